/* The output: the table with its budgets, the rows below their floor, the JSON. */
#include "bench.h"

#include <stdio.h>
#include <string.h>

bool bench_smaller_is_better(const bench_row *row)
{
    return strcmp(row->unit, "ms") == 0 || strcmp(row->unit, "ns") == 0 || strcmp(row->unit, "mm") == 0 ||
           strcmp(row->unit, "FLIP") == 0 || strncmp(row->unit, "B/", 2) == 0;
}

double bench_ratio(const bench_row *row)
{
    if (row->peer < 0) return -1;
    return bench_smaller_is_better(row) ? row->peer / row->ours : row->ours / row->peer;
}

/* ---- budgets ---- */

/* The result as a fraction of `goal`; negative: nothing to judge. */
static double fraction_of(const bench_row *row, double goal)
{
    if (!(goal > 0)) return -1;
    if (!row->budget.of_value) return row->peer < 0 ? -1 : bench_ratio(row) / goal;
    return bench_smaller_is_better(row) ? goal / row->ours : row->ours / goal;
}

static bool under_floor(const bench_row *row)
{
    double fraction = fraction_of(row, row->budget.floor);
    return fraction >= 0 && fraction < 1;
}

static void goal_cell(double goal, char *out, size_t size)
{
    if (goal > 0)
        snprintf(out, size, "%.3g", goal);
    else
        snprintf(out, size, "-");
}

/* The fraction of the aim that is reached, in percent; "!" marks a row below its floor. */
static void reached_cell(const bench_row *row, char *out, size_t size)
{
    double fraction = fraction_of(row, row->budget.aim);
    if (fraction >= 0)
        snprintf(out, size, "%.0f%%%s", fraction * 100, under_floor(row) ? "!" : "");
    else
        snprintf(out, size, under_floor(row) ? "!" : "-");
}

static void print_summary(const bench *self)
{
    size_t judged = 0, under = 0, aims = 0;
    for (size_t i = 0; i < self->count; i++) {
        const bench_row *row = &self->rows[i];
        judged += fraction_of(row, row->budget.floor) >= 0;
        under += under_floor(row);
        aims += fraction_of(row, row->budget.aim) >= 1;
    }
    if (judged == 0) return;
    printf("\n%zu rows have a budget: %zu reach their aim, %zu are under their floor%s\n", judged, aims, under,
           under ? ":" : "");
    for (size_t i = 0; i < self->count; i++) {
        const bench_row *row = &self->rows[i];
        if (!under_floor(row)) continue;
        printf("  %s %s, %d thread%s: %.3g%s%s, floor %.3g\n", row->scene, row->what, row->threads,
               row->threads == 1 ? "" : "s", row->budget.of_value ? row->ours : bench_ratio(row),
               row->budget.of_value ? " " : "x", row->budget.of_value ? row->unit : "", row->budget.floor);
    }
}

/* ---- the table ---- */

static const char *peer_cell(const bench_row *row, char *out, size_t size)
{
    if (row->peer >= 0)
        snprintf(out, size, "%.4g", row->peer);
    else
        snprintf(out, size, "%s", row->peer_name ? "not installed" : "-");
    return out;
}

typedef struct columns {
    int scene, what, name;
    bool peers, budgets;
} columns;

static columns measure_columns(const bench *self)
{
    columns c = {5, 4, 11, false, false};
    for (size_t i = 0; i < self->count; i++) {
        const bench_row *row = &self->rows[i];
        c.scene = daft_max_i(c.scene, (int)strlen(row->scene));
        c.what = daft_max_i(c.what, (int)strlen(row->what));
        if (row->peer_name) c.name = daft_max_i(c.name, (int)strlen(row->peer_name));
        c.peers |= row->peer_name != NULL;
        c.budgets |= row->budget.floor > 0;
    }
    return c;
}

static void print_row(const bench_row *row, const columns *c)
{
    char peer[32], ratio[32] = "-", floor[32], aim[32], reached[32];
    if (bench_ratio(row) >= 0) snprintf(ratio, sizeof ratio, "%.2f", bench_ratio(row));
    printf("%-*s  %-*s  %7d  %-6s  %9.4g  %-7s", c->scene, row->scene, c->what, row->what, row->threads, row->isa,
           row->ours, row->unit);
    if (c->peers)
        printf("  %13s  %6s  %-*s", peer_cell(row, peer, sizeof peer), ratio, c->name,
               row->peer_name ? row->peer_name : "-");
    if (c->budgets) {
        goal_cell(row->budget.floor, floor, sizeof floor);
        goal_cell(row->budget.aim, aim, sizeof aim);
        reached_cell(row, reached, sizeof reached);
        printf("  %5s  %5s  %6s", floor, aim, reached);
    }
    printf("  %s\n", row->counters);
}

void bench_tell(const bench_row *row)
{
    fprintf(stderr, "  %s %s: %.4g %s", row->scene, row->what, row->ours, row->unit);
    if (row->peer >= 0 && row->peer_name)
        fprintf(stderr, ", %s %.4g (%.2fx)", row->peer_name, row->peer, bench_ratio(row));
    fprintf(stderr, "%s%s%s\n", row->counters[0] ? "; " : "", row->counters,
            under_floor(row) ? " (under its floor)" : "");
}

void bench_print(const bench *self)
{
    columns c = measure_columns(self);
    printf("%-*s  %-*s  %7s  %-6s  %9s  %-7s", c.scene, "scene", c.what, "what", "threads", "isa", "ours", "unit");
    if (c.peers) printf("  %13s  %6s  %-*s", "peer", "ratio", c.name, "peer's name");
    if (c.budgets) printf("  %5s  %5s  %6s", "floor", "aim", "of aim");
    printf("  counters\n");
    for (size_t i = 0; i < self->count; i++) print_row(&self->rows[i], &c);
    print_summary(self);
}

/* ---- JSON ---- */

static void write_number(FILE *file, const char *name, double value)
{
    if (value < 0)
        fprintf(file, ", \"%s\": null", name);
    else
        fprintf(file, ", \"%s\": %.6g", name, value);
}

/* Names are ours and plain: nothing in them needs escaping. */
static void write_row(FILE *file, const bench *self, const bench_row *row)
{
    bool budget = row->budget.floor > 0;
    fprintf(file, "\n  {\"scene\": \"%s\", \"what\": \"%s\", \"threads\": %d, \"isa\": \"%s\"", row->scene, row->what,
            row->threads, row->isa);
    write_number(file, "ours", row->ours);
    write_number(file, "peer", row->peer);
    if (row->peer_name)
        fprintf(file, ", \"peer_name\": \"%s\"", row->peer_name);
    else
        fprintf(file, ", \"peer_name\": null");
    fprintf(file, ", \"unit\": \"%s\"", row->unit);
    write_number(file, "ratio", bench_ratio(row));
    write_number(file, "floor", budget ? row->budget.floor : -1);
    write_number(file, "aim", budget ? row->budget.aim : -1);
    fprintf(file, ", \"budget_of\": %s", !budget ? "null" : row->budget.of_value ? "\"ours\"" : "\"ratio\"");
    fprintf(file, ", \"counters\": \"%s\", \"date\": \"%s\", \"machine\": \"%s\", \"command\": \"%s\"}", row->counters,
            self->date, self->machine, self->command);
}

bool bench_write_json(const bench *self)
{
    FILE *file = fopen(self->json, "w");
    if (!file) return false;
    fprintf(file, "[");
    for (size_t i = 0; i < self->count; i++) {
        if (i) fprintf(file, ",");
        write_row(file, self, &self->rows[i]);
    }
    fprintf(file, "\n]\n");
    bool written = !ferror(file);
    return (fclose(file) == 0) && written;
}
