import java.awt.image.BufferedImage;
import java.io.File;
import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.DoubleBuffer;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import javax.imageio.ImageIO;
import vesper.Builder;
import vesper.Engine;

/**
 * A virtual environment around an engine: things of its own, which look at themselves and are drawn in each frame, and whose places
 * lie in one direct buffer that the engine uses in place. A chain hangs from a nail, a ball is thrown by the environment in
 * between. Frames are drawn as text; with a file as argument the paths are drawn there, too, as a PNG picture.
 */
final class Environment implements AutoCloseable {
    private static final int LINKS = 12;
    private static final double FRAME = 1.0 / 25;
    private static final int FRAMES = 100;

    /** A thing of the environment: a row of the engine, and what the environment knows about it. */
    static final class Body {
        final String name;
        final char sign;
        final double mass;
        private final int row;
        private final DoubleBuffer places;

        Body(String name, char sign, double mass, int row, DoubleBuffer places) {
            this.name = name;
            this.sign = sign;
            this.mass = mass;
            this.row = row;
            this.places = places;
        }

        /** Where it is: read where the engine wrote it. */
        double x() {
            return places.get(3 * row);
        }

        double z() {
            return places.get(3 * row + 2);
        }

        /** Puts it somewhere else, for the engine to go on from there. */
        void put(double x, double z) {
            places.put(3 * row, x).put(3 * row + 1, 0).put(3 * row + 2, z);
        }

        /** What the environment asks of each thing before it draws it. */
        void validate() {
            if (!(Math.abs(x()) < 1e3 && Math.abs(z()) < 1e3)) {
                throw new IllegalStateException(name + " left the world: " + x() + ", " + z());
            }
        }
    }

    private final List<Body> bodies = new ArrayList<>();
    private final Engine engine;

    Environment() {
        int count = LINKS + 2;
        ByteBuffer memory = ByteBuffer.allocateDirect(3 * count * Double.BYTES).order(ByteOrder.nativeOrder());
        DoubleBuffer places = memory.asDoubleBuffer();
        int[] ends = new int[2 * LINKS];
        double[] masses = new double[count];
        double[] stiffness = new double[LINKS];
        double[] damping = new double[LINKS];
        double[] rest = new double[LINKS];
        for (int row = 0; row < count; row++) {
            boolean ball = row == count - 1;
            // A row of mass 0 is immovable: the nail.
            double mass = row == 0 ? 0 : ball ? 2 : 0.1;
            String name = row == 0 ? "nail" : ball ? "ball" : "link " + row;
            Body body = new Body(name, row == 0 ? '+' : ball ? 'O' : 'o', mass, row, places);
            body.put(ball ? -8 : 0.5 * row, ball ? -6 : 0);
            masses[row] = mass;
            bodies.add(body);
        }
        for (int link = 0; link < LINKS; link++) {
            ends[2 * link] = link;
            ends[2 * link + 1] = link + 1;
            stiffness[link] = 400;
            damping[link] = 0.5;
            rest[link] = 0.5;
        }
        Builder builder = Engine.builder()
                .domain("bodies", count)
                .lend("bodies", "position", memory)
                .column("bodies", "velocity", new double[3 * count])
                .column("bodies", "mass", masses)
                .domain("springs", LINKS)
                .link("springs", "ends", "bodies", ends)
                .column("springs", "stiffness", stiffness)
                .column("springs", "damping", damping)
                .column("springs", "rest_length", rest)
                .constant("gravity", 0, 0, -9.81);
        engine = builder.law("spring").law("damper").law("uniform_gravity").law("motion").step(1e-3).build();
        throwBall();
    }

    /** What a user of the environment might do between two frames: the ball begins anew, with a velocity. */
    private void throwBall() {
        bodies.get(LINKS + 1).put(-8, -6);
        double[] velocity = engine.get("bodies", "velocity");
        velocity[3 * (LINKS + 1)] = 8;
        velocity[3 * (LINKS + 1) + 1] = 0;
        velocity[3 * (LINKS + 1) + 2] = 11;
        engine.set("bodies", "velocity", velocity);
    }

    /** One frame: the engine goes on, everything looks at itself. */
    void frame(int number) {
        if (number == FRAMES / 2) {
            throwBall();
        }
        engine.advance(FRAME);
        bodies.forEach(Body::validate);
    }

    /** The frame as text, 72 columns and 14 rows. */
    String text() {
        char[][] grid = new char[14][72];
        for (char[] line : grid) {
            Arrays.fill(line, ' ');
        }
        for (Body body : bodies) {
            int column = (int) Math.floor((body.x() + 12) * 3);
            int line = (int) Math.floor((1 - body.z()) * 1.6);
            if (line >= 0 && line < grid.length && column >= 0 && column < grid[0].length) {
                grid[line][column] = body.sign;
            }
        }
        StringBuilder text = new StringBuilder(String.format("t = %.2f s%n", engine.time()));
        for (char[] line : grid) {
            text.append(new String(line).stripTrailing()).append(System.lineSeparator());
        }
        return text.toString();
    }

    /** Adds the places of now to a picture; later is brighter. */
    void draw(BufferedImage picture, int number) {
        int bright = 80 + 175 * number / FRAMES;
        for (Body body : bodies) {
            int x = (int) ((body.x() + 12) * picture.getWidth() / 24);
            int y = (int) ((2 - body.z()) * picture.getWidth() / 24);
            int colour = body.sign == 'O' ? bright << 16 | bright / 2 << 8 : bright << 8 | bright;
            for (int place = 0; place < 9; place++) {
                int column = x + place % 3 - 1;
                int line = y + place / 3 - 1;
                if (column >= 0 && line >= 0 && column < picture.getWidth() && line < picture.getHeight()) {
                    picture.setRGB(column, line, colour);
                }
            }
        }
    }

    @Override
    public void close() {
        engine.close();
    }

    public static void main(String[] arguments) throws IOException {
        BufferedImage picture = new BufferedImage(720, 400, BufferedImage.TYPE_INT_RGB);
        try (Environment environment = new Environment()) {
            for (int number = 1; number <= FRAMES; number++) {
                environment.frame(number);
                environment.draw(picture, number);
                if (number % 20 == 0) {
                    System.out.print(environment.text());
                }
            }
        }
        if (arguments.length > 0) {
            ImageIO.write(picture, "png", new File(arguments[0]));
        }
    }
}
