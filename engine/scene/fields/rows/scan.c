/* What a laser scanner measures with. */
#include "scene/fields/fields.h"

#define SCAN(m, ...) DAFT_ROW(daft_scan_def, m, __VA_ARGS__)
#define ANGLE        .unit = "rad", FROM(-DAFT_PI_FLOAT, DAFT_PI_FLOAT)
#define ELEVATION    .unit = "rad", FROM(-DAFT_PI_FLOAT / 2, DAFT_PI_FLOAT / 2)

static const char *const PATTERNS[] = {"spinning", "grid", "rays"};

static const daft_field SCAN_ROWS[] = {
    DAFT_COOKIE_ROW(daft_scan_def),
    DAFT_CHOICE_ROW(daft_scan_def, pattern, PATTERNS, .doc = "Beams that turn, a grid over a field of view, or a list"),
    SCAN(rows, FROM(1, 4096), .initial = {64}, .doc = "Beams one above the other, or rows of the grid"),
    SCAN(columns, FROM(1, 65536), .initial = {2048}, .doc = "Steps of a turn, or columns of the grid"),
    SCAN(bottom, ELEVATION, .initial = {(double)-0.43633231f}, .doc = "The elevation of row 0"),
    SCAN(top, ELEVATION, .initial = {(double)0.26179939f}, .doc = "The elevation of the last row"),
    SCAN(left, ANGLE, .initial = {(double)-0.78539816f}, .doc = "The grid's column 0; 0 is forward"),
    SCAN(right, ANGLE, .initial = {(double)0.78539816f}, .doc = "The grid's last column, positive to the right"),
    DAFT_OTHER_ROW(daft_scan_def, rays, .doc = "Directions of the list, in the sensor's axes"),
    SCAN(ray_count, FROM(0, 268435456), .doc = "How many the list has"),
    SCAN(position, .unit = "m", .doc = "Where the sensor is as the scan begins"),
    SCAN(rotation, .initial = {0, 0, 0, 1}, .doc = "The sensor's axes then: +X looks forward, +Y up, +Z right"),
    SCAN(velocity, .unit = "m/s", .doc = "How the sensor moves"),
    SCAN(spin, .unit = "rad/s", .doc = "How it turns, about an axis of the world"),
    SCAN(duration, .unit = "s", FROM(0, 3600), .initial = {(double)0.1f},
         .doc = "From the first ray to the end of the turn"),
    SCAN(min_range, .unit = "m", FROM(0, 1e6), .initial = {(double)0.3f}, .doc = "What is nearer sends nothing back"),
    SCAN(max_range, .unit = "m", FROM(DAFT_ABOVE_ZERO, 1e9), .initial = {120},
         .doc = "What is farther sends nothing back"),
    SCAN(range_noise, .unit = "m", FROM(0, 1e6), .doc = "Standard deviation of the distances' Gaussian error"),
    SCAN(drop_out, FROM(0, 1), .doc = "The share of returns that get lost"),
    SCAN(seed, .doc = "Of the errors: the same seed, the same errors"),
    SCAN(ignore, .doc = "An entity that rays pass through, the robot itself for example; or none"),
};

const daft_field_list daft_scan_fields = DAFT_FIELD_LIST(daft_scan_def, SCAN_ROWS);
