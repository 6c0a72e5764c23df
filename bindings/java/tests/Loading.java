import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.logging.Handler;
import java.util.logging.Level;
import java.util.logging.LogRecord;
import java.util.logging.Logger;
import vesper.Builder;
import vesper.Engine;
import vesper.VesperException.Kind;

/**
 * What is loaded, and what it says: the native half, and what is told where it is not there; modules of laws; the log. Arguments: a
 * folder with the module {@code lift}, and a library that is not the native half.
 */
final class Loading {
    private Loading() {}

    /** Another machine of Java, with this library; what it says. */
    private static String with(String library) throws IOException, InterruptedException {
        List<String> command = new ArrayList<>(List.of(Path.of(System.getProperty("java.home"), "bin", "java").toString()));
        command.addAll(List.of("-cp", System.getProperty("java.class.path"), "--enable-native-access=ALL-UNNAMED"));
        if (library != null) {
            command.add("-Dvesper.library=" + library);
        }
        command.addAll(List.of("-Djava.library.path=/nowhere", "Loading"));
        Process process = new ProcessBuilder(command).redirectErrorStream(true).start();
        String said = new String(process.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        Check.same(process.waitFor(), 0);
        return said;
    }

    /** In the other one: the second time it is told as the first. */
    private static void tellTwice() {
        for (int time = 0; time < 2; time++) {
            System.out.println(Check.refused(Kind.FAULT, Engine::builder));
        }
    }

    private static void withoutLibrary(String other) throws IOException, InterruptedException {
        for (String library : Arrays.asList(null, "/nowhere/libvesper_java.so", other)) {
            String[] lines = with(library).split("\n");
            Check.same(lines.length, 2);
            Check.same(lines[1], lines[0]);
            Check.that(lines[0].startsWith("the native half of vesper is not there: "), lines[0]);
            Check.that(lines[0].contains("-Dvesper.library="), lines[0]);
            Check.that(library == null || library.equals(other) || lines[0].contains(library), lines[0]);
        }
    }

    private static Builder glider() {
        Builder builder = Engine.builder().domain("gliders", 1).column("gliders", "position", 0, 0, 1000);
        return builder.column("gliders", "velocity", 25, 0, 0).column("gliders", "mass", 250).constant("gravity", 0, 0, -9.81)
                .law("motion").law("uniform_gravity");
    }

    private static void modules(Path folder) {
        try (Engine engine = glider().lawsFrom(folder).law("lift", "module = 'lift', slope = 98.1").step(1e-3).build()) {
            engine.advance(1);
            double height = engine.get("gliders", "position")[2];
            Check.that(Math.abs(height - 1000) < 1e-9, "it is carried, and not at " + height);
        }
        Builder nowhere = glider().lawsFrom(folder.resolve("nowhere"));
        String text = Check.refused(Kind.FAULT, nowhere::build);
        Check.same(text, "there is no folder " + folder.resolve("nowhere") + " with modules of laws");
        Check.refused(Kind.FAULT, () -> glider().lawsFrom(null).build());
    }

    private static void log() {
        List<LogRecord> heard = new ArrayList<>();
        Handler keep = new Handler() {
            @Override
            public void publish(LogRecord record) {
                heard.add(record);
                throw new IllegalStateException("a logger that throws breaks nothing");
            }

            @Override
            public void flush() {}

            @Override
            public void close() {}
        };
        Logger logger = Logger.getLogger("vesper");
        logger.setUseParentHandlers(false);
        logger.addHandler(keep);
        try (Engine engine = glider().law("spring").build()) {
            engine.step(1, 1e-3);
        }
        Check.same(heard.size(), 1);
        Check.same(heard.get(0).getLevel(), Level.WARNING);
        Check.that(heard.get(0).getMessage().contains("spring"), heard.get(0).getMessage());
        logger.setLevel(Level.SEVERE);
        glider().law("spring").build().close();
        Check.same(heard.size(), 1);
    }

    public static void main(String[] arguments) throws IOException, InterruptedException {
        if (arguments.length == 0) {
            tellTwice();
            return;
        }
        withoutLibrary(arguments[1]);
        modules(Path.of(arguments[0]));
        log();
        Check.done("loading");
    }
}
