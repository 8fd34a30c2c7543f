/* image: pixels in memory, files in and out, textures with their mip chains, skies.
 * Promises: linear light inside, sRGB at the edges; a texture that cannot be had is a visible checker, never a crash.
 * Public headers: image.h */
#ifndef DAFT_IMAGE_ROOM_H
#define DAFT_IMAGE_ROOM_H

#include "base/base.h"
#include "base/files.h"
#include "math/vec.h"

struct daft_image {
    daft_allocator allocator;
    int width, height;
    uint8_t *pixels; /* RGBA, sRGB, top row first */
    bool from_stb;   /* pixels are what stb_image has made */
    bool drawing;    /* the target of a daft_render that has not come back */
};

/* Decodes PNG, JPEG, TGA, BMP, GIF (first frame), PSD, HDR. At most 16384 pixels a side. As a picture or a texture, an
 * HDR file ends at white; skies keep its light. */
bool daft_image_read(const daft_allocator *allocator, const daft_files *files, const char *path, daft_image *out,
                     daft_error *error);
/* The same from memory; `path` names it in messages. */
bool daft_image_decode(const daft_allocator *allocator, const void *bytes, size_t size, const char *path,
                       daft_image *out, daft_error *error);
void daft_image_free(daft_image *image);

/* Fills `to` with `from`, which is no larger. scratch: of daft_image_enlarge_bytes, aligned for float. */
size_t daft_image_enlarge_bytes(const daft_image *from, const daft_image *to, int workers);
void daft_image_enlarge(const daft_image *from, daft_image *to, daft_upscale how, void *scratch, int workers, int isa);

float daft_srgb_to_linear(float encoded);
float daft_linear_to_srgb(float linear); /* clamps to 0..1 */

/* Textures and skies that several scenes of an engine have, once in memory: known by the bytes of their files, so that
 * a scene that is loaded while another one has the same decodes none of them again. Each is freed with its last
 * holder. */
typedef struct daft_shared_image daft_shared_image;
typedef struct daft_image_cache {
    daft_shared_image *first; /* NULL: none */
} daft_image_cache;

/* A file that has been read; `path` names it in messages. */
typedef struct daft_image_file {
    const char *path;
    const void *bytes;
    size_t size;
} daft_image_file;

/* Level 0 is the full image; each level halves both sides (at least 1), box filtered in linear light. Texels are sRGB
 * bytes, RGBA; `linear` turns a byte into linear light. Row 0 is the TOP row; v = 0 is the bottom (OBJ's convention).
 */
enum { DAFT_MAX_MIPS = 15 };
typedef struct daft_texture_data {
    int levels;
    int width[DAFT_MAX_MIPS], height[DAFT_MAX_MIPS];
    uint8_t *texels[DAFT_MAX_MIPS];   /* level 0, and an allocation with all others, one after the other */
    bool from_stb;                    /* level 0 is what stb_image has made */
    bool has_alpha;                   /* some texel's is not 255 */
    bool missing;                     /* stands in for a file that could not be read */
    uint64_t revision;                /* the holder's: no other texture has it */
    struct daft_shared_image *shared; /* what owns the texels; NULL: this does */
} daft_texture_data;

/* What is made of an image's bytes before it is a texture: all of red, green and blue become one channel (r g b m l z
 * of MTL's -imfchan: red, green, blue, matte, luminance; 0: they stay), then base + gain·value (-mm), then no more than
 * `most` texels a side (-texres; 0: any). All zero: nothing. */
typedef struct daft_texture_change {
    char channel;
    float base, gain;
    int most;
} daft_texture_change;

static inline bool daft_texture_is_changed(const daft_texture_change *c)
{
    return c->channel || c->most || (c->gain != 0 && (c->base != 0 || c->gain != 1));
}

bool daft_texture_build(const daft_allocator *allocator, const uint8_t *rgba, int width, int height,
                        daft_texture_data *out, daft_error *error);
bool daft_texture_read(const daft_allocator *allocator, const daft_files *files, const char *path,
                       daft_texture_data *out, daft_error *error);
/* The same from memory. `change` may be NULL. */
bool daft_texture_decode(const daft_allocator *allocator, const daft_image_file *file,
                         const daft_texture_change *change, daft_texture_data *out, daft_error *error);
/* The same texels that another texture has, if one of the cache is made of the same. */
bool daft_texture_share(daft_image_cache *cache, const daft_allocator *allocator, const daft_image_file *file,
                        const daft_texture_change *change, daft_texture_data *out, daft_error *error);
/* The magenta and black checker that stands for a missing file. */
bool daft_texture_missing(const daft_allocator *allocator, daft_texture_data *out, daft_error *error);
size_t daft_texture_bytes(const daft_texture_data *texture); /* of all levels */
void daft_texture_free(const daft_allocator *allocator, daft_texture_data *texture);

/* An equirectangular sky in linear light, RGB floats, top row first. A Radiance file (.hdr) has light above 1, in
 * steps of 1/256 to 1/128 of a pixel's brightest colour. */
typedef struct daft_sky_image {
    int width, height;
    float *texels; /* 3·width·height */
    bool from_stb; /* texels are what stb_image has made */
    bool cube; /* instead six faces, one below the other: `width` a side, the outer texels copies of its neighbours' */
    struct daft_shared_image *shared; /* what owns the texels; NULL: this does */
} daft_sky_image;

bool daft_sky_read(const daft_allocator *allocator, const daft_files *files, const char *path, daft_sky_image *out,
                   daft_error *error);
bool daft_sky_decode(const daft_allocator *allocator, const daft_image_file *file, daft_sky_image *out,
                     daft_error *error);
/* Six images: right, left, top, bottom, front, back as seen from within (see daft_scene_set_sky_cube). */
enum { DAFT_MAX_CUBE_SIDE = 8192 }; /* offsets of floats are 32 bits */
bool daft_sky_decode_cube(const daft_allocator *allocator, const daft_image_file files[6], daft_sky_image *out,
                          daft_error *error);
/* Of one image, or as a cube of six; shared as textures are. */
bool daft_sky_share(daft_image_cache *cache, const daft_allocator *allocator, const daft_image_file *files, int count,
                    daft_sky_image *out, daft_error *error);
/* The direction, of any length, in which place x, y of a face lies, 0 to 1 from its upper left corner. */
daft_dvec3 daft_cube_direction(int face, double x, double y);
/* Of no cube, over all directions: of at least 256 rows, as far as there are so many; of all rows where a few texels
 * may outshine the others. */
daft_vec3 daft_sky_mean(const daft_sky_image *sky);
void daft_sky_free(const daft_allocator *allocator, daft_sky_image *sky);
/* A cube as one image all around, as an equirectangular sky lies: four times as wide as a face, at most 8192 texels. */
bool daft_texture_of_cube(const daft_allocator *allocator, const daft_sky_image *cube,
                          const daft_texture_change *change, daft_texture_data *out, daft_error *error);

#endif
