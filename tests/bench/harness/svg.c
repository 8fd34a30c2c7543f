/* The SVG writer: a legend on top, panels in three columns, decades as grid lines. */
#include "svg.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum {
    COLUMNS = 3,
    PANEL_WIDTH = 300,
    PANEL_HEIGHT = 200,
    ZERO_ROW = 26, /* under the axis, for points whose y is 0 */
    GAP_X = 78,
    GAP_Y = 92,
    LEFT = 70,
    LEGEND_COLUMNS = 4,
    LEGEND_LINE = 20
};

typedef struct axes {
    double x_low, x_high, y_low, y_high; /* decades */
    double left, top;                    /* of the panel, pixels */
} axes;

static double place_x(const axes *a, double x)
{
    return a->left + (log10(x) - a->x_low) / (a->x_high - a->x_low) * PANEL_WIDTH;
}

static double place_y(const axes *a, double y)
{
    if (!(y > 0)) return a->top + PANEL_HEIGHT + ZERO_ROW / 2.0;
    return a->top + PANEL_HEIGHT - (log10(y) - a->y_low) / (a->y_high - a->y_low) * PANEL_HEIGHT;
}

/* Whole decades around all points; at least one each. */
static axes common_axes(const svg_plot *plot)
{
    axes a = {INFINITY, -INFINITY, 0, 1, 0, 0};
    for (size_t i = 0; i < plot->point_count; i++) {
        const svg_point *p = &plot->points[i];
        a.x_low = fmin(a.x_low, floor(log10(p->x))), a.x_high = fmax(a.x_high, ceil(log10(p->x) + 0.02));
        if (p->y > 0) a.y_high = fmax(a.y_high, ceil(log10(p->y) + 0.02));
    }
    if (!(a.x_low < a.x_high)) a.x_low = 0, a.x_high = 1;
    return a;
}

bool svg_is_beaten(const svg_plot *plot, size_t point)
{
    const svg_point *p = &plot->points[point];
    for (size_t i = 0; i < plot->point_count; i++) {
        const svg_point *q = &plot->points[i];
        if (q->panel == p->panel && q->x <= p->x && q->y <= p->y && (q->x < p->x || q->y < p->y)) return true;
    }
    return false;
}

/* ---- pieces ---- */

static void put_text(FILE *out, double x, double y, const char *anchor, int size, const char *color, const char *text)
{
    fprintf(out, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\" font-size=\"%d\" fill=\"%s\">%s</text>\n", x, y,
            anchor, size, color, text);
}

static void put_line(FILE *out, double x0, double y0, double x1, double y1, const char *style)
{
    fprintf(out, "<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" %s/>\n", x0, y0, x1, y1, style);
}

static void put_marker(FILE *out, const svg_series *series, double x, double y, bool beaten)
{
    char paint[128];
    snprintf(paint, sizeof paint, "fill=\"%s\" stroke=\"%s\" stroke-width=\"1.5\"%s",
             beaten ? "#ffffff" : series->color, series->color, beaten ? " opacity=\"0.65\"" : "");
    switch (series->shape) {
    case SVG_DISC: fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"5\" %s/>\n", x, y, paint); break;
    case SVG_SQUARE:
        fprintf(out, "<rect x=\"%.1f\" y=\"%.1f\" width=\"9\" height=\"9\" %s/>\n", x - 4.5, y - 4.5, paint);
        break;
    case SVG_TRIANGLE: fprintf(out, "<path d=\"M%.1f %.1f l6 10.5 l-12 0 z\" %s/>\n", x, y - 6.5, paint); break;
    case SVG_DIAMOND:
        fprintf(out, "<path d=\"M%.1f %.1f l6.5 6.5 l-6.5 6.5 l-6.5 -6.5 z\" %s/>\n", x, y - 6.5, paint);
        break;
    }
}

static void put_power(FILE *out, double x, double y, const char *anchor, int power)
{
    char text[64];
    if (power >= -2 && power <= 3)
        snprintf(text, sizeof text, "%g", pow(10, power));
    else
        snprintf(text, sizeof text, "10<tspan dy=\"-4\" font-size=\"8\">%d</tspan>", power);
    put_text(out, x, y, anchor, 11, "#444444", text);
}

static void put_grid(FILE *out, const svg_plot *plot, const axes *a)
{
    double bottom = a->top + PANEL_HEIGHT, right = a->left + PANEL_WIDTH, end = bottom + ZERO_ROW;
    for (int d = (int)a->x_low; d <= (int)a->x_high; d++) {
        double x = place_x(a, pow(10, d));
        put_line(out, x, a->top, x, end, "stroke=\"#dddddd\"");
        put_power(out, x, end + 15, "middle", d);
    }
    for (int d = (int)a->y_low; d <= (int)a->y_high; d++) {
        double y = place_y(a, pow(10, d));
        put_line(out, a->left, y, right, y, "stroke=\"#dddddd\"");
        put_power(out, a->left - 6, y + 4, "end", d);
    }
    put_text(out, a->left - 6, bottom + ZERO_ROW / 2.0 + 4, "end", 11, "#444444", "0");
    fprintf(out, "<rect x=\"%.1f\" y=\"%.1f\" width=\"%d\" height=\"%d\" fill=\"none\" stroke=\"#666666\"/>\n", a->left,
            a->top, PANEL_WIDTH, PANEL_HEIGHT + ZERO_ROW);
    put_line(out, a->left, bottom, right, bottom, "stroke=\"#666666\" stroke-dasharray=\"2 2\"");
    for (size_t i = 0; i < plot->mark_count; i++) {
        double x = place_x(a, plot->marks[i]);
        if (x < a->left || x > right) continue;
        put_line(out, x, a->top, x, end, "stroke=\"#999999\" stroke-dasharray=\"5 3\"");
        put_text(out, x, a->top - 4, i % 2 ? "start" : "end", 9, "#777777", plot->mark_names[i]);
    }
}

/* ---- panels ---- */

static int by_x(const void *a, const void *b)
{
    const svg_point *p = *(const svg_point *const *)a, *q = *(const svg_point *const *)b;
    return (p->x > q->x) - (p->x < q->x);
}

/* As a staircase: between two points of the front, only what is worse on an axis can be had. */
static void put_front(FILE *out, const svg_plot *plot, const axes *a, size_t panel)
{
    const svg_point **front = malloc(plot->point_count * sizeof *front);
    size_t count = 0;
    for (size_t i = 0; front && i < plot->point_count; i++)
        if (plot->points[i].panel == panel && !svg_is_beaten(plot, i)) front[count++] = &plot->points[i];
    if (front) qsort(front, count, sizeof *front, by_x);
    fprintf(out, "<path fill=\"none\" stroke=\"#222222\" stroke-width=\"1.2\" d=\"");
    for (size_t i = 0; i < count; i++) {
        double x = place_x(a, front[i]->x), y = place_y(a, front[i]->y);
        if (i)
            fprintf(out, " H%.1f V%.1f", x, y);
        else
            fprintf(out, "M%.1f %.1f", x, y);
    }
    fprintf(out, "%s\"/>\n", count ? "" : "M0 0");
    free(front);
}

static void put_panel(FILE *out, const svg_plot *plot, const axes *a, size_t panel)
{
    put_text(out, a->left, a->top - 18, "start", 13, "#000000", plot->panels[panel]);
    put_grid(out, plot, a);
    put_front(out, plot, a, panel);
    for (int beaten = 1; beaten >= 0; beaten--)
        for (size_t i = 0; i < plot->point_count; i++) {
            const svg_point *p = &plot->points[i];
            if (p->panel == panel && svg_is_beaten(plot, i) == (beaten == 1))
                put_marker(out, &plot->series[p->series], place_x(a, p->x), place_y(a, p->y), beaten == 1);
        }
    put_text(out, a->left + PANEL_WIDTH / 2.0, a->top + PANEL_HEIGHT + ZERO_ROW + 32, "middle", 11, "#444444",
             plot->x_label);
    double y = a->top + PANEL_HEIGHT / 2.0, x = a->left - 44;
    fprintf(out,
            "<text transform=\"translate(%.1f %.1f) rotate(-90)\" text-anchor=\"middle\" font-size=\"11\" "
            "fill=\"#444444\">%s</text>\n",
            x, y, plot->y_label);
}

/* ---- the whole ---- */

static void put_head(FILE *out, const svg_plot *plot, double width)
{
    put_text(out, LEFT, 30, "start", 17, "#000000", plot->title);
    put_text(out, LEFT, 50, "start", 11, "#444444", plot->note);
    for (size_t i = 0; i < plot->series_count; i++) {
        double x = LEFT + (double)(i % LEGEND_COLUMNS) * (width - LEFT) / LEGEND_COLUMNS;
        double y = 74 + (double)(i / LEGEND_COLUMNS) * LEGEND_LINE;
        put_marker(out, &plot->series[i], x + 6, y - 4, false);
        put_text(out, x + 18, y, "start", 12, "#000000", plot->series[i].name);
    }
}

bool svg_write(const svg_plot *plot, const char *path)
{
    FILE *out = fopen(path, "w");
    if (!out) return false;
    size_t rows = (plot->panel_count + COLUMNS - 1) / COLUMNS,
           lines = (plot->series_count + LEGEND_COLUMNS - 1) / LEGEND_COLUMNS;
    double width = LEFT + COLUMNS * (PANEL_WIDTH + GAP_X), head = 74 + (double)lines * LEGEND_LINE + 34;
    double height = head + (double)rows * (PANEL_HEIGHT + ZERO_ROW + GAP_Y);
    fprintf(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" viewBox=\"0 0 %.0f %.0f\" "
        "font-family=\"DejaVu Sans, Arial, sans-serif\">\n<rect width=\"100%%\" height=\"100%%\" fill=\"#ffffff\"/>\n",
        width, height, width, height);
    axes a = common_axes(plot);
    put_head(out, plot, width);
    for (size_t i = 0; i < plot->panel_count; i++) {
        a.left = LEFT + (double)(i % COLUMNS) * (PANEL_WIDTH + GAP_X);
        a.top = head + (double)(i / COLUMNS) * (PANEL_HEIGHT + ZERO_ROW + GAP_Y);
        put_panel(out, plot, &a, i);
    }
    fprintf(out, "</svg>\n");
    bool written = !ferror(out);
    return fclose(out) == 0 && written;
}
