/* Rays that surfaces send on, mirrored and refracted, DAFT_VL points at a time, and the kernels of render/ in one
 * table.
 *
 * Where a surface transmits, Fresnel's equations (for light that is not polarised) divide what is transmitted between
 * the mirrored and the refracted ray, and Snell's law bends the latter; past the critical angle all of it is mirrored.
 * Which index lies on which side follows from the hit alone, by the surface's outer side, so nothing is carried along a
 * path: a camera may stand in glass, and parts may cross each other; what lies beyond a surface that is left counts as
 * air. Where materials have priorities or absorb, rays carry their media along (render/media.h), and tile/media.c has
 * found what each point's surface is between. Radiance is not scaled by the square of the index: it would be scaled
 * back where the light leaves again.
 *
 * Rough surfaces are facets (GGX: Walter, Marschner, Li, Torrance, "Microfacet Models for Refraction through Rough
 * Surfaces", EGSR 2007), each a smooth surface; a ray meets one of those that its viewer sees. Light that other facets
 * hide on its way is not lost but goes on from these; so a white surface under a white sky stays white.
 *
 * Rays are listed in the order of their points, those that go straight on before those that bend, whatever the number
 * of lanes: the light of a pixel is summed in that order. */
#include "render/dice.h"
#include "render/kernels.h"
#include "render/points/surface.h"
#include "shade/material_lanes.h"

#define GRAZING 1e-3f /* the sine of the least angle between a facet and a ray that leaves it */

typedef uint32_t vu __attribute__((vector_size(DAFT_VL * 4)));

/* What is asked of a batch, and where its rays go. */
typedef struct spawning {
    const daft_snapshot *snapshot;
    const daft_batch *b;
    const daft_spawning *allowed;
    const daft_varying *varying; /* NULL: no material of the batch's varies */
} spawning;

/* DAFT_VL points, from `first` on; those of `lanes` are there. */
typedef struct window {
    uint32_t first;
    vbits lanes;
    vf3 view, outward;
} window;

DAFT_INLINE vbits lanes_of(const daft_batch *b, uint32_t first) { return vbits_first_n((int)(b->count - first)); }

DAFT_INLINE window window_at(const daft_batch *b, uint32_t first, vbits lanes)
{
    return (window){first, lanes, load3(&b->view, first), load3(&b->outward, first)};
}

DAFT_INLINE vf3 mul3(vf3 a, vf3 b) { return (vf3){a.x * b.x, a.y * b.y, a.z * b.z}; }

/* The lanes in which some colour's weight is more than the least. */
DAFT_INLINE vbits that_count(vf3 weight, float min)
{
    const vf least = vf_set(min);
    return vbits_from_mask(vm_or(vm_or(vf_lt(least, weight.x), vf_lt(least, weight.y)), vf_lt(least, weight.z)));
}

/* ---- directions ---- */

/* Which of the turns all round, and an even number in 0..1, of each point's pixel: as daft_dice_turn and
 * daft_dice_part.
 */
DAFT_INLINE void throw_dice(const spawning *s, const window *w, vf *turn_x, vf *turn_y, vf *part)
{
    const daft_spawning *a = s->allowed;
    vi place = vi_if_then_else(vm_from_bits(w->lanes), vi_load(&s->b->pixel[w->first]), vi_set(0));
    if (a->place) place = vi_gather_index(a->place, place);
    const daft_dice first = daft_dice_throw(0, 0, a->round, a->salt);
    const vu x = (vu)(place & vi_set(DAFT_TILE - 1)) + a->column, y = (vu)(place >> __builtin_ctz(DAFT_TILE)) + a->row;
    const vu turn = x * DAFT_R2_X + y * DAFT_R2_Y + first.turn, radius = x * DAFT_R2_Y + y * DAFT_R2_X + first.radius;
    const vi number = (vi)((turn + a->ray * DAFT_GOLDEN) >> (32 - DAFT_TURN_BITS)) * vi_set(2);
    const float *turns = &a->turns[0].x;
    *turn_x = vf_gather_index(turns, number), *turn_y = vf_gather_index(turns + 1, number);
    *part = (vf_set((float)a->ray) + vf_convert_to((vi)(radius >> 8)) * vf_set(0x1p-24f)) / vf_set((float)a->rays);
}

/* As daft_axes_across. */
DAFT_INLINE void axes_across(vf3 n, vf3 *a, vf3 *b)
{
    const vf one = vf_set(1), sign = vf_if_then_else(vf_lt(n.z, vf_set(0)), -one, one);
    const vf p = -one / (sign + n.z), q = n.x * n.y * p;
    *a = (vf3){one + sign * n.x * n.x * p, sign * q, -sign * n.x};
    *b = (vf3){q, sign + n.y * n.y * p, -n.y};
}

/* The normals of facets that are seen (Dupuy, Benyoub, "Sampling Visible GGX Normals with Spherical Caps", HPG 2023);
 * the surface's own where that is smooth. */
DAFT_INLINE vf3 facet_normals(const spawning *s, const window *w, vf alpha, vm rough)
{
    const vf3 normal = load3(&s->b->normal, w->first);
    if (!(vbits_from_mask(rough) & w->lanes)) return normal;
    const vf zero = vf_set(0), one = vf_set(1), up = vf3_dot(w->view, normal), min = vf_set(GRAZING);
    vf turn_x, turn_y, part;
    vf3 x, y;
    throw_dice(s, w, &turn_x, &turn_y, &part);
    axes_across(normal, &x, &y);
    const vf3 v = unit3((vf3){alpha * vf3_dot(w->view, x), alpha * vf3_dot(w->view, y), vf_max(up, min)});
    const vf z = (one - part) * (one + v.z) - v.z, rest = one - z * z;
    const vf across = vf_if_then_else(vf_lt(zero, rest), vf_sqrt(rest), zero);
    const vf high = vf_max(z + v.z, vf_set(1e-6f));
    const vf3 h = {alpha * (across * turn_x + v.x), alpha * (across * turn_y + v.y), high};
    return select3(rough, unit3(add3(add3(scale3(x, h.x), scale3(y, h.y)), scale3(normal, h.z))), normal);
}

/* The mirrored directions; one that would enter the surface, which smooth normals can ask for, is bent to graze it, and
 * by facets is mirrored once more. */
DAFT_INLINE vf3 mirrored(const window *w, vf3 normal, vm rough)
{
    const vf zero = vf_set(0), min = vf_set(GRAZING);
    vf3 d = sub3(scale3(normal, vf_set(2) * vf3_dot(normal, w->view)), w->view);
    vf under = vf3_dot(d, w->outward);
    const vm again = vm_and(rough, vf_lt(under, zero));
    d = select3(again, sub3(d, scale3(w->outward, vf_set(2) * under)), d);
    under = vf_if_then_else(again, -under, under);
    d = select3(vf_lt(under, min), add3(d, scale3(w->outward, min - under)), d);
    return unit3(d);
}

/* What happens to rays at a surface between two indices. */
typedef struct interface {
    vm straight; /* these are the same: nothing happens */
    vf eta;      /* the index on the viewer's side over the one beyond */
    vf cosine;   /* between the normal and the direction to the viewer, up to 1; more than 0, though smooth normals may
                    face away */
    vf beyond;   /* between the normal and the refracted ray; 0 where all is mirrored */
    vf fresnel;  /* fraction that is mirrored */
} interface;

DAFT_INLINE interface interface_at(vf eta, vf cosine)
{
    const vf one = vf_set(1), zero = vf_set(0), min = vf_set(GRAZING);
    interface f = {.straight = vi_eq((vi)eta, (vi)one), .eta = eta};
    f.cosine = vf_if_then_else(vf_lt(min, cosine), vf_min(cosine, one), min);
    const vf rest = one - eta * eta * (one - f.cosine * f.cosine);
    const vm bends = vf_lt(zero, rest);
    f.beyond = vf_if_then_else(bends, vf_sqrt(rest), zero);
    const vf across = (eta * f.cosine - f.beyond) / (eta * f.cosine + f.beyond),
             along = (f.cosine - eta * f.beyond) / (f.cosine + eta * f.beyond);
    f.fresnel = vf_if_then_else(bends, vf_set(0.5f) * (across * across + along * along), one);
    f.beyond = vf_if_then_else(f.straight, f.cosine, f.beyond);
    f.fresnel = vf_if_then_else(f.straight, zero, f.fresnel);
    return f;
}

/* By Snell's law; not bent at all between equal indices, to the bit. */
DAFT_INLINE vf3 refracted(const window *w, const interface *f, vf3 normal)
{
    const vf min = vf_set(GRAZING);
    vf3 d = sub3(scale3(normal, f->eta * f->cosine - f->beyond), scale3(w->view, f->eta));
    const vf over = vf3_dot(d, w->outward);
    d = select3(vf_lt(-min, over), sub3(d, scale3(w->outward, over + min)), d);
    return select3(f->straight, flipped3(w->view), unit3(d));
}

/* ---- origins ---- */

/* Of DAFT_VL points' triangles, the corners in frame space; gives the lanes that have one. Neighbours mostly see the
 * same. */
static vbits shared_corners(const daft_instance *instance, uint32_t triangle, vbits lanes, vf3 c[3])
{
    const daft_trimesh *mesh = instance->mesh;
    if (!mesh) return 0;
    for (int k = 0; k < 3; k++) {
        const uint32_t v = mesh->indices[3 * (size_t)triangle + (size_t)k];
        c[k] = set3(daft_affine_point(&instance->to_frame, daft_v3(mesh->x[v], mesh->y[v], mesh->z[v])));
    }
    return lanes;
}

static vbits fetch_corners(const spawning *s, uint32_t first, vbits lanes, vf3 c[3])
{
    const uint32_t any = first + (uint32_t)__builtin_ctz(lanes);
    float at[9][DAFT_VL]; /* in object space: x, y, z of one after the other */
    const float *map[DAFT_VL];
    vbits triangles = 0;
    for (uint32_t i = 0; i < DAFT_VL; i++) {
        const uint32_t point = lanes >> i & 1 ? first + i : any;
        const daft_instance *instance = &s->snapshot->instances[s->b->instance[point]];
        const daft_trimesh *mesh = instance->mesh;
        map[i] = (const float *)&instance->to_frame;
        if (!mesh || !(lanes >> i & 1)) continue;
        const uint32_t *corner = &mesh->indices[3 * (size_t)s->b->triangle[point]];
        for (int k = 0; k < 3; k++) {
            const uint32_t v = corner[k];
            at[3 * k][i] = mesh->x[v], at[3 * k + 1][i] = mesh->y[v], at[3 * k + 2][i] = mesh->z[v];
        }
        triangles |= (vbits)1 << i;
    }
    if (!triangles) return 0;
    vf m[12];
    for (int k = 0; k < 12; k += 4) vf_gather_rows4(map, k, m + k);
    for (int k = 0; k < 3; k++) { /* as daft_affine_point */
        const vf x = vf_load(at[3 * k]), y = vf_load(at[3 * k + 1]), z = vf_load(at[3 * k + 2]);
        c[k] = (vf3){((m[0] * x + m[1] * y) + m[2] * z) + m[9], ((m[3] * x + m[4] * y) + m[5] * z) + m[10],
                     ((m[6] * x + m[7] * y) + m[8] * z) + m[11]};
    }
    return triangles;
}

static vbits corners_at(const spawning *s, uint32_t first, vbits lanes, vf3 c[3])
{
    const uint32_t any = first + (uint32_t)__builtin_ctz(lanes), instance = s->b->instance[any],
                   triangle = s->b->triangle[any];
    const vm same = vm_and(vi_eq(vi_load(&s->b->instance[first]), vi_set((int32_t)instance)),
                           vi_eq(vi_load(&s->b->triangle[first]), vi_set((int32_t)triangle)));
    if (lanes & ~vbits_from_mask(same)) return fetch_corners(s, first, lanes, c);
    return shared_corners(&s->snapshot->instances[instance], triangle, lanes, c);
}

/* What moves points that lie closer than `margin` to the sides of their triangles, or beyond one by rounding, away from
 * them. */
DAFT_INLINE vf3 off_sides(const vf3 c[3], vbits triangles, vf3 p, vf3 normal, vf margin)
{
    vf3 shift = set3(daft_v3(0, 0, 0));
    for (int k = 0; k < 3; k++) {
        const vf3 in = unit3(cross3(normal, sub3(c[(k + 1) % 3], c[k])));
        const vf other = vf3_dot(in, sub3(c[(k + 2) % 3], c[k])), own = vf3_dot(in, sub3(p, c[k]));
        const vm away = vf_lt(other, vf_set(0));
        const vf inside = vf_if_then_else(away, -own, own);
        const vm near = vm_and(vf_lt(inside, margin), vm_from_bits(triangles));
        const vf by = vf_if_then_else(away, inside - margin, margin - inside);
        shift = select3(near, add3(shift, scale3(in, by)), shift);
    }
    return shift;
}

/* Batches hold points that lie off the surface by e along `outward` and e along `view`; these lie e beyond it, and half
 * as much again for the roundings on the way. Within e of a facet's side they may lie across the neighbouring one,
 * inside when they are meant to be outside or the other way round; so they are moved away from sides by as much. */
static void place_beyond(const spawning *s, const window *w, vbits lanes, vf3 *out)
{
    const vf3 p = load3(&s->b->point, w->first);
    const vf error =
        (vf_abs(p.x) + vf_abs(p.y) + vf_abs(p.z) + vf_load(&s->b->extent[w->first])) * vf_set(DAFT_SPAWN_ERROR);
    vf3 on = sub3(p, scale3(add3(w->outward, w->view), error));
    vf3 corners[3];
    const vbits triangles = corners_at(s, w->first, lanes, corners);
    if (triangles) on = add3(on, off_sides(corners, triangles, on, w->outward, error));
    *out = sub3(on, scale3(w->outward, vf_set(1.5f) * error));
}

/* ---- rays ---- */

static const daft_media *media_from(const daft_batch *b) { return b->media ? b->media->from : NULL; }
static const daft_media *media_beyond(const daft_batch *b) { return b->media ? b->media->beyond : NULL; }

/* `media`: of the batch's points, that the rays are in; read where rays carry them. */
static void add_rays(const daft_batch *b, const window *w, vbits lanes, vf3 origin, vf3 d, vf3 weight,
                     const daft_media *media, daft_ray_batch *rays)
{
    uint32_t at = rays->count;
    compress3(&rays->origin, at, lanes, origin);
    compress3(&rays->direction, at, lanes, d);
    compress3(&rays->weight, at, lanes, weight);
    vf_compress_store(&rays->distance[at], lanes, vf_load(&b->distance[w->first]));
    vi_compress_store(&rays->pixel[at], lanes, vi_load(&b->pixel[w->first]));
    rays->count += (uint32_t)__builtin_popcount(lanes);
    for (vbits left = rays->media ? lanes : 0; left; left &= left - 1)
        rays->media[at++] = media[w->first + (uint32_t)__builtin_ctz(left)];
}

/* The lanes in which a surface lies within a medium that wins: it is not there. */
DAFT_INLINE vbits passed_by(const daft_batch *b, uint32_t first)
{
    return b->media ? vbits_from_mask(vi_eq(vi_load(&b->media->eta[first]), vi_set(0))) : 0;
}

/* What goes straight on: past surfaces that are not there, and what those that blend do not cover. */
static void spawn_straight(const spawning *s, daft_ray_batch *rays)
{
    const daft_batch *b = s->b;
    const bool blends = b->traits & DAFT_TRAIT_BLEND;
    for (uint32_t i = 0; i < b->count; i += DAFT_VL) {
        const vbits all = lanes_of(b, i), by = s->allowed->refracts ? passed_by(b, i) & all : 0;
        const vf3 weight = load3(&b->weight, i);
        vf left = vf_set(1);
        vbits through = 0;
        if (blends) {
            const vf opacity = vf_load(&s->varying->opacity[i]);
            through = vbits_from_mask(vf_lt(opacity, vf_set(1))) & all & ~passed_by(b, i);
            left = vf_if_then_else(vm_from_bits(through), vf_set(1) - opacity, left);
        }
        const vf3 rest = scale3(weight, left);
        const vbits lanes = (by | through) & that_count(rest, s->allowed->min);
        if (!lanes) continue;
        const window w = window_at(b, i, lanes);
        vf3 origin;
        place_beyond(s, &w, lanes, &origin);
        const uint32_t at = rays->count;
        add_rays(b, &w, lanes, origin, flipped3(w.view), rest, media_from(b), rays);
        for (vbits last = by & lanes; last; last &= last - 1) {
            const uint32_t lane = (uint32_t)__builtin_ctz(last);
            rays->media[at + (uint32_t)__builtin_popcount(lanes & ((1u << lane) - 1))] = b->media->beyond[i + lane];
        }
    }
}

/* How much of each surface is there. */
DAFT_INLINE vf opacity_at(const spawning *s, uint32_t first)
{
    return s->b->traits & DAFT_TRAIT_BLEND ? vf_load(&s->varying->opacity[first]) : vf_set(1);
}

/* Of points that transmit, `through`: where mirrored rays are not followed any more, what can be refracted is, in full;
 * what cannot still is mirrored, since that is the only way the light has. Changes what is mirrored, `mirror`, and
 * gives what happens at the surface. */
DAFT_INLINE interface divide(const spawning *s, const window *w, const material_reader *m, vbits through, vf3 normal,
                             vf3 *mirror)
{
    const daft_batch *b = s->b;
    const vf index = MATERIAL_WORD(m, index);
    const vm inside = vi_eq(vi_load(&b->inner[w->first]), vi_set(1));
    const vf eta = b->media ? vf_load(&b->media->eta[w->first]) : vf_if_then_else(inside, index, vf_set(1) / index);
    interface f = interface_at(eta, vf3_dot(normal, w->view));
    if (!s->allowed->mirrors) f.fresnel = vf_if_then_else(vf_lt(f.fresnel, vf_set(1)), vf_set(0), f.fresnel);
    const vf fraction = MATERIAL_WORD(m, transmission) * f.fresnel * opacity_at(s, w->first);
    const vf3 all = {mirror->x + fraction, mirror->y + fraction, mirror->z + fraction};
    *mirror = select3(vm_from_bits(through), all, *mirror);
    return f;
}

/* The rays of DAFT_VL points whose surfaces are there. `refracted_rays` NULL: none is followed. */
static void spawn_bent(const spawning *s, uint32_t i, vbits lanes, daft_ray_batch *mirror_rays,
                       daft_ray_batch *refracted_rays)
{
    const daft_batch *b = s->b;
    const daft_spawning *allowed = s->allowed;
    const material_reader m = read_materials(b, s->snapshot->materials, i);
    const vf zero = vf_set(0), alpha = s->varying ? vf_load(&s->varying->alpha[i]) : MATERIAL_WORD(&m, alpha);
    const vm rough = vm_and(vf_lt(zero, alpha), vm_from_bits(allowed->rough ? DAFT_ALL_LANES : 0));
    if (allowed->ray) lanes &= vbits_from_mask(rough);
    vf3 mirror = set3(daft_v3(0, 0, 0)), weight = load3(&b->weight, i);
    if (allowed->mirrors) mirror = s->varying ? load3(&s->varying->mirror, i) : MATERIAL_COLOR(&m, mirror);
    if (allowed->rays > 1) weight = select3(rough, scale3(weight, vf_set(1 / (float)allowed->rays)), weight);
    const vbits through = refracted_rays ? vbits_from_mask(vf_lt(zero, MATERIAL_WORD(&m, transmission))) & lanes : 0;
    const vbits some = through | (lanes & that_count(mul3(weight, mirror), allowed->min));
    if (!some) return;
    const window w = window_at(b, i, some);
    const vf3 normal = facet_normals(s, &w, alpha, rough);
    interface f;
    if (through) f = divide(s, &w, &m, through, normal, &mirror);
    const vf3 back = mul3(weight, mirror);
    const vbits mirrors = some & that_count(back, allowed->min);
    if (mirrors)
        add_rays(b, &w, mirrors, load3(&b->point, i), mirrored(&w, normal, rough), back, media_from(b), mirror_rays);
    if (!through) return;
    const vf passed = (vf_set(1) - f.fresnel) * opacity_at(s, i);
    const vf3 on = mul3(weight, scale3(MATERIAL_COLOR(&m, transmittance), passed));
    const vbits refracts = through & that_count(on, allowed->min);
    if (!refracts) return;
    vf3 origin;
    place_beyond(s, &w, refracts, &origin);
    add_rays(b, &w, refracts, origin, refracted(&w, &f, normal), on, media_beyond(b), refracted_rays);
}

static void spawn(const daft_snapshot *snapshot, const daft_batch *b, const daft_spawning *allowed,
                  daft_ray_batch *mirror_rays, daft_ray_batch *refracted_rays, daft_ray_batch *straight_rays)
{
    const spawning s = {snapshot, b, allowed, b->traits & DAFT_TRAIT_VARIES ? b->varying : NULL};
    mirror_rays->count = 0;
    if (refracted_rays) refracted_rays->count = 0;
    if (straight_rays) straight_rays->count = 0;
    if (straight_rays && allowed->ray == 0 && (b->media || b->traits & DAFT_TRAIT_BLEND))
        spawn_straight(&s, straight_rays);
    for (uint32_t i = 0; i < b->count; i += DAFT_VL)
        spawn_bent(&s, i, lanes_of(b, i) & ~passed_by(b, i), mirror_rays, allowed->refracts ? refracted_rays : NULL);
}

const daft_render_kernels DAFT_KERNEL(daft_render) = {.surfaces = DAFT_KERNEL(daft_surfaces),
                                                      .listed_surfaces = DAFT_KERNEL(daft_listed_surfaces),
                                                      .hit_points = DAFT_KERNEL(daft_hit_points),
                                                      .spawn = spawn,
                                                      .ids = DAFT_KERNEL(daft_tile_ids),
                                                      .contrast = DAFT_KERNEL(daft_find_contrast),
                                                      .take_edges = DAFT_KERNEL(daft_take_edges),
                                                      .gather_light = DAFT_KERNEL(daft_gather_light),
                                                      .add_light = DAFT_KERNEL(daft_add_light),
                                                      .corners = DAFT_KERNEL(daft_find_corners),
                                                      .match_corners = DAFT_KERNEL(daft_match_corners),
                                                      .mix_corners = DAFT_KERNEL(daft_mix_corners),
                                                      .filter_noise = DAFT_KERNEL(daft_filter_noise),
                                                      .filter_spread = DAFT_KERNEL(daft_filter_spread),
                                                      .filter_pass = DAFT_KERNEL(daft_filter_pass),
                                                      .reuse = DAFT_KERNEL(daft_reuse),
                                                      .enlarge = DAFT_KERNEL(daft_enlarge),
                                                      .take_light = DAFT_KERNEL(daft_take_light),
                                                      .sum_candidates = DAFT_KERNEL(daft_sum_candidates),
                                                      .draw_light = DAFT_KERNEL(daft_draw_light),
                                                      .skip_middle = DAFT_KERNEL(daft_skip_middle),
                                                      .rectangle_rays = DAFT_KERNEL(daft_rectangle_rays)};
