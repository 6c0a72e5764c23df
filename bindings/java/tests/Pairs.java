import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.DoubleBuffer;
import java.nio.file.DirectoryStream;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import vesper.Builder;
import vesper.Engine;
import vesper.Precision;

/**
 * Pairs on a spring, seven cases: the bits of positions and velocities after ten seconds, in both precisions, to be compared with the
 * lines that Rust and C print. From scenes and in lent buffers they are the same bits.
 */
final class Pairs {
    private static final double[] NONE = {0, 0, 0, 0, 0, 0};
    private static final double[] UP = {0, 0, 15, 0, 0, 15};

    private final String name;
    private final double[] masses;
    private final double[] velocities;
    /** 0 for no spring. */
    private final double stiffness;
    private final boolean gravity;

    private Pairs(String name, double[] masses, double[] velocities, double stiffness, boolean gravity) {
        this.name = name;
        this.masses = masses;
        this.velocities = velocities;
        this.stiffness = stiffness;
        this.gravity = gravity;
    }

    private static final Pairs[] ALL = {
        new Pairs("a", new double[] {1, 1}, NONE, 100, false),
        new Pairs("b", new double[] {1, 1}, new double[] {0, -10, 0, 0, 10, 0}, 100, false),
        new Pairs("c", new double[] {1, 1}, new double[] {0, 0, 0, 0, 10, 0}, 100, false),
        new Pairs("d", new double[] {10, 1}, new double[] {0, 3, 0, 0, 0, 0}, 100, false),
        new Pairs("e", new double[] {1, 1}, new double[] {10, 0, 30, -20, 0, 20}, 0, true),
        new Pairs("f", new double[] {1, 1}, UP, 100, true),
        new Pairs("g", new double[] {1, 1}, UP, 30, true),
    };

    /** The laws around two bodies whose places and velocities are given otherwise. */
    private Builder laws(Builder builder) {
        builder.column("bodies", "mass", masses).law("motion");
        if (stiffness > 0) {
            builder.domain("springs", 1)
                    .link("springs", "ends", "bodies", 0, 1)
                    .column("springs", "stiffness", stiffness)
                    .column("springs", "damping", 10)
                    .column("springs", "rest_length", 10)
                    .law("spring")
                    .law("damper");
        }
        if (gravity) {
            builder.constant("gravity", 0, 0, -9.81).law("uniform_gravity");
        }
        return builder.integrator("runge_kutta_4").step(1e-3);
    }

    private Engine copied(Precision precision) {
        Builder builder = Engine.builder(precision).domain("bodies", 2);
        builder.column("bodies", "position", -10, 5, 0, 10, 5, 0).column("bodies", "velocity", velocities);
        return laws(builder).build();
    }

    private static double[] tenSeconds(Engine engine) {
        try (engine) {
            engine.advance(10);
            double[] both = Arrays.copyOf(engine.get("bodies", "position"), 12);
            System.arraycopy(engine.get("bodies", "velocity"), 0, both, 6, 6);
            return both;
        }
    }

    /** The numbers that a program finds in its own buffers. */
    private double[] inOwnBuffers() {
        ByteBuffer position = ByteBuffer.allocateDirect(48).order(ByteOrder.nativeOrder());
        ByteBuffer velocity = ByteBuffer.allocateDirect(48).order(ByteOrder.nativeOrder());
        DoubleBuffer places = position.asDoubleBuffer().put(new double[] {-10, 5, 0, 10, 5, 0});
        DoubleBuffer speeds = velocity.asDoubleBuffer().put(velocities);
        Builder builder = Engine.builder().domain("bodies", 2);
        builder.lend("bodies", "position", position).lend("bodies", "velocity", velocity);
        try (Engine engine = laws(builder).build()) {
            engine.advance(10);
            double[] both = new double[12];
            places.rewind().get(both, 0, 6);
            speeds.rewind().get(both, 6, 6);
            return both;
        }
    }

    private static String scene(String name) throws IOException {
        try (DirectoryStream<Path> found = Files.newDirectoryStream(Path.of("examples/scenes"), "c7" + name + "-*.toml")) {
            return Files.readString(found.iterator().next());
        }
    }

    private static String bits(double[] numbers, Precision precision) {
        StringBuilder bits = new StringBuilder();
        for (double number : numbers) {
            bits.append(precision == Precision.F64
                    ? String.format(" %016x", Double.doubleToRawLongBits(number))
                    : String.format(" %08x", Float.floatToRawIntBits((float) number)));
        }
        return bits.toString();
    }

    public static void main(String[] arguments) throws IOException {
        for (Pairs pair : ALL) {
            String expected = "";
            for (Precision precision : new Precision[] {Precision.F64, Precision.F32}) {
                String bits = bits(tenSeconds(pair.copied(precision)), precision);
                System.out.println(pair.name + " " + precision.name().toLowerCase() + bits);
                expected = precision == Precision.F64 ? bits : expected;
            }
            Check.same(bits(pair.inOwnBuffers(), Precision.F64), expected);
            Check.same(bits(tenSeconds(Engine.fromScene(scene(pair.name))), Precision.F64), expected);
        }
    }
}
