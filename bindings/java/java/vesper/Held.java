package vesper;

import java.lang.invoke.MethodHandles;
import java.lang.invoke.VarHandle;
import java.lang.ref.Cleaner;
import java.nio.ByteBuffer;
import java.util.ArrayList;
import java.util.List;

/**
 * A native engine: its handle, the thread that has it, and the buffers lent to it.
 *
 * <p>In: the handle, once. Out: the handle, to the one thread that has the engine, while it is not closed. Never: a handle that was
 * freed; two threads inside one engine; a lent buffer that the collector takes before the engine.
 *
 * <p>An engine belongs to the thread that made it, until that thread lets go of it or ends: so a call looks at two fields, and
 * takes no lock.
 */
final class Held implements Runnable {
    private static final Cleaner CLEANER = Cleaner.create();
    private static final VarHandle OWNER;

    static {
        try {
            OWNER = MethodHandles.lookup().findVarHandle(Held.class, "owner", Thread.class);
        } catch (ReflectiveOperationException impossible) {
            throw new ExceptionInInitializerError(impossible);
        }
    }

    /** A buffer and the column that it was lent for, as it was called. */
    record Lent(String domain, String property, ByteBuffer buffer) {}

    /** All buffers whose addresses the engine may have. Holding them is what keeps their memory, until the engine is freed. */
    private final List<Lent> lent;
    /** 0 when closed; changed by the owner only, or when nobody is left to be one. */
    private volatile long handle;
    /** Null while nobody has it: the next thread that calls does then. */
    private volatile Thread owner = Thread.currentThread();

    Held(long handle, List<Lent> lent) {
        this.handle = handle;
        this.lent = new ArrayList<>(lent);
    }

    /** Sees to it that the engine is freed when {@code of} is gone, if nobody closes it before. */
    Cleaner.Cleanable whenGone(Object of) {
        return CLEANER.register(of, this);
    }

    /** The handle, for a call on this thread. */
    long handle() {
        if (owner == Thread.currentThread()) {
            long mine = handle;
            if (mine != 0) {
                return mine;
            }
        }
        return taken();
    }

    /** The handle for a thread that has no open engine here, if it can have one. */
    private long taken() {
        Thread me = Thread.currentThread();
        Thread other = owner;
        if (handle == 0) {
            throw new VesperException(VesperException.Kind.CLOSED, "this engine is closed: build another one");
        }
        if ((other == null || !other.isAlive()) && OWNER.compareAndSet(this, other, me)) {
            return handle();
        }
        String has = other == null ? "another thread" : "thread " + other.getName();
        String text = "this engine belongs to " + has + ": call letGo() there first";
        throw new VesperException(VesperException.Kind.THREAD, text);
    }

    boolean isClosed() {
        return handle == 0;
    }

    void letGo() {
        handle();
        owner = null;
    }

    /** The buffer that was lent for a column; null if none was. */
    ByteBuffer lent(String domain, String property) {
        for (Lent each : lent) {
            if (each.domain.equals(domain) && name(each.property).equals(name(property))) {
                return each.buffer;
            }
        }
        return null;
    }

    /** What the native half takes for a property's name: without the unit behind it, and without what Rust takes for blanks. */
    private static String name(String property) {
        if (property == null) {
            return "";
        }
        int end = property.indexOf('[') < 0 ? property.length() : property.indexOf('[');
        int begin = 0;
        while (begin < end && isBlank(property.charAt(begin))) {
            begin++;
        }
        while (end > begin && isBlank(property.charAt(end - 1))) {
            end--;
        }
        return property.substring(begin, end);
    }

    /** Neither {@code trim} nor {@code strip} has these: they take control characters for blanks, with which there are other names. */
    private static boolean isBlank(char letter) {
        return Character.isSpaceChar(letter) || letter >= '\t' && letter <= '\r' || letter == '\u0085';
    }

    /** Frees the engine, once: called by its owner, or by the cleaner when no thread can call any more. */
    @Override
    public void run() {
        long last = handle;
        handle = 0;
        if (last != 0) {
            nativeFree(last);
        }
        lent.clear();
    }

    private static native void nativeFree(long handle);
}
