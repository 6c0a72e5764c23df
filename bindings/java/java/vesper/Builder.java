package vesper;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.function.Function;

/**
 * What an engine is put together from.
 *
 * <p>In: domains (sets of rows) first, then columns, laws and settings. Out: an {@link Engine}, once. Never: an engine that lacks what
 * was refused. Faults wait for {@link #build}, which tells all of them at once, in the order of the calls.
 *
 * <p>A property is named as laws name it, {@code "position"}, with a unit behind it where it is not in SI: {@code "velocity [km/s]"}.
 * Arrays are interleaved: all numbers of the first row, then those of the second. They are copied when they are given.
 */
public final class Builder {
    /** One call, repeated on the native half when the engine is built. */
    private interface Part {
        void add(long assembly);
    }

    private final Precision precision;
    private final List<Part> parts = new ArrayList<>();
    /** All buffers that were ever lent here, whatever their names: the engine has their addresses. */
    private final List<Held.Lent> lent = new ArrayList<>();
    private boolean built;

    Builder(Precision precision) {
        Library.load();
        this.precision = precision == null ? Precision.F64 : precision;
    }

    /** Adds a domain of so many rows. The domain "scene", of one row, is there: it holds the constants. */
    public Builder domain(String domain, long rows) {
        return with(assembly -> nativeDomain(assembly, domain, rows));
    }

    /** Adds a column, copied: rows times 1 number, 3 of a vector, 4 of a quaternion. A name that no law knows is kept, too. */
    public Builder column(String domain, String property, double... values) {
        double[] own = values == null ? null : values.clone();
        return with(assembly -> nativeColumn(assembly, domain, property, own));
    }

    /** The same from {@code float}. */
    public Builder column(String domain, String property, float[] values) {
        double[] own = values == null ? null : Engine.widened(values);
        return with(assembly -> nativeColumn(assembly, domain, property, own));
    }

    /**
     * Adds a column in a direct buffer in the order of the machine, {@code ByteBuffer.allocateDirect(bytes)
     * .order(ByteOrder.nativeOrder())}. No number is ever copied: steps write there, and read what the program wrote. The whole
     * buffer is meant, wherever its position is; a part of it is {@code buffer.slice(...)}. Numbers are of the precision of the
     * engine, in the property's own unit. The engine keeps the buffer; touch it only while no call runs on the engine.
     * Domains with lent columns keep their number of rows.
     */
    public Builder lend(String domain, String property, ByteBuffer buffer) {
        String why = unfit(buffer);
        if (why != null) {
            return fault(domain + "." + property + " cannot be lent: " + why);
        }
        synchronized (this) {
            with(assembly -> nativeLend(assembly, precision == Precision.F32, domain, property, buffer));
            lent.add(new Held.Lent(domain, property, buffer));
        }
        return this;
    }

    /** Why a buffer cannot be lent; null if it can. */
    private static String unfit(ByteBuffer buffer) {
        if (buffer == null) {
            return "the buffer is null: give a direct one";
        }
        if (!buffer.isDirect()) {
            return "the buffer lies in the heap, where it is moved: make it by ByteBuffer.allocateDirect";
        }
        if (buffer.isReadOnly()) {
            return "the buffer is read-only, and steps write there: give one that can be written";
        }
        if (buffer.order() != ByteOrder.nativeOrder()) {
            return "the buffer is " + buffer.order() + ": make it so by order(ByteOrder.nativeOrder())";
        }
        return null;
    }

    /** Adds a link: for every row as many rows of {@code target} as the property says ("ends": 2, "corners": 3). */
    public Builder link(String domain, String property, String target, int... rows) {
        int[] own = rows == null ? null : rows.clone();
        return with(assembly -> nativeLink(assembly, domain, property, target, own));
    }

    /** Sets a constant of the scene, {@code constant("gravity", 0, 0, -9.81)}. */
    public Builder constant(String name, double... values) {
        return column("scene", name, values);
    }

    /**
     * Looks for modules of laws in this folder, before those of VESPER_LAW_PATH; it comes before laws that need it. The code of a
     * module runs in this process: whoever put it there is trusted.
     */
    public Builder lawsFrom(Path folder) {
        String where = folder == null ? null : folder.toString();
        return with(assembly -> nativeLawsFrom(assembly, where));
    }

    /** Adds a stock law with its own parameters; {@code vesper laws} lists them. */
    public Builder law(String law) {
        return law(law, "");
    }

    /** Adds a stock law with parameters by their names, {@code Map.of("g", 1, "domain", "stars")}. */
    public Builder law(String law, Map<String, ?> parameters) {
        return text("law " + law, parameters, text -> law(law, text));
    }

    /**
     * Adds a law with parameters as a scene says them, {@code "softening = 1e3, label = 'pull'"}; one of a module of laws by
     * {@code "module = 'wings'"}, which is found in a folder of {@link #lawsFrom}, or of the environment variable VESPER_LAW_PATH.
     */
    public Builder law(String law, String parameters) {
        return with(assembly -> nativeLaw(assembly, law, parameters));
    }

    /** Chooses the integrator, {@code "runge_kutta_4"}. Leapfrog where none is chosen. */
    public Builder integrator(String name) {
        return integrator(name, Map.of());
    }

    /** Chooses the integrator with its parameters, {@code integrator("dormand_prince_8", Map.of("rtol", 1e-10))}. */
    public Builder integrator(String name, Map<String, ?> parameters) {
        String start = "integrator = { name = " + SceneText.quoted(String.valueOf(name));
        return text("integrator", parameters, text -> settings(start + (text.isEmpty() ? "" : ", " + text) + " }"));
    }

    /** Sets the step that {@link Engine#advance} takes, in s. */
    public Builder step(double step) {
        return settings("step = " + SceneText.number(step));
    }

    /** Sets the threads of the engine; 1 for none but the caller's. */
    public Builder threads(int threads) {
        return settings("threads = " + threads);
    }

    /** Looks at a property that laws compute, {@code observe("bodies", "force")}. */
    public Builder observe(String domain, String property) {
        return settings("observe = [" + SceneText.quoted(domain + "." + property) + "]");
    }

    /** Chooses what section {@code [engine]} of a scene chooses, {@code "strict = true, step = 1e-3"}. */
    public Builder settings(String settings) {
        return with(assembly -> nativeSettings(assembly, settings));
    }

    /** Adds a whole scene; files that it names lie in the current folder. */
    public Builder scene(String scene) {
        return scene(scene, null);
    }

    /** Adds a whole scene; files that it names lie in {@code folder}. */
    public Builder scene(String scene, Path folder) {
        String where = folder == null ? null : folder.toString();
        return with(assembly -> nativeScene(assembly, scene, where));
    }

    /** Checks everything, orders the laws, and makes the engine, which belongs to this thread. Throws all that went wrong. */
    public Engine build() {
        synchronized (this) {
            // Of two threads that build at once one does, and nothing is added any more.
            usable();
            built = true;
        }
        long assembly = nativeBegin(precision == Precision.F32);
        try {
            for (Part part : parts) {
                part.add(assembly);
            }
        } catch (Throwable mishap) {
            nativeForget(assembly);
            throw mishap;
        }
        return new Engine(nativeBuild(assembly), precision, lent);
    }

    private synchronized Builder with(Part part) {
        usable();
        parts.add(part);
        return this;
    }

    private Builder fault(String text) {
        return with(assembly -> nativeNote(assembly, text));
    }

    /** Goes on with parameters as text, or keeps the fault of one that has none. */
    private Builder text(String what, Map<String, ?> parameters, Function<String, Builder> then) {
        String text;
        try {
            text = SceneText.pairs(what, parameters);
        } catch (VesperException refused) {
            return fault(refused.getMessage());
        }
        return then.apply(text);
    }

    private void usable() {
        if (built) {
            String text = "this builder has built its engine: begin another one";
            throw new VesperException(VesperException.Kind.CLOSED, text);
        }
    }

    private native long nativeBegin(boolean single);

    private native void nativeNote(long assembly, String fault);

    private native void nativeDomain(long assembly, String domain, long rows);

    private native void nativeColumn(long assembly, String domain, String property, double[] values);

    private native void nativeLend(long assembly, boolean single, String domain, String property, ByteBuffer buffer);

    private native void nativeLink(long assembly, String domain, String property, String target, int[] rows);

    private native void nativeLawsFrom(long assembly, String folder);

    private native void nativeLaw(long assembly, String law, String parameters);

    private native void nativeSettings(long assembly, String settings);

    private native void nativeScene(long assembly, String scene, String folder);

    private native long nativeBuild(long assembly);

    private native void nativeForget(long assembly);
}
