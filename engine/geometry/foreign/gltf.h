/* gltf: what Assimp 5.2 does not say of a glTF file, from its JSON: how keys of clips are interpolated, with the
 * tangents of cubic splines; lights, of which it keeps one node each; cameras; numbers that are packed. Of other
 * formats there is nothing. */
#ifndef DAFT_FOREIGN_GLTF_H
#define DAFT_FOREIGN_GLTF_H

#include "geometry/foreign/json.h"

struct daft_foreign;
struct daft_foreign_nodes;

/* An array of the file's. */
typedef struct daft_gltf_list {
    daft_json *items;
    uint32_t count;
} daft_gltf_list;

typedef struct daft_gltf {
    const struct daft_foreign *from;
    daft_json root;        /* nothing: it is another format */
    const uint8_t *binary; /* of a GLB, or NULL */
    size_t binary_size;
    daft_arena arena;
    daft_gltf_list nodes, clips, accessors, views, buffers, cameras, lights;
    uint32_t node_count; /* of the model */
    uint32_t *node_of;   /* of each the file's number; UINT32_MAX: unknown */
    struct daft_gltf_bytes {
        const uint8_t *at; /* NULL: not read yet, or not to be had */
        size_t size;
        bool asked;
    } * bytes; /* of each buffer */
    struct daft_gltf_numbers {
        const float *at; /* NULL: not asked for yet, or not to be had */
        size_t count;
    } * numbers; /* of each accessor */
    bool out_of_memory;
} daft_gltf;

/* The numbers of an accessor, as they lie in the file. */
typedef struct daft_gltf_packed {
    const uint8_t *first;
    size_t items, stride, width; /* width: numbers of an item */
    uint32_t type;               /* of these: GL's constants, 5120 to 5126 */
    bool normalized;             /* whole numbers stand for -1 to 1, or 0 to 1 */
} daft_gltf_packed;

/* The text and its arrays alone, without the model's nodes. Call daft_gltf_close in any case. False: memory is out. */
bool daft_gltf_begin(const struct daft_foreign *from, daft_gltf *out);
/* False: there are none, or they are packed in some way that is not read here (sparse, compressed, of matrices). */
bool daft_gltf_locate(daft_gltf *gltf, daft_json accessor, daft_gltf_packed *out);
/* widen.c: a copy of the file in which everything that Assimp 5.2 takes for floats is floats. NULL: it is so already.
 * The caller releases it by the file's allocator. False: the text is no JSON, or memory is out. */
bool daft_gltf_widen(const struct daft_foreign *from, char **out, size_t *size);

/* Call daft_gltf_close in any case. False: memory is out. */
bool daft_gltf_open(const struct daft_foreign *from, const struct daft_foreign_nodes *nodes, daft_gltf *out);
void daft_gltf_close(daft_gltf *gltf);

/* A node's camera or light; nothing where it has none. */
daft_json daft_gltf_camera(const daft_gltf *gltf, uint32_t node);
daft_json daft_gltf_light(const daft_gltf *gltf, uint32_t node);

/* Whether all keys of a clip are joined by straight lines, so that nobody need ask how. */
bool daft_gltf_is_linear(const daft_gltf *gltf, uint32_t clip);
/* How a clip moves "translation", "rotation", "scale" or "weights" of a node; nothing: it does not. */
daft_json daft_gltf_sampler(const daft_gltf *gltf, uint32_t clip, uint32_t node, const char *path);
/* All numbers of the accessor of this number, a sampler's "input" or "output", as long as the gltf lives. NULL: they
 * are no floats, or are packed in some way that is not read here, or out_of_memory says why. */
const float *daft_gltf_floats(daft_gltf *gltf, daft_json number, size_t *count);

#endif
