/* Joints, and what holds between two kinds of surface. */
#include "scene/fields/fields.h"

#define ROW(m, ...)      DAFT_ROW(daft_joint_def, m, __VA_ARGS__)
#define SURFACES(m, ...) DAFT_ROW(daft_surfaces, m, __VA_ARGS__)

static const char *const KINDS[] = {NULL, "ball", "hinge", "slider", "distance", "fixed", "drag"};

enum {
    BALL = 1 << DAFT_JOINT_BALL,
    HINGE = 1 << DAFT_JOINT_HINGE,
    SLIDER = 1 << DAFT_JOINT_SLIDER,
    DISTANCE = 1 << DAFT_JOINT_DISTANCE,

    DRAG = 1 << DAFT_JOINT_DRAG
};

/* Newtons, or newton metres, that floats can still work with. */
#define FORCES FROM(0, (double)1e30f)

static const daft_field ROWS[] = {
    DAFT_COOKIE_ROW(daft_joint_def),
    DAFT_CHOICE_ROW(
        daft_joint_def, kind, KINDS, .initial = {DAFT_JOINT_BALL}, .lua = "kind",
        .doc = "ball: two points stay together; hinge: and so do two axes; slider: moves along an axis and does not "
               "turn; distance: a rod, rope or spring; fixed: does not move; drag: draws a point to a target"),
    ROW(a, .lua = "a", .doc = "The first body; none: the world itself"),
    ROW(b, .lua = "b", .doc = "The second body"),
    ROW(anchor, .unit = "m", .lua = "at",
        .doc = "Where, in the world, as the bodies stand now; distance: the point on a"),
    ROW(anchor_b, .unit = "m", .kinds = DISTANCE | DRAG, .lua = "to",
        .doc = "distance: the point on b; drag: the target"),
    ROW(axis, .initial = {0, 1, 0}, .kinds = BALL | HINGE | SLIDER, .lua = "axis",
        .doc = "Of a hinge, a slider, or a ball's cone, in the world; any length"),
    ROW(limit, .lua = "limit", .doc = "Whether lower and upper hold"),
    ROW(lower, FROM((double)-1e7f, (double)1e7f),
        .doc = "The lowest value, from the pose of now: radians of a hinge within pi, metres of a slider; distance: a "
               "length"),
    ROW(upper, FROM((double)-1e7f, (double)1e7f), .doc = "The highest value; ball: half the angle of its cone"),
    ROW(motor, .kinds = BALL | HINGE | SLIDER, .lua = "motor", .doc = "Whether it is driven; a ball is braked"),
    ROW(motor_speed, FROM((double)-1e6f, (double)1e6f), .kinds = HINGE | SLIDER,
        .doc = "rad/s or m/s, of b relative to a"),
    ROW(motor_force, FORCES, .kinds = BALL | HINGE | SLIDER,
        .doc = "The greatest torque in N m, or force in N, of the motor"),
    ROW(spring, .lua = "spring",
        .doc = "distance: a spring about its length; hinge, slider: about 0; ball, fixed: the whole joint gives"),
    ROW(hertz, .unit = "Hz", FROM(0, (double)1e6f), .initial = {2},
        .doc = "The frequency of the two bodies on the spring"),
    ROW(damping, FROM(0, (double)1e6f), .initial = {0.7},
        .doc = "The damping ratio of the spring; 1: it does not swing"),
    ROW(length, .unit = "m", FROM(0, (double)1e7f), .kinds = DISTANCE, .lua = "length",
        .doc = "Between the two points; 0: what it is now"),
    ROW(break_force, .unit = "N", FORCES, .lua = "break_force",
        .doc = "The mean over a tick at which it breaks; 0: never"),
    ROW(break_torque, .unit = "N m", FORCES, .lua = "break_torque",
        .doc = "The mean over a tick at which it breaks; 0: never"),
    ROW(collide, .lua = "collide", .doc = "Whether the two bodies still touch each other"),
};

const daft_field_list daft_joint_fields = DAFT_FIELD_LIST(daft_joint_def, ROWS);

static const daft_field SURFACES_ROWS[] = {
    SURFACES(friction, ZERO_OR_MORE, .lua = "friction", .doc = "Coulomb's coefficient"),
    SURFACES(static_friction, ZERO_OR_MORE, .lua = "static_friction", .doc = "The same for what does not slide yet"),
    SURFACES(restitution, FROM(0, 1), .lua = "restitution", .doc = "How much of a bounce comes back"),
    SURFACES(rolling_resistance, ZERO_OR_MORE, .lua = "rolling_resistance",
             .doc = "What brakes rolling, as a fraction of load times radius"),
};

const daft_field_list daft_surfaces_fields = DAFT_FIELD_LIST(daft_surfaces, SURFACES_ROWS);
