/* The plan: which effects a frame can need. Tiles then decide by what they see. */
#include "render/internal.h"

static bool casts(const daft_snapshot *snapshot)
{
    for (uint32_t i = 0; i < snapshot->instance_count; i++)
        if (snapshot->instances[i].flags & DAFT_INSTANCE_CASTS_SHADOW) return true;
    return false;
}

static bool lamp_casts(const daft_snapshot *snapshot)
{
    for (uint32_t i = 0; i < snapshot->lamp_count; i++)
        if (snapshot->lamps[i].casts_shadow) return true;
    return false;
}

static bool mirrors(const daft_surface *m) { return m->mirror.x > 0 || m->mirror.y > 0 || m->mirror.z > 0; }

static bool some_mirror(const daft_snapshot *snapshot)
{
    for (uint32_t i = 0; i < snapshot->instance_count; i++) {
        const daft_instance *instance = &snapshot->instances[i];
        uint32_t slots = instance->mesh ? instance->mesh->slot_count : 1;
        for (uint32_t k = 0; k < (slots ? slots : 1); k++)
            if (mirrors(&snapshot->materials[instance->materials[k]])) return true;
    }
    return false;
}

static const char *shadow_reason(const daft_snapshot *snapshot, const daft_preset *preset, bool *run)
{
    *run = false;
    if (!preset->shadows) return "this quality has no shadows";
    if (snapshot->lamp_count == 0) return "the scene has no light";
    if (!lamp_casts(snapshot)) return "no light casts shadows";
    if (!casts(snapshot)) return "nothing visible casts shadows";
    *run = true;
    return "lit points lie under something's bounds, seen from a light";
}

static const char *reflection_reason(const daft_snapshot *snapshot, const daft_preset *preset, bool *run)
{
    *run = false;
    if (preset->reflections == 0) return "this quality has no reflections";
    if (!some_mirror(snapshot)) return "no material mirrors";
    *run = true;
    return "a mirror is seen";
}

daft_plan daft_plan_make(const daft_snapshot *snapshot)
{
    daft_plan plan = {.preset = daft_quality_preset(snapshot->quality)};
    const char **why = plan.why, **none = plan.why_not_seen;
    why[DAFT_EFFECT_VISIBILITY] = "every picture";
    why[DAFT_EFFECT_SURFACE] = "a surface is seen", none[DAFT_EFFECT_SURFACE] = "no surface is seen";
    why[DAFT_EFFECT_TEXTURE] = "a textured surface is seen", none[DAFT_EFFECT_TEXTURE] = "no textured surface is seen";
    why[DAFT_EFFECT_SHADOW] = shadow_reason(snapshot, plan.preset, &plan.shadows);
    none[DAFT_EFFECT_SHADOW] = plan.shadows ? "no lit point lies under anything's bounds, seen from a light" : why[DAFT_EFFECT_SHADOW];
    why[DAFT_EFFECT_LIGHTING] = "a lit surface is seen";
    none[DAFT_EFFECT_LIGHTING] = snapshot->lamp_count ? "no surface that faces a light is seen" : "the scene has no light";
    why[DAFT_EFFECT_REFLECTION] = reflection_reason(snapshot, plan.preset, &plan.reflections);
    none[DAFT_EFFECT_REFLECTION] = plan.reflections ? "no mirror is seen" : why[DAFT_EFFECT_REFLECTION];
    why[DAFT_EFFECT_SKY] = "the sky is seen", none[DAFT_EFFECT_SKY] = "the sky is not seen";
    why[DAFT_EFFECT_RESOLVE] = "every picture";
    return plan;
}
