/* The text of a .scene file: words, quoted names and numbers of one line, each with its place for messages. */
#ifndef DAFT_SCENE_TEXT_H
#define DAFT_SCENE_TEXT_H

#include "base/base.h"
#include "base/files.h"

typedef struct daft_scene_text {
    const char *path; /* for messages */
    const char *end;
    const char *line_start, *at;
    int line;
    bool block;        /* what is read stands between { and } */
    const char *usage; /* what the current item looks like, for messages */
    daft_error *error;
} daft_scene_text;

typedef struct daft_token {
    const char *text;
    size_t length;
    int column;
} daft_token;

daft_scene_text daft_scene_text_open(const char *path, const char *text, size_t size, daft_error *error);
/* Goes to the next line that has something on it. False at the end of the file. */
bool daft_scene_text_line(daft_scene_text *text);
/* Leaves what is left of the line unread, and of the block. */
void daft_scene_text_skip_item(daft_scene_text *text);
/* Whether the word comes next, as a word. */
bool daft_scene_text_next_is(daft_scene_text *text, const char *word);
/* Whether nothing but blanks and a comment is left on the line. */
bool daft_scene_text_ends(daft_scene_text *text);
/* A word up to the next blank, or what stands between quotes. `what` names it in messages. */
bool daft_scene_text_word(daft_scene_text *text, const char *what, daft_token *out);
/* A decimal number with low <= value <= high; `allowed` finishes "it must be …". */
bool daft_scene_text_number(daft_scene_text *text, const char *what, double low, double high, const char *allowed,
                            double *out);
/* Fails unless the line ends. */
bool daft_scene_text_finish(daft_scene_text *text);
/* A syntax error at a column of the current line; "%s" in the format is the token, cut and made printable. */
bool daft_scene_text_fail(const daft_scene_text *text, int column, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* Whichever of `name` and `near` (or NULL) is nearer to what was `written`, as a guess at what was meant: at most a
 * third of its letters are wrong, missing or too many. NULL: neither. */
const char *daft_scene_text_nearer(const char *written, const char *name, const char *near);
/* The token, cut to 40 characters and with control characters as '?'. */
typedef struct daft_shown {
    char text[48];
} daft_shown;
daft_shown daft_token_show(daft_token token);

#endif
