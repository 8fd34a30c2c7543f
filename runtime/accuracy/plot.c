/* Pages and plots. */
#include "accuracy/plot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 520, HEIGHT = 300, LEFT = 56, BOTTOM = 40, TOP = 14, RIGHT = 16 };

static const char HEAD[] =
    "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>"
    "</title>\n<style>body{font:15px/1.45 system-ui,sans-serif;max-width:1120px;margin:2em auto;padding:0 "
    "1em;color:#222}"
    "table{border-collapse:collapse;font-size:13px}td,th{padding:2px 9px;text-align:right;border-bottom:1px solid #ddd}"
    "td:last-child,th:last-child{text-align:left}tr.front{font-weight:600}tr.beaten{color:#888}"
    ".plots{display:flex;flex-wrap:wrap;gap:12px}figure{margin:0;max-width:520px}figcaption{font-weight:600}"
    ".pair{position:relative;display:inline-block;line-height:0}.pair img{max-width:100%}"
    ".pair img+img{position:absolute;left:0;top:0;clip-path:inset(0 0 0 50%)}.dots img+img{clip-path:none}"
    ".dots:has(input:not(:checked)) img+img{display:none}figure code{font-size:11px}"
    "input[type=range]{display:block;width:100%;max-width:640px}svg{background:#fff}svg text{font:11px "
    "system-ui,sans-serif}"
    "code{background:#f3f3f3;padding:2px 5px;overflow-wrap:anywhere}.advice{font-size:18px}"
    "@media(prefers-color-scheme:dark){body{background:#161616;color:#ddd}svg{background:#fff}code{background:#2a2a2a}"
    "td,th{border-color:#3a3a3a}}</style></head><body>\n";

static const char TAIL[] =
    "<script>for(const r of document.querySelectorAll('input[type=range]'))r.oninput=()=>"
    "r.previousElementSibling.lastElementChild.style.clipPath='inset(0 0 0 '+r.value+'%)';</script></body></html>\n";

void page_text(FILE *out, const char *text)
{
    for (; *text; text++) {
        if (*text == '<' || *text == '>' || *text == '&' || *text == '"')
            fprintf(out, "&#%d;", *text);
        else
            fputc(*text, out);
    }
}

void page_begin(FILE *out, const char *title)
{
    const char *half = strstr(HEAD, "</title>");
    fwrite(HEAD, 1, (size_t)(half - HEAD), out);
    page_text(out, title);
    fprintf(out, "%s<h1>", half);
    page_text(out, title);
    fputs("</h1>\n", out);
}

void page_end(FILE *out) { fputs(TAIL, out); }

/* ---- axes -------------------------------------------------------------------------------------------------------- */

static const double LEAST_X = 1e-4;

static double place_x(const plot *p, double x)
{
    return LEFT + (log10(fmax(x, LEAST_X)) - p->x0) / (p->x1 - p->x0) * (WIDTH - LEFT - RIGHT);
}

static double place_y(const plot *p, double y)
{
    double t = y > 0 ? (log10(y) - p->y0) / (p->y1 - p->y0) : 0;
    return HEIGHT - BOTTOM - fmin(fmax(t, 0), 1) * (HEIGHT - BOTTOM - TOP);
}

static bool is_empty(const plot *p) { return p->x1 < p->x0; }

void plot_fit(plot *p, double x, double y)
{
    const double at = log10(fmax(x, LEAST_X));
    if (is_empty(p)) p->x0 = p->x1 = at, p->y0 = INFINITY, p->y1 = -INFINITY;
    p->x0 = fmin(p->x0, at), p->x1 = fmax(p->x1, at);
    if (y > 0) p->y0 = fmin(p->y0, log10(y)), p->y1 = fmax(p->y1, log10(y));
}

void plot_widen(plot *p)
{
    if (is_empty(p)) p->x0 = p->x1 = 0;
    if (!(p->y0 <= p->y1) || !isfinite(p->y0)) p->y0 = -1, p->y1 = 0; /* no error is above zero */
    p->x0 -= 0.1, p->x1 += 0.1;
    p->y0 -= 0.15, p->y1 = fmax(p->y1 + 0.1, p->y0 + 0.25);
}

static void put_grid(const plot *p)
{
    static const double steps[] = {1, 2, 5};
    FILE *out = p->out;
    const bool coarse = p->y1 - p->y0 > 3; /* decades alone fit */
    for (int e = -12; e < 8; e++) {
        for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
            double v = steps[i] * pow(10, e), l = log10(v), x = place_x(p, v), y = place_y(p, v);
            if (l >= p->x0 && l <= p->x1)
                fprintf(out,
                        "<path d=\"M%.1f %d V%d\" stroke=\"#eee\"/><text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%g"
                        "</text>",
                        x, TOP, HEIGHT - BOTTOM, x, HEIGHT - BOTTOM + 14, v);
            if (l >= p->y0 && l <= p->y1 && (i == 0 || !coarse))
                fprintf(
                    out,
                    "<path d=\"M%d %.1f H%d\" stroke=\"#eee\"/><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%g</text>",
                    LEFT, y, WIDTH - RIGHT, LEFT - 5, y + 4, v);
        }
    }
    fprintf(out, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">%s</text>", WIDTH / 2, HEIGHT - 8, p->x_name);
    fprintf(out, "<text transform=\"translate(13 %d) rotate(-90)\" text-anchor=\"middle\">%s</text>", HEIGHT / 2,
            p->y_name);
}

/* ---- what is drawn ------------------------------------------------------------------------------------------------ */

void plot_begin(const plot *p, const char *title, const char *doc)
{
    fprintf(p->out, "<figure><figcaption>%s</figcaption>%s<br><svg width=\"%d\" height=\"%d\">", title, doc, WIDTH,
            HEIGHT);
    put_grid(p);
}

void plot_end(const plot *p, const char *command)
{
    fprintf(p->out, "</svg><br><code>");
    page_text(p->out, command);
    fprintf(p->out, "</code></figure>\n");
}

void plot_limit(const plot *p, double x, const char *unit)
{
    const double at = place_x(p, x);
    if (log10(fmax(x, LEAST_X)) <= p->x0) return;
    fprintf(p->out,
            "<path d=\"M%.1f %d V%d\" stroke=\"#d33\" stroke-dasharray=\"4 3\"/><text x=\"%.1f\" y=\"%d\" "
            "fill=\"#d33\">%g %s</text>",
            at, TOP, HEIGHT - BOTTOM, at + 3, TOP + 10, x, unit);
}

void plot_floor(const plot *p, double y, const char *name)
{
    const double at = place_y(p, y);
    if (!(y > 0)) return;
    fprintf(p->out,
            "<path d=\"M%d %.1f H%d\" stroke=\"#777\" stroke-dasharray=\"2 3\"/><text x=\"%d\" y=\"%.1f\" "
            "fill=\"#777\" text-anchor=\"end\">%s</text>",
            LEFT, at, WIDTH - RIGHT, WIDTH - RIGHT, at - 4, name);
}

void plot_dot(const plot *p, double x, double half, double y, const char *color, const char *title, const char *label)
{
    const double at = place_x(p, x), down = place_y(p, y);
    FILE *out = p->out;
    fprintf(out, "<path d=\"M%.1f %.1f H%.1f\" stroke=\"%s\"/>", fmax(place_x(p, x - half), LEFT), down,
            fmin(place_x(p, x + half), WIDTH - RIGHT), color);
    fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" fill=\"%s\"><title>", at, down, label ? 4.0 : 3.0, color);
    page_text(out, title);
    fprintf(out, "</title></circle>");
    if (!label) return;
    const bool right = at > WIDTH - 130;
    fprintf(out, "<text x=\"%.1f\" y=\"%.1f\"%s>", right ? at - 6 : at + 6, down - 5,
            right ? " text-anchor=\"end\"" : "");
    page_text(out, label);
    fprintf(out, "</text>");
}

void plot_curve_begin(const plot *p, const char *color)
{
    fprintf(p->out, "<polyline fill=\"none\" stroke=\"%s\" points=\"", color);
}

void plot_curve_to(const plot *p, double x, double y) { fprintf(p->out, "%.1f,%.1f ", place_x(p, x), place_y(p, y)); }

void plot_curve_end(const plot *p) { fprintf(p->out, "\"/>"); }

bool plot_too_near(const plot *p, double x, double y, double other_x, double other_y)
{
    return fabs(place_x(p, x) - place_x(p, other_x)) <= 48 && fabs(place_y(p, y) - place_y(p, other_y)) <= 12;
}
