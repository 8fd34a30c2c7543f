/* accel/traverse: rays through the trees: single rays, packets of sixteen, streams, and the kd-tree. Public headers:
 * traverse.h.
 *
 * The kernels of each instruction set; dispatch.c picks. */
#ifndef DAFT_TRAVERSE_H
#define DAFT_TRAVERSE_H

#include "accel/accel.h"
#include "math/simd/dispatch.h"

DAFT_KERNEL_DECLARE(daft_accel_kernels, daft_accel);

#ifdef DAFT_ISA
/* single_kernel.c: one ray through one instance, or from a child's code downwards. Rays are in frame space. */
struct daft_nearest;
struct daft_mesh_ray;
void DAFT_KERNEL(daft_instance_closest)(const daft_tlas *tlas, uint32_t index, const daft_ray *ray,
                                        struct daft_nearest *hit);
bool DAFT_KERNEL(daft_instance_occluded)(const daft_tlas *tlas, uint32_t index, const daft_ray *ray);
void DAFT_KERNEL(daft_mesh_closest)(const daft_instance *instance, uint32_t child, const daft_ray *ray,
                                    daft_intersection how, struct daft_nearest *hit);
bool DAFT_KERNEL(daft_mesh_occluded)(const daft_instance *instance, uint32_t child, const daft_ray *ray,
                                     daft_intersection how);
void DAFT_KERNEL(daft_upper_closest)(const daft_tlas *tlas, uint32_t child, const daft_ray *ray, uint32_t ignore,
                                     struct daft_nearest *hit);
bool DAFT_KERNEL(daft_upper_occluded)(const daft_tlas *tlas, uint32_t child, const daft_ray *ray);
/* Against the blocks of a leaf; `child` is its code. See daft_blocks_intersect. */
bool DAFT_KERNEL(daft_leaf_closest)(const daft_block *blocks, uint32_t child, const struct daft_mesh_ray *r, float past,
                                    struct daft_nearest *hit);
bool DAFT_KERNEL(daft_leaf_stops)(const daft_block *blocks, uint32_t child, const struct daft_mesh_ray *r, float past,
                                  struct daft_nearest *hit);

uint32_t DAFT_KERNEL(daft_closest_packet)(const daft_tlas *tlas, const daft_ray_packet *rays, uint32_t active,
                                          uint32_t ignore, daft_hit hits[DAFT_PACKET]);
uint32_t DAFT_KERNEL(daft_occluded_packet)(const daft_tlas *tlas, const daft_ray_packet *rays, uint32_t active);
void DAFT_KERNEL(daft_closest_arrays)(const daft_tlas *tlas, const daft_ray_arrays *rays, uint32_t count,
                                      daft_hit *hits);
void DAFT_KERNEL(daft_closest_stream)(const daft_tlas *tlas, const daft_ray *rays, uint32_t count, uint32_t ignore,
                                      daft_hit *hits);
void DAFT_KERNEL(daft_occluded_stream)(const daft_tlas *tlas, const daft_ray *rays, uint32_t count, uint32_t *occluded);
/* pierce_kernel.c */
void DAFT_KERNEL(daft_pierce)(const daft_tlas *tlas, const daft_ray *ray, uint32_t flag, uint32_t ignore,
                              daft_pierced_at *at, void *user, daft_pierced_leaf *last);
bool DAFT_KERNEL(daft_pierce_leaf)(const daft_tlas *tlas, const daft_ray *ray, const daft_pierced_leaf *leaf,
                                   daft_pierced_at *at, void *user);
/* bound_kernel.c */
void DAFT_KERNEL(daft_bound_all)(daft_instance *instances, uint32_t count);
#endif

#endif
