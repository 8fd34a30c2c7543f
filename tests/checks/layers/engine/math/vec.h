/* A room of the samples.
 * Public headers: vec.h simd/ops.h */
