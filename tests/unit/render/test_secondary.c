/* Secondary rays: what points send on, by every instruction set, against a scalar twin that takes one point after the
 * other, bit for bit: smooth and rough surfaces, mirrors, glass from either side, cut-outs, media, and triangles small
 * enough that rays are moved off their sides. */
#include "fixtures.h"

#include "render/dice.h"
#include "render/internal.h"

DAFT_KERNEL_DECLARE(daft_render_kernels, daft_render);
static const daft_render_kernels *kernels(int isa)
{
    static const daft_render_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_render);
    return TABLE[isa];
}

/* ---- the twin ---- */

#define GRAZING 1e-3f

static daft_vec3 lane3(const daft_lanes3 *a, uint32_t i) { return daft_v3(a->x[i], a->y[i], a->z[i]); }

/* The normal of a facet that is seen (Dupuy, Benyoub, "Sampling Visible GGX Normals with Spherical Caps", HPG 2023);
 * the surface's own where that is smooth. */
static daft_vec3 facet_at(const daft_batch *b, uint32_t i, float alpha, const daft_spawning *allowed)
{
    const daft_vec3 normal = lane3(&b->normal, i), view = lane3(&b->view, i);
    if (!(alpha > 0) || !allowed->rough) return normal;
    const uint32_t place = allowed->place ? allowed->place[b->pixel[i]] : b->pixel[i];
    const daft_dice dice = daft_dice_throw(allowed->column + place % DAFT_TILE, allowed->row + place / DAFT_TILE,
                                           allowed->round, allowed->salt);
    const daft_vec2 turn = allowed->turns[daft_dice_turn(dice, allowed->ray)];
    const float part = daft_dice_part(dice, allowed->ray, allowed->rays), up = daft_dot(view, normal);
    daft_vec3 x, y;
    daft_axes_across(normal, &x, &y);
    const daft_vec3 v =
        daft_normalize(daft_v3(alpha * daft_dot(view, x), alpha * daft_dot(view, y), up > GRAZING ? up : GRAZING));
    const float z = (1 - part) * (1 + v.z) - v.z, across = z * z < 1 ? sqrtf(1 - z * z) : 0;
    const float high = z + v.z > 1e-6f ? z + v.z : 1e-6f;
    const daft_vec3 h = daft_v3(alpha * (across * turn.x + v.x), alpha * (across * turn.y + v.y), high);
    return daft_normalize(daft_add(daft_add(daft_scale(x, h.x), daft_scale(y, h.y)), daft_scale(normal, h.z)));
}

/* The mirrored direction; one that would enter the surface, which smooth normals can ask for, is bent to graze it, and
 * by facets is mirrored once more. */
static daft_vec3 mirrored(daft_vec3 view, daft_vec3 normal, daft_vec3 outward, bool rough)
{
    daft_vec3 d = daft_sub(daft_scale(normal, 2 * daft_dot(normal, view)), view);
    float under = daft_dot(d, outward);
    if (rough && under < 0) d = daft_sub(d, daft_scale(outward, 2 * under)), under = -under;
    if (under < GRAZING) d = daft_add(d, daft_scale(outward, GRAZING - under));
    return daft_normalize(d);
}

/* What happens to a ray at a surface between two indices. */
typedef struct interface {
    float eta;    /* the index on the viewer's side over the one beyond */
    float cosine; /* between the normal and the direction to the viewer, up to 1; more than 0, though smooth normals may
                     face away */
    float beyond; /* between the normal and the refracted ray; 0 where all is mirrored */
    float fresnel; /* fraction that is mirrored */
} interface;

static interface interface_at(float eta, float cosine)
{
    interface f = {eta, cosine > GRAZING ? (cosine < 1 ? cosine : 1) : GRAZING, 0, 1};
    if (eta == 1) f.beyond = f.cosine, f.fresnel = 0;
    float sine2 = eta * eta * (1 - f.cosine * f.cosine);
    if (eta == 1 || !(sine2 < 1)) return f;
    f.beyond = sqrtf(1 - sine2);
    float across = (eta * f.cosine - f.beyond) / (eta * f.cosine + f.beyond);
    float along = (f.cosine - eta * f.beyond) / (f.cosine + eta * f.beyond);
    f.fresnel = 0.5f * (across * across + along * along);
    return f;
}

/* By Snell's law; not bent at all between equal indices, to the bit. */
static daft_vec3 refracted(const interface *f, daft_vec3 view, daft_vec3 normal, daft_vec3 outward)
{
    if (f->eta == 1) return daft_neg(view);
    daft_vec3 d = daft_sub(daft_scale(normal, f->eta * f->cosine - f->beyond), daft_scale(view, f->eta));
    float over = daft_dot(d, outward);
    if (over > -GRAZING) d = daft_sub(d, daft_scale(outward, over + GRAZING));
    return daft_normalize(d);
}

/* `media`: that the ray is in; read where rays carry them. */
static void add_ray(const daft_batch *b, uint32_t i, daft_vec3 origin, daft_vec3 d, daft_vec3 weight,
                    const daft_media *media, daft_ray_batch *rays)
{
    uint32_t at = rays->count++;
    rays->origin.x[at] = origin.x, rays->origin.y[at] = origin.y, rays->origin.z[at] = origin.z;
    rays->direction.x[at] = d.x, rays->direction.y[at] = d.y, rays->direction.z[at] = d.z;
    rays->weight.x[at] = weight.x, rays->weight.y[at] = weight.y, rays->weight.z[at] = weight.z;
    rays->distance[at] = b->distance[i];
    rays->pixel[at] = b->pixel[i];
    if (rays->media) rays->media[at] = media[i];
}

static const daft_media *media_from(const daft_batch *b) { return b->media ? b->media->from : NULL; }
static const daft_media *media_beyond(const daft_batch *b) { return b->media ? b->media->beyond : NULL; }

static bool counts(daft_vec3 weight, float min) { return weight.x > min || weight.y > min || weight.z > min; }

/* What moves a point that lies closer than `margin` to the sides of its triangle, or beyond one by rounding, away from
 * them. */
static daft_vec3 off_sides(const daft_instance *instance, uint32_t triangle, daft_vec3 p, daft_vec3 normal,
                           float margin)
{
    const daft_trimesh *mesh = instance->mesh;
    const uint32_t *corner = &mesh->indices[3 * (size_t)triangle];
    daft_vec3 c[3], shift = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        c[k] =
            daft_affine_point(&instance->to_frame, daft_v3(mesh->x[corner[k]], mesh->y[corner[k]], mesh->z[corner[k]]));
    for (int k = 0; k < 3; k++) {
        daft_vec3 a = c[k], in = daft_normalize(daft_cross(normal, daft_sub(c[(k + 1) % 3], a)));
        if (daft_dot(in, daft_sub(c[(k + 2) % 3], a)) < 0) in = daft_neg(in);
        float inside = daft_dot(in, daft_sub(p, a));
        if (inside < margin) shift = daft_add(shift, daft_scale(in, margin - inside));
    }
    return shift;
}

/* Batches hold points that lie off the surface by e along `outward` and e along `view`; this one lies e beyond it, and
 * half as much again for the roundings on the way. Within e of a facet's side it may lie across the neighbouring one,
 * inside when it is meant to be outside or the other way round; so it is moved away from sides by as much. */
static daft_vec3 place_beyond(const daft_snapshot *snapshot, const daft_batch *b, uint32_t i)
{
    const daft_instance *instance = &snapshot->instances[b->instance[i]];
    daft_vec3 outward = lane3(&b->outward, i);
    daft_vec3 p = lane3(&b->point, i);
    float error = (fabsf(p.x) + fabsf(p.y) + fabsf(p.z) + b->extent[i]) * DAFT_SPAWN_ERROR;
    daft_vec3 on = daft_sub(p, daft_scale(daft_add(outward, lane3(&b->view, i)), error));
    if (instance->mesh) on = daft_add(on, off_sides(instance, b->triangle[i], on, outward, error));
    return daft_sub(on, daft_scale(outward, 1.5f * error));
}

/* A point that transmits: `mirror` is what its material mirrors besides. Where mirrored rays are not followed any more,
 * what can be refracted is, in full; what cannot still is mirrored, since that is the only way the light has. */
static void divide(const daft_snapshot *snapshot, const daft_batch *b, uint32_t i, float alpha, daft_vec3 mirror,
                   daft_vec3 weight, const daft_spawning *allowed, daft_ray_batch *mirror_rays,
                   daft_ray_batch *refracted_rays)
{
    const daft_surface *material = &snapshot->materials[b->material[i]];
    const bool rough = allowed->rough && alpha > 0;
    daft_vec3 view = lane3(&b->view, i), outward = lane3(&b->outward, i);
    daft_vec3 normal = facet_at(b, i, alpha, allowed);
    float eta = b->media ? b->media->eta[i] : b->inner[i] ? material->index : 1 / material->index;
    interface f = interface_at(eta, daft_dot(normal, view));
    if (!allowed->mirrors && f.fresnel < 1) f.fresnel = 0;
    const float opacity = b->traits & DAFT_TRAIT_BLEND ? b->varying->opacity[i] : 1;
    float fraction = material->transmission * f.fresnel * opacity;
    daft_vec3 back = daft_mul(weight, daft_add(mirror, daft_v3(fraction, fraction, fraction)));
    if (counts(back, allowed->min))
        add_ray(b, i, lane3(&b->point, i), mirrored(view, normal, outward, rough), back, media_from(b), mirror_rays);
    daft_vec3 on = daft_mul(weight, daft_scale(material->transmittance, (1 - f.fresnel) * opacity));
    if (counts(on, allowed->min))
        add_ray(b, i, place_beyond(snapshot, b, i), refracted(&f, view, normal, outward), on, media_beyond(b),
                refracted_rays);
}

/* What a surface that blends does not cover: straight on. */
static void pass_through(const daft_snapshot *snapshot, const daft_batch *b, uint32_t i, daft_vec3 weight, float min,
                         daft_ray_batch *rays)
{
    const daft_vec3 left = daft_scale(weight, 1 - b->varying->opacity[i]);
    if (counts(left, min))
        add_ray(b, i, place_beyond(snapshot, b, i), daft_neg(lane3(&b->view, i)), left, media_from(b), rays);
}

/* A surface within a medium that wins: it is not there. */
static void pass_by(const daft_snapshot *snapshot, const daft_batch *b, uint32_t i, float min, daft_ray_batch *rays)
{
    const daft_vec3 weight = lane3(&b->weight, i);
    if (rays && counts(weight, min))
        add_ray(b, i, place_beyond(snapshot, b, i), daft_neg(lane3(&b->view, i)), weight, media_beyond(b), rays);
}

static void spawn_twin(const daft_snapshot *snapshot, const daft_batch *b, const daft_spawning *allowed,
                       daft_ray_batch *mirror_rays, daft_ray_batch *refracted_rays, daft_ray_batch *straight_rays)
{
    const float share = 1 / (float)allowed->rays;
    const daft_varying *varying = b->traits & DAFT_TRAIT_VARIES ? b->varying : NULL;
    const bool blends = b->traits & DAFT_TRAIT_BLEND && refracted_rays && allowed->ray == 0;
    mirror_rays->count = 0;
    if (refracted_rays) refracted_rays->count = straight_rays->count = 0;
    for (uint32_t i = 0; i < b->count; i++) {
        const daft_surface *material = &snapshot->materials[b->material[i]];
        const float alpha = varying ? varying->alpha[i] : material->alpha;
        const bool rough = allowed->rough && alpha > 0;
        if (b->media && b->media->eta[i] == 0) {
            if (allowed->ray == 0) pass_by(snapshot, b, i, allowed->min, allowed->refracts ? straight_rays : NULL);
            continue;
        }
        if (blends && varying->opacity[i] < 1)
            pass_through(snapshot, b, i, lane3(&b->weight, i), allowed->min, straight_rays);
        if (allowed->ray && !rough) continue;
        daft_vec3 weight = rough ? daft_scale(lane3(&b->weight, i), share) : lane3(&b->weight, i);
        const daft_vec3 own = varying ? lane3(&varying->mirror, i) : material->mirror;
        daft_vec3 mirror = allowed->mirrors ? own : daft_v3(0, 0, 0);
        if (refracted_rays && allowed->refracts && material->transmission > 0) {
            divide(snapshot, b, i, alpha, mirror, weight, allowed, mirror_rays, refracted_rays);
            continue;
        }
        weight = daft_mul(weight, mirror);
        if (!counts(weight, allowed->min)) continue;
        const daft_vec3 normal = facet_at(b, i, alpha, allowed);
        daft_vec3 d = mirrored(lane3(&b->view, i), normal, lane3(&b->outward, i), rough);
        add_ray(b, i, lane3(&b->point, i), d, weight, media_from(b), mirror_rays);
    }
}

/* ---- batches ---- */

enum { INSTANCES = 12, MATERIALS = 6, POINTS = DAFT_BATCH };

typedef struct lists {
    daft_ray_batch mirrored, refracted, straight;
    daft_media media[3][DAFT_BATCH_ROOM];
} lists;

typedef struct stage {
    fixture_mesh large, tiny;
    daft_instance instances[INSTANCES];
    daft_surface materials[MATERIALS];
    daft_snapshot snapshot;
    daft_vec2 turns[1 << DAFT_TURN_BITS];
    daft_batch points;
    daft_varying varying;
    daft_crossings crossings;
    lists twin, fast;
} stage;

static void media_on(lists *l, bool on)
{
    l->mirrored.media = on ? l->media[0] : NULL;
    l->refracted.media = on ? l->media[1] : NULL;
    l->straight.media = on ? l->media[2] : NULL;
}

static stage *stage_make(void)
{
    stage *s = aligned_alloc(64, (sizeof *s + 63) / 64 * 64);
    memset(s, 0, sizeof *s);
    s->large = mesh_soup(100, 2, 0.5f), s->tiny = mesh_soup(100, 2, 1e-5f);
    for (uint32_t i = 0; i < INSTANCES; i++) {
        const daft_vec3 at = random_vec3(-5, 5), scale = daft_v3(1, i % 5 ? 1 : -1.4f, 1);
        s->instances[i] =
            i % 3 == 0 ? sphere_make(at, random_float(0.2f, 1.2f))
                       : instance_make(i % 3 == 1 ? &s->large : &s->tiny, affine_make(random_rotation(), scale, at));
    }
    for (uint32_t i = 0; i < MATERIALS; i++) {
        daft_surface *m = &s->materials[i];
        *m = (daft_surface){.index = i == 2 ? 1 : 1.5f, .texture = DAFT_NO_TEXTURE};
        if (i % 2) m->mirror = daft_v3(0.5f, 0.1f, 0);
        if (i > 1) m->transmission = 0.8f, m->transmittance = daft_v3(0.8f, 0.4f, 0.001f);
        if (i > 3) m->alpha = 0.2f;
    }
    for (int i = 0; i < 1 << DAFT_TURN_BITS; i++)
        s->turns[i] = (daft_vec2){cosf((float)i * 0.0245f), sinf((float)i * 0.0245f)};
    s->snapshot = (daft_snapshot){
        .instances = s->instances, .instance_count = INSTANCES, .materials = s->materials, .material_count = MATERIALS};
    return s;
}

static void stage_drop(stage *s)
{
    mesh_drop(&s->large);
    mesh_drop(&s->tiny);
    free(s);
}

static void put(daft_lanes3 *to, uint32_t i, daft_vec3 v) { to->x[i] = v.x, to->y[i] = v.y, to->z[i] = v.z; }

static daft_vec3 random_unit(void) { return daft_normalize(random_vec3(-1, 1)); }

/* Neighbours often lie on one triangle, and some right at its sides. */
static void fill_point(stage *s, uint32_t i)
{
    daft_batch *b = &s->points;
    const bool again = i && random_bits() % 2;
    b->instance[i] = again ? b->instance[i - 1] : random_bits() % INSTANCES;
    const daft_instance *t = &s->instances[b->instance[i]];
    b->triangle[i] = !t->mesh ? 0 : again ? b->triangle[i - 1] : random_bits() % t->mesh->triangle_count;
    b->material[i] = again ? b->material[i - 1] : random_bits() % MATERIALS;
    const daft_vec3 view = random_unit(), outward = random_unit();
    const daft_vec3 out = daft_dot(view, outward) < 0 ? daft_neg(outward) : outward;
    daft_vec3 p = daft_add(daft_v3(t->to_frame.t[0], t->to_frame.t[1], t->to_frame.t[2]), random_vec3(-1, 1));
    if (t->mesh) {
        const uint32_t *c = &t->mesh->indices[3 * (size_t)b->triangle[i]];
        const float u = random_bits() % 4 ? random_float(0, 1) : 0, v = random_float(0, 1 - u);
        const daft_vec3 x = daft_v3(t->mesh->x[c[0]], t->mesh->y[c[0]], t->mesh->z[c[0]]),
                        y = daft_v3(t->mesh->x[c[1]], t->mesh->y[c[1]], t->mesh->z[c[1]]),
                        z = daft_v3(t->mesh->x[c[2]], t->mesh->y[c[2]], t->mesh->z[c[2]]);
        p = daft_affine_point(&t->to_frame,
                              daft_add(daft_add(daft_scale(x, 1 - u - v), daft_scale(y, u)), daft_scale(z, v)));
    }
    put(&b->point, i, p), put(&b->view, i, view), put(&b->outward, i, out);
    put(&b->normal, i, daft_normalize(daft_add(out, random_vec3(-0.3f, 0.3f))));
    put(&b->weight, i, random_bits() % 8 ? random_vec3(0, 1) : daft_v3(0, 0, 1e-5f));
    b->extent[i] = random_float(0, 9), b->distance[i] = random_float(1, 50), b->pixel[i] = random_bits() % DAFT_BATCH;
    b->inner[i] = random_bits() % 2;
    daft_varying *v = &s->varying;
    v->alpha[i] = random_bits() % 2 ? random_float(0, 1) : 0,
    v->opacity[i] = random_bits() % 2 ? 1 : random_float(0, 1);
    put(&v->mirror, i, random_vec3(0, 0.3f));
    daft_crossings *c = &s->crossings;
    for (int k = 0; k < DAFT_MEDIA; k++)
        c->from[i].material[k] = random_bits() % 9, c->beyond[i].material[k] = random_bits() % 9;
    c->eta[i] = random_bits() % 3 ? random_float(0.5f, 2) : (float)(random_bits() % 2);
}

static void same_lanes(const daft_lanes3 *a, const daft_lanes3 *b, uint32_t count)
{
    assert_memory_equal(a->x, b->x, count * sizeof(float));
    assert_memory_equal(a->y, b->y, count * sizeof(float));
    assert_memory_equal(a->z, b->z, count * sizeof(float));
}

static void same_rays(const daft_ray_batch *a, const daft_ray_batch *b)
{
    assert_int_equal(a->count, b->count);
    same_lanes(&a->origin, &b->origin, a->count);
    same_lanes(&a->direction, &b->direction, a->count);
    same_lanes(&a->weight, &b->weight, a->count);
    assert_memory_equal(a->distance, b->distance, a->count * sizeof a->distance[0]);
    assert_memory_equal(a->pixel, b->pixel, a->count * sizeof a->pixel[0]);
    if (a->media) assert_memory_equal(a->media, b->media, a->count * sizeof *a->media);
}

static uint32_t total(const lists *l) { return l->mirrored.count + l->refracted.count + l->straight.count; }

/* Some round of what tile/secondary.c may ask. */
static daft_spawning any_spawning(const stage *s)
{
    const uint32_t rays = random_bits() % 2 ? 1 : 3;
    return (daft_spawning){.mirrors = random_bits() % 4,
                           .refracts = random_bits() % 4,
                           .min = 1.0f / 2048,
                           .rough = random_bits() % 2,
                           .ray = random_bits() % rays,
                           .rays = rays,
                           .column = 32 * (random_bits() % 40),
                           .row = 32 * (random_bits() % 20),
                           .round = random_bits(),
                           .salt = random_bits() % 4000,
                           .turns = s->turns};
}

static void all_send_the_same(void **unused)
{
    (void)unused;
    fixture_seed(91);
    stage *s = stage_make();
    daft_batch *b = &s->points;
    uint32_t rays = 0;
    for (int round = 0; round < 60; round++) {
        const bool media = random_bits() % 2, varies = random_bits() % 2;
        b->count = random_bits() % 4 ? random_bits() % (POINTS + 1) : POINTS;
        for (uint32_t i = 0; i < b->count; i++) fill_point(s, i);
        b->traits = DAFT_TRAIT_SENDS | (varies ? DAFT_TRAIT_VARIES | DAFT_TRAIT_BLEND : 0u);
        b->varying = varies ? &s->varying : NULL, b->media = media ? &s->crossings : NULL;
        media_on(&s->twin, media), media_on(&s->fast, media);
        const daft_spawning allowed = any_spawning(s);
        const bool mirrors_alone = random_bits() % 4 == 0;
        lists *t = &s->twin, *f = &s->fast;
        t->refracted.count = t->straight.count = f->refracted.count = f->straight.count = 0;
        spawn_twin(&s->snapshot, b, &allowed, &t->mirrored, mirrors_alone ? NULL : &t->refracted,
                   mirrors_alone ? NULL : &t->straight);
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            kernels(isa)->spawn(&s->snapshot, b, &allowed, &f->mirrored, mirrors_alone ? NULL : &f->refracted,
                                mirrors_alone ? NULL : &f->straight);
            same_rays(&f->mirrored, &t->mirrored);
            same_rays(&f->refracted, &t->refracted);
            same_rays(&f->straight, &t->straight);
        }
        rays += total(t);
    }
    print_message("%u rays\n", rays);
    assert_true(rays > 20000);
    stage_drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(all_send_the_same)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
