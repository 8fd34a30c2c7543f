/* A room of the samples.
 * Public headers: raster.h */
