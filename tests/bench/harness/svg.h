/* A plot of points in small multiples with common logarithmic axes, as one SVG file. In each panel less is better on
 * both axes: what nothing else beats on both is the Pareto front; it is joined by a line, and the rest is drawn faint.
 */
#ifndef DAFT_BENCH_SVG_H
#define DAFT_BENCH_SVG_H

#include <stdbool.h>
#include <stddef.h>

typedef enum svg_shape { SVG_DISC, SVG_SQUARE, SVG_TRIANGLE, SVG_DIAMOND } svg_shape;

typedef struct svg_series {
    const char *name, *color;
    svg_shape shape;
} svg_series;

typedef struct svg_point {
    size_t panel, series;
    double x, y; /* x > 0; y >= 0: zero has a row of its own under the axis */
} svg_point;

typedef struct svg_plot {
    const char *title, *note, *x_label, *y_label;
    const char *const *panels;
    size_t panel_count;
    const svg_series *series;
    size_t series_count;
    const svg_point *points;
    size_t point_count;
    const double *marks; /* vertical lines */
    const char *const *mark_names;
    size_t mark_count;
} svg_plot;

/* Texts are ours: nothing in them needs escaping. False when the file cannot be written. */
bool svg_write(const svg_plot *plot, const char *path);
/* Whether some point of the same panel is at least as good on both axes, and better on one. */
bool svg_is_beaten(const svg_plot *plot, size_t point);

#endif
