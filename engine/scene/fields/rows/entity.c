/* Entities, and what their bodies are made of. */
#include "scene/fields/fields.h"

#define ENTITY(m, ...)   DAFT_ROW(daft_entity_def, m, __VA_ARGS__)
#define COLLIDER(m, ...) DAFT_ROW(daft_collider, m, __VA_ARGS__)

static const char *const SHAPES[] = {"none", "mesh", "sphere", "box"};
static const char *const BODIES[] = {"none", "static", "kinematic", "dynamic"};

enum { MESH = 1 << DAFT_SHAPE_MESH, SPHERE = 1 << DAFT_SHAPE_SPHERE, BOX = 1 << DAFT_SHAPE_BOX };
enum { SEEN = DAFT_FIELD_HASHED, BODY = DAFT_FIELD_NOT_HASHED };

static const daft_field ENTITY_ROWS[] = {
    DAFT_COOKIE_ROW(daft_entity_def),
    DAFT_CHOICE_ROW(daft_entity_def, shape, SHAPES, .flags = SEEN,
                    .doc = "What is drawn; none: a group, or a body alone"),
    ENTITY(mesh, .kinds = MESH, .lua = "mesh", .flags = SEEN, .doc = "The mesh that is drawn"),
    ENTITY(radius, .unit = "m", ABOVE_ZERO, .initial = {0.5}, .kinds = SPHERE, .lua = "sphere", .flags = SEEN,
           .doc = "The sphere's radius"),
    ENTITY(size, .unit = "m", ABOVE_ZERO, .initial = {1, 1, 1}, .kinds = BOX, .lua = "box", .flags = SEEN,
           .doc = "The box's edge lengths"),
    ENTITY(material, .lua = "material", .flags = SEEN,
           .doc = "What it is made of; none: the mesh's own, or a light grey"),
    ENTITY(parent, .lua = "parent", .flags = SEEN,
           .doc = "The entity within which position, rotation and scale are; none: the world"),
    ENTITY(position, .unit = "m", .lua = "position", .flags = SEEN, .doc = "Where it is"),
    ENTITY(rotation, .initial = {0, 0, 0, 1}, .lua = "rotation", .flags = SEEN, .doc = "How it is turned"),
    ENTITY(scale, .initial = {1, 1, 1}, .lua = "scale", .flags = SEEN | DAFT_FIELD_UNIFORM,
           .doc = "How many times as large it is along its own axes; a sphere's is equal in all"),
    ENTITY(visible, .initial = {true}, .lua = "visible", .scene = "visible", .flags = SEEN,
           .doc = "Whether it is drawn and hit by rays"),
    ENTITY(casts_shadow, .initial = {true}, .lua = "casts_shadow", .scene = "shadow", .flags = SEEN,
           .doc = "Whether it casts shadows; light comes through materials that transmit"),
    DAFT_CHOICE_ROW(daft_entity_def, body, BODIES, .lua = "body", .flags = SEEN,
                    .doc = "How the simulation moves it: not at all, as the game says, or by forces and contacts"),
    DAFT_OTHER_ROW(
        daft_entity_def, colliders, .lua = "collider",
        .doc = "What the body is made of; none: what is drawn, of a mesh the hull where it is dynamic, else the "
               "triangles"),
    ENTITY(collider_count, FROM(0, 65536), .flags = BODY, .doc = "How many colliders there are"),
    ENTITY(density, .unit = "kg/m³", ABOVE_ZERO, .initial = {1000}, .lua = "density", .flags = SEEN,
           .doc = "The mass of a cubic metre of it"),
    ENTITY(mass, .unit = "kg", ZERO_OR_MORE, .lua = "mass", .flags = BODY, .doc = "Its mass; 0: from the density"),
    ENTITY(friction, ZERO_OR_MORE, .initial = {0.5}, .lua = "friction", .flags = SEEN,
           .doc = "Coulomb's coefficient; between two bodies the geometric mean holds"),
    ENTITY(static_friction, ZERO_OR_MORE, .lua = "static_friction", .flags = BODY,
           .doc = "The same for what does not slide yet; less than friction: the same as friction"),
    ENTITY(restitution, FROM(0, 1), .lua = "restitution", .flags = SEEN,
           .doc = "How much of a bounce comes back; between two bodies the larger holds"),
    ENTITY(rolling_resistance, ZERO_OR_MORE, .lua = "rolling_resistance", .flags = SEEN,
           .doc = "What brakes rolling, as a fraction of load times radius; the larger of two bodies' holds"),
    ENTITY(surface, FROM(0, 63), .lua = "surface", .flags = BODY,
           .doc = "The kind of its surface, for pairs of surfaces"),
    ENTITY(surface_velocity, .unit = "m/s", .lua = "surface_velocity", .flags = BODY,
           .doc = "The velocity of its surface in its own axes, as a conveyor's"),
    ENTITY(gravity_scale, .initial = {1}, .lua = "gravity_scale", .flags = BODY,
           .doc = "The fraction of gravity that acts on it"),
    ENTITY(linear_damping, .unit = "1/s", ZERO_OR_MORE, .lua = "damping", .flags = BODY,
           .doc = "The fraction of its velocity that it loses in a second, for small ones"),
    ENTITY(angular_damping, .unit = "1/s", ZERO_OR_MORE, .lua = "angular_damping", .flags = BODY,
           .doc = "The same of its angular velocity"),
    ENTITY(locks, .lua = "lock", .flags = BODY,
           .doc = "Axes of the world about which it does not turn, and along which its centre of mass does not move"),
    ENTITY(layers, .initial = {1}, .lua = "layer", .flags = BODY, .doc = "The layers that it is in"),
    ENTITY(mask, .initial = {UINT32_MAX}, .lua = "hits", .flags = BODY,
           .doc = "The layers that it meets; two bodies meet where each meets a layer of the other"),
    ENTITY(sensor, .lua = "sensor", .flags = BODY, .doc = "Meets nothing; what enters and leaves it makes events"),
    ENTITY(bullet, .lua = "bullet", .flags = BODY, .doc = "Does not pass through fast dynamic bodies either"),
    ENTITY(sleeps, .initial = {true}, .lua = "sleeps", .flags = BODY, .doc = "Whether it may fall asleep at rest"),
    ENTITY(lights, .kinds = MESH | SPHERE | BOX, .lua = "lights", .scene = "lights",
           .doc = "Whether what its material gives off lights what is around"),
};

const daft_field_list daft_entity_fields = DAFT_FIELD_LIST(daft_entity_def, ENTITY_ROWS);

/* ---- colliders ---- */

static const char *const COLLIDERS[] = {NULL, "sphere", "capsule", "box", "hull", "mesh", "field", "cylinder"};

enum {
    ROUND = 1 << DAFT_COLLIDER_SPHERE | 1 << DAFT_COLLIDER_CAPSULE | 1 << DAFT_COLLIDER_CYLINDER,
    LONG = 1 << DAFT_COLLIDER_CAPSULE | 1 << DAFT_COLLIDER_CYLINDER,
    FIELD = 1 << DAFT_COLLIDER_FIELD
};
#define LENGTHS FROM((double)1e-4f, (double)1e7f)

static const daft_field COLLIDER_ROWS[] = {
    DAFT_CHOICE_ROW(daft_collider, kind, COLLIDERS, .initial = {DAFT_COLLIDER_SPHERE}, .doc = "Its shape"),
    COLLIDER(radius, .unit = "m", LENGTHS, .initial = {0.5}, .kinds = ROUND, .doc = "Of a sphere, capsule or cylinder"),
    COLLIDER(height, .unit = "m", LENGTHS, .initial = {2}, .kinds = LONG,
             .doc = "From end to end along y; a capsule's is more than twice its radius"),
    COLLIDER(size, .unit = "m", LENGTHS, .initial = {1, 1, 1}, .kinds = 1 << DAFT_COLLIDER_BOX,
             .doc = "A box's edge lengths"),
    COLLIDER(mesh, .kinds = 1 << DAFT_COLLIDER_HULL | 1 << DAFT_COLLIDER_MESH,
             .doc = "Of a hull (at most 64 corners) or of triangles; none: the entity's"),
    DAFT_OTHER_ROW(
        daft_collider, heights, .unit = "m", .kinds = FIELD,
        .doc = "A height field's heights row by row: heights[row * columns + column] is at x = column * spacing.x, "
               "z = row * spacing.y; NaN makes a hole; copied"),
    COLLIDER(columns, .kinds = FIELD, .doc = "Heights in a row, 2 to 16384"),
    COLLIDER(rows, .kinds = FIELD, .doc = "Rows of heights, 2 to 16384"),
    COLLIDER(spacing, .unit = "m", LENGTHS, .initial = {1, 1}, .kinds = FIELD,
             .doc = "Between columns, and between rows"),
    COLLIDER(position, .unit = "m", .lua = "position", .doc = "In the entity's axes"),
    COLLIDER(rotation, .initial = {0, 0, 0, 1}, .lua = "rotation", .doc = "In the entity's axes"),
};

const daft_field_list daft_collider_fields = DAFT_FIELD_LIST(daft_collider, COLLIDER_ROWS);
