/* The plan: which effects a frame can need. Tiles then decide by what they see. */
#include "render/internal.h"

/* Surfaces that blend, one behind the other: what lies behind the last that is looked through is opaque. Each takes a
 * batch of rays of a worker's memory, 58 KB, where something in the scene blends. */
enum { MOST_LAYERS = 32 };

static bool some_flag(const daft_snapshot *snapshot, uint32_t flags)
{
    for (uint32_t i = 0; i < snapshot->instance_count; i++)
        if (snapshot->instances[i].flags & flags) return true;
    return false;
}

static bool light_casts(const daft_snapshot *snapshot)
{
    for (uint32_t i = 0; i < snapshot->light_count; i++)
        if (snapshot->lights[i].casts_shadow) return true;
    return false;
}

static bool mirrors(const daft_surface *m) { return m->mirror.x > 0 || m->mirror.y > 0 || m->mirror.z > 0; }

static bool transmits(const daft_surface *m) { return m->transmission > 0; }

static bool absorbs(const daft_surface *m) { return m->transmission > 0 && daft_surface_absorbs(m); }

static bool ranks(const daft_surface *m) { return m->transmission > 0 && m->priority > 0; }

static bool blends(const daft_surface *m) { return m->traits & DAFT_TRAIT_BLEND; }

static bool blends_and_transmits(const daft_surface *m) { return transmits(m) && blends(m); }
static bool lets_through(const daft_surface *m) { return transmits(m) || blends(m); }

static bool varies(const daft_surface *m) { return m->traits & DAFT_TRAIT_VARIES; }

static bool needs_tangents(const daft_surface *m) { return m->traits & DAFT_TRAIT_TANGENT; }

/* Where light is bent, some of it is mirrored. */
static bool bends(const daft_surface *m) { return m->transmission > 0 && m->index != 1; }

typedef bool surface_test(const daft_surface *surface);

static bool has(const daft_snapshot *snapshot, const daft_instance *instance, surface_test *test)
{
    uint32_t slots = instance->mesh ? instance->mesh->slot_count : 1;
    for (uint32_t k = 0; k < (slots ? slots : 1); k++)
        if (test(&snapshot->materials[instance->materials[k]])) return true;
    return false;
}

/* Most often no material does, and materials are few where instances are many. */
static bool some_material(const daft_snapshot *snapshot, surface_test *test)
{
    for (uint32_t i = 0; i < snapshot->material_count; i++)
        if (test(&snapshot->materials[i])) return true;
    return false;
}

static bool is_rough(const daft_surface *m) { return m->alpha > 0 && (mirrors(m) || transmits(m)); }

static const char *shadow_reason(const daft_snapshot *snapshot, const daft_quality *quality, bool *run)
{
    *run = false;
    if (!quality->shadows) return "this quality has no shadows";
    if (snapshot->light_count == 0) return "the scene has no light";
    if (!light_casts(snapshot)) return "no light casts shadows";
    if (!some_flag(snapshot, DAFT_INSTANCE_CASTS_SHADOW | DAFT_INSTANCE_TINTS_SHADOW | DAFT_INSTANCE_FILTERS_SHADOW))
        return "nothing visible casts shadows";
    *run = true;
    return "lit points lie under something's bounds, seen from a light";
}

/* Whether the shadows of some light are asked by rays: those of areas always are. */
static bool light_has_size(const daft_snapshot *snapshot)
{
    for (uint32_t i = 0; i < snapshot->light_count; i++) {
        const daft_light_source *light = &snapshot->lights[i];
        if (light->casts_shadow && (light->area || light->radius > 0)) return true;
    }
    return false;
}

static const char *occlusion_reason(const daft_snapshot *s, bool *run)
{
    *run = false;
    if (!(s->occlusion > 0)) return "the scene asks for no ambient occlusion";
    if (s->quality.occlusion_samples == 0) return "this quality has no ambient occlusion";
    const daft_vec3 a = s->ambient.color;
    if (!s->ambient.by_normal && !(a.x > 0 || a.y > 0 || a.z > 0)) return "the scene has no ambient light";
    *run = some_flag(s, DAFT_INSTANCE_CASTS_SHADOW | DAFT_INSTANCE_FILTERS_SHADOW);
    return *run ? "a surface is seen" : "nothing visible casts shadows";
}

static const char *reflection_reason(const daft_snapshot *snapshot, const daft_quality *quality, bool *run)
{
    *run = false;
    if (quality->mirror_depth == 0) return "this quality has no reflections";
    *run = some_material(snapshot, mirrors) || some_material(snapshot, bends);
    return *run ? "a mirror is seen" : "no material mirrors";
}

daft_plan daft_plan_make(const daft_snapshot *snapshot)
{
    daft_plan plan = {.quality = &snapshot->quality};
    const char **why = plan.why, **none = plan.why_not_seen;
    why[DAFT_EFFECT_VISIBILITY] = "every picture";
    why[DAFT_EFFECT_SURFACE] = "a surface is seen", none[DAFT_EFFECT_SURFACE] = "no surface is seen";
    why[DAFT_EFFECT_TEXTURE] = "a textured surface is seen", none[DAFT_EFFECT_TEXTURE] = "no textured surface is seen";
    why[DAFT_EFFECT_SHADOW] = shadow_reason(snapshot, plan.quality, &plan.shadows);
    none[DAFT_EFFECT_SHADOW] =
        plan.shadows ? "no lit point lies under anything's bounds, seen from a light" : why[DAFT_EFFECT_SHADOW];
    plan.soft = plan.shadows && plan.quality->shadow_samples > 0 && light_has_size(snapshot);
    why[DAFT_EFFECT_OCCLUSION] = occlusion_reason(snapshot, &plan.occlusion);
    none[DAFT_EFFECT_OCCLUSION] = plan.occlusion ? "no surface is seen" : why[DAFT_EFFECT_OCCLUSION];
    plan.glossy = plan.quality->glossy_samples > 0 &&
                  (plan.quality->mirror_depth > 0 || plan.quality->refraction_depth > 0) &&
                  some_material(snapshot, is_rough);
    plan.samples_light = plan.soft || plan.occlusion;
    const bool sampled = plan.samples_light || plan.glossy;
    plan.denoise = sampled && plan.quality->denoise;
    why[DAFT_EFFECT_DENOISE] = "light is sampled";
    none[DAFT_EFFECT_DENOISE] = plan.denoise ? "no sampled light is seen"
                                : !sampled   ? "no light is sampled"
                                             : "this quality does not denoise";
    why[DAFT_EFFECT_LIGHTING] = "a lit surface is seen";
    none[DAFT_EFFECT_LIGHTING] =
        snapshot->light_count ? "no surface that faces a light is seen" : "the scene has no light";
    why[DAFT_EFFECT_REFLECTION] = reflection_reason(snapshot, plan.quality, &plan.may_reflect);
    none[DAFT_EFFECT_REFLECTION] = plan.may_reflect ? "no mirror is seen" : why[DAFT_EFFECT_REFLECTION];
    plan.tints = plan.shadows && some_material(snapshot, transmits) && some_flag(snapshot, DAFT_INSTANCE_TINTS_SHADOW);
    plan.colors = snapshot->colors;
    plan.varies = some_material(snapshot, varies);
    plan.tangents = plan.varies && some_material(snapshot, needs_tangents);
    plan.blends = plan.varies && some_material(snapshot, blends);
    plan.fades = plan.blends && snapshot->fades;
    plan.through_depth = plan.quality->refraction_depth;
    if (plan.blends) plan.through_depth = daft_max_i(plan.through_depth, MOST_LAYERS);
    plan.through_lists = plan.blends && some_material(snapshot, blends_and_transmits) ? 2 : 1;
    plan.filters = plan.blends && (plan.shadows || plan.occlusion) && some_flag(snapshot, DAFT_INSTANCE_FILTERS_SHADOW);
    plan.may_refract = plan.through_depth > 0 && some_material(snapshot, lets_through);
    why[DAFT_EFFECT_REFRACTION] =
        plan.blends ? "something that transmits or blends is seen" : "something that transmits is seen";
    none[DAFT_EFFECT_REFRACTION] = plan.may_refract                      ? "nothing that transmits is seen"
                                   : plan.quality->refraction_depth == 0 ? "this quality has no refraction"
                                                                         : "no material transmits";
    plan.absorbs = some_material(snapshot, absorbs);
    plan.media = plan.absorbs || some_material(snapshot, ranks);
    plan.fog = snapshot->air.density > 0;
    why[DAFT_EFFECT_FOG] = "the scene has fog", none[DAFT_EFFECT_FOG] = "the scene has no fog";
    why[DAFT_EFFECT_SKY] = "the sky is seen", none[DAFT_EFFECT_SKY] = "the sky is not seen";
    why[DAFT_EFFECT_RESOLVE] = "every picture";
    const char **edges = &none[DAFT_EFFECT_ANTIALIASING];
    why[DAFT_EFFECT_ANTIALIASING] = "pixels differ from their neighbours";
    *edges = plan.quality->edge_samples ? "no pixel differs from its neighbours"
                                        : "this quality takes as many samples of all pixels";
    return plan;
}

static float beyond(float x, float low, float high) { return x < low ? low - x : x > high ? x - high : 0; }

static bool soft_light_reaches(const daft_snapshot *snapshot, const daft_instance *instance)
{
    for (uint32_t i = 0; i < snapshot->light_count; i++) {
        const daft_light_source *light = &snapshot->lights[i];
        if (!light->casts_shadow || !(light->area || light->radius > 0)) continue;
        const daft_vec3 away = daft_v3(beyond(light->position.x, instance->low.x, instance->high.x),
                                       beyond(light->position.y, instance->low.y, instance->high.y),
                                       beyond(light->position.z, instance->low.z, instance->high.z));
        if (light->area || light->sun || !(light->range > 0) ||
            daft_dot(away, away) <= light->range * light->range * 1.0001f)
            return true;
    }
    return false;
}

/* Where nothing is sampled, nothing is kept for the filter. With more samples of all pixels, the next may see more. */
static void narrow_sampling(daft_plan *plan, const daft_snapshot *snapshot, const daft_raster *raster)
{
    if (!plan->denoise || plan->quality->samples > 1 || plan->reflects || plan->refracts) return;
    bool reached = false;
    for (uint32_t i = 0; plan->soft && !reached && i < raster->instance_count; i++)
        reached = raster->visible[i].instance && soft_light_reaches(snapshot, raster->visible[i].instance);
    plan->soft = reached, plan->glossy = false;
    plan->samples_light = plan->soft || plan->occlusion;
    plan->denoise = plan->samples_light;
}

void daft_plan_narrow(daft_plan *plan, const daft_snapshot *snapshot, const daft_raster *raster)
{
    const bool asked = plan->may_reflect || plan->may_refract;
    plan->reflects = plan->refracts = false;
    for (uint32_t i = 0; asked && i < raster->instance_count && !(plan->reflects && plan->refracts); i++) {
        const daft_instance *instance = raster->visible[i].instance;
        if (!instance) continue;
        bool mirror = plan->may_reflect && (has(snapshot, instance, mirrors) || has(snapshot, instance, bends));
        plan->reflects |= mirror;
        plan->refracts |= plan->may_refract && (mirror || has(snapshot, instance, lets_through));
    }
    narrow_sampling(plan, snapshot, raster);
}
