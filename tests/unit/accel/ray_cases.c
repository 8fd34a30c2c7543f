/* Runs hard rays from a CSV file, whose answers were decided with exact rational arithmetic, through every kernel that
 * applies and on every instruction set: ray_cases FILE.csv. Single rays take the BVH and the kd-tree, and the BVH in
 * packets and streams, too. The camera's pencil and its reference path apply where a picture of one pixel can be that
 * ray without rounding: see ask_pencil. Ends with the line `N passed, M failed`; exit status 1 if any failed, 2 for
 * wrong usage. The format is that of a file with the columns
 *   id,category,kind,group,mesh,g0..g8,ox,oy,oz,dx,dy,dz,tmin,tmax,expect,must,where,t,…
 * kind tri | sphere | aabb | mesh; numbers as strtof reads them, hex floats among them; mesh files are beside the CSV.
 *
 * What is ours to choose (must = policy): triangles are closed, so their edges and corners are hit; one without area,
 * or seen exactly edge-on, is missed; tmin and tmax belong to the interval; a tangent sphere is hit; a radius of 0 or
 * less and a direction of zero are missed. Such rows pass when all kernels agree and no hit holds a NaN. A group, the
 * triangles around an edge or a vertex, passes when some triangle is hit, and at most one by daft_line_hits, which
 * counts crossings. */
#include "accel/bvh.h"
#include "geometry/mesh.h"
#include "math/exact.h"
#include "math/simd/dispatch.h"
#include "raster/raster.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_COLUMNS = 64, MAX_LINE = 8192, MAX_GROUPS = 4096 };

typedef struct row {
    char line[MAX_LINE];
    char *field[MAX_COLUMNS];
    int count;
} row;

typedef struct table {
    char folder[1024];
    row header;
    int passed, failed, by_pencil;
    struct {
        char name[64];
        int rows, hits, crossed;
        daft_vec3 seen[16]; /* sums of corners: some files list a triangle twice */
        int seen_count;
    } groups[MAX_GROUPS]; /* a fan's rows need not stand together */
    int group_count;
} table;

/* Splits in place at commas; a field may be in double quotes, "" inside them stands for one. */
static void split(row *r)
{
    char *in = r->line;
    r->count = 0;
    while (r->count < MAX_COLUMNS) {
        char *out = in;
        r->field[r->count++] = out;
        bool quoted = *in == '"';
        if (quoted) in++;
        while (*in && (quoted || (*in != ',' && *in != '\n' && *in != '\r'))) {
            if (quoted && *in == '"' && *++in != '"')
                quoted = false;
            else
                *out++ = *in++;
        }
        char end = *in;
        *out = 0;
        if (end != ',') return;
        in++;
    }
}

static const char *text(const table *t, const row *r, const char *name)
{
    for (int i = 0; i < t->header.count && i < r->count; i++)
        if (strcmp(t->header.field[i], name) == 0) return r->field[i];
    return "";
}

static float number(const table *t, const row *r, const char *name) { return strtof(text(t, r, name), NULL); }

static daft_vec3 vector(const table *t, const row *r, const char *x, const char *y, const char *z)
{
    return daft_v3(number(t, r, x), number(t, r, y), number(t, r, z));
}

/* ---- targets ---- */

typedef struct target {
    daft_trimesh mesh;
    daft_bvh *bvh;
    daft_kdtree *kdtree;
    daft_instance instance;
    daft_arena arena;
    const daft_tlas *tlas;
    daft_allocator allocator;
} target;

static const uint32_t MATERIAL[1] = {0};

static bool target_finish(target *s)
{
    daft_error error;
    const float *t = s->instance.to_frame.t;
    s->instance.to_frame = s->instance.to_object = (daft_affine){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {t[0], t[1], t[2]}};
    s->instance.materials = MATERIAL, s->instance.flags = DAFT_INSTANCE_CASTS_SHADOW;
    daft_instance_bound(&s->instance);
    daft_arena_init(&s->arena, &s->allocator);
    s->tlas = daft_tlas_build(&s->arena, &s->instance, 1, &error);
    return s->tlas != NULL;
}

static bool target_mesh(target *s)
{
    s->bvh = daft_bvh_build_mesh(&s->allocator, &s->mesh, 1, NULL);
    s->kdtree = daft_kdtree_build(&s->allocator, &s->mesh, 1, NULL);
    s->instance.mesh = &s->mesh, s->instance.bvh = s->bvh;
    return s->bvh && s->kdtree && target_finish(s);
}

/* Through the door that users have: what is not finite is dropped there. */
static bool target_triangle(target *s, const table *t, const row *r)
{
    const daft_vec3 p[3] = {vector(t, r, "g0", "g1", "g2"), vector(t, r, "g3", "g4", "g5"),
                            vector(t, r, "g6", "g7", "g8")};
    const uint32_t index[3] = {0, 1, 2};
    daft_mesh_def def = {
        .cookie = DAFT_COOKIE, .positions = p, .vertex_count = 3, .indices = index, .triangle_count = 1};
    return daft_trimesh_from_arrays(&s->allocator, &def, NULL, &s->mesh, NULL) && target_mesh(s);
}

static bool target_file(target *s, const table *t, const row *r)
{
    char path[2048];
    daft_obj obj;
    daft_error error = {0};
    snprintf(path, sizeof path, "%s%s", t->folder, text(t, r, "mesh"));
    if (!daft_obj_load(&s->allocator, NULL, path, NULL, &obj, &error)) {
        fprintf(stderr, "%s: %s\n", path, error.message);
        return false;
    }
    s->mesh = obj.mesh;
    memset(&obj.mesh, 0, sizeof obj.mesh);
    daft_obj_free(&s->allocator, &obj);
    return target_mesh(s);
}

static void target_drop(target *s)
{
    daft_arena_free(&s->arena);
    daft_bvh_free(s->bvh);
    if (s->kdtree) daft_kdtree_free(s->kdtree);
    daft_trimesh_free(&s->allocator, &s->mesh);
}

/* ---- answers ---- */

typedef struct answer {
    bool hit;
    float t;
    bool agree; /* all kernels and instruction sets */
} answer;

/* The ray in fifteen lanes, one with a neighbour that goes elsewhere; and as a stream. */
static bool agrees_in_company(const target *s, const daft_ray *ray, const daft_accel_kernels *k,
                              const daft_hit *expected)
{
    bool found = expected->instance != UINT32_MAX, same = true;
    daft_ray_packet packet;
    daft_ray rays[DAFT_PACKET], elsewhere = *ray;
    daft_hit hits[DAFT_PACKET];
    elsewhere.direction = daft_v3(-ray->direction.y, ray->direction.z, ray->direction.x);
    for (uint32_t i = 0; i < DAFT_PACKET; i++)
        rays[i] = i == 5 ? elsewhere : *ray, daft_ray_packet_set(&packet, i, &rays[i]);
    const uint32_t others = 0xffff & ~(1u << 5), stopped = k->occluded_packet(s->tlas, &packet, 0xffff);
    same &= (k->closest_packet(s->tlas, &packet, 0xffff, UINT32_MAX, hits) & others) == (found ? others : 0);
    same &= (stopped & others) == (found ? others : 0);
    for (uint32_t i = 0; i < DAFT_PACKET; i++) same &= i == 5 || memcmp(&hits[i], expected, sizeof hits[i]) == 0;
    uint32_t dark;
    k->closest_stream(s->tlas, rays, 4, UINT32_MAX, hits);
    k->occluded_stream(s->tlas, rays, 4, &dark);
    for (uint32_t i = 0; i < 4; i++)
        same &= memcmp(&hits[i], expected, sizeof hits[i]) == 0 && (dark >> i & 1) == found;
    return same;
}

static answer ask(target *s, const daft_ray *ray)
{
    answer out = {.agree = true};
    int ways = daft_isa_best() + 1;
    for (int way = 0; way < (s->kdtree ? 2 * ways : ways); way++) {
        int isa = way % ways;
        s->instance.kdtree = way < ways ? NULL : s->kdtree;
        daft_hit hit;
        bool found = daft_accel_kernels_for(isa)->closest(s->tlas, ray, UINT32_MAX, &hit);
        bool stopped = daft_accel_kernels_for(isa)->occluded(s->tlas, ray);
        bool sound = !found || (!isnan(hit.t) && isfinite(hit.u) && isfinite(hit.v) && !isnan(hit.normal.x));
        out.agree &= sound && stopped == found && (way == 0 || (found == out.hit && (!found || hit.t == out.t)));
        out.agree &= agrees_in_company(s, ray, daft_accel_kernels_for(isa), &hit);
        out.hit = found, out.t = found ? hit.t : 0;
    }
    s->instance.kdtree = NULL;
    return out;
}

/* ---- the pencil ---- */

static bool exact_difference(float a, float b) { return (double)(a - b) == (double)a - (double)b && isfinite(a - b); }

/* The target as a camera at the ray's origin has it. False: some coordinate would be rounded. */
static bool move_to_eye(const target *s, daft_vec3 o, daft_instance *out)
{
    const float eye[3] = {o.x, o.y, o.z};
    *out = s->instance;
    for (int k = 0; k < 3; k++) {
        if (!s->instance.mesh && !exact_difference(s->instance.to_frame.t[k], eye[k])) return false;
        out->to_frame.t[k] -= eye[k];
        out->to_object.t[k] = s->instance.mesh ? eye[k] : -out->to_frame.t[k];
    }
    for (uint32_t i = 0; s->instance.mesh && i < s->mesh.vertex_count; i++)
        if (!exact_difference(s->mesh.x[i], o.x) || !exact_difference(s->mesh.y[i], o.y) ||
            !exact_difference(s->mesh.z[i], o.z))
            return false;
    daft_instance_bound(out);
    return true;
}

/* A picture of one pixel whose ray is d: forward is the axis along which d is longest, d over a power of two there, and
 * the shift of the sample is the rest. False: the direction underflows. */
static bool pencil_along(daft_vec3 d, daft_pencil *out)
{
    const daft_vec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    float c[3] = {d.x, d.y, d.z};
    int k = fabsf(c[0]) >= fabsf(c[1]) ? 0 : 1, exponent;
    if (fabsf(c[2]) > fabsf(c[k])) k = 2;
    if (!(fabsf(c[k]) > 0) || !isfinite(c[k])) return false;
    frexpf(c[k], &exponent);
    for (int i = 0; i < 3; i++) {
        float scaled = ldexpf(c[i], -1 - exponent);
        if (ldexpf(scaled, 1 + exponent) != c[i]) return false;
        c[i] = scaled;
    }
    *out = (daft_pencil){
        .right = axis[(k + 1) % 3], .up = axis[(k + 2) % 3], .focal = fabsf(c[k]), .width = 1, .height = 1};
    out->forward = c[k] > 0 ? axis[k] : daft_neg(axis[k]);
    out->shift_x = c[(k + 1) % 3], out->shift_y = c[(k + 2) % 3];
    return true;
}

/* What the pencil and its reference see: 1 the target, 0 nothing, -1 they do not agree, -2 it does not apply. */
static int ask_pencil(const target *s, const daft_ray *ray)
{
    daft_instance instance;
    daft_pencil pencil;
    daft_raster raster;
    daft_error error;
    static daft_tile tile;
    if (!(ray->tmin == 0) || !isinf(ray->tmax) || !daft_finite3(ray->origin) || !daft_finite3(ray->direction))
        return -2;
    if (!move_to_eye(s, ray->origin, &instance) || !pencil_along(ray->direction, &pencil)) return -2;
    daft_arena arena;
    daft_arena_init(&arena, &s->allocator);
    const daft_tlas *tlas = daft_tlas_build(&arena, &instance, 1, &error);
    int seen = -2;
    if (tlas && daft_raster_init(&raster, &s->allocator, 1, daft_isa_best(), &error)) {
        if (daft_raster_begin(&raster, &pencil, &instance, 1, &error)) {
            for (uint32_t i = 0; i < raster.work_count; i++) daft_raster_bin(&raster, i, 0);
            daft_reference_tile(&raster, tlas, 0, NULL, &tile);
            seen = tile.instance[0] != DAFT_NOTHING;
            for (int isa = 0; isa <= daft_isa_best(); isa++) {
                daft_raster_kernels_for(isa)->tile(&raster, 0, 0, NULL, &tile);
                if (seen != (tile.instance[0] != DAFT_NOTHING)) seen = -1;
            }
        }
        daft_raster_free(&raster);
    }
    daft_arena_free(&arena);
    return seen;
}

/* Rows that say how it is within triangles or clearly outside: through an edge, a pencil's ray belongs to one triangle
 * alone, and the row may be about another. */
static bool pencil_is_right(table *t, const row *r, const target *s, const daft_ray *ray)
{
    const char *must = text(t, r, "must"), *least = text(t, r, "minbary"), *kind = text(t, r, "kind");
    bool expect = strcmp(text(t, r, "expect"), "hit") == 0;
    if (strcmp(must, "exact") != 0 && strcmp(must, "f64") != 0 && strcmp(must, "meshhit") != 0) return true;
    if (expect && strcmp(kind, "tri") == 0 && !(strtod(least, NULL) > 0)) return true;
    int seen = ask_pencil(s, ray);
    t->by_pencil += seen >= -1;
    return seen == -2 || seen == expect;
}

static daft_ray ray_of(const table *t, const row *r)
{
    return (daft_ray){.origin = vector(t, r, "ox", "oy", "oz"),
                      .direction = vector(t, r, "dx", "dy", "dz"),
                      .tmin = number(t, r, "tmin"),
                      .tmax = number(t, r, "tmax")};
}

static void verdict(table *t, const row *r, bool pass, const char *why)
{
    if (pass) {
        t->passed++;
        return;
    }
    t->failed++;
    printf("FAILED %s (%s %s, expect %s): %s\n", text(t, r, "id"), text(t, r, "kind"), text(t, r, "must"),
           text(t, r, "expect"), why);
}

static bool near_enough(const table *t, const row *r, float found, double tolerance)
{
    const char *expected = text(t, r, "t");
    if (isinf(found)) return strtod(expected, NULL) > 3.4e38; /* further than floats reach */
    return !*expected ||
           fabs((double)found - strtod(expected, NULL)) <= tolerance * fmax(1e-30, fabs(strtod(expected, NULL)));
}

static void judge(table *t, const row *r, answer a)
{
    const char *must = text(t, r, "must");
    bool expect = strcmp(text(t, r, "expect"), "hit") == 0;
    if (!a.agree)
        verdict(t, r, false, "the kernels do not agree, or a hit holds a NaN");
    else if (strcmp(must, "policy") == 0)
        verdict(t, r, true, "");
    else if (a.hit != expect)
        verdict(t, r, false, a.hit ? "hit" : "missed");
    else
        verdict(t, r, !a.hit || near_enough(t, r, a.t, 1e-3), "the distance is off");
}

static bool seen_before(table *t, int group, daft_vec3 sum)
{
    for (int i = 0; i < t->groups[group].seen_count; i++)
        if (memcmp(&t->groups[group].seen[i], &sum, sizeof sum) == 0) return true;
    if (t->groups[group].seen_count < 16) t->groups[group].seen[t->groups[group].seen_count++] = sum;
    return false;
}

static void group_add(table *t, const row *r, const daft_ray *ray, bool hit)
{
    const char *name = text(t, r, "group");
    int i = 0;
    while (i < t->group_count && strcmp(t->groups[i].name, name) != 0) i++;
    if (i == MAX_GROUPS) return;
    if (i == t->group_count) snprintf(t->groups[t->group_count++].name, sizeof t->groups[i].name, "%s", name);
    t->groups[i].rows++, t->groups[i].hits += hit;
    daft_vec3 a = vector(t, r, "g0", "g1", "g2"), b = vector(t, r, "g3", "g4", "g5"),
              c = vector(t, r, "g6", "g7", "g8");
    if (seen_before(t, i, daft_add(a, daft_add(b, c)))) return;
    t->groups[i].crossed += daft_line_hits(ray->origin, a, b, c, ray->direction);
}

/* A fan's rows pass together. */
static void judge_groups(table *t)
{
    for (int i = 0; i < t->group_count; i++) {
        if (t->groups[i].hits >= 1 && t->groups[i].crossed <= 1) {
            t->passed += t->groups[i].rows;
            continue;
        }
        t->failed += t->groups[i].rows;
        printf("FAILED group %s: %d triangles of the fan are hit, %d crossed\n", t->groups[i].name, t->groups[i].hits,
               t->groups[i].crossed);
    }
}

static void run_triangle(table *t, const row *r)
{
    target s = {.allocator = daft_malloc_allocator()};
    if (!target_triangle(&s, t, r)) {
        verdict(t, r, false, "cannot be built");
        return;
    }
    daft_ray ray = ray_of(t, r);
    answer a = ask(&s, &ray);
    if (a.agree && strcmp(text(t, r, "must"), "group") == 0)
        group_add(t, r, &ray, a.hit);
    else if (!pencil_is_right(t, r, &s, &ray))
        verdict(t, r, false, "the pencil says otherwise");
    else
        judge(t, r, a);
    target_drop(&s);
}

static void run_mesh(table *t, const row *r)
{
    target s = {.allocator = daft_malloc_allocator()};
    if (!target_file(&s, t, r)) {
        verdict(t, r, false, "cannot be loaded");
        return;
    }
    daft_ray ray = ray_of(t, r);
    answer a = ask(&s, &ray);
    uint32_t crossings = 0;
    for (uint32_t i = 0; i < s.mesh.triangle_count; i++) {
        daft_vec3 p[3];
        for (int k = 0; k < 3; k++) {
            uint32_t v = s.mesh.indices[3 * i + (uint32_t)k];
            p[k] = daft_v3(s.mesh.x[v], s.mesh.y[v], s.mesh.z[v]);
        }
        double w[3], along = 0;
        if (!daft_line_hits(ray.origin, p[0], p[1], p[2], ray.direction)) continue;
        daft_dvec3 q[3];
        for (int k = 0; k < 3; k++) q[k] = daft_dsub(daft_to_double(p[k]), daft_to_double(ray.origin));
        daft_pencil_weights(q[0], q[1], q[2], ray.direction, w);
        for (int k = 0; k < 3; k++) along += w[k] * daft_ddot(q[k], daft_to_double(ray.direction));
        crossings += along > 0;
    }
    if (crossings % 2 == 0)
        verdict(t, r, false, "an even number of crossings");
    else if (!pencil_is_right(t, r, &s, &ray))
        verdict(t, r, false, "the pencil says otherwise");
    else
        judge(t, r, a);
    target_drop(&s);
}

static void run_sphere(table *t, const row *r)
{
    target s = {.allocator = daft_malloc_allocator()};
    daft_vec3 centre = vector(t, r, "g0", "g1", "g2");
    s.instance.to_frame.t[0] = centre.x, s.instance.to_frame.t[1] = centre.y, s.instance.to_frame.t[2] = centre.z;
    s.instance.radius = number(t, r, "g3");
    daft_ray ray = ray_of(t, r);
    if (!target_finish(&s))
        verdict(t, r, false, "cannot be built");
    else if (!pencil_is_right(t, r, &s, &ray))
        verdict(t, r, false, "the pencil says otherwise");
    else
        judge(t, r, ask(&s, &ray));
    target_drop(&s);
}

static void run_box(table *t, const row *r)
{
    daft_node node;
    daft_vec3 low = vector(t, r, "g0", "g1", "g2"), high = vector(t, r, "g3", "g4", "g5");
    const float bounds[6] = {low.x, low.y, low.z, high.x, high.y, high.z};
    for (int k = 0; k < 6; k++)
        for (int i = 0; i < DAFT_WIDTH; i++) node.bounds[k][i] = bounds[k];
    daft_ray ray = ray_of(t, r);
    bool expect = strcmp(text(t, r, "expect"), "hit") == 0, agree = true, hit = false;
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        uint32_t bits = daft_accel_kernels_for(isa)->boxes(&node, &ray);
        agree &= (bits == 0 || bits == 0xff) && (isa == 0 || hit == (bits != 0));
        hit = bits != 0;
    }
    if (!agree)
        verdict(t, r, false, "the kernels do not agree");
    else if (strcmp(text(t, r, "must"), "culls") == 0)
        verdict(t, r, true, "");
    else
        verdict(t, r, hit == expect, hit ? "hit" : "missed");
}

static void run_row(table *t, const row *r)
{
    const char *kind = text(t, r, "kind");
    if (strcmp(kind, "tri") == 0)
        run_triangle(t, r);
    else if (strcmp(kind, "sphere") == 0)
        run_sphere(t, r);
    else if (strcmp(kind, "aabb") == 0)
        run_box(t, r);
    else if (strcmp(kind, "mesh") == 0)
        run_mesh(t, r);
    else
        verdict(t, r, false, "unknown kind");
}

int main(int argc, char **argv)
{
    static table t;
    static row r;
    if (argc != 2) {
        fprintf(stderr, "usage: ray_cases FILE.csv\n");
        return 2;
    }
    FILE *file = fopen(argv[1], "r");
    if (!file || !fgets(t.header.line, sizeof t.header.line, file)) {
        fprintf(stderr, "%s: cannot be read\n", argv[1]);
        return 1;
    }
    split(&t.header);
    const char *slash = strrchr(argv[1], '/');
    snprintf(t.folder, sizeof t.folder, "%.*s", slash ? (int)(slash - argv[1]) + 1 : 0, argv[1]);
    while (fgets(r.line, sizeof r.line, file)) {
        if (isspace((unsigned char)r.line[0])) continue;
        split(&r);
        run_row(&t, &r);
    }
    judge_groups(&t);
    fclose(file);
    printf("%d of the rows went through the camera's pencil as well\n", t.by_pencil);
    printf("%d passed, %d failed\n", t.passed, t.failed);
    return t.failed ? 1 : 0;
}
