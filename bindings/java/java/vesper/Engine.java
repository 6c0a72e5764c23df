package vesper;

import java.lang.ref.Cleaner;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.List;
import java.util.Map;

/**
 * An engine that runs.
 *
 * <p>In: steps, names of columns, arrays. Out: numbers, texts, exceptions with the whole text of a fault. Never: an array that is
 * changed where its length is not that of the column.
 *
 * <p>An engine belongs to the thread that built it, until that thread calls {@link #letGo} or ends; then to the next thread that
 * calls. A call of any other thread, or on a closed engine, is a {@link VesperException}. Different engines run on different
 * threads at once.
 */
public final class Engine implements AutoCloseable {
    private final Held held;
    private final Cleaner.Cleanable cleanable;
    private final Precision precision;

    Engine(long handle, Precision precision, List<Held.Lent> lent) {
        this.held = new Held(handle, lent);
        this.cleanable = held.whenGone(this);
        this.precision = precision;
    }

    /** Begins an engine that computes in {@code double}. */
    public static Builder builder() {
        return new Builder(Precision.F64);
    }

    /** Begins an engine that computes in this precision. */
    public static Builder builder(Precision precision) {
        return new Builder(precision);
    }

    /** The engine of a whole scene, in {@code double}. */
    public static Engine fromScene(String scene) {
        return builder().scene(scene).build();
    }

    /** What it computes in. */
    public Precision precision() {
        return precision;
    }

    /** Takes {@code count} steps of {@code step} s. */
    public void step(long count, double step) {
        nativeStep(held.handle(), count, step);
    }

    /** Goes on by {@code frame} s, by as many steps of the set length as fit; the rest is carried on. Without one, by one step. */
    public void advance(double frame) {
        nativeAdvance(held.handle(), frame);
    }

    /** The time, in s. */
    public double time() {
        return nativeTime(held.handle());
    }

    /** Steps taken. */
    public long steps() {
        return nativeSteps(held.handle());
    }

    /** All numbers of a column, interleaved: given ones, and those that are observed. */
    public double[] get(String domain, String property) {
        long handle = held.handle();
        double[] values = new double[size(handle, domain, property)];
        nativeGet(handle, domain, property, values);
        return values;
    }

    /** The same, into an array of just that length. */
    public double[] get(String domain, String property, double[] into) {
        nativeGet(held.handle(), domain, property, into);
        return into;
    }

    /**
     * The same, into a direct buffer in the order of the machine, in the precision of the engine. The whole buffer is meant, from 0
     * to its capacity, and holds just as many numbers; its position and limit do not count, and stay.
     */
    public ByteBuffer get(String domain, String property, ByteBuffer into) {
        long handle = held.handle();
        if (into != null && (!into.isDirect() || into.isReadOnly() || into.order() != ByteOrder.nativeOrder())) {
            String text = "the buffer for " + domain + "." + property
                    + " does not fit: give a direct one in native order that can be written";
            throw new VesperException(VesperException.Kind.ARGUMENT, text);
        }
        nativeGetDirect(handle, domain, property, into);
        return into;
    }

    /** The rows that a link leads to, interleaved. */
    public int[] links(String domain, String property) {
        long handle = held.handle();
        int[] ends = new int[size(handle, domain, property)];
        nativeLinks(handle, domain, property, ends);
        return ends;
    }

    /** The buffer that was lent for this column, from its beginning, with marks of its own: no copy. */
    public ByteBuffer lent(String domain, String property) {
        held.handle();
        ByteBuffer buffer = held.lent(domain, property);
        if (buffer == null) {
            String text = domain + "." + property + " is not lent: lend a buffer to the builder, or get a copy";
            throw new VesperException(VesperException.Kind.FAULT, text);
        }
        return buffer.duplicate().clear().order(ByteOrder.nativeOrder());
    }

    /** Where the first number of a column is in memory: of a lent one, the address of its buffer. */
    public long address(String domain, String property) {
        return nativeAddress(held.handle(), domain, property);
    }

    /** Changes all numbers of a column, also of a constant (domain "scene"). They are finite, or none is changed. */
    public void set(String domain, String property, double... values) {
        nativeSet(held.handle(), domain, property, values);
    }

    /**
     * Adds rows behind the last: every property that all rows have needs values for the new ones, as {@code double[]} or
     * {@code float[]}, or as {@code int[]} where it is a link.
     */
    public void addRows(String domain, long rows, Map<String, ?> values) {
        long handle = held.handle();
        int size = values == null ? 0 : values.size();
        String[] properties = new String[size];
        double[][] numbers = new double[size][];
        int[][] links = new int[size][];
        int place = 0;
        for (Map.Entry<String, ?> entry : values == null ? Map.<String, Object>of().entrySet() : values.entrySet()) {
            Object given = entry.getValue();
            properties[place] = entry.getKey();
            if (given instanceof int[]) {
                links[place] = (int[]) given;
            } else if (given instanceof double[]) {
                numbers[place] = (double[]) given;
            } else if (given instanceof float[]) {
                numbers[place] = widened((float[]) given);
            } else {
                String text = domain + "." + entry.getKey() + " has no values: give double[], float[], or int[] of a link";
                throw new VesperException(VesperException.Kind.ARGUMENT, text);
            }
            place++;
        }
        nativeAddRows(handle, domain, rows, properties, numbers, links);
    }

    /** Removes rows, and with them rows that link to them. Later rows move up, and links follow. */
    public void removeRows(String domain, int... rows) {
        nativeRemoveRows(held.handle(), domain, rows);
    }

    /** Switches a law on or off, by its label, or else its name. */
    public void enable(String law, boolean enabled) {
        nativeEnable(held.handle(), law, enabled);
    }

    /** Looks at a property that laws compute ("force") from now on: it is computed at once, and after each step or frame. */
    public void observe(String domain, String property) {
        nativeObserve(held.handle(), domain, property);
    }

    /** Which laws run, which do not, and why; what nobody uses. */
    public String report() {
        return nativeText(held.handle(), 0);
    }

    /** The order of the laws, merged passes, and what moves where. */
    public String explain() {
        return nativeText(held.handle(), 1);
    }

    /** The same graph in the language of Graphviz. */
    public String dot() {
        return nativeText(held.handle(), 2);
    }

    /** The complete state, for {@link #restore}. */
    public String checkpoint() {
        return nativeText(held.handle(), 3);
    }

    /** Goes on from a checkpoint of an engine that was put together alike; rows may differ. Lent buffers are written. */
    public void restore(String checkpoint) {
        nativeRestore(held.handle(), checkpoint);
    }

    /** Lets the next thread that calls have the engine. */
    public void letGo() {
        held.letGo();
    }

    /** Whether it was closed. */
    public boolean isClosed() {
        return held.isClosed();
    }

    /** Frees the engine; again is nothing. Lent buffers are the program's alone from then on. */
    @Override
    public void close() {
        if (!held.isClosed()) {
            held.handle();
            cleanable.clean();
        }
    }

    /** The length of an array for all numbers of a column. */
    private int size(long handle, String domain, String property) {
        long count = nativeCount(handle, domain, property);
        if (count > Integer.MAX_VALUE - 8) {
            String text = domain + "." + property + " has " + count + " numbers, more than an array holds: lend a buffer";
            throw new VesperException(VesperException.Kind.FAULT, text);
        }
        return (int) count;
    }

    static double[] widened(float[] values) {
        double[] wide = new double[values.length];
        for (int place = 0; place < wide.length; place++) {
            wide[place] = values[place];
        }
        return wide;
    }

    // Not static: while one runs, the engine is in use, and not collected.

    private native void nativeStep(long handle, long count, double step);

    private native void nativeAdvance(long handle, double frame);

    private native double nativeTime(long handle);

    private native long nativeSteps(long handle);

    private native long nativeCount(long handle, String domain, String property);

    private native long nativeAddress(long handle, String domain, String property);

    private native void nativeGet(long handle, String domain, String property, double[] values);

    private native void nativeGetDirect(long handle, String domain, String property, ByteBuffer buffer);

    private native void nativeLinks(long handle, String domain, String property, int[] ends);

    private native void nativeSet(long handle, String domain, String property, double[] values);

    private native void nativeAddRows(
            long handle, String domain, long rows, String[] properties, double[][] values, int[][] links);

    private native void nativeRemoveRows(long handle, String domain, int[] rows);

    private native void nativeEnable(long handle, String law, boolean enabled);

    private native void nativeObserve(long handle, String domain, String property);

    private native String nativeText(long handle, int which);

    private native void nativeRestore(long handle, String checkpoint);
}
