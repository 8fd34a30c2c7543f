/* Shadows of lamps, anew in each frame: of a point light a depth cube of 1024² a face, of a spot a map of its cone of
 * 1024². Faces see only the casters within them and within the light's range; those in which the camera sees nothing
 * that is lit are not drawn. All lie in one texture array, so that they take one of the sixteen texture units whatever
 * their number. A game would bound what lamps may cost: those beyond the strongest PEER_MAPS of a kind cast no
 * shadows. */
#include "llvmpipe/peer.h"

#include "math/vec.h"

#include <math.h>
#include <stdlib.h>

enum { SIDE = 1024 };
static const float NEAREST = 0.05f; /* metres */
static const float STEEPEST = 6;    /* tangent of half a cone's angle, 80 degrees; of wider ones this much is right */

/* ---- which lights ---- */

/* What it brings to where the camera looks, about. */
static float strength_of(const daft_light_source *light)
{
    const daft_vec3 c = light->color, d = light->position; /* the eye is at 0 */
    const float luminance = 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z, length2 = fmaxf(daft_dot(d, d), 1);
    const float left = light->range > 0 ? fmaxf(1 - length2 / (light->range * light->range), 0.01f) : 1;
    if (light->area == DAFT_AREA_SPHERE) return luminance * light->radius * light->radius / length2;
    if (light->area == DAFT_AREA_RECTANGLE)
        return luminance * daft_length(daft_cross(light->edges[0], light->edges[1])) / ((float)DAFT_PI * length2);
    return luminance * left * left / (light->inverse_square ? length2 : 1);
}

/* Those that cast shadows first, the strongest of them in front. */
static int by_strength(const void *a, const void *b)
{
    const daft_light_source *x = *(const daft_light_source *const *)a, *y = *(const daft_light_source *const *)b;
    if (x->casts_shadow != y->casts_shadow) return x->casts_shadow ? -1 : 1;
    const float p = strength_of(x), q = strength_of(y);
    if (p != q) return p > q ? -1 : 1;
    return x < y ? -1 : x > y;
}

static int kind_of(const daft_light_source *light) { return light->sun ? 0 : light->spot ? 2 : 1; }

static int choose(const daft_light_source **lights, int count)
{
    int casting = 0;
    qsort(lights, (size_t)count, sizeof *lights, by_strength);
    while (casting < count && casting < PEER_MAPS && lights[casting]->casts_shadow) casting++;
    return casting;
}

void peer_lights_find(peer_lights *out, const daft_snapshot *s, bool maps)
{
    int counts[3] = {0, 0, 0}, used = 0;
    for (int kind = 0; kind < 3; kind++)
        for (uint32_t i = 0; i < s->light_count && i < PEER_LIGHTS; i++)
            if (kind_of(&s->lights[i]) == kind) out->items[used++] = &s->lights[i], counts[kind]++;
    out->suns = counts[0], out->points = counts[1], out->spots = counts[2], out->cubes = out->cones = 0;
    if (maps) out->cubes = choose(out->items + counts[0], counts[1]);
    if (maps) out->cones = choose(out->items + counts[0] + counts[1], counts[2]);
}

/* ---- textures ---- */

static GLuint make_maps(GLsizei layers)
{
    const GLenum target = GL_TEXTURE_2D_ARRAY;
    GLuint map;
    glGenTextures(1, &map);
    glBindTexture(target, map);
    glTexImage3D(target, 0, GL_DEPTH_COMPONENT24, SIDE, SIDE, layers, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, NULL);
    glTexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_LINEAR); /* of four comparisons */
    glTexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTexParameteri(target, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(target, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    return map;
}

bool peer_lamps_create(peer_lamps *lamps)
{
    *lamps = (peer_lamps){.maps = make_maps(7 * PEER_MAPS)};
    glGenFramebuffers(1, &lamps->target);
    glBindFramebuffer(GL_FRAMEBUFFER, lamps->target);
    glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, lamps->maps, 0, 0);
    glDrawBuffer(GL_NONE), glReadBuffer(GL_NONE);
    return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE && glGetError() == GL_NO_ERROR;
}

/* ---- a map ---- */

/* What a map sees, from the light along `forward`: a pyramid. */
typedef struct map_view {
    daft_vec3 from, across, up, forward; /* unit */
    float tangent, far;                  /* of half its angle; metres */
} map_view;

static void planes_of(const map_view *v, peer_planes *out)
{
    *out = (peer_planes){.count = 5};
    const daft_vec3 forward = daft_scale(v->forward, v->tangent);
    const daft_vec3 normals[5] = {daft_add(forward, v->across), daft_sub(forward, v->across), daft_add(forward, v->up),
                                  daft_sub(forward, v->up), daft_scale(v->forward, -1)};
    for (int k = 0; k < 5; k++) {
        const daft_vec3 n = normals[k];
        float *p = out->at[k];
        p[0] = n.x, p[1] = n.y, p[2] = n.z, p[3] = -daft_dot(n, v->from) + (k == 4 ? v->far : 0);
    }
}

static void corners_of(const map_view *v, daft_vec3 out[5])
{
    const float half = v->far * v->tangent;
    out[0] = v->from;
    for (int k = 0; k < 4; k++) {
        daft_vec3 p = daft_add(v->from, daft_scale(v->forward, v->far));
        p = daft_add(p, daft_scale(v->across, k & 1 ? half : -half));
        out[k + 1] = daft_add(p, daft_scale(v->up, k & 2 ? half : -half));
    }
}

/* Column-major. The same as depth: x + y / the distance along the axis. */
static void matrix_of(const map_view *v, float out[16], float depth[2])
{
    const float away = v->far - NEAREST, a = (v->far + NEAREST) / away, b = -2 * v->far * NEAREST / away;
    const daft_vec3 rows[4] = {daft_scale(v->across, 1 / v->tangent), daft_scale(v->up, 1 / v->tangent),
                               daft_scale(v->forward, a), v->forward};
    for (int i = 0; i < 4; i++) {
        out[i] = rows[i].x, out[4 + i] = rows[i].y, out[8 + i] = rows[i].z;
        out[12 + i] = -daft_dot(rows[i], v->from) + (i == 2 ? b : 0);
    }
    depth[0] = 0.5f * a + 0.5f, depth[1] = 0.5f * b;
}

/* Whether one of the planes has all the points outside. */
static bool parted(const peer_planes *planes, const daft_vec3 points[5])
{
    for (int k = 0; k < planes->count; k++) {
        const float *p = planes->at[k];
        int outside = 0;
        for (int i = 0; i < 5; i++) outside += p[0] * points[i].x + p[1] * points[i].y + p[2] * points[i].z + p[3] < 0;
        if (outside == 5) return true;
    }
    return false;
}

/* Whether the camera sees something that the light reaches through the map. */
static bool is_of_use(const daft_snapshot *s, const daft_light_source *light, const map_view *v,
                      const peer_planes *planes, const peer_sight *sight)
{
    daft_vec3 corners[5];
    corners_of(v, corners);
    if (parted(planes, sight->corners) || parted(&sight->inside, corners)) return false;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const daft_instance *instance = &s->instances[i];
        if (light->range > 0 && peer_distance(instance, light->position) > light->range) continue;
        if (!peer_is_outside(instance, &sight->inside) && !peer_is_outside(instance, planes)) return true;
    }
    return false;
}

typedef struct map_drawing {
    peer_lamps *lamps;
    peer_casters *casters;
    peer_assets *assets;
    const daft_snapshot *snapshot;
    const peer_sight *sight;
} map_drawing;

static bool draw_map(const map_drawing *d, const daft_light_source *light, const map_view *v, int layer, float depth[2])
{
    float to_clip[16];
    peer_pick pick = {.from = light->position, .casters = true, .glowing = light->entity};
    planes_of(v, &pick.inside);
    matrix_of(v, to_clip, depth);
    if (!is_of_use(d->snapshot, light, v, &pick.inside, d->sight)) return true;
    glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, d->lamps->maps, 0, layer);
    return peer_casters_draw(d->casters, d->assets, d->snapshot, &pick, to_clip);
}

/* ---- all of them ---- */

/* As far as something stands. */
static float reach_of(const daft_snapshot *s, const daft_light_source *light)
{
    float most = 1;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const daft_instance *a = &s->instances[i];
        const daft_vec3 p = light->position,
                        corner = {fmaxf(p.x - a->low.x, a->high.x - p.x), fmaxf(p.y - a->low.y, a->high.y - p.y),
                                  fmaxf(p.z - a->low.z, a->high.z - p.z)};
        most = fmaxf(most, daft_length(corner));
    }
    return 1.01f * (light->range > 0 ? fminf(light->range, most) : most);
}

/* Faces as OpenGL has them (3.3 core, 3.8.10, table 3.19): s, t and the major axis. */
static bool draw_cube(const map_drawing *d, const daft_light_source *light, int number)
{
    static const daft_vec3 axes[6][3] = {{{0, 0, -1}, {0, -1, 0}, {1, 0, 0}}, {{0, 0, 1}, {0, -1, 0}, {-1, 0, 0}},
                                         {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},   {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
                                         {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}},  {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}};
    const float far = reach_of(d->snapshot, light);
    for (int k = 0; k < 6; k++) {
        const map_view v = {light->position, axes[k][0], axes[k][1], axes[k][2], 1, far};
        if (!draw_map(d, light, &v, 6 * number + k, d->lamps->cube_depth[number])) return false;
    }
    return true;
}

static bool draw_cone(const map_drawing *d, const daft_light_source *light, int number, int layer)
{
    const daft_vec3 back = light->to_light, other = fabsf(back.y) < 0.9f ? daft_v3(0, 1, 0) : daft_v3(1, 0, 0),
                    across = daft_normalize(daft_cross(other, back)), up = daft_cross(back, across);
    const float cosine = light->cone_cosine, sine = sqrtf(fmaxf(1 - cosine * cosine, 0)),
                tangent = sine < STEEPEST * cosine ? fmaxf(1.01f * sine / cosine, 0.01f) : STEEPEST;
    const map_view v = {light->position, across, up, daft_scale(back, -1), tangent, reach_of(d->snapshot, light)};
    d->lamps->cone_across[number] = daft_scale(across, 0.5f / tangent);
    d->lamps->cone_up[number] = daft_scale(up, 0.5f / tangent);
    return draw_map(d, light, &v, layer, d->lamps->cone_depth[number]);
}

bool peer_lamps_draw(peer_lamps *lamps, peer_casters *casters, peer_assets *assets, const daft_snapshot *s,
                     const peer_lights *lights, const peer_sight *sight)
{
    const map_drawing d = {lamps, casters, assets, s, sight};
    const daft_light_source *const *points = lights->items + lights->suns, *const *spots = points + lights->points;
    glBindFramebuffer(GL_FRAMEBUFFER, lamps->target);
    glViewport(0, 0, SIDE, SIDE);
    bool good = true;
    for (int i = 0; good && i < lights->cubes; i++) good = draw_cube(&d, points[i], i);
    for (int i = 0; good && i < lights->cones; i++) good = draw_cone(&d, spots[i], i, 6 * lights->cubes + i);
    return good;
}
