import java.lang.ref.WeakReference;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.DoubleBuffer;
import java.nio.FloatBuffer;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import vesper.Builder;
import vesper.Engine;
import vesper.Precision;
import vesper.VesperException;
import vesper.VesperException.Kind;

/** Direct buffers are used in place: the same address, seen and changed from both sides, kept while the engine is there. */
final class Shared {
    private Shared() {}

    private static ByteBuffer direct(int bytes) {
        return ByteBuffer.allocateDirect(bytes).order(ByteOrder.nativeOrder());
    }

    /** What Java itself says; for that it is run with {@code --add-exports java.base/sun.nio.ch=ALL-UNNAMED}. */
    private static long address(ByteBuffer buffer) {
        try {
            return (long) Class.forName("sun.nio.ch.DirectBuffer").getMethod("address").invoke(buffer);
        } catch (ReflectiveOperationException closed) {
            throw new AssertionError(closed);
        }
    }

    private static double[] ones(int count) {
        double[] ones = new double[count];
        Arrays.fill(ones, 1);
        return ones;
    }

    private static Builder falling(Precision precision, int rows) {
        Builder builder = Engine.builder(precision).domain("bodies", rows);
        return builder.constant("gravity", 0, 0, -10).law("uniform_gravity").law("motion").step(0.5);
    }

    private static void oneMemory() {
        ByteBuffer position = direct(6 * Double.BYTES);
        ByteBuffer velocity = direct(6 * Double.BYTES);
        double[] mass = {1, 1};
        DoubleBuffer places = position.asDoubleBuffer();
        Builder builder = falling(Precision.F64, 2).column("bodies", "mass", mass);
        builder.lend("bodies", "position [m]", position).lend("bodies", "velocity", velocity);
        mass[0] = -1; // Copied already.
        try (Engine engine = builder.build()) {
            Check.same(engine.address("bodies", "position"), address(position));
            Check.same(engine.address("bodies", "velocity"), address(velocity));
            Check.same(engine.get("bodies", "mass")[0], 1.0);
            engine.advance(1);
            Check.that(places.get(2) < 0 && places.get(2) == places.get(5), "no fall: " + places.get(2));
            Check.same(engine.get("bodies", "position")[2], places.get(2));
            // From the other side: what is written here is where the next step begins.
            places.put(2, 1000);
            velocity.asDoubleBuffer().put(2, 0);
            engine.step(1, 0.5);
            Check.that(places.get(2) > 990 && places.get(2) < 1000, "not seen: " + places.get(2));
            // A view is the same memory, with marks of its own.
            position.position(8);
            ByteBuffer view = engine.lent("bodies", "position");
            Check.same(address(view), address(position));
            Check.same(view.position(), 0);
            Check.same(view.asDoubleBuffer().get(2), places.get(2));
            Check.refused(Kind.FAULT, () -> engine.lent("bodies", "mass"));
            // Copies, from the state and back.
            ByteBuffer other = direct(6 * Double.BYTES);
            Check.same(engine.get("bodies", "position", other).asDoubleBuffer().get(2), places.get(2));
            // The whole buffer, wherever its marks are; they stay.
            other.putDouble(0, 7).position(8).limit(16);
            engine.get("bodies", "position", other);
            Check.same(other.position() + other.limit(), 24);
            Check.same(other.clear().getDouble(0), places.get(0));
            Check.refused(Kind.ARGUMENT, () -> engine.get("bodies", "velocity", position));
            Check.refused(Kind.FAULT, () -> engine.get("bodies", "position", direct(40)));
            Check.refused(Kind.ARGUMENT, () -> engine.get("bodies", "position", direct(41)));
            Check.refused(Kind.ARGUMENT, () -> engine.get("bodies", "position", ByteBuffer.allocate(48)));
            Check.refused(Kind.ARGUMENT, () -> engine.get("bodies", "position", (ByteBuffer) null));
            engine.set("bodies", "position", 1, 2, 3, 4, 5, 6);
            Check.same(places.get(5), 6.0);
        }
        Check.same(places.get(5), 6.0); // The program's alone again.
    }

    private static void inSingle() {
        ByteBuffer all = direct(4 + 6 * Float.BYTES);
        ByteBuffer position = all.slice(4, 6 * Float.BYTES).order(ByteOrder.nativeOrder());
        FloatBuffer places = position.asFloatBuffer();
        Builder builder = falling(Precision.F32, 2).column("bodies", "velocity", new float[6]).lend("bodies", "position", position);
        try (Engine engine = builder.column("bodies", "mass", 1, 1).build()) {
            Check.same(engine.address("bodies", "position"), address(all) + 4);
            engine.step(1, 0.5);
            Check.that(places.get(2) < 0, "no fall");
        }
    }

    /** Buffers that the program has dropped stay, and an engine that it has dropped gives them back. */
    private static void kept() throws InterruptedException {
        Engine engine = falling(Precision.F64, 100_000)
                .lend("bodies", "position", direct(2_400_000))
                .column("bodies", "velocity", new double[300_000])
                .column("bodies", "mass", ones(100_000))
                .build();
        for (int round = 0; round < 5; round++) {
            System.gc();
            direct(2_400_000).putDouble(16, 1e9); // Where a buffer that was freed might lie.
            engine.step(1, 0.5);
        }
        DoubleBuffer places = engine.lent("bodies", "position").asDoubleBuffer();
        Check.that(places.get(2) < 0 && places.get(2) == places.get(299_999), "the memory was somebody else's");
        ByteBuffer again = engine.lent("bodies", "position");
        Builder builder = falling(Precision.F64, 100_000).lend("bodies", "position", again);
        builder.column("bodies", "velocity", new double[300_000]).column("bodies", "mass", ones(100_000));
        String text = Check.refused(Kind.FAULT, builder::build);
        Check.same(text, "bodies.position cannot be lent: another engine has some of this memory: close or free that one first");
        engine = null;
        for (int round = 0; round < 100; round++) {
            System.gc();
            Thread.sleep(20);
            Builder once = falling(Precision.F64, 100_000).lend("bodies", "position", again);
            once.column("bodies", "velocity", new double[300_000]).column("bodies", "mass", ones(100_000));
            try (Engine next = once.build()) {
                next.step(1, 0.5);
                return;
            } catch (VesperException notYet) {
                Check.same(notYet.getMessage(), text);
            }
        }
        throw new AssertionError("an engine that nobody has is not freed");
    }

    /** Every buffer that was lent stays, also of a name that differs in a letter which Java's {@code trim} takes for a blank. */
    private static void keptWhateverItsName() throws InterruptedException {
        String[] names = {"age", "age\u0001", "age\u001f"};
        List<WeakReference<ByteBuffer>> buffers = new ArrayList<>();
        Builder builder = falling(Precision.F64, 2).column("bodies", "position", new double[6]);
        builder.column("bodies", "velocity", new double[6]).column("bodies", "mass", 1, 1);
        for (int number = 0; number < names.length; number++) {
            ByteBuffer buffer = direct(2 * Double.BYTES).putDouble(0, number);
            buffers.add(new WeakReference<>(buffer));
            builder.lend("bodies", names[number], buffer);
        }
        try (Engine engine = builder.build()) {
            builder = null;
            for (int round = 0; round < 10; round++) {
                System.gc();
                Thread.sleep(5);
            }
            for (int number = 0; number < names.length; number++) {
                Check.that(buffers.get(number).get() != null, "the buffer of name " + number + " was collected");
                Check.same(engine.lent("bodies", names[number]).getDouble(0), (double) number);
                Check.same(engine.lent("bodies", " \u00a0" + names[number] + " [1]").getDouble(0), (double) number);
                Check.same(engine.address("bodies", names[number]), address(buffers.get(number).get()));
            }
        }
    }

    public static void main(String[] arguments) throws InterruptedException {
        oneMemory();
        inSingle();
        kept();
        keptWhateverItsName();
        Check.done("shared buffers");
    }
}
