/* A room of the samples.
 * Public headers: scene.h */
