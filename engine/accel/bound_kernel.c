/* Bounds of instances in frame space, for the build and refit of the TLAS: those of meshes DAFT_VL at a time, spheres
 * one by one. */
#include "accel/bound_lanes.h"
#include "accel/traverse/traverse.h"

static void bound_group(daft_instance *instances)
{
    daft_bounded meshes;
    float map[12][DAFT_VL], low[3][DAFT_VL], high[3][DAFT_VL];
    for (int i = 0; i < DAFT_VL; i++) {
        const daft_affine *frame = &instances[i].to_frame;
        for (int k = 0; k < 9; k++) map[k][i] = frame->m[k];
        for (int k = 0; k < 3; k++) map[9 + k][i] = frame->t[k];
    }
    daft_bounded_read(instances, &meshes);
    daft_bound_lanes(&meshes, map, low, high);
    for (int i = 0; i < DAFT_VL; i++) {
        instances[i].low = daft_v3(low[0][i], low[1][i], low[2][i]);
        instances[i].high = daft_v3(high[0][i], high[1][i], high[2][i]);
    }
}

void DAFT_KERNEL(daft_bound_all)(daft_instance *instances, uint32_t count)
{
    for (uint32_t i = 0, some; i < count; i += some) {
        for (some = 0; some < DAFT_VL && i + some < count && instances[i + some].mesh && instances[i + some].bvh;)
            some++;
        if (some == DAFT_VL)
            bound_group(&instances[i]);
        else
            daft_instance_bound(&instances[i]), some = 1;
    }
}
