import java.util.concurrent.CountDownLatch;
import java.util.concurrent.atomic.AtomicInteger;
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

    private static void inTurns() throws InterruptedException {
        Engine engine = one();
        String theirs = "this engine belongs to thread main: call letGo() there first";
        on("other", () -> {
            Check.same(Check.refused(Kind.THREAD, () -> engine.step(1)), theirs);
            Check.same(Check.refused(Kind.THREAD, engine::close), theirs);
            Check.same(Check.refused(Kind.THREAD, engine::letGo), theirs);
        });
        engine.letGo();
        on("other", () -> engine.step(1));
        engine.step(1); // The other one has ended.
        Check.same(engine.get("bodies", "position")[0], 2.0);
        engine.letGo();
        on("other", engine::close);
        Check.refused(Kind.CLOSED, () -> engine.step(1));
    }

    /** Many threads at one engine, which let go of it and close it: each step is one thread's, and none is lost. */
    private static void allAtOnce() throws InterruptedException {
        for (int round = 0; round < 20; round++) {
            Engine engine = one();
            engine.letGo();
            AtomicInteger steps = new AtomicInteger();
            CountDownLatch start = new CountDownLatch(1);
            Thread[] threads = new Thread[4];
            for (int number = 0; number < threads.length; number++) {
                threads[number] = new Thread(() -> {
                    try {
                        start.await();
                    } catch (InterruptedException impossible) {
                        return;
                    }
                    for (int turn = 0; turn < 2000; turn++) {
                        try {
                            engine.step(1);
                            steps.incrementAndGet();
                            engine.letGo();
                        } catch (VesperException exception) {
                            Check.same(exception.kind(), Kind.THREAD);
                        }
                    }
                });
                threads[number].start();
            }
            start.countDown();
            for (Thread thread : threads) {
                thread.join();
            }
            Check.same(engine.steps(), (long) steps.get());
            engine.close();
        }
    }

    public static void main(String[] arguments) throws InterruptedException {
        inTurns();
        allAtOnce();
        Check.done("threads");
    }
}
