/* What the simulation sees, as edges: for pictures that are looked at by somebody who asks why a body stops in mid-air.
 * Read from the state, never part of a step. */
#include "math/trig.h"
#include "sim/world.h"

#include <math.h>

enum { CIRCLE = 24 };

typedef struct edge_list {
    daft_sim_edge *out;
    uint32_t count, capacity;
    daft_sim_edge like; /* what all of a part's edges have in common */
    daft_rigid frame;   /* of the part, in the world */
    daft_daabb near;    /* in the world */
} edge_list;

static void add(edge_list *list, daft_dvec3 a, daft_dvec3 b)
{
    if (list->count < list->capacity) {
        daft_sim_edge *edge = &list->out[list->count];
        *edge = list->like;
        edge->from = daft_rigid_point(&list->frame, a), edge->to = daft_rigid_point(&list->frame, b);
    }
    list->count++;
}

/* Around `middle`, through middle + a and middle + b; half: from a by way of b to -a. */
static void add_arc(edge_list *list, daft_dvec3 middle, daft_dvec3 a, daft_dvec3 b, bool half)
{
    const int edges = half ? CIRCLE / 2 : CIRCLE;
    daft_dvec3 last = daft_dadd(middle, a);
    for (int i = 1; i <= edges; i++) {
        const double angle = 2 * 3.14159265358979323846 * i / CIRCLE;
        const daft_dvec3 on = daft_dadd(daft_dscale(a, daft_cos(angle)), daft_dscale(b, daft_sin(angle)));
        add(list, last, daft_dadd(middle, on));
        last = daft_dadd(middle, on);
    }
}

static void add_sphere(edge_list *list, double r)
{
    const daft_dvec3 o = {0, 0, 0}, x = {r, 0, 0}, y = {0, r, 0}, z = {0, 0, r};
    add_arc(list, o, x, y, false), add_arc(list, o, y, z, false), add_arc(list, o, z, x, false);
}

static void add_capsule(edge_list *list, double half, double r)
{
    const daft_dvec3 top = {0, half, 0}, foot = {0, -half, 0}, x = {r, 0, 0}, y = {0, r, 0}, z = {0, 0, r};
    add_arc(list, top, x, z, false), add_arc(list, foot, x, z, false);
    add_arc(list, top, x, y, true), add_arc(list, top, z, y, true);
    add_arc(list, foot, x, daft_dscale(y, -1), true), add_arc(list, foot, z, daft_dscale(y, -1), true);
    for (int i = 0; i < 4; i++) {
        const daft_dvec3 side = daft_dscale(i & 1 ? z : x, i & 2 ? -1 : 1);
        add(list, daft_dadd(top, side), daft_dadd(foot, side));
    }
}

static void add_box(edge_list *list, daft_vec3 half)
{
    const double h[3] = {(double)half.x, (double)half.y, (double)half.z};
    for (int axis = 0; axis < 3; axis++)
        for (int corner = 0; corner < 4; corner++) {
            double a[3];
            a[(axis + 1) % 3] = corner & 1 ? h[(axis + 1) % 3] : -h[(axis + 1) % 3];
            a[(axis + 2) % 3] = corner & 2 ? h[(axis + 2) % 3] : -h[(axis + 2) % 3];
            a[axis] = -h[axis];
            const daft_dvec3 from = {a[0], a[1], a[2]};
            a[axis] = h[axis];
            add(list, from, daft_dv3(a[0], a[1], a[2]));
        }
}

static void add_hull(edge_list *list, const daft_hull *hull)
{
    for (uint32_t i = 0; i + 1 < hull->half_edge_count; i += 2) /* an edge and its twin follow each other */
        add(list, daft_to_double(hull->vertices[hull->half_edges[i].origin]),
            daft_to_double(hull->vertices[hull->half_edges[i + 1].origin]));
}

static bool is_near(const edge_list *list, const daft_dvec3 *corners, int count)
{
    daft_dvec3 low = daft_rigid_point(&list->frame, corners[0]), high = low;
    for (int i = 1; i < count; i++) {
        const daft_dvec3 p = daft_rigid_point(&list->frame, corners[i]);
        low = daft_sim_dmin(low, p), high = daft_sim_dmax(high, p);
    }
    return low.x <= list->near.high.x && low.y <= list->near.high.y && low.z <= list->near.high.z &&
           high.x >= list->near.low.x && high.y >= list->near.low.y && high.z >= list->near.low.z;
}

/* An edge that two triangles share is the first one's. */
static void add_mesh(edge_list *list, const daft_mesh_shape *shape)
{
    const daft_trimesh *m = shape->mesh;
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        daft_dvec3 corners[3];
        for (int k = 0; k < 3; k++) {
            const uint32_t v = m->indices[3 * (size_t)t + (size_t)k];
            corners[k] = daft_dv3((double)m->x[v], (double)m->y[v], (double)m->z[v]);
        }
        if (!is_near(list, corners, 3)) continue;
        for (int k = 0; k < 3; k++) {
            const uint32_t across = shape->neighbours[3 * (size_t)t + (size_t)k];
            if (across == DAFT_NO_FEATURE || across / 3 > t) add(list, corners[k], corners[(k + 1) % 3]);
        }
    }
}

/* Columns or rows of samples that lie within two places, in spacings. */
static void clip_range(double low, double high, double spacing, uint32_t count, uint32_t *first, uint32_t *end)
{
    const double a = floor(low / spacing), b = ceil(high / spacing) + 1;
    *first = a > 0 ? (a < count ? (uint32_t)a : count) : 0;
    *end = b > 0 ? (b < count ? (uint32_t)b : count) : 0;
}

static daft_dvec3 sample_at(const daft_height_field *f, uint32_t column, uint32_t row)
{
    return daft_dv3((double)column * (double)f->spacing_x, (double)f->heights[(size_t)row * f->columns + column],
                    (double)row * (double)f->spacing_z);
}

/* Lines from sample to sample, along both axes. */
static void add_field(edge_list *list, const daft_height_field *f)
{
    const daft_dvec3 half = daft_dscale(daft_dsub(list->near.high, list->near.low), 0.5);
    const daft_dvec3 middle = daft_rigid_to_local(&list->frame, daft_dadd(list->near.low, half));
    const double reach = sqrt(daft_ddot(half, half));
    uint32_t c0, c1, r0, r1;
    clip_range(middle.x - reach, middle.x + reach, (double)f->spacing_x, f->columns, &c0, &c1);
    clip_range(middle.z - reach, middle.z + reach, (double)f->spacing_z, f->rows, &r0, &r1);
    for (uint32_t r = r0; r < r1; r++)
        for (uint32_t c = c0; c < c1; c++) {
            const daft_dvec3 here = sample_at(f, c, r);
            if (!isfinite(here.y)) continue;
            for (int side = 0; side < 2; side++) {
                if (side ? r + 1 >= f->rows : c + 1 >= f->columns) continue;
                const daft_dvec3 ends[2] = {here, side ? sample_at(f, c, r + 1) : sample_at(f, c + 1, r)};
                if (isfinite(ends[1].y) && is_near(list, ends, 2)) add(list, ends[0], ends[1]);
            }
        }
}

static void add_shape(edge_list *list, const daft_sim_shape *shape)
{
    switch (shape->type) {
    case DAFT_GEOMETRY_SPHERE: add_sphere(list, (double)shape->radius); break;
    case DAFT_GEOMETRY_CAPSULE: add_capsule(list, (double)shape->half_height, (double)shape->radius); break;
    case DAFT_GEOMETRY_BOX: add_box(list, shape->half); break;
    case DAFT_GEOMETRY_HULL: add_hull(list, shape->hull); break;
    case DAFT_GEOMETRY_MESH: add_mesh(list, shape->mesh); break;
    case DAFT_GEOMETRY_FIELD: add_field(list, shape->field); break;
    case DAFT_GEOMETRY_COMPOUND: {
        const daft_rigid body = list->frame;
        for (uint32_t i = 0; i < shape->compound->count; i++) {
            list->frame = daft_rigid_mul(&body, &shape->compound->children[i].pose);
            add_shape(list, &shape->compound->children[i].shape); /* no child is a compound */
        }
        break;
    }
    case DAFT_GEOMETRY_NONE: break;
    }
}

static bool overlap(const daft_daabb *a, const daft_daabb *b)
{
    return a->low.x <= b->high.x && a->low.y <= b->high.y && a->low.z <= b->high.z && b->low.x <= a->high.x &&
           b->low.y <= a->high.y && b->low.z <= a->high.z;
}

uint32_t daft_world_edges(const daft_world *world, daft_dvec3 centre, float radius, daft_sim_edge *out,
                          uint32_t capacity)
{
    const daft_dvec3 reach = daft_dv3((double)radius, (double)radius, (double)radius);
    edge_list list = {.out = out, .capacity = capacity};
    list.near = (daft_daabb){daft_dsub(centre, reach), daft_dadd(centre, reach)};
    for (uint32_t i = 0; i < world->part_count; i++) {
        const daft_sim_part *part = &world->parts[i];
        if (part->body == DAFT_SIM_NONE) continue;
        const daft_sim_body *body = &world->bodies[part->body];
        list.frame = daft_sim_part_frame(body, part);
        const daft_daabb bounds = daft_shape_bounds(&part->shape, &list.frame);
        if (!overlap(&bounds, &list.near)) continue;
        list.like = (daft_sim_edge){
            .user = body->user, .kind = body->kind, .awake = daft_sim_is_active(body), .sensor = part->sensor};
        add_shape(&list, &part->shape);
    }
    return list.count;
}
