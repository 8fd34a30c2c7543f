/* geometry/formats: reading and checking OBJ and MTL files. Public headers: text.h. The functions are those of
 * geometry/mesh.h.
 *
 * What the parts of the OBJ loader share: the statements as read, before they are a mesh. */
#ifndef DAFT_OBJ_H
#define DAFT_OBJ_H

#include "geometry/mesh.h"
#include "geometry/formats/text.h"

#define DAFT_OBJ_ABSENT    UINT32_MAX       /* a corner without uv or normal */
#define DAFT_OBJ_MAX_INDEX (UINT32_MAX - 1) /* what larger indices are cut to: beyond any array */

/* Smoothing groups of `s`: 0 is flat. */
#define DAFT_OBJ_GROUP_NONE UINT32_MAX /* no `s` seen yet: smooth */

/* The state of `usemtl` and `s` from a face on. */
typedef struct daft_obj_run {
    uint32_t first_face, slot, group;
} daft_obj_run;

typedef struct daft_obj_name {
    const char *at; /* in the text */
    size_t length;
} daft_obj_name;

/* Arrays lie as the mesh has them, which takes them over as they are where every face is a triangle. */
typedef struct daft_obj_source {
    daft_text text;
    const daft_allocator *allocator;
    const daft_files *files; /* where its materials are; NULL: anywhere */
    float *x, *y, *z;        /* positions */
    daft_vec3 *normals;
    daft_vec2 *uvs;
    daft_vec3 *colors; /* of the first color_count positions, linear; NULL: none has one */
    float *alphas;     /* of as many of these; NULL: none has one */
    size_t color_count, color_room, alpha_count, alpha_room;
    /* Of each corner, from 0. Positions may lie beyond the file's last, as forward references do. NULL: no corner has
     * any. */
    uint32_t *corner_positions, *corner_uvs, *corner_normals;
    uint32_t *faces; /* corners of each `f` statement; 0: dropped. NULL: 3 each */
    daft_obj_run *runs;
    daft_obj_name *slots;     /* materials by first use; length 0: none named */
    daft_obj_name *libraries; /* what follows each mtllib */
    size_t position_count, normal_count, uv_count, corner_count, face_count, run_count, slot_count, library_count;
    size_t position_room, normal_room, uv_room, corner_room, face_room, run_room, slot_room, library_room;
    bool repeats;              /* some triangle has a vertex twice */
    size_t triangle_count;     /* at most so many come from the faces */
    uint32_t largest_face;     /* corners */
    bool bad_position, bad_uv; /* some is NaN or infinite */
    const char *first_drop;    /* where the first face was dropped, and why */
    const char *first_drop_reason;
    uint32_t drops;    /* faces left out */
    uint32_t *groups;  /* of each triangle, where some `s` was seen */
    uint32_t *face_of; /* the face that each triangle comes from; NULL: nobody asks. Room for triangle_count */
    const daft_problems *problems; /* NULL: only what loading warns of */
} daft_obj_source;

/* Statements to arrays (obj_read.c). On failure the source still has to be freed. */
bool daft_obj_read(daft_obj_source *source, daft_error *error);
/* Reads on as long as lines are plain (obj_scan.c), there is room for what they say, and, unless `faces`, they are no
 * faces; returns where the general reader goes on. */
const char *daft_obj_scan(daft_obj_source *source, const char *p, bool faces);
/* The `f` statement of a face, for messages. */
const char *daft_obj_find_face(const daft_obj_source *source, size_t face);
/* Warns that a face is left out. `reason` is a constant string. */
void daft_obj_drop(daft_obj_source *source, const char *at, const char *reason);

void daft_obj_source_free(daft_obj_source *source);

/* Arrays to a mesh (obj_mesh.c), which takes what it can use as it is out of the source: all but the normals. */
bool daft_obj_make_mesh(daft_obj_source *source, daft_trimesh *mesh, daft_error *error);
/* Those are last. The text may be gone by then: it is as large as what they need beside it. None, where no
 * corner of the file has one. */
bool daft_obj_make_normals(daft_obj_source *source, daft_trimesh *mesh, daft_error *error);

static inline daft_vec3 daft_obj_position(const daft_obj_source *source, size_t index)
{
    return daft_v3(source->x[index], source->y[index], source->z[index]);
}

/* The material of every slot, from the libraries (obj_slots.c). */
bool daft_obj_make_slots(daft_obj_source *source, daft_mtl_list *slots, daft_error *error);

#endif
