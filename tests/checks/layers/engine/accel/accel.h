/* A room of the samples.
 * Public headers: accel.h */
