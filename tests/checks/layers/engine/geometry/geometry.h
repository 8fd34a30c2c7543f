/* A room of the samples.
 * Public headers: geometry.h */
