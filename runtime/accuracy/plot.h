/* plot: pages of HTML that need nothing else, and error over time as SVG. Both axes are logarithmic; an error of zero
 * lies on the bottom line. */
#ifndef RUNTIME_ACCURACY_PLOT_H
#define RUNTIME_ACCURACY_PLOT_H

#include <stdbool.h>
#include <stdio.h>

typedef struct plot {
    FILE *out;
    const char *x_name, *y_name;
    double x0, x1, y0, y1; /* logarithms to the base 10; x1 < x0: nothing is in it yet */
} plot;

/* From <!doctype> to <body>, and from there to the end. */
void page_begin(FILE *out, const char *title);
void page_end(FILE *out);
void page_text(FILE *out, const char *text); /* escaped */

/* Makes room for a point; errors of zero need none. */
void plot_fit(plot *p, double x, double y);
/* Once all are in: a margin. */
void plot_widen(plot *p);

void plot_begin(const plot *p, const char *title, const char *doc);
/* `command`: what makes the figure again; it stands under it. */
void plot_end(const plot *p, const char *command);
void plot_limit(const plot *p, double x, const char *unit); /* a line upwards */
void plot_floor(const plot *p, double y, const char *name); /* a line across */
/* With a bar of ± half; `label` beside it, or NULL; `title` on hovering. */
void plot_dot(const plot *p, double x, double half, double y, const char *color, const char *title, const char *label);
void plot_curve_begin(const plot *p, const char *color);
void plot_curve_to(const plot *p, double x, double y);
void plot_curve_end(const plot *p);
/* Whether labels at the two places would lie on each other. */
bool plot_too_near(const plot *p, double x, double y, double other_x, double other_y);

#endif
