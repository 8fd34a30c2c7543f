/* A room of the samples.
 * Public headers: shade.h */
