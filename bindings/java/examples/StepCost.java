import java.util.Arrays;
import vesper.Builder;
import vesper.Engine;

/**
 * What a call costs from Java, in ns: a step of two bodies, a frame of them, and a frame with nothing to do, which shows what the way
 * to the library and back costs, and little else. The least of many batches, the median of many engines, as in {@code step_cost.rs}
 * of the C interface, which measures the same scenes in Rust.
 */
final class StepCost {
    private static final int CALLS = 1000;
    private static final int BATCHES = 40;
    private static final int ENGINES = 60;
    private static final double STEP = 1.0 / 1024;

    private StepCost() {}

    private static Engine twoBodies() {
        Builder builder = Engine.builder().domain("bodies", 2).column("bodies", "position", 0, 0, 0, 1, 0, 0);
        builder.column("bodies", "velocity", 0, 0, 0, 0, 1, 0).column("bodies", "mass", 1, 1e-3);
        return builder.law("gravity", "g = 1").law("motion").integrator("leapfrog").step(STEP).build();
    }

    private static void steps(Engine engine) {
        for (int call = 0; call < CALLS; call++) {
            engine.step(1, STEP);
        }
    }

    private static void frames(Engine engine) {
        for (int call = 0; call < CALLS; call++) {
            engine.advance(STEP);
        }
    }

    /** The time of a step, in ns, where that is the least so far. */
    private static void least(double[] best, int which, Runnable batch) {
        long start = System.nanoTime();
        batch.run();
        best[which] = Math.min(best[which], (System.nanoTime() - start) / (double) CALLS);
    }

    public static void main(String[] arguments) {
        double[][] all = new double[3][ENGINES];
        for (int turn = -5; turn < ENGINES; turn++) { // Some first, for the compiler of Java.
            double[] best = new double[all.length];
            Arrays.fill(best, Double.POSITIVE_INFINITY);
            try (Engine engine = twoBodies(); Engine empty = Engine.builder().step(STEP).build()) {
                for (int batch = 0; batch < BATCHES; batch++) {
                    least(best, 0, () -> steps(engine));
                    least(best, 1, () -> frames(engine));
                    least(best, 2, () -> frames(empty));
                }
            }
            for (int which = 0; turn >= 0 && which < all.length; which++) {
                all[which][turn] = best[which];
            }
        }
        for (double[] times : all) {
            Arrays.sort(times);
        }
        int middle = ENGINES / 2;
        System.out.printf("step of two bodies: Java %.1f ns%n", all[0][middle]);
        System.out.printf("frame of two bodies: Java %.1f ns%n", all[1][middle]);
        System.out.printf("frame with nothing to do: Java %.1f ns%n", all[2][middle]);
    }
}
