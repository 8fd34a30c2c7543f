/* What was typed and said, and what keys do. */
#include "tools/console.h"

#include "common/util.h"
#include "lua/api.h"
#include "platform/input.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- lines ---- */

static void drop_lines(console *self)
{
    for (size_t i = 0; i < self->count; i++) free(self->lines[(self->first + i) % CONSOLE_LINES].text);
    self->first = self->count = self->scroll = 0;
}

void console_free(console *self)
{
    drop_lines(self);
    for (size_t i = 0; i < self->history_count; i++) free(self->history[i]);
    self->history_count = 0;
}

/* Out of memory a line is lost. */
static void add_line(console *self, console_kind kind, const char *text, size_t length)
{
    char *copy = strndup(text, length);
    if (!copy) return;
    if (self->count == CONSOLE_LINES) {
        free(self->lines[self->first].text);
        self->first = (self->first + 1) % CONSOLE_LINES, self->count--;
    }
    self->lines[(self->first + self->count++) % CONSOLE_LINES] = (console_line){copy, kind};
    if (self->scroll > 0 && self->scroll < self->count - 1) self->scroll++; /* what is looked at stays */
}

void console_say(console *self, console_kind kind, const char *text)
{
    while (*text) {
        const size_t length = strcspn(text, "\n");
        add_line(self, kind, text, length);
        text += length + (text[length] == '\n');
    }
}

/* Lines that are longer are cut. */
void console_print(console *self, const char *text, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        if (text[i] == '\n') {
            add_line(self, CONSOLE_PRINT, self->printed, self->printed_size);
            self->printed_size = 0;
        } else if (self->printed_size < sizeof self->printed) {
            self->printed[self->printed_size++] = text[i] == '\t' || text[i] == 0 ? ' ' : text[i];
        }
    }
}

/* ---- history ---- */

static void remember(console *self, const char *line)
{
    char *copy =
        self->history_count > 0 && strcmp(self->history[self->history_count - 1], line) == 0 ? NULL : strdup(line);
    if (copy && self->history_count == CONSOLE_HISTORY) {
        free(self->history[0]);
        memmove(self->history, self->history + 1, --self->history_count * sizeof *self->history);
    }
    if (copy) self->history[self->history_count++] = copy;
    self->history_at = self->history_count;
}

static void recall(console *self, int step)
{
    const size_t at = self->history_at, count = self->history_count;
    if ((step < 0 && at == 0) || (step > 0 && at == count)) return;
    if (at == count) memcpy(self->draft, self->edit.text, sizeof self->draft);
    self->history_at = step < 0 ? at - 1 : at + 1;
    edit_set(&self->edit, self->history_at == count ? self->draft : self->history[self->history_at]);
}

/* ---- keys ---- */

void console_show(console *self, bool open)
{
    self->open = open, self->ctrl = false;
    self->held.key = -1, self->scroll = 0;
}

static void scroll_by(console *self, long lines)
{
    const long most = self->count > 0 ? (long)self->count - 1 : 0, wanted = (long)self->scroll + lines;
    self->scroll = (size_t)(wanted < 0 ? 0 : wanted > most ? most : wanted);
}

static console_wish enter(console *self)
{
    memcpy(self->line, self->edit.text, sizeof self->line);
    edit_set(&self->edit, "");
    self->scroll = 0;
    if (self->line[strspn(self->line, " ")] == 0) return CONSOLE_STAY;
    remember(self, self->line);
    return CONSOLE_RUN;
}

static console_wish press(console *self, const char *key)
{
    enum { PAGE = 10 };
    if (self->ctrl && strcmp(key, "v") == 0) return CONSOLE_PASTE;
    if (self->ctrl && strcmp(key, "c") == 0) return CONSOLE_COPY;
    if (self->ctrl && strcmp(key, "l") == 0) drop_lines(self);
    if (strcmp(key, "escape") == 0) return CONSOLE_CLOSE;
    if (strcmp(key, "return") == 0 || strcmp(key, "keypad enter") == 0) return enter(self);
    if (strcmp(key, "tab") == 0) return CONSOLE_COMPLETE;
    if (strcmp(key, "up") == 0) recall(self, -1);
    if (strcmp(key, "down") == 0) recall(self, 1);
    if (strcmp(key, "pageup") == 0) scroll_by(self, PAGE);
    if (strcmp(key, "pagedown") == 0) scroll_by(self, -PAGE);
    edit_key(&self->edit, key, self->ctrl);
    return CONSOLE_STAY;
}

static bool is_ctrl(const char *key)
{
    return strcmp(key, "left ctrl") == 0 || strcmp(key, "right ctrl") == 0 || strcmp(key, "left gui") == 0 ||
           strcmp(key, "right gui") == 0;
}

console_wish console_key(console *self, int key, bool down, uint64_t now_ns)
{
    const char *name = input_key_name(key);
    if (!name) return CONSOLE_STAY;
    if (is_ctrl(name)) {
        self->ctrl = down;
        return CONSOLE_STAY;
    }
    repeat_key(&self->held, key, down, now_ns);
    return down ? press(self, name) : CONSOLE_STAY;
}

/* Return, Tab and Esc once for each press. */
console_wish console_repeat(console *self, uint64_t now_ns)
{
    const char *name = input_key_name(repeat_next(&self->held, now_ns));
    if (!name || strcmp(name, "return") == 0 || strcmp(name, "tab") == 0 || strcmp(name, "escape") == 0 ||
        strcmp(name, "keypad enter") == 0)
        return CONSOLE_STAY;
    return press(self, name);
}

void console_type(console *self, int code)
{
    if (!self->ctrl) edit_type(&self->edit, code);
}

void console_wheel(console *self, float notches) { scroll_by(self, (long)(3 * notches)); }

/* ---- completion ---- */

void console_complete(console *self, const completions *found)
{
    char line[CONSOLE_PRINTED] = "";
    const size_t common = strlen(found->common);
    if (found->total > 0 && common > found->typed) {
        edit_insert(&self->edit, found->common + found->typed);
        return;
    }
    if (found->total < 2) return;
    for (size_t i = 0; i < found->count; i++) {
        const size_t used = strlen(line);
        snprintf(line + used, sizeof line - used, "%s%s", i > 0 ? "   " : "", found->names[i]);
    }
    const console_line *last = self->count > 0 ? &self->lines[(self->first + self->count - 1) % CONSOLE_LINES] : NULL;
    if (!last || strcmp(last->text, line) != 0) console_say(self, CONSOLE_HELP, line);
}

/* ---- the console's own lines ---- */

static const char HELP[] =
    "Type Lua: an expression shows its value, statements run, as a part of the game that recordings repeat.\n"
    "Names are the game's own: locals that its callbacks use, and globals. entity_31 is the entity with the number "
    "31;\n"
    "it is the one that F4 has chosen.\n"
    "Up and Down: what was typed before. Tab: completes a name. Page Up, Page Down, wheel: older lines.\n"
    "Ctrl+C, Ctrl+V: copy, paste. Ctrl+U, Ctrl+K, Ctrl+W: delete to the begin, to the end, a word. Ctrl+L: clear.\n"
    "help NAME tells of a function: help position, help daft.entity. Esc, or the key again, closes.";

/* "entity:push" by itself or by "push"; "light.sun" also by "daft.light.sun". */
static bool is_called(const char *function, const char *name)
{
    const char *last = function + strlen(function);
    while (last > function && last[-1] != '.' && last[-1] != ':') last--;
    if (strncmp(name, "daft.", 5) == 0) return strcmp(function, name + 5) == 0;
    return strcmp(function, name) == 0 || strcmp(last, name) == 0;
}

static void tell_of(console *self, const char *name)
{
    size_t areas, told = 0;
    const api_area *const *all = api_areas(&areas);
    for (size_t i = 0; i < areas; i++) {
        for (size_t k = 0; k < all[i]->count; k++) {
            const api_function *f = &all[i]->functions[k];
            char line[300];
            if (!is_called(f->name, name)) continue;
            snprintf(line, sizeof line, "%s%s %.200s", strchr(f->name, ':') ? "" : "daft.", f->name, f->form);
            console_say(self, CONSOLE_VALUE, line);
            console_say(self, CONSOLE_HELP, f->doc);
            told++;
        }
    }
    if (told == 0) console_say(self, CONSOLE_ERROR, "There is no function of that name. Tab after daft. lists them.");
}

bool console_command(console *self, const char *line)
{
    char command[8] = "", name[64] = "", rest;
    const int words = sscanf(line, "%7s %63s %c", command, name, &rest);
    if (words == 1 && strcmp(command, "clear") == 0) {
        drop_lines(self);
        return true;
    }
    if (strcmp(command, "help") != 0 || words > 2 || strcspn(name, "=(") < strlen(name)) return false;
    if (words == 1)
        console_say(self, CONSOLE_HELP, HELP);
    else
        tell_of(self, name);
    return true;
}
