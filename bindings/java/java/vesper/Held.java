package vesper;

import java.lang.invoke.MethodHandles;
import java.lang.invoke.VarHandle;
import java.lang.ref.Cleaner;
import java.nio.ByteBuffer;
import java.util.Arrays;
import java.util.List;
import java.util.Map;

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

    /** Buffers by domain and property. Holding them is what keeps their memory. */
    private final Map<List<String>, ByteBuffer> lent;
    /** 0 when closed; changed by the owner only, or when nobody is left to be one. */
    private volatile long handle;
    /** Null while nobody has it: the next thread that calls does then. */
    private volatile Thread owner = Thread.currentThread();

    Held(long handle, Map<List<String>, ByteBuffer> lent) {
        this.handle = handle;
        this.lent = lent;
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

    ByteBuffer lent(String domain, String property) {
        return lent.get(key(domain, property));
    }

    /** Under what a buffer is found: without the unit that may stand behind the property. */
    static List<String> key(String domain, String property) {
        String name = property == null ? null : property.split("\\[", 2)[0].trim();
        return Arrays.asList(domain, name);
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
