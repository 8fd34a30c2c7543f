/* index.html: one page that needs nothing else: plots as SVG, pictures as data. */
#include "accuracy/report.h"

#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PLOT_WIDTH = 520, PLOT_HEIGHT = 300, LEFT = 56, BOTTOM = 40, TOP = 14, RIGHT = 16, SHOWN = 6 };

static const char HEAD[] =
    "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>What accuracy costs</title>\n"
    "<style>body{font:15px/1.45 system-ui,sans-serif;max-width:1120px;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse;font-size:13px}td,th{padding:2px 9px;text-align:right;border-bottom:1px solid #ddd}"
    "td:last-child,th:last-child{text-align:left}tr.front{font-weight:600}tr.beaten{color:#888}"
    ".plots{display:flex;flex-wrap:wrap;gap:12px}figure{margin:0;max-width:520px}figcaption{font-weight:600}"
    ".pair{position:relative;display:inline-block;line-height:0}.pair img{max-width:100%}"
    ".pair img+img{position:absolute;left:0;top:0;clip-path:inset(0 0 0 50%)}"
    "input[type=range]{display:block;width:100%;max-width:640px}svg{background:#fff}svg text{font:11px "
    "system-ui,sans-serif}"
    "code{background:#f3f3f3;padding:2px 5px;overflow-wrap:anywhere}.advice{font-size:18px}"
    "@media(prefers-color-scheme:dark){body{background:#161616;color:#ddd}svg{background:#fff}code{background:#2a2a2a}"
    "td,th{border-color:#3a3a3a}}</style></head><body>\n";

static const char TAIL[] =
    "<script>for(const r of document.querySelectorAll('input[type=range]'))r.oninput=()=>"
    "r.previousElementSibling.lastElementChild.style.clipPath='inset(0 0 0 '+r.value+'%)';</script></body></html>\n";

static void put_html(FILE *out, const char *text)
{
    for (; *text; text++) {
        if (*text == '<' || *text == '>' || *text == '&' || *text == '"')
            fprintf(out, "&#%d;", *text);
        else
            fputc(*text, out);
    }
}

/* ---- plots ------------------------------------------------------------------------------------------------------- */

/* Both axes are logarithmic; an error of zero lies on the bottom line. */
typedef struct plot_axes {
    double x0, x1, y0, y1; /* logarithms to the base 10 */
} plot_axes;

static double place_x(const plot_axes *a, double ms)
{
    return LEFT + (log10(ms) - a->x0) / (a->x1 - a->x0) * (PLOT_WIDTH - LEFT - RIGHT);
}

static double place_y(const plot_axes *a, double error)
{
    double t = error > 0 ? (log10(error) - a->y0) / (a->y1 - a->y0) : 0;
    return PLOT_HEIGHT - BOTTOM - fmin(fmax(t, 0), 1) * (PLOT_HEIGHT - BOTTOM - TOP);
}

static plot_axes make_axes(const report_def *def)
{
    const sweep_result *s = def->sweep;
    plot_axes a = {INFINITY, -INFINITY, 0, -INFINITY};
    double least = s->floor.flip > 0 ? s->floor.flip : 1;
    for (size_t i = 0; i < s->count; i++) {
        const sweep_point *p = &s->points[i];
        double ms = log10(fmax(p->ms, 1e-4));
        a.x0 = fmin(a.x0, ms), a.x1 = fmax(a.x1, ms);
        if (p->errors.flip <= 0) continue;
        least = fmin(least, p->errors.flip);
        a.y1 = fmax(a.y1, log10(p->errors.flip));
    }
    a.x0 -= 0.1, a.x1 = fmax(a.x1, log10(def->budget_ms)) + 0.1;
    a.y0 = log10(least) - 0.15;
    a.y1 = fmax(a.y1, a.y0 + 0.1) + 0.1;
    return a;
}

static void put_grid(FILE *out, const plot_axes *a)
{
    static const double steps[] = {1, 2, 5};
    for (int e = -6; e < 6; e++) {
        for (size_t i = 0; i < COUNT_OF(steps); i++) {
            double v = steps[i] * pow(10, e), l = log10(v), x = place_x(a, v), y = place_y(a, v);
            if (l >= a->x0 && l <= a->x1)
                fprintf(out,
                        "<path d=\"M%.1f %d V%d\" stroke=\"#eee\"/><text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%g"
                        "</text>",
                        x, TOP, PLOT_HEIGHT - BOTTOM, x, PLOT_HEIGHT - BOTTOM + 14, v);
            if (l >= a->y0 && l <= a->y1)
                fprintf(
                    out,
                    "<path d=\"M%d %.1f H%d\" stroke=\"#eee\"/><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%g</text>",
                    LEFT, y, PLOT_WIDTH - RIGHT, LEFT - 5, y + 4, v);
        }
    }
    fprintf(out, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">milliseconds a picture</text>", PLOT_WIDTH / 2,
            PLOT_HEIGHT - 8);
    fprintf(out, "<text transform=\"translate(13 %d) rotate(-90)\" text-anchor=\"middle\">mean FLIP</text>",
            PLOT_HEIGHT / 2);
}

static void put_lines(FILE *out, const report_def *def, const plot_axes *a)
{
    double x = place_x(a, def->budget_ms), y = place_y(a, def->sweep->floor.flip);
    if (log10(def->budget_ms) > a->x0)
        fprintf(out,
                "<path d=\"M%.1f %d V%d\" stroke=\"#d33\" stroke-dasharray=\"4 3\"/><text x=\"%.1f\" y=\"%d\" "
                "fill=\"#d33\">%g ms</text>",
                x, TOP, PLOT_HEIGHT - BOTTOM, x + 3, TOP + 10, def->budget_ms);
    fprintf(out,
            "<path d=\"M%d %.1f H%d\" stroke=\"#777\" stroke-dasharray=\"2 3\"/><text x=\"%d\" y=\"%.1f\" "
            "fill=\"#777\" text-anchor=\"end\">floor of the reference</text>",
            LEFT, y, PLOT_WIDTH - RIGHT, PLOT_WIDTH - RIGHT, y - 4);
}

static void put_dot(FILE *out, const plot_axes *a, const sweep_point *p, const char *color, bool name)
{
    double x = place_x(a, p->ms), y = place_y(a, p->errors.flip), half = p->spread;
    fprintf(out, "<path d=\"M%.1f %.1f H%.1f\" stroke=\"%s\"/>", place_x(a, fmax(p->ms - half, 1e-4)), y,
            place_x(a, p->ms + half), color);
    fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" fill=\"%s\"><title>", x, y, name ? 4.0 : 3.0, color);
    put_html(out, p->setting);
    fprintf(out, ": %.2f ms, FLIP %.4f</title></circle>", p->ms, p->errors.flip);
    if (!name) return;
    const char *equals = strchr(p->setting, '=');
    bool right = x > PLOT_WIDTH - 110;
    fprintf(out, "<text x=\"%.1f\" y=\"%.1f\"%s>", right ? x - 6 : x + 6, y - 5, right ? " text-anchor=\"end\"" : "");
    put_html(out, equals ? equals + 1 : p->setting);
    fprintf(out, "</text>");
}

static void begin_plot(FILE *out, const char *title, const char *doc)
{
    fprintf(out, "<figure><figcaption>%s</figcaption>%s<br><svg width=\"%d\" height=\"%d\">", title, doc, PLOT_WIDTH,
            PLOT_HEIGHT);
}

static void put_knob_plot(FILE *out, const report_def *def, const plot_axes *a, const char *name, const char *doc)
{
    const sweep_result *s = def->sweep;
    double named_x = -100, named_y = -100;
    begin_plot(out, name, doc);
    put_grid(out, a);
    put_lines(out, def, a);
    fprintf(out, "<polyline fill=\"none\" stroke=\"#27c\" points=\"");
    for (size_t i = 0; i < s->count; i++)
        if (strcmp(s->points[i].knob, name) == 0)
            fprintf(out, "%.1f,%.1f ", place_x(a, s->points[i].ms), place_y(a, s->points[i].errors.flip));
    fprintf(out, "\"/>");
    for (size_t i = 0; i < s->count; i++) {
        const sweep_point *p = &s->points[i];
        if (strcmp(p->knob, name) != 0) continue;
        double x = place_x(a, p->ms), y = place_y(a, p->errors.flip);
        bool apart = fabs(x - named_x) > 24 || fabs(y - named_y) > 12; /* pixels that a name needs */
        if (apart) named_x = x, named_y = y;
        put_dot(out, a, p, "#27c", apart);
    }
    fprintf(out, "</svg></figure>\n");
}

static void put_front_plot(FILE *out, const report_def *def, const plot_axes *a)
{
    const sweep_result *s = def->sweep;
    size_t order[SWEEP_POINTS];
    report_sort(s, order);
    begin_plot(out, "All settings",
               "Orange: no other setting beats it. Grey: another is faster or closer, and not worse.");
    put_grid(out, a);
    put_lines(out, def, a);
    for (size_t i = 0; i < s->count; i++)
        if (!s->points[i].on_front) put_dot(out, a, &s->points[i], "#bbb", false);
    fprintf(out, "<polyline fill=\"none\" stroke=\"#e70\" points=\"");
    double lowest = INFINITY; /* of the settings that are called equal, the line joins those that lead */
    for (size_t i = 0; i < s->count; i++) {
        const sweep_point *p = &s->points[order[i]];
        if (!p->on_front || p->errors.flip >= lowest) continue;
        lowest = p->errors.flip;
        fprintf(out, "%.1f,%.1f ", place_x(a, p->ms), place_y(a, p->errors.flip));
    }
    fprintf(out, "\"/>");
    for (size_t i = 0; i < s->count; i++)
        if (s->points[i].on_front) put_dot(out, a, &s->points[i], "#e70", false);
    fprintf(out, "</svg></figure>\n");
}

static void put_plots(FILE *out, const report_def *def)
{
    plot_axes axes = make_axes(def);
    fprintf(out, "<h2>Error over time</h2><div class=\"plots\">\n");
    put_front_plot(out, def, &axes);
    put_knob_plot(out, def, &axes, "quality", "The presets.");
    for (size_t k = 0; k < KNOBS; k++) put_knob_plot(out, def, &axes, knob_at(k)->name, knob_at(k)->doc);
    fprintf(out, "</div>\n");
}

/* ---- table ------------------------------------------------------------------------------------------------------- */

static void put_row(FILE *out, const sweep_result *s, const sweep_point *p)
{
    const picture_errors *e = &p->errors;
    fprintf(out, "<tr class=\"%s\"><td>%.2f</td><td>%.2f</td><td>%.4f</td><td>%.5f</td><td>",
            p->on_front ? "front" : "beaten", p->ms, p->spread, e->flip, e->rmse);
    if (isfinite(e->psnr)) fprintf(out, "%.2f", e->psnr);
    fprintf(out, "</td><td>%.5f</td><td>%.4f</td><td>%s ", e->ssim, e->worst, p->knob);
    put_html(out, p->setting);
    int other = p->same_as >= 0 ? p->same_as : p->beaten_by;
    if (other >= 0) {
        fprintf(out, " &mdash; %s %s ", p->same_as >= 0 ? "the same picture and time as" : "beaten by",
                s->points[other].knob);
        put_html(out, s->points[other].setting);
    }
    fprintf(out, "</td></tr>\n");
}

static void put_table(FILE *out, const sweep_result *s)
{
    size_t order[SWEEP_POINTS];
    report_sort(s, order);
    fprintf(out, "<h2>All settings</h2><table><tr><th>ms</th><th>&plusmn;</th><th>FLIP</th><th>RMSE</th><th>PSNR</th>"
                 "<th>SSIM</th><th>worst tile</th><th>setting</th></tr>\n");
    for (size_t i = 0; i < s->count; i++) put_row(out, s, &s->points[order[i]]);
    fprintf(out, "</table>\n");
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static void put_base64(FILE *out, const uint8_t *bytes, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        unsigned left = size - i < 3 ? (unsigned)(size - i) : 3;
        unsigned bits = (unsigned)bytes[i] << 16;
        if (left > 1) bits |= (unsigned)bytes[i + 1] << 8;
        if (left > 2) bits |= bytes[i + 2];
        for (unsigned k = 0; k < 4; k++) fputc(k <= left ? digits[bits >> (18 - 6 * k) & 63] : '=', out);
    }
}

/* The picture goes through a PNG file in the folder, since that is how the library encodes. */
static bool put_picture(FILE *out, const report_def *def, const uint8_t *pixels, daft_error *error)
{
    const sweep_result *s = def->sweep;
    char name[48], path[PATH_SIZE];
    snprintf(name, sizeof name, ".picture-%ld.png", (long)getpid());
    if (!path_join(path, sizeof path, def->folder, name))
        return fail(error, DAFT_ERROR_ARGUMENT, "%s: the path is too long", def->folder);
    daft_image *image = daft_image_create(s->def.engine, s->def.width, s->def.height, error);
    if (!image) return false;
    memcpy(daft_image_pixels(image), pixels, 4 * (size_t)s->def.width * (size_t)s->def.height);
    size_t size = 0;
    uint8_t *bytes = daft_image_write(image, path, error) ? daft_read_file(NULL, path, &size, error) : NULL;
    daft_image_destroy(image);
    unlink(path);
    if (!bytes) return false;
    fprintf(out, "<img alt=\"\" src=\"data:image/png;base64,");
    put_base64(out, bytes, size);
    fprintf(out, "\">");
    free(bytes);
    return true;
}

/* Black is no error, then blue, red, yellow, white: brightness grows all the way. */
static void paint_error(float error, uint8_t out[4])
{
    static const double stops[5][3] = {{0, 0, 0}, {59, 15, 112}, {183, 55, 121}, {252, 153, 94}, {252, 253, 191}};
    double t = fmin(fmax((double)error, 0), 1) * 4;
    int i = t >= 4 ? 3 : (int)t;
    for (int c = 0; c < 3; c++) out[c] = (uint8_t)(stops[i][c] + (stops[i + 1][c] - stops[i][c]) * (t - i) + 0.5);
    out[3] = 255;
}

static bool put_error_map(FILE *out, const report_def *def, const sweep_point *p, daft_error *error)
{
    const sweep_result *s = def->sweep;
    size_t pixels = (size_t)s->def.width * (size_t)s->def.height;
    float *map = malloc(pixels * sizeof *map);
    uint8_t *painted = malloc(4 * pixels);
    bool good = (map && painted) || fail(error, DAFT_ERROR_MEMORY, "out of memory for an error map");
    good = good && metrics_flip(p->pixels, s->reference, s->def.width, s->def.height, METRICS_PPD, map, error);
    for (size_t i = 0; good && i < pixels; i++) paint_error(map[i], painted + 4 * i);
    good = good && put_picture(out, def, painted, error);
    free(map);
    free(painted);
    return good;
}

static bool put_pair(FILE *out, const report_def *def, const sweep_point *p, daft_error *error)
{
    fprintf(out, "<h3>%s ", p->knob);
    put_html(out, p->setting);
    fprintf(
        out,
        "</h3><p>%.2f ms, FLIP %.4f. Left of the slider: this setting; right: the reference.</p><div class=\"pair\">",
        p->ms, p->errors.flip);
    if (!put_picture(out, def, p->pixels, error) || !put_picture(out, def, def->sweep->reference, error)) return false;
    fprintf(out,
            "</div><input type=\"range\" min=\"0\" max=\"100\" value=\"50\" aria-label=\"where the pictures meet\">"
            "<p>Its error, black none, white all:</p>");
    bool good = put_error_map(out, def, p, error);
    fputc('\n', out);
    return good;
}

/* The preset, the budget's choice, and settings of the front from the fastest to the best. */
static bool put_pairs(FILE *out, const report_def *def, daft_error *error)
{
    const sweep_result *s = def->sweep;
    size_t order[SWEEP_POINTS], front[SWEEP_POINTS], count = 0;
    bool shown[SWEEP_POINTS] = {false};
    int best = sweep_choose(s, def->budget_ms);
    report_sort(s, order);
    for (size_t i = 0; i < s->count; i++)
        if (s->points[order[i]].on_front) front[count++] = order[i];
    shown[s->preset] = true;
    if (best >= 0) shown[best] = true;
    for (size_t i = 0; i + 2 < SHOWN && count > 0; i++) shown[front[i * (count - 1) / (SHOWN - 3)]] = true;
    fprintf(out, "<h2>Pictures</h2>\n");
    for (size_t i = 0; i < s->count; i++)
        if (shown[order[i]] && !put_pair(out, def, &s->points[order[i]], error)) return false;
    return true;
}

bool report_write_page(const report_def *def, daft_error *error)
{
    char path[PATH_SIZE], text[SENTENCE];
    draft_file draft;
    if (!path_join(path, sizeof path, def->folder, "index.html"))
        return fail(error, DAFT_ERROR_ARGUMENT, "%s: the path is too long", def->folder);
    if (!draft_open(&draft, error)) return false;
    FILE *out = draft.file;
    fputs(HEAD, out);
    fprintf(out, "<h1>What accuracy costs: ");
    put_html(out, def->scene);
    report_advise(def, text);
    fprintf(out, "</h1><p class=\"advice\">");
    put_html(out, text);
    report_floor(def, text);
    fprintf(out, "</p><p>");
    put_html(out, text);
    fprintf(
        out,
        " FLIP at %.0f pixels a degree; RMSE and PSNR in linear light; &plusmn; is half of the distance between the "
        "quartiles. %d&times;%d pixels.</p><p>Made by <code>",
        METRICS_PPD, def->sweep->def.width, def->sweep->def.height);
    put_html(out, def->command);
    fprintf(out, "</code></p>\n");
    put_plots(out, def);
    bool good = put_pairs(out, def, error);
    put_table(out, def->sweep);
    fputs(TAIL, out);
    if (good) return draft_commit(&draft, path, error);
    fclose(draft.file);
    free(draft.bytes);
    return false;
}
