/* A room of the samples.
 * Public headers: render.h */
