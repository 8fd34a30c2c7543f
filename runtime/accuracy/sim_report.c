/* The table, the page, the CSV and the JSON of a simulation's settings. */
#include "accuracy/plot.h"
#include "accuracy/sim.h"

#include "common/json.h"
#include "common/util.h"

#include <math.h>
#include <stdlib.h>

enum { SIM_SENTENCE = 512 };

static void advise(const sim_report_def *def, char out[SIM_SENTENCE])
{
    const sim_result *r = def->sim;
    const int best = sim_choose(r, def->budget_ms);
    int cheap = 0;
    for (int k = 1; k < SIM_SETTINGS; k++)
        if (r->settings[k].ms < r->settings[cheap].ms) cheap = k;
    const sim_setting *s = &r->settings[best >= 0 ? best : cheap];
    snprintf(out, SIM_SENTENCE, "%s %g ms a tick%s: %s (%.3f ms ± %.3f, %.3g m off after up to a second).",
             best >= 0 ? "For" : "No setting keeps", def->budget_ms, best >= 0 ? "" : " here. The fastest", s->text,
             s->ms, s->spread, s->position);
}

static void tell_floor(const sim_report_def *def, char out[SIM_SENTENCE])
{
    const sim_result *r = def->sim;
    double least = INFINITY;
    for (int k = 0; k < SIM_SETTINGS; k++)
        if (r->settings[k].position > 0) least = fmin(least, r->settings[k].position);
    const bool fine = r->floor * 10 <= least;
    snprintf(
        out, SIM_SENTENCE,
        "The reference takes %d steps a second (%.2f ms a tick). With half as many it ends %.3g m elsewhere, which "
        "is %s a tenth of the smallest error here%s",
        SIM_REFERENCE_HZ, r->reference_ms, r->floor, fine ? "less than" : "more than",
        fine || !isfinite(least) ? "." : ": errors near this floor say little.");
}

void sim_print(const sim_report_def *def, FILE *out)
{
    const sim_result *r = def->sim;
    char text[SIM_SENTENCE];
    fprintf(out,
            "%s: the same second from %d moment%s of the game, %u bodies\n\n%9s %8s %11s %11s %11s %11s  setting\n",
            def->scene, r->moments, r->moments == 1 ? "" : "s", r->bodies, "ms", "±", "position m", "energy J",
            "overlap m", "joints m");
    for (int k = 0; k < SIM_SETTINGS; k++) {
        const sim_setting *s = &r->settings[k];
        fprintf(out, "%9.3f %8.3f %11.3g %11.3g %11.3g %11.3g  %s", s->ms, s->spread, s->position, s->energy,
                s->penetration, s->joint_gap, s->text);
        fprintf(out, s->beaten_by < 0 ? "\n" : " (beaten by %s)\n",
                s->beaten_by < 0 ? "" : r->settings[s->beaten_by].text);
    }
    advise(def, text);
    fprintf(out, "\n%s\n", text);
    tell_floor(def, text);
    fprintf(out, "%s\nFiles: %s/index.html, points.csv, report.json\n", text, def->folder);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static void put_csv(const sim_report_def *def, FILE *out)
{
    fprintf(out, "scene,knob,setting,ms,ms_spread,position_m,energy_j,penetration_m,joint_m,on_front\n");
    for (int k = 0; k < SIM_SETTINGS; k++) {
        const sim_setting *s = &def->sim->settings[k];
        fprintf(out, "%s,physics,\"%s\",%.5f,%.5f,%.7g,%.7g,%.7g,%.7g,%d\n", def->scene, s->text, s->ms, s->spread,
                s->position, s->energy, s->penetration, s->joint_gap, s->beaten_by < 0);
    }
}

static void put_json(const sim_report_def *def, FILE *out)
{
    const sim_result *r = def->sim;
    char text[SIM_SENTENCE];
    fprintf(out, "{\"scene\":");
    json_put_text(out, def->scene);
    fprintf(out, ",\"command\":");
    json_put_text(out, def->command);
    advise(def, text);
    fprintf(out, ",\"advice\":");
    json_put_text(out, text);
    fprintf(out,
            ",\"budget_ms\":%g,\"budget_kept\":%s,\"moments\":%d,\"bodies\":%u,\"reference_hz\":%d,\"floor_m\":%.7g,",
            def->budget_ms, sim_choose(r, def->budget_ms) >= 0 ? "true" : "false", r->moments, r->bodies,
            SIM_REFERENCE_HZ, r->floor);
    fprintf(out, "\"points\":[");
    for (int k = 0; k < SIM_SETTINGS; k++) {
        const sim_setting *s = &r->settings[k];
        fprintf(out, "%s\n{\"setting\":\"%s\",\"ms\":%.5f,\"ms_spread\":%.5f,\"position_m\":%.7g,\"energy_j\":%.7g,",
                k ? "," : "", s->text, s->ms, s->spread, s->position, s->energy);
        fprintf(out, "\"penetration_m\":%.7g,\"joint_m\":%.7g,\"on_front\":%s}", s->penetration, s->joint_gap,
                s->beaten_by < 0 ? "true" : "false");
    }
    fprintf(out, "\n]}\n");
}

typedef struct figure {
    const char *name, *doc, *unit;
    size_t offset; /* of the error in a setting */
} figure;

static double error_of(const sim_setting *s, const figure *f)
{
    return *(const double *)(const void *)((const char *)s + f->offset);
}

static bool has_error(const sim_result *r, const figure *f)
{
    for (int k = 0; k < SIM_SETTINGS; k++)
        if (error_of(&r->settings[k], f) > 0) return true;
    return false;
}

static void put_figure(const sim_report_def *def, const figure *f, FILE *out)
{
    const sim_result *r = def->sim;
    plot p = {.out = out, .x_name = "milliseconds a tick", .y_name = f->unit, .x0 = 1};
    const bool has_floor = f->offset == offsetof(sim_setting, position);
    for (int k = 0; k < SIM_SETTINGS; k++) plot_fit(&p, r->settings[k].ms, error_of(&r->settings[k], f));
    if (has_floor) plot_fit(&p, r->settings[0].ms, r->floor);
    plot_widen(&p);
    plot_begin(&p, f->name, f->doc);
    if (has_floor) plot_floor(&p, r->floor, "floor of the reference");
    const sim_setting *last = NULL;
    for (int k = 0; k < SIM_SETTINGS; k++) {
        const sim_setting *s = &r->settings[k];
        char title[128], label[32];
        const bool apart = !last || !plot_too_near(&p, s->ms, error_of(s, f), last->ms, error_of(last, f));
        if (apart) last = s;
        snprintf(title, sizeof title, "%s: %.3f ms, %.3g", s->text, s->ms, error_of(s, f));
        snprintf(label, sizeof label, "%d × %d Hz", s->substeps, s->rate);
        plot_dot(&p, s->ms, s->spread, error_of(s, f), s->beaten_by < 0 ? "#e70" : "#999", title, apart ? label : NULL);
    }
    plot_end(&p, def->command);
}

static void put_table(const sim_report_def *def, FILE *out)
{
    fprintf(out,
            "<h2>All settings</h2><table><tr><th>ms a tick</th><th>&plusmn;</th><th>position, m</th><th>energy, J</th>"
            "<th>overlap, m</th><th>joints, m</th><th>setting</th></tr>\n");
    for (int k = 0; k < SIM_SETTINGS; k++) {
        const sim_setting *s = &def->sim->settings[k];
        fprintf(
            out,
            "<tr class=\"%s\"><td>%.3f</td><td>%.3f</td><td>%.3g</td><td>%.3g</td><td>%.3g</td><td>%.3g</td><td>%s%s%s"
            "</td></tr>\n",
            s->beaten_by < 0 ? "front" : "beaten", s->ms, s->spread, s->position, s->energy, s->penetration,
            s->joint_gap, s->text, s->beaten_by < 0 ? "" : " &mdash; beaten by ",
            s->beaten_by < 0 ? "" : def->sim->settings[s->beaten_by].text);
    }
    fprintf(out, "</table>\n");
}

static void put_page(const sim_report_def *def, FILE *out)
{
    static const figure FIGURES[] = {
        {"Position", "How far bodies are from where the reference has them.", "metres",
         offsetof(sim_setting, position)},
        {"Energy", "How far the total is from the reference's.", "joules", offsetof(sim_setting, energy)},
        {"Overlap", "The deepest that two bodies were in each other.", "metres", offsetof(sim_setting, penetration)},
        {"Joints", "The widest gap in a joint.", "metres", offsetof(sim_setting, joint_gap)}};
    char text[SIM_SENTENCE];
    snprintf(text, sizeof text, "What accuracy costs: the simulation of %s", def->scene);
    page_begin(out, text);
    advise(def, text);
    fprintf(out, "<p class=\"advice\">");
    page_text(out, text);
    tell_floor(def, text);
    fprintf(out, "</p><p>");
    page_text(out, text);
    fprintf(out,
            " From each of %d moments of the game every setting simulates the same second; nobody plays meanwhile. "
            "%u bodies.</p>\n<div class=\"plots\">\n",
            def->sim->moments, def->sim->bodies);
    for (size_t i = 0; i < COUNT_OF(FIGURES); i++)
        if (has_error(def->sim, &FIGURES[i])) put_figure(def, &FIGURES[i], out);
    fprintf(out, "</div>\n");
    put_table(def, out);
    page_end(out);
}

static bool write_with(const sim_report_def *def, const char *name, void (*put)(const sim_report_def *, FILE *),
                       daft_error *error)
{
    char path[PATH_SIZE];
    draft_file draft;
    if (!path_join(path, sizeof path, def->folder, name))
        return fail(error, DAFT_ERROR_ARGUMENT, "%s: the path is too long", def->folder);
    if (!draft_open(&draft, error)) return false;
    put(def, draft.file);
    return draft_commit(&draft, path, error);
}

bool sim_write(const sim_report_def *def, daft_error *error)
{
    return write_with(def, "points.csv", put_csv, error) && write_with(def, "report.json", put_json, error) &&
           write_with(def, "index.html", put_page, error);
}
