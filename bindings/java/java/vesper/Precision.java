package vesper;

/** The numbers that an engine computes with. */
public enum Precision {
    /** {@code float}. */
    F32,
    /** {@code double}. */
    F64;

    /** Bytes of a number. */
    public int bytes() {
        return this == F32 ? Float.BYTES : Double.BYTES;
    }
}
