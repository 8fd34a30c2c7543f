/* Shows and writes what the profile has found. */
#include "session/hot.h"

#include "common/util.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void hot_switch(session *s)
{
    daft_error error;
    if (s->overlay || s->def->profile) {
        if (!profile_start(&s->profile, &error)) report(&error);
    } else {
        profile_stop(&s->profile);
    }
}

/* ---- the panel ---- */

enum { SHOWN = 5 };

void hot_draw(session *s)
{
    static const float WIDTH = 504, ROW = 21;
    static const canvas_color WHITE = {245, 247, 250, 255}, GREY = {170, 180, 195, 255};
    profile_line top[SHOWN];
    const uint64_t now = clock_now_ns();
    if (now - s->faded_ns > 1000000000u) profile_fade(&s->profile), s->faded_ns = now;
    const size_t count = profile_top(&s->profile, true, top, SHOWN);
    if (count == 0) return;
    canvas over = canvas_over(s->picture);
    panels_place(&s->placed, &over, WIDTH + 12, ROW * (SHOWN + 1) + 28);
    over.origin_y += 12 * over.unit;
    canvas_rect(&over, 0, 0, WIDTH, ROW * (float)(count + 1) + 16, (canvas_color){10, 14, 24, 190});
    text_style style = {17, GREY, TEXT_LEFT, false};
    text_draw(&over, s->def->face, "where Lua spends its time", 12, 8, &style);
    for (size_t i = 0; i < count; i++) {
        char text[160];
        const float y = 8 + ROW * (float)(i + 1);
        style.color = WHITE;
        snprintf(text, sizeof text, "%.63s:%d%s%.31s", top[i].file, top[i].line, top[i].function[0] ? "  in " : "",
                 top[i].function);
        text_draw(&over, s->def->face, text, 84, y, &style);
        style.align = TEXT_RIGHT;
        snprintf(text, sizeof text, "%.0f %%", 100 * (double)top[i].recent_ns / (double)s->profile.recent_ns);
        text_draw(&over, s->def->face, text, 66, y, &style);
        style.align = TEXT_LEFT;
    }
}

/* ---- the table ---- */

enum { WRITTEN = 100, LINE_TEXT = 80 };

/* The line of the script without the blanks around it; empty where it cannot be read. */
static const char *source_of(const session *s, const profile_line *line, char out[LINE_TEXT])
{
    const size_t own = strlen(s->info->name);
    const char *name = strncmp(line->file, s->info->name, own) == 0 && line->file[own] == '/' ? line->file + own + 1
                       : strncmp(line->file, "scripts/", 8) == 0                              ? line->file + 8
                                                                                              : line->file;
    char path[PATH_SIZE];
    size_t size;
    out[0] = 0;
    if (!daft_files_find(s->source->files, name, path, sizeof path)) return out;
    char *text = daft_read_file(s->source->files, path, &size, NULL);
    const char *at = text;
    for (int i = 1; at && i < line->line; i++) at = strchr(at, '\n') ? strchr(at, '\n') + 1 : NULL;
    if (at) at += strspn(at, " \t");
    if (at) snprintf(out, LINE_TEXT, "%.*s", (int)strcspn(at, "\r\n"), at);
    free(text);
    return out;
}

static size_t put_head(const session *s, char *out, size_t size)
{
    const profile *p = &s->profile;
    return (size_t)snprintf(out, size,
                            "Lua ran for %.1f ms; %" PRIu64
                            " samples, about one in a millisecond. A call of the engine "
                            "counts for the line that makes it.\n   share         ms  line\n",
                            (double)p->call_ns / 1e6, p->samples);
}

static size_t put_line(const session *s, const profile_line *line, char *out, size_t size)
{
    char place[PROFILE_FILE + 16], source[LINE_TEXT];
    snprintf(place, sizeof place, "%.63s:%d", line->file, line->line);
    const int used =
        snprintf(out, size, "%6.1f %%  %9.1f  %-28s  %-16.31s  %s\n", 100 * (double)line->ns / (double)s->profile.ns,
                 (double)line->ns / 1e6, place, line->function, source_of(s, line, source));
    return (size_t)used < size ? (size_t)used : size - 1;
}

bool hot_write(session *s, daft_error *error)
{
    profile_line top[WRITTEN];
    if (!s->def->profile) return true;
    profile_stop(&s->profile);
    const size_t count = profile_top(&s->profile, false, top, WRITTEN), size = 256 * (count + 2);
    char *text = malloc(size);
    if (!text) return fail(error, DAFT_ERROR_MEMORY, "out of memory for the profile");
    size_t used = put_head(s, text, size);
    for (size_t i = 0; i < count; i++) used += put_line(s, &top[i], text + used, size - used);
    const bool file = strcmp(s->def->profile, "-") != 0;
    const bool good = !file || daft_write_file(s->def->profile, text, used, error);
    if (!file) fputs(text, stdout), fflush(stdout);
    free(text);
    return good;
}
