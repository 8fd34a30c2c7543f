/* A line of text being typed. */
#include "tools/edit.h"

#include "common/util.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

/* Bytes of a letter after the first. */
static bool is_rest(char c) { return ((unsigned char)c & 0xC0) == 0x80; }

static size_t before(const line_edit *self, size_t at)
{
    if (at > 0) at--;
    while (at > 0 && is_rest(self->text[at])) at--;
    return at;
}

static size_t after(const line_edit *self, size_t at)
{
    if (self->text[at]) at++;
    while (is_rest(self->text[at])) at++;
    return at;
}

static bool is_word(char c) { return isalnum((unsigned char)c) || c == '_' || (unsigned char)c >= 0x80; }

static size_t word_before(const line_edit *self, size_t at)
{
    while (at > 0 && !is_word(self->text[at - 1])) at--;
    while (at > 0 && is_word(self->text[at - 1])) at--;
    return at;
}

static size_t word_after(const line_edit *self, size_t at)
{
    while (self->text[at] && !is_word(self->text[at])) at++;
    while (is_word(self->text[at])) at++;
    return at;
}

/* From one place to a later one; the cursor goes to the first. */
static void cut(line_edit *self, size_t from, size_t to)
{
    memmove(self->text + from, self->text + to, strlen(self->text + to) + 1);
    self->cursor = from;
}

void edit_set(line_edit *self, const char *text)
{
    self->text[0] = 0, self->cursor = 0;
    edit_insert(self, text);
}

void edit_type(line_edit *self, int code)
{
    char letter[5];
    utf8_put((uint32_t)code, letter);
    const size_t length = strlen(letter), used = strlen(self->text);
    if (used + length >= sizeof self->text) return;
    memmove(self->text + self->cursor + length, self->text + self->cursor, used - self->cursor + 1);
    memcpy(self->text + self->cursor, letter, length);
    self->cursor += length;
}

void edit_insert(line_edit *self, const char *text)
{
    for (uint32_t code; (code = utf8_next(&text)) != 0;) edit_type(self, code < ' ' || code == 0x7F ? ' ' : (int)code);
}

static bool edit_by_ctrl(line_edit *self, const char *key)
{
    if (strcmp(key, "a") == 0)
        self->cursor = 0;
    else if (strcmp(key, "e") == 0)
        self->cursor = strlen(self->text);
    else if (strcmp(key, "u") == 0)
        cut(self, 0, self->cursor);
    else if (strcmp(key, "k") == 0)
        self->text[self->cursor] = 0;
    else if (strcmp(key, "w") == 0 || strcmp(key, "backspace") == 0)
        cut(self, word_before(self, self->cursor), self->cursor);
    else if (strcmp(key, "left") == 0)
        self->cursor = word_before(self, self->cursor);
    else if (strcmp(key, "right") == 0)
        self->cursor = word_after(self, self->cursor);
    else
        return false;
    return true;
}

bool edit_key(line_edit *self, const char *key, bool ctrl)
{
    if (ctrl) return edit_by_ctrl(self, key);
    if (strcmp(key, "left") == 0)
        self->cursor = before(self, self->cursor);
    else if (strcmp(key, "right") == 0)
        self->cursor = after(self, self->cursor);
    else if (strcmp(key, "home") == 0)
        self->cursor = 0;
    else if (strcmp(key, "end") == 0)
        self->cursor = strlen(self->text);
    else if (strcmp(key, "backspace") == 0)
        cut(self, before(self, self->cursor), self->cursor);
    else if (strcmp(key, "delete") == 0)
        cut(self, self->cursor, after(self, self->cursor));
    else
        return false;
    return true;
}

void repeat_key(key_repeat *self, int key, bool down, uint64_t now_ns)
{
    static const uint64_t FIRST_NS = 400000000;
    if (down)
        *self = (key_repeat){key, now_ns + FIRST_NS};
    else if (key == self->key)
        self->key = -1;
}

int repeat_next(key_repeat *self, uint64_t now_ns)
{
    static const uint64_t NEXT_NS = 33000000;
    if (self->key < 0 || now_ns < self->due_ns) return -1;
    self->due_ns += NEXT_NS;
    if (self->due_ns < now_ns) self->due_ns = now_ns; /* after a long frame */
    return self->key;
}
