package vesper;

/**
 * Something that could not be done. The message is the whole text: a line or a few for each fault, with who, what, where, and what
 * to do. A call that fails changes nothing, but for steps, which stand where they broke.
 */
public final class VesperException extends RuntimeException {
    private static final long serialVersionUID = 1;

    /** What kind of thing went wrong. In the order that the native half knows. */
    public enum Kind {
        /** An argument makes no sense by itself: null, memory at an odd address, a negative count. */
        ARGUMENT,
        /** What was described or asked for does not fit: names, units, lengths, laws. */
        FAULT,
        /**
         * A step could not be taken, or numbers became infinite or NaN; or a law of a module failed in a step, which was taken without
         * it. {@link Engine#steps} says how far it came.
         */
        RUN,
        /** The engine is closed, or the builder has built already. */
        CLOSED,
        /** The engine belongs to another thread. */
        THREAD,
        /** A mistake inside the library, or of a law; the engine can only be closed. */
        PANIC
    }

    private final Kind kind;

    VesperException(Kind kind, String message) {
        super(message);
        this.kind = kind;
    }

    /** For the native half: the kind by its place. */
    VesperException(int kind, String message) {
        this(Kind.values()[kind], message);
    }

    /** What kind of thing went wrong. */
    public Kind kind() {
        return kind;
    }
}
