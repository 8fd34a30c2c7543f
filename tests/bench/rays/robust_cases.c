/* The rows of ray_cases.csv, whose answers were decided with exact rational arithmetic, judged by class as its README
 * says. Rows that other libraries cannot answer are left out: boxes, cases decided by convention, NaN
 * and infinity (tests/unit/accel/ray_cases.c runs them all). */
#include "robust.h"

#include "closed_shapes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_COLUMNS = 40, MAX_LINE = 8192, MAX_FANS = 1024 };
enum { EXACT, FANS, INSIDE, ILL, SPHERES };

typedef struct row {
    char line[MAX_LINE];
    char *field[MAX_COLUMNS];
    int count;
} row;

/* Splits in place at commas. Only the last columns, which are not read here, have quotes. */
static void split(row *r)
{
    char *at = r->line;
    at[strcspn(at, "\r\n")] = 0;
    for (r->count = 0; r->count < MAX_COLUMNS && at; r->count++) {
        r->field[r->count] = at;
        at = strchr(at, ',');
        if (at) *at++ = 0;
    }
}

static const char *text(const row *header, const row *r, const char *name)
{
    for (int i = 0; i < header->count && i < r->count; i++)
        if (strcmp(header->field[i], name) == 0) return r->field[i];
    return "";
}

static daft_vec3 vector(const row *header, const row *r, const char *x, const char *y, const char *z)
{
    return daft_v3(strtof(text(header, r, x), NULL), strtof(text(header, r, y), NULL),
                   strtof(text(header, r, z), NULL));
}

static int class_of(const char *kind, const char *must)
{
    bool triangle = strcmp(kind, "tri") == 0;
    if (strcmp(kind, "sphere") == 0) return strcmp(must, "exact") == 0 ? SPHERES : -1;
    if (strcmp(kind, "mesh") == 0) return strcmp(must, "meshhit") == 0 ? INSIDE : -1;
    if (triangle && strcmp(must, "exact") == 0) return EXACT;
    if (triangle && strcmp(must, "group") == 0) return FANS;
    return triangle && strcmp(must, "f64") == 0 ? ILL : -1;
}

/* ---- scenes ---- */

static bool row_triangle(const bench *self, const row *header, const row *r, daft_trimesh *out)
{
    const daft_vec3 p[3] = {vector(header, r, "g0", "g1", "g2"), vector(header, r, "g3", "g4", "g5"),
                            vector(header, r, "g6", "g7", "g8")};
    const uint32_t index[3] = {0, 1, 2};
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = p, def.vertex_count = 3, def.indices = index, def.triangle_count = 1;
    return daft_trimesh_from_arrays(&self->allocator, &def, NULL, out, NULL);
}

static bool row_file(const bench *self, const row *header, const row *r, daft_trimesh *out)
{
    char path[1024];
    daft_obj obj;
    snprintf(path, sizeof path, "%s/%s", hard_cases_folder(), text(header, r, "mesh"));
    if (!daft_obj_load(&self->allocator, NULL, path, NULL, &obj, NULL)) return false;
    *out = obj.mesh;
    memset(&obj.mesh, 0, sizeof obj.mesh);
    daft_obj_free(&self->allocator, &obj);
    return true;
}

typedef struct answer {
    bool hit;
    float t;
} answer;

static answer ask(const robust_tracer *tracer, const row *header, const row *r, const daft_trimesh *mesh,
                  const daft_ray *ray)
{
    answer out = {false, 0};
    void *scene =
        mesh ? tracer->mesh(tracer->self, mesh)
             : tracer->sphere(tracer->self, vector(header, r, "g0", "g1", "g2"), strtof(text(header, r, "g3"), NULL));
    if (!scene) return out;
    out.hit = tracer->closest(scene, ray, &out.t);
    tracer->drop(scene);
    return out;
}

/* ---- judging ---- */

/* Ill-conditioned rows may be missed. A reported hit lies within a thousandth of the triangle's size of its bounds. */
static bool near_triangle(const daft_trimesh *mesh, const daft_ray *ray, float t)
{
    daft_vec3 size = daft_sub(mesh->high, mesh->low);
    double slack = 1e-3 * (double)fmaxf(size.x, fmaxf(size.y, size.z));
    daft_dvec3 p = daft_dadd(daft_to_double(ray->origin), daft_dscale(daft_to_double(ray->direction), (double)t));
    daft_dvec3 low = daft_to_double(mesh->low), high = daft_to_double(mesh->high);
    return p.x >= low.x - slack && p.y >= low.y - slack && p.z >= low.z - slack && p.x <= high.x + slack &&
           p.y <= high.y + slack && p.z <= high.z + slack;
}

static bool right(int class, const row *header, const row *r, const daft_trimesh *mesh, const daft_ray *ray, answer a)
{
    if (class == ILL) return !a.hit || near_triangle(mesh, ray, a.t);
    if (a.hit != (strcmp(text(header, r, "expect"), "hit") == 0)) return false;
    double expected = strtod(text(header, r, "t"), NULL);
    if (!a.hit || !text(header, r, "t")[0]) return true;
    if (isinf(a.t)) return expected > 3.4e38;
    return fabs((double)a.t - expected) <= 1e-3 * fmax(1e-30, fabs(expected));
}

/* Triangles around an edge or a vertex that a ray goes through: some must be hit. */
typedef struct fan {
    char name[64];
    bool hit[ROBUST_TRACERS];
} fan;

typedef struct fans {
    fan items[MAX_FANS];
    int count;
} fans;

static fan *find_fan(fans *f, const char *name)
{
    int i = 0;
    while (i < f->count && strcmp(f->items[i].name, name) != 0) i++;
    if (i == f->count && i < MAX_FANS - 1) snprintf(f->items[f->count++].name, sizeof f->items[i].name, "%.63s", name);
    return &f->items[i];
}

/* Embree asks for limits of 0 or more and for numbers below 1.8e18. */
static bool everyone_takes(const daft_ray *ray)
{
    daft_vec3 o = ray->origin, d = ray->direction;
    float most =
        fmaxf(fmaxf(fabsf(o.x), fmaxf(fabsf(o.y), fabsf(o.z))), fmaxf(fabsf(d.x), fmaxf(fabsf(d.y), fabsf(d.z))));
    return ray->tmin >= 0 && ray->tmax >= ray->tmin && most < 1.8e18f;
}

static void run_row(const bench *self, const robust_tracer *tracers, const row *header, const row *r,
                    robust_score *scores, fans *f)
{
    int class = class_of(text(header, r, "kind"), text(header, r, "must"));
    if (class < 0) return;
    daft_trimesh mesh = {0};
    bool file = class == INSIDE, sphere = class == SPHERES;
    if (!sphere && !(file ? row_file(self, header, r, &mesh) : row_triangle(self, header, r, &mesh))) return;
    daft_ray ray = {.origin = vector(header, r, "ox", "oy", "oz"),
                    .direction = vector(header, r, "dx", "dy", "dz"),
                    .tmin = strtof(text(header, r, "tmin"), NULL),
                    .tmax = strtof(text(header, r, "tmax"), NULL)};
    if (!everyone_takes(&ray)) {
        daft_trimesh_free(&self->allocator, &mesh);
        return;
    }
    scores[class].asked += class != FANS;
    for (int i = 0; i < ROBUST_TRACERS; i++) {
        if (!tracers[i].name) continue;
        answer a = ask(&tracers[i], header, r, sphere ? NULL : &mesh, &ray);
        if (class == FANS)
            find_fan(f, text(header, r, "group"))->hit[i] |= a.hit;
        else
            scores[class].wrong[i] += !right(class, header, r, &mesh, &ray, a);
    }
    daft_trimesh_free(&self->allocator, &mesh);
}

static void judge_fans(const fans *f, robust_score *score)
{
    score->asked = (uint64_t)f->count;
    for (int i = 0; i < f->count; i++)
        for (int k = 0; k < ROBUST_TRACERS; k++) score->wrong[k] += !f->items[i].hit[k];
}

size_t robust_cases(bench *self, const robust_tracer *tracers, robust_score scores[ROBUST_CLASSES])
{
    static const char *const WHAT[ROBUST_CLASSES] = {"robust: triangles (exact)", "robust: edges, vertices (group)",
                                                     "robust: inside meshes (meshhit)", "robust: ill-conditioned (f64)",
                                                     "robust: spheres (exact)"};
    char path[1024];
    snprintf(path, sizeof path, "%s/ray_cases.csv", hard_cases_folder());
    FILE *file = fopen(path, "r");
    row *header = daft_alloc(&self->allocator, 2, sizeof *header), *r = header + 1;
    fans *f = daft_alloc_zero(&self->allocator, 1, sizeof *f);
    bool ready = file && header && f && fgets(header->line, sizeof header->line, file);
    if (!file) bench_note(self, false, "ray_cases.csv left out: there is no %s", path);
    for (int i = 0; i < ROBUST_CLASSES; i++) scores[i] = (robust_score){.scene = "ray_cases.csv", .what = WHAT[i]};
    if (ready) split(header);
    while (ready && fgets(r->line, sizeof r->line, file)) {
        split(r);
        if (r->count > 10) run_row(self, tracers, header, r, scores, f);
    }
    if (ready) judge_fans(f, &scores[FANS]);
    if (file) fclose(file);
    daft_release(&self->allocator, header);
    daft_release(&self->allocator, f);
    return ready ? ROBUST_CLASSES : 0;
}
