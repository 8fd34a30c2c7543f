/* Cameras and lights. Those of glTF come from its JSON: Assimp keeps one node of a light or camera that several share,
 * and moves cameras twice. Lights there are photometric: candela, and lux. Others are as bright as they say; Assimp
 * tells of FBX its intensity / 100, of all formats attenuation as 1 / (constant + linear d + quadratic d²). */
#include "geometry/foreign/assimp.h"

#include "math/trig.h"

#include <stdio.h>
#include <string.h>

typedef struct maker {
    const daft_flattener *f;
    daft_scenery *out;
    size_t camera_capacity, light_capacity;
} maker;

static const double ORIGIN[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

static void leave_out(const maker *m, const char *what, const char *name, const char *why)
{
    daft_warn_at(m->f->from->log, DAFT_ERROR_UNSUPPORTED, m->f->from->path, 0, 0, "the %s '%.100s' %s: it is left out",
                 what, name, why);
}

/* ---- places and directions ---- */

/* w: 1 for places, 0 for directions. */
static daft_dvec3 move(const double m[12], daft_dvec3 v, double w)
{
    return daft_dv3(m[0] * v.x + m[1] * v.y + m[2] * v.z + w * m[3], m[4] * v.x + m[5] * v.y + m[6] * v.z + w * m[7],
                    m[8] * v.x + m[9] * v.y + m[10] * v.z + w * m[11]);
}

/* Unit; false: it has no direction. */
static bool turn(const double m[12], daft_dvec3 v, daft_vec3 *out)
{
    const daft_dvec3 d = move(m, v, 0);
    const double length = sqrt(daft_ddot(d, d));
    *out = daft_to_float(daft_dscale(d, 1 / length));
    return isfinite(length) && length > 0;
}

static daft_dvec3 from_assimp(struct aiVector3D v) { return daft_dv3((double)v.x, (double)v.y, (double)v.z); }

/* The matrix of the node of a name, which is where Assimp says its cameras and lights hang. */
static const double *place_of(const maker *m, const char *name)
{
    const uint32_t node = daft_foreign_nodes_find(&m->f->nodes, name);
    return node == DAFT_RIG_NONE ? ORIGIN : m->f->nodes.items[node].m;
}

/* ---- cameras ---- */

/* fov: from the left to the right edge, radians. */
static bool add_camera(maker *m, const char *name, const double place[12], daft_dvec3 position, daft_dvec3 forward,
                       daft_dvec3 up, double fov)
{
    daft_scenery *out = m->out;
    daft_obj_camera made = {.position = move(place, position, 1), .fov = (float)fov};
    snprintf(made.name, sizeof made.name, "%.120s", name);
    if (!turn(place, forward, &made.forward) || !turn(place, up, &made.up) || !daft_dfinite3(made.position) ||
        !(fov > 1e-4 && fov < 3.1415)) {
        leave_out(m, "camera", name, "has no direction, or no angle of view between 0 and 180 degrees");
        return true;
    }
    if (!daft_grow(m->f->from->allocator, &out->cameras, &m->camera_capacity, (size_t)out->camera_count + 1,
                   out->camera_count, sizeof made))
        return daft_fail_memory(m->f->from->error, "a model's cameras");
    out->cameras[out->camera_count++] = made;
    return true;
}

static bool gltf_camera(maker *m, uint32_t node)
{
    const daft_foreign_node *at = &m->f->nodes.items[node];
    const daft_json camera = daft_gltf_camera(&m->f->gltf, node), lens = daft_json_member(camera, "perspective");
    if (!camera.at) return true;
    if (!lens.at) {
        leave_out(m, "camera", at->node->mName.data, "is no perspective one");
        return true;
    }
    const double height = daft_tan(daft_json_number(daft_json_member(lens, "yfov"), 0) / 2),
                 aspect = daft_json_number(daft_json_member(lens, "aspectRatio"), 16.0 / 9);
    return add_camera(m, at->node->mName.data, at->m, daft_dv3(0, 0, 0), daft_dv3(0, 0, -1), daft_dv3(0, 1, 0),
                      2 * daft_atan2(height * aspect, 1));
}

static bool assimp_camera(maker *m, const struct aiCamera *c)
{
    return add_camera(m, c->mName.data, place_of(m, c->mName.data), from_assimp(c->mPosition), from_assimp(c->mLookAt),
                      from_assimp(c->mUp), (double)c->mHorizontalFOV);
}

/* ---- lights ---- */

static float limited(double x, double low, double high) { return (float)(x > low ? x < high ? x : high : low); }

/* color: of what the struct asks for. */
static bool add_light(maker *m, const char *name, const double place[12], daft_dvec3 position, daft_dvec3 direction,
                      daft_dvec3 color, daft_obj_light made)
{
    daft_scenery *out = m->out;
    made.position = move(place, position, 1);
    made.color = daft_v3(limited(color.x, 0, 1e30), limited(color.y, 0, 1e30), limited(color.z, 0, 1e30));
    snprintf(made.name, sizeof made.name, "%.120s", name);
    if (!daft_dfinite3(made.position) || (!turn(place, direction, &made.direction) && made.kind != DAFT_LIGHT_POINT)) {
        leave_out(m, "light", name, "has no place or direction");
        return true;
    }
    if (made.kind == DAFT_LIGHT_POINT) made.direction = daft_v3(0, -1, 0);
    if (!daft_grow(m->f->from->allocator, &out->lights, &m->light_capacity, (size_t)out->light_count + 1,
                   out->light_count, sizeof made))
        return daft_fail_memory(m->f->from->error, "a model's lights");
    out->lights[out->light_count++] = made;
    return true;
}

static void set_cone(daft_obj_light *light, double inner, double outer)
{
    light->outer_angle = limited(outer, 1e-3, DAFT_PI / 2),
    light->inner_angle = limited(inner, 0, (double)light->outer_angle);
}

/* KHR_lights_punctual. */
static bool gltf_light(maker *m, uint32_t node)
{
    const daft_foreign_node *at = &m->f->nodes.items[node];
    const daft_json light = daft_gltf_light(&m->f->gltf, node), color = daft_json_member(light, "color"),
                    cone = daft_json_member(light, "spot");
    if (!light.at) return true;
    const bool sun = daft_json_is(daft_json_member(light, "type"), "directional"),
               spot = daft_json_is(daft_json_member(light, "type"), "spot");
    daft_obj_light made = {.kind = sun ? DAFT_LIGHT_SUN : spot ? DAFT_LIGHT_SPOT : DAFT_LIGHT_POINT};
    const double intensity = daft_json_number(daft_json_member(light, "intensity"), 1) / DAFT_PI;
    double rgb[3] = {intensity, intensity, intensity};
    daft_json part = daft_json_first(color);
    for (int k = 0; k < 3; k++, part = daft_json_next(part)) rgb[k] *= daft_json_number(part, 1);
    made.inverse_square = !sun;
    if (!sun) made.range = limited(daft_json_number(daft_json_member(light, "range"), 0), 0, 1e6);
    if (spot)
        set_cone(&made, daft_json_number(daft_json_member(cone, "innerConeAngle"), 0),
                 daft_json_number(daft_json_member(cone, "outerConeAngle"), DAFT_PI / 4));
    return add_light(m, at->node->mName.data, at->m, daft_dv3(0, 0, 0), daft_dv3(0, 0, -1),
                     daft_dv3(rgb[0], rgb[1], rgb[2]), made);
}

/* Metres of the unit of the file's lengths, in which decay is: FBX files tell theirs in centimetres. */
static double unit_of(const maker *m)
{
    const struct aiMetadata *about = m->f->from->scene->mMetaData;
    double unit = 1;
    for (unsigned i = 0; about && i < about->mNumProperties; i++) {
        const struct aiMetadataEntry *e = &about->mValues[i];
        if (strcmp(about->mKeys[i].data, "UnitScaleFactor") != 0) continue;
        if (e->mType == AI_DOUBLE) unit = *(const double *)e->mData / 100;
        if (e->mType == AI_FLOAT) unit = (double)*(const float *)e->mData / 100;
    }
    return isfinite(unit) && unit > 0 ? unit : 1;
}

/* Cones are given from edge to edge. */
static bool assimp_light(maker *m, const struct aiLight *l)
{
    const bool sun = l->mType == aiLightSource_DIRECTIONAL, spot = l->mType == aiLightSource_SPOT;
    if (!sun && !spot && l->mType != aiLightSource_POINT) {
        leave_out(m, "light", l->mName.data, "is no point, spot or sun");
        return true;
    }
    daft_obj_light made = {.kind = sun ? DAFT_LIGHT_SUN : spot ? DAFT_LIGHT_SPOT : DAFT_LIGHT_POINT};
    const double decay = (double)l->mAttenuationQuadratic, unit = unit_of(m);
    made.inverse_square = !sun && l->mAttenuationConstant == 0 && decay > 0 && isfinite(decay);
    const double at_a_metre = made.inverse_square ? unit * unit / decay : 1;
    if (spot) set_cone(&made, (double)l->mAngleInnerCone / 2, (double)l->mAngleOuterCone / 2);
    const struct aiColor3D c = l->mColorDiffuse;
    return add_light(m, l->mName.data, place_of(m, l->mName.data), from_assimp(l->mPosition),
                     from_assimp(l->mDirection),
                     daft_dv3((double)c.r * at_a_metre, (double)c.g * at_a_metre, (double)c.b * at_a_metre), made);
}

bool daft_foreign_scenery(const daft_flattener *f, daft_obj *out)
{
    maker m = {.f = f, .out = &out->scenery};
    const struct aiScene *scene = f->from->scene;
    bool good = true;
    if (f->gltf.root.at) {
        for (uint32_t i = 0; good && i < f->nodes.count; i++) good = gltf_camera(&m, i) && gltf_light(&m, i);
        return good;
    }
    for (uint32_t i = 0; good && i < scene->mNumCameras; i++) good = assimp_camera(&m, scene->mCameras[i]);
    for (uint32_t i = 0; good && i < scene->mNumLights; i++) good = assimp_light(&m, scene->mLights[i]);
    return good;
}
