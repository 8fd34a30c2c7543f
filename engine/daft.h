/* DAFT: a 3D engine in C that needs no GPU. The one public header of libdaft.
 *
 * Life of a program: make an engine, make a scene in it, fill the scene (from a file or by calls), render views of it
 * into images, cast rays, step it, destroy the scene, destroy the engine.
 *
 * Conventions: right-handed, Y up; metres, seconds, kilograms, radians. Colours are linear light, 1 is white. Images
 * have the top row first. Counter-clockwise triangles face the viewer. A quaternion is (x, y, z, w) with w real.
 *
 * Errors: a call that can fail returns false, NULL or a null handle and fills `error` (which may be NULL). It leaves
 * everything as it was before the call. Warnings go to the callback of the engine's definition. A pointer is NULL only
 * where this is said; elsewhere the call fails with DAFT_ERROR_ARGUMENT, and one that has no `error` gives 0, NULL or a
 * default, or does nothing.
 *
 * Handles are 32 bits of index and generation: 0 is "none", a handle of something destroyed is stale and every call
 * that takes it fails with DAFT_ERROR_HANDLE. A scene cannot tell another scene's handle from an own of the same
 * number.
 *
 * Callbacks (allocator, warn, progress, found) run inside a call. From inside one, what changes or draws anything of
 * the same engine fails with DAFT_ERROR_ARGUMENT; what has no `error` warns and does nothing, daft_scene_destroy and
 * daft_engine_destroy among them; daft_image_destroy does nothing to a picture that is being drawn. What only reads, by
 * a const scene or a name with _get_, and whatever belongs to another engine is fine there, but not in an allocator's
 * functions, which call nothing of the library. A callback must return: no longjmp, no exception.
 *
 * Threads: an engine and everything in it belongs to one calling thread at a time; the library uses its own worker
 * threads inside a call. Results do not depend on how many, bit for bit. Different engines are independent.
 *
 * Sections, each under a line of dashes: plain values; numbers; errors and warnings; files; engine; images; scenes
 * (assets, entities, animation, joints, the simulation as a whole, camera and lights); time; rendering; ray queries;
 * scans; queries of bodies; characters; checking files; counters; and, as data, the fields of the structs that users
 * fill (daft_fields).
 */
#ifndef DAFT_H
#define DAFT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define DAFT_API __attribute__((visibility("default")))
#else
#define DAFT_API
#endif

#define DAFT_VERSION_MAJOR 0
#define DAFT_VERSION_MINOR 1
#define DAFT_VERSION_PATCH 0

/* ---- plain values ------------------------------------------------------------------------------------------------ */

/* clang-format off */
typedef struct daft_vec2 { float x, y; } daft_vec2;
typedef struct daft_vec3 { float x, y, z; } daft_vec3;
typedef struct daft_dvec3 { double x, y, z; } daft_dvec3; /* a position in the world */
typedef struct daft_quat { float x, y, z, w; } daft_quat;
/* clang-format on */

/* ---- numbers: the same bits on every machine, where libm's differ ------------------------------------------------- */

/* Angles are radians. Sine and cosine: |x| up to 1e6, absolute error below 1e-15; the tangent is their quotient. */
DAFT_API double daft_sin(double x);
DAFT_API double daft_cos(double x);
DAFT_API double daft_tan(double x);
DAFT_API double daft_atan2(double y, double x);         /* -pi..pi */
DAFT_API double daft_asin(double x);                    /* clamps x to -1..1; -pi/2..pi/2 */
DAFT_API double daft_acos(double x);                    /* clamps x to -1..1; 0..pi */
DAFT_API double daft_exp2(double x);                    /* relative error below 5e-14 */
DAFT_API double daft_log2(double x);                    /* x > 0 */
DAFT_API double daft_pow(double base, double exponent); /* base >= 0 */

/* ---- errors and warnings ----------------------------------------------------------------------------------------- */

typedef enum daft_status {
    DAFT_OK = 0,
    DAFT_ERROR_ARGUMENT,    /* a value the call does not accept: the message names it */
    DAFT_ERROR_HANDLE,      /* a null or stale handle */
    DAFT_ERROR_IO,          /* a file that cannot be opened, read or written */
    DAFT_ERROR_SYNTAX,      /* a file whose text or bytes are not what its format says */
    DAFT_ERROR_UNSUPPORTED, /* a format or option this build does not have */
    DAFT_ERROR_MEMORY,      /* the allocator returned NULL */
    DAFT_ERROR_CANCELLED    /* a progress callback asked to stop */
} daft_status;

typedef struct daft_error {
    daft_status code;
    int line;          /* 1-based, 0 where it means nothing */
    int column;        /* 1-based, 0 where it means nothing */
    char file[512];    /* empty where it means nothing */
    char message[512]; /* one line of English, no full stop */
} daft_error;

/* Writes "file:line:column: message", leaving out what is not known. Returns `buffer`. */
DAFT_API const char *daft_error_text(const daft_error *error, char *buffer, size_t size);

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* A text that a terminal can be shown: control characters and bytes that are no UTF-8 become \n, \t, \x1b and so on.
 * Every message of the library is in this form. Returns `buffer`. */
DAFT_API const char *daft_escape(const char *text, char *buffer, size_t size);

/* A set of folders, the roots, and nothing else of the disk: for scenes and games of strangers. Whatever a path says,
 * and whatever links lie in its way, what is read lies beneath a root; links are not followed at all. A path that
 * begins with a root's folder leads into that root; another relative one is looked for in all roots, in order; any
 * other is refused. Hard links and mounted folders count as part of a root. */
typedef struct daft_files daft_files;

/* Calls back with a file's name. */
typedef void daft_name_callback(void *user, const char *name);
/* A root whose files are somewhere else than on the disk. `path` is beneath the root, with neither "." nor ".." in it.
 * Returns the file's size, or -1 where there is none; where `capacity` is at least that, fills `bytes`. A file that is
 * damaged fills *error and gives -1. Called from the thread that loads. */
typedef int64_t daft_read_callback(void *user, const char *path, void *bytes, uint64_t capacity, daft_error *error);
/* Calls `found` with the name of each file of `folder`. */
typedef void daft_list_callback(void *user, const char *folder, daft_name_callback *found, void *found_user);

typedef struct daft_root {
    const char *folder;       /* what paths into it begin with */
    daft_read_callback *read; /* NULL: `folder` is one of the disk */
    daft_list_callback *list; /* or NULL; with `read` only */
    void *user;
} daft_root;

typedef struct daft_files_def {
    uint32_t cookie;
    const daft_root *roots; /* copied; at most 16 */
    uint32_t root_count;
    uint64_t max_file_bytes; /* larger files are refused; 2 GiB, which is also the most */
} daft_files_def;

DAFT_API daft_files_def daft_default_files_def(void);
/* Fails where a folder cannot be opened. It is opened once: renaming it changes nothing. */
DAFT_API daft_files *daft_files_create(const daft_files_def *def, daft_error *error);
DAFT_API void daft_files_destroy(daft_files *files); /* NULL is fine; no engine may use it any more */
/* Writes the path of the first root's file of this relative name. False: no root has a regular file of that name. */
DAFT_API bool daft_files_find(const daft_files *files, const char *name, char *path, size_t size);
/* Calls `found` with what each root has in `folder`, but for names that begin with a dot. A root without the folder has
 * nothing. False: the name leads outside, or some root's folder cannot be read to its end. */
DAFT_API bool daft_files_list(const daft_files *files, const char *folder, daft_name_callback *found, void *user);
/* Reads a whole regular file and appends a zero byte. `files` may be NULL: the path leads anywhere, also by links.
 * NULL: *error says why. Pipes, devices and sockets are refused without waiting. From malloc: the caller frees it. */
DAFT_API void *daft_read_file(const daft_files *files, const char *path, size_t *size, daft_error *error);

/* Writes a whole file, or nothing: a temporary file beside it is flushed to the disk and renamed, so the old file stays
 * until the new one is whole. Fails with DAFT_ERROR_IO where `path` is a folder, a device, a pipe or a symbolic link.
 */
DAFT_API bool daft_write_file(const char *path, const void *bytes, size_t size, daft_error *error);

/* The same for a file that is too large for memory, a video for example: it grows in a temporary file. Errors stick, so
 * only daft_writer_commit has to be checked. A writer belongs to one thread at a time. */
typedef struct daft_writer daft_writer;
DAFT_API daft_writer *daft_writer_begin(const char *path, daft_error *error); /* NULL with the message */
/* Appends. NULL or no bytes: nothing happens. */
DAFT_API void daft_writer_put(daft_writer *writer, const void *bytes, size_t size);
/* Writes over earlier bytes, for headers with sizes: the end stays where it is. What would lie past it is an error. */
DAFT_API void daft_writer_put_at(daft_writer *writer, uint64_t offset, const void *bytes, size_t size);
/* Puts the file into place and frees the writer. False: the old file is as it was, and nothing else is left behind. */
DAFT_API bool daft_writer_commit(daft_writer *writer, daft_error *error);
/* Drops what was written and frees the writer. NULL is fine. */
DAFT_API void daft_writer_abandon(daft_writer *writer);
/* For a program that is about to end while its threads still write, as on SIGTERM: removes the temporary files that
 * this process has open. What is being written then fails. Not for signal handlers. Where the system does not tell a
 * file's name (it does on Linux and macOS), nothing happens, and the next write in that folder removes them. */
DAFT_API void daft_remove_temporaries(void);

/* ---- engine ------------------------------------------------------------------------------------------------------ */

typedef struct daft_engine daft_engine;

/* Called from the library's worker threads too, at the same time: it must be thread-safe, as malloc is. */
typedef struct daft_allocator {
    void *user;
    void *(*allocate)(void *user, size_t size, size_t alignment); /* alignment: a power of two up to 64 */
    void (*release)(void *user, void *pointer);                   /* pointer may be NULL */
} daft_allocator;

/* Called in calls that load or draw, from the calling thread. `warning` lives as long as the call. */
typedef void daft_warning_callback(void *user, const daft_error *warning);

/* What rays search meshes by. Pictures and hits are the same, bit for bit. */
typedef enum daft_accel {
    DAFT_ACCEL_BVH = 0, /* bounding volume hierarchies, which the rasterizer culls by as well */
    DAFT_ACCEL_KDTREE   /* kd-trees besides: camera, mirror and query rays go through them one by one; shadows do not */
} daft_accel;

/* "bvh" or "kdtree"; false for other names, which leave *out as it was. */
DAFT_API bool daft_accel_parse(const char *name, daft_accel *out);
DAFT_API const char *daft_accel_name(daft_accel accel);

typedef struct daft_engine_def {
    uint32_t cookie; /* of all definitions: set by the default maker, shows that it was called */
    int threads;     /* worker threads, at most 64; 0: one for each processor */
    const char *isa; /* "plain", "sse2", "avx2", "avx512"; NULL: the best this build and processor have */
    daft_accel accel;
    daft_allocator allocator;    /* all zero: malloc */
    daft_warning_callback *warn; /* NULL: warnings are dropped */
    void *warn_user;             /* handed to warn */
    uint64_t memory_limit;       /* bytes that the engine may hold, with what daft_engine_reserve takes; 0: no limit */
} daft_engine_def;

DAFT_API daft_engine_def daft_default_engine_def(void);
/* Owned by the caller. NULL: a field out of range, an instruction set that this build or processor lacks
 * (DAFT_ERROR_UNSUPPORTED), no memory. */
DAFT_API daft_engine *daft_engine_create(const daft_engine_def *def, daft_error *error);
/* NULL is fine. Its scenes and images must be gone. */
DAFT_API void daft_engine_destroy(daft_engine *engine);
DAFT_API int daft_engine_threads(const daft_engine *engine);     /* worker threads, 1 or more */
DAFT_API const char *daft_engine_isa(const daft_engine *engine); /* the one in use; lives as long as the program */
/* From now on everything that the engine loads and checks, and all that those files name, comes from these roots: call
 * it before a scene's first load, since assets are known by their paths. NULL, as at first: from anywhere. The engine
 * uses `files` until another is set. */
DAFT_API bool daft_engine_set_files(daft_engine *engine, const daft_files *files, daft_error *error);

/* Bytes. All of the engine's memory is counted: scenes, images, what decoders and builders need for a while, and what
 * is reserved. A call that needs more than the limit leaves over fails with DAFT_ERROR_MEMORY and changes nothing;
 * images are measured by their headers, before they are decoded. */
typedef struct daft_memory {
    uint64_t used, peak, limit; /* limit 0: none */
} daft_memory;

DAFT_API daft_memory daft_engine_memory(const daft_engine *engine);
/* Counts bytes that the program itself holds, such as those of scripts, so that all share one limit. False: they would
 * exceed it, and nothing is taken. Any thread may call both; give back all before daft_engine_destroy. */
DAFT_API bool daft_engine_reserve(daft_engine *engine, uint64_t bytes);
DAFT_API void daft_engine_unreserve(daft_engine *engine, uint64_t bytes); /* at most what was reserved */

/* ---- images ------------------------------------------------------------------------------------------------------ */

/* RGBA, 8 bits each, sRGB, top row first, rows packed. Owned by the caller; freed with daft_image_destroy. */
typedef struct daft_image daft_image;

/* 1 to 16,384 pixels a side; all bytes are 0, transparent black. NULL: see the error. */
DAFT_API daft_image *daft_image_create(daft_engine *engine, int width, int height, daft_error *error);
/* The formats of daft_texture_load, at most 16,384 pixels a side. NULL: see the error. */
DAFT_API daft_image *daft_image_load(daft_engine *engine, const char *path, daft_error *error);
DAFT_API void daft_image_destroy(daft_image *image); /* NULL is fine */
DAFT_API int daft_image_width(const daft_image *image);
DAFT_API int daft_image_height(const daft_image *image);
/* 4·width·height bytes, which belong to the image and may be changed. */
DAFT_API uint8_t *daft_image_pixels(daft_image *image);
/* By the extension, .png or .ppm; others are DAFT_ERROR_UNSUPPORTED. As daft_write_file: the whole file or nothing. */
DAFT_API bool daft_image_write(const daft_image *image, const char *path, daft_error *error);

/* ---- scenes: assets ---------------------------------------------------------------------------------------------- */

typedef struct daft_scene daft_scene;
/* clang-format off */
typedef struct daft_mesh { uint32_t id; } daft_mesh;
typedef struct daft_texture { uint32_t id; } daft_texture;
typedef struct daft_material { uint32_t id; } daft_material;
typedef struct daft_light { uint32_t id; } daft_light;
typedef struct daft_entity { uint32_t id; } daft_entity;
typedef struct daft_joint { uint32_t id; } daft_joint;
/* clang-format on */

/* Empty: no entity, a grey ambient light, a plain sky. Owned by the caller. */
DAFT_API daft_scene *daft_scene_create(daft_engine *engine, daft_error *error);
DAFT_API void daft_scene_destroy(daft_scene *scene); /* with all that is in it; NULL is fine */
/* Adds what a .scene file describes (docs/reference/scene-files.md). A mistake in a file is DAFT_ERROR_SYNTAX with
 * file, line and column; the scene is then as it was. */
DAFT_API bool daft_scene_load(daft_scene *scene, const char *path, daft_error *error);

/* The files that the scene has read so far, as they were opened: scenes and what they include, meshes, materials,
 * pictures. For programs that load it again when one of them changes. NULL past the end; a path lives as long as the
 * scene. */
DAFT_API uint32_t daft_scene_file_count(const daft_scene *scene);
DAFT_API const char *daft_scene_get_file(const daft_scene *scene, uint32_t index);

/* Assets live as long as the scene, unless the program releases them. Loading the same path twice gives the same
 * handle. Calls that make or load one return a null handle where they fail.
 *
 * Each of those calls counts as one hold; daft_mesh_release and its kin drop one. daft_scene_collect frees the assets
 * that have no hold and that nothing uses: entities and bodies use meshes and materials, meshes materials, materials
 * textures. Their handles are stale from then on. Pictures in the making keep what they read. */
DAFT_API bool daft_mesh_release(daft_scene *scene, daft_mesh mesh, daft_error *error);
DAFT_API bool daft_texture_release(daft_scene *scene, daft_texture texture, daft_error *error);
DAFT_API bool daft_material_release(daft_scene *scene, daft_material material, daft_error *error);
/* Looks at every entity and asset: some microseconds for a thousand. Returns how many were freed. */
DAFT_API uint32_t daft_scene_collect(daft_scene *scene);

/* OBJ, with the MTL files that it names; glTF, FBX and more where Assimp is installed (docs/reference/scene-files.md),
 * else DAFT_ERROR_UNSUPPORTED. What the file holds decides, not its name. */
DAFT_API daft_mesh daft_mesh_load(daft_scene *scene, const char *path, daft_error *error);

/* A mesh from arrays, which are copied. */
typedef struct daft_mesh_def {
    uint32_t cookie;
    const daft_vec3 *positions; /* metres, all finite */
    const daft_vec3 *normals;   /* one a position, or NULL: smooth across edges flatter than 40 degrees */
    const daft_vec2 *uvs;       /* one a position, or NULL: no texture coordinates */
    uint32_t vertex_count;
    const uint32_t *indices; /* three a triangle, below vertex_count; counter-clockwise seen from outside */
    uint32_t triangle_count;
    const daft_vec3 *colors; /* one a position, linear, 0..1: what its material's colour is multiplied by; or NULL */
    const float *alphas; /* one a position, 0..1: what the opacity of a material is multiplied by that masks or blends;
                            or NULL */
} daft_mesh_def;

DAFT_API daft_mesh_def daft_default_mesh_def(void);
DAFT_API daft_mesh daft_mesh_create(daft_scene *scene, const daft_mesh_def *def, daft_error *error);

/* A solid from flat outlines: what closed contours enclose, from z = -depth/2 to depth/2, the front towards +z. What
 * has a winding number that is not zero is inside, so contours may cross and overlap themselves and each other, holes
 * run the other way round than what they are in, and either way round will do for the whole. Corners are moved to a
 * grid of 2^-22 of the largest coordinate. The mesh is closed, its walls are smooth across edges flatter than 40
 * degrees, and texture coordinates are metres. */
typedef struct daft_extrude_def {
    uint32_t cookie;
    const daft_vec2 *points; /* metres, all finite; of one contour after the other */
    uint32_t point_count;    /* at most 65,536 */
    const uint32_t *counts;  /* points of each contour, which closes itself; they add up to point_count */
    uint32_t contour_count;
    float depth; /* metres, above zero */
} daft_extrude_def;

DAFT_API daft_extrude_def daft_default_extrude_def(void); /* depth: 1 */
/* Fails where the contours enclose nothing, or are so entangled that it would take more than about a second. */
DAFT_API daft_mesh daft_mesh_extrude(daft_scene *scene, const daft_extrude_def *def, daft_error *error);

/* Moves a mesh's vertices: `count`, daft_mesh_info.vertex_count of them, positions that are all finite, and as many
 * normals, or NULL: smooth across edges flatter than 40 degrees, which takes longer than all the rest. Triangles,
 * texture coordinates and materials stay. The boxes of the BVH are fitted anew; once that has made rays 1.4 times as
 * costly as they were when it was built, it is built anew (Lauterbach et al., "RT-DEFORM", 2006). Fails for a mesh that
 * has clips, which move it. */
DAFT_API bool daft_mesh_set_positions(daft_scene *scene, daft_mesh mesh, const daft_vec3 *positions,
                                      const daft_vec3 *normals, uint32_t count, daft_error *error);

typedef struct daft_mesh_info {
    uint32_t vertex_count, triangle_count, material_count;
    daft_vec3 low, high; /* bounds in the mesh's own space, at rest */
    size_t bytes;        /* of memory: vertices, attributes, indices, trees and clips */
    uint32_t clip_count;
    uint32_t camera_count, light_count; /* that its file has */
} daft_mesh_info;

/* Fails for a null handle, as every call that takes one. */
DAFT_API bool daft_mesh_get_info(daft_scene *scene, daft_mesh mesh, daft_mesh_info *info, daft_error *error);

/* What is odd about a mesh. None of it stops rendering. Edges and triangles are told apart by where their corners are,
 * whatever the vertices' numbers. */
typedef struct daft_mesh_report {
    uint32_t left_out;     /* triangles of the source that are not in the mesh: a corner repeated or not finite */
    uint32_t without_area; /* triangles lower than a millionth of their longest edge */
    uint32_t duplicate_triangles; /* with the corners of an earlier one, in the same sense */
    uint32_t duplicate_vertices;  /* used ones, in the place of an earlier one */
    uint32_t unused_vertices;
    uint32_t open_edges;         /* of one triangle. None: the mesh is closed */
    uint32_t non_manifold_edges; /* of three triangles or more */
    uint32_t turned_edges;       /* of two triangles that face opposite ways */
} daft_mesh_report;

/* Takes about as long as loading the mesh did. */
DAFT_API bool daft_mesh_check(daft_scene *scene, daft_mesh mesh, daft_mesh_report *report, daft_error *error);

/* PNG, JPEG, TGA, BMP, GIF, PSD, HDR: what stb_image reads, at most 16,384 pixels a side. */
DAFT_API daft_texture daft_texture_load(daft_scene *scene, const char *path, daft_error *error);

typedef enum daft_shading {
    DAFT_SHADING_PHONG = 0, /* Lambert and Phong, as MTL says */
    DAFT_SHADING_PHYSICAL   /* base colour (`diffuse`), `metallic` and `roughness`, as glTF says */
} daft_shading;

/* What lies behind a surface. */
typedef enum daft_alpha_mode {
    DAFT_ALPHA_OPAQUE = 0,
    DAFT_ALPHA_MASK, /* there where alpha is `alpha_cutoff` or more, a hole where it is less */
    DAFT_ALPHA_BLEND /* so much of what lies behind is seen as alpha says */
} daft_alpha_mode;

/* What lies beyond a texture's edges. */
typedef enum daft_wrap { DAFT_WRAP_REPEAT = 0, DAFT_WRAP_CLAMP, DAFT_WRAP_MIRROR } daft_wrap;

typedef struct daft_material_def {
    uint32_t cookie;
    daft_vec3 ambient;     /* Ka: the fraction of the ambient light that it reflects */
    daft_vec3 diffuse;     /* Kd: the fraction of a light's light that it scatters (Lambert) */
    daft_vec3 specular;    /* Ks: the fraction that its highlight reflects (Phong) */
    float shininess;       /* Ns: Phong exponent, 0..1000 */
    float mirror;          /* 0..1: the weight of the mirrored ray's light, which mirror_tint colours */
    daft_vec3 mirror_tint; /* 1, 1, 1 */
    float roughness;       /* 0..1: of what mirrors or lets light through; 0: smooth. Its square is GGX's alpha */
    daft_vec3 emission;    /* light it gives off by itself; lights nothing else but by `lights` of entities */
    /* Light that passes through, 0..1: the rest is left to `ambient` and `diffuse`. At each surface Fresnel's equations
     * divide it between a mirrored and a refracted ray. Everything outside closed meshes, and between two of them,
     * counts as air, unless they have priorities. */
    float transmission;
    daft_vec3 transmission_tint; /* 0..1 each: the refracted ray's light is multiplied by it, at each surface or, with
                                    a distance, in each such length of its way within the body; 1, 1, 1 */
    float tint_distance;         /* metres; 0: each surface tints, however thick the body is */
    int medium_priority;         /* 0..255. Where bodies overlap the higher one is there alone (Schmidt and Budge 2002);
                                    0: what lies around the body counts as air, if it has no priority either */
    float refractive_index;      /* 0.001..10; 1: no bending and no mirroring; water 1.33, glass 1.5 (the default) */
    daft_texture diffuse_map;    /* multiplies `ambient` and `diffuse`; none: white */
    daft_vec2 map_scale;         /* repeats of the texture over one unit of u and v */
    daft_vec2 map_offset;        /* added to u and v once these are scaled */
    daft_wrap map_wrap;          /* of all maps */
    daft_shading shading;
    float metallic; /* 0..1; physical shading alone */
    /* Textures that multiply a value, by use of their sRGB colours (ambient, specular, emission) or of bytes as they
     * are: green (shininess, roughness), blue (metallic), red (occlusion), alpha or, where the image has none, green
     * (alpha). */
    daft_texture ambient_map; /* instead of `diffuse_map` */
    daft_texture specular_map, emission_map, shininess_map, roughness_map, metallic_map;
    daft_texture normal_map;    /* tangent space: red along u, green along v, blue outwards, as glTF has it */
    float normal_strength;      /* of its slopes: 1 */
    daft_texture bump_map;      /* heights, in green */
    float bump_strength;        /* slope where neighbouring texels differ from black to white: 1 */
    daft_texture occlusion_map; /* red: the fraction of the ambient light that reaches the place, as glTF has it */
    float occlusion_strength;   /* 0..1: of what it keeps away: 1 */
    daft_alpha_mode alpha_mode;
    float opacity; /* 0..1, what the alpha map multiplies; of a mask and a blend alone */
    float alpha_cutoff;
    daft_texture alpha_map; /* none: the alpha of `diffuse_map` */
    /* Phong shading: what it mirrors in place of what stands around it, without a ray: an image all around, as of a sky
     * (daft_scene_set_sky_image); none: the rays do. */
    daft_texture reflection_map;
} daft_material_def;

DAFT_API daft_material_def daft_default_material_def(void); /* a light grey, slightly shiny */
/* The definition is copied. Entities show what is set from the next picture on. */
DAFT_API daft_material daft_material_create(daft_scene *scene, const daft_material_def *def, daft_error *error);
DAFT_API bool daft_material_get(daft_scene *scene, daft_material material, daft_material_def *def, daft_error *error);
DAFT_API bool daft_material_set(daft_scene *scene, daft_material material, const daft_material_def *def,
                                daft_error *error);
/* What its MTL file calls it; empty: nothing does. Returns `buffer`, or NULL without a scene.
 */
DAFT_API const char *daft_material_name(const daft_scene *scene, daft_material material, char *buffer, size_t size);
/* "file.mtl": its first material. "file.mtl#name": the one with that name. */
DAFT_API daft_material daft_material_load(daft_scene *scene, const char *path, daft_error *error);

/* ---- scenes: entities -------------------------------------------------------------------------------------------- */

/* What is drawn of an entity; none: a group, or a body that is not seen. */
typedef enum daft_shape { DAFT_SHAPE_NONE = 0, DAFT_SHAPE_MESH, DAFT_SHAPE_SPHERE, DAFT_SHAPE_BOX } daft_shape;

typedef enum daft_body_kind {
    DAFT_BODY_NONE = 0,  /* not in the simulation */
    DAFT_BODY_STATIC,    /* stands still */
    DAFT_BODY_KINEMATIC, /* moved by the game; pushes, is not pushed */
    DAFT_BODY_DYNAMIC    /* moved by forces and contacts */
} daft_body_kind;

typedef enum daft_collider_kind {
    DAFT_COLLIDER_SPHERE = 1,
    DAFT_COLLIDER_CAPSULE, /* around its y axis */
    DAFT_COLLIDER_BOX,
    DAFT_COLLIDER_HULL,    /* the convex hull of a mesh's vertices, of at most 64 corners */
    DAFT_COLLIDER_MESH,    /* a mesh's triangles, from both sides; static and kinematic bodies */
    DAFT_COLLIDER_FIELD,   /* a grid of heights; static and kinematic bodies */
    DAFT_COLLIDER_CYLINDER /* around its y axis; rolls smoothly. Rays and casts meet a prism of 32 sides within it */
} daft_collider_kind;

/* A part of a body, in the entity's axes and in metres: the entity's scale counts for hulls and meshes alone. Lengths
 * are 1e-4 to 1e7 m. */
typedef struct daft_collider {
    daft_collider_kind kind;
    float radius;         /* sphere, capsule, cylinder */
    float height;         /* from end to end; capsule: more than twice the radius */
    daft_vec3 size;       /* box: edge lengths */
    daft_mesh mesh;       /* hull, mesh; none: the entity's */
    const float *heights; /* field: heights[row·columns + column] lies at x = column·spacing.x, z = row·spacing.y;
                             copied. NaN makes a hole. 2 to 16,384 columns and rows */
    uint32_t columns, rows;
    daft_vec2 spacing;  /* field: between columns, and between rows */
    daft_vec3 position; /* of the part in the entity's axes */
    daft_quat rotation;
} daft_collider;

DAFT_API daft_collider daft_default_collider(void); /* a sphere of 0.5 m */

/* Axes of the world about which a dynamic body does not turn, and along which its centre of mass does not move: bits.
 */
enum {
    DAFT_LOCK_X = 1,
    DAFT_LOCK_Y = 2,
    DAFT_LOCK_Z = 4,
    DAFT_LOCK_ROTATION = 7,
    DAFT_LOCK_POSITION_X = 8,
    DAFT_LOCK_POSITION_Y = 16,
    DAFT_LOCK_POSITION_Z = 32,
    DAFT_LOCK_POSITION = 56
};

typedef struct daft_entity_def {
    uint32_t cookie;
    daft_shape shape;
    daft_mesh mesh;         /* DAFT_SHAPE_MESH */
    float radius;           /* DAFT_SHAPE_SPHERE, metres */
    daft_vec3 size;         /* DAFT_SHAPE_BOX: full edge lengths, metres */
    daft_material material; /* none: the mesh's own, or the default material */
    daft_entity parent;     /* none: the world; position, rotation and scale are then the parent's */
    daft_dvec3 position;    /* metres */
    daft_quat rotation;     /* of any length but zero */
    daft_vec3 scale;        /* finite; spheres take only equal scales; a negative one mirrors */
    bool visible;
    bool casts_shadow; /* where all of its materials transmit, light comes through, weighted by their mean transmission
                          and tint */
    daft_body_kind body; /* entities without a parent; spheres and boxes unscaled. The scale stays as it was made */
    const daft_collider *colliders; /* what the body is made of, read by daft_entity_create; none: what is drawn, and of
                                       a mesh the hull where the body is dynamic, else the triangles */
    uint32_t collider_count;        /* up to 65,536 */
    float density;                  /* kg/m³ */
    float mass;                     /* kg; 0: from the density */
    float friction;                 /* Coulomb's coefficient; two bodies: the geometric mean */
    float static_friction;          /* of what does not slide yet; less than friction: the same */
    float restitution;              /* 0..1; two bodies: the larger */
    float rolling_resistance;       /* fraction of load times radius that brakes rolling; two bodies: the larger */
    uint32_t surface;               /* 0..63: which kind of surface, for daft_scene_set_surfaces */
    daft_vec3 surface_velocity;     /* m/s, in the entity's axes: of its surface, as a conveyor belt's */
    float gravity_scale;            /* 1 */
    float linear_damping, angular_damping; /* 1/s: fraction of the velocity lost in a second, for small ones */
    uint32_t locks;                        /* DAFT_LOCK_… */
    uint32_t layers;                       /* bits: what it is; the first by default */
    uint32_t mask; /* bits: what it collides with; two bodies do where each one's layers have a bit of the other's mask;
                      default all */
    bool sensor;   /* collides with nothing: what enters and leaves it makes events */
    bool bullet;   /* dynamic: does not pass through fast dynamic bodies either */
    bool sleeps;   /* may; default true */
    bool lights;   /* what its material gives off lights what is around; of an emission map its mean */
} daft_entity_def;

/* Nothing that is drawn, no body: at the origin, unscaled, visible. */
DAFT_API daft_entity_def daft_default_entity_def(void);
/* What the definition points to is copied. A scene holds at most 1,048,576 entities. */
DAFT_API daft_entity daft_entity_create(daft_scene *scene, const daft_entity_def *def, daft_error *error);
/* With its body and its children. */
DAFT_API bool daft_entity_destroy(daft_scene *scene, daft_entity entity, daft_error *error);
DAFT_API bool daft_entity_is_valid(const daft_scene *scene, daft_entity entity);
DAFT_API uint32_t daft_entity_count(const daft_scene *scene);
/* Writes the first `capacity` entities, in a fixed order, and returns how many there are. `out` may be NULL where
 * `capacity` is 0. */
DAFT_API uint32_t daft_scene_entities(const daft_scene *scene, daft_entity *out, uint32_t capacity);
/* As it was made and changed since, with the transform of now; its body's colliders are not told. */
DAFT_API bool daft_entity_get(daft_scene *scene, daft_entity entity, daft_entity_def *out, daft_error *error);

/* A point p of the entity lies at position + rotation·(scale·p). */
typedef struct daft_transform {
    daft_dvec3 position; /* metres */
    daft_quat rotation;  /* of any length but zero */
    daft_vec3 scale;     /* component by component */
} daft_transform;

/* Local to the parent. Setting keeps the pose of the last tick, so drawing interpolates; `teleport` drops it. */
DAFT_API bool daft_entity_get_transform(daft_scene *scene, daft_entity entity, daft_transform *out, daft_error *error);
DAFT_API bool daft_entity_set_transform(daft_scene *scene, daft_entity entity, const daft_transform *transform,
                                        bool teleport, daft_error *error);
/* Of the transform the position alone. */
DAFT_API bool daft_entity_set_position(daft_scene *scene, daft_entity entity, daft_dvec3 position, bool teleport,
                                       daft_error *error);
/* The same in the world, whatever it hangs on. Where a parent of uneven scale shears it, its own X axis keeps its
 * direction and the scale is the axes' lengths. Setting fails where a parent's scale is 0. */
DAFT_API bool daft_entity_get_world_transform(daft_scene *scene, daft_entity entity, daft_transform *out,
                                              daft_error *error);
DAFT_API bool daft_entity_set_world_transform(daft_scene *scene, daft_entity entity, const daft_transform *transform,
                                              bool teleport, daft_error *error);
/* Hangs it, with its children, on another entity; none: on the world. Its world transform stays, and with it what
 * drawing interpolates from. Fails for a body, under itself or its own children, under a parent whose scale is 0, and
 * for spheres under uneven scales. */
DAFT_API bool daft_entity_set_parent(daft_scene *scene, daft_entity entity, daft_entity parent, daft_error *error);
/* None: it has no parent, or is stale. */
DAFT_API daft_entity daft_entity_get_parent(const daft_scene *scene, daft_entity entity);
/* Writes the first `capacity` of its own children, those that came first first, and returns how many there are; 0 where
 * it is stale. `out` may be NULL where `capacity` is 0. */
DAFT_API uint32_t daft_entity_children(const daft_scene *scene, daft_entity entity, daft_entity *out,
                                       uint32_t capacity);
/* None: the mesh's own materials, or the default one. */
DAFT_API bool daft_entity_set_material(daft_scene *scene, daft_entity entity, daft_material material,
                                       daft_error *error);
/* Its children keep their own. Its body stays in the simulation. */
DAFT_API bool daft_entity_set_visible(daft_scene *scene, daft_entity entity, bool visible, daft_error *error);

/* Bodies. Velocities in m/s and rad/s, in world axes; an impulse in kg·m/s acts at once, at the centre of mass; a force
 * in N or a torque in N·m acts over the next tick only. Values are finite. Each call fails for an entity without a body
 * of the kind it needs: velocities are set of kinematic and dynamic ones, forces act on dynamic ones. */
DAFT_API bool daft_entity_get_velocity(daft_scene *scene, daft_entity entity, daft_vec3 *linear, daft_vec3 *angular,
                                       daft_error *error);
DAFT_API bool daft_entity_set_velocity(daft_scene *scene, daft_entity entity, daft_vec3 linear, daft_vec3 angular,
                                       daft_error *error);
DAFT_API bool daft_entity_apply_force(daft_scene *scene, daft_entity entity, daft_vec3 force, daft_error *error);
DAFT_API bool daft_entity_apply_impulse(daft_scene *scene, daft_entity entity, daft_vec3 impulse, daft_error *error);
DAFT_API bool daft_entity_apply_impulse_at(daft_scene *scene, daft_entity entity, daft_vec3 impulse, daft_dvec3 point,
                                           daft_error *error);
DAFT_API bool daft_entity_apply_torque(daft_scene *scene, daft_entity entity, daft_vec3 torque, daft_error *error);
/* kg·m²/s. */
DAFT_API bool daft_entity_apply_angular_impulse(daft_scene *scene, daft_entity entity, daft_vec3 impulse,
                                                daft_error *error);
/* 0: the body is not dynamic. */
DAFT_API bool daft_entity_get_mass(daft_scene *scene, daft_entity entity, float *kg, daft_error *error);
/* Bodies at rest fall asleep, island by island, and cost nothing; whatever touches or moves them wakes them. */
DAFT_API bool daft_entity_get_awake(daft_scene *scene, daft_entity entity, bool *awake, daft_error *error);
DAFT_API bool daft_entity_set_awake(daft_scene *scene, daft_entity entity, bool awake, daft_error *error);
/* Bits, as in the definition; from the next step on. */
DAFT_API bool daft_entity_set_layers(daft_scene *scene, daft_entity entity, uint32_t layers, uint32_t mask,
                                     daft_error *error);

/* Two bodies that touched in the last tick. */
typedef struct daft_contact {
    daft_entity a, b;
    daft_dvec3 point; /* in the world */
    daft_vec3 normal; /* unit, from a to b */
    float impulse;    /* kg·m/s, summed over the tick */
} daft_contact;

/* Writes the first `capacity` contacts, in a fixed order, and returns how many there are. `out` may be NULL where
 * `capacity` is 0. */
DAFT_API uint32_t daft_scene_contacts(const daft_scene *scene, daft_contact *out, uint32_t capacity);

typedef enum daft_event_kind {
    DAFT_EVENT_CONTACT_BEGIN = 1, /* point, normal, impulse, speed */
    DAFT_EVENT_CONTACT_END,
    DAFT_EVENT_TRIGGER_ENTER, /* a is the sensor; told by the step after the one at whose end they overlap */
    DAFT_EVENT_TRIGGER_LEAVE,
    DAFT_EVENT_JOINT_BREAK, /* joint; impulse: the force in N, or the torque in N·m, that broke it */
    DAFT_EVENT_JOINT_GONE,  /* with one of its bodies */
    DAFT_EVENT_SLEEP,       /* a */
    DAFT_EVENT_WAKE         /* a */
} daft_event_kind;

/* Handles of what has been destroyed since are stale. */
typedef struct daft_event {
    daft_event_kind kind;
    daft_entity a, b;
    daft_joint joint;
    daft_dvec3 point;
    daft_vec3 normal; /* from a to b */
    float impulse;    /* kg·m/s over the tick */
    float speed;      /* m/s at which they met */
} daft_event;

/* What happened in the last tick and by calls since the one before, in a fixed order: by kind, then by bodies and
 * joints. Writes the first `capacity` and returns how many there are. They are copies: the scene may be changed while
 * the caller goes through them. */
DAFT_API uint32_t daft_scene_events(const daft_scene *scene, daft_event *out, uint32_t capacity);

/* ---- scenes: animation ------------------------------------------------------------------------------------------- */

/* Clips of a mesh's file: movements of its skeleton, its parts and its morph targets. An entity that plays none stands
 * as the file has it. Clips advance with daft_scene_step; a picture shows the pose of its own time between two ticks
 * (daft_view.alpha), rays meet that of the last tick. What is posed is drawn and hit by rays; bodies keep the mesh's
 * shape at rest. A clip is not sampled where nothing that it reaches can be in the picture. */
typedef struct daft_clip_info {
    char name[128];
    double duration;     /* seconds; 0: one pose */
    daft_vec3 low, high; /* bounds, in the mesh's own space, of all that it reaches */
} daft_clip_info;

/* By its number, below daft_mesh_info.clip_count. */
DAFT_API bool daft_mesh_get_clip(daft_scene *scene, daft_mesh mesh, uint32_t clip, daft_clip_info *out,
                                 daft_error *error);
/* The first of that name. The message of a failure lists those that there are. */
DAFT_API bool daft_mesh_find_clip(const daft_scene *scene, daft_mesh mesh, const char *name, uint32_t *clip,
                                  daft_error *error);

/* The mesh that an entity shows. Fails for one that shows none. */
DAFT_API bool daft_entity_get_mesh(daft_scene *scene, daft_entity entity, daft_mesh *out, daft_error *error);

typedef struct daft_play_def {
    uint32_t cookie;
    uint32_t clip; /* number of one of the mesh's */
    float speed;   /* 1: as it was made; below 0: backwards, from its end; -1000 to 1000 */
    float blend;   /* seconds in which the clip that plays passes over into it; 0, or where none plays: at once */
    float start;   /* seconds into the clip, from the end where speed is below 0 */
    bool loop;     /* begins anew at its end; false: stays there */
    bool restart;  /* a clip that plays already begins anew; false: it goes on, with this speed */
} daft_play_def;

DAFT_API daft_play_def daft_default_play_def(void); /* the first clip, looped, at once */
/* Fails for an entity whose mesh has no such clip. */
DAFT_API bool daft_entity_play(daft_scene *scene, daft_entity entity, const daft_play_def *def, daft_error *error);
/* Back to rest, at once. Nothing happens where no clip plays. */
DAFT_API bool daft_entity_stop(daft_scene *scene, daft_entity entity, daft_error *error);

typedef struct daft_animation {
    uint32_t clip; /* the one played last */
    double time;   /* seconds into it */
    float speed;
    bool loop;
    bool playing; /* false: it has come to its end */
    float weight; /* 0..1: how far the pose has passed over into it */
} daft_animation;

/* False with error->code DAFT_OK: it plays none. */
DAFT_API bool daft_entity_get_animation(daft_scene *scene, daft_entity entity, daft_animation *out, daft_error *error);
/* Puts the clip that plays at a time: seconds, wrapped where it loops, else limited to the clip. Fails where none
 * plays.
 */
DAFT_API bool daft_entity_set_animation_time(daft_scene *scene, daft_entity entity, double seconds, daft_error *error);

/* ---- scenes: joints ---------------------------------------------------------------------------------------------- */

typedef enum daft_joint_kind {
    DAFT_JOINT_BALL = 1, /* two points stay together */
    DAFT_JOINT_HINGE,    /* and so do two axes; angles in radians */
    DAFT_JOINT_SLIDER,   /* moves along an axis, does not turn; metres */
    DAFT_JOINT_DISTANCE, /* keeps two points `length` apart, or between lower and upper: a rod, rope or spring */
    DAFT_JOINT_FIXED,    /* does not move */
    DAFT_JOINT_DRAG      /* draws a point of b to a target, softly */
} daft_joint_kind;

typedef struct daft_joint_def {
    uint32_t cookie;
    daft_joint_kind kind;
    daft_entity a, b;    /* with bodies, one of them dynamic; a: none is the world itself (drag: always) */
    daft_dvec3 anchor;   /* in the world, as the bodies stand now; distance: the point on a; drag: on b */
    daft_dvec3 anchor_b; /* distance: the point on b; drag: the target */
    daft_vec3 axis;      /* hinge, slider, ball with a cone: in the world, any length */
    bool limit;          /* hinge, slider, distance: between lower and upper; ball: upper is the cone's half angle */
    float lower, upper;  /* relative to the pose at creation; hinge: radians within ±pi; slider: metres; distance:
                            lengths */
    bool motor;          /* hinge, slider; ball: a brake, whose speed is always 0 */
    float motor_speed, motor_force; /* rad/s and N·m, m/s and N; of b relative to a */
    bool spring;          /* distance: about its length; hinge, slider: about 0; ball, fixed: the whole joint gives */
    float hertz, damping; /* of the spring: frequency of the two bodies on it, and damping ratio */
    float length;         /* distance: 0 takes what it is now */
    float break_force, break_torque; /* N, N·m, mean over a tick; 0: never */
    bool collide;                    /* the two bodies touch each other still */
} daft_joint_def;

typedef struct daft_joint_state {
    daft_joint_kind kind;
    daft_entity a, b;
    daft_dvec3 anchor_a, anchor_b; /* in the world */
    float value;                   /* hinge: angle; slider: displacement; distance: length; ball with a cone: angle */
    float speed;                   /* of the value; hinge, slider */
    float force, torque;           /* N, N·m, mean over the last tick */
} daft_joint_state;

/* A ball joint to the world; springs of 2 Hz, damping ratio 0.7. */
DAFT_API daft_joint_def daft_default_joint_def(void);
/* Fails where neither body is dynamic, and for limits that cross. A scene holds at most 1,048,576 joints. */
DAFT_API daft_joint daft_joint_create(daft_scene *scene, const daft_joint_def *def, daft_error *error);
DAFT_API bool daft_joint_destroy(daft_scene *scene, daft_joint joint, daft_error *error);
DAFT_API bool daft_joint_is_valid(const daft_scene *scene, daft_joint joint); /* not broken, not gone with a body */
DAFT_API bool daft_joint_get(daft_scene *scene, daft_joint joint, daft_joint_state *out, daft_error *error);
/* Units and ranges as in the definition: speed in m/s or rad/s, force in N or N·m, 0 or more; limits in m or radians;
 * hertz 0 or more, damping a ratio of 0 or more. Fails for a joint that is gone. */
DAFT_API bool daft_joint_set_motor(daft_scene *scene, daft_joint joint, bool on, float speed, float force,
                                   daft_error *error);
DAFT_API bool daft_joint_set_limit(daft_scene *scene, daft_joint joint, bool on, float lower, float upper,
                                   daft_error *error);
DAFT_API bool daft_joint_set_spring(daft_scene *scene, daft_joint joint, bool on, float hertz, float damping,
                                    daft_error *error);
/* Of a drag joint: where it draws the point to, in the world. */
DAFT_API bool daft_joint_set_target(daft_scene *scene, daft_joint joint, daft_dvec3 target, daft_error *error);

/* ---- scenes: the simulation as a whole --------------------------------------------------------------------------- */

/* Substeps of each step, 1 to 16, default 4: more cost more, and stretch, sink and drift less. This and the dt of
 * daft_scene_step are the knobs of the simulation: unlike those of daft_quality they change the state. */
DAFT_API bool daft_scene_set_substeps(daft_scene *scene, int substeps, daft_error *error);
DAFT_API void daft_scene_set_sleeping(daft_scene *scene, bool allowed); /* default true */

/* How well the simulation holds, as the last step left it. */
typedef struct daft_sim_measure {
    double energy;      /* J: of all dynamic bodies, kinetic and, from the world's origin, potential */
    double penetration; /* m: the deepest overlap of two bodies that the last step found */
    double joint_gap; /* m: the farthest that what a joint keeps together is apart; springs and sliders do not count */
} daft_sim_measure;

/* Looks at every body, contact and joint: for tests and reports. All 0 where there are no bodies. */
DAFT_API bool daft_scene_measure_sim(daft_scene *scene, daft_sim_measure *out, daft_error *error);
/* Writes the first `capacity` entities with dynamic or kinematic bodies, and returns how many there are. `out` may be
 * NULL where `capacity` is 0. */
DAFT_API uint32_t daft_scene_moving(const daft_scene *scene, daft_entity *out, uint32_t capacity);

/* What counts where two kinds of surface meet, in place of what their bodies say. Kinds are 0..63 and may be equal. */
typedef struct daft_surfaces { /* ranges as in daft_entity_def */
    float friction, static_friction, restitution, rolling_resistance;
} daft_surfaces;
/* `together` NULL: what the bodies say counts again. */
DAFT_API bool daft_scene_set_surfaces(daft_scene *scene, uint32_t kind_a, uint32_t kind_b,
                                      const daft_surfaces *together, daft_error *error);

/* The state of all bodies, joints and characters as bytes: loaded into the same scene, with the same entities, it goes
 * on with the same bits. Writes them where `capacity` is enough, and returns how many there are; 0: failed. They are
 * for this build alone. */
DAFT_API size_t daft_scene_save_bodies(const daft_scene *scene, void *out, size_t capacity, daft_error *error);
/* Fails for bytes that are damaged and where entities with bodies or characters have come or gone; joints come back as
 * they were. */
DAFT_API bool daft_scene_load_bodies(daft_scene *scene, const void *bytes, size_t size, daft_error *error);

/* Of the last tick. */
typedef struct daft_sim_counters {
    uint32_t bodies, awake;   /* awake: dynamic ones */
    uint32_t joints, islands; /* islands: groups of awake bodies that touch or are joined */
    uint32_t pairs, contacts; /* pairs of parts whose bounds meet, and that touch */
    uint32_t rows;            /* constraints solved in each substep */
    uint32_t colours;         /* groups of constraints that share no body, so that they are solved side by side */
    uint32_t substeps;        /* the most of any island; 0: nothing was solved */
    uint32_t sweeps;          /* searches for the time of an impact */
} daft_sim_counters;
DAFT_API daft_sim_counters daft_scene_sim_counters(const daft_scene *scene);

/* How long the stages of the last step took, in milliseconds, one after the other; all 0 where nothing moved. */
typedef struct daft_sim_times {
    double broad;    /* which parts are near each other */
    double contacts; /* where they touch, and which islands that makes */
    double solve;    /* the substeps */
    double sweep;    /* of what is fast; then bodies are placed */
    double events;   /* contacts and events are told; islands fall asleep */
} daft_sim_times;
DAFT_API daft_sim_times daft_scene_sim_times(const daft_scene *scene);

/* An edge of a body's shape as the simulation has it, for pictures of it. */
typedef struct daft_body_edge {
    daft_dvec3 from, to; /* in the world */
    daft_entity entity;
    daft_body_kind kind;
    bool awake, sensor;
} daft_body_edge;
/* Edges of bodies whose bounds meet the ball about `centre`, in a fixed order; of meshes and height fields only those
 * of triangles that meet its bounds. Round shapes are circles of 24 edges. Writes the first `capacity`, and returns how
 * many there are. `out` may be NULL where `capacity` is 0. */
DAFT_API uint32_t daft_scene_body_edges(const daft_scene *scene, daft_dvec3 centre, float radius, daft_body_edge *out,
                                        uint32_t capacity);

/* ---- scenes: camera, lights, sky --------------------------------------------------------------------------------- */

/* yaw 0 looks along +X, positive yaw turns right (towards +Z), positive pitch looks down, positive roll leans right. */
typedef struct daft_camera {
    daft_dvec3 position;    /* metres */
    float yaw, pitch, roll; /* radians, -1e6 to 1e6 */
    float fov;              /* horizontal, radians, 0 < fov < pi */
} daft_camera;

DAFT_API daft_camera daft_default_camera(void); /* at the origin, fov 90 degrees */
/* Level, at `from`, looking at `at`; along +X where the two are one point or not finite. fov: radians. */
DAFT_API daft_camera daft_camera_look_at(daft_dvec3 from, daft_dvec3 at, float fov);
/* The direction, of length 1, in which a point of the camera's picture lies: x and y go from 0, 0 in the upper left
 * corner to 1, 1; `aspect` is the picture's height over its width. */
DAFT_API daft_vec3 daft_camera_ray(const daft_camera *camera, double x, double y, double aspect);
/* The cameras that scene files name and programs add, in order; the first is the one that is set. */
DAFT_API uint32_t daft_scene_camera_count(const daft_scene *scene);
DAFT_API bool daft_scene_get_camera(const daft_scene *scene, uint32_t index, daft_camera *out, daft_error *error);
/* One more behind these. */
DAFT_API bool daft_scene_add_camera(daft_scene *scene, const daft_camera *camera, daft_error *error);
/* The camera in use, interpolated between the last two ticks (alpha 1: now). */
DAFT_API daft_camera daft_scene_camera(const daft_scene *scene, float alpha);
/* `teleport`: pictures do not glide to it from the last tick's. */
DAFT_API bool daft_scene_set_camera(daft_scene *scene, const daft_camera *camera, bool teleport, daft_error *error);

/* A checkpoint of a camera path: where the camera is, `time` seconds into it. */
typedef struct daft_checkpoint {
    daft_camera camera;
    double time; /* after that of the checkpoint before */
} daft_checkpoint;

typedef enum daft_pace {
    DAFT_PACE_TIMED = 0, /* at each checkpoint at its time */
    DAFT_PACE_CONSTANT,  /* the same speed all the way; only the first and the last time count */
    DAFT_PACE_EASED      /* slowly off, and slowly to the end; only the first and the last time count */
} daft_pace;

/* The camera at `time` seconds on a smooth curve through the checkpoints: before the first it stands there, after the
 * last it stands there. Positions and the field of view follow a Catmull-Rom curve, rotations the shorter way round
 * without a gimbal's flips; the roll may therefore differ from 0 between checkpoints that have none. Fails where times
 * do not ascend. */
DAFT_API bool daft_path_camera(const daft_checkpoint *points, uint32_t count, daft_pace pace, double time,
                               daft_camera *out, daft_error *error);
/* The checkpoints that a scene file names, in its order. */
DAFT_API uint32_t daft_scene_path_count(const daft_scene *scene);
DAFT_API bool daft_scene_get_checkpoint(const daft_scene *scene, uint32_t index, daft_checkpoint *out,
                                        daft_error *error);

/* An entity that a scene file names. */
typedef struct daft_named_entity {
    const char *name; /* lives as long as the scene */
    daft_entity entity;
} daft_named_entity;

/* In the order of the files. Two may have the same name, and one may have been destroyed since. */
DAFT_API uint32_t daft_scene_named_count(const daft_scene *scene);
DAFT_API bool daft_scene_get_named(const daft_scene *scene, uint32_t index, daft_named_entity *out, daft_error *error);

typedef enum daft_light_kind {
    DAFT_LIGHT_POINT = 0,
    DAFT_LIGHT_SUN,
    DAFT_LIGHT_SPOT,
    DAFT_LIGHT_RECTANGLE /* lights on one side; not seen itself */
} daft_light_kind;

typedef struct daft_light_def {
    uint32_t cookie;
    daft_light_kind kind;
    daft_dvec3 position; /* point and spot: where; rectangle: its middle */
    daft_vec3 direction; /* sun, spot and rectangle: where its light travels to, a spot's along its axis, a rectangle's
                            straight off it; any length but zero */
    daft_vec3 color;     /* linear light, 0 or more; 1 lights a white surface that faces it white. Rectangle: its
                            radiance, as `emission` of materials; it falls with distance and angle as area does */
    bool casts_shadow;
    /* Spot: radians from the direction, 0 <= inner_angle <= outer_angle <= pi, outer_angle > 0. All of the light within
     * the inner angle, none beyond the outer; between, a cubic of the angle's cosine (Pharr, Jakob, Humphreys,
     * "Physically Based Rendering", 4th edition, 12.2.1). Default pi/8 and pi/6. */
    float inner_angle, outer_angle;
    /* Sizes, for soft shadows; 0: the light is a point, and its shadows are sharp. Point and spot: metres; sun:
     * radians, half the angle that its disc spans (the real one has 0.00465), up to pi/4. */
    float radius, disc;
    /* All but suns: metres to where its light ends; on the way it falls as (1 - (distance / range)^2)^2. 0: it is
     * equally bright at any distance, but for a rectangle. A light that reaches nothing in sight costs next to nothing.
     */
    float range;
    /* Point and spot: its light falls with the square of the distance, and `color` is what it has at a metre; with a
     * range times 1 - (distance / range)^4, as glTF has it. Nearer than a centimetre it is as bright as there. */
    bool inverse_square;
    bool visible; /* sun: its disc is seen in the sky, of 16 times its colour at most */
    /* Rectangle: metres, its width and height, each 1e-6 or more, default 1 and 1. The width is level (along x where
     * `direction` is up or down), until `turn` turns both about the direction, radians, from the width to the height.
     */
    daft_vec2 size;
    float turn;
} daft_light_def;

/* A white point light at the origin that casts shadows. */
DAFT_API daft_light_def daft_default_light_def(void);
/* A scene holds at most 1,048,576 lights. */
DAFT_API daft_light daft_light_create(daft_scene *scene, const daft_light_def *def, daft_error *error);
DAFT_API bool daft_light_get(daft_scene *scene, daft_light light, daft_light_def *def, daft_error *error);
DAFT_API bool daft_light_set(daft_scene *scene, daft_light light, const daft_light_def *def, daft_error *error);
DAFT_API bool daft_light_destroy(daft_scene *scene, daft_light light, daft_error *error);

/* Cameras and lights of a mesh's file, by their numbers below daft_mesh_info's counts. Nothing adds them to the scene
 * but daft_scene_add_camera and daft_light_create. `at` is where the mesh stands: NULL, or at the origin, in its own
 * axes. Lights of glTF files are photometric, and a white surface sends on a pi-th of what it gets: `color` is the
 * light's colour times its lux / pi (sun) or candela / pi (point and spot, inverse_square). Those of other formats are
 * what they say, and fall where they decay with the square of the distance. Sizes of lights do not grow with `at`. */
typedef struct daft_mesh_camera {
    char name[128];
    daft_camera camera; /* fov: of a picture with the camera's own aspect ratio, or 16:9 where it has none */
} daft_mesh_camera;

typedef struct daft_mesh_light {
    char name[128];
    daft_light_def light;
} daft_mesh_light;

DAFT_API bool daft_mesh_get_camera(daft_scene *scene, daft_mesh mesh, uint32_t index, const daft_transform *at,
                                   daft_mesh_camera *out, daft_error *error);
DAFT_API bool daft_mesh_get_light(daft_scene *scene, daft_mesh mesh, uint32_t index, const daft_transform *at,
                                  daft_mesh_light *out, daft_error *error);

/* Colours in linear light, finite and 0 or more. The calls without an error warn about others, and change nothing. */
DAFT_API void daft_scene_set_ambient(daft_scene *scene, daft_vec3 color); /* light from everywhere; default 0.2 grey */
/* Ambient occlusion: what stands within so many metres of a surface keeps ambient light away from it. 0, the default:
 * nothing does. */
DAFT_API void daft_scene_set_ambient_occlusion(daft_scene *scene, float distance);
/* The sky's own light in place of that colour: `strength` (0 to 1e6) times what a white surface sends on of all the sky
 * above it, to second order in spherical harmonics (Ramamoorthi and Hanrahan, "An Efficient Representation for
 * Irradiance Environment Maps", 2001). 0, the default: the colour, which daft_scene_set_ambient goes back to. Follows
 * the sky as it changes; occlusion keeps it away as it does the colour. */
DAFT_API void daft_scene_set_ambient_sky(daft_scene *scene, float strength);

/* Fog: light from what is seen is lost on its way by exp(-optical depth), and the fog's own colour takes its place. */
typedef struct daft_fog {
    daft_vec3 color;
    float density; /* 1/m, at `base` and, where `height` is 0, everywhere: exp(-density * metres) is left; 0: no fog */
    float height;  /* metres over which it thins to 1/e; 0: it is equally dense everywhere, and hides all of the sky */
    float base;    /* metres, of the world's y */
    float glow;    /* 0 to 1: towards the first sun the fog has this much of its colour */
} daft_fog;

DAFT_API daft_fog daft_default_fog(void); /* grey, of density 0 */
DAFT_API bool daft_scene_set_fog(daft_scene *scene, const daft_fog *fog, daft_error *error);
DAFT_API daft_fog daft_scene_fog(const daft_scene *scene);

DAFT_API void daft_scene_set_sky_color(daft_scene *scene, daft_vec3 color);
DAFT_API void daft_scene_set_sky_gradient(daft_scene *scene, daft_vec3 zenith, daft_vec3 horizon);
/* One equirectangular image; u = 0.5 + atan2(dz, dx)/2pi, v = 0.5 + asin(dy)/pi, v = 1 the top row. A Radiance file
 * (.hdr) keeps its linear light, also above 1; other images are sRGB. */
DAFT_API bool daft_scene_set_sky_image(daft_scene *scene, const char *path, daft_error *error);
/* Six square images of one size, up to 8192 pixels a side, in the order right, left, top, bottom, front, back (most
 * sets name them px nx py ny pz nz), each as it is seen from within: front towards -Z, right towards +X, the lower edge
 * of top and the upper edge of bottom beside front. */
DAFT_API bool daft_scene_set_sky_cube(daft_scene *scene, const char *const paths[6], daft_error *error);

/* What a picture makes of light before it is shown: the last step, for the whole picture. */
typedef enum daft_tone_curve {
    DAFT_TONE_NONE = 0, /* what is brighter than white is white */
    DAFT_TONE_ACES,     /* contrasty; bright colours turn white late: Narkowicz's fit of the ACES filmic curve (2015) */
    DAFT_TONE_AGX       /* soft; bright colours fade to white: Sobotka's AgX, as Wrensch fits it (2023) */
} daft_tone_curve;

typedef struct daft_exposure {
    float ev;       /* stops, -24 to 24: light is times 2^ev; automatic: so much brighter than it would be */
    bool automatic; /* light is metered: the picture's mean of log2 luminance becomes middle grey, 0.18 */
    daft_tone_curve curve;
} daft_exposure;

DAFT_API daft_exposure daft_default_exposure(void); /* off: 0 stops, no curve */
DAFT_API bool daft_scene_set_exposure(daft_scene *scene, const daft_exposure *exposure, daft_error *error);
DAFT_API daft_exposure daft_scene_exposure(const daft_scene *scene);

/* ---- time -------------------------------------------------------------------------------------------------------- */

DAFT_API void daft_scene_set_gravity(daft_scene *scene, daft_vec3 gravity); /* m/s², default 0, -9.81, 0 */
/* One tick is: begin_tick (remembers poses for interpolation), the game's own changes, then step (moves bodies). dt:
 * seconds, above 0 and at most 1; always the same one for the same results. */
DAFT_API void daft_scene_begin_tick(daft_scene *scene);
DAFT_API bool daft_scene_step(daft_scene *scene, float dt, daft_error *error);
/* 64 bits over every entity and what it plays, body, light and the camera: equal states, equal hashes. */
DAFT_API uint64_t daft_scene_hash(const daft_scene *scene);
DAFT_API uint64_t daft_hash(const void *bytes, size_t size, uint64_t seed); /* FNV-1a */

/* ---- quality: what a picture may cost ---------------------------------------------------------------------------- */

/* The presets are rows of one table, engine/render/presets.c. */
typedef enum daft_preset {
    DAFT_PRESET_DRAFT = 0, /* one sample, no shadows, no reflections, through six surfaces that transmit */
    DAFT_PRESET_GAME,      /* one sample and four at edges, shadows, reflections two deep, through twelve surfaces */
    DAFT_PRESET_HIGH,      /* sixteen samples at edges, reflections six deep, through sixteen surfaces */
    DAFT_PRESET_REFERENCE  /* sixteen samples, every camera ray alone through the BVH, reflections ten deep, through 24
                            */
} daft_preset;

/* "draft", "game", "high", "reference"; false for other names. */
DAFT_API bool daft_preset_parse(const char *name, daft_preset *out);
DAFT_API const char *daft_preset_name(daft_preset preset);

/* How rays and triangles meet; what each costs is measured by `daft bench --only intersection`. */
typedef enum daft_intersection {
    DAFT_INTERSECT_EXACT = 0,  /* the true answer for the vertices as they are: no cracks, no double hits */
    DAFT_INTERSECT_WATERTIGHT, /* floats alone, but the same ones for both triangles at an edge: cracks at vertices only
                                */
    DAFT_INTERSECT_FAST        /* floats alone: a few rays slip through along edges */
} daft_intersection;

/* "exact", "watertight", "fast"; false for other names. */
DAFT_API bool daft_intersection_parse(const char *name, daft_intersection *out);
DAFT_API const char *daft_intersection_name(daft_intersection intersection);

/* What camera rays are found by; all give the same picture. */
typedef enum daft_tree {
    DAFT_TREE_RASTER = 0, /* projected bounds say which rays are tested against what; rays that share no origin take the
                             BVH */
    DAFT_TREE_BVH,        /* each camera ray alone through the BVH */
    DAFT_TREE_KDTREE      /* each camera and mirrored ray alone through kd-trees, built by the first such picture */
} daft_tree;

/* What a texture's colour at a point is made of. */
typedef enum daft_texture_filter {
    DAFT_TEXTURE_TRILINEAR = 0, /* two levels of the mip map, four texels of each */
    DAFT_TEXTURE_MIPMAP,        /* the nearest level, four texels */
    DAFT_TEXTURE_BILINEAR,      /* the finest level, four texels */
    DAFT_TEXTURE_NEAREST,       /* the finest level, one texel */
    DAFT_TEXTURE_ANISOTROPIC4,  /* trilinear, as sharp as the pixel's shorter side on the surface allows: up to four
                                   times along the longer one */
    DAFT_TEXTURE_ANISOTROPIC16  /* the same, up to sixteen times */
} daft_texture_filter;

/* How a picture that is drawn smaller is enlarged to its target. */
typedef enum daft_upscale {
    DAFT_UPSCALE_BILINEAR = 0,
    DAFT_UPSCALE_BICUBIC, /* Catmull and Rom: sharper, within the four neighbours' range */
    DAFT_UPSCALE_NEAREST
} daft_upscale;

/* The knobs: what a picture costs and how exact it is. They never change the scene or the simulation, whose own knobs
 * are daft_scene_set_substeps and the dt of daft_scene_step. The names are the same in C, in daft.quality { } of Lua,
 * in the `quality` item of .scene files, and on the command line (--knobs). What each costs is measured by
 * `daft cost`. */
typedef struct daft_quality {
    float scale;          /* sides of the drawn picture relative to its target, 0.1 to 1; below 1 a view has no band and
                             no channels */
    daft_upscale upscale; /* where scale is below 1 */
    daft_intersection visibility;
    daft_tree tree;
    int samples;         /* per pixel: 1, 4, 8 or 16 */
    int edge_samples;    /* more where a pixel differs from its neighbours: 0; 4, its corners, at outlines and creases;
                            16, at edges of shadows and in mirrors, too, and trilinear textures become anisotropic4 */
    float edge_contrast; /* times the usual contrast from which pixels get these, 0.25 to 4; below 1 fainter edges get
                            some, and strong ones more of the 16 */
    bool shadows;        /* of every light */
    int shadow_samples;  /* rays of a point to each light that has a size, 1 to 64; of more than six lights, to those
                          * that are drawn for it; 0: shadows are sharp */
    int occlusion_samples; /* rays around each point for ambient occlusion, 1 to 64; 0: none */
    int mirror_depth;      /* mirror bounces followed, 0 to 32 */
    int refraction_depth;  /* surfaces that a path which passes through some may meet, 0 to 32 */
    float min_weight;      /* mirrored or refracted rays that weigh less in all colours are not cast, 0 to 1 */
    int glossy_samples;    /* rays that a rough surface sends on, 1 to 64; 0: none is rough */
    daft_texture_filter texture_filter;
    bool denoise;    /* filters what is sampled */
    bool half_light; /* where that is so, sampled shadows and occlusion are found for one pixel in four */
} daft_quality;

/* The values of a preset; of none, those of DAFT_PRESET_GAME. */
DAFT_API daft_quality daft_preset_quality(daft_preset preset);
/* What the scene asks for: by default DAFT_PRESET_GAME's, or what the `quality` item of a .scene file says. It is a
 * wish for whoever draws the scene: daft_render goes by the view. Not part of the state's hash. */
DAFT_API bool daft_scene_set_quality(daft_scene *scene, const daft_quality *quality, daft_error *error);
DAFT_API daft_quality daft_scene_quality(const daft_scene *scene);

/* ---- rendering --------------------------------------------------------------------------------------------------- */

/* What a pixel's first sample saw, but for color and cost. All arrays are the caller's, width·height long, and may be
 * NULL. */
typedef struct daft_aov {
    float *depth;        /* distance along the ray, metres; infinity where the sky is */
    daft_vec3 *normal;   /* shading normal, world axes; zero where the sky is */
    daft_entity *entity; /* none where the sky is */
    uint32_t *triangle;  /* of the entity's mesh; 0 for spheres */
    daft_vec3 *color;    /* linear light, not limited to 1: the mean of all samples but those at edges */
    daft_vec3 *albedo;   /* the surface's own colour, linear: diffuse times texture; zero where the sky is */
    /* How far, in pixels to the right and down, what is seen has moved since the last picture of daft_view.history;
     * zero without one, and where that picture had it behind the camera. */
    daft_vec2 *motion;
    uint32_t *cost; /* rays that were cast for the pixel: camera, edges, shadows, mirrors, glass */
} daft_aov;

/* What a series of pictures of a scene remembers of the last one: where the camera and entities were. */
typedef struct daft_history daft_history;

/* Of nothing yet. Owned by the caller, who destroys it before the engine. NULL: see the error. */
DAFT_API daft_history *daft_history_create(daft_engine *engine, daft_error *error);
DAFT_API void daft_history_destroy(daft_history *history); /* NULL is fine */
/* After a cut: the next picture has none before it. */
DAFT_API void daft_history_forget(daft_history *history);

/* Parts of the shading that a picture can go without, to see the others: bits of daft_view.without. Shadows and mirrors
 * have knobs of their own. */
enum {
    DAFT_WITHOUT_SHADING = 1, /* no light: surfaces in their own colour, `diffuse` times the texture */
    DAFT_WITHOUT_AMBIENT = 2, /* the ambient light */
    DAFT_WITHOUT_DIFFUSE = 4,
    DAFT_WITHOUT_SPECULAR = 8,  /* highlights */
    DAFT_WITHOUT_TEXTURES = 16, /* of surfaces; the sky stays */
    DAFT_WITHOUT_ALL = 31
};

typedef struct daft_view {
    uint32_t cookie;
    daft_camera camera;
    float alpha;          /* between the last two ticks: 0 the one before, 1 now */
    daft_quality quality; /* the knobs: daft_preset_quality(…), or that with single values changed */
    int first_row;        /* draws a band of the picture: a multiple of 32 */
    int row_count;        /* of the band; a multiple of 32 or up to the last row; 0: from first_row to the last */
    uint32_t without;     /* DAFT_WITHOUT_…; 0: the whole picture */
    daft_aov aov;
    /* Drawing a whole picture, no band, makes it the last one; of a picture without channels by the same camera only
     * tiles are drawn that a change may reach, unless `full` asks for all. NULL: none. */
    daft_history *history;
    bool full;
    bool (*progress)(void *user, float done); /* done 0..1; return false to stop; called from the calling thread */
    void *progress_user;
} daft_view;

DAFT_API daft_view daft_default_view(void); /* the default camera, quality game */
/* Draws the view over the whole target, whose size (1 to 16,384 a side) is the picture's, or over the view's band of
 * it: the rest of target and AOVs stays as it is. Bands together are the picture, byte for byte. DAFT_ERROR_CANCELLED
 * where `progress` returned false: target and AOVs then hold parts of the picture. */
DAFT_API bool daft_render(daft_scene *scene, const daft_view *view, daft_image *target, daft_error *error);

/* ---- ray queries ------------------------------------------------------------------------------------------------- */

typedef struct daft_ray_hit {
    daft_entity entity;
    uint32_t triangle;      /* of the entity's mesh; 0 for spheres */
    daft_material material; /* of the surface; none: the default one */
    float distance;         /* metres along the normalised direction */
    daft_dvec3 position;
    daft_vec3 normal; /* geometric, towards the ray's origin */
    daft_vec2 uv;     /* texture coordinates; 0 where there are none */
} daft_ray_hit;

/* The nearest hit of a visible entity within max_distance metres, which may be infinite. The direction has any length
 * but zero. `ignore` may be none. False with error->code DAFT_OK: a
 * miss. */
DAFT_API bool daft_scene_cast_ray(daft_scene *scene, daft_dvec3 origin, daft_vec3 direction, float max_distance,
                                  daft_entity ignore, daft_ray_hit *hit, daft_error *error);

/* The corners of the box around all visible entities, which it touches or exceeds. False with error->code DAFT_OK:
 * there is none. */
DAFT_API bool daft_scene_get_bounds(daft_scene *scene, daft_dvec3 *low, daft_dvec3 *high, daft_error *error);

/* ---- scans ------------------------------------------------------------------------------------------------------- */

/* What a laser scanner (lidar) measures: for each of its rays, how far it goes to what is drawn. Rays are found
 * exactly, as by daft_scene_cast_ray, many at a time on all threads. */

typedef enum daft_scan_pattern {
    DAFT_SCAN_SPINNING = 0, /* `rows` beams one above the other turn once round in `columns` steps; ray number
                               column * rows + row */
    DAFT_SCAN_GRID,         /* rows by columns over a field of view, row by row; ray number row * columns + column */
    DAFT_SCAN_RAYS          /* the list `rays` */
} daft_scan_pattern;

typedef struct daft_scan_def {
    uint32_t cookie;
    daft_scan_pattern pattern;
    uint32_t rows, columns; /* 1 to 4,096 and 1 to 65,536; at most 268,435,456 rays in all */
    float bottom, top;      /* radians: the elevation of row 0 and of the last row */
    float left, right;      /* grid: radians of column 0 and of the last column; 0 is forward, positive to the right */
    const daft_vec3 *rays;  /* directions in the sensor's axes, any length but zero */
    uint32_t ray_count;     /* of the list */
    daft_dvec3 position;    /* of the sensor, as the scan begins, metres */
    daft_quat rotation;     /* its axes then: +X looks forward, +Y up, +Z right */
    daft_vec3 velocity;     /* m/s */
    daft_vec3 spin;         /* rad/s about a world axis */
    float duration;         /* seconds: columns (spinning), rows (grid) and rays of a list leave one after the other */
    float min_range, max_range; /* metres; what is nearer or farther sends nothing back */
    float range_noise;          /* metres: standard deviation of a Gaussian error */
    float drop_out;             /* 0..1: the share of returns that get lost */
    uint64_t seed;              /* of both: the same seed, the same errors */
    daft_entity ignore;         /* passed through, the robot itself for example; or none */
} daft_scan_def;

/* 64 beams from 25 degrees below the horizon to 15 above, 2,048 columns in 0.1 s, 0.3 m to 120 m, no errors. */
DAFT_API daft_scan_def daft_default_scan_def(void);
/* How many rays; 0 where the definition is refused. */
DAFT_API uint32_t daft_scan_size(const daft_scan_def *def);
/* A ray as it leaves: a return at `range` lies at origin + range * direction. Each pointer may be NULL. */
DAFT_API bool daft_scan_ray(const daft_scan_def *def, uint32_t index, daft_dvec3 *origin, daft_vec3 *direction,
                            double *seconds, daft_error *error);

typedef struct daft_scan_return {
    float range;     /* metres along the ray; 0: nothing came back */
    float intensity; /* luminance of what the surface scatters times the cosine of the angle to its normal: 1 is white,
                        met square on; free of distance, as sensors calibrate it */
    daft_entity entity;
    uint32_t triangle; /* of the entity's mesh; 0 for spheres */
} daft_scan_return;

/* Writes daft_scan_size(def) returns to `first`: of the nearest surface; and where `last` is not NULL, the last one
 * that a ray reaches through surfaces that transmit light, which it crosses straight on. */
DAFT_API bool daft_scan(daft_scene *scene, const daft_scan_def *def, daft_scan_return *first, daft_scan_return *last,
                        daft_error *error);

/* ---- queries of bodies ------------------------------------------------------------------------------------------- */

/* Rays, moving shapes, volumes and points against the bodies of the simulation, as they are now, visible or not.
 * Answers are in double: as good 1e7 m from the origin as at it. Distances beyond 1e9 m count as that. */

typedef struct daft_query_filter {
    uint32_t cookie;
    bool statics, kinematics, dynamics; /* which kinds of bodies are met */
    bool sensors;                       /* whether sensors are met as well */
    uint32_t layers, mask; /* as between two bodies: each side's layers must have a bit of the other's mask */
    daft_entity ignore;    /* none, or one to pass through */
} daft_query_filter;

DAFT_API daft_query_filter daft_default_query_filter(void); /* every body but sensors */

typedef struct daft_query_hit {
    daft_entity entity;
    uint32_t triangle; /* of a mesh or height field; 0 for other shapes */
    daft_dvec3 position;
    daft_vec3 normal; /* unit, of the surface, towards the ray or volume; zero where an overlap defines none */
    float distance;   /* metres along the motion, or from the point */
    bool inside;      /* it began inside, or overlapping: distance 0 */
} daft_query_hit;

/* A box of `size`, or with a radius a sphere, or with a height as well a capsule along y, `height` in all. */
typedef struct daft_volume {
    uint32_t cookie;
    daft_vec3 size;       /* metres: a box's edge lengths */
    float radius, height; /* metres; 0: none */
    daft_quat rotation;   /* in the world */
} daft_volume;

DAFT_API daft_volume daft_default_volume(void); /* a box of 1 m */

/* `filter` may be NULL: the default. False with error->code DAFT_OK: a miss. Of equally near ones the older body
 * counts. */
DAFT_API bool daft_query_ray(daft_scene *scene, daft_dvec3 origin, daft_vec3 direction, float max_distance,
                             const daft_query_filter *filter, daft_query_hit *hit, daft_error *error);
/* The nearest hit of each body's shapes, in order; the first `capacity` of them. Gives how many there are. */
DAFT_API uint32_t daft_query_ray_all(daft_scene *scene, daft_dvec3 origin, daft_vec3 direction, float max_distance,
                                     const daft_query_filter *filter, daft_query_hit *hits, uint32_t capacity,
                                     daft_error *error);
/* A volume that moves without turning (conservative advancement; Mirtich 1996, van den Bergen 2004). */
DAFT_API bool daft_query_cast(daft_scene *scene, const daft_volume *volume, daft_dvec3 origin, daft_vec3 direction,
                              float max_distance, const daft_query_filter *filter, daft_query_hit *hit,
                              daft_error *error);
/* The bodies that a volume overlaps, oldest first: entity and inside are set. */
DAFT_API uint32_t daft_query_overlap(daft_scene *scene, const daft_volume *volume, daft_dvec3 position,
                                     const daft_query_filter *filter, daft_query_hit *hits, uint32_t capacity,
                                     daft_error *error);
/* The nearest point of any body. */
DAFT_API bool daft_query_closest(daft_scene *scene, daft_dvec3 point, float max_distance,
                                 const daft_query_filter *filter, daft_query_hit *hit, daft_error *error);

/* ---- characters -------------------------------------------------------------------------------------------------- */

/* A capsule that walks about: it climbs steps and slopes up to its limits, slides along walls, follows the ground
 * downwards, rides what it stands on, jumps, and pushes dynamic bodies with a bounded force. It does not pass through
 * what stands still, however fast it is. It is no body: bodies feel it only through its pushes and its weight.
 * Characters move at the end of daft_scene_step, oldest first. (Collide and slide: Catto, Box2D v3.1; steps: Rouwe,
 * Jolt Physics.) */
/* clang-format off */
typedef struct daft_character { uint32_t id; } daft_character;
/* clang-format on */

typedef struct daft_character_def {
    uint32_t cookie;
    daft_dvec3 position;    /* of the capsule's centre */
    float radius, height;   /* metres; height: the whole, at least twice the radius */
    float step_height;      /* what it climbs without a jump, at most half its height */
    float max_slope;        /* radians from level, 0 to 1.5: steeper ground is slid down */
    float acceleration;     /* m/s² with which it takes up the speed it is asked for, on the ground */
    float air_acceleration; /* the same in the air */
    float gravity_scale;    /* of the scene's gravity along y */
    float mass;             /* kg */
    float push_force;       /* N: the most it pushes bodies with */
    uint32_t layers, mask;
    daft_entity entity; /* none, or one that goes where the character goes; its own body is not in the way */
} daft_character_def;

/* 0.3 m in radius, 1.8 m high, climbs 0.35 m and 50 degrees, 80 kg, 400 N. */
DAFT_API daft_character_def daft_default_character_def(void);
DAFT_API daft_character daft_character_create(daft_scene *scene, const daft_character_def *def, daft_error *error);
DAFT_API bool daft_character_destroy(daft_scene *scene, daft_character character, daft_error *error);
DAFT_API bool daft_character_is_valid(const daft_scene *scene, daft_character character);
/* The velocity it walks with from the next step on, m/s; y is ignored. */
DAFT_API bool daft_character_walk(daft_scene *scene, daft_character character, daft_vec3 velocity, daft_error *error);
/* Upwards in m/s, in the next step, if it stands then. */
DAFT_API bool daft_character_jump(daft_scene *scene, daft_character character, float speed, daft_error *error);
/* There at once, and off the ground. */
DAFT_API bool daft_character_teleport(daft_scene *scene, daft_character character, daft_dvec3 position,
                                      daft_error *error);
/* Crouches or rises, its feet where they are. False with error->code DAFT_OK: there is no room. */
DAFT_API bool daft_character_set_height(daft_scene *scene, daft_character character, float height, daft_error *error);

typedef struct daft_character_state {
    daft_dvec3 position;
    daft_vec3 velocity; /* m/s */
    float height;
    bool grounded;           /* stands on something that is not too steep */
    bool sliding;            /* touches ground that is */
    bool crushed;            /* is held where it has too little room */
    daft_entity ground;      /* what it stands on, or none */
    daft_vec3 ground_normal; /* unit, away from what it stands on or slides down */
    float turn;              /* radians about y by which what it stands on turned in the last step */
} daft_character_state;

/* As it is after the last step. */
DAFT_API bool daft_character_get(daft_scene *scene, daft_character character, daft_character_state *out,
                                 daft_error *error);

/* ---- checking files ---------------------------------------------------------------------------------------------- */

typedef enum daft_severity {
    DAFT_SEVERITY_NOTE = 0, /* worth knowing: open edges, materials that nothing uses */
    DAFT_SEVERITY_WARNING,  /* it is drawn, but perhaps not as it was meant */
    DAFT_SEVERITY_ERROR     /* the engine refuses the file */
} daft_severity;

typedef void daft_problem_callback(void *user, daft_severity severity, const daft_error *problem);

/* Reads a .scene, .obj or .mtl file, or a picture, as loading does, but looks closer and goes on after errors where it
 * can; each problem goes to `found`, with its place. The engine's warnings about these files go there too. False when
 * the check itself failed (an argument, memory), not when the file is bad. */
DAFT_API bool daft_check_file(daft_engine *engine, const char *path, daft_problem_callback *found, void *user,
                              daft_error *error);

/* ---- counters ---------------------------------------------------------------------------------------------------- */

typedef enum daft_effect_kind {
    DAFT_EFFECT_VISIBILITY = 0,
    DAFT_EFFECT_SURFACE, /* positions, normals, texture coordinates of visible points */
    DAFT_EFFECT_TEXTURE,
    DAFT_EFFECT_SHADOW,
    DAFT_EFFECT_LIGHTING,
    DAFT_EFFECT_REFLECTION,
    DAFT_EFFECT_REFRACTION,
    DAFT_EFFECT_SKY,
    DAFT_EFFECT_RESOLVE,
    DAFT_EFFECT_ANTIALIASING, /* more samples of pixels that differ from their neighbours: all of their work */
    DAFT_EFFECT_OCCLUSION,    /* rays around points, for the ambient light */
    DAFT_EFFECT_DENOISE,      /* filters what is sampled */
    DAFT_EFFECT_FOG,
    DAFT_EFFECT_COUNT
} daft_effect_kind;

typedef struct daft_effect {
    const char *name;
    bool ran;
    const char *why; /* why it ran, or why it did not */
    uint32_t tiles;
    uint64_t rays;
    uint64_t bytes; /* of working memory it took; textures: of the scene's, with all levels, too */
    double ms;      /* summed over threads, divided by their number */
} daft_effect;

typedef struct daft_counters {
    int width, height, threads; /* of the picture, in pixels; workers */
    const char *isa;
    double frame_ms; /* wall time of the whole picture */
    uint64_t camera_rays, shadow_rays, reflection_rays, refraction_rays, query_rays;
    uint64_t instances_seen, triangles_tested, triangles_binned, spheres_binned;
    uint64_t tiles_drawn;  /* of 32 × 32 pixels; fewer than the picture has where daft_view.history knew the rest */
    uint64_t exact_edges;  /* edge tests that floats could not decide */
    uint64_t exact_depths; /* depth comparisons that floats could not decide */
    uint64_t shadow_points_kept; /* lit points that something may hide: the only ones that cast a ray */
    uint64_t alpha_rays;         /* towards lights and around, that met the bounds of surfaces with alpha */
    uint64_t alpha_reads;        /* hits of these for which the texture was read: of triangles that it covers in part */
    uint64_t mesh_builds;        /* BVHs built since the scene was made */
    uint64_t mesh_refits;        /* BVHs fitted to moved vertices since the scene was made */
    uint64_t poses;        /* clips sampled and skins moved, for pictures and for rays, since the scene was made */
    uint64_t poses_unseen; /* poses that pictures went without: nothing that the clips reach was in sight */
    /* Frames, since the scene was made, that rebuilt the list of instances and the tree over it: none where nothing has
     * moved or looks different since the frame before, and the camera is where it was. */
    uint64_t instance_updates;
    double ev; /* the picture's exposure, stops */
    daft_effect effects[DAFT_EFFECT_COUNT];
} daft_counters;

/* Of the last daft_render; query_rays, mesh_builds, mesh_refits, poses, poses_unseen and instance_updates since
 * the scene was made. */
DAFT_API const daft_counters *daft_scene_counters(const daft_scene *scene);

/* ---- the fields of the structs, as data ---------------------------------------------------------------------------- */

/* Each struct below has one list of its fields: name, type, range, default, unit and a sentence. The library's
 * defaults, checks, state hash and .scene options come from these lists, and so do the tables of Lua and of the manual;
 * editors and bindings of other languages can read them instead of repeating them. All of it is constant and lives as
 * long as the program; nothing here needs an engine, and any thread may call it. */

typedef enum daft_struct {
    DAFT_STRUCT_ENGINE_DEF = 0,
    DAFT_STRUCT_MATERIAL_DEF,
    DAFT_STRUCT_ENTITY_DEF,
    DAFT_STRUCT_COLLIDER,
    DAFT_STRUCT_JOINT_DEF,
    DAFT_STRUCT_SURFACES,
    DAFT_STRUCT_CAMERA,
    DAFT_STRUCT_LIGHT_DEF,
    DAFT_STRUCT_QUALITY,
    DAFT_STRUCT_VIEW,
    DAFT_STRUCT_QUERY_FILTER,
    DAFT_STRUCT_VOLUME,
    DAFT_STRUCT_SCAN_DEF,
    DAFT_STRUCT_CHARACTER_DEF,
    DAFT_STRUCT_PLAY_DEF,
    DAFT_STRUCT_FOG,
    DAFT_STRUCT_EXPOSURE,
    DAFT_STRUCT_COUNTERS,
    DAFT_STRUCT_SIM_COUNTERS,
    DAFT_STRUCT_COUNT
} daft_struct;

typedef enum daft_field_type {
    DAFT_FIELD_BOOL = 0,
    DAFT_FIELD_INT,
    DAFT_FIELD_UINT, /* uint32_t */
    DAFT_FIELD_UINT64,
    DAFT_FIELD_FLOAT,
    DAFT_FIELD_DOUBLE,
    DAFT_FIELD_CHOICE, /* an enum: `choices` names its values */
    DAFT_FIELD_VEC2,
    DAFT_FIELD_VEC3,
    DAFT_FIELD_COLOR,     /* daft_vec3, linear light */
    DAFT_FIELD_DIRECTION, /* daft_vec3 of any length but zero */
    DAFT_FIELD_POSITION,  /* daft_dvec3 */
    DAFT_FIELD_ROTATION,  /* daft_quat of any length but zero */
    DAFT_FIELD_MESH,
    DAFT_FIELD_TEXTURE,
    DAFT_FIELD_MATERIAL,
    DAFT_FIELD_ENTITY,
    DAFT_FIELD_STRUCT, /* another struct of this list: `nested` */
    DAFT_FIELD_TEXT,   /* const char *, or NULL */
    DAFT_FIELD_OTHER,  /* pointers, callbacks and cookies: neither checked nor packed, parsed or printed */
    DAFT_FIELD_TYPE_COUNT
} daft_field_type;

enum {                             /* daft_field.flags */
       DAFT_FIELD_UNIFORM = 1,     /* Lua: one number stands for all components */
       DAFT_FIELD_HASHED = 2,      /* its bytes are in the state's hash at any value; others are where they are not the
                                      default */
       DAFT_FIELD_HASHED_USED = 4, /* the same, but only where the struct's kind uses it */
       DAFT_FIELD_NOT_HASHED = 8   /* never: the simulation's state shows what it does */
};

typedef struct daft_field {
    const char *name; /* of the member */
    daft_field_type type;
    size_t offset, size; /* bytes, in the struct */
    const char *doc;     /* one sentence without its full stop */
    const char *unit;    /* "m", "rad", "kg/m³"; NULL: a plain number */
    double min, max;     /* of each component; both 0: any finite number. FLT_TRUE_MIN: above 0; max may be infinity */
    double initial[4];   /* the default, component by component */
    const char *const *choices; /* names of the values 0, 1, …; NULL where a value has none */
    uint32_t choice_count;
    uint32_t value_count; /* of `values`: the only ones that the number may have; 0: all of the range */
    const double *values;
    uint32_t kinds;     /* bit k: used where the struct's first choice is k; 0: used always */
    const char *lua;    /* its name in tables of Lua, or NULL */
    const char *scene;  /* its name in options of .scene files, name=value, or NULL */
    daft_struct nested; /* DAFT_FIELD_STRUCT */
    uint32_t flags;
} daft_field;

/* The fields in the order of the struct. NULL, and a count of 0, for what is no struct of the list. */
DAFT_API const daft_field *daft_fields(daft_struct which, uint32_t *count);
DAFT_API const char *daft_struct_name(daft_struct which); /* "daft_light_def"; "unknown" */
DAFT_API size_t daft_struct_size(daft_struct which);      /* bytes */
/* The field with this member name, or NULL. */
DAFT_API const daft_field *daft_field_find(daft_struct which, const char *name);
/* Writes what the default maker gives; the struct's size at `out`, padding is zero. */
DAFT_API void daft_struct_default(daft_struct which, void *out);
/* Whether every field is within its range, as far as that can be told without a scene: handles are not looked up. The
 * message names the first that is not, its value and its range. */
DAFT_API bool daft_struct_check(daft_struct which, const void *value, daft_error *error);
/* The fields' bytes one after the other, without padding and without DAFT_FIELD_OTHER: two structs are equal where
 * these are. Writes them where `capacity` is enough, and returns how many there are. */
DAFT_API size_t daft_struct_pack(daft_struct which, const void *value, void *out, size_t capacity);
/* "between 0 and 1", "finite and above 0", "point, sun or spot". Returns `buffer`. */
DAFT_API const char *daft_field_range(const daft_field *field, char *buffer, size_t size);
/* The field of the struct at `value` as text: "0.5", "1, 0, 0", "true", "spot", "none". Returns `buffer`. */
DAFT_API const char *daft_field_print(const daft_field *field, const void *value, char *buffer, size_t size);
/* Sets the field of the struct at `value` from such text; components are separated by commas. Numbers, choices and
 * booleans only. On failure the struct is as it was. */
DAFT_API bool daft_field_parse(const daft_field *field, const char *text, void *value, daft_error *error);

#ifdef __cplusplus
}
#endif
#endif
