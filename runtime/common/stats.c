/* What a frame cost, as JSON and as a table. */
#include "common/stats.h"

#include "common/json.h"
#include "common/util.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- times ---- */

void frame_times_add(frame_times *times, double ms, const daft_counters *counters)
{
    if (times->count == times->capacity) {
        size_t capacity = times->capacity ? times->capacity * 2 : 256;
        double *more = realloc(times->ms, capacity * sizeof *more);
        if (!more) return;
        times->ms = more;
        times->capacity = capacity;
    }
    times->ms[times->count++] = ms;
    for (size_t i = 0; i < DAFT_EFFECT_COUNT; i++) times->effects[i] += counters->effects[i].ms;
}

void frame_times_free(frame_times *times)
{
    free(times->ms);
    *times = (frame_times){0};
}

static int by_time(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* Of the times: 0.5 is the median. 0 without frames. */
static double quantile(const frame_times *times, double fraction)
{
    double *sorted = times->count ? malloc(times->count * sizeof *sorted) : NULL;
    if (!sorted) return 0;
    memcpy(sorted, times->ms, times->count * sizeof *sorted);
    qsort(sorted, times->count, sizeof *sorted, by_time);
    double rank = ceil(fraction * (double)times->count);
    double value = sorted[rank < 1 ? 0 : (size_t)rank - 1];
    free(sorted);
    return value;
}

/* ---- JSON ---- */

/* JSON has no NaN and no infinity. */
static void put_number(FILE *out, double value) { fprintf(out, "%.4f", isfinite(value) ? value : 0.0); }

static void put_effect(FILE *out, const daft_effect *effect, double mean_ms, bool last)
{
    fputs("    ", out);
    json_put_text(out, effect->name);
    fprintf(out, ": {\"ran\": %s, \"why\": ", effect->ran ? "true" : "false");
    json_put_text(out, effect->why);
    fprintf(out, ", \"tiles\": %" PRIu32 ", \"rays\": %" PRIu64 ", \"bytes\": %" PRIu64 ", \"ms\": ", effect->tiles,
            effect->rays, effect->bytes);
    put_number(out, effect->ms);
    fputs(", \"mean_ms\": ", out);
    put_number(out, mean_ms);
    fprintf(out, "}%s\n", last ? "" : ",");
}

/* Rays of the effects have a list of their own. */
static bool is_listed_apart(const char *name) { return strstr(name, "_rays") && strcmp(name, "alpha_rays") != 0; }

/* Every field of one type that is not listed apart. */
static void put_counts(FILE *out, daft_struct which, daft_field_type type, const void *counters)
{
    uint32_t count;
    const daft_field *fields = daft_fields(which, &count);
    const char *between = "";
    for (uint32_t i = 0; i < count; i++) {
        if (fields[i].type != type || is_listed_apart(fields[i].name)) continue;
        const char *from = (const char *)counters + fields[i].offset;
        uint64_t value = 0;
        uint32_t narrow = 0;
        if (type == DAFT_FIELD_UINT64)
            memcpy(&value, from, sizeof value);
        else
            memcpy(&narrow, from, sizeof narrow);
        fprintf(out, "%s\"%s\": %" PRIu64, between, fields[i].name, value + narrow);
        between = ", ";
    }
}

static void print_json(FILE *out, const daft_counters *c, const frame_times *times)
{
    fprintf(out, "{\n  \"width\": %d,\n  \"height\": %d,\n  \"threads\": %d,\n  \"isa\": ", c->width, c->height,
            c->threads);
    json_put_text(out, c->isa);
    fputs(",\n  \"frame_ms\": {\"median\": ", out);
    put_number(out, quantile(times, 0.5));
    fputs(", \"p95\": ", out);
    put_number(out, quantile(times, 0.95));
    fprintf(out, ", \"frames\": %zu},\n", times->count);
    fprintf(out, "  \"memory\": {\"used\": %" PRIu64 ", \"peak\": %" PRIu64 ", \"limit\": %" PRIu64 "},\n",
            times->memory.used, times->memory.peak, times->memory.limit);
    fprintf(out,
            "  \"rays\": {\"camera\": %" PRIu64 ", \"shadow\": %" PRIu64 ", \"reflection\": %" PRIu64
            ", \"refraction\": %" PRIu64 ", \"query\": %" PRIu64 "},\n  \"tiles_drawn\": %" PRIu64
            ",\n  \"effects\": {\n",
            c->camera_rays, c->shadow_rays, c->reflection_rays, c->refraction_rays, c->query_rays, c->tiles_drawn);
    size_t named = 0;
    double frames = times->count ? (double)times->count : 1;
    for (size_t i = 0; i < DAFT_EFFECT_COUNT; i++) named += c->effects[i].name != NULL;
    for (size_t i = 0; i < DAFT_EFFECT_COUNT; i++)
        if (c->effects[i].name) put_effect(out, &c->effects[i], times->effects[i] / frames, --named == 0);
    fputs("  },\n  \"counters\": {", out);
    put_counts(out, DAFT_STRUCT_COUNTERS, DAFT_FIELD_UINT64, c);
    fputs("},\n  \"simulation\": {", out);
    put_counts(out, DAFT_STRUCT_SIM_COUNTERS, DAFT_FIELD_UINT, &times->simulation);
    fputs("}\n}\n", out);
}

bool stats_write(const char *path, const daft_counters *counters, const frame_times *times, daft_error *error)
{
    if (strcmp(path, "-") == 0) {
        print_json(stdout, counters, times);
        return true;
    }
    draft_file out;
    if (!draft_open(&out, error)) return false;
    print_json(out.file, counters, times);
    return draft_commit(&out, path, error);
}

/* ---- the plan ---- */

void stats_print_plan(FILE *out, const daft_counters *c)
{
    fprintf(out, "%dx%d, %d thread%s, %s, %.2f ms\n", c->width, c->height, c->threads, c->threads == 1 ? "" : "s",
            c->isa, c->frame_ms);
    fprintf(out, "%-12s %-4s %7s %10s %10s %9s  %s\n", "effect", "ran", "tiles", "rays", "bytes", "ms", "why");
    for (size_t i = 0; i < DAFT_EFFECT_COUNT; i++) {
        const daft_effect *effect = &c->effects[i];
        if (!effect->name) continue;
        fprintf(out, "%-12s %-4s %7" PRIu32 " %10" PRIu64 " %10" PRIu64 " %9.3f  %s\n", effect->name,
                effect->ran ? "yes" : "no", effect->tiles, effect->rays, effect->bytes, effect->ms,
                effect->why ? effect->why : "");
    }
}
