/**
 * Vesper, a framework for laws of physics, from Java.
 *
 * <p>In: domains, columns as arrays or as direct buffers that are used in place, laws by their names, whole scenes. Out: engines
 * that take steps, and between them show and change their columns. Never: a number of a lent buffer that is copied; a fault
 * without its whole text.
 *
 * <p>A {@link vesper.Builder} becomes an {@link vesper.Engine}; what goes wrong is a {@link vesper.VesperException}.
 * Numbers are in SI units, where no other one is named. The native library is the file that the system property
 * {@code vesper.library} names, or {@code vesper_java} on {@code java.library.path}. What it has to say goes to the
 * {@link java.lang.System.Logger} {@code "vesper"}, up to the level that this has when an engine is begun.
 */
package vesper;
