import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.logging.Level;
import java.util.logging.Logger;
import vesper.Builder;
import vesper.Engine;
import vesper.Precision;
import vesper.VesperException;

/**
 * Calls at random: null, wrong sizes, wrong names, wrong order, closed engines, buffers of all kinds. Each one works, or throws a
 * {@link VesperException} with a text; nothing crashes. Arguments: how many calls, and where the chance begins.
 */
final class Chance {
    private static final String[] WORDS = {
        null, "", "bodies", "bodies", "bodies", "springs", "scene", "position", "velocity", "mass", "force", "ends", "stiffness",
        "rest_length", "colour", "gravity", "motion", "spring", "uniform_gravity", "leapfrog", "runge_kutta_4", "velocity [km/s]",
        "mass [", "time", "g = 1", "step = 0.5", "\0", "\ud800", "\u00e4\ud83d\ude00", "x = [[[", "a\"b",
    };

    private final Random chance;
    private final List<Builder> builders = new ArrayList<>();
    private final List<Engine> engines = new ArrayList<>();
    private final List<ByteBuffer> buffers = new ArrayList<>();
    private int done;
    private int refused;

    private Chance(long seed) {
        chance = new Random(seed);
    }

    private String word() {
        return WORDS[chance.nextInt(WORDS.length)];
    }

    private int count() {
        int[] counts = {0, 1, 2, 3, 3, 6, 6, 6, 7, 12, 1000};
        return counts[chance.nextInt(counts.length)];
    }

    private double number() {
        double[] numbers = {0, 1, -1, 0.5, 1e-3, 1e-3, 1e300, Double.NaN, Double.POSITIVE_INFINITY, Double.MIN_VALUE};
        return numbers[chance.nextInt(numbers.length)];
    }

    private double[] numbers() {
        if (chance.nextInt(8) == 0) {
            return null;
        }
        double[] numbers = new double[count()];
        for (int place = 0; place < numbers.length; place++) {
            numbers[place] = chance.nextInt(50) == 0 ? number() : chance.nextDouble();
        }
        return numbers;
    }

    private int[] rows() {
        if (chance.nextInt(8) == 0) {
            return null;
        }
        int[] rows = new int[chance.nextInt(4)];
        for (int place = 0; place < rows.length; place++) {
            rows[place] = chance.nextInt(20) == 0 ? chance.nextInt() : chance.nextInt(3);
        }
        return rows;
    }

    private ByteBuffer buffer() {
        int bytes = 8 * count() + (chance.nextInt(8) == 0 ? 3 : 0);
        int kind = chance.nextInt(10);
        if (kind == 5 && !buffers.isEmpty()) {
            return buffers.get(chance.nextInt(buffers.size()));
        }
        ByteBuffer direct = ByteBuffer.allocateDirect(bytes + 3).slice(kind == 4 ? 3 : 0, bytes);
        switch (kind) {
            case 0:
                return null;
            case 1:
                return ByteBuffer.allocate(bytes).order(ByteOrder.nativeOrder());
            case 2:
                return direct.order(ByteOrder.BIG_ENDIAN);
            case 3:
                return direct.asReadOnlyBuffer().order(ByteOrder.nativeOrder());
            default:
                buffers.add(direct.order(ByteOrder.nativeOrder()));
                return direct;
        }
    }

    private Map<String, Object> values() {
        if (chance.nextInt(8) == 0) {
            return null;
        }
        Object[] kinds = {numbers(), rows(), new float[count()], null, 1, 2.5, "text", true, List.of(1, 2), new Object(), number()};
        Map<String, Object> values = new HashMap<>();
        for (int turn = chance.nextInt(4); turn > 0; turn--) {
            values.put(word(), kinds[chance.nextInt(kinds.length)]);
        }
        return values;
    }

    /** A builder that mostly has what it needs, so that engines come out of some. */
    private Builder sound(boolean lend) {
        Builder builder = Engine.builder(chance.nextInt(4) == 0 ? Precision.F32 : Precision.F64).domain("bodies", 2);
        builder.column("bodies", "velocity", new double[6]).column("bodies", "mass", 1, 1).law("motion");
        if (lend) {
            return builder.lend("bodies", "position", ByteBuffer.allocateDirect(48).order(ByteOrder.nativeOrder()));
        }
        return builder.column("bodies", "position", -1, 0, 0, 1, 0, 0);
    }

    private Builder builder() {
        if (builders.isEmpty() || chance.nextInt(6) == 0) {
            builders.add(chance.nextInt(3) == 0 ? Engine.builder(null) : sound(chance.nextBoolean()));
        }
        if (builders.size() > 20) {
            builders.remove(chance.nextInt(builders.size()));
        }
        return builders.get(chance.nextInt(builders.size()));
    }

    private Engine engine() {
        if (engines.isEmpty() || chance.nextInt(40) == 0) {
            engines.add(sound(chance.nextBoolean()).build());
        }
        if (engines.size() > 20) {
            engines.remove(chance.nextInt(engines.size())); // Not closed: the collector sees to it.
        }
        return engines.get(chance.nextInt(engines.size()));
    }

    private void onBuilder() {
        Builder builder = builder();
        switch (chance.nextInt(17)) {
            case 16 -> builder.lawsFrom(chance.nextBoolean() ? Path.of(".") : null);
            case 0 -> builder.domain(word(), chance.nextInt(10) == 0 ? chance.nextLong() : chance.nextInt(4));
            case 1 -> builder.column(word(), word(), numbers());
            case 2 -> builder.column(word(), word(), new float[count()]);
            case 3, 4 -> builder.lend(word(), word(), buffer());
            case 5 -> builder.link(word(), word(), word(), rows());
            case 6 -> builder.law(word());
            case 7 -> builder.law(word(), word());
            case 8 -> builder.law(word(), values());
            case 9 -> builder.integrator(word(), values());
            case 10 -> builder.settings(word());
            case 11 -> builder.observe(word(), word());
            case 12 -> builder.scene(word(), chance.nextBoolean() ? Path.of("nowhere") : null);
            case 13 -> builder.constant(word(), numbers());
            case 14 -> builder.step(number());
            default -> engines.add(builder.build());
        }
    }

    private void onEngine() {
        Engine engine = engine();
        switch (chance.nextInt(20)) {
            case 0 -> engine.step(chance.nextInt(10) == 0 ? -chance.nextInt(9) : chance.nextInt(9), number());
            case 1 -> engine.advance(number() > 10 ? 0 : number());
            case 2 -> engine.get(word(), word());
            case 3 -> engine.get(word(), word(), numbers());
            case 4 -> engine.get(word(), word(), buffer());
            case 5 -> engine.links(word(), word());
            case 6 -> engine.lent(word(), word());
            case 7 -> engine.address(word(), word());
            case 8 -> engine.set(word(), word(), numbers());
            case 9 -> engine.addRows(word(), chance.nextInt(9) == 0 ? chance.nextLong() : chance.nextInt(3), values());
            case 10 -> engine.removeRows(word(), rows());
            case 11 -> engine.enable(word(), chance.nextBoolean());
            case 12 -> engine.observe(word(), word());
            case 13 -> engine.restore(chance.nextBoolean() ? word() : engine().checkpoint());
            case 14 -> engine.report();
            case 15 -> engine.explain();
            case 16 -> engine.letGo();
            case 17 -> engine.close();
            case 18 -> engine.step(1, 1e-3);
            default -> engine.time();
        }
    }

    private void call() {
        try {
            if (chance.nextInt(3) == 0) {
                onBuilder();
            } else {
                onEngine();
            }
            done++;
        } catch (VesperException exception) {
            Check.that(exception.kind() != VesperException.Kind.PANIC, exception.toString());
            Check.that(!exception.getMessage().isBlank(), "an exception without a word");
            refused++;
        }
    }

    public static void main(String[] arguments) {
        // What is logged is made, and not printed.
        Logger.getLogger("vesper").setUseParentHandlers(false);
        Logger.getLogger("vesper").setLevel(Level.ALL);
        int calls = Integer.parseInt(arguments[0]);
        Chance chance = new Chance(Long.parseLong(arguments[1]));
        for (int call = 0; call < calls; call++) {
            chance.call();
            if (call % 1000 == 0) {
                System.gc();
            }
        }
        String counts = chance.done + " done, " + chance.refused + " refused";
        Check.that(chance.done > calls / 5 && chance.refused > calls / 5, counts);
        System.out.println(calls + " calls at random: " + counts);
    }
}
