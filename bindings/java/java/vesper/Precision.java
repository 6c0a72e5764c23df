package vesper;

/** The numbers that an engine computes with. */
public enum Precision {
    /** {@code float}. */
    F32,
    /** {@code double}. */
    F64
}
