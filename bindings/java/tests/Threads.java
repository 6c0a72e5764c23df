import java.util.Arrays;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.atomic.AtomicReference;
import vesper.Builder;
import vesper.Engine;
import vesper.VesperException;
import vesper.VesperException.Kind;

/** An engine belongs to one thread; another one is told so, and gets it when that one lets go or ends. */
final class Threads {
    private Threads() {}

    private static Engine one() {
        return Engine.builder().domain("bodies", 1).column("bodies", "position", 0, 0, 0)
                .column("bodies", "velocity", 1, 0, 0).column("bodies", "mass", 1).law("motion").build();
    }

    private static void on(String name, Runnable call) throws InterruptedException {
        AssertionError[] failed = new AssertionError[1];
        Thread thread = new Thread(() -> {
            try {
                call.run();
            } catch (AssertionError error) {
                failed[0] = error;
            }
        }, name);
        thread.start();
        thread.join();
        if (failed[0] != null) {
            throw failed[0];
        }
    }

    /** Threads that begin at one time; what one of them throws is thrown here. */
    private static void together(int count, Runnable call) throws InterruptedException {
        AtomicReference<Throwable> failed = new AtomicReference<>();
        CountDownLatch start = new CountDownLatch(1);
        Thread[] threads = new Thread[count];
        for (int number = 0; number < count; number++) {
            threads[number] = new Thread(() -> {
                try {
                    start.await();
                    call.run();
                } catch (Throwable thrown) {
                    failed.compareAndSet(null, thrown);
                }
            });
            threads[number].start();
        }
        start.countDown();
        for (Thread thread : threads) {
            thread.join();
        }
        if (failed.get() != null) {
            throw new AssertionError("a thread failed", failed.get());
        }
    }

    /** What a thread of a test finds wrong fails the test. */
    private static void isHeard() throws InterruptedException {
        try {
            together(2, () -> Check.that(false, "said in a thread"));
        } catch (AssertionError heard) {
            Check.same(heard.getCause().getMessage(), "said in a thread");
            return;
        }
        throw new AssertionError("a thread failed, and nobody heard it");
    }

    /** Of two threads that build with one builder at one time one gets the engine, and the other is told. */
    private static void oneBuilds() throws InterruptedException {
        int rounds = 5_000;
        Builder[] builders = new Builder[rounds];
        Arrays.setAll(builders, round -> Engine.builder());
        AtomicInteger arrived = new AtomicInteger();
        AtomicInteger built = new AtomicInteger();
        together(2, () -> {
            for (int round = 0; round < rounds; round++) {
                arrived.incrementAndGet();
                while (arrived.get() < 2 * (round + 1)) { // As near to each other as can be.
                    Thread.onSpinWait();
                }
                try (Engine engine = builders[round].build()) {
                    built.incrementAndGet();
                } catch (VesperException exception) {
                    arrived.addAndGet(exception.kind() == Kind.CLOSED ? 0 : 2 * rounds); // Nobody waits for who fails.
                    Check.same(exception.kind(), Kind.CLOSED);
                }
            }
        });
        Check.same(built.get(), rounds);
    }

    private static void inTurns() throws InterruptedException {
        Engine engine = one();
        String theirs = "this engine belongs to thread main: call letGo() there first";
        on("other", () -> {
            Check.same(Check.refused(Kind.THREAD, () -> engine.step(1, 1)), theirs);
            Check.same(Check.refused(Kind.THREAD, engine::close), theirs);
            Check.same(Check.refused(Kind.THREAD, engine::letGo), theirs);
        });
        engine.letGo();
        on("other", () -> engine.step(1, 1));
        engine.step(1, 1); // The other one has ended.
        Check.same(engine.get("bodies", "position")[0], 2.0);
        engine.letGo();
        on("other", engine::close);
        Check.refused(Kind.CLOSED, () -> engine.step(1, 1));
    }

    /** Many threads at one engine, which let go of it and close it: each step is one thread's, and none is lost. */
    private static void allAtOnce() throws InterruptedException {
        for (int round = 0; round < 20; round++) {
            Engine engine = one();
            engine.letGo();
            AtomicInteger steps = new AtomicInteger();
            together(4, () -> {
                for (int turn = 0; turn < 2000; turn++) {
                    try {
                        engine.step(1, 1);
                        steps.incrementAndGet();
                        engine.letGo();
                    } catch (VesperException exception) {
                        Check.same(exception.kind(), Kind.THREAD);
                    }
                }
            });
            Check.same(engine.steps(), (long) steps.get());
            engine.close();
        }
    }

    public static void main(String[] arguments) throws InterruptedException {
        isHeard();
        inTurns();
        allAtOnce();
        oneBuilds();
        Check.done("threads");
    }
}
