/* The table on the terminal, points.csv and report.json. */
#include "accuracy/report.h"

#include "common/json.h"
#include "common/stats.h"
#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void report_sort(const sweep_result *sweep, size_t *order)
{
    for (size_t i = 0; i < sweep->count; i++) {
        size_t k = i;
        for (; k > 0 && sweep->points[order[k - 1]].ms > sweep->points[i].ms; k--) order[k] = order[k - 1];
        order[k] = i;
    }
}

/* The smallest error above zero of all settings. */
static double smallest_error(const sweep_result *s)
{
    double least = INFINITY;
    for (size_t i = 0; i < s->count; i++)
        if (s->points[i].errors.flip > 0) least = fmin(least, s->points[i].errors.flip);
    return least;
}

void report_command(const sweep_result *sweep, const sweep_point *point, char *out, size_t size)
{
    const bool whole = strcmp(point->knob, "quality") == 0;
    const char *fixed = sweep->def.fixed ? sweep->def.fixed : "", *setting = whole ? "" : point->setting;
    snprintf(out, size, "--quality %s%s%s%s%s --size %dx%d",
             whole ? point->setting : daft_preset_name(sweep->def.preset), *fixed || *setting ? " --knobs " : "", fixed,
             *fixed && *setting ? "," : "", setting, sweep->def.width, sweep->def.height);
}

void report_floor(const report_def *def, char out[SENTENCE])
{
    const sweep_result *s = def->sweep;
    double least = smallest_error(s);
    bool fine = s->floor.flip * 10 <= least;
    int used = snprintf(
        out, SENTENCE, "The reference is the mean of two halves of %d and %d samples a pixel. They differ by FLIP %.4f",
        s->reference_samples[0], s->reference_samples[1], s->floor.flip);
    if (!isfinite(least))
        snprintf(out + used, SENTENCE - (size_t)used, ".");
    else
        snprintf(out + used, SENTENCE - (size_t)used, ", %s a tenth of the smallest error here (%.4f)%s",
                 fine ? "less than" : "more than", least,
                 fine ? "." : ": the plots show the floor, below which an error says little.");
    used = (int)strlen(out);
    snprintf(out + used, SENTENCE - (size_t)used,
             " A setting is called closer than another where both halves say so, else the two are called equal.");
}

void report_advise(const report_def *def, char out[SENTENCE])
{
    const sweep_result *s = def->sweep;
    int best = sweep_choose(s, def->budget_ms);
    char command[SENTENCE / 2 + SETTING_TEXT];
    const sweep_point *p = best >= 0 ? &s->points[best] : &s->points[0];
    for (size_t i = 0; best < 0 && i < s->count; i++)
        if (s->points[i].ms < p->ms) p = &s->points[i];
    report_command(s, p, command, sizeof command);
    const bool again = p->again_ms > 0;
    int used = 0;
    if (sweep_all_same(s)) used = snprintf(out, SENTENCE, "All settings draw the same picture. ");
    if (best >= 0)
        used += snprintf(out + used, SENTENCE - (size_t)used, "For %g ms: ", def->budget_ms);
    else
        used +=
            snprintf(out + used, SENTENCE - (size_t)used, "No setting keeps %g ms here. The fastest: ", def->budget_ms);
    snprintf(out + used, SENTENCE - (size_t)used, "%s (%.2f ms ± %.2f%s, FLIP %.4f).", command,
             again ? p->again_ms : p->ms, again ? p->again_spread : p->spread, again ? ", timed again at the end" : "",
             p->errors.flip);
}

static void print_point(const report_def *def, const sweep_point *p, FILE *out)
{
    const picture_errors *e = &p->errors;
    fprintf(out, "%9.2f %8.2f %8.4f %8.5f %7.2f %8.5f %8.4f ", p->ms, p->spread, e->flip, e->rmse, e->psnr, e->ssim,
            e->worst);
    if (def->sweep->def.moments) fprintf(out, "%8.4f ", p->temporal);
    fprintf(out, " %s %s\n", p->knob, p->setting);
}

static void print_front(const report_def *def, FILE *out)
{
    const sweep_result *s = def->sweep;
    size_t order[SWEEP_POINTS];
    report_sort(s, order);
    fprintf(out, "%s at %dx%d", def->scene, s->def.width, s->def.height);
    if (s->def.moments) fprintf(out, ", %d moments of the game", s->moments);
    fprintf(out, ": settings that no other beats, of %zu", s->count);
    if (s->dropped) fprintf(out, " (there was no time for %zu more)", s->dropped);
    fprintf(out, "\n\n%9s %8s %8s %8s %7s %8s %8s ", "ms", "±", "FLIP", "RMSE", "PSNR", "SSIM", "tile");
    fprintf(out, s->def.moments ? "%8s  setting\n" : "%s setting\n", s->def.moments ? "temporal" : "");
    for (size_t i = 0; i < s->count; i++)
        if (s->points[order[i]].on_front) print_point(def, &s->points[order[i]], out);
}

void report_wrong(const sweep_result *s, int which, char out[SENTENCE])
{
    const sweep_wrong *w = &s->wrong[which];
    snprintf(out, SENTENCE, "%s: %zu of %d pixels see another triangle than with visibility=exact.", w->setting,
             w->count, s->def.width * s->def.height);
}

void report_print(const report_def *def, FILE *out)
{
    char text[SENTENCE];
    print_front(def, out);
    fprintf(out, "\nWhat a picture of quality %s is made of:\n\n", daft_preset_name(def->sweep->def.preset));
    stats_print_plan(out, &def->sweep->counters);
    for (int i = 0; i < SWEEP_WRONG; i++) {
        report_wrong(def->sweep, i, text);
        fprintf(out, i ? "%s\n" : "\n%s\n", text);
    }
    report_advise(def, text);
    fprintf(out, "\n%s\n", text);
    report_floor(def, text);
    fprintf(out, "%s\nFLIP at %.0f pixels a degree. Files: %s/index.html, points.csv, report.json\n", text, METRICS_PPD,
            def->folder);
}

/* ---- points.csv -------------------------------------------------------------------------------------------------- */

/* RFC 4180: quotes where a text holds a comma, a quote or a line's end. */
static void put_csv(FILE *out, const char *text)
{
    if (!strpbrk(text, ",\"\n\r")) {
        fputs(text, out);
        return;
    }
    fputc('"', out);
    for (; *text; text++) fprintf(out, "%s%c", *text == '"' ? "\"" : "", *text);
    fputc('"', out);
}

static bool make_path(const report_def *def, const char *name, char path[PATH_SIZE], daft_error *error)
{
    return path_join(path, PATH_SIZE, def->folder, name) ||
           fail(error, DAFT_ERROR_ARGUMENT, "%s: the path is too long", def->folder);
}

static bool write_csv(const report_def *def, daft_error *error)
{
    const sweep_result *s = def->sweep;
    char path[PATH_SIZE];
    draft_file draft;
    if (!make_path(def, "points.csv", path, error) || !draft_open(&draft, error)) return false;
    fprintf(draft.file, "scene,knob,setting,ms,ms_spread,rmse,psnr,ssim,flip,on_front\n");
    for (size_t i = 0; i < s->count; i++) {
        const sweep_point *p = &s->points[i];
        const picture_errors *e = &p->errors;
        put_csv(draft.file, def->scene);
        fprintf(draft.file, ",%s,", p->knob);
        put_csv(draft.file, p->setting);
        fprintf(draft.file, ",%.4f,%.4f,%.7f,%.4f,%.6f,%.6f,%d\n", p->ms, p->spread, e->rmse, e->psnr, e->ssim, e->flip,
                p->on_front);
    }
    return draft_commit(&draft, path, error);
}

/* ---- report.json ------------------------------------------------------------------------------------------------- */

/* JSON has no infinity and no NaN. */
static void put_number(FILE *out, const char *name, double value)
{
    if (isfinite(value))
        fprintf(out, "\"%s\":%.7g", name, value);
    else
        fprintf(out, "\"%s\":null", name);
}

static void put_errors(FILE *out, const picture_errors *e)
{
    const struct {
        const char *name;
        double value;
    } all[] = {{"rmse", e->rmse}, {"psnr", e->psnr}, {"ssim", e->ssim}, {"flip", e->flip}, {"worst_tile", e->worst}};
    for (size_t i = 0; i < COUNT_OF(all); i++) {
        fputc(',', out);
        put_number(out, all[i].name, all[i].value);
    }
}

static void put_other(FILE *out, const char *name, const sweep_result *s, int other)
{
    if (other >= 0) fprintf(out, ",\"%s\":\"%s %s\"", name, s->points[other].knob, s->points[other].setting);
}

static void put_point(FILE *out, const sweep_result *s, const sweep_point *p)
{
    fprintf(out, "{\"knob\":\"%s\",\"setting\":", p->knob);
    json_put_text(out, p->setting);
    fprintf(out, ",\"ms\":%.4f,\"ms_spread\":%.4f,\"rounds\":%d", p->ms, p->spread, p->at[0].rounds);
    if (p->again_ms > 0) fprintf(out, ",\"ms_again\":%.4f,\"ms_again_spread\":%.4f", p->again_ms, p->again_spread);
    put_errors(out, &p->errors);
    if (s->def.moments) {
        fputc(',', out);
        put_number(out, "temporal_flip", p->temporal);
    }
    fprintf(out, ",\"on_front\":%s", p->on_front ? "true" : "false");
    put_other(out, "same_as", s, p->same_as);
    put_other(out, "beaten_by", s, p->beaten_by);
    fputc('}', out);
}

static void put_effects(FILE *out, const daft_counters *c)
{
    for (int i = 0; i < DAFT_EFFECT_COUNT; i++) {
        const daft_effect *e = &c->effects[i];
        fprintf(out,
                "%s\n{\"effect\":\"%s\",\"ran\":%s,\"why\":\"%s\",\"tiles\":%u,\"rays\":%llu,\"bytes\":%llu,"
                "\"ms\":%.4f}",
                i ? "," : "", e->name, e->ran ? "true" : "false", e->why ? e->why : "", e->tiles,
                (unsigned long long)e->rays, (unsigned long long)e->bytes, e->ms);
    }
}

static bool write_json(const report_def *def, daft_error *error)
{
    const sweep_result *s = def->sweep;
    char path[PATH_SIZE], text[SENTENCE];
    draft_file draft;
    if (!make_path(def, "report.json", path, error) || !draft_open(&draft, error)) return false;
    FILE *out = draft.file;
    fprintf(out, "{\"scene\":");
    json_put_text(out, def->scene);
    fprintf(out, ",\"command\":");
    json_put_text(out, def->command);
    fprintf(out, ",\"width\":%d,\"height\":%d,\"threads\":%d,\"preset\":\"%s\",\"pixels_per_degree\":%.4f,",
            s->def.width, s->def.height, def->threads, s->points[s->preset].setting, METRICS_PPD);
    fprintf(out, "\"dropped\":%zu,\"floor\":{\"samples\":[%d,%d]", s->dropped, s->reference_samples[0],
            s->reference_samples[1]);
    put_errors(out, &s->floor);
    int best = sweep_choose(s, def->budget_ms);
    report_advise(def, text);
    fprintf(out, "},\"budget_ms\":%g,\"budget_kept\":%s,\"advice\":", def->budget_ms, best >= 0 ? "true" : "false");
    json_put_text(out, text);
    fprintf(out, ",\"moments\":%d,\"wrong_pixels\":{", s->moments);
    for (int i = 0; i < SWEEP_WRONG; i++)
        fprintf(out, "%s\"%s\":%zu", i ? "," : "", s->wrong[i].setting, s->wrong[i].count);
    fprintf(out, "},\"effects\":[");
    put_effects(out, &s->counters);
    fprintf(out, "\n],\"points\":[");
    for (size_t i = 0; i < s->count; i++) {
        fputs(i ? ",\n" : "\n", out);
        put_point(out, s, &s->points[i]);
    }
    fprintf(out, "\n]}\n");
    return draft_commit(&draft, path, error);
}

bool report_write(const report_def *def, daft_error *error)
{
    return write_csv(def, error) && write_json(def, error) && report_write_page(def, error);
}
