/* The group `robust`: rays from inside closed meshes, aimed at vertices, edges and along axes, and the rows of
 * ray_cases.csv. Prints how many of a hundred answers are right, and counts the wrong ones. */
#include "robust.h"

#include "closed_shapes.h"
#include "math/simd/dispatch.h"

#include <stdio.h>
#include <string.h>

enum { RAYS = 1000000, RAYS_A_PLACE = 10000, SEED = 20264 };

/* ---- ours ---- */

typedef struct daft_tracer {
    daft_allocator allocator;
    const daft_accel_kernels *kernels;
} daft_tracer;

typedef struct daft_tracer_scene {
    const daft_tracer *tracer;
    daft_bvh *bvh;
    daft_instance instance;
    daft_arena arena;
    const daft_tlas *tlas;
} daft_tracer_scene;

static const uint32_t MATERIAL[1] = {0};

static void drop(void *context)
{
    daft_tracer_scene *scene = context;
    daft_arena_free(&scene->arena);
    daft_bvh_free(scene->bvh);
    daft_release(&scene->tracer->allocator, scene);
}

static void *finish(daft_tracer_scene *scene, daft_vec3 at)
{
    daft_affine identity = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {at.x, at.y, at.z}};
    scene->instance.to_frame = identity;
    scene->instance.to_object = (daft_affine){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-at.x, -at.y, -at.z}};
    scene->instance.materials = MATERIAL;
    daft_instance_bound(&scene->instance);
    daft_arena_init(&scene->arena, &scene->tracer->allocator);
    scene->tlas = daft_tlas_build(&scene->arena, &scene->instance, 1, NULL);
    if (scene->tlas) return scene;
    drop(scene);
    return NULL;
}

static void *mesh_scene(void *context, const daft_trimesh *mesh)
{
    const daft_tracer *self = context;
    daft_tracer_scene *scene = daft_alloc_zero(&self->allocator, 1, sizeof *scene);
    if (!scene) return NULL;
    scene->tracer = self;
    scene->bvh = daft_bvh_build_mesh(&self->allocator, mesh, 1, NULL);
    scene->instance.mesh = mesh, scene->instance.bvh = scene->bvh;
    return finish(scene, daft_v3(0, 0, 0));
}

static void *sphere_scene(void *context, daft_vec3 centre, float radius)
{
    const daft_tracer *self = context;
    daft_tracer_scene *scene = daft_alloc_zero(&self->allocator, 1, sizeof *scene);
    if (!scene) return NULL;
    scene->tracer = self;
    scene->instance.radius = radius;
    return finish(scene, centre);
}

static bool closest(void *context, const daft_ray *ray, float *t)
{
    const daft_tracer_scene *scene = context;
    daft_hit hit;
    bool found = scene->tracer->kernels->closest(scene->tlas, ray, UINT32_MAX, &hit);
    *t = hit.t;
    return found;
}

static void close_tracer(void *context)
{
    daft_tracer *self = context;
    daft_allocator allocator = self->allocator;
    daft_release(&allocator, self);
}

bool robust_open_daft(const bench *self, robust_tracer *out)
{
    int isa;
    daft_tracer *tracer = daft_alloc_zero(&self->allocator, 1, sizeof *tracer);
    if (!tracer || !daft_isa_parse(self->isa, &isa)) return daft_release(&self->allocator, tracer), false;
    tracer->allocator = self->allocator, tracer->kernels = daft_accel_kernels_for(isa);
    *out = (robust_tracer){.name = "DAFT",
                           .self = tracer,
                           .mesh = mesh_scene,
                           .sphere = sphere_scene,
                           .drop = drop,
                           .closest = closest,
                           .close = close_tracer};
    return true;
}

/* ---- leaks ---- */

/* Rays from places inside; gives how many: fewer where no place is found. */
static uint32_t make_rays(const daft_trimesh *mesh, uint64_t *state, daft_ray *rays)
{
    uint32_t count = 0;
    daft_vec3 origin;
    while (count + RAYS_A_PLACE <= RAYS && point_inside(mesh, state, &origin))
        for (int i = 0; i < RAYS_A_PLACE; i++)
            rays[count++] =
                (daft_ray){.origin = origin, .direction = hard_target(mesh, state, origin), .tmax = INFINITY};
    return count;
}

static uint64_t count_leaks(const robust_tracer *tracer, const daft_trimesh *mesh, const daft_ray *rays, uint32_t count)
{
    void *scene = tracer->mesh(tracer->self, mesh);
    uint64_t leaks = 0;
    float t;
    if (!scene) return count;
    for (uint32_t i = 0; i < count; i++) leaks += !tracer->closest(scene, &rays[i], &t);
    tracer->drop(scene);
    return leaks;
}

/* ---- the table ---- */

typedef struct cell {
    const robust_score *score;
    int peer;
} cell;

static double percent(const robust_score *s, int tracer)
{
    return s->asked ? 100 * (1 - (double)s->wrong[tracer] / (double)s->asked) : 100;
}
static double sample_ours(void *context) { return percent(((const cell *)context)->score, 0); }
static double sample_peer(void *context)
{
    const cell *c = context;
    return percent(c->score, c->peer);
}

static void describe(void *context, char *out, size_t size)
{
    const cell *c = context;
    const robust_score *s = c->score;
    int used =
        snprintf(out, size, "wrong of %llu: ours %llu", (unsigned long long)s->asked, (unsigned long long)s->wrong[0]);
    if (c->peer && used > 0 && (size_t)used < size)
        snprintf(out + used, size - (size_t)used, ", peer's %llu", (unsigned long long)s->wrong[c->peer]);
}

/* One row for each peer that there is; one without a peer otherwise. */
static void report(bench *self, const robust_tracer *tracers, const robust_score *score)
{
    bool alone = !tracers[1].name;
    int kept = self->rounds;
    self->rounds = 1; /* counts are the same each time */
    for (int peer = alone ? 0 : 1; peer < (alone ? 1 : ROBUST_TRACERS); peer++) {
        cell c = {score, peer};
        bench_subject subject = {.scene = score->scene,
                                 .what = score->what,
                                 .unit = "% right",
                                 .isa = self->isa,
                                 .threads = 1,
                                 .ours = sample_ours,
                                 .peer = peer ? sample_peer : NULL,
                                 .context = &c,
                                 .peer_name = peer ? tracers[peer].name : "Embree",
                                 .describe = describe};
        bench_measure(self, &subject);
    }
    self->rounds = kept;
}

static void measure_shape(bench *self, const robust_tracer *tracers, closed_shape *shape, uint64_t *state,
                          daft_ray *rays)
{
    robust_score score = {.scene = shape->name, .what = "robust: rays from inside"};
    uint32_t count = make_rays(&shape->mesh, state, rays);
    score.asked = count;
    for (int i = 0; i < ROBUST_TRACERS; i++)
        if (tracers[i].name) score.wrong[i] = count_leaks(&tracers[i], &shape->mesh, rays, count);
    report(self, tracers, &score);
}

static void measure_shapes(bench *self, const robust_tracer *tracers)
{
    daft_ray *rays = daft_alloc(&self->allocator, RAYS, sizeof *rays);
    if (!rays) {
        bench_note(self, true, "out of memory");
        return;
    }
    for (int i = 0; i < CLOSED_KINDS + CLOSED_FILES; i++) {
        closed_shape shape;
        uint64_t state = hard_state(SEED, (uint64_t)i);
        bool made = i < CLOSED_KINDS ? closed_shape_make(&self->allocator, i, &state, &shape)
                                     : closed_shape_load(&self->allocator, i - CLOSED_KINDS, &shape);
        if (!made) continue;
        if (bench_wants(self, shape.name, "robust: rays from inside"))
            measure_shape(self, tracers, &shape, &state, rays);
        closed_shape_free(&self->allocator, &shape);
    }
    daft_release(&self->allocator, rays);
}

void bench_robust(bench *self)
{
    robust_tracer tracers[ROBUST_TRACERS] = {0};
    robust_score scores[ROBUST_CLASSES];
    if (!robust_open_daft(self, &tracers[0])) {
        bench_note(self, true, "out of memory");
        return;
    }
    for (int i = 1; i < ROBUST_TRACERS && self->peers; i++)
        if (!robust_open_embree(i == 2, &tracers[i])) tracers[i].name = NULL;
    measure_shapes(self, tracers);
    if (bench_wants(self, "ray_cases.csv", "robust: rows")) {
        size_t count = robust_cases(self, tracers, scores);
        for (size_t i = 0; i < count; i++) report(self, tracers, &scores[i]);
    }
    for (int i = 0; i < ROBUST_TRACERS; i++)
        if (tracers[i].name) tracers[i].close(tracers[i].self);
}
