/* json: values of a JSON text by where they begin, for what Assimp leaves out of a glTF file. Nothing is copied. What
 * is no JSON has no members, and nothing beyond the text's end is read. */
#ifndef DAFT_FOREIGN_JSON_H
#define DAFT_FOREIGN_JSON_H

#include "base/base.h"

typedef struct daft_json {
    const char *at, *end; /* at NULL: there is none; end: of the text, a readable byte */
} daft_json;

daft_json daft_json_open(const char *text, size_t size);
daft_json daft_json_member(daft_json object, const char *name);
/* Behind its last character; the text's end for what is none. */
const char *daft_json_behind(daft_json value);
/* The first item of an array, and the one after an item. */
daft_json daft_json_first(daft_json array);
daft_json daft_json_next(daft_json item);
/* `other` for what is no finite number. */
double daft_json_number(daft_json value, double other);
/* UINT32_MAX for what is no whole number below that. */
uint32_t daft_json_index(daft_json value);
/* Whether it is this string, which has nothing to be escaped. */
bool daft_json_is(daft_json value, const char *text);
/* A string as UTF-8, cut to the buffer; empty where it is none. */
void daft_json_string(daft_json value, char *out, size_t size);

#endif
