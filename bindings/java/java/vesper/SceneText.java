package vesper;

import java.lang.reflect.Array;
import java.util.Collection;
import java.util.Map;
import java.util.StringJoiner;

/**
 * Values of Java in the language of scenes.
 *
 * <p>In: numbers, texts, truths, lists, arrays, maps. Out: what a scene would say, with all digits. Never: a value that is guessed:
 * others are refused.
 */
final class SceneText {
    /** Deeper than any parameter, and a list that contains itself ends there. */
    private static final int DEPTH = 16;

    private SceneText() {}

    /** Pairs as they stand between the braces of a table, {@code g = 1.0, domain = "stars"}. */
    static String pairs(String what, Map<String, ?> values) {
        return pairs(what, values, 0);
    }

    private static String pairs(String what, Map<?, ?> values, int depth) {
        StringJoiner pairs = new StringJoiner(", ");
        if (values != null) {
            for (Map.Entry<?, ?> entry : values.entrySet()) {
                String key = String.valueOf(entry.getKey());
                String name = key.matches("[A-Za-z0-9_-]+") ? key : quoted(key);
                pairs.add(name + " = " + value(what + "." + key, entry.getValue(), depth + 1));
            }
        }
        return pairs.toString();
    }

    private static String value(String what, Object value, int depth) {
        if (depth > DEPTH) {
            throw new VesperException(VesperException.Kind.ARGUMENT, what + " is nested too deeply: say it flatly");
        }
        if (value instanceof Double || value instanceof Float) {
            return number(((Number) value).doubleValue());
        }
        if (value instanceof Long || value instanceof Integer || value instanceof Short || value instanceof Byte
                || value instanceof Boolean) {
            return value.toString();
        }
        if (value instanceof CharSequence || value instanceof Enum) {
            return quoted(value.toString());
        }
        if (value instanceof Map) {
            return "{ " + pairs(what, (Map<?, ?>) value, depth) + " }";
        }
        StringJoiner list = new StringJoiner(", ", "[", "]");
        if (value instanceof Collection) {
            for (Object each : (Collection<?>) value) {
                list.add(value(what, each, depth + 1));
            }
            return list.toString();
        }
        if (value != null && value.getClass().isArray()) {
            for (int place = 0; place < Array.getLength(value); place++) {
                list.add(value(what, Array.get(value, place), depth + 1));
            }
            return list.toString();
        }
        String kind = value == null ? "null" : "a " + value.getClass().getName();
        String text = what + " is " + kind + ": give a number, a text, a boolean, a list or a map";
        throw new VesperException(VesperException.Kind.ARGUMENT, text);
    }

    /** A number with all its digits. */
    static String number(double number) {
        if (Double.isNaN(number)) {
            return "nan";
        }
        return Double.isInfinite(number) ? (number > 0 ? "inf" : "-inf") : Double.toString(number);
    }

    /** A text in quotes. */
    static String quoted(String text) {
        StringBuilder quoted = new StringBuilder("\"");
        for (char letter : text.toCharArray()) {
            if (letter == '"' || letter == '\\') {
                quoted.append('\\').append(letter);
            } else if (Character.isISOControl(letter)) {
                quoted.append(String.format("\\u%04X", (int) letter));
            } else {
                quoted.append(letter);
            }
        }
        return quoted.append('"').toString();
    }
}
