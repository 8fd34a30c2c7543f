/* What of a material depends on the place or on the direction it is seen from: maps of highlights, emission, exponents,
 * roughness, metal, occlusion and opacity, normals and heights, and physically based shading.
 *
 * Physically based: a metal reflects by its base colour, anything else by 4 % straight on (Burley, "Physically Based
 * Shading at Disney", 2012; alpha is the square of roughness), facets are GGX's and hide each other by Smith's term
 * (Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2), 2014). What they reflect
 * of all that comes from everywhere, E, is Karis's fit ("Physically Based Shading on Mobile", 2014); light that facets
 * hide from each other is not lost but scaled back in, which makes E 1 for white metal (Turquin, "Practical multiple
 * scattering compensation for microfacet models", 2019). The rest, 1 - E, is what lies below: base colour. So a white
 * sphere under a white sky is not seen, whatever its roughness.
 *
 * E of the surroundings comes by mirrored rays. Where these would add little, and where none are followed, the ambient
 * light stands for what they would see, the latter fading in over the least weight to twice it. */
#include "shade/batch_lanes.h"

#define DIELECTRIC 0.04f
#define LEAST_PART 0.125f

typedef struct place {
    daft_batch *batch;
    const daft_surface *materials;
    const daft_texture_data *textures;
    daft_texture_filter filter;
    const daft_vary_def *def;
    uint32_t maps; /* bits: those that some point's material has */
    uint32_t i;
} place;

/* Neighbours mostly share a material. */
static uint32_t maps_of(const daft_batch *batch, const daft_surface *materials)
{
    uint32_t maps = 0, last = UINT32_MAX;
    if (!(batch->traits & DAFT_TRAIT_MAPS)) return 0;
    for (uint32_t i = 0; i < batch->count; i++) {
        if (batch->material[i] == last) continue;
        last = batch->material[i];
        for (int k = 0; k < DAFT_MAPS; k++) maps |= (materials[last].maps[k] != DAFT_NO_TEXTURE ? 1u : 0u) << k;
    }
    return maps;
}

static bool has_map(const place *p, uint32_t map) { return p->maps >> map & 1; }

DAFT_INLINE vf3 times3(vf3 a, vf3 b) { return (vf3){a.x * b.x, a.y * b.y, a.z * b.z}; }
DAFT_INLINE vf3 scaled3(vf3 a, vf s) { return (vf3){a.x * s, a.y * s, a.z * s}; }
DAFT_INLINE vf3 choose3(vm m, vf3 a, vf3 b)
{
    return (vf3){vf_if_then_else(m, a.x, b.x), vf_if_then_else(m, a.y, b.y), vf_if_then_else(m, a.z, b.z)};
}
DAFT_INLINE vf3 grey(vf a) { return (vf3){a, a, a}; }
DAFT_INLINE vf3 unit3(vf3 a)
{
    vf length2 = vf3_dot(a, a);
    return scaled3(a, vf_if_then_else(vf_lt(vf_set(0), length2), vf_set(1) / vf_sqrt(length2), vf_set(0)));
}

static vf3 map_of(const place *p, uint32_t map, bool linear, vf *alpha)
{
    vf3 color = grey(vf_set(1));
    vf unused = vf_set(1);
    if (has_map(p, map)) DAFT_KERNEL(daft_map_color)
    (p->batch, p->materials, p->textures, p->filter, map, linear, p->i, &color, alpha ? alpha : &unused);
    return color;
}

/* ---- normals ---- */

/* Slopes in the surface, along u and v, of the map of normals and of that of heights; those without any have none. */
static void slopes_at(const place *p, const material_reader *m, vf *along_u, vf *along_v)
{
    const vf one = vf_set(1), half = vf_set(0.5f);
    vf3 n = {half, half, one}; /* of a flat place */
    vf unused = one, u = vf_set(0), v = u;
    if (has_map(p, DAFT_MAP_NORMAL)) DAFT_KERNEL(daft_map_color)
    (p->batch, p->materials, p->textures, p->filter, DAFT_MAP_NORMAL, true, p->i, &n, &unused);
    n = (vf3){n.x * vf_set(2) - one, n.y * vf_set(2) - one, n.z * vf_set(2) - one};
    /* 128 stands for 0: what is within half a step is flat */
    n.x = vf_if_then_else(vf_lt(vf_abs(n.x), vf_set(0.005f)), vf_set(0), n.x);
    n.y = vf_if_then_else(vf_lt(vf_abs(n.y), vf_set(0.005f)), vf_set(0), n.y);
    const vf up = vf_max(n.z, vf_set(0.01f)), strength = MATERIAL_WORD(m, normal_strength);
    if (has_map(p, DAFT_MAP_BUMP)) DAFT_KERNEL(daft_map_slopes)
    (p->batch, p->materials, p->textures, p->filter, p->i, &u, &v);
    const vf bump = MATERIAL_WORD(m, bump_strength);
    *along_u = n.x / up * strength - u * bump;
    *along_v = n.y / up * strength - v * bump;
}

/* The surface's axes at a right angle to its normal, which may be smooth, as glTF's are: of unit length, b on the side
 * of the bitangent. */
DAFT_INLINE void axes_at(const daft_varying *v, uint32_t i, vf3 n, vf3 *t, vf3 *b)
{
    const vf3 along = lanes_load(&v->tangent, i), across = lanes_load(&v->bitangent, i);
    const vf on = vf3_dot(along, n);
    *t = unit3((vf3){along.x - n.x * on, along.y - n.y * on, along.z - n.z * on});
    *b = (vf3){n.y * t->z - n.z * t->y, n.z * t->x - n.x * t->z, n.x * t->y - n.y * t->x};
    const vf side = vf_if_then_else(vf_lt(vf3_dot(*b, across), vf_set(0)), vf_set(-1), vf_set(1));
    *b = scaled3(*b, side);
}

/* A turned normal that would be seen from behind is held at the horizon: a viewer sees no facets that face away. */
static void turn_normals(const place *p, const material_reader *m)
{
    daft_batch *batch = p->batch;
    vf su, sv;
    vf3 t, b, n = lanes_load(&batch->normal, p->i);
    slopes_at(p, m, &su, &sv);
    axes_at(batch->varying, p->i, n, &t, &b);
    vf3 turned = unit3((vf3){n.x + t.x * su + b.x * sv, n.y + t.y * su + b.y * sv, n.z + t.z * su + b.z * sv});
    const vf3 view = lanes_load(&batch->view, p->i);
    const vf under = vf_min(vf3_dot(turned, view) - vf_set(0.01f), vf_set(0));
    turned = unit3((vf3){turned.x - view.x * under, turned.y - view.y * under, turned.z - view.z * under});
    const vm flat = vf_le(su * su + sv * sv, vf_set(0));
    lanes_store(&batch->normal, p->i, choose3(flat, n, turned));
}

/* ---- facets ---- */

/* E of a colour F0 straight on, seen by this cosine. */
DAFT_INLINE vf3 directional_albedo(vf3 f0, vf rough, vf cosine)
{
    const vf one = vf_set(1);
    const vf rx = one - rough, ry = vf_set(0.0425f) - rough * vf_set(0.0275f),
             rz = vf_set(1.04f) - rough * vf_set(0.572f), rw = rough * vf_set(0.022f) - vf_set(0.04f);
    const vf grazing = vf_min(rx * rx, vf_exp2(cosine * vf_set(-9.28f))) * rx + ry;
    const vf a = rz - grazing * vf_set(1.04f), b = rw + grazing * vf_set(1.04f), lost = one / (a + b) - one;
    vf3 e = {f0.x * a + b, f0.y * a + b, f0.z * a + b};
    return (vf3){vf_clamp01(e.x * (one + f0.x * lost)), vf_clamp01(e.y * (one + f0.y * lost)),
                 vf_clamp01(e.z * (one + f0.z * lost))};
}

/* The values of points whose material is physically based, in place of what Lambert and Phong have. */
static void make_physical(const place *p, const material_reader *m, vf3 base, vm which)
{
    daft_batch *batch = p->batch;
    daft_varying *v = batch->varying;
    const uint32_t i = p->i;
    const vf zero = vf_set(0), one = vf_set(1);
    const vf metal = vf_clamp01(MATERIAL_WORD(m, metallic) * map_of(p, DAFT_MAP_METALLIC, true, NULL).z),
             rough = vf_clamp01(MATERIAL_WORD(m, roughness) * map_of(p, DAFT_MAP_ROUGHNESS, true, NULL).y);
    const vf dielectric = (one - metal) * vf_set(DIELECTRIC);
    const vf3 f0 = {dielectric + base.x * metal, dielectric + base.y * metal, dielectric + base.z * metal};
    const vf cosine = vf_clamp01(vf3_dot(lanes_load(&batch->normal, i), lanes_load(&batch->view, i)));
    const vf3 e = directional_albedo(f0, rough, cosine);
    const vf most = vf_max(e.x, vf_max(e.y, e.z)) * (one - rough * vf_set(0.5f)), least = vf_set(DAFT_LEAST_MIRROR);
    const vf rays = p->def->mirrors ? vf_clamp01((most - least) / least) : zero;
    const vf3 below = {base.x * (one - metal) * (one - e.x), base.y * (one - metal) * (one - e.y),
                       base.z * (one - metal) * (one - e.z)};
    const vf3 around = scaled3(e, one - rays);
    const vf3 ambient = {below.x + around.x, below.y + around.y, below.z + around.z};
    lanes_store(&v->ambient, i, choose3(which, ambient, lanes_load(&v->ambient, i)));
    lanes_store(&v->diffuse, i, choose3(which, below, lanes_load(&v->diffuse, i)));
    lanes_store(&v->specular, i, choose3(which, f0, lanes_load(&v->specular, i)));
    lanes_store(&v->mirror, i, choose3(which, scaled3(e, rays), lanes_load(&v->mirror, i)));
    const vf alpha = rough * rough;
    vf_store(&v->gloss[i], vf_if_then_else(which, -vf_max(alpha, vf_set(0.002f)), vf_load(&v->gloss[i])));
    vf_store(&v->alpha[i], vf_if_then_else(which, alpha, vf_load(&v->alpha[i])));
}

/* ---- all of it ---- */

/* As the material says, and its maps. */
static void make_phong(const place *p, const material_reader *m)
{
    daft_batch *batch = p->batch;
    daft_varying *v = batch->varying;
    const uint32_t i = p->i;
    const vf3 albedo =
        batch->traits & (DAFT_TRAIT_TEXTURE | DAFT_TRAIT_COLORS) ? lanes_load(&batch->albedo, i) : grey(vf_set(1));
    vf3 ambient = albedo;
    vf unused = vf_set(1);
    if (has_map(p, DAFT_MAP_AMBIENT)) DAFT_KERNEL(daft_map_color)
    (batch, p->materials, p->textures, p->filter, DAFT_MAP_AMBIENT, false, i, &ambient, &unused);
    lanes_store(&v->ambient, i, times3(MATERIAL_COLOR(m, ambient), ambient));
    lanes_store(&v->diffuse, i, times3(MATERIAL_COLOR(m, diffuse), albedo));
    const vf3 specular = map_of(p, DAFT_MAP_SPECULAR, false, NULL);
    lanes_store(&v->specular, i, times3(MATERIAL_COLOR(m, specular), specular));
    lanes_store(&v->mirror, i, times3(MATERIAL_COLOR(m, mirror), specular));
    lanes_store(&v->emission, i, times3(MATERIAL_COLOR(m, emission), map_of(p, DAFT_MAP_EMISSION, false, NULL)));
    vf_store(&v->gloss[i], MATERIAL_WORD(m, shininess) * map_of(p, DAFT_MAP_SHININESS, true, NULL).y);
    const vf rough = MATERIAL_WORD(m, roughness) * map_of(p, DAFT_MAP_ROUGHNESS, true, NULL).y;
    vf_store(&v->alpha[i], rough * rough);
}

/* An image all around, in the direction that is mirrored: light as what the surface gives off by itself. */
static void add_reflection(const place *p, const material_reader *m)
{
    daft_varying *v = p->batch->varying;
    const uint32_t i = p->i;
    const vf3 n = lanes_load(&p->batch->normal, i), view = lanes_load(&p->batch->view, i);
    const vf twice = vf_set(2) * vf3_dot(n, view);
    vf3 light = grey(vf_set(0));
    DAFT_KERNEL(daft_map_around)
    (p->batch, p->materials, p->textures, p->filter, i,
     (vf3){n.x * twice - view.x, n.y * twice - view.y, n.z * twice - view.z}, &light);
    const vf3 part = times3(MATERIAL_COLOR(m, reflection), map_of(p, DAFT_MAP_SPECULAR, false, NULL)),
              emission = lanes_load(&v->emission, i);
    lanes_store(&v->emission, i,
                (vf3){emission.x + light.x * part.x, emission.y + light.y * part.y, emission.z + light.z * part.z});
}

/* What a map leaves of the ambient light (glTF 2.0, 3.9.3: 1 + strength · (red - 1)), also where that stands for what
 * rays would see; rays meet what stands around, and light sources have their shadows. */
static void occlude(const place *p, const material_reader *m)
{
    daft_varying *v = p->batch->varying;
    const vf one = vf_set(1), red = map_of(p, DAFT_MAP_OCCLUSION, true, NULL).x;
    const vf left = one + MATERIAL_WORD(m, occlusion_strength) * (red - one);
    lanes_store(&v->ambient, p->i, scaled3(lanes_load(&v->ambient, p->i), left));
}

/* The part of what a point stands for that a mask covers: 1/2 where alpha is the cutoff, and from there as fast to 0
 * and 1 as alpha changes across that, so that an outline is as wide as a sample (Golus, "Anti-aliased Alpha Test: The
 * Esoteric Alpha To Coverage", 2017, who takes the slope from neighbours). Where texels are smaller, alpha is a mean of
 * theirs already, and nearly the part that is covered: the cutoff goes to 1/2, which keeps outlines in their places,
 * and 0 and 1 stay what they are, so that leaves far away get neither thin nor fat (what Castano's "Computing Alpha
 * Mipmaps", 2010, scales alpha for). A part of less than LEAST_PART of a pixel is rounded to all or none: a path behind
 * it would cost as much as one behind a hole. */
DAFT_INLINE vf mask_coverage(const place *p, const material_reader *m, vf alpha)
{
    const vf zero = vf_set(0), one = vf_set(1), half = vf_set(0.5f), tiny = vf_set(1e-6f);
    const vf cutoff = MATERIAL_WORD(m, cutoff), most = MATERIAL_WORD(m, opacity);
    const vf hard = vf_if_then_else(vf_lt(vf_clamp01(alpha * most), cutoff), zero, one);
    if (!(p->def->sample_side > 0 && p->batch->traits & DAFT_TRAIT_MAPS)) return hard;
    const vf side = vf_load(&p->batch->footprint[p->i]) * vf_set(p->def->sample_side);
    const vf change = MATERIAL_WORD(m, steepness) * side, slope = one / vf_max(change, tiny);
    const vf middle = half + (cutoff / vf_max(most, tiny) - half) * vf_min(slope, one), over = alpha - middle;
    const vf to_end = vf_if_then_else(vf_lt(over, zero), middle, one - middle);
    const vf part = vf_clamp01(half + over * vf_max(slope, half / vf_max(to_end, tiny)));
    const vf3 weight = lanes_load(&p->batch->weight, p->i);
    const vf counts = vf_min(part, one - part) * vf_max(weight.x, vf_max(weight.y, weight.z));
    const vf rounded = vf_if_then_else(vf_lt(part, half), zero, one);
    const vf soft = vf_if_then_else(vf_lt(counts, vf_set(LEAST_PART)), rounded, part);
    return vf_if_then_else(vf_lt(zero, change), soft, hard); /* change: 0 of a mask without an outline */
}

/* What of a surface that blends is there: its light is as much less. */
static void make_opacity(const place *p, const material_reader *m)
{
    daft_varying *v = p->batch->varying;
    const uint32_t i = p->i;
    const vf one = vf_set(1), zero = vf_set(0);
    vf alpha = one;
    const vf3 c = map_of(p, DAFT_MAP_ALPHA, true, &alpha);
    const vi channel = (vi)MATERIAL_WORD(m, alpha_channel), traits = (vi)MATERIAL_WORD(m, traits);
    vf opacity = vf_if_then_else(vi_eq(channel, vi_set(3)), alpha, c.y);
    opacity = vf_if_then_else(vi_eq(channel, vi_set(0)), c.x, vf_if_then_else(vi_eq(channel, vi_set(2)), c.z, opacity));
    if (p->batch->traits & DAFT_TRAIT_FADES) opacity = opacity * vf_load(&v->opacity[i]);
    const vm masks = vf_lt(zero, MATERIAL_WORD(m, cutoff));
    const vf blended = vf_clamp01(opacity * MATERIAL_WORD(m, opacity));
    opacity = vbits_from_mask(masks) ? vf_if_then_else(masks, mask_coverage(p, m, opacity), blended) : blended;
    const vm blends = vi_eq(traits & vi_set(DAFT_TRAIT_BLEND), vi_set(DAFT_TRAIT_BLEND));
    opacity = p->def->lets_through ? vf_if_then_else(blends, opacity, one) : one;
    vf_store(&v->opacity[i], opacity);
    daft_lanes3 *const all[] = {&v->ambient, &v->diffuse, &v->specular, &v->mirror, &v->emission};
    for (size_t k = 0; k < DAFT_COUNT_OF(all); k++) lanes_store(all[k], i, scaled3(lanes_load(all[k], i), opacity));
}

void DAFT_KERNEL(daft_vary)(daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                            daft_texture_filter filter, const daft_vary_def *def)
{
    place p = {batch, materials, textures, filter, def, maps_of(batch, materials), 0};
    for (; p.i < batch->count; p.i += DAFT_VL) {
        const material_reader m = read_materials(batch, materials, p.i);
        if (batch->traits & DAFT_TRAIT_TANGENT) turn_normals(&p, &m);
        make_phong(&p, &m);
        const vi traits = (vi)MATERIAL_WORD(&m, traits) & vi_set(DAFT_TRAIT_PHYSICAL);
        const vm physical = vi_eq(traits, vi_set(DAFT_TRAIT_PHYSICAL));
        /* of a physical surface `diffuse` is the base colour */
        if (vbits_from_mask(physical)) make_physical(&p, &m, lanes_load(&batch->varying->diffuse, p.i), physical);
        if (batch->traits & DAFT_TRAIT_AROUND) add_reflection(&p, &m);
        if (batch->traits & DAFT_TRAIT_OCCLUSION) occlude(&p, &m);
        if (batch->traits & DAFT_TRAIT_BLEND)
            make_opacity(&p, &m);
        else
            vf_store(&batch->varying->opacity[p.i], vf_set(1));
    }
}
