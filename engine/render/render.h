/* render: a picture from a snapshot. Plan, visibility, surfaces, light visibility, shading, reflections, resolve.
 * Promises: reads only the snapshot; the same snapshot gives the same bytes for any number of threads and any
 * instruction set; what the scene does not call for is not run, and the counters say so.
 *
 * Public headers: render.h Inner headers: internal.h kernels.h media.h denoise.h dice.h redraw.h
 *
 * The snapshot is flat arrays in frame space: world axes, origin at the camera, floats. The caller rebases (in double).
 */
#ifndef DAFT_RENDER_H
#define DAFT_RENDER_H

#include "accel/accel.h"
#include "base/base.h"
#include "geometry/mesh.h"
#include "image/image.h"
#include "shade/shade.h"

typedef struct daft_renderer daft_renderer; /* scratch memory that outlives a frame */

/* What a series of pictures remembers of what was sampled (reuse.c), in planes of a float for each pixel: the fraction
 * that arrived, or what came along the mirrored rays, of three colours; the inverse of the depth; over how many
 * pictures; and, as an integer, whose surface it was (0: nothing was sampled). All zero: nothing yet. */
enum { DAFT_PAST_INVERSE = 3, DAFT_PAST_LENGTH, DAFT_PAST_ENTITY, DAFT_PAST_PLANES };
/* Pictures that count together: more would leave trails behind moving shadows. */
#define DAFT_LONGEST_PAST 8

typedef struct daft_past {
    bool some;               /* of a picture before */
    int now;                 /* the planes of that picture; the others are for the one at work */
    int width, height, step; /* pixels that are remembered, in whole tiles: one of every step x step of the picture, */
    int x[2], y[2];          /* this one of them */
    float *planes[2];
    size_t capacity[2];
} daft_past;

enum { DAFT_PAST_LIGHT, DAFT_PAST_GLOSS, DAFT_PASTS };

void daft_past_free(daft_past *past, const daft_allocator *allocator);

/* How bright a series of pictures is shown (meter.c). All zero: there was none yet. */
typedef struct daft_metering {
    bool some, moving;
    float ev;
} daft_metering;

typedef struct daft_kept daft_kept;

typedef struct daft_snapshot {
    int width, height;
    int first_row, row_count;       /* to be drawn: whole rows of tiles */
    daft_vec3 right, up, forward;   /* camera axes, unit, in frame space */
    float focal;                    /* pixels: (width/2) / tan(fov/2) */
    daft_quality quality;           /* of the drawn size: `scale` and `upscale` are the caller's */
    const daft_instance *instances; /* visible ones, in entity order */
    uint32_t instance_count;
    uint64_t revision; /* of these instances; no others had or will have it. 0: nothing is kept of them */
    const daft_surface *materials;
    uint32_t material_count;
    const daft_texture_data *textures;
    uint32_t texture_count;
    const daft_light_source *lights;
    uint32_t light_count;
    bool colors, fades; /* some mesh has colours of its own; or alpha, too */
    daft_ambient ambient;
    float occlusion; /* metres within which what stands around keeps ambient light away; 0: nothing does */
    uint32_t seed;   /* of what is sampled */
    daft_air air;
    daft_sky sky;
    /* From frame space to the view space of the picture before, of what each instance shows and, last, of the sky's
     * directions; NULL: there was none. */
    const daft_affine *before;
    float before_focal;
    daft_past *past; /* DAFT_PASTS: read and, unless this is a band, written while the picture is drawn; NULL: none */
    daft_tone tone;
    bool metered;            /* tone.ev is added to what the picture's own light calls for */
    daft_metering *metering; /* of the pictures before, read and, unless this is a band, written; NULL: there are none
                              */
    float elapsed;           /* seconds since the one before */
    daft_kept *kept; /* the same of the picture as it is, so that only what changes is drawn; NULL: all is drawn */
    daft_dvec3 eye;  /* the camera's place in the world, and a revision of the textures and the sky's image: both are
                      * only  compared with those of the picture before */
    uint64_t looks;
} daft_snapshot;

/* A picture as it was drawn, and all that decided it (redraw.c). All zero: none yet. */
typedef struct daft_reach {
    daft_vec3 low, high; /* of places, or of directions; low > high: none */
} daft_reach;

/* What one pass over a tile lit, and where that sent rays on: of points that pixels see themselves, and of others. */
typedef struct daft_kept_pass {
    daft_reach points[2], rays[2];
} daft_kept_pass;

typedef struct daft_kept_tile {
    daft_kept_pass pass[2]; /* its pixels; its corners */
} daft_kept_tile;

typedef struct daft_kept_instance {
    daft_affine to_frame, to_object;
    daft_vec3 low, high;
    float radius;
    uint32_t entity, order, flags, slots;
    uint64_t shape, materials; /* the latter by their hash */
} daft_kept_instance;

struct daft_kept {
    bool some;
    uint32_t still;     /* pictures in a row in which nothing changed */
    daft_snapshot view; /* of its pointers, only the address of the sky's image is compared; width 0: no picture yet */
    uint8_t *pixels;
    daft_kept_tile *tiles;
    uint8_t *state;  /* of each tile in the running picture */
    uint32_t *lists; /* of tiles: those to draw, then those to mix with their corners */
    uint32_t tile_count;
    daft_kept_instance *instances;
    uint32_t instance_count;
    uint64_t revision; /* of the snapshot whose instances these are */
    daft_surface *materials;
    uint32_t material_count;
    bool *recoloured; /* of the running picture's materials: whether they differ */
    daft_light_source *lights;
    size_t pixel_capacity, tile_capacity, state_capacity, list_capacity, instance_capacity, material_capacity,
        recoloured_capacity, light_capacity;
};

void daft_kept_free(daft_kept *kept, const daft_allocator *allocator);

/* Arrays of width·height or NULL; ids index the snapshot's instances, UINT32_MAX for the sky. See daft_aov. */
typedef struct daft_frame_aov {
    float *depth;
    daft_vec3 *normal;
    uint32_t *instance, *triangle;
    daft_vec3 *color, *albedo;
    daft_vec2 *motion;
    uint32_t *cost;
} daft_frame_aov;

typedef struct daft_frame_target {
    uint8_t *pixels; /* RGBA, sRGB */
    daft_frame_aov aov;
    bool (*progress)(void *user, float done);
    void *progress_user;
} daft_frame_target;

/* opacity.c. The DAFT_OPACITY_… of each of a mesh's triangles; `materials`: of its slots, into `surfaces`. False:
 * memory is out. */
bool daft_opacity_classify(const daft_allocator *allocator, const daft_trimesh *mesh, const daft_surface *surfaces,
                           const uint32_t *materials, const daft_texture_data *textures, uint8_t *out);
/* And what masks say of their mixed triangles' places: one for each slot, into `out`. The cells are as many as the mesh
 * has use for; daft_masks_free frees them. False: memory is out, and nothing is to be freed. */
bool daft_masks_make(const daft_allocator *allocator, const daft_trimesh *mesh, const daft_surface *surfaces,
                     const uint32_t *materials, const daft_texture_data *textures, daft_mask *out);
void daft_masks_free(const daft_allocator *allocator, daft_mask *masks, uint32_t count);
size_t daft_masks_bytes(const daft_mask *masks, uint32_t count);

daft_renderer *daft_renderer_create(const daft_allocator *allocator, int threads, int isa, daft_error *error);
void daft_renderer_destroy(daft_renderer *renderer);
/* counters: the renderer adds to nothing, it sets every field but query_rays, mesh_builds, mesh_refits, poses,
 * poses_unseen, instance_updates, threads and isa. */
bool daft_render_frame(daft_renderer *renderer, const daft_snapshot *snapshot, const daft_frame_target *target,
                       daft_counters *counters, daft_error *error);

#endif
