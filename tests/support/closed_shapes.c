/* Closed meshes and hard rays from inside them. */
#include "closed_shapes.h"

#include "math/exact.h"
#include "math/trig.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- random numbers ---- */

/* SplitMix64's mixing: neighbouring seeds and streams give unrelated states. */
uint64_t hard_state(uint64_t seed, uint64_t stream)
{
    uint64_t x = seed + 0x9e3779b97f4a7c15u * (stream + 1);
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

uint32_t hard_bits(uint64_t *state)
{
    *state += 0x9e3779b97f4a7c15u;
    uint64_t x = *state;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return (uint32_t)(x >> 32);
}

float hard_float(uint64_t *state, float low, float high)
{
    return low + (high - low) * ((float)(hard_bits(state) >> 8) * 0x1p-24f);
}

daft_vec3 hard_vec3(uint64_t *state, float low, float high)
{
    float x = hard_float(state, low, high), y = hard_float(state, low, high);
    return daft_v3(x, y, hard_float(state, low, high));
}

/* ---- generated shapes ---- */

typedef struct arrays {
    daft_vec3 *p;
    uint32_t *index;
    uint32_t vertices, triangles;
} arrays;

static void add_triangle(arrays *a, uint32_t i, uint32_t j, uint32_t k)
{
    const uint32_t corners[3] = {i, j, k};
    memcpy(a->index + 3 * a->triangles++, corners, sizeof corners);
}

static void add_quad(arrays *a, uint32_t i, uint32_t j, uint32_t k, uint32_t l)
{
    add_triangle(a, i, j, k);
    add_triangle(a, j, l, k);
}

static bool arrays_make(arrays *a, uint32_t vertices, uint32_t triangles)
{
    *a = (arrays){.p = malloc(vertices * sizeof *a->p),
                  .index = malloc(3 * (size_t)triangles * sizeof *a->index),
                  .vertices = vertices};
    return a->p && a->index;
}

static bool arrays_finish(const daft_allocator *allocator, arrays *a, daft_vec3 stretch, daft_trimesh *out)
{
    bool made = a->p && a->index;
    for (uint32_t i = 0; made && i < a->vertices; i++) a->p[i] = daft_mul(a->p[i], stretch);
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = a->p, def.vertex_count = a->vertices, def.indices = a->index, def.triangle_count = a->triangles;
    made = made && daft_trimesh_from_arrays(allocator, &def, NULL, out, NULL);
    free(a->p);
    free(a->index);
    return made;
}

/* Rings of `columns` vertices between two poles; one ring is a double cone. */
static void make_ball(arrays *a, uint32_t rings, uint32_t columns, float bump, uint64_t *state)
{
    if (!arrays_make(a, rings * columns + 2, 2 * rings * columns)) return;
    for (uint32_t i = 0; i < rings; i++) {
        double latitude = DAFT_PI * ((i + 1.0) / (rings + 1.0) - 0.5);
        for (uint32_t j = 0; j < columns; j++) {
            double longitude = 2 * DAFT_PI * j / columns, r = 1 + (double)(bump * hard_float(state, -1, 1));
            a->p[i * columns + j] =
                daft_v3((float)(r * daft_cos(latitude) * daft_cos(longitude)), (float)(r * daft_sin(latitude)),
                        (float)(r * daft_cos(latitude) * daft_sin(longitude)));
        }
    }
    uint32_t south = rings * columns, north = south + 1, last = (rings - 1) * columns;
    a->p[south] = daft_v3(0, -1, 0), a->p[north] = daft_v3(0, 1, 0);
    for (uint32_t j = 0; j < columns; j++) {
        uint32_t k = (j + 1) % columns;
        add_triangle(a, south, j, k);
        add_triangle(a, north, last + k, last + j);
        for (uint32_t i = 0; i + 1 < rings; i++)
            add_quad(a, i * columns + j, (i + 1) * columns + j, i * columns + k, (i + 1) * columns + k);
    }
}

static void make_torus(arrays *a, uint32_t rows, uint32_t columns)
{
    if (!arrays_make(a, rows * columns, 2 * rows * columns)) return;
    for (uint32_t i = 0; i < rows; i++)
        for (uint32_t j = 0; j < columns; j++) {
            double u = 2 * DAFT_PI * i / rows, v = 2 * DAFT_PI * j / columns, r = 1 + 0.4 * daft_cos(v);
            a->p[i * columns + j] =
                daft_v3((float)(r * daft_cos(u)), (float)(0.4 * daft_sin(v)), (float)(r * daft_sin(u)));
            uint32_t next = (i + 1) % rows, beside = (j + 1) % columns;
            add_quad(a, i * columns + j, i * columns + beside, next * columns + j, next * columns + beside);
        }
}

/* n by n by n cells, corners at whole numbers from -n to n in steps of 2: rays between whole numbers meet edges
 * exactly. */
static void make_box(arrays *a, uint32_t n)
{
    const uint32_t m = n + 1, step[3] = {1, m, m * m};
    if (!arrays_make(a, m * m * m, 12 * n * n)) return;
    for (uint32_t i = 0; i < m * m * m; i++)
        a->p[i] = daft_v3(2 * (float)(i % m) - (float)n, 2 * (float)(i / m % m) - (float)n,
                          2 * (float)(i / (m * m)) - (float)n);
    for (uint32_t side = 0; side < 6; side++) {
        uint32_t k = side / 2, u = step[(k + 1) % 3], v = step[(k + 2) % 3], base = side % 2 ? n * step[k] : 0;
        for (uint32_t i = 0; i < n * n; i++) {
            uint32_t at = base + i % n * u + i / n * v;
            add_quad(a, at, at + u, at + v, at + u + v);
        }
    }
}

bool closed_shape_make(const daft_allocator *allocator, int kind, uint64_t *state, closed_shape *out)
{
    static const char *const NAMES[CLOSED_KINDS] = {"ball",  "bumpy ball", "grid box", "block",
                                                    "torus", "cone",       "needle",   "slab"};
    arrays a = {0};
    daft_vec3 stretch = {1, 1, 1};
    uint32_t detail = 5 + hard_bits(state) % 20;
    if (kind == 0) make_ball(&a, detail, 2 * detail, 0, state);
    if (kind == 1) make_ball(&a, detail, 2 * detail, 0.2f, state);
    if (kind == 2) make_box(&a, 2 + detail / 2);
    if (kind == 3) make_box(&a, 1);
    if (kind == 4) make_torus(&a, 2 * detail, detail);
    if (kind == 5) make_ball(&a, 1, 40 * detail, 0.3f, state);
    if (kind == 6) make_ball(&a, detail, 2 * detail, 0.2f, state), stretch = daft_v3(1e3f, 1e-3f, 1e-3f);
    if (kind == 7) make_box(&a, detail), stretch = daft_v3(1, 1e-6f, 1);
    snprintf(out->name, sizeof out->name, "%s", NAMES[kind]);
    return arrays_finish(allocator, &a, stretch, &out->mesh);
}

/* ---- files ---- */

static const char *folder(const char *variable, const char *fallback)
{
    const char *value = getenv(variable);
    return value && value[0] ? value : fallback;
}

const char *hard_cases_folder(void) { return folder("DAFT_CASES", DAFT_ROOT "/tests/data/cases"); }

bool closed_shape_load(const daft_allocator *allocator, int file, closed_shape *out)
{
    static const char *const FILES[CLOSED_FILES] = {"meshes/cube.obj",
                                                    "meshes/cube_embreepos.obj",
                                                    "meshes/cube_far1e7.obj",
                                                    "meshes/cube_tiny1e-6.obj",
                                                    "meshes/needle_1e6.obj",
                                                    "meshes/octa.obj",
                                                    "meshes/slab_1e-6.obj",
                                                    "meshes/uvsphere16.obj",
                                                    "meshes/uvsphere_bumpy.obj",
                                                    "meshes/uvsphere_embreepos.obj",
                                                    "models/cow.obj",
                                                    "models/fandisk.obj",
                                                    "models/spot/spot_triangulated.obj",
                                                    "models/stanford-bunny.obj",
                                                    "models/nefertiti.obj"};
    char path[1024];
    daft_obj obj;
    bool model = strncmp(FILES[file], "models/", 7) == 0;
    snprintf(path, sizeof path, "%s/%s", model ? folder("DAFT_DATA", DAFT_ROOT "/../shared/data") : hard_cases_folder(),
             FILES[file]);
    if (!daft_file_exists(NULL, path) || !daft_obj_load(allocator, NULL, path, NULL, &obj, NULL)) return false;
    const char *name = strrchr(FILES[file], '/') + 1;
    snprintf(out->name, sizeof out->name, "%.*s", (int)strcspn(name, "."), name);
    out->mesh = obj.mesh;
    memset(&obj.mesh, 0, sizeof obj.mesh);
    daft_obj_free(allocator, &obj);
    if (closed_mesh(allocator, &out->mesh)) return true;
    closed_shape_free(allocator, out);
    return false;
}

void closed_shape_free(const daft_allocator *allocator, closed_shape *shape)
{
    daft_trimesh_free(allocator, &shape->mesh);
}

/* ---- closed or not ---- */

daft_vec3 mesh_vertex(const daft_trimesh *mesh, uint32_t vertex)
{
    return daft_v3(mesh->x[vertex], mesh->y[vertex], mesh->z[vertex]);
}

daft_vec3 mesh_corner(const daft_trimesh *mesh, uint32_t triangle, uint32_t corner)
{
    return mesh_vertex(mesh, mesh->indices[3 * (size_t)triangle + corner]);
}

typedef struct edge {
    daft_vec3 low, high;
} edge;

static int order(daft_vec3 a, daft_vec3 b)
{
    if (a.x != b.x) return a.x < b.x ? -1 : 1;
    if (a.y != b.y) return a.y < b.y ? -1 : 1;
    return (a.z > b.z) - (a.z < b.z);
}

static int by_place(const void *x, const void *y)
{
    const edge *a = x, *b = y;
    int low = order(a->low, b->low);
    return low ? low : order(a->high, b->high);
}

bool closed_mesh(const daft_allocator *allocator, const daft_trimesh *mesh)
{
    size_t count = 3 * (size_t)mesh->triangle_count, run = 1;
    edge *edges = daft_alloc(allocator, count, sizeof *edges);
    if (!edges || count == 0) return daft_release(allocator, edges), false;
    for (size_t i = 0; i < count; i++) {
        uint32_t t = (uint32_t)(i / 3), k = (uint32_t)(i % 3);
        daft_vec3 a = mesh_corner(mesh, t, k), b = mesh_corner(mesh, t, (k + 1) % 3);
        edges[i] = order(a, b) < 0 ? (edge){a, b} : (edge){b, a};
    }
    qsort(edges, count, sizeof *edges, by_place);
    bool closed = true;
    for (size_t i = 1; i <= count; i++) {
        bool same = i < count && by_place(&edges[i - 1], &edges[i]) == 0;
        closed &= same || run % 2 == 0;
        run = same ? run + 1 : 1;
    }
    daft_release(allocator, edges);
    return closed;
}

/* ---- points and rays ---- */

/* The sign of the distance along d at which the line through o meets the plane of a triangle that it crosses; 0 where
 * double cannot tell. The sides have the sign of t·det(p, q, r). */
static int forward(daft_vec3 o, const daft_vec3 c[3], daft_vec3 d)
{
    daft_dvec3 p[3], origin = daft_to_double(o);
    for (int k = 0; k < 3; k++) p[k] = daft_dsub(daft_to_double(c[k]), origin);
    daft_dvec3 n = daft_dcross(daft_dsub(p[1], p[0]), daft_dsub(p[2], p[0])), m = daft_to_double(d);
    double size = 0;
    for (int k = 0; k < 3; k++) size = fmax(size, fmax(fabs(p[k].x), fmax(fabs(p[k].y), fabs(p[k].z))));
    double height = daft_ddot(n, p[0]), slope = daft_ddot(n, m), length = fabs(m.x) + fabs(m.y) + fabs(m.z);
    if (fabs(height) <= 0x1p-46 * size * size * size || fabs(slope) <= 0x1p-46 * size * size * length) return 0;
    return (height > 0) == (slope > 0) ? 1 : -1;
}

int exact_crossings(const daft_trimesh *mesh, daft_vec3 origin, daft_vec3 direction)
{
    int before = 0, after = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const daft_vec3 c[3] = {mesh_corner(mesh, i, 0), mesh_corner(mesh, i, 1), mesh_corner(mesh, i, 2)};
        if (!daft_line_hits(origin, c[0], c[1], c[2], direction)) continue;
        int sign = forward(origin, c, direction);
        if (sign == 0) return -1;
        before += sign<0, after += sign> 0;
    }
    return (before + after) % 2 ? -1 : after; /* odd: the origin's own triangle is left out */
}

/* A point of a random triangle, as floats have it. */
static daft_vec3 surface_point(const daft_trimesh *mesh, uint64_t *state)
{
    uint32_t t = hard_bits(state) % mesh->triangle_count;
    float u = hard_float(state, 0, 1), v = hard_float(state, 0, 1 - u);
    daft_vec3 a = mesh_corner(mesh, t, 0), b = mesh_corner(mesh, t, 1), c = mesh_corner(mesh, t, 2);
    return daft_add(a, daft_add(daft_scale(daft_sub(b, a), u), daft_scale(daft_sub(c, a), v)));
}

bool point_inside(const daft_trimesh *mesh, uint64_t *state, daft_vec3 *out)
{
    daft_vec3 size = daft_sub(mesh->high, mesh->low);
    int tries = mesh->triangle_count > 10000 ? 60 : 1000;
    for (int i = 0; i < tries; i++) {
        uint32_t kind = hard_bits(state) % 4;
        daft_vec3 fraction = hard_vec3(state, 0, 1);
        if (kind == 1)
            fraction = daft_v3(floorf(fraction.x * 8) / 8, floorf(fraction.y * 8) / 8, floorf(fraction.z * 8) / 8);
        *out = kind == 2 ? surface_point(mesh, state) : daft_add(mesh->low, daft_mul(size, fraction));
        if (exact_crossings(mesh, *out, hard_vec3(state, -1, 1)) % 2 == 1) return true;
    }
    return false;
}

static float nudge(uint64_t *state, float x)
{
    int steps = (int)(hard_bits(state) % 7) - 3;
    for (; steps > 0; steps--) x = nextafterf(x, INFINITY);
    for (; steps < 0; steps++) x = nextafterf(x, -INFINITY);
    return x;
}

static float sign_of(uint64_t *state) { return (float)((int)(hard_bits(state) % 3) - 1); }

daft_vec3 hard_target(const daft_trimesh *mesh, uint64_t *state, daft_vec3 origin)
{
    uint32_t t = hard_bits(state) % mesh->triangle_count, k = hard_bits(state) % 3, kind = hard_bits(state) % 16;
    daft_vec3 a = mesh_corner(mesh, t, k), b = mesh_corner(mesh, t, (k + 1) % 3), d;
    if (kind == 0) { /* axes and diagonals */
        d = daft_v3(sign_of(state), sign_of(state), sign_of(state));
        return d.x != 0 || d.y != 0 || d.z != 0 ? d : daft_v3(0, 1, 0);
    }
    if (kind == 1) return hard_vec3(state, -1, 1);
    float along = kind < 8 ? 0 : kind < 10 ? 0.5f : hard_float(state, 0, 1);
    d = daft_sub(daft_add(a, daft_scale(daft_sub(b, a), along)), origin);
    if (kind == 2 || kind == 10) d = daft_v3(nudge(state, d.x), nudge(state, d.y), nudge(state, d.z));
    if (kind == 3 || kind == 11) d = daft_scale(d, hard_float(state, 0.5f, 2));
    if (kind == 4) d.x = hard_bits(state) % 2 ? 0 : 1e-20f * hard_float(state, -1, 1);
    if (kind == 12) d = daft_normalize(d);
    return d.x != 0 || d.y != 0 || d.z != 0 ? d : daft_v3(0, 1, 0);
}
