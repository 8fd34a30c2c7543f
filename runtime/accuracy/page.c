/* index.html: one page that needs nothing else: plots as SVG, pictures as data. */
#include "accuracy/plot.h"
#include "accuracy/report.h"

#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SHOWN = 6, LABEL = 28 };

/* ---- plots ------------------------------------------------------------------------------------------------------- */

static plot make_plot(FILE *out, const report_def *def)
{
    const sweep_result *s = def->sweep;
    plot p = {.out = out, .x_name = "milliseconds a picture", .y_name = "mean FLIP", .x0 = 1};
    for (size_t i = 0; i < s->count; i++) plot_fit(&p, s->points[i].ms, s->points[i].errors.flip);
    plot_fit(&p, s->points[0].ms, s->floor.flip);
    p.x1 = fmax(p.x1, log10(def->budget_ms));
    plot_widen(&p);
    return p;
}

static void put_lines(const report_def *def, const plot *p)
{
    plot_limit(p, def->budget_ms, "ms");
    plot_floor(p, def->sweep->floor.flip, "floor of the reference");
}

/* "samples=4,edge_samples=0" is 4, 0 beside its dot. */
static void make_label(const sweep_point *p, char out[LABEL])
{
    size_t used = 0;
    for (const char *at = p->setting; *at && used + 1 < LABEL;) {
        const size_t length = strcspn(at, ",");
        const char *equals = memchr(at, '=', length), *value = equals ? equals + 1 : at;
        used +=
            (size_t)snprintf(out + used, LABEL - used, "%s%.*s", used ? " " : "", (int)(at + length - value), value);
        at += length + (at[length] == ',');
    }
}

static void put_dot(const plot *p, const sweep_point *point, const char *color, bool named)
{
    char title[SETTING_TEXT + 64], label[LABEL] = "";
    snprintf(title, sizeof title, "%s: %.2f ms, FLIP %.4f", point->setting, point->ms, point->errors.flip);
    make_label(point, label);
    plot_dot(p, point->ms, point->spread, point->errors.flip, color, title, named ? label : NULL);
}

static void put_knob_plot(const plot *p, const report_def *def, const char *name, const char *doc)
{
    const sweep_result *s = def->sweep;
    const sweep_point *last = NULL;
    plot_begin(p, name, doc);
    put_lines(def, p);
    plot_curve_begin(p, "#27c");
    for (size_t i = 0; i < s->count; i++)
        if (strcmp(s->points[i].knob, name) == 0) plot_curve_to(p, s->points[i].ms, s->points[i].errors.flip);
    plot_curve_end(p);
    for (size_t i = 0; i < s->count; i++) {
        const sweep_point *q = &s->points[i];
        if (strcmp(q->knob, name) != 0) continue;
        const bool apart = !last || !plot_too_near(p, q->ms, q->errors.flip, last->ms, last->errors.flip);
        if (apart) last = q;
        put_dot(p, q, "#27c", apart);
    }
    plot_end(p, def->command);
}

static void put_front_plot(const plot *p, const report_def *def)
{
    const sweep_result *s = def->sweep;
    size_t order[SWEEP_POINTS];
    report_sort(s, order);
    plot_begin(p, "All settings",
               "Orange: no other setting beats it. Grey: another is faster or closer, and not worse.");
    put_lines(def, p);
    for (size_t i = 0; i < s->count; i++)
        if (!s->points[i].on_front) put_dot(p, &s->points[i], "#bbb", false);
    plot_curve_begin(p, "#e70");
    double lowest = INFINITY; /* of the settings that are called equal, the line joins those that lead */
    for (size_t i = 0; i < s->count; i++) {
        const sweep_point *q = &s->points[order[i]];
        if (!q->on_front || q->errors.flip >= lowest) continue;
        lowest = q->errors.flip;
        plot_curve_to(p, q->ms, q->errors.flip);
    }
    plot_curve_end(p);
    for (size_t i = 0; i < s->count; i++)
        if (s->points[i].on_front) put_dot(p, &s->points[i], "#e70", false);
    plot_end(p, def->command);
}

static void put_plots(FILE *out, const report_def *def)
{
    const plot p = make_plot(out, def);
    fprintf(out, "<h2>Error over time</h2><div class=\"plots\">\n");
    put_front_plot(&p, def);
    put_knob_plot(&p, def, "quality", "The presets.");
    const knob_row *only = def->sweep->def.knob;
    if (only) put_knob_plot(&p, def, only->name, only->doc);
    for (size_t k = 0; !only && k < KNOBS; k++) put_knob_plot(&p, def, knob_at(k)->name, knob_at(k)->doc);
    fprintf(out, "</div>\n");
}

/* ---- table ------------------------------------------------------------------------------------------------------- */

static void put_row(FILE *out, const sweep_result *s, const sweep_point *p)
{
    const picture_errors *e = &p->errors;
    fprintf(out, "<tr class=\"%s\"><td>%.2f</td><td>%.2f</td><td>%.4f</td><td>%.5f</td><td>",
            p->on_front ? "front" : "beaten", p->ms, p->spread, e->flip, e->rmse);
    if (isfinite(e->psnr)) fprintf(out, "%.2f", e->psnr);
    fprintf(out, "</td><td>%.5f</td><td>%.4f</td>", e->ssim, e->worst);
    if (s->def.moments) fprintf(out, "<td>%.4f</td>", p->temporal);
    fprintf(out, "<td>%s ", p->knob);
    page_text(out, p->setting);
    int other = p->same_as >= 0 ? p->same_as : p->beaten_by;
    if (other >= 0) {
        fprintf(out, " &mdash; %s %s ", p->same_as >= 0 ? "the same picture and time as" : "beaten by",
                s->points[other].knob);
        page_text(out, s->points[other].setting);
    }
    fprintf(out, "</td></tr>\n");
}

static void put_table(FILE *out, const sweep_result *s)
{
    size_t order[SWEEP_POINTS];
    report_sort(s, order);
    fprintf(out,
            "<h2>All settings</h2><table><tr><th>ms</th><th>&plusmn;</th><th>FLIP</th><th>RMSE</th><th>PSNR</th>"
            "<th>SSIM</th><th>worst tile</th>%s<th>setting</th></tr>\n",
            s->def.moments ? "<th>temporal FLIP</th>" : "");
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
    page_text(out, p->setting);
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

/* ---- what the preset's picture is made of, and wrong pixels ------------------------------------------------------ */

static void put_effects(FILE *out, const sweep_result *s)
{
    fprintf(out,
            "<h2>What a picture of quality %s is made of</h2><p>An effect that nothing in sight calls for costs no "
            "rays, no bytes and no time.</p><table><tr><th>ms</th><th>rays</th><th>bytes</th><th>tiles</th>"
            "<th>effect</th></tr>\n",
            daft_preset_name(s->def.preset));
    for (int i = 0; i < DAFT_EFFECT_COUNT; i++) {
        const daft_effect *e = &s->counters.effects[i];
        fprintf(out,
                "<tr class=\"%s\"><td>%.2f</td><td>%llu</td><td>%llu</td><td>%u</td><td>%s: ", e->ran ? "" : "beaten",
                e->ms, (unsigned long long)e->rays, (unsigned long long)e->bytes, e->tiles, e->name);
        page_text(out, e->why ? e->why : "");
        fprintf(out, "</td></tr>\n");
    }
    fprintf(out, "</table>\n");
}

static bool put_wrong(FILE *out, const report_def *def, int which, daft_error *error)
{
    const sweep_result *s = def->sweep;
    const sweep_wrong *wrong = &s->wrong[which];
    const size_t bytes = 4 * (size_t)s->def.width * (size_t)s->def.height;
    char text[SENTENCE];
    report_wrong(s, which, text);
    fprintf(out, "<p>");
    page_text(out, text);
    fprintf(out, "</p>\n");
    if (wrong->count == 0 || def->no_pictures) return true;
    uint8_t *painted = malloc(bytes);
    if (!painted) return fail(error, DAFT_ERROR_MEMORY, "out of memory for wrong pixels");
    memcpy(painted, s->points[s->preset].pixels, bytes);
    wrong_paint(wrong->mask, s->def.width, s->def.height, painted);
    fprintf(out, "<div class=\"dots\"><label><input type=\"checkbox\" checked> red dots over wrong pixels</label><br>"
                 "<div class=\"pair\">");
    const bool good =
        put_picture(out, def, s->points[s->preset].pixels, error) && put_picture(out, def, painted, error);
    fprintf(out, "</div></div>\n");
    free(painted);
    return good;
}

static bool put_wrongs(FILE *out, const report_def *def, daft_error *error)
{
    fprintf(out, "<h2>Wrong pixels</h2>\n");
    for (int i = 0; i < SWEEP_WRONG; i++)
        if (!put_wrong(out, def, i, error)) return false;
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
    char title[SENTENCE];
    snprintf(title, sizeof title, "What accuracy costs: %s", def->scene);
    page_begin(out, title);
    report_advise(def, text);
    fprintf(out, "<p class=\"advice\">");
    page_text(out, text);
    report_floor(def, text);
    fprintf(out, "</p><p>");
    page_text(out, text);
    fprintf(
        out,
        " FLIP at %.0f pixels a degree; RMSE and PSNR in linear light; &plusmn; is half of the distance between the "
        "quartiles. %d&times;%d pixels%s.</p><p>Made by <code>",
        METRICS_PPD, def->sweep->def.width, def->sweep->def.height,
        def->sweep->def.moments ? "; means over moments of the game, whose texts over the picture are left out" : "");
    page_text(out, def->command);
    fprintf(out, "</code></p>\n");
    put_plots(out, def);
    put_effects(out, def->sweep);
    bool good = (def->no_pictures || put_pairs(out, def, error)) && put_wrongs(out, def, error);
    put_table(out, def->sweep);
    page_end(out);
    if (good) return draft_commit(&draft, path, error);
    fclose(draft.file);
    free(draft.bytes);
    return false;
}
