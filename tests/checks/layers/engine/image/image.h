/* A room of the samples.
 * Public headers: image.h */
