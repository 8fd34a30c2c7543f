/* A mesh for benchmarks: a leaning frame of beams, long thin triangles across the axes. */
#include "scenes.h"

#include "math/trig.h"

#include <string.h>

/* Beams along three axes that are at right angles, 1.2 by 1 by 1 m: tubes whose triangles are a hundred times as long as
 * wide, as tools for construction make them. */
enum { LONG = 24, CROSS = 8, BEAMS = LONG * LONG + 2 * LONG * CROSS, SIDES = 16, PIECES = 8, RINGS = PIECES + 1 };
static const double RADIUS = 0.004;

typedef struct heap {
    daft_vec3 *positions;
    uint32_t *indices;
    uint32_t beams;
} heap;

/* A tube around an axis of the frame, `turn` being its axes in columns. */
static void add_beam(heap *to, const double turn[9], const double middle[3], int axis, double length)
{
    uint32_t first = to->beams * RINGS * SIDES, next = to->beams * PIECES * SIDES * 6;
    for (uint32_t i = 0; i < RINGS * SIDES; i++) {
        double angle = 2 * DAFT_PI * (i % SIDES) / SIDES, p[3] = {middle[0], middle[1], middle[2]};
        p[axis] += length * ((double)(i / SIDES) / PIECES - 0.5);
        p[(axis + 1) % 3] += RADIUS * daft_cos(angle), p[(axis + 2) % 3] += RADIUS * daft_sin(angle);
        float q[3];
        for (int k = 0; k < 3; k++) q[k] = (float)(turn[3 * k] * p[0] + turn[3 * k + 1] * p[1] + turn[3 * k + 2] * p[2]);
        to->positions[first + i] = daft_v3(q[0], q[1], q[2]);
    }
    for (uint32_t i = 0; i < PIECES * SIDES; i++) {
        uint32_t a = first + i, b = first + i / SIDES * SIDES + (i + 1) % SIDES;
        const uint32_t corners[6] = {a, b, b + SIDES, a, b + SIDES, a + SIDES};
        memcpy(to->indices + next + 6 * i, corners, sizeof corners);
    }
    to->beams++;
}

bool bench_beams_make(bench *self, daft_trimesh *out)
{
    heap all = {.positions = daft_alloc(&self->allocator, BEAMS * RINGS * SIDES, sizeof(daft_vec3)),
                .indices = daft_alloc(&self->allocator, BEAMS * PIECES * SIDES * 6, sizeof(uint32_t))};
    double turn[9], spacing = 1.0 / LONG;
    daft_quat_matrix(daft_quat_normalize((daft_quat){0.18f, 0.35f, 0.42f, 0.82f}), turn);
    for (int i = 0; all.positions && all.indices && i < LONG * LONG; i++) {
        double y = (i % LONG + 0.5) * spacing - 0.5, z = ((double)(i / LONG) + 0.5) * spacing - 0.5;
        add_beam(&all, turn, (double[3]){0, y, z}, 0, 1.2);
        if (i / LONG >= CROSS) continue;
        double x = 1.2 * ((i / LONG + 0.5) / CROSS - 0.5);
        add_beam(&all, turn, (double[3]){x, 0, y + 0.5 * spacing}, 1, 1);
        add_beam(&all, turn, (double[3]){x + 0.01, y + 0.5 * spacing, 0}, 2, 1);
    }
    daft_mesh_def def = daft_default_mesh_def();
    daft_log log = {0};
    def.positions = all.positions, def.vertex_count = BEAMS * RINGS * SIDES;
    def.indices = all.indices, def.triangle_count = BEAMS * PIECES * SIDES * 2;
    bool made = all.positions && all.indices && daft_trimesh_from_arrays(&self->allocator, &def, &log, out, NULL);
    daft_release(&self->allocator, all.positions);
    daft_release(&self->allocator, all.indices);
    return made;
}
