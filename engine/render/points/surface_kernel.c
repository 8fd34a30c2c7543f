/* Surface points from hits: position, normal, texture coordinates and ray origins, for the pixels of a tile or a batch
 * of rays. The different triangles and spheres that the rays hit are listed (visible_kernel.c) and set up
 * (facet_kernel.c) first. Then DAFT_VL rays at a time read what was set up, by broadcast where all hit the same
 * triangle, else by gathering rows. Only what the tile's materials and the plan call for is stored.
 *
 * Points lie where their ray meets the triangle's plane, whose normal and height are taken in double once a triangle:
 * so a point's error is a few 2^-24 of its own distance along the ray, and less across the plane, even on a triangle
 * that reaches to the horizon. Rays that leave start off the surface by more than that, and than the rounding of their
 * transform into an instance's space. They start towards the viewer by as much again: in a concave corner a point may
 * lie across the other wall by its error, where going off its own surface, which runs along that wall, does not bring
 * it back; the path that its ray came along is free. No constant depends on the scene's scale. Shadow rays start from a
 * point raised to where the smooth surface would be, so that facets do not show in the terminator (Hanika, "Hacking the
 * Shadow Terminator", Ray Tracing Gems II, 2021, chapter 4). */
#include "render/points/surface.h"

#include "math/simd/elementary.h"

/* What a batch's points need beside their place, normal and material. */
enum {
    WANT_SHADOW = 1,  /* the shadow origin and the facet's normal */
    WANT_VIEW = 2,    /* the direction to the viewer */
    WANT_TEXTURE = 4, /* uv and the footprint */
    WANT_PATH = 8,    /* what rays that go on need: weight, reach, spawn error, which side is seen */
    WANT_DISTANCE = 16,
    WANT_COLOR = 32,   /* the vertices' colour */
    WANT_TANGENT = 64, /* where u and v grow */
    WANT_ALPHA = 128   /* the vertices' alpha, which comes with their colour */
};

static uint32_t wants_of(uint32_t traits, const daft_surfaces_def *def)
{
    uint32_t wants = (def->shadows ? WANT_SHADOW : 0u) | (def->distance ? WANT_DISTANCE : 0u);
    if (traits & DAFT_TRAIT_SPECULAR) wants |= WANT_VIEW;
    if (traits & DAFT_TRAIT_TEXTURE) wants |= WANT_TEXTURE | WANT_DISTANCE;
    if (traits & DAFT_TRAIT_COLORS) wants |= WANT_COLOR;
    if (traits & DAFT_TRAIT_FADES) wants |= WANT_ALPHA;
    if (traits & DAFT_TRAIT_VARIES) wants |= WANT_VIEW;
    if (traits & DAFT_TRAIT_MAPS) wants |= WANT_TEXTURE | WANT_DISTANCE;
    if (traits & DAFT_TRAIT_TANGENT) wants |= WANT_TANGENT;
    if (traits & DAFT_TRAIT_SENDS) wants |= WANT_SHADOW | WANT_VIEW | WANT_PATH | WANT_DISTANCE;
    return wants;
}

/* ---- rays and what they meet ---- */

/* DAFT_VL rays with what was set up for each. Camera rays begin at the frame's origin and go `focal` forwards; of
 * others it is known where they hit: the corners' weights on a triangle, t on a sphere. */
typedef struct window {
    vf3 origin, direction;
    vf u, v, t;
    const float *row; /* of the one facet that all meet */
    vf part[DAFT_FACET_FLOATS];
} window;

/* Where they meet it. `normal` is not unit yet, and the points lie on the surface. */
typedef struct meeting {
    vf3 point, shadow_origin, normal, outward;
    vf3 color, tangent, bitangent;
    vf size, density, u, v, alpha;
    vi word;
} meeting;

/* Constants where this is inlined: what sort of window it is. */
typedef struct sort {
    bool camera, uniform;
} sort;

DAFT_INLINE vf part(const window *w, sort s, int k) { return s.uniform ? vf_set(w->row[k]) : w->part[k]; }
DAFT_INLINE vf3 part3(const window *w, sort s, int k)
{
    return (vf3){part(w, s, k), part(w, s, k + 1), part(w, s, k + 2)};
}

DAFT_INLINE vf3 mean3(const vf3 a[3], const vf w[3])
{
    return (vf3){a[0].x * w[0] + a[1].x * w[1] + a[2].x * w[2], a[0].y * w[0] + a[1].y * w[1] + a[2].y * w[2],
                 a[0].z * w[0] + a[1].z * w[1] + a[2].z * w[2]};
}

DAFT_INLINE void corner_weights(const window *r, sort s, vf w[3])
{
    vf zero = vf_set(0), one = vf_set(1);
    if (!s.camera) {
        w[0] = one - r->u - r->v, w[1] = r->u, w[2] = r->v;
        return;
    }
    for (int k = 0; k < 3; k++) w[k] = vf3_dot(part3(r, s, FACET_EDGE + 3 * k), r->direction);
    vf sum = w[0] + w[1] + w[2], sign = vf_if_then_else(vf_lt(sum, zero), -one, one);
    for (int k = 0; k < 3; k++) w[k] = vf_max(w[k] * sign, zero);
    sum = w[0] + w[1] + w[2];
    vm some = vf_lt(zero, sum);
    vf fraction = one / sum;
    for (int k = 0; k < 3; k++) w[k] = vf_if_then_else(some, w[k] * fraction, vf_set(1.0f / 3));
}

/* Where the rays meet the plane, but no further than the triangle's nearest and farthest corners are along them: seen
 * edge-on, a plane says little. */
DAFT_INLINE vf3 plane_point(const window *r, sort s, vf3 outward)
{
    vf t = part(r, s, FACET_HEIGHT) / vf3_dot(outward, r->direction);
    t = vf_min(vf_max(t, part(r, s, FACET_LEAST)), part(r, s, FACET_MOST));
    vf3 along = scale3(r->direction, t);
    return s.camera ? along : add3(r->origin, along);
}

/* The corner's tangent plane pulls the point up where the point lies below it. */
DAFT_INLINE vf3 lift_point(const vf3 corner[3], const vf3 normal[3], vf3 point, const vf w[3])
{
    vf3 shadow_origin = point;
    for (int k = 0; k < 3; k++) {
        vf below = vf_min(vf3_dot(sub3(point, corner[k]), normal[k]), vf_set(0));
        shadow_origin = sub3(shadow_origin, scale3(normal[k], below * w[k]));
    }
    return shadow_origin;
}

/* Where u and v grow on the triangles, of any length; zero where they do not. */
DAFT_INLINE void facet_axes(const window *r, sort s, meeting *m)
{
    const vf3 from = part3(r, s, FACET_CORNER), a = sub3(part3(r, s, FACET_CORNER + 3), from),
              b = sub3(part3(r, s, FACET_CORNER + 6), from);
    const vf u = part(r, s, FACET_UV), v = part(r, s, FACET_UV + 1);
    const vf au = part(r, s, FACET_UV + 2) - u, av = part(r, s, FACET_UV + 3) - v;
    const vf bu = part(r, s, FACET_UV + 4) - u, bv = part(r, s, FACET_UV + 5) - v;
    const vf area = au * bv - bu * av, zero = vf_set(0);
    const vf side = vf_if_then_else(vf_lt(area, zero), vf_set(-1), vf_if_then_else(vf_lt(zero, area), vf_set(1), zero));
    m->tangent = scale3(sub3(scale3(a, bv), scale3(b, av)), side);
    m->bitangent = scale3(sub3(scale3(b, au), scale3(a, bu)), side);
}

/* A corner's colour; 1 where the facet has none. */
DAFT_INLINE vf3 facet_color(const window *r, sort s, int corner, vm colored)
{
    const vi word = (vi)part(r, s, FACET_COLOR + corner), mask = vi_set(1023);
    const vf scale = vf_set(1 / FACET_COLOR_MOST), one = vf_set(1);
    const vf x = vf_convert_to(word & mask) * scale, y = vf_convert_to((word >> 10) & mask) * scale,
             z = vf_convert_to((word >> 20) & mask) * scale;
    return select3(colored, (vf3){x * x, y * y, z * z}, (vf3){one, one, one});
}

/* Of corners that are alike, just what they have: what is there in full hides all. */
DAFT_INLINE vf facet_alpha(const window *r, sort s, const vf w[3], vm colored)
{
    const vf a = part(r, s, FACET_ALPHA), b = part(r, s, FACET_ALPHA + 1), c = part(r, s, FACET_ALPHA + 2);
    return vf_if_then_else(colored, a + (b - a) * w[1] + (c - a) * w[2], vf_set(1));
}

DAFT_INLINE void meet_facets(const window *r, sort s, vbits smooth, uint32_t wants, meeting *m)
{
    m->outward = m->normal = part3(r, s, FACET_OUTWARD);
    m->point = m->shadow_origin = plane_point(r, s, m->outward);
    m->size = part(r, s, FACET_SIZE);
    m->color = set3(daft_v3(1, 1, 1)), m->alpha = vf_set(1), m->tangent = m->bitangent = set3(daft_v3(0, 0, 0));
    if (!smooth && !(wants & (WANT_TEXTURE | WANT_COLOR))) return;
    vf w[3];
    corner_weights(r, s, w);
    if (wants & WANT_COLOR) {
        const vm colored = vi_eq(m->word & vi_set(FACET_COLORED), vi_set(FACET_COLORED));
        const vf3 c[3] = {facet_color(r, s, 0, colored), facet_color(r, s, 1, colored), facet_color(r, s, 2, colored)};
        m->color = mean3(c, w);
        if (wants & WANT_ALPHA) m->alpha = facet_alpha(r, s, w, colored);
    }
    if (wants & WANT_TANGENT) facet_axes(r, s, m);
    if (wants & WANT_TEXTURE) {
        m->density = part(r, s, FACET_DENSITY);
        m->u = part(r, s, FACET_UV) * w[0] + part(r, s, FACET_UV + 2) * w[1] + part(r, s, FACET_UV + 4) * w[2];
        m->v = part(r, s, FACET_UV + 1) * w[0] + part(r, s, FACET_UV + 3) * w[1] + part(r, s, FACET_UV + 5) * w[2];
    }
    if (!smooth) return;
    vf3 corner[3], normal[3];
    for (int k = 0; k < 3; k++)
        corner[k] = part3(r, s, FACET_CORNER + 3 * k), normal[k] = part3(r, s, FACET_NORMAL + 3 * k);
    vm which = vm_from_bits(smooth);
    m->normal = select3(which, mean3(normal, w), m->normal);
    if (wants & WANT_SHADOW) m->shadow_origin = select3(which, lift_point(corner, normal, m->point, w), m->point);
}

/* How far along rays from the origin, which are known to hit, the sphere is. As daft_pencil_sphere, in lanes. */
DAFT_INLINE vf sphere_way(vf3 centre, vf radius, vf3 d)
{
    vf dd = vf3_dot(d, d), along = vf3_dot(centre, d) / dd;
    vf3 aside = sub3(centre, scale3(d, along));
    vf half = vf_sqrt(vf_max(radius * radius - vf3_dot(aside, aside), vf_set(0)) / dd), near = along - half;
    return vf_if_then_else(vf_lt(vf_set(0), near), near, along + half);
}

/* The points as first found are pushed onto the sphere along its normal. */
DAFT_INLINE void meet_spheres(const window *r, sort s, uint32_t wants, meeting *m)
{
    vf3 centre = part3(r, s, SPHERE_CENTRE), d = r->direction;
    vf radius = part(r, s, SPHERE_RADIUS);
    vf3 near = s.camera ? scale3(d, sphere_way(centre, radius, d)) : add3(r->origin, scale3(d, r->t));
    vf3 normal = unit3(sub3(near, centre));
    m->point = m->shadow_origin = add3(centre, scale3(normal, radius));
    m->size = part(r, s, FACET_SIZE);
    m->color = set3(daft_v3(1, 1, 1)), m->alpha = vf_set(1), m->tangent = m->bitangent = set3(daft_v3(0, 0, 0));
    if (wants & WANT_TEXTURE) {
        vf3 local =
            unit3((vf3){vf3_dot(part3(r, s, SPHERE_TURN), normal), vf3_dot(part3(r, s, SPHERE_TURN + 3), normal),
                        vf3_dot(part3(r, s, SPHERE_TURN + 6), normal)});
        m->density = part(r, s, FACET_DENSITY);
        m->u = vf_set(0.5f) + vf_atan2(local.z, local.x) * vf_set(0.159154943f);
        m->v = vf_set(0.5f) + vf_asin(local.y) * vf_set(0.318309886f);
        if (wants & WANT_TANGENT) {
            const vf3 row[3] = {part3(r, s, SPHERE_TURN), part3(r, s, SPHERE_TURN + 3), part3(r, s, SPHERE_TURN + 6)};
            m->tangent = add3(scale3(row[0], -local.z), scale3(row[2], local.x));
            m->bitangent =
                add3(add3(scale3(row[0], -local.x * local.y), scale3(row[1], local.x * local.x + local.z * local.z)),
                     scale3(row[2], -local.z * local.y));
        }
    }
    const vm inner = vf_lt(vf_set(0), vf3_dot(normal, d));
    const vf side = vf_if_then_else(inner, vf_set(-1), vf_set(1));
    m->normal = m->outward = scale3(normal, side);
    m->word = vi_if_then_else(inner, m->word | vi_set(FACET_INNER), m->word & ~vi_set(FACET_INNER));
}

DAFT_INLINE void take_spheres(const window *r, sort s, vbits spheres, uint32_t wants, meeting *m)
{
    meeting b = *m;
    vm which = vm_from_bits(spheres);
    meet_spheres(r, s, wants, &b);
    m->word = vi_if_then_else(which, b.word, m->word);
    m->point = select3(which, b.point, m->point), m->shadow_origin = select3(which, b.shadow_origin, m->shadow_origin);
    m->normal = select3(which, b.normal, m->normal), m->outward = select3(which, b.outward, m->outward);
    m->size = vf_if_then_else(which, b.size, m->size), m->density = vf_if_then_else(which, b.density, m->density);
    m->u = vf_if_then_else(which, b.u, m->u), m->v = vf_if_then_else(which, b.v, m->v);
    if (wants & WANT_COLOR) m->color = select3(which, b.color, m->color);
    if (wants & WANT_ALPHA) m->alpha = vf_if_then_else(which, b.alpha, m->alpha);
    if (!(wants & WANT_TANGENT)) return;
    m->tangent = select3(which, b.tangent, m->tangent), m->bitangent = select3(which, b.bitangent, m->bitangent);
}

DAFT_INLINE vf3 at3(const vf *part, int k) { return (vf3){part[k], part[k + 1], part[k + 2]}; }
DAFT_INLINE void put3(vf *part, int k, vf3 a) { part[k] = a.x, part[k + 1] = a.y, part[k + 2] = a.z; }

/* The normal of triangles without area, on the side of their normals: it points along the ray. */
DAFT_INLINE vf3 normal_of_none(const window *r, vbits smooth)
{
    vf3 sum = set3(daft_v3(0, 0, 0));
    const vf3 back = flipped3(unit3(r->direction));
    if (!smooth) return back;
    for (int k = 0; k < 3; k++) sum = add3(sum, at3(r->part, FACET_NORMAL + 3 * k));
    return flip3(back, vm_and(vm_from_bits(smooth), vf_lt(vf3_dot(sum, back), vf_set(0))));
}

/* Turns facets to where their rays begin, and finds what else hangs on that. Spheres lose their first parts. */
DAFT_INLINE void face_rays(window *r, vbits smooth, vi *word)
{
    const vf3 corner[3] = {at3(r->part, FACET_FIRST), at3(r->part, FACET_OTHERS), at3(r->part, FACET_OTHERS + 3)};
    vf3 outward = at3(r->part, FACET_OUTWARD);
    const vm some = vf_lt(vf_set(0), vf3_dot(outward, outward));
    if (vbits_from_mask(some) != DAFT_ALL_LANES) outward = select3(some, outward, normal_of_none(r, smooth));
    const vf height = plane_height(outward, corner[0], r->origin);
    const vm behind = vf_lt(vf_set(0), height);
    put3(r->part, FACET_OUTWARD, flip3(outward, behind));
    corner_range(corner, r->origin, r->direction, &r->part[FACET_LEAST], &r->part[FACET_MOST]);
    r->part[FACET_HEIGHT] = vf_if_then_else(behind, -height, height);
    *word = vi_if_then_else(behind, *word ^ vi_set(FACET_INNER), *word);
    for (int k = 0; smooth && k < 3; k++)
        put3(r->part, FACET_NORMAL + 3 * k, flip3(at3(r->part, FACET_NORMAL + 3 * k), behind));
}

/* rows: the number of each ray's row. */
DAFT_INLINE void load_parts(window *r, const daft_facets *f, const int32_t *rows, int from, int end)
{
    enum { EIGHTS = DAFT_FACET_FLOATS / 8 };
    int32_t eighth[DAFT_VL];
    if (r->row) {
        for (int k = 8 * from; k < 8 * end; k++) r->part[k] = vf_set(r->row[k]);
        return;
    }
    vi_store(eighth, vi_load(rows) * vi_set(EIGHTS));
    for (int k = from; k < end; k++) vf_gather_rows8(f->row[0] + 8 * k, eighth, r->part + 8 * k);
}

DAFT_INLINE void meet_mixed(window *r, bool camera, const daft_facets *f, const int32_t *rows, uint32_t wants,
                            meeting *m)
{
    const sort s = {camera, false};
    load_parts(r, f, rows, 0, 1);
    m->word = (vi)r->part[FACET_WORD];
    vbits smooth = vbits_from_mask(vi_lt(m->word, vi_set(0)));
    vbits spheres = vbits_from_mask(vi_eq(m->word & vi_set(FACET_SPHERE), vi_set(FACET_SPHERE)));
    const bool more = (smooth | spheres) || (wants & (WANT_TEXTURE | WANT_COLOR));
    if (more || !camera) load_parts(r, f, rows, 1, more ? 5 : 2);
    if (wants & (WANT_TEXTURE | WANT_COLOR)) load_parts(r, f, rows, 5, 6);
    m->density = m->u = m->v = vf_set(0);
    if (spheres == DAFT_ALL_LANES) {
        meet_spheres(r, s, wants, m);
        return;
    }
    vf ball[SPHERE_RADIUS + 1];
    for (int k = 0; k <= SPHERE_RADIUS; k++) ball[k] = r->part[k];
    if (!camera) face_rays(r, smooth, &m->word);
    meet_facets(r, s, smooth, wants, m);
    if (!spheres) return;
    for (int k = 0; k <= SPHERE_RADIUS; k++) r->part[k] = ball[k];
    take_spheres(r, s, spheres, wants, m);
}

/* Gives whether it has one normal. */
DAFT_INLINE bool meet_uniform(window *r, const daft_facets *f, int32_t slot, uint32_t wants, meeting *m)
{
    const sort s = {true, true};
    int32_t word;
    r->row = f->row[slot];
    memcpy(&word, &r->row[FACET_WORD], sizeof word);
    m->word = vi_set(word);
    m->density = m->u = m->v = vf_set(0);
    if (word & FACET_SPHERE)
        meet_spheres(r, s, wants, m);
    else
        meet_facets(r, s, word & FACET_SMOOTH ? DAFT_ALL_LANES : 0, wants, m);
    return !(word & (FACET_SMOOTH | FACET_SPHERE));
}

/* How far rays start off the surface. `view` has about unit length, towards the viewer. */
DAFT_INLINE vf3 spawn_offset(vf3 point, vf size, vf3 outward, vf3 view)
{
    vf error = (vf_abs(point.x) + vf_abs(point.y) + vf_abs(point.z) + size) * vf_set(DAFT_SPAWN_ERROR);
    return scale3(add3(outward, view), error);
}

/* Off the surface, and into the batch. */
DAFT_INLINE void store_meeting(const meeting *m, vf3 direction, vf3 normal, vf reach, float focal, uint32_t wants,
                               daft_batch *b, uint32_t at)
{
    vf3 view = scale3(unit3(direction), vf_set(-1));
    vf3 off = spawn_offset(m->point, m->size, m->outward, view);
    store3(&b->point, at, add3(m->point, off));
    store3(&b->normal, at, normal);
    vi_store(&b->material[at], m->word & vi_set(FACET_MATERIAL));
    if (wants & WANT_SHADOW) {
        store3(&b->shadow_origin, at, add3(m->shadow_origin, off));
        store3(&b->outward, at, m->outward);
    }
    if (wants & WANT_VIEW) store3(&b->view, at, view);
    if (wants & WANT_DISTANCE) vf_store(&b->distance[at], reach);
    if (wants & WANT_TEXTURE) {
        vf cosine = vf_max(vf_abs(vf3_dot(m->outward, view)), vf_set(0.01f)), spread = reach / vf_set(focal);
        vf_store(&b->footprint[at], spread * m->density / vf_sqrt(cosine));
        vf_store(&b->u[at], m->u), vf_store(&b->v[at], m->v);
    }
    if (wants & WANT_COLOR) store3(&b->albedo, at, m->color);
    if (wants & WANT_ALPHA) vf_store(&b->varying->opacity[at], m->alpha);
    if (wants & WANT_TANGENT)
        store3(&b->varying->tangent, at, m->tangent), store3(&b->varying->bitangent, at, m->bitangent);
    if (!(wants & WANT_PATH)) return;
    vf_store(&b->extent[at], m->size);
    vi_store(&b->inner[at], (m->word >> __builtin_ctz(FACET_INNER)) & vi_set(1));
}

/* ---- footprints ---- */

/* Two diameters of what a pixel sees across its ray: at the point of a camera ray, how far the rays of the pixels to
 * the right and above pass; of other rays, of a cone as wide as the path from the camera is long (Akenine-Möller et
 * al., "Improved Shader and Texture Level of Detail Using Ray Cones", JCGT 10(1), 2021). For planar mirrors that is the
 * camera's again, but for the picture's perspective; that curved surfaces spread rays, or gather them, it leaves out.
 */
typedef struct across {
    vf3 first, second;
} across;

DAFT_INLINE across across_camera(const daft_pencil *p, vf3 direction, vf reach)
{
    const vf t = reach / vf_sqrt(vf3_dot(direction, direction));
    return (across){scale3(set3(p->right), t), scale3(set3(p->up), t)};
}

DAFT_INLINE across across_cone(vf3 direction, vf reach, float focal)
{
    const vf zero = vf_set(0), width = reach / vf_set(focal);
    const vm steep = vf_lt(vf_set(0.7f), vf_abs(direction.y)); /* two at right angles to it: by y, or else by x */
    const vf3 first = unit3((vf3){vf_if_then_else(steep, zero, direction.z), vf_if_then_else(steep, -direction.z, zero),
                                  vf_if_then_else(steep, direction.y, -direction.x)});
    const vf3 second = {direction.y * first.z - direction.z * first.y, direction.z * first.x - direction.x * first.z,
                        direction.x * first.y - direction.y * first.x};
    return (across){scale3(first, width), scale3(unit3(second), width)};
}

/* Along the ray onto the surface; seen edge-on, that has no end. */
DAFT_INLINE vf3 onto_surface(vf3 a, vf3 outward, vf3 unit)
{
    const vf cosine = vf_min(vf3_dot(outward, unit), vf_set(-0.01f));
    return sub3(a, scale3(unit, vf3_dot(outward, a) / cosine));
}

/* Vectors whose products with one in the surface are how far u and v go along it. */
typedef struct gradients {
    vf3 u, v;
} gradients;

DAFT_INLINE gradients facet_gradients(const window *r, sort s, vf3 outward)
{
    const vf3 from = part3(r, s, FACET_CORNER), a = sub3(part3(r, s, FACET_CORNER + 3), from),
              b = sub3(part3(r, s, FACET_CORNER + 6), from);
    const vf u = part(r, s, FACET_UV), v = part(r, s, FACET_UV + 1);
    const vf au = part(r, s, FACET_UV + 2) - u, av = part(r, s, FACET_UV + 3) - v;
    const vf bu = part(r, s, FACET_UV + 4) - u, bv = part(r, s, FACET_UV + 5) - v;
    const vf3 of_a = cross3(b, outward), of_b = cross3(outward, a);
    const vf area = vf3_dot(a, of_a), some = vf_abs(area), zero = vf_set(0);
    const vf scale = vf_if_then_else(vf_lt(zero, some), vf_set(1) / area, zero);
    return (gradients){scale3(add3(scale3(of_a, au), scale3(of_b, bu)), scale),
                       scale3(add3(scale3(of_a, av), scale3(of_b, bv)), scale)};
}

/* u goes once round a parallel, v along half a meridian. */
DAFT_INLINE gradients sphere_gradients(const window *r, sort s, vf3 point)
{
    const vf radius = part(r, s, SPHERE_RADIUS);
    const vf3 normal = unit3(sub3(point, part3(r, s, SPHERE_CENTRE)));
    const vf3 row[3] = {part3(r, s, SPHERE_TURN), part3(r, s, SPHERE_TURN + 3), part3(r, s, SPHERE_TURN + 6)};
    const vf3 local = unit3((vf3){vf3_dot(row[0], normal), vf3_dot(row[1], normal), vf3_dot(row[2], normal)});
    const vf parallel = vf_max(vf_sqrt(local.x * local.x + local.z * local.z), vf_set(1e-3f));
    const vf3 east = unit3(add3(scale3(row[0], -local.z), scale3(row[2], local.x))), up = unit3(row[1]);
    const vf3 north = unit3(sub3(up, scale3(normal, vf3_dot(up, normal))));
    return (gradients){scale3(east, vf_set(0.159154943f) / (parallel * radius)),
                       scale3(north, vf_set(0.318309886f) / radius)};
}

DAFT_INLINE void store_footprint(const window *r, sort s, const meeting *m, across a, daft_batch *b, uint32_t at)
{
    const vf3 unit = unit3(r->direction);
    const vf3 first = onto_surface(a.first, m->outward, unit), second = onto_surface(a.second, m->outward, unit);
    const vm sphere = vi_eq(m->word & vi_set(FACET_SPHERE), vi_set(FACET_SPHERE));
    gradients along = facet_gradients(r, s, m->outward);
    if (vbits_from_mask(sphere)) {
        const gradients ball = sphere_gradients(r, s, m->point);
        along = (gradients){select3(sphere, ball.u, along.u), select3(sphere, ball.v, along.v)};
    }
    daft_footprints *out = b->footprints;
    vf_store(&out->first_u[at], vf3_dot(first, along.u)), vf_store(&out->first_v[at], vf3_dot(first, along.v));
    vf_store(&out->second_u[at], vf3_dot(second, along.u)), vf_store(&out->second_v[at], vf3_dot(second, along.v));
}

/* What a footprint reads of a window: a copy, so that the window stays in registers where no footprint is wanted. */
DAFT_INLINE void copy_for_footprint(window *to, const window *r, bool uniform, vi word)
{
    to->direction = r->direction, to->row = r->row;
    if (uniform) return;
    for (int k = FACET_CORNER; k < FACET_UV + 6; k++) to->part[k] = r->part[k];
    if (!vbits_from_mask(vi_eq(word & vi_set(FACET_SPHERE), vi_set(FACET_SPHERE)))) return;
    for (int k = 0; k < SPHERE_TURN + 9; k++) to->part[k] = r->part[k];
}

/* Not part of the functions that call them: only one filter asks. */
static __attribute__((noinline)) void camera_footprint(const window *r, bool uniform, const daft_pencil *p,
                                                       const meeting *m, vf reach, daft_batch *b, uint32_t at)
{
    const across a = across_camera(p, r->direction, reach);
    if (uniform)
        store_footprint(r, (sort){true, true}, m, a, b, at);
    else
        store_footprint(r, (sort){true, false}, m, a, b, at);
}

static __attribute__((noinline)) void cone_footprint(const window *r, const meeting *m, vf reach, float focal,
                                                     daft_batch *b, uint32_t at)
{
    store_footprint(r, (sort){false, false}, m, across_cone(r->direction, reach, focal), b, at);
}

/* ---- points that the camera sees ---- */

DAFT_INLINE vf3 rays_at(const daft_pencil *p, vf x, vf y)
{
    vf f = vf_set(p->focal);
    return (vf3){vf_set(p->right.x) * x + vf_set(p->up.x) * y + vf_set(p->forward.x) * f,
                 vf_set(p->right.y) * x + vf_set(p->up.y) * y + vf_set(p->forward.y) * f,
                 vf_set(p->right.z) * x + vf_set(p->up.z) * y + vf_set(p->forward.z) * f};
}

DAFT_INLINE vf3 pixel_rays(const daft_pencil *p, daft_vec3 first, const uint32_t *pixel)
{
    vi number = vi_load(pixel);
    return rays_at(p, vf_set(first.x) + vf_convert_to(number & vi_set(DAFT_TILE - 1)),
                   vf_set(first.y) - vf_convert_to(number >> __builtin_ctz(DAFT_TILE)));
}

static void setup_visible(const daft_snapshot *snapshot, const daft_pencil *p, daft_facets *f)
{
    const facet_rays rays = {set3(daft_v3(0, 0, 0)), set3(p->forward), set3(daft_scale(p->forward, 1 / p->focal))};
    f->traits = 0, f->one_material = true, f->last_material = UINT32_MAX;
    DAFT_KERNEL(daft_facets_fetch)(snapshot, f, 0);
    for (uint32_t i = 0; i < f->count; i += DAFT_VL) {
        DAFT_KERNEL(daft_facets_fetch)(snapshot, f, i + DAFT_VL);
        DAFT_KERNEL(daft_facets_setup)(snapshot, f, i, daft_min_u(DAFT_VL, f->count - i), &rays);
    }
}

/* A facet that is not smooth has one normal for all its points. */
typedef struct flat_normal {
    int32_t slot;
    vf3 unit;
} flat_normal;

/* `first`: the ray of the tile's first pixel; NULL: points have their rays' x and y in u and v. */
static void visible_points(const daft_pencil *p, const daft_vec3 *first, const daft_facets *f, uint32_t wants,
                           daft_batch *b)
{
    flat_normal kept = {.slot = -1};
    const bool footprints = b->footprints && wants & WANT_TEXTURE;
    window r = {.row = NULL}, copy = {.row = NULL}; /* once: a debug build cannot tell that each reads what it set */
    for (uint32_t i = 0; i < b->count; i += DAFT_VL) {
        meeting m;
        vf3 normal;
        const int32_t *slots = &f->slot[i];
        r.direction = first ? pixel_rays(p, *first, &b->pixel[i]) : rays_at(p, vf_load(&b->u[i]), vf_load(&b->v[i]));
        const bool uniform = vbits_from_mask(vi_eq(vi_load(slots), vi_set(slots[0]))) == DAFT_ALL_LANES;
        if (uniform) {
            bool flat = meet_uniform(&r, f, slots[0], wants, &m);
            if (flat && kept.slot != slots[0]) kept = (flat_normal){slots[0], unit3(m.normal)};
            normal = flat ? kept.unit : unit3(m.normal);
        } else {
            r.row = NULL;
            meet_mixed(&r, true, f, slots, wants, &m);
            normal = unit3(m.normal);
        }
        vf reach = wants & WANT_DISTANCE ? vf_sqrt(vf3_dot(m.point, m.point)) : vf_set(0);
        store_meeting(&m, r.direction, normal, reach, p->focal, wants, b, i);
        if (footprints) {
            const meeting met = m;
            copy_for_footprint(&copy, &r, uniform, m.word);
            camera_footprint(&copy, uniform, p, &met, reach, b, i);
        }
        if (wants & WANT_PATH) store3(&b->weight, i, set3(daft_v3(1, 1, 1)));
    }
}

void DAFT_KERNEL(daft_surfaces)(const daft_surfaces_def *def, const daft_tile *tile, daft_facets *facets,
                                daft_batch *points, daft_ray_batch *sky)
{
    const daft_pencil *p = def->pencil;
    daft_vec3 first = daft_pencil_ray(p, tile->x, tile->y);
    DAFT_KERNEL(daft_tile_facets)(def->snapshot, tile, facets, points, sky);
    setup_visible(def->snapshot, p, facets);
    points->traits = facets->traits, points->one_material = facets->one_material;
    visible_points(p, &first, facets, wants_of(facets->traits, def), points);
    const daft_sky *all = &def->snapshot->sky;
    if (all->kind == DAFT_SKY_COLOR && !(all->sun_chord2 > 0) && !(def->snapshot->air.density > 0)) return;
    for (uint32_t i = 0; i < sky->count; i += DAFT_VL) store3(&sky->direction, i, pixel_rays(p, first, &sky->pixel[i]));
}

void DAFT_KERNEL(daft_listed_surfaces)(const daft_surfaces_def *def, const daft_seen_list *list, daft_facets *facets,
                                       daft_batch *points, daft_ray_batch *sky)
{
    const daft_pencil *p = def->pencil;
    DAFT_KERNEL(daft_list_facets)(def->snapshot, list, facets, points, sky);
    setup_visible(def->snapshot, p, facets);
    points->traits = facets->traits, points->one_material = facets->one_material;
    visible_points(p, NULL, facets, wants_of(facets->traits, def), points);
    for (uint32_t i = 0; i < sky->count; i += DAFT_VL)
        store3(&sky->direction, i, rays_at(p, vf_load(&sky->direction.x[i]), vf_load(&sky->direction.y[i])));
}

/* ---- hits of rays that were followed ---- */

static void take_rays(const daft_ray_batch *from, uint32_t ray, vbits lanes, uint32_t at, daft_batch *b)
{
    if (!lanes) return;
    compress3(&b->point, at, lanes, load3(&from->origin, ray));
    compress3(&b->view, at, lanes, load3(&from->direction, ray));
    compress3(&b->weight, at, lanes, load3(&from->weight, ray));
    vf_compress_store(&b->distance[at], lanes, vf_load(&from->distance[ray]));
    vi_compress_store(&b->pixel[at], lanes, vi_load(&from->pixel[ray]));
}

static void take_sky(const daft_ray_batch *from, uint32_t ray, vbits lanes, daft_ray_batch *sky)
{
    if (!lanes) return;
    compress3(&sky->direction, sky->count, lanes, load3(&from->direction, ray));
    compress3(&sky->weight, sky->count, lanes, load3(&from->weight, ray));
    vi_compress_store(&sky->pixel[sky->count], lanes, vi_load(&from->pixel[ray]));
    sky->count += (uint32_t)__builtin_popcount(lanes);
}

/* Appends the hits' rays, the origins for points, and lists what they hit, each facet once. */
static void take_hits(const daft_snapshot *snapshot, const daft_ray_batch *from, uint32_t first, const daft_hit *hits,
                      uint32_t count, daft_facets *f, daft_batch *b, daft_ray_batch *sky)
{
    finder known = {.snapshot = snapshot, .facets = f};
    uint32_t at = b->count, last = UINT32_MAX, last_triangle = 0, triangle = 0;
    int32_t slot = 0;
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        const uint32_t begin = at, ray = first + i, end = daft_min_u(DAFT_VL, count - i);
        vbits lanes = 0;
        for (uint32_t k = 0; k < end; k++) {
            const daft_hit *hit = &hits[i + k];
            if (hit->instance == UINT32_MAX) continue;
            if (hit->instance != last || hit->triangle != last_triangle) {
                last = hit->instance, last_triangle = hit->triangle;
                triangle = snapshot->instances[last].mesh ? last_triangle : 0;
                slot = find_slot(&known, last, triangle);
            }
            b->u[at] = hit->u, b->v[at] = hit->v, b->footprint[at] = hit->t;
            b->instance[at] = last, b->triangle[at] = triangle, f->slot[at - b->count] = slot;
            if (from->media) b->media->from[at] = from->media[ray + k];
            lanes |= (vbits)1 << k, at++;
        }
        take_rays(from, ray, lanes, begin, b);
        if (sky) take_sky(from, ray, vbits_first_n((int)end) & ~lanes, sky);
    }
    b->count = at;
}

/* Lanes past the last hit repeat it: all that a register reads was written. */
static void repeat_last(daft_batch *b, uint32_t first, int32_t *slots)
{
    const uint32_t last = b->count - 1, end = first + (b->count - first + DAFT_VL - 1) / DAFT_VL * DAFT_VL;
    float *all[] = {b->point.x, b->point.y, b->point.z, b->view.x,    b->view.y,
                    b->view.z,  b->u,       b->v,       b->footprint, b->distance};
    for (size_t k = 0; k < DAFT_COUNT_OF(all); k++)
        for (uint32_t at = last + 1; at < end; at++) all[k][at] = all[k][last];
    for (uint32_t at = last + 1; at < end; at++) slots[at - first] = slots[last - first];
}

static void setup_hit(const daft_snapshot *snapshot, daft_facets *f)
{
    f->traits = 0, f->last_material = UINT32_MAX;
    DAFT_KERNEL(daft_facets_fetch)(snapshot, f, 0);
    for (uint32_t i = 0; i < f->count; i += DAFT_VL) {
        DAFT_KERNEL(daft_facets_fetch)(snapshot, f, i + DAFT_VL);
        DAFT_KERNEL(daft_facets_setup)(snapshot, f, i, daft_min_u(DAFT_VL, f->count - i), NULL);
    }
}

void DAFT_KERNEL(daft_hit_points)(const daft_snapshot *snapshot, const daft_ray_batch *rays, uint32_t first,
                                  const daft_hit *hits, uint32_t count, daft_facets *facets, daft_batch *points,
                                  daft_ray_batch *sky)
{
    const uint32_t begin = points->count;
    window r = {.row = NULL}, copy = {.row = NULL}; /* as in visible_points */
    facets->count = 0;
    take_hits(snapshot, rays, first, hits, count, facets, points, sky);
    if (points->count == begin) return;
    repeat_last(points, begin, facets->slot);
    setup_hit(snapshot, facets);
    const bool textured = facets->tangents || facets->traits & (DAFT_TRAIT_TEXTURE | DAFT_TRAIT_MAPS);
    const uint32_t wants = WANT_SHADOW | WANT_VIEW | WANT_PATH | WANT_DISTANCE | (textured ? WANT_TEXTURE : 0u) |
                           (facets->colors ? WANT_COLOR : 0u) | (facets->fades ? WANT_ALPHA : 0u) |
                           (facets->tangents ? WANT_TANGENT : 0u);
    for (uint32_t at = begin; at < points->count; at += DAFT_VL) {
        const int32_t *slots = &facets->slot[at - begin];
        const vf3 direction = load3(&points->view, at);
        meeting m;
        r.origin = load3(&points->point, at), r.direction = direction;
        r.u = vf_load(&points->u[at]), r.v = vf_load(&points->v[at]), r.t = vf_load(&points->footprint[at]);
        const bool uniform = vbits_from_mask(vi_eq(vi_load(slots), vi_set(slots[0]))) == DAFT_ALL_LANES;
        r.row = uniform ? facets->row[slots[0]] : NULL;
        meet_mixed(&r, false, facets, slots, wants, &m);
        const vf reach = vf_load(&points->distance[at]) + r.t;
        store_meeting(&m, direction, unit3(m.normal), reach, snapshot->focal, wants, points, at);
        if (points->footprints && textured) {
            const meeting met = m;
            copy_for_footprint(&copy, &r, false, m.word);
            cone_footprint(&copy, &met, reach, snapshot->focal, points, at);
        }
    }
    points->traits |= facets->traits;
}
