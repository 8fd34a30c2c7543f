/* Properties of rays and meshes that hold for all of them, on random ones: closed meshes leak no ray, lines cross them
 * an even number of times, trees find what brute force finds and what the pencil finds, limits are sharp to the last
 * bit, numbering does not matter, powers of two do not matter, instruction sets do not matter.
 *
 * A short run is part of every `./daft test`. A long one: test_properties --rays 1e8, or DAFT_RAYS=1e8 in the
 * environment; it shoots that many rays from inside closed meshes, and looks at the other properties that much longer.
 * DAFT_SEED=n repeats a run, whatever the number of threads. */
#include "subject.h"

#include "math/exact.h"
#include "raster/raster.h"

/* Distances of single rays are good to 2^-18 of themselves: two that differ by less than that twice may change places.
 */
#define SAME_DISTANCE 0x1p-17

enum { SHAPES = CLOSED_KINDS + CLOSED_FILES };

#define QUICK_RAYS 1.5e6
static double wanted_rays = QUICK_RAYS;
static uint64_t seed;

static bool is_long(void) { return wanted_rays > QUICK_RAYS; }

/* The last two are large. */
static int shapes(void) { return is_long() ? SHAPES : SHAPES - 2; }

static uint32_t rounds(uint32_t quick) { return (uint32_t)(quick * fmin(1e3, fmax(1, wanted_rays / QUICK_RAYS))); }

/* ---- closed meshes leak no ray ---- */

enum { BATCH = 4096 };

typedef struct leak_job {
    subject *subjects; /* one a worker's task may use: they are only read */
    uint32_t subject_count, batch_rays;
    bool as_instances;
    uint64_t stream;
    struct leak_count {
        uint64_t rays, leaks, unlike, skipped;
        daft_ray leak; /* the first */
        uint32_t subject;
    } * counts; /* one a batch */
} leak_job;

/* Left out are places where the steps of floats are larger than the object: the ray would not start inside. */
static bool resolved(const subject *s, const daft_ray *ray)
{
    daft_vec3 o = daft_affine_point(&s->instance.to_object, ray->origin), l = s->instance.low, h = s->instance.high;
    if (exact_crossings(&s->shape.mesh, o, daft_v3(0.3f, 1, -0.6f)) % 2 != 1) return false;
    return ray->origin.x >= l.x && ray->origin.y >= l.y && ray->origin.z >= l.z && ray->origin.x <= h.x &&
           ray->origin.y <= h.y && ray->origin.z <= h.z;
}

static void leak_ray(const subject *s, daft_ray ray, uint32_t number, struct leak_count *count)
{
    daft_hit hit;
    bool found = daft_accel_kernels_for(daft_isa_best())->closest(s->tlas, &ray, UINT32_MAX, &hit);
    count->rays++;
    if (!found && count->leaks++ == 0) count->leak = ray;
    if (number % 16 == 0 && !looks_alike(s->tlas, &ray, &hit))
        count->unlike++;
    else if (number % 4 == 0 && daft_accel_kernels_for(daft_isa_best())->occluded(s->tlas, &ray) != found)
        count->unlike++;
}

/* One origin, many rays: an origin is checked against every triangle. */
static void leak_batch(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    leak_job *job = context;
    struct leak_count *count = &job->counts[index];
    uint64_t state = hard_state(seed, job->stream + index);
    count->subject = index % job->subject_count;
    subject s = job->subjects[count->subject];
    daft_affine at = identity();
    daft_ray ray = ray_make(daft_v3(0, 0, 0), daft_v3(0, 0, 0));
    bool usable = point_inside(&s.shape.mesh, &state, &ray.origin);
    daft_vec3 origin = ray.origin;
    if (usable && job->as_instances) {
        daft_arena_init(&s.arena, memory());
        at = any_place(&state);
        subject_place(&s, at);
        ray.origin = daft_affine_point(&at, origin);
        usable = resolved(&s, &ray);
    }
    for (uint32_t i = 0; usable && i < job->batch_rays; i++) {
        daft_vec3 d = hard_target(&s.shape.mesh, &state, origin);
        ray.direction = job->as_instances ? daft_affine_vector(&at, d) : d;
        leak_ray(&s, ray, i, count);
    }
    count->skipped = !usable;
    if (job->as_instances && s.arena.first) daft_arena_free(&s.arena);
}

static struct leak_count leak_sum(const leak_job *job, uint32_t batches)
{
    struct leak_count sum = {0};
    for (uint32_t i = 0; i < batches; i++) {
        const struct leak_count *c = &job->counts[i];
        sum.rays += c->rays, sum.unlike += c->unlike, sum.skipped += c->skipped;
        sum.leaks += c->leaks;
        if (c->leaks == 0) continue;
        const daft_ray *r = &c->leak;
        print_error("batch %u, %s: %llu leaks, first from %a %a %a along %a %a %a\n", i,
                    job->subjects[c->subject].shape.name, (unsigned long long)c->leaks, (double)r->origin.x,
                    (double)r->origin.y, (double)r->origin.z, (double)r->direction.x, (double)r->direction.y,
                    (double)r->direction.z);
    }
    return sum;
}

/* Shoots about `fraction` of the rays that are wanted. */
static void leak_rays(bool as_instances, double fraction)
{
    uint64_t total = 0, stream = hard_state(seed, as_instances ? 1 : 2);
    int threads = is_long() ? daft_processor_count() : 1;
    while ((double)total < wanted_rays * fraction) {
        subject subjects[SHAPES];
        uint64_t state = hard_state(seed, stream);
        leak_job job = {.subjects = subjects,
                        .as_instances = as_instances,
                        .stream = stream,
                        .batch_rays = is_long() ? 16 * BATCH : BATCH};
        for (int i = 0; i < shapes(); i++) job.subject_count += subject_make(&subjects[job.subject_count], i, &state);
        double left = (as_instances ? 1.3 : 1) * (wanted_rays * fraction - (double)total); /* some places will be left
                                                                                            * out
                                                                                            */
        uint32_t batches = (uint32_t)fmin(2048, left / job.batch_rays + 1);
        job.counts = calloc(batches, sizeof *job.counts);
        daft_parallel_for(threads, batches, leak_batch, &job);
        struct leak_count sum = leak_sum(&job, batches);
        total += sum.rays + 1, stream += batches;
        print_message("%s: %llu rays, %llu leaks; %u shapes, %u places, %llu of them left out\n",
                      as_instances ? "instances" : "meshes", (unsigned long long)sum.rays,
                      (unsigned long long)sum.leaks, job.subject_count, batches, (unsigned long long)sum.skipped);
        free(job.counts);
        for (uint32_t i = 0; i < job.subject_count; i++) subject_drop(&subjects[i]);
        assert_true(sum.leaks == 0 && sum.unlike == 0);
    }
}

static void meshes_leak_no_ray(void **unused)
{
    (void)unused;
    leak_rays(false, 0.5);
}

static void instances_leak_no_ray(void **unused)
{
    (void)unused;
    leak_rays(true, 0.25);
}

/* ---- pencils ---- */

enum { SIDE = 256 };

static daft_pencil pencil_make(float focal)
{
    return (daft_pencil){
        .right = {0, 0, 1}, .up = {0, 1, 0}, .forward = {1, 0, 0}, .focal = focal, .width = SIDE, .height = SIDE};
}

typedef void pixel_check(void *context, int x, int y, uint32_t instance, uint32_t triangle);

static void pencil_see(const daft_instance *instances, uint32_t count, const daft_pencil *pencil, pixel_check *check,
                       void *context)
{
    daft_raster raster;
    daft_error error;
    assert_true(daft_raster_init(&raster, memory(), 1, daft_isa_best(), &error));
    assert_true(daft_raster_begin(&raster, pencil, instances, count, &error));
    const daft_raster_kernels *kernels = daft_raster_kernels_for(daft_isa_best());
    for (uint32_t i = 0; i < raster.work_count; i++) daft_raster_bin(&raster, i, 0);
    daft_tile *tile = malloc(sizeof *tile);
    for (uint32_t i = 0; i < (uint32_t)(raster.tiles_x * raster.tiles_y); i++) {
        kernels->tile(&raster, i, 0, NULL, tile);
        for (int y = 0; y < tile->height; y++)
            for (int x = 0; x < tile->width; x++) {
                int at = y * DAFT_TILE_STRIDE + x;
                check(context, tile->x + x, tile->y + y, tile->instance[at], tile->triangle[at]);
            }
    }
    free(tile);
    daft_raster_free(&raster);
}

static void count_sky(void *context, int x, int y, uint32_t instance, uint32_t triangle)
{
    (void)x, (void)y, (void)triangle;
    *(uint64_t *)context += instance == DAFT_NOTHING;
}

/* The eye is the frame's origin: it is inside when it is inside the mesh as its corners are moved. */
static bool eye_inside(const subject *s, uint64_t *state)
{
    const daft_trimesh *m = &s->shape.mesh;
    daft_trimesh moved = *m;
    float *room = malloc(3 * (size_t)m->vertex_count * sizeof *room);
    moved.x = room, moved.y = room + m->vertex_count, moved.z = moved.y + m->vertex_count;
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        daft_vec3 p = daft_affine_point(&s->instance.to_frame, mesh_vertex(m, i));
        moved.x[i] = p.x, moved.y[i] = p.y, moved.z[i] = p.z;
    }
    bool inside = exact_crossings(&moved, daft_v3(0, 0, 0), hard_vec3(state, -1, 1)) % 2 == 1;
    free(room);
    return inside;
}

/* From within a mesh no pixel sees the sky. */
static void pencils_leak_no_ray(void **unused)
{
    (void)unused;
    uint64_t rays = 0, sky = 0, state = hard_state(seed, 3);
    for (uint32_t round = 0; (double)rays < wanted_rays * 0.25; round++) {
        subject s;
        daft_vec3 eye;
        if (!subject_make(&s, (int)round % shapes(), &state)) continue;
        for (int i = 0; i < (is_long() ? 16 : 1) && point_inside(&s.shape.mesh, &state, &eye); i++) {
            daft_affine at = any_place(&state);
            if (i % 4 == 0) at = identity(); /* corners on the rays */
            at.t[0] = at.t[1] = at.t[2] = 0;
            daft_vec3 home = daft_affine_point(&at, eye);
            at.t[0] = -home.x, at.t[1] = -home.y, at.t[2] = -home.z;
            subject_place(&s, at);
            daft_pencil pencil = pencil_make(i % 2 ? hard_float(&state, 20, 400) : 128);
            if (i % 4 == 0) pencil.shift_x = pencil.shift_y = 0.5f;
            if (!eye_inside(&s, &state)) continue;
            uint64_t before = sky;
            pencil_see(&s.instance, 1, &pencil, count_sky, &sky);
            if (sky > before)
                print_error("round %u, %d, %s: %llu pixels leak\n", round, i, s.shape.name,
                            (unsigned long long)(sky - before));
            rays += SIDE * SIDE;
        }
        subject_drop(&s);
    }
    print_message("pencils: %llu rays, %llu leaks\n", (unsigned long long)rays, (unsigned long long)sky);
    assert_int_equal(sky, 0);
}

/* ---- crossings ---- */

/* A point outside: beyond the bounds. */
static daft_vec3 point_outside(const daft_trimesh *mesh, uint64_t *state)
{
    daft_vec3 size = daft_sub(mesh->high, mesh->low),
              p = daft_add(mesh->low, daft_mul(size, hard_vec3(state, -0.5f, 1.5f)));
    float longest = fmaxf(size.x, fmaxf(size.y, size.z)), away = longest * hard_float(state, 0.1f, 2);
    if (hard_bits(state) % 2)
        p.x = mesh->high.x + away;
    else
        p.z = mesh->low.z - away;
    return p;
}

static int count_by_walking(const subject *s, daft_ray ray)
{
    int count = 0;
    for (daft_hit hit; look(s, &ray, &hit); ray.tmin = nextafterf(hit.t, INFINITY)) count++;
    return count;
}

/* The distance to one triangle in double, infinity for a miss. */
static double exact_distance(const daft_trimesh *mesh, uint32_t triangle, const daft_ray *ray)
{
    daft_vec3 c[3];
    daft_dvec3 p[3], d = daft_to_double(ray->direction);
    double w[3], along = 0;
    for (uint32_t k = 0; k < 3; k++) c[k] = mesh_corner(mesh, triangle, k);
    if (!daft_line_touches(ray->origin, c[0], c[1], c[2], ray->direction)) return INFINITY;
    for (int k = 0; k < 3; k++) p[k] = daft_dsub(daft_to_double(c[k]), daft_to_double(ray->origin));
    daft_pencil_weights(p[0], p[1], p[2], ray->direction, w);
    for (int k = 0; k < 3; k++) along += w[k] * daft_ddot(p[k], d);
    return along >= 0 ? along / daft_ddot(d, d) : INFINITY;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static bool crosses(const daft_trimesh *mesh, uint32_t t, const daft_ray *ray)
{
    return daft_line_hits(ray->origin, mesh_corner(mesh, t, 0), mesh_corner(mesh, t, 1), mesh_corner(mesh, t, 2),
                          ray->direction);
}

/* Whether the ray can step from hit to hit: they are further apart than distances are wrong, and none is on an edge or
 * a vertex, where a ray touches what it does not cross. */
static bool can_be_walked(const daft_trimesh *mesh, const daft_ray *ray)
{
    enum { MOST = 64 };
    double t[MOST], last = 0;
    size_t count = 0;
    for (uint32_t i = 0; i < mesh->triangle_count && count < MOST; i++) {
        t[count] = exact_distance(mesh, i, ray);
        if (t[count] == INFINITY) continue;
        if (!crosses(mesh, i, ray)) return false;
        count++;
    }
    qsort(t, count, sizeof *t, by_value);
    for (size_t i = 0; i < count; last = t[i++])
        if (t[i] - last < 4 * SAME_DISTANCE * t[i]) return false;
    return count < MOST;
}

static void lines_cross_evenly(void **unused)
{
    (void)unused;
    uint64_t state = hard_state(seed, 4);
    uint32_t rays = 0, walked = 0, hits = 0;
    for (uint32_t round = 0; round < rounds(SHAPES); round++) {
        subject s;
        if (!subject_make(&s, (int)round % shapes(), &state)) continue;
        int count = s.shape.mesh.triangle_count > 10000 ? 1 : 60;
        for (int i = 0; i < count; i++) {
            daft_ray ray = ray_make(point_outside(&s.shape.mesh, &state), daft_v3(0, 0, 0));
            ray.direction = hard_target(&s.shape.mesh, &state, ray.origin);
            int exact = exact_crossings(&s.shape.mesh, ray.origin, ray.direction), steps = count_by_walking(&s, ray);
            if (exact < 0) continue;
            rays++, hits += exact > 0;
            if (exact % 2) fail_msg("round %u, ray %d, %s: %d crossings", round, i, s.shape.name, exact);
            assert_true(exact == 0 || steps != 0);
            if (!can_be_walked(&s.shape.mesh, &ray)) continue;
            walked++;
            if (steps != exact)
                fail_msg("round %u, ray %d, %s: %d crossings, %d hits one by one", round, i, s.shape.name, exact,
                         steps);
        }
        subject_drop(&s);
    }
    print_message("%u lines from outside, %u that hit, %u walked from hit to hit\n", rays, hits, walked);
    assert_true(hits > 100 && walked > 100);
}

/* ---- brute force and the pencil ---- */

typedef struct brute_hit {
    double t; /* infinity: none */
    uint32_t triangle;
} brute_hit;

static brute_hit brute(const daft_trimesh *mesh, const daft_ray *ray)
{
    brute_hit nearest = {INFINITY, 0};
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        double t = exact_distance(mesh, i, ray);
        if (t < nearest.t) nearest = (brute_hit){t, i};
    }
    return nearest;
}

static bool close_to(double a, double b) { return fabs(a - b) <= SAME_DISTANCE * fmax(fabs(a), fabs(b)); }

/* Triangles that cross each other, of all sizes, some in the place of others. */
static void subject_soup(subject *s, float size, uint64_t *state)
{
    *s = (subject){0};
    enum { COUNT = 120 };
    daft_vec3 p[3 * COUNT];
    uint32_t index[3 * COUNT];
    float spread = (float)daft_pow(10, (double)hard_float(state, -2, 1));
    for (uint32_t i = 0; i < COUNT; i++) {
        daft_vec3 centre = hard_vec3(state, -2, 2);
        for (uint32_t k = 0; k < 3; k++) {
            index[3 * i + k] = 3 * i + k;
            p[3 * i + k] = daft_scale(daft_add(centre, hard_vec3(state, -spread, spread)), size);
        }
        if (i % 10 == 9) memcpy(&p[3 * i], &p[3 * i - 3], 3 * sizeof *p);
    }
    fixture_mesh mesh = mesh_make(p, 3 * COUNT, index, COUNT);
    daft_bvh_free(mesh.bvh);
    s->shape.mesh = mesh.mesh;
    snprintf(s->shape.name, sizeof s->shape.name, "soup");
    subject_wrap(s);
}

static bool small_subject(subject *s, uint32_t round, uint64_t *state)
{
    if (round % 3 == 0) return subject_soup(s, 1, state), true;
    if (!subject_make(s, (int)round % shapes(), state)) return false;
    if (s->shape.mesh.triangle_count < 3000) return true;
    subject_drop(s);
    return false;
}

static daft_ray any_ray(const subject *s, uint64_t *state)
{
    const daft_trimesh *m = &s->shape.mesh;
    daft_ray ray = ray_make(daft_add(m->low, daft_mul(daft_sub(m->high, m->low), hard_vec3(state, -0.5f, 1.5f))),
                            daft_v3(0, 0, 0));
    ray.direction = hard_target(m, state, ray.origin);
    return ray;
}

static void trees_find_what_brute_force_finds(void **unused)
{
    (void)unused;
    uint64_t state = hard_state(seed, 5);
    uint32_t rays = 0, hits = 0, ties = 0;
    for (uint32_t round = 0; round < rounds(30); round++) {
        subject s;
        float lengths = 1;
        if (round % 2 == 0) { /* from 1e-12 to 1e12, with directions of any length */
            subject_soup(&s, (float)daft_pow(10, (double)hard_float(&state, -12, 12)), &state);
            lengths = (float)daft_pow(10, (double)hard_float(&state, -9, 9));
        } else if (!small_subject(&s, round, &state))
            continue;
        for (int i = 0; i < 100; i++) {
            daft_ray ray = any_ray(&s, &state);
            ray.direction = daft_scale(ray.direction, lengths);
            daft_hit hit;
            bool found = look(&s, &ray, &hit);
            brute_hit expected = brute(&s.shape.mesh, &ray);
            rays++, hits += found;
            if (found != (expected.t < INFINITY) || (found && !close_to((double)hit.t, expected.t)))
                fail_msg("round %u, ray %d, %s: %.9g instead of %.9g from %a %a %a along %a %a %a", round, i,
                         s.shape.name, found ? (double)hit.t : -1.0, expected.t, (double)ray.origin.x,
                         (double)ray.origin.y, (double)ray.origin.z, (double)ray.direction.x, (double)ray.direction.y,
                         (double)ray.direction.z);
            if (!found || hit.triangle == expected.triangle) continue;
            ties++;
            assert_true(close_to(exact_distance(&s.shape.mesh, hit.triangle, &ray), expected.t));
        }
        subject_drop(&s);
    }
    print_message("%u rays, %u hits, %u of them on another triangle at the same distance\n", rays, hits, ties);
    assert_true(hits > 1000);
}

typedef struct pencil_job {
    const subject *subject;
    const daft_pencil *pencil;
    uint32_t pixels, seen, ties, touches, wrong;
} pencil_job;

/* In camera space, whose axes are the frame's z, y and x: ties are broken there. */
static bool pencil_crosses(const daft_trimesh *mesh, uint32_t t, daft_vec3 r)
{
    daft_vec3 c[3];
    for (uint32_t k = 0; k < 3; k++) {
        daft_vec3 p = mesh_corner(mesh, t, k);
        c[k] = daft_v3(p.z, p.y, p.x);
    }
    return daft_pencil_hits(c[0], c[1], c[2], r);
}

/* The eye is where the frame begins and looks along an axis: camera space holds the frame's numbers in another order,
 * so both see the same triangles to the last bit. Single rays also hit what they only touch. */
static void pixel_as_ray(void *context, int x, int y, uint32_t instance, uint32_t triangle)
{
    pencil_job *job = context;
    const subject *s = job->subject;
    daft_vec3 r = daft_pencil_ray(job->pencil, x, y);
    daft_ray ray = ray_make(daft_v3(0, 0, 0), daft_v3(r.z, r.y, r.x));
    daft_hit hit;
    bool found = daft_accel_kernels_for(daft_isa_best())->closest(s->tlas, &ray, UINT32_MAX, &hit),
         seen = instance != DAFT_NOTHING;
    job->pixels++, job->seen += seen;
    if (found == seen && (!seen || hit.triangle == triangle)) return;
    double other = seen ? exact_distance(&s->shape.mesh, triangle, &ray) : INFINITY;
    if (seen && found && close_to((double)hit.t, other)) {
        job->ties++;
        return;
    }
    if (found && (double)hit.t < other && !pencil_crosses(&s->shape.mesh, hit.triangle, r))
        job->touches++;
    else if (job->wrong++ == 0)
        print_error("%s: pixel %d, %d\n", s->shape.name, x, y);
}

/* As OBJ files are placed: the mesh itself is moved, so that no transform stands between the two. */
static void move_mesh(subject *s, daft_vec3 by)
{
    daft_trimesh *m = &s->shape.mesh;
    for (uint32_t i = 0; i < m->vertex_count; i++) m->x[i] += by.x, m->y[i] += by.y, m->z[i] += by.z;
    m->low = daft_add(m->low, by), m->high = daft_add(m->high, by);
    daft_bvh_free(s->bvh);
    daft_arena_free(&s->arena);
    subject_wrap(s);
}

static void pencils_see_what_rays_hit(void **unused)
{
    (void)unused;
    uint64_t state = hard_state(seed, 6);
    pencil_job sum = {0};
    for (uint32_t round = 0; round < rounds(8); round++) {
        subject s;
        if (!small_subject(&s, round, &state)) continue;
        daft_vec3 size = daft_sub(s.shape.mesh.high, s.shape.mesh.low);
        if (round % 4 < 3) move_mesh(&s, daft_v3(size.x * (float)(round % 4), 0, 0));
        daft_pencil pencil = pencil_make(round % 2 ? hard_float(&state, 30, 400) : 128);
        if (round % 4 > 1) pencil.shift_x = 0.5f;
        pencil_job job = {.subject = &s, .pencil = &pencil};
        pencil_see(&s.instance, 1, &pencil, pixel_as_ray, &job);
        sum.pixels += job.pixels, sum.seen += job.seen, sum.ties += job.ties, sum.touches += job.touches,
            sum.wrong += job.wrong;
        subject_drop(&s);
    }
    print_message(
        "%u pixels, %u see something; %u see another triangle at the same distance, %u rays touch only; %u differ\n",
        sum.pixels, sum.seen, sum.ties, sum.touches, sum.wrong);
    assert_true(sum.wrong == 0 && sum.seen > 1000);
}

/* ---- limits ---- */

static void limits_are_sharp(void **unused)
{
    (void)unused;
    uint64_t state = hard_state(seed, 7);
    uint32_t hits = 0;
    for (uint32_t round = 0; round < rounds(30); round++) {
        subject s;
        if (!subject_make(&s, (int)round % shapes(), &state)) continue;
        if (round % 2) subject_place(&s, any_place(&state));
        for (int i = 0; i < 100; i++) {
            daft_ray ray = any_ray(&s, &state);
            ray.origin = daft_affine_point(&s.instance.to_frame, ray.origin);
            ray.direction = daft_affine_vector(&s.instance.to_frame, ray.direction);
            daft_hit hit, again;
            if (!look(&s, &ray, &hit) || !(hit.t > 0)) continue;
            hits++;
            ray.tmax = hit.t;
            assert_true(look(&s, &ray, &again) && memcmp(&hit, &again, sizeof hit) == 0);
            ray.tmax = nextafterf(hit.t, 0);
            assert_false(look(&s, &ray, &again));
            ray.tmax = INFINITY, ray.tmin = hit.t;
            assert_true(look(&s, &ray, &again) && memcmp(&hit, &again, sizeof hit) == 0);
            ray.tmin = nextafterf(hit.t, INFINITY);
            assert_true(!look(&s, &ray, &again) || again.t > hit.t);
        }
        subject_drop(&s);
    }
    print_message("%u hits\n", hits);
    assert_true(hits > 1000);
}

/* ---- numbering and scale ---- */

static uint32_t *shuffled(uint32_t count, uint64_t *state)
{
    uint32_t *order = malloc(count * sizeof *order);
    for (uint32_t i = 0; i < count; i++) order[i] = i;
    for (uint32_t i = count; i > 1; i--) {
        uint32_t j = hard_bits(state) % i, swap = order[i - 1];
        order[i - 1] = order[j], order[j] = swap;
    }
    return order;
}

/* The same surface, vertices and triangles renumbered. from[i]: what triangle i was. The corners' order stays, or
 * turns. */
static void subject_renumber(const subject *s, uint64_t *state, uint32_t turn, subject *out, uint32_t **from)
{
    const daft_trimesh *m = &s->shape.mesh;
    uint32_t *place = shuffled(m->vertex_count, state), *index = malloc(3 * (size_t)m->triangle_count * sizeof *index);
    daft_vec3 *p = malloc(m->vertex_count * sizeof *p);
    *from = shuffled(m->triangle_count, state);
    for (uint32_t i = 0; i < m->vertex_count; i++) p[place[i]] = mesh_vertex(m, i);
    for (uint32_t i = 0; i < m->triangle_count; i++)
        for (uint32_t k = 0; k < 3; k++) index[3 * i + k] = place[m->indices[3 * (*from)[i] + (k + turn) % 3]];
    fixture_mesh mesh = mesh_make(p, m->vertex_count, index, m->triangle_count);
    daft_bvh_free(mesh.bvh);
    *out = (subject){.shape.mesh = mesh.mesh};
    subject_wrap(out);
    assert_int_equal(out->shape.mesh.triangle_count, m->triangle_count);
    free(place);
    free(index);
    free(p);
}

static void numbering_does_not_matter(void **unused)
{
    (void)unused;
    uint64_t state = hard_state(seed, 8);
    uint32_t hits = 0, ties = 0;
    for (uint32_t round = 0; round < rounds(30); round++) {
        subject s, other;
        uint32_t *from, turn = round / 2 % 3;
        if (!small_subject(&s, round, &state)) continue;
        subject_renumber(&s, &state, turn, &other, &from);
        for (int i = 0; i < 300; i++) {
            daft_ray ray = any_ray(&s, &state);
            daft_hit a, b;
            bool found = look(&s, &ray, &a);
            assert_int_equal(look(&other, &ray, &b), found);
            if (!found) continue;
            hits++;
            assert_true(turn ? close_to((double)a.t, (double)b.t) : a.t == b.t);
            if (from[b.triangle] == a.triangle) continue;
            ties++;
            assert_true(close_to(exact_distance(&s.shape.mesh, from[b.triangle], &ray), (double)a.t));
        }
        free(from);
        subject_drop(&other);
        subject_drop(&s);
    }
    print_message("%u hits, %u of them on another triangle at the same distance\n", hits, ties);
    assert_true(hits > 1000);
}

static daft_affine affine_scaled(daft_affine a, float linear, float place)
{
    for (int i = 0; i < 9; i++) a.m[i] *= linear;
    for (int i = 0; i < 3; i++) a.t[i] *= place;
    return a;
}

/* A mesh with its vertices multiplied. */
static void subject_scale(const subject *s, float k, subject *out)
{
    const daft_trimesh *m = &s->shape.mesh;
    daft_vec3 *p = malloc(m->vertex_count * sizeof *p);
    for (uint32_t i = 0; i < m->vertex_count; i++) p[i] = daft_scale(mesh_vertex(m, i), k);
    fixture_mesh mesh = mesh_make(p, m->vertex_count, m->indices, m->triangle_count);
    daft_bvh_free(mesh.bvh);
    *out = (subject){.shape.mesh = mesh.mesh};
    subject_wrap(out);
    free(p);
}

static bool same_bits(const daft_hit *a, const daft_hit *b, float k)
{
    return b->t == a->t * k && b->u == a->u && b->v == a->v && b->triangle == a->triangle && b->instance == a->instance;
}

/* The world times 2^k, or a mesh times 2^k and its transform by 2^-k: rays with their direction give the same t; with
 * the direction as it was, 2^k t. */
static void powers_of_two_do_not_matter(void **unused)
{
    (void)unused;
    uint64_t state = hard_state(seed, 9);
    uint32_t hits = 0;
    for (uint32_t round = 0; round < rounds(30); round++) {
        subject s, other;
        if (!small_subject(&s, round, &state)) continue;
        float k = ldexpf(1, (int)(hard_bits(&state) % 25) - 12),
              size = daft_length(daft_sub(s.shape.mesh.high, s.shape.mesh.low));
        if (size < 1e-3f) k = ldexpf(1, 10 + (int)(hard_bits(&state) % 20)); /* away from what underflows */
        daft_affine at = affine_make(random_rotation(), daft_v3(1, 1.5f, 1), hard_vec3(&state, -4, 4));
        subject_scale(&s, k, &other);
        subject_place(&s, at);
        subject_place(&other, affine_scaled(at, round % 2 ? 1 / k : 1, round % 2 ? 1 : k));
        float world = round % 2 ? 1 : k;
        for (int i = 0; i < 300; i++) {
            daft_ray ray = any_ray(&s, &state), scaled;
            ray.origin = daft_affine_point(&s.instance.to_frame, ray.origin);
            ray.direction = daft_affine_vector(&s.instance.to_frame, ray.direction);
            scaled = ray_make(daft_scale(ray.origin, world), daft_scale(ray.direction, i % 2 ? world : 1));
            daft_hit a, b;
            bool found = look(&s, &ray, &a);
            assert_int_equal(look(&other, &scaled, &b), found);
            hits += found;
            if (found && !same_bits(&a, &b, i % 2 ? 1 : world))
                fail_msg("round %u, ray %d, %s by %g: t %a, then %a", round, i, s.shape.name, (double)k, (double)a.t,
                         (double)b.t);
        }
        subject_drop(&other);
        subject_drop(&s);
    }
    print_message("%u hits\n", hits);
    assert_true(hits > 1000);
}

int main(int argc, char **argv)
{
    const char *rays = argc == 3 && strcmp(argv[1], "--rays") == 0 ? argv[2] : argc == 1 ? getenv("DAFT_RAYS") : NULL;
    if (rays) wanted_rays = strtod(rays, NULL);
    if ((argc > 1 && !rays) || !(wanted_rays >= 1)) {
        fprintf(stderr, "usage: test_properties [--rays N]\n");
        return 2;
    }
    fixture_seed(20264);
    seed = fixture_state;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(meshes_leak_no_ray),
        cmocka_unit_test(instances_leak_no_ray),
        cmocka_unit_test(pencils_leak_no_ray),
        cmocka_unit_test(lines_cross_evenly),
        cmocka_unit_test(trees_find_what_brute_force_finds),
        cmocka_unit_test(pencils_see_what_rays_hit),
        cmocka_unit_test(limits_are_sharp),
        cmocka_unit_test(numbering_does_not_matter),
        cmocka_unit_test(powers_of_two_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
