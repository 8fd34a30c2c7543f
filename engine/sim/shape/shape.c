/* Making shapes; rigid frames; bounds, reach and support. */
#include "sim/shape/shape.h"

/* ---- rigid frames ---- */

daft_rigid daft_rigid_identity(void) { return (daft_rigid){.m = {1, 0, 0, 0, 1, 0, 0, 0, 1}}; }

daft_rigid daft_rigid_make(daft_dvec3 position, daft_quat rotation)
{
    double x = (double)rotation.x, y = (double)rotation.y, z = (double)rotation.z, w = (double)rotation.w;
    double square = x * x + y * y + z * z + w * w;
    if (!(square > 0) || !isfinite(square)) return (daft_rigid){position, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    double s = 2 / square; /* takes the place of normalising: q's components occur in pairs only */
    return (daft_rigid){position,
                        {1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w), s * (x * y + z * w),
                         1 - s * (x * x + z * z), s * (y * z - x * w), s * (x * z - y * w), s * (y * z + x * w),
                         1 - s * (x * x + y * y)}};
}

daft_rigid daft_rigid_mul(const daft_rigid *a, const daft_rigid *b)
{
    daft_rigid out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out.m[3 * i + j] = (a->m[3 * i] * b->m[j] + a->m[3 * i + 1] * b->m[3 + j]) + a->m[3 * i + 2] * b->m[6 + j];
    out.p = daft_rigid_point(a, b->p);
    return out;
}

daft_rigid daft_rigid_relative(const daft_rigid *a, const daft_rigid *b)
{
    daft_rigid out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out.m[3 * i + j] = (a->m[i] * b->m[j] + a->m[3 + i] * b->m[3 + j]) + a->m[6 + i] * b->m[6 + j];
    out.p = daft_rigid_to_local(a, b->p);
    return out;
}

daft_rigid daft_rigid_inverse(const daft_rigid *a)
{
    const double *m = a->m;
    daft_rigid out = {.m = {m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]}};
    out.p = daft_dscale(daft_rigid_to_local_vector(a, a->p), -1);
    return out;
}

/* ---- makers ---- */

static bool check_size(float size, float least, const char *what, daft_error *error)
{
    if (size >= least && size <= DAFT_SHAPE_MAX_SIZE) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "%s of %g m; it takes %g to %g", what, (double)size, (double)least,
                     (double)DAFT_SHAPE_MAX_SIZE);
}

bool daft_shape_sphere(float radius, daft_sim_shape *out, daft_error *error)
{
    if (!check_size(radius, DAFT_SHAPE_MIN_SIZE, "a sphere with a radius", error)) return false;
    *out = (daft_sim_shape){.type = DAFT_GEOMETRY_SPHERE, .radius = radius};
    return true;
}

bool daft_shape_capsule(float half_height, float radius, daft_sim_shape *out, daft_error *error)
{
    if (!check_size(radius, DAFT_SHAPE_MIN_SIZE, "a capsule with a radius", error)) return false;
    if (!check_size(half_height, 0, "a capsule with half a core", error)) return false;
    *out = (daft_sim_shape){.type = DAFT_GEOMETRY_CAPSULE, .radius = radius, .half_height = half_height};
    if (half_height < DAFT_SHAPE_MIN_SIZE) /* a core that short has no direction to speak of */
        *out = (daft_sim_shape){.type = DAFT_GEOMETRY_SPHERE, .radius = radius + half_height};
    return true;
}

bool daft_shape_box(daft_vec3 half, daft_sim_shape *out, daft_error *error)
{
    const float *h = &half.x;
    for (int k = 0; k < 3; k++)
        if (!check_size(h[k], DAFT_SHAPE_MIN_SIZE, "a box with half an edge", error)) return false;
    *out = (daft_sim_shape){.type = DAFT_GEOMETRY_BOX, .half = half};
    return true;
}

daft_sim_shape daft_shape_hull(const daft_hull *hull)
{
    return (daft_sim_shape){.type = DAFT_GEOMETRY_HULL, .hull = hull};
}
daft_sim_shape daft_shape_mesh(const daft_mesh_shape *mesh)
{
    return (daft_sim_shape){.type = DAFT_GEOMETRY_MESH, .mesh = mesh};
}
daft_sim_shape daft_shape_field(const daft_height_field *field)
{
    return (daft_sim_shape){.type = DAFT_GEOMETRY_FIELD, .field = field};
}
daft_sim_shape daft_shape_compound(const daft_compound *compound)
{
    return (daft_sim_shape){.type = DAFT_GEOMETRY_COMPOUND, .compound = compound};
}

bool daft_shape_has_mass(const daft_sim_shape *s)
{
    if (s->type != DAFT_GEOMETRY_COMPOUND) return daft_shape_is_convex(s);
    for (uint32_t i = 0; i < s->compound->count; i++)
        if (!daft_shape_is_convex(&s->compound->children[i].shape)) return false;
    return true;
}

/* ---- bounds ---- */

static daft_daabb ball_bounds(daft_dvec3 centre, daft_dvec3 reach)
{
    return (daft_daabb){daft_dsub(centre, reach), daft_dadd(centre, reach)};
}

static daft_daabb box_bounds(daft_dvec3 centre, daft_dvec3 half, const daft_rigid *pose)
{
    const double *m = pose->m;
    daft_dvec3 reach = {(fabs(m[0]) * half.x + fabs(m[1]) * half.y) + fabs(m[2]) * half.z,
                        (fabs(m[3]) * half.x + fabs(m[4]) * half.y) + fabs(m[5]) * half.z,
                        (fabs(m[6]) * half.x + fabs(m[7]) * half.y) + fabs(m[8]) * half.z};
    return ball_bounds(daft_rigid_point(pose, centre), reach);
}

/* Of local bounds; empty ones become a point. */
static daft_daabb turned_bounds(daft_vec3 low, daft_vec3 high, const daft_rigid *pose)
{
    if (!(low.x <= high.x)) return (daft_daabb){pose->p, pose->p};
    daft_dvec3 l = daft_to_double(low), h = daft_to_double(high);
    return box_bounds(daft_dscale(daft_dadd(l, h), 0.5), daft_dscale(daft_dsub(h, l), 0.5), pose);
}

static daft_dvec3 dmin(daft_dvec3 a, daft_dvec3 b)
{
    return daft_dv3(a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z);
}
static daft_dvec3 dmax(daft_dvec3 a, daft_dvec3 b)
{
    return daft_dv3(a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z);
}

static double across(double r, double axis) { return r * sqrt(fmax(0, 1 - axis * axis)); }

static daft_daabb hull_bounds(const daft_hull *hull, const daft_rigid *pose)
{
    double r = (double)hull->cylinder, h = (double)hull->high.y;
    const double *m = pose->m;
    if (r > 0)
        return ball_bounds(pose->p, daft_dv3(fabs(m[1]) * h + across(r, m[1]), fabs(m[4]) * h + across(r, m[4]),
                                             fabs(m[7]) * h + across(r, m[7])));
    daft_daabb out = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (uint16_t i = 0; i < hull->vertex_count; i++) {
        daft_dvec3 p = daft_rigid_point(pose, daft_to_double(hull->vertices[i]));
        out.low = dmin(out.low, p), out.high = dmax(out.high, p);
    }
    return out;
}

daft_daabb daft_shape_bounds(const daft_sim_shape *s, const daft_rigid *pose)
{
    double r = (double)s->radius, h = (double)s->half_height;
    switch (s->type) {
    case DAFT_GEOMETRY_SPHERE: return ball_bounds(pose->p, daft_dv3(r, r, r));
    case DAFT_GEOMETRY_CAPSULE:
        return ball_bounds(pose->p,
                           daft_dv3(fabs(pose->m[1]) * h + r, fabs(pose->m[4]) * h + r, fabs(pose->m[7]) * h + r));
    case DAFT_GEOMETRY_BOX: return box_bounds(daft_dv3(0, 0, 0), daft_to_double(s->half), pose);
    case DAFT_GEOMETRY_HULL: return hull_bounds(s->hull, pose);
    case DAFT_GEOMETRY_MESH: return turned_bounds(s->mesh->mesh->low, s->mesh->mesh->high, pose);
    case DAFT_GEOMETRY_FIELD: {
        const daft_height_field *f = s->field;
        float x = (float)(f->columns - 1) * f->spacing_x, z = (float)(f->rows - 1) * f->spacing_z;
        if (!(f->low <= f->high)) return (daft_daabb){pose->p, pose->p};
        return turned_bounds(daft_v3(0, f->low, 0), daft_v3(x, f->high, z), pose);
    }
    case DAFT_GEOMETRY_COMPOUND: {
        daft_daabb out = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
        for (uint32_t i = 0; i < s->compound->count; i++) {
            daft_rigid child = daft_rigid_mul(pose, &s->compound->children[i].pose);
            daft_daabb b = daft_shape_bounds(&s->compound->children[i].shape, &child);
            out.low = dmin(out.low, b.low), out.high = dmax(out.high, b.high);
        }
        return out;
    }
    case DAFT_GEOMETRY_NONE: break;
    }
    return (daft_daabb){pose->p, pose->p};
}

/* ---- reach ---- */

static double corner_reach(daft_dvec3 low, daft_dvec3 high, daft_dvec3 from)
{
    double x = fmax(fabs(from.x - low.x), fabs(high.x - from.x));
    double y = fmax(fabs(from.y - low.y), fabs(high.y - from.y));
    double z = fmax(fabs(from.z - low.z), fabs(high.z - from.z));
    return sqrt(x * x + y * y + z * z);
}

static double dlength(daft_dvec3 v) { return sqrt(daft_ddot(v, v)); }

static double reach_of(const daft_sim_shape *s, daft_dvec3 from)
{
    double most = 0, h = (double)s->half_height;
    switch (s->type) {
    case DAFT_GEOMETRY_SPHERE: return dlength(from) + (double)s->radius;
    case DAFT_GEOMETRY_CAPSULE: return dlength(daft_dv3(from.x, fabs(from.y) + h, from.z)) + (double)s->radius;
    case DAFT_GEOMETRY_HULL:
        for (uint16_t i = 0; i < s->hull->vertex_count; i++)
            most = fmax(most, dlength(daft_dsub(daft_to_double(s->hull->vertices[i]), from)));
        return most;
    case DAFT_GEOMETRY_COMPOUND:
        for (uint32_t i = 0; i < s->compound->count; i++) {
            const daft_child *c = &s->compound->children[i];
            most = fmax(most, reach_of(&c->shape, daft_rigid_to_local(&c->pose, from)));
        }
        return most;
    default: {
        daft_rigid identity = daft_rigid_identity();
        daft_daabb bounds = daft_shape_bounds(s, &identity);
        return corner_reach(bounds.low, bounds.high, from);
    }
    }
}

float daft_shape_reach(const daft_sim_shape *s, daft_vec3 from)
{
    return (float)(reach_of(s, daft_to_double(from)) * (1 + 0x1p-22)); /* rounded up */
}

float daft_shape_inner_radius(const daft_sim_shape *s, daft_vec3 from)
{
    float least = 0;
    switch (s->type) {
    case DAFT_GEOMETRY_SPHERE: least = s->radius - daft_length(from); break;
    case DAFT_GEOMETRY_CAPSULE: {
        float beyond = fabsf(from.y) - s->half_height;
        least = s->radius - daft_length(daft_v3(from.x, beyond > 0 ? beyond : 0, from.z));
        break;
    }
    case DAFT_GEOMETRY_BOX:
        least = s->half.x - fabsf(from.x);
        if (s->half.y - fabsf(from.y) < least) least = s->half.y - fabsf(from.y);
        if (s->half.z - fabsf(from.z) < least) least = s->half.z - fabsf(from.z);
        break;
    case DAFT_GEOMETRY_HULL:
        least = INFINITY;
        for (uint16_t i = 0; i < s->hull->face_count; i++) {
            float depth = s->hull->planes[i].offset - daft_dot(s->hull->planes[i].normal, from);
            if (depth < least) least = depth;
        }
        break;
    default: break;
    }
    return least > 0 ? least : 0;
}
