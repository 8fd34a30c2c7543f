/* aov: what `daft render --aov` writes beside the picture: depth, normals, entity and triangle of each pixel. */
#ifndef RUNTIME_CLI_AOV_H
#define RUNTIME_CLI_AOV_H

#include "daft.h"

enum { AOV_DEPTH, AOV_NORMAL, AOV_ID, AOV_TRIANGLE, AOV_COUNT };

/* The channels wanted, and their arrays. A zero value wants none. */
typedef struct aov_set {
    bool wanted[AOV_COUNT];
    int width, height;
    daft_aov arrays;
} aov_set;

/* Parses "depth,normal". False: the message is on stderr; exit with STATUS_BAD_USAGE. */
bool aov_parse(const char *list, aov_set *set);
bool aov_allocate(aov_set *set, int width, int height, daft_error *error);
/* image "a/b.png": a/b.depth.pfm, a/b.normal.pfm, a/b.id.png, a/b.triangle.png, for the wanted channels. */
bool aov_write(const aov_set *set, daft_engine *engine, const char *image, daft_error *error);
void aov_free(aov_set *set);

#endif
