import java.util.Arrays;
import java.util.Map;
import vesper.Builder;
import vesper.Engine;
import vesper.VesperException.Kind;

/** What changes between steps: rows, numbers, laws, observers; and a state that is kept. */
final class Rows {
    private Rows() {}

    private static Builder two() {
        return Engine.builder()
                .domain("bodies", 2)
                .column("bodies", "position", -10, 5, 0, 10, 5, 0)
                .column("bodies", "velocity [km/s]", new float[6])
                .column("bodies", "mass", 1, 1)
                .column("bodies", "colour", 0.25, 0.75)
                .domain("springs", 1)
                .link("springs", "ends", "bodies", 0, 1)
                .column("springs", "stiffness", 100)
                .column("springs", "rest_length", 10)
                .law("spring")
                .law("motion")
                .step(1e-3);
    }

    public static void main(String[] arguments) {
        try (Engine engine = two().build()) {
            Check.refused(Kind.FAULT, () -> engine.get("bodies", "force"));
            engine.observe("bodies", "force");
            Check.same(engine.get("bodies", "force")[0], 1000.0);
            engine.advance(0.1);
            Check.same(engine.steps(), 100L);
            Check.that(Math.abs(engine.time() - 0.1) < 1e-12, "the time is " + engine.time());
            String state = engine.checkpoint();
            double there = engine.get("bodies", "position")[0];

            String text = Check.refused(Kind.FAULT, () -> engine.addRows("bodies", 1, Map.of("mass", new double[] {1})));
            Check.that(text.contains("position") && text.contains("colour"), text);
            Check.refused(Kind.ARGUMENT, () -> engine.addRows("bodies", 1, Map.of("mass", 1)));
            Check.refused(Kind.ARGUMENT, () -> engine.addRows("bodies", -1, Map.of()));
            Check.refused(Kind.ARGUMENT, () -> engine.addRows("bodies", 1, Map.of("mass", new int[] {1})));
            engine.addRows("bodies", 1, Map.of("position", new double[] {0, 20, 0}, "velocity [km/s]", new float[] {0, 1, 0},
                    "mass", new double[] {2}, "colour", new double[] {0.5}));
            engine.addRows("springs", 1, Map.of("ends", new int[] {2, 0}, "stiffness", new double[] {1}, "rest_length",
                    new double[] {1}));
            Check.same(Arrays.toString(engine.links("springs", "ends")), "[0, 1, 2, 0]");
            Check.same(engine.get("bodies", "velocity")[7], 1000.0);
            engine.removeRows("bodies", 1);
            Check.same(Arrays.toString(engine.links("springs", "ends")), "[1, 0]");
            Check.same(Arrays.toString(engine.get("bodies", "colour")), "[0.25, 0.5]");
            Check.refused(Kind.FAULT, () -> engine.removeRows("bodies", 7));
            Check.refused(Kind.ARGUMENT, () -> engine.removeRows("bodies", -1));
            engine.advance(0.1);

            engine.enable("spring", false);
            Check.that(engine.get("bodies", "force")[0] != 0, "no force to switch off");
            engine.report(); // What is observed follows.
            Check.same(Arrays.toString(engine.get("bodies", "force")), "[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]");
            engine.restore(state);
            Check.same(engine.steps(), 100L);
            Check.same(engine.get("bodies", "position")[0], there);
            engine.set("scene", "time", 7);
            engine.step(1, 0.5);
            Check.same(engine.time(), 7.5);
        }
        Check.done("rows and laws");
    }
}
