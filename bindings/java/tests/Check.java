import java.util.concurrent.atomic.AtomicInteger;
import vesper.VesperException;

/** What the tests ask: that something holds, or is refused in these words. */
final class Check {
    private static final AtomicInteger CHECKS = new AtomicInteger();

    private Check() {}

    static void that(boolean holds, String what) {
        CHECKS.incrementAndGet();
        if (!holds) {
            throw new AssertionError(what);
        }
    }

    static void same(Object got, Object expected) {
        that(expected.equals(got), "expected:\n" + expected + "\ngot:\n" + got);
    }

    /** Expects an exception of this kind, and gives its text. */
    static String refused(VesperException.Kind kind, Runnable call) {
        try {
            call.run();
        } catch (VesperException exception) {
            same(exception.kind(), kind);
            that(!exception.getMessage().isBlank(), "an exception without a word");
            return exception.getMessage();
        }
        throw new AssertionError("nothing was refused");
    }

    static void done(String test) {
        System.out.println(test + ": " + CHECKS + " checks hold");
    }
}
