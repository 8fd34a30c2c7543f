/* What casts shadows, as maps see it, and the sun's map: 2048², around what the camera sees up to 60 m. */
#include "llvmpipe/peer.h"

#include "math/vec.h"

#include <math.h>
#include <stdio.h>

enum { SIDE = 2048 };
static const float FARTHEST = 60; /* metres */

bool peer_shadow_create(peer_shadow *s)
{
    *s = (peer_shadow){.map = 0};
    glGenTextures(1, &s->map);
    glBindTexture(GL_TEXTURE_2D, s->map);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, SIDE, SIDE, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
    glTexParameterfv(GL_TEXTURE_2D, GL_TEXTURE_BORDER_COLOR, (const float[]){1, 1, 1, 1}); /* beyond it, light */
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    glGenFramebuffers(1, &s->target);
    glBindFramebuffer(GL_FRAMEBUFFER, s->target);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, s->map, 0);
    glDrawBuffer(GL_NONE), glReadBuffer(GL_NONE);
    return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

/* A box along the light's axes: across, across, away from the light. */
typedef struct light_box {
    daft_vec3 axis[3];
    float low[3], high[3];
} light_box;

static void box_add(light_box *box, daft_vec3 middle, daft_vec3 half)
{
    for (int k = 0; k < 3; k++) {
        const daft_vec3 a = box->axis[k];
        const float at = daft_dot(a, middle), more = fabsf(a.x) * half.x + fabsf(a.y) * half.y + fabsf(a.z) * half.z;
        box->low[k] = fminf(box->low[k], at - more), box->high[k] = fmaxf(box->high[k], at + more);
    }
}

static light_box empty_box(daft_vec3 to_light)
{
    const daft_vec3 other = fabsf(to_light.y) < 0.9f ? daft_v3(0, 1, 0) : daft_v3(1, 0, 0);
    const daft_vec3 across = daft_normalize(daft_cross(other, to_light));
    light_box box = {.axis = {across, daft_cross(to_light, across), daft_scale(to_light, -1)}};
    for (int k = 0; k < 3; k++) box.low[k] = INFINITY, box.high[k] = -INFINITY;
    return box;
}

/* What the camera sees, cut to where something casts shadows; deep enough for all that does. */
static light_box fit(const daft_snapshot *s, daft_vec3 to_light)
{
    light_box casters = empty_box(to_light), seen = casters;
    const daft_vec3 none = {0, 0, 0};
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const daft_instance *instance = &s->instances[i];
        if (!(instance->flags & (DAFT_INSTANCE_CASTS_SHADOW | DAFT_INSTANCE_FILTERS_SHADOW))) continue;
        const daft_vec3 half = daft_scale(daft_sub(instance->high, instance->low), 0.5f);
        box_add(&casters, daft_add(instance->low, half), half);
    }
    box_add(&seen, none, none);
    for (int corner = 0; corner < 4; corner++) {
        const float x = FARTHEST * (float)s->width / (2 * s->focal), y = FARTHEST * (float)s->height / (2 * s->focal);
        daft_vec3 p = daft_scale(s->forward, FARTHEST);
        p = daft_add(p, daft_scale(s->right, corner & 1 ? x : -x));
        box_add(&seen, daft_add(p, daft_scale(s->up, corner & 2 ? y : -y)), none);
    }
    for (int k = 0; k < 2; k++) {
        seen.low[k] = fmaxf(seen.low[k], casters.low[k]) - 0.01f;
        seen.high[k] = fmaxf(fminf(seen.high[k], casters.high[k]), seen.low[k]) + 0.01f;
    }
    seen.low[2] = casters.low[2] - 0.1f, seen.high[2] = fmaxf(seen.high[2], casters.high[2]) + 0.1f;
    return seen;
}

/* To -1..1 (half 1, offset 0) or 0..1 (half and offset 1/2). */
static void matrix_of(const light_box *box, float half, float offset, float out[16])
{
    for (int k = 0; k < 3; k++) {
        const daft_vec3 a = box->axis[k];
        const float scale = 2 * half / (box->high[k] - box->low[k]);
        out[k] = a.x * scale, out[4 + k] = a.y * scale, out[8 + k] = a.z * scale;
        out[12 + k] = offset - half * (box->high[k] + box->low[k]) / (box->high[k] - box->low[k]);
    }
    out[3] = out[7] = out[11] = 0, out[15] = 1;
}

static peer_planes planes_of(const light_box *box)
{
    peer_planes p = {.count = 4};
    for (int k = 0; k < 2; k++) {
        const daft_vec3 a = box->axis[k];
        const float above[4] = {a.x, a.y, a.z, -box->low[k]}, below[4] = {-a.x, -a.y, -a.z, box->high[k]};
        for (int i = 0; i < 4; i++) p.at[2 * k][i] = above[i], p.at[2 * k + 1][i] = below[i];
    }
    return p;
}

bool peer_casters_create(peer_casters *c)
{
    *c = (peer_casters){.programs = {peer_depth_program(false), peer_depth_program(true)}};
    return c->programs[0] && c->programs[1];
}

static bool is_masked(const daft_snapshot *s, const peer_group *group)
{
    const uint32_t both = PEER_MASK | PEER_OPACITY;
    return group->range != UINT32_MAX && (peer_traits_of(&s->materials[group->material]) & both) == both;
}

bool peer_casters_draw(peer_casters *c, peer_assets *assets, const daft_snapshot *s, const peer_pick *pick,
                       const float to_clip[16])
{
    if (!peer_groups_fill(&c->groups, assets, s, pick)) return false;
    glEnable(GL_DEPTH_TEST), glDepthFunc(GL_LESS), glDepthMask(GL_TRUE);
    glEnable(GL_POLYGON_OFFSET_FILL), glPolygonOffset(2, 4);
    glClear(GL_DEPTH_BUFFER_BIT);
    for (int k = 0; k < 2; k++) {
        glUseProgram(c->programs[k]);
        glUniformMatrix4fv(glGetUniformLocation(c->programs[k], "view"), 1, GL_FALSE, to_clip);
    }
    for (size_t i = 0; i < c->groups.count; i++) {
        const peer_group *group = &c->groups.items[i];
        const bool mask = is_masked(s, group);
        glUseProgram(c->programs[mask]);
        if (mask) peer_set_opacity(assets, s, &s->materials[group->material], c->programs[mask]);
        peer_group_draw(&c->groups, assets, group, !mask);
    }
    glDisable(GL_POLYGON_OFFSET_FILL);
    return true;
}

void peer_casters_free(peer_casters *c, const daft_allocator *allocator) { peer_groups_free(&c->groups, allocator); }

bool peer_shadow_draw(peer_shadow *shadow, peer_casters *casters, peer_assets *assets, const daft_snapshot *s,
                      const daft_light_source *sun)
{
    const light_box box = fit(s, sun->to_light);
    const peer_pick pick = {.inside = planes_of(&box), .casters = true};
    float to_clip[16];
    matrix_of(&box, 1, 0, to_clip);
    matrix_of(&box, 0.5f, 0.5f, shadow->from_frame);
    glBindFramebuffer(GL_FRAMEBUFFER, shadow->target);
    glViewport(0, 0, SIDE, SIDE);
    return peer_casters_draw(casters, assets, s, &pick, to_clip);
}
