package vesper;

/** The native half, loaded once, before anything of it is called. */
final class Library {
    static {
        String file = System.getProperty("vesper.library");
        if (file == null) {
            System.loadLibrary("vesper_java");
        } else {
            System.load(new java.io.File(file).getAbsolutePath());
        }
    }

    private Library() {}

    /** Loads it, unless it is there. */
    static void load() {}
}
