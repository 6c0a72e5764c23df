import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import vesper.Builder;
import vesper.Engine;
import vesper.VesperException.Kind;

/** What is refused, in full: all faults of a builder at once, in the order of the calls; and what an engine refuses. */
final class Faults {
    private Faults() {}

    private static ByteBuffer direct(int bytes) {
        return ByteBuffer.allocateDirect(bytes).order(ByteOrder.nativeOrder());
    }

    private static Builder one() {
        Builder builder = Engine.builder().domain("bodies", 1).column("bodies", "position", 0, 0, 0);
        return builder.column("bodies", "velocity", 1, 0, 0).column("bodies", "mass", 1).law("motion").step(1);
    }

    private static void allAtOnce() {
        ByteBuffer twice = direct(24);
        String text = Check.refused(Kind.FAULT, () -> Engine.builder()
                .domain("bodies", 1)
                .domain("bodies", 2)
                .domain("more", -1)
                .column("bodys", "mass", 1)
                .column("bodies", "mass", 1, 2)
                .column("bodies", null, 1)
                .column("bodies", "mass", (double[]) null)
                .column("bodies", "mass [s]", 1)
                .lend("bodies", "position", ByteBuffer.allocate(24))
                .lend("bodies", "position", ByteBuffer.allocateDirect(24).order(ByteOrder.BIG_ENDIAN))
                .lend("bodies", "position", direct(24).asReadOnlyBuffer())
                .lend("bodies", "position", null)
                .lend("bodies", "position", direct(20))
                .lend("bodies", "position", direct(16))
                .lend("bodies", "position", direct(32).slice(4, 24).order(ByteOrder.nativeOrder()))
                .lend("bodies", "position", twice)
                .lend("bodies", "velocity", twice)
                .link("bodies", "ends", "bodies", 0, -1)
                .law("gravity", Map.of("softning", 1e3))
                .law("gravity", Map.of("softening", new Object[] {null}))
                .build());
        text = text.replaceAll("0x[0-9a-f]+", "ADDRESS");
        Check.same(text, String.join("\n",
                "domain bodies is given twice: keep one",
                "domain more has -1 rows: give 0 or more",
                "domain bodys does not exist; did you mean bodies?",
                "bodies.mass has 2 numbers, but 1 rows of a scalar are 1: give as many",
                "the property is null: give a text",
                "bodies.mass is null: give an array",
                "bodies.mass is given in s, but it is measured in kg: give it in a unit of that dimension",
                "bodies.position cannot be lent: the buffer lies in the heap, where it is moved: make it by"
                        + " ByteBuffer.allocateDirect",
                "bodies.position cannot be lent: the buffer is BIG_ENDIAN: make it so by order(ByteOrder.nativeOrder())",
                "bodies.position cannot be lent: the buffer is read-only, and steps write there: give one that can be written",
                "bodies.position cannot be lent: the buffer is null: give a direct one",
                "bodies.position has 20 bytes, which are no numbers in f64 of 8 bytes each",
                "bodies.position has 2 numbers, but 1 rows of a vector are 3: give as many",
                "bodies.position: ADDRESS is no address of an f64: align the memory",
                "bodies.velocity cannot be lent: bodies.position has some of the same memory: lend each column memory of its own",
                "bodies.ends names row -1: rows count from 0",
                "error: law `gravity` has no parameter `softning`",
                "  --> law gravity:1:29",
                "  1 | laws = [{ name = \"gravity\", softning = 1000.0 }]",
                "    |                             ^^^^^^^^",
                "    = help: did you mean `softening`?",
                "law gravity.softening is null: give a number, a text, a boolean, a list or a map"));
    }

    private static void ofParameters() {
        Map<String, Object> all = new LinkedHashMap<>();
        all.put("g", 1);
        all.put("softening", 1e-3f);
        all.put("label", "a \"pull\"\n");
        all.put("domain", "bodies");
        Builder builder = one().law("gravity", all).integrator("dormand_prince_8", Map.of("rtol", 1e-10)).threads(1);
        try (Engine engine = builder.observe("bodies", "force").build()) {
            engine.step(1, 1);
            Check.that(engine.report().contains("a \"pull\"\n is active"), engine.report());
            Check.that(!engine.explain().isBlank() && engine.dot().startsWith("digraph"), engine.dot());
            Check.same(engine.get("bodies", "force").length, 3);
        }
        List<Object> itself = new ArrayList<>();
        itself.add(itself);
        Check.refused(Kind.FAULT, () -> one().law("gravity", Map.of("g", itself)).build());
        Check.refused(Kind.FAULT, () -> one().law("gravity", Map.of("g", new Object())).build());
        Check.refused(Kind.FAULT, () -> one().law(null).build());
        Check.refused(Kind.FAULT, () -> one().step(Double.NaN).build());
        Check.refused(Kind.FAULT, () -> one().integrator(null).build());
        Check.refused(Kind.FAULT, () -> one().integrator("euler", null).integrator("x").build());
        Check.refused(Kind.FAULT, () -> one().scene(null).build());
        Check.refused(Kind.FAULT, () -> one().settings("step = \ud800").build());
        Check.refused(Kind.FAULT, () -> Engine.fromScene("no scene"));
    }

    /** More than there is memory for is refused where it is counted, before anything is asked for. */
    private static void tooMuch() {
        Check.refused(Kind.FAULT, () -> one().domain("more", 1L << 32).build());
        Check.refused(Kind.FAULT, () -> one().domain("more", (1L << 32) - 1).column("more", "mass", 1).build());
        try (Engine engine = one().domain("more", (1L << 32) - 1).build()) {
            Check.refused(Kind.FAULT, () -> engine.get("more", "mass"));
            Check.refused(Kind.FAULT, () -> engine.addRows("more", 1, Map.of()));
            Check.refused(Kind.FAULT, () -> engine.addRows("bodies", Long.MAX_VALUE, Map.of()));
            engine.step(1, 1);
        }
    }

    private static void ofAnEngine() {
        Builder builder = one();
        try (Engine engine = builder.build()) {
            Check.refused(Kind.CLOSED, builder::build);
            Check.refused(Kind.CLOSED, () -> builder.domain("more", 1));
            Check.same(Check.refused(Kind.FAULT, () -> engine.get("bodies", "masse")),
                    Check.refused(Kind.FAULT, () -> engine.get("bodies", "masse", new double[1])));
            Check.same(Check.refused(Kind.FAULT, () -> engine.get("bodies", "mass", new double[2])),
                    "bodies.mass: 1 values of 1 numbers are 1, and not 2: give as many");
            Check.same(Check.refused(Kind.ARGUMENT, () -> engine.get(null, "mass")), "the domain is null: give a text");
            Check.refused(Kind.ARGUMENT, () -> engine.get("bodies", "mass", (double[]) null));
            Check.refused(Kind.ARGUMENT, () -> engine.set("bodies", "mass", (double[]) null));
            Check.refused(Kind.FAULT, () -> engine.set("bodies", "position", 1, Double.NaN, 0));
            Check.refused(Kind.FAULT, () -> engine.lent("bodies", null));
            Check.refused(Kind.ARGUMENT, () -> engine.links("bodies", "mass"));
            Check.same(Check.refused(Kind.ARGUMENT, () -> engine.step(-1, 1)), "-1 steps cannot be taken: give 0 or more");
            Check.refused(Kind.RUN, () -> engine.step(1, Double.NaN));
            Check.refused(Kind.FAULT, () -> engine.enable("gravitas", true));
            Check.refused(Kind.FAULT, () -> engine.restore("{"));
            Check.refused(Kind.ARGUMENT, () -> engine.restore(null));
            // Nothing of it changed anything.
            Check.same(engine.steps(), 0L);
            engine.step(1, 1);
            Check.same(engine.get("bodies", "position")[0], 1.0);
            engine.set("bodies", "velocity", 1e308, 0, 0);
            String text = Check.refused(Kind.RUN, () -> engine.step(10, 1));
            Check.that(text.contains("bodies.position"), text);
            engine.close();
            engine.close();
            Check.that(engine.isClosed(), "it is not closed");
            Check.same(Check.refused(Kind.CLOSED, () -> engine.step(1, 1)), "this engine is closed: build another one");
            Check.refused(Kind.CLOSED, engine::time);
            Check.refused(Kind.CLOSED, engine::letGo);
            Check.refused(Kind.CLOSED, () -> engine.lent("bodies", "mass"));
        }
    }

    public static void main(String[] arguments) {
        allAtOnce();
        ofParameters();
        tooMuch();
        ofAnEngine();
        Check.done("faults");
    }
}
