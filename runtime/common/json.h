/* json: text in JSON files. */
#ifndef RUNTIME_COMMON_JSON_H
#define RUNTIME_COMMON_JSON_H

#include <stdio.h>

/* Writes `text` in quotes, with escapes. NULL is an empty string. */
void json_put_text(FILE *out, const char *text);

#endif
