/* json: JSON files: text that is written, and objects that are read. */
#ifndef RUNTIME_COMMON_JSON_H
#define RUNTIME_COMMON_JSON_H

#include "daft.h"

#include <stdio.h>

/* Writes `text` in quotes, with escapes. NULL is an empty string. */
void json_put_text(FILE *out, const char *text);
/* Writes an object with the struct's fields, exactly: numbers, booleans, choices, lists of numbers and nested structs.
 * Others are left out. `indent`: spaces before its lines. */
void json_put_struct(FILE *out, daft_struct which, const void *value, int indent);

/* Reads objects of strings, numbers, booleans and lists of numbers, one after the other. Ends with the first mistake,
 * whose place *error has: from then on every call fails. */
typedef struct json_reader {
    const char *file, *text, *at, *key; /* key: where the last one stands */
    daft_error *error;
    bool fresh, failed; /* at the begin of an object */
} json_reader;

/* `text` and `file` (its name) have to outlive the reader. */
void json_open(json_reader *out, const char *file, const char *text, daft_error *error);
bool json_begin(json_reader *in); /* of an object */
/* Its next key. False: the object has ended, or in->failed. */
bool json_key(json_reader *in, char *key, size_t size);
bool json_get_text(json_reader *in, char *out, size_t size);
bool json_get_number(json_reader *in, double *out);
/* An object as json_put_struct writes it; fields that it does not have stay as they are. */
bool json_get_struct(json_reader *in, daft_struct which, void *value);
bool json_end(json_reader *in); /* nothing but blanks follows */
/* An error about the last key. */
bool json_unknown(json_reader *in, const char *key);
/* An error at the place that is being read. */
bool json_fail(json_reader *in, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
