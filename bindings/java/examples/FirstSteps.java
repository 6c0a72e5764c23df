import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.DoubleBuffer;
import java.util.Map;
import vesper.Engine;

/** Earth and Moon: the ten lines of README.md. */
final class FirstSteps {
    private FirstSteps() {}

    public static void main(String[] arguments) {
        ByteBuffer memory = ByteBuffer.allocateDirect(6 * Double.BYTES).order(ByteOrder.nativeOrder());
        DoubleBuffer position = memory.asDoubleBuffer().put(new double[] {0, 0, 0, 384.4e6, 0, 0});
        try (Engine engine = Engine.builder()
                .domain("bodies", 2)
                .lend("bodies", "position", memory) // Used in place.
                .column("bodies", "velocity [km/s]", 0, -0.0125, 0, 0, 1.0095, 0) // Copied, converted.
                .column("bodies", "mass", 5.972e24, 7.342e22)
                .law("gravity", Map.of("softening", 1e3))
                .law("motion")
                .build()) {
            engine.step(1180, 1000); // Half a month.
            System.out.printf("the Moon went from x = 384400 km to %.0f km%n", position.get(3) / 1e3);
            assert position.get(3) < -370e6;
        }
    }
}
