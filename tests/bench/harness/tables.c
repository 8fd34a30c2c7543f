/* The manual's tables, so that no figure is typed by hand. A page marks where a table belongs and which rows it holds:
 *
 *     <!-- bench: camera rays, exact | camera rays, fast; threads 1; columns; counters -->
 *     <!-- /bench -->
 *
 * Rows are those of the JSON files whose "scene what" contains one of the patterns. `threads N` keeps rows of N
 * threads, `what TEXT` those of this `what`, `columns` gives each `what` a column of its own, `counters` adds what was
 * counted. What stands between the
 * two marks is replaced; a section without rows stays as it is, and is noted on stderr. */
#include "bench.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct table_row {
    char scene[64], what[64], unit[16], isa[16], peer_name[48], counters[320], date[16], machine[128], command[512];
    double ours, peer, ratio, floor; /* NAN: none */
    int threads;
    bool of_value; /* the floor is about our own figure, else about the ratio */
} table_row;

enum { MAX_PATTERNS = 8, MAX_COLUMNS = 24 };

typedef struct section {
    char patterns[MAX_PATTERNS][64];
    char what[64];              /* empty: any */
    int pattern_count, threads; /* 0: any number */
    bool columns, counters;
} section;

typedef struct tables {
    bench *self;
    table_row *rows;
    size_t count, capacity;
} tables;

/* ---- reading JSON: our own, one row a line, names and values without escapes ---- */

static bool text_of(const char *line, const char *name, char *out, size_t size)
{
    char key[32];
    out[0] = 0;
    snprintf(key, sizeof key, "\"%s\": \"", name);
    const char *at = strstr(line, key), *end = at ? strchr(at + strlen(key), '"') : NULL;
    if (!end) return false;
    at += strlen(key);
    size_t length = (size_t)(end - at) < size - 1 ? (size_t)(end - at) : size - 1;
    memcpy(out, at, length);
    out[length] = 0;
    return true;
}

static double number_of(const char *line, const char *name)
{
    char key[32], *end;
    snprintf(key, sizeof key, "\"%s\": ", name);
    const char *at = strstr(line, key);
    if (!at) return NAN;
    double value = strtod(at + strlen(key), &end);
    return end > at + strlen(key) ? value : NAN;
}

static bool read_row(const char *line, table_row *r)
{
    if (!text_of(line, "scene", r->scene, sizeof r->scene) || !text_of(line, "what", r->what, sizeof r->what))
        return false;
    text_of(line, "unit", r->unit, sizeof r->unit), text_of(line, "isa", r->isa, sizeof r->isa);
    text_of(line, "peer_name", r->peer_name, sizeof r->peer_name),
        text_of(line, "counters", r->counters, sizeof r->counters);
    text_of(line, "date", r->date, sizeof r->date), text_of(line, "machine", r->machine, sizeof r->machine);
    text_of(line, "command", r->command, sizeof r->command);
    r->ours = number_of(line, "ours"), r->peer = number_of(line, "peer"), r->ratio = number_of(line, "ratio");
    r->floor = number_of(line, "floor"), r->threads = (int)number_of(line, "threads");
    char budget_of[8];
    r->of_value = text_of(line, "budget_of", budget_of, sizeof budget_of) && strcmp(budget_of, "ours") == 0;
    return true;
}

/* A row of a later file replaces the same row of an earlier one. */
static bool add_row(tables *t, const table_row *row)
{
    for (size_t i = 0; i < t->count; i++) {
        table_row *old = &t->rows[i];
        if (strcmp(old->scene, row->scene) || strcmp(old->what, row->what) || old->threads != row->threads) continue;
        *old = *row;
        return true;
    }
    if (!daft_grow(&t->self->allocator, &t->rows, &t->capacity, t->count + 1, t->count, sizeof *t->rows)) return false;
    t->rows[t->count++] = *row;
    return true;
}

static bool read_rows(tables *t, const char *path)
{
    size_t size;
    char *text = daft_file_read(&t->self->allocator, NULL, path, &size, NULL);
    if (!text) {
        bench_note(t->self, true, "cannot read %s", path);
        return false;
    }
    bool good = true;
    for (char *line = strtok(text, "\n"); line && good; line = strtok(NULL, "\n")) {
        table_row row;
        if (read_row(line, &row)) good = add_row(t, &row);
    }
    daft_release(&t->self->allocator, text);
    return good;
}

/* ---- choosing rows ---- */

static void trim(char *text)
{
    size_t skip = strspn(text, " "), length = strlen(text + skip);
    memmove(text, text + skip, length + 1);
    while (length && text[length - 1] == ' ') text[--length] = 0;
}

/* `spec`: what stands between "bench:" and "-->". */
static section parse_section(const char *spec, size_t length)
{
    section s = {0};
    char copy[512], *save, *part;
    snprintf(copy, sizeof copy, "%.*s", (int)length, spec);
    char *options = strchr(copy, ';');
    if (options) *options++ = 0;
    for (part = strtok_r(copy, "|", &save); part && s.pattern_count < MAX_PATTERNS; part = strtok_r(NULL, "|", &save)) {
        trim(part);
        snprintf(s.patterns[s.pattern_count++], sizeof s.patterns[0], "%.63s", part);
    }
    for (part = options ? strtok_r(options, ";", &save) : NULL; part; part = strtok_r(NULL, ";", &save)) {
        trim(part);
        if (strncmp(part, "threads ", 8) == 0) s.threads = atoi(part + 8);
        if (strncmp(part, "what ", 5) == 0) snprintf(s.what, sizeof s.what, "%.63s", part + 5);
        s.columns |= strcmp(part, "columns") == 0, s.counters |= strcmp(part, "counters") == 0;
    }
    return s;
}

static bool chosen(const section *s, const table_row *r)
{
    char name[160];
    snprintf(name, sizeof name, "%s %s", r->scene, r->what);
    if ((s->threads && s->threads != r->threads) || (s->what[0] && strcmp(s->what, r->what) != 0)) return false;
    for (int i = 0; i < s->pattern_count; i++)
        if (strstr(name, s->patterns[i])) return true;
    return false;
}

/* ---- writing ---- */

static void put_figure(FILE *out, double value)
{
    if (isnan(value))
        fputs("", out);
    else if (value >= 1000)
        fprintf(out, "%.0f", value);
    else
        fprintf(out, "%.3g", value);
}

static void put_ratio(FILE *out, const table_row *r)
{
    if (!isnan(r->ratio)) fprintf(out, "%.*f", r->ratio < 10 ? 2 : r->ratio < 100 ? 1 : 0, r->ratio);
}

/* Below its floor. */
static bool missed(const table_row *r)
{
    if (isnan(r->floor)) return false;
    if (!r->of_value) return r->ratio < r->floor;
    bool smaller = strcmp(r->unit, "ms") == 0 || strcmp(r->unit, "mm") == 0 || strcmp(r->unit, "FLIP") == 0 ||
                   strncmp(r->unit, "B/", 2) == 0;
    return smaller ? r->ours > r->floor : r->ours < r->floor;
}

/* Where, when and how: each run that the table has rows of. */
static void put_origin(FILE *out, const tables *t, const section *s)
{
    for (size_t i = 0; i < t->count; i++) {
        const table_row *r = &t->rows[i];
        bool told = !chosen(s, r);
        for (size_t k = 0; k < i && !told; k++)
            told = chosen(s, &t->rows[k]) && strcmp(r->command, t->rows[k].command) == 0 &&
                   strcmp(r->date, t->rows[k].date) == 0 && r->threads == t->rows[k].threads;
        if (!told)
            fprintf(out, "- %s, %s, %d thread%s, %s: `%s`\n", r->machine, r->isa, r->threads,
                    r->threads == 1 ? "" : "s", r->date, r->command);
    }
    fputc('\n', out);
}

static void put_rows(FILE *out, const tables *t, const section *s)
{
    bool peers = false, floors = false;
    for (size_t i = 0; i < t->count; i++)
        if (chosen(s, &t->rows[i])) peers |= !isnan(t->rows[i].peer), floors |= !isnan(t->rows[i].floor);
    fprintf(out, "| scene | what | threads | DAFT |%s%s%s\n", peers ? " peer | | ratio |" : "",
            floors ? " floor |" : "", s->counters ? " counted |" : "");
    fprintf(out, "|---|---|--:|--:|%s%s%s\n", peers ? "--:|---|--:|" : "", floors ? "--:|" : "",
            s->counters ? "---|" : "");
    for (size_t i = 0; i < t->count; i++) {
        const table_row *r = &t->rows[i];
        if (!chosen(s, r)) continue;
        fprintf(out, "| %s | %s | %d | ", r->scene, r->what, r->threads);
        put_figure(out, r->ours);
        fprintf(out, " %s |", r->unit);
        if (peers) {
            fputc(' ', out), put_figure(out, r->peer);
            fprintf(out, " | %s | ", r->peer_name), put_ratio(out, r);
            fputs(" |", out);
        }
        if (floors) {
            fputc(' ', out), put_figure(out, r->floor);
            fputs(missed(r) ? " ! |" : " |", out);
        }
        fprintf(out, s->counters ? " %s |\n" : "\n", r->counters);
    }
}

/* One line for each scene and number of threads, one column for each `what`. */
static void put_columns(FILE *out, const tables *t, const section *s)
{
    const char *columns[MAX_COLUMNS];
    int count = 0;
    for (size_t i = 0; i < t->count; i++) {
        int k = 0;
        while (k < count && strcmp(columns[k], t->rows[i].what) != 0) k++;
        if (chosen(s, &t->rows[i]) && k == count && count < MAX_COLUMNS) columns[count++] = t->rows[i].what;
    }
    fputs("| scene | threads |", out);
    for (int k = 0; k < count; k++) fprintf(out, " %s |", columns[k]);
    fputs(s->counters ? " counted |\n|---|--:|" : "\n|---|--:|", out);
    for (int k = 0; k < count; k++) fputs("--:|", out);
    fputs(s->counters ? "---|\n" : "\n", out);
    for (size_t i = 0; i < t->count; i++) {
        const table_row *first = &t->rows[i];
        bool done = !chosen(s, first);
        for (size_t k = 0; k < i && !done; k++)
            done = chosen(s, &t->rows[k]) && strcmp(first->scene, t->rows[k].scene) == 0 &&
                   first->threads == t->rows[k].threads;
        if (done) continue;
        const char *counters = "";
        fprintf(out, "| %s | %d |", first->scene, first->threads);
        for (int c = 0; c < count; c++) {
            const table_row *found = NULL;
            for (size_t k = i; k < t->count && !found; k++)
                if (chosen(s, &t->rows[k]) && strcmp(first->scene, t->rows[k].scene) == 0 &&
                    first->threads == t->rows[k].threads && strcmp(t->rows[k].what, columns[c]) == 0)
                    found = &t->rows[k];
            if (found && found->counters[0]) counters = found->counters;
            fputc(' ', out);
            if (found) put_figure(out, found->ours), fprintf(out, " %s%s", found->unit, missed(found) ? " !" : "");
            fputs(" |", out);
        }
        fprintf(out, s->counters ? " %s |\n" : "\n", counters);
    }
}

static bool put_section(FILE *out, const tables *t, const section *s)
{
    size_t rows = 0;
    for (size_t i = 0; i < t->count; i++) rows += chosen(s, &t->rows[i]);
    if (rows == 0) return false;
    fputc('\n', out);
    put_origin(out, t, s);
    if (s->columns)
        put_columns(out, t, s);
    else
        put_rows(out, t, s);
    return true;
}

/* ---- pages ---- */

static const char BEGIN[] = "<!-- bench:", END[] = "<!-- /bench -->";

/* Copies the page with new tables in it. False: a mark is not closed. */
static bool fill(FILE *out, const tables *t, const char *path, const char *text)
{
    for (const char *at; (at = strstr(text, BEGIN)) != NULL;) {
        const char *spec = at + strlen(BEGIN), *close = strstr(spec, "-->"), *end = close ? strstr(close, END) : NULL;
        if (!end) return false;
        section s = parse_section(spec, (size_t)(close - spec));
        close += 3;
        fwrite(text, 1, (size_t)(close - text), out);
        if (!put_section(out, t, &s)) {
            bench_note(t->self, false, "%s: no rows for '%s'; the table stays", path, s.patterns[0]);
            fwrite(close, 1, (size_t)(end - close), out);
        }
        text = end;
    }
    fputs(text, out);
    return true;
}

static void fill_page(const tables *t, const char *name)
{
    char path[1024], made[1040];
    size_t size;
    snprintf(path, sizeof path, "%s/%s", t->self->tables, name);
    snprintf(made, sizeof made, "%s.new", path);
    char *text = daft_file_read(&t->self->allocator, NULL, path, &size, NULL);
    FILE *out = text && strstr(text, BEGIN) ? fopen(made, "w") : NULL;
    if (out) {
        bool good = fill(out, t, path, text) && !ferror(out);
        good = fclose(out) == 0 && good;
        if (!good || rename(made, path) != 0) bench_note(t->self, true, "%s cannot be filled", path), remove(made);
    }
    daft_release(&t->self->allocator, text);
}

bool bench_write_tables(bench *self)
{
    tables t = {.self = self};
    for (size_t i = 0; i < DAFT_COUNT_OF(self->from) && self->from[i]; i++) read_rows(&t, self->from[i]);
    DIR *folder = opendir(self->tables);
    if (!folder) bench_note(self, true, "there is no folder %s", self->tables);
    for (struct dirent *entry; folder && !self->failed && (entry = readdir(folder)) != NULL;) {
        size_t length = strlen(entry->d_name);
        if (length > 3 && strcmp(entry->d_name + length - 3, ".md") == 0) fill_page(&t, entry->d_name);
    }
    if (folder) closedir(folder);
    daft_release(&self->allocator, t.rows);
    return !self->failed;
}
