/* report: what a sweep found, as a table, a CSV, a JSON and a page. */
#ifndef RUNTIME_ACCURACY_REPORT_H
#define RUNTIME_ACCURACY_REPORT_H

#include "accuracy/sweep.h"

#include <stdio.h>

typedef struct report_def {
    const sweep_result *sweep;
    const char *scene;   /* its name, as the user gave it */
    const char *command; /* that repeats it */
    const char *folder;  /* exists */
    double budget_ms;
    int threads;      /* 0: one for each processor */
    bool no_pictures; /* the page has plots and tables alone */
} report_def;

/* The front, the budget's choice and the floor. */
void report_print(const report_def *def, FILE *out);
/* Writes points.csv, report.json, index.html and the pictures that it shows into the folder. */
bool report_write(const report_def *def, daft_error *error);
/* page.c: index.html. */
bool report_write_page(const report_def *def, daft_error *error);

/* The settings by time, fastest first: `order` has room for all of them. */
void report_sort(const sweep_result *sweep, size_t *order);
enum { SENTENCE = 1024 };
/* The options of daft render that draw the setting. */
void report_command(const sweep_result *sweep, const sweep_point *point, char *out, size_t size);
/* What to take for the budget. */
void report_advise(const report_def *def, char out[SENTENCE]);
/* One about the pixels that a cheaper visibility gets wrong. */
void report_wrong(const sweep_result *sweep, int which, char out[SENTENCE]);
/* One sentence about how far the reference can be trusted. */
void report_floor(const report_def *def, char out[SENTENCE]);

#endif
