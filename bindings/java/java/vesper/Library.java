package vesper;

import java.io.File;
import java.lang.System.Logger;
import java.lang.System.Logger.Level;

/**
 * The native half.
 *
 * <p>In: where it is, {@code vesper.library}. Out: nothing, once it is loaded and is of this version; what it logs, to the logger
 * {@code "vesper"}. Never: an error of Java's own for a file that is not there.
 */
final class Library {
    /** The version that both halves have. */
    static final String VERSION = "0.1.0";

    /** What 1 to 5 of the native half are here: its third one, a column that nobody uses, is not for a terminal where nobody asked. */
    private static final Level[] LEVELS = {Level.ERROR, Level.WARNING, Level.DEBUG, Level.DEBUG, Level.TRACE};

    private static final Logger LOGGER = System.getLogger("vesper");
    private static boolean loaded;

    private Library() {}

    /** Loads it, unless it is there. Not when a class is initialised: what fails there has another name the second time. */
    static synchronized void load() {
        if (!loaded) {
            String file = System.getProperty("vesper.library");
            String version;
            try {
                if (file == null) {
                    System.loadLibrary("vesper_java");
                } else {
                    System.load(new File(file).getAbsolutePath());
                }
                version = nativeVersion();
            } catch (UnsatisfiedLinkError missing) {
                String text = "the native half of vesper is not there: " + missing.getMessage() + ": build it by cargo build --release"
                        + " -p vesper-java, and name the file, -Dvesper.library=target/release/" + System.mapLibraryName("vesper_java");
                throw new VesperException(VesperException.Kind.FAULT, text);
            }
            if (!VERSION.equals(version)) {
                String text = "the native half of vesper is of version " + version + ", and the classes are of " + VERSION
                        + ": build both from the same sources, and name the file by -Dvesper.library";
                throw new VesperException(VesperException.Kind.FAULT, text);
            }
            loaded = true;
        }
        int level = LEVELS.length;
        while (level > 0 && !LOGGER.isLoggable(LEVELS[level - 1])) {
            level--;
        }
        nativeListen(level);
    }

    /** Called by the native half, on any thread. */
    private static void say(int level, String text) {
        LOGGER.log(LEVELS[level - 1], text);
    }

    private static native String nativeVersion();

    private static native void nativeListen(int level);
}
