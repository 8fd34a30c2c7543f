/* A room of the samples.
 * Public headers: base.h */
