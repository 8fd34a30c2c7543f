/* Ambient, Lambert and Phong light over batches of points. `facing` says which points a light may reach (in front of
 * the surface, inside a spot's cone), `direct_light` adds a light to those, `scatter` writes points' light to their
 * pixels. Phong, "Illumination for Computer Generated Pictures" (1975): the specular term is the cosine between the
 * mirrored light and the viewer, raised to the material's shininess. */
#include "shade/kernels.h"
#include "shade/batch_lanes.h"

/* Bright suns make the sum of harmonics fall below 0 on the other side. */
static __attribute__((noinline)) vf3 ambient_by_normal(const daft_batch *batch, uint32_t i, const daft_ambient *ambient)
{
    const vf3 n = lanes_load(&batch->normal, i);
    const vf one = vf_set(1), zero = vf_set(0);
    const vf factors[DAFT_HARMONICS] = {
        one, n.x, n.y, n.z, n.x * n.y, n.y * n.z, n.x * n.z, vf_set(3) * n.z * n.z - one, n.x * n.x - n.y * n.y};
    vf3 sum = {zero, zero, zero};
    for (int k = 0; k < DAFT_HARMONICS; k++) {
        const daft_vec3 h = ambient->harmonics[k];
        sum =
            (vf3){sum.x + factors[k] * vf_set(h.x), sum.y + factors[k] * vf_set(h.y), sum.z + factors[k] * vf_set(h.z)};
    }
    return (vf3){vf_max(sum.x, zero), vf_max(sum.y, zero), vf_max(sum.z, zero)};
}

DAFT_INLINE vf3 ambient_light(const daft_batch *batch, const material_reader *m, uint32_t i,
                              const daft_ambient *ambient)
{
    const bool varies = batch->traits & DAFT_TRAIT_VARIES;
    vf3 reflected =
        varies ? lanes_load(&batch->varying->ambient, i) : times_albedo(batch, i, MATERIAL_COLOR(m, ambient));
    vf3 emitted = varies ? lanes_load(&batch->varying->emission, i) : MATERIAL_COLOR(m, emission);
    vf3 color = {vf_set(ambient->color.x), vf_set(ambient->color.y), vf_set(ambient->color.z)};
    if (ambient->by_normal) color = ambient_by_normal(batch, i, ambient);
    return (vf3){emitted.x + reflected.x * color.x, emitted.y + reflected.y * color.y,
                 emitted.z + reflected.z * color.z};
}

static void ambient(daft_batch *batch, const daft_surface *materials, const daft_ambient *all)
{
    for (uint32_t i = 0; i < batch->count; i += DAFT_VL) {
        material_reader m = read_materials(batch, materials, i);
        lanes_store(&batch->light, i, ambient_light(batch, &m, i, all));
    }
}

/* Unit vectors to the light. */
DAFT_INLINE vf3 direction_to(const daft_batch *batch, const daft_light_source *source, uint32_t i)
{
    if (source->sun) return (vf3){vf_set(source->to_light.x), vf_set(source->to_light.y), vf_set(source->to_light.z)};
    vf3 p = lanes_load(&batch->point, i);
    vf3 l = {vf_set(source->position.x) - p.x, vf_set(source->position.y) - p.y, vf_set(source->position.z) - p.z};
    vf length2 = vf3_dot(l, l);
    vf scale = vf_if_then_else(vf_lt(vf_set(0), length2), vf_set(1) / vf_sqrt(length2), vf_set(0));
    return (vf3){l.x * scale, l.y * scale, l.z * scale};
}

/* The fraction of a spot's intensity in the direction -l: a cubic between the cosines of its two angles (Pharr, Jakob,
 * Humphreys, "Physically Based Rendering", 4th edition, 12.2.1). */
DAFT_INLINE vf cone_falloff(const daft_light_source *source, vf3 l)
{
    daft_vec3 a = source->to_light;
    vf cosine = vf3_dot(l, (vf3){vf_set(a.x), vf_set(a.y), vf_set(a.z)});
    vf t = vf_clamp01((cosine - vf_set(source->cone_cosine)) * vf_set(source->cone_scale));
    return t * t * (vf_set(3) - vf_set(2) * t);
}

/* What distance leaves of a light: 1 at the light, smoothly down to 0 where its range ends; or 1 at a metre, with the
 * end that KHR_lights_punctual gives a range. */
DAFT_INLINE vf distance_falloff(const daft_batch *batch, const daft_light_source *source, uint32_t i)
{
    const vf3 p = lanes_load(&batch->point, i);
    const vf3 l = {vf_set(source->position.x) - p.x, vf_set(source->position.y) - p.y,
                   vf_set(source->position.z) - p.z};
    const vf d2 = vf3_dot(l, l), gone = d2 * vf_set(source->range > 0 ? 1 / (source->range * source->range) : 0);
    if (source->inverse_square)
        return vf_max(vf_set(1) - gone * gone, vf_set(0)) / vf_max(d2, vf_set(1e-4f)); /* m²: of a centimetre */
    const vf left = vf_max(vf_set(1) - gone, vf_set(0));
    return left * left;
}

static void extent(const daft_lanes3 *points, uint32_t count, daft_vec3 *low, daft_vec3 *high)
{
    const float *const from[3] = {points->x, points->y, points->z};
    float *const to_low[3] = {&low->x, &low->y, &low->z}, *const to_high[3] = {&high->x, &high->y, &high->z};
    for (int k = 0; k < 3; k++) {
        vf min = vf_set(from[k][0]), max = min;
        for (uint32_t i = 0; i < count; i += DAFT_VL) {
            const vm some = vm_from_bits(vbits_first_n((int)(count - i)));
            const vf at = vf_if_then_else(some, vf_load(&from[k][i]), vf_set(from[k][0]));
            min = vf_min(min, at), max = vf_max(max, at);
        }
        *to_low[k] = vf_reduce_min(min), *to_high[k] = vf_reduce_max(max);
    }
}

static uint32_t facing(daft_batch *batch, const daft_light_source *source, uint32_t bits[DAFT_BATCH_WORDS])
{
    uint32_t total = 0;
    memset(bits, 0, DAFT_BATCH_WORDS * sizeof bits[0]);
    for (uint32_t i = 0; i < batch->count; i += DAFT_VL) {
        vf3 l = {vf_set(0), vf_set(0), vf_set(0)};
        vf cosine;
        if (!source->area || source->spot) l = direction_to(batch, source, i);
        if (source->area)
            DAFT_KERNEL(daft_area_form)(batch, i, source, &cosine);
        else
            cosine = vf3_dot(lanes_load(&batch->normal, i), l);
        vf_store(&batch->cosine[i], cosine);
        vbits lit = vbits_from_mask(vf_lt(vf_set(0), cosine)) & vbits_first_n((int)(batch->count - i));
        if (source->spot && lit) lit &= vbits_from_mask(vf_lt(vf_set(0), cone_falloff(source, l)));
        if (source->range > 0 && lit) lit &= vbits_from_mask(vf_lt(vf_set(0), distance_falloff(batch, source, i)));
        bits[i / 32] |= lit << (i % 32);
        total += (uint32_t)__builtin_popcount(lit);
    }
    return total;
}

/* Powers below this count as none: no byte of a picture shows them, and products with them are subnormal numbers, which
 * take a hundred cycles each. */
#define LEAST_POWER 0x1p-96f

/* Adds Phong's highlight. */
DAFT_INLINE void add_highlight_of(const daft_batch *batch, vf3 specular, vf shininess, uint32_t i, vf3 l, vf cosine,
                                  vf3 *sum)
{
    vf3 n = lanes_load(&batch->normal, i), view = lanes_load(&batch->view, i);
    vf mirrored = vf_set(2) * cosine * vf3_dot(n, view) - vf3_dot(l, view), zero = vf_set(0);
    vf power = vf_if_then_else(vf_lt(zero, mirrored), vf_pow(vf_clamp01(mirrored), shininess), zero);
    power = vf_if_then_else(vf_lt(vf_set(LEAST_POWER), power), power, zero);
    *sum = (vf3){sum->x + specular.x * power, sum->y + specular.y * power, sum->z + specular.z * power};
}

DAFT_INLINE void add_highlight(const daft_batch *batch, const material_reader *m, uint32_t i, vf3 l, vf cosine,
                               vf3 *sum)
{
    add_highlight_of(batch, MATERIAL_COLOR(m, specular), MATERIAL_WORD(m, shininess), i, l, cosine, sum);
}

/* What facets mirror of a light, times its cosine: GGX, Smith's term for both directions at once, Schlick's Fresnel;
 * and what they hide from each other, as vary_kernel.c says. A light's colour is what a white surface that faces it
 * sends on, so all is times pi. */
DAFT_INLINE vf3 facet_light(const daft_batch *batch, vf3 f0, vf alpha, uint32_t i, vf3 l, vf cosine)
{
    const vf zero = vf_set(0), one = vf_set(1), tiny = vf_set(1e-6f);
    const vf3 n = lanes_load(&batch->normal, i), view = lanes_load(&batch->view, i);
    const vf nv = vf_max(vf3_dot(n, view), vf_set(1e-3f)), nl = vf_max(cosine, zero);
    vf3 h = {l.x + view.x, l.y + view.y, l.z + view.z};
    const vf inverse = one / vf_sqrt(vf_max(vf3_dot(h, h), tiny));
    const vf nh = vf_clamp01(vf3_dot(n, h) * inverse), vh = vf_clamp01(vf3_dot(view, h) * inverse), a2 = alpha * alpha;
    const vf spread = nh * nh * (a2 - one) + one, d = a2 / vf_max(spread * spread, vf_set(1e-12f));
    const vf hidden = nl * vf_sqrt(nv * nv * (one - a2) + a2) + nv * vf_sqrt(nl * nl * (one - a2) + a2);
    const vf g = vf_set(0.5f) / vf_max(hidden, tiny), away = one - vh, away2 = away * away,
             steep = away2 * away2 * away;
    const vf rough = vf_sqrt(alpha), lost = one / (one - vf_set(0.55f) * rough) - one, all = d * g * nl;
    const vf3 f = {f0.x + (one - f0.x) * steep, f0.y + (one - f0.y) * steep, f0.z + (one - f0.z) * steep};
    return (vf3){f.x * all * (one + f0.x * lost), f.y * all * (one + f0.y * lost), f.z * all * (one + f0.z * lost)};
}

/* Of points that are not all Phong's. */
static __attribute__((noinline)) vf3 varying_light(const daft_batch *batch, uint32_t i, vf3 l, vf cosine)
{
    const daft_varying *v = batch->varying;
    const vf gloss = vf_load(&v->gloss[i]);
    const vf3 diffuse = lanes_load(&v->diffuse, i), specular = lanes_load(&v->specular, i);
    vf3 sum = {diffuse.x * cosine, diffuse.y * cosine, diffuse.z * cosine}, facets = {vf_set(0), vf_set(0), vf_set(0)};
    const vm physical = vf_lt(gloss, vf_set(0));
    const vbits some = vbits_from_mask(physical);
    vf3 phong = sum;
    if (some != DAFT_ALL_LANES) add_highlight_of(batch, specular, vf_max(gloss, vf_set(0)), i, l, cosine, &phong);
    if (!some) return phong;
    facets = facet_light(batch, specular, -gloss, i, l, cosine);
    return (vf3){vf_if_then_else(physical, sum.x + facets.x, phong.x),
                 vf_if_then_else(physical, sum.y + facets.y, phong.y),
                 vf_if_then_else(physical, sum.z + facets.z, phong.z)};
}

/* The width of a cosine lobe as high as Phong's, squared; and of one about as wide as that of GGX's facets, up to that
 * of Lambert's law. */
DAFT_INLINE vf phong_width2(vf shininess) { return vf_set(2) / (shininess + vf_set(1)); }
DAFT_INLINE vf facet_width2(vf alpha)
{
    const vf width = vf_max(vf_set(2) * alpha / (vf_set(1) + alpha), vf_set(1e-3f));
    return width * width;
}

/* The fraction of its surroundings that a surface shows by rays, by these rays' weight (vary_kernel.c). */
DAFT_INLINE vf shown_by_rays(vf3 mirror)
{
    const vf least = vf_set(DAFT_LEAST_MIRROR), weight = vf_max(vf_max(mirror.x, mirror.y), mirror.z);
    const vf all = vf_set(0.5f) * (least + vf_sqrt(least * (least + vf_set(4) * weight)));
    return vf_clamp01(all / least - vf_set(1));
}

/* The highlight of an area: what of it the lobe sees, times what the lobe reflects at all. Of facets that is a fit of
 * facet_light()'s sum over all directions, with Fresnel's term straight into the mirrored one. */
static __attribute__((noinline)) vf3 area_highlight(const daft_batch *batch, vf3 specular, vf gloss, vf3 mirror,
                                                    uint32_t i, const daft_light_source *source)
{
    const vf zero = vf_set(0), one = vf_set(1), alpha = vf_max(-gloss, zero);
    const vm physical = vf_lt(gloss, zero);
    const vf left = source->entity ? one - shown_by_rays(mirror) : one;
    if (!vbits_from_mask(vf_lt(zero, left))) return (vf3){zero, zero, zero};
    const vf width2 = vf_if_then_else(physical, facet_width2(alpha), phong_width2(vf_max(gloss, zero)));
    vf seen;
    DAFT_KERNEL(daft_area_gleam)(batch, i, source, &width2, &seen);
    if (source->entity) seen = seen * left;
    const vf away = one - vf_clamp01(vf3_dot(lanes_load(&batch->normal, i), lanes_load(&batch->view, i)));
    const vf away2 = away * away, steep = vf_if_then_else(physical, away2 * away2 * away, zero);
    const vf lost = vf_if_then_else(physical, one / (one - vf_set(0.55f) * vf_sqrt(alpha)) - one, zero);
    const vf all = seen * vf_if_then_else(physical, one - vf_set(0.6f) * alpha, width2);
    const vf3 f = {specular.x + (one - specular.x) * steep, specular.y + (one - specular.y) * steep,
                   specular.z + (one - specular.z) * steep};
    return (vf3){f.x * all * (one + specular.x * lost), f.y * all * (one + specular.y * lost),
                 f.z * all * (one + specular.z * lost)};
}

static __attribute__((noinline)) vf3 area_light(const daft_batch *batch, const material_reader *m, uint32_t i, vf form,
                                                const daft_light_source *source)
{
    const daft_varying *v = batch->traits & DAFT_TRAIT_VARIES ? batch->varying : NULL;
    const vf3 diffuse = v ? lanes_load(&v->diffuse, i) : times_albedo(batch, i, MATERIAL_COLOR(m, diffuse));
    vf3 sum = {diffuse.x * form, diffuse.y * form, diffuse.z * form};
    if (!v && !(batch->traits & DAFT_TRAIT_SPECULAR)) return sum;
    const vf3 specular = v ? lanes_load(&v->specular, i) : MATERIAL_COLOR(m, specular),
              mirror = v ? lanes_load(&v->mirror, i) : MATERIAL_COLOR(m, mirror);
    const vf gloss = v ? vf_load(&v->gloss[i]) : MATERIAL_WORD(m, shininess);
    const vf3 highlight = area_highlight(batch, specular, gloss, mirror, i, source);
    return (vf3){sum.x + highlight.x, sum.y + highlight.y, sum.z + highlight.z};
}

/* Lanes of points that send on nothing of a light, since their surface has no colour of its own and their highlight is
 * elsewhere. */
DAFT_INLINE vbits dark(const daft_batch *batch, const daft_surface *materials, const daft_light_source *source,
                       uint32_t i, bool varies)
{
    const vf zero = vf_set(0), cosine = vf_load(&batch->cosine[i]);
    const daft_varying *v = batch->varying;
    const material_reader m = read_materials(batch, materials, i);
    const vf3 diffuse = varies ? lanes_load(&v->diffuse, i) : MATERIAL_COLOR(&m, diffuse);
    const vf gloss = varies ? vf_load(&v->gloss[i]) : MATERIAL_WORD(&m, shininess);
    vm none = vf_le(vf_max(vf_max(diffuse.x, diffuse.y), diffuse.z), zero);
    if (varies) none = vm_and(none, vf_le(zero, gloss));
    if (!vbits_from_mask(none)) return 0;
    if (!varies && !(batch->traits & DAFT_TRAIT_SPECULAR)) return vbits_from_mask(none);
    vf3 sum = {zero, zero, zero};
    const vf3 specular = varies ? lanes_load(&v->specular, i) : MATERIAL_COLOR(&m, specular);
    add_highlight_of(batch, specular, gloss, i, direction_to(batch, source, i), cosine, &sum);
    return vbits_from_mask(vm_and(none, vf_le(vf_max(vf_max(sum.x, sum.y), sum.z), zero)));
}

static uint32_t skip_dark(const daft_batch *batch, const daft_surface *materials, const daft_light_source *source,
                          uint32_t lit[DAFT_BATCH_WORDS])
{
    const bool varies = batch->traits & DAFT_TRAIT_VARIES;
    uint32_t some = 0;
    for (uint32_t i = 0; i < batch->count; i += DAFT_VL) {
        const vbits bits = bits_at(lit, i);
        if (!bits) continue;
        const vbits left = bits & ~dark(batch, materials, source, i, varies);
        lit[i / 32] &= ~((uint32_t)(bits & ~left) << (i % 32));
        some += (uint32_t)__builtin_popcount(left);
    }
    return some;
}

static void direct_light(daft_batch *batch, const daft_surface *materials, const daft_light_source *source,
                         const uint32_t lit[DAFT_BATCH_WORDS], const daft_lanes3 *arriving, const daft_ambient *first)
{
    const vf zero = vf_set(0);
    const bool specular = batch->traits & DAFT_TRAIT_SPECULAR, varies = batch->traits & DAFT_TRAIT_VARIES;
    for (uint32_t i = 0; i < batch->count; i += DAFT_VL) {
        vbits bits = bits_at(lit, i);
        if (!bits && !first) continue;
        material_reader m = read_materials(batch, materials, i);
        vf3 light = first ? ambient_light(batch, &m, i, first) : lanes_load(&batch->light, i);
        if (!bits) {
            lanes_store(&batch->light, i, light);
            continue;
        }
        vf cosine = vf_load(&batch->cosine[i]);
        vf3 sum;
        if (source->area) {
            sum = area_light(batch, &m, i, cosine, source);
        } else if (varies) {
            sum = varying_light(batch, i, direction_to(batch, source, i), cosine);
        } else {
            sum = times_albedo(batch, i, MATERIAL_COLOR(&m, diffuse));
            sum = (vf3){sum.x * cosine, sum.y * cosine, sum.z * cosine};
            if (specular) add_highlight(batch, &m, i, direction_to(batch, source, i), cosine, &sum);
        }
        if (source->spot) {
            vf falloff = cone_falloff(source, direction_to(batch, source, i));
            sum = (vf3){sum.x * falloff, sum.y * falloff, sum.z * falloff};
        }
        if (source->range > 0 || source->inverse_square) {
            const vf left = distance_falloff(batch, source, i);
            sum = (vf3){sum.x * left, sum.y * left, sum.z * left};
        }
        if (arriving) {
            vf3 fraction = lanes_load(arriving, i);
            sum = (vf3){sum.x * fraction.x, sum.y * fraction.y, sum.z * fraction.z};
        }
        vm mask = vm_from_bits(bits);
        light.x = light.x + vf_if_then_else(mask, sum.x * vf_set(source->color.x), zero);
        light.y = light.y + vf_if_then_else(mask, sum.y * vf_set(source->color.y), zero);
        light.z = light.z + vf_if_then_else(mask, sum.z * vf_set(source->color.z), zero);
        lanes_store(&batch->light, i, light);
    }
}

/* ---- from points to pixels ---- */

/* Whether DAFT_VL points from i on are used and belong to neighbouring pixels of a row. */
DAFT_INLINE bool in_a_row(const uint32_t *pixel, uint32_t i, uint32_t count)
{
    vi row = vi_iota() + vi_set((int32_t)pixel[i]);
    return count - i >= DAFT_VL && vbits_from_mask(vi_eq(vi_load(&pixel[i]), row)) == DAFT_ALL_LANES;
}

static void scatter(daft_lanes3 *color, const uint32_t *pixel, uint32_t count, const daft_lanes3 *light)
{
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        uint32_t left = count - i;
        if (in_a_row(pixel, i, count)) {
            lanes_store(color, pixel[i], lanes_load(light, i));
            continue;
        }
        for (uint32_t k = i; k < i + DAFT_VL && k < i + left; k++) {
            uint32_t at = pixel[k];
            color->x[at] = light->x[k], color->y[at] = light->y[k], color->z[at] = light->z[k];
        }
    }
}

static void scatter_add(daft_lanes3 *color, const uint32_t *pixel, uint32_t count, const daft_lanes3 *weight,
                        const daft_lanes3 *light)
{
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        vf3 l = lanes_load(light, i), w = lanes_load(weight, i);
        vf3 part = {l.x * w.x, l.y * w.y, l.z * w.z};
        uint32_t at = pixel[i], left = count - i;
        if (in_a_row(pixel, i, count)) {
            vf3 c = lanes_load(color, at);
            lanes_store(color, at, (vf3){c.x + part.x, c.y + part.y, c.z + part.z});
            continue;
        }
        for (uint32_t k = 0; k < left && k < DAFT_VL; k++) {
            at = pixel[i + k];
            color->x[at] += part.x[k], color->y[at] += part.y[k], color->z[at] += part.z[k];
        }
    }
}

const daft_shade_kernels DAFT_KERNEL(daft_shade) = {
    .albedo = DAFT_KERNEL(daft_albedo),
    .vary = DAFT_KERNEL(daft_vary),
    .ambient = ambient,
    .extent = extent,
    .facing = facing,
    .skip_dark = skip_dark,
    .direct_light = direct_light,
    .sky = DAFT_KERNEL(daft_sky_color),
    .fog = DAFT_KERNEL(daft_fog_way),
    .fade = DAFT_KERNEL(daft_fade),
    .scatter = scatter,
    .scatter_add = scatter_add,
    .tone = DAFT_KERNEL(daft_tone_light),
    .encode = DAFT_KERNEL(daft_encode),
    .decode = DAFT_KERNEL(daft_decode),
};
