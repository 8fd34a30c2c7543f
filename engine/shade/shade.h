/* shade: what a surface does with light: materials, textures, light sources, sky, Lambert and Phong, and the encoding
 * to sRGB. All are functions of points in lanes: a batch in, a batch out, no state. Promises: linear light; the same
 * bits on every instruction set; no rays: the caller says which points a light reaches. Public headers: shade.h
 * material_lanes.h */
#ifndef DAFT_SHADE_H
#define DAFT_SHADE_H

#include "base/base.h"
#include "image/image.h"
#include "math/vec.h"

#define DAFT_NO_TEXTURE UINT32_MAX

/* The maps of daft_surface.maps. */
enum {
    DAFT_MAP_AMBIENT,
    DAFT_MAP_SPECULAR,
    DAFT_MAP_EMISSION,
    DAFT_MAP_SHININESS,
    DAFT_MAP_ROUGHNESS,
    DAFT_MAP_METALLIC,
    DAFT_MAP_NORMAL,
    DAFT_MAP_BUMP,
    DAFT_MAP_ALPHA,
    DAFT_MAP_REFLECTION,
    DAFT_MAP_OCCLUSION,
    DAFT_MAPS
};

/* A material as the kernels read it: words in this order, gathered by their number. */
typedef struct daft_surface {
    daft_vec3 ambient, diffuse; /* times 1 - transmission */
    daft_vec3 specular, emission;
    daft_vec3 mirror;        /* reflected fraction times tint */
    daft_vec3 reflection;    /* the same, of a material that mirrors an image instead; else 0 */
    daft_vec3 transmittance; /* transmission times its tint */
    float transmission, index;
    float shininess;
    float alpha;      /* of the facets that mirror and refract (GGX): the square of the roughness; 0: smooth */
    uint32_t texture; /* index into the snapshot's textures, or DAFT_NO_TEXTURE */
    daft_vec2 map_scale, map_offset;
    uint32_t wrap;   /* a daft_wrap */
    uint32_t traits; /* DAFT_TRAIT_VARIES, and what goes with it; 0: all that follows is not read */
    float metallic, roughness;
    float normal_strength, bump_strength, occlusion_strength, opacity, cutoff;
    uint32_t maps[DAFT_MAPS]; /* textures, each DAFT_NO_TEXTURE or an index; DAFT_MAP_… */
    uint32_t alpha_channel;   /* of DAFT_MAP_ALPHA: a texel's byte, 0 to 3 */
    float steepness;          /* of a mask: see daft_mask_steepness */
    int32_t priority;         /* of what transmits, where bodies overlap */
    daft_vec3 absorption;     /* 1/m, base 2: of light on its way within the body */
} daft_surface;

/* Traits of materials: what their points call for beside Lambert's law. */
enum {
    DAFT_TRAIT_TEXTURE = 1,
    DAFT_TRAIT_SPECULAR = 2,
    DAFT_TRAIT_SENDS = 4,     /* mirrors, transmits or blends */
    DAFT_TRAIT_ROUGH = 8,     /* and mirrors or transmits in many directions */
    DAFT_TRAIT_COLORS = 16,   /* a mesh's vertices have colours: a trait of its points, of no material */
    DAFT_TRAIT_VARIES = 32,   /* more than the colour depends on the place or the direction: daft_varying */
    DAFT_TRAIT_MAPS = 64,     /* some of it by maps */
    DAFT_TRAIT_TANGENT = 128, /* some of these are normals or heights */
    DAFT_TRAIT_PHYSICAL = 256,
    DAFT_TRAIT_BLEND = 512,
    DAFT_TRAIT_AROUND = 1024,    /* mirrors an image all around it */
    DAFT_TRAIT_OCCLUSION = 2048, /* a map keeps ambient light away */
    DAFT_TRAIT_FADES = 4096      /* a mesh's vertices have alpha: as DAFT_TRAIT_COLORS, with which it comes */
};

static inline uint32_t daft_surface_traits(const daft_surface *m)
{
    bool specular = m->specular.x != 0 || m->specular.y != 0 || m->specular.z != 0;
    bool sends = m->mirror.x > 0 || m->mirror.y > 0 || m->mirror.z > 0 || m->transmission > 0;
    return (m->texture != DAFT_NO_TEXTURE ? DAFT_TRAIT_TEXTURE : 0u) | (specular ? DAFT_TRAIT_SPECULAR : 0u) |
           (sends ? DAFT_TRAIT_SENDS : 0u) | (sends && m->alpha > 0 ? DAFT_TRAIT_ROUGH : 0u) | m->traits;
}

/* Whether its points need texture coordinates. */
static inline bool daft_surface_is_textured(const daft_surface *m)
{
    return m->texture != DAFT_NO_TEXTURE || m->traits & DAFT_TRAIT_MAPS;
}

/* Whether light on its way within the body gets less. */
static inline bool daft_surface_absorbs(const daft_surface *m)
{
    return m->absorption.x > 0 || m->absorption.y > 0 || m->absorption.z > 0;
}

/* Whether some of what lies behind may be seen. */
static inline bool daft_surface_blends(const daft_surface *m) { return m->traits & DAFT_TRAIT_BLEND; }

/* opacity.c. How much of a surface that blends is there at a place of its texture, 0..1: what `vary` finds at a point
 * whose pixel is smaller than a texel. `own`: the vertices' alpha there. */
float daft_surface_opacity(const daft_surface *m, const daft_texture_data *textures, daft_vec2 uv, float own,
                           daft_texture_filter filter);

/* How fast the alpha of a mask rises where its outline is, on average, per unit of u and v; 0: the material is no mask
 * or has no outline. Of a large texture some rows are read, about a million texels. */
float daft_mask_steepness(const daft_surface *m, const daft_texture_data *textures);

/* What shines is a point or the sun, unless it is an area, whose colour is its radiance. */
typedef enum daft_area { DAFT_AREA_NONE = 0, DAFT_AREA_RECTANGLE, DAFT_AREA_SPHERE } daft_area;

typedef struct daft_light_source {
    bool sun;
    bool casts_shadow;
    daft_vec3 position; /* all but the sun, frame space; a rectangle's middle */
    daft_vec3 to_light; /* sun, spot and rectangle: unit, against its direction */
    daft_vec3 color;
    bool spot;
    bool inverse_square;           /* point and spot: `color` is what it has at a metre */
    float range;                   /* metres to where all but a sun ends; 0: nowhere */
    float radius;                  /* metres; of a sun the tangent of half the angle that it spans; 0: sharp shadows */
    float cone_cosine, cone_scale; /* spot: cosine of the outer angle; 1 / (cosine of the inner angle - cone_cosine) */
    daft_area area;
    daft_vec3 edges[2]; /* rectangle: its sides in full; their product points against its direction */
    uint32_t entity;    /* whose it is, which is no occluder of its own light and is seen in mirrors; 0: nobody's */
    /* Of an entity that the area stands in for: rays end before its bounds, and do not light it. */
    bool bounded;
    daft_slanted_box bounds;
} daft_light_source;

/* Fog as its kernel reads it, in frame space. */
typedef struct daft_air {
    daft_vec3 color;
    float density;  /* 1/m, at `base`; 0: no fog */
    float thinning; /* 1/m: 1 / the height in which it thins to 1/e; 0: it does not */
    float base;     /* metres, y */
    float glow;     /* fraction of `sun` that it has towards `to_sun` */
    daft_vec3 sun, to_sun;
} daft_air;

typedef enum daft_sky_kind { DAFT_SKY_COLOR = 0, DAFT_SKY_GRADIENT, DAFT_SKY_IMAGE, DAFT_SKY_CUBE } daft_sky_kind;

typedef struct daft_sky {
    daft_sky_kind kind;
    daft_vec3 zenith, horizon; /* colour: zenith alone */
    daft_vec3 mean;            /* over all directions */
    const daft_sky_image *image;
    daft_vec3 sun, to_sun; /* what a sun's disc adds; where it is, unit */
    float sun_chord2;      /* the square of the chord from its middle to its edge; 0: none is seen */
} daft_sky;

/* Light from everywhere, as a white surface sends it on: the same for all normals, or by the normal's x, y, z as
 * factors of 1, x, y, z, xy, yz, xz, 3z² - 1, x² - y². */
enum { DAFT_HARMONICS = 9 };
typedef struct daft_ambient {
    bool by_normal;
    daft_vec3 color;
    daft_vec3 harmonics[DAFT_HARMONICS];
} daft_ambient;

/* The factors for a sky: of its radiance's spherical harmonics up to the second order, each times what Lambert's cosine
 * leaves of it, 1, 2/3, 1/4 (Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance Environment Maps",
 * SIGGRAPH 2001). Irradiance is pi times their sum. The first factor is the sky's mean. */
void daft_sky_irradiance(const daft_sky *sky, daft_vec3 harmonics[DAFT_HARMONICS]);

/* What is done to light before it becomes bytes: times 2^ev, then the curve. All 0: nothing. */
typedef struct daft_tone {
    float ev;
    daft_tone_curve curve;
} daft_tone;

static inline bool daft_tone_changes(const daft_tone *tone) { return tone->ev != 0 || tone->curve != DAFT_TONE_NONE; }
/* The least light that it shows as white, where it is grey. */
float daft_tone_white(const daft_tone *tone);

enum {
    DAFT_BATCH = 1024,                 /* points in one batch: a tile's pixels */
    DAFT_BATCH_ROOM = DAFT_BATCH + 16, /* one whole SIMD store past the end */
    DAFT_BATCH_WORDS = DAFT_BATCH / 32 + 1
};
_Static_assert(DAFT_BATCH % 32 == 0 && DAFT_BATCH % 16 == 0, "bit sets and SIMD stores divide a batch evenly");

typedef struct daft_lanes3 {
    float x[DAFT_BATCH_ROOM], y[DAFT_BATCH_ROOM], z[DAFT_BATCH_ROOM];
} daft_lanes3;

/* What materials with DAFT_TRAIT_VARIES are at a batch's points, and so are the other materials of such a batch. */
typedef struct daft_varying {
    daft_lanes3 tangent, bitangent; /* where u and v grow, of any length; DAFT_TRAIT_TANGENT */
    daft_lanes3 ambient, diffuse;   /* times the albedo */
    daft_lanes3 specular;           /* of Phong, or straight on of facets (F0) */
    daft_lanes3 emission, mirror;   /* mirror: of the rays that are sent on */
    float gloss[DAFT_BATCH_ROOM];   /* Phong's exponent or, less than 0, minus alpha of facets */
    float alpha[DAFT_BATCH_ROOM];   /* of the facets that mirror and transmit */
    float opacity[DAFT_BATCH_ROOM]; /* the rest is seen through it; DAFT_TRAIT_FADES: before `vary`, the vertices' */
} daft_varying;

/* Two diameters of the ellipse on the surface that a pixel sees, in units of u and v, each parallel to the ellipse's
 * tangent where the other ends. `spread`: close up a point is read at several places, since its pixel has no more of
 * them. */
typedef struct daft_footprints {
    float first_u[DAFT_BATCH_ROOM], first_v[DAFT_BATCH_ROOM], second_u[DAFT_BATCH_ROOM], second_v[DAFT_BATCH_ROOM];
    bool spread;
} daft_footprints;

static inline bool daft_filter_is_anisotropic(daft_texture_filter filter)
{
    return filter == DAFT_TEXTURE_ANISOTROPIC4 || filter == DAFT_TEXTURE_ANISOTROPIC16;
}

/* Mirrored rays of physical surfaces of less weight than this are not sent: see vary_kernel.c. */
#define DAFT_LEAST_MIRROR 0.02f

/* What the points of a batch may still do. */
typedef struct daft_vary_def {
    bool mirrors;      /* mirrored rays are followed: else the ambient light stands for what they would see */
    bool lets_through; /* what lies behind is looked for: else surfaces that blend are opaque */
    float sample_side; /* pixels a side of what a point stands for, of which a mask covers a part; 0: all or none */
} daft_vary_def;

/* Points to be shaded, in frame space. Bit sets have point i at bit i % 32 of word i / 32. */
typedef struct daft_batch {
    uint32_t count;
    uint32_t traits; /* of the points' materials, all of them; where one is missing, so may be what only it calls for */
    bool one_material; /* all points' */
    daft_lanes3 point; /* rays that leave the surface start here: on its outer side by more than the error of the hit */
    daft_lanes3 shadow_origin; /* the same for shadow rays: raised off the facets to where the smooth surface would be
                                */
    daft_lanes3 normal;        /* shading normal, unit */
    daft_lanes3 outward;       /* geometric normal, unit, towards the viewer */
    daft_lanes3 view;          /* to the viewer, unit */
    float u[DAFT_BATCH_ROOM], v[DAFT_BATCH_ROOM]; /* of points whose material has a texture */
    float footprint[DAFT_BATCH_ROOM];             /* side of the pixel's patch on the surface, in units of u and v */
    float extent[DAFT_BATCH_ROOM];   /* metres that the spawn error counts beside the point's own coordinates */
    float distance[DAFT_BATCH_ROOM]; /* metres travelled from the camera to here */
    uint32_t material[DAFT_BATCH_ROOM];
    uint32_t instance[DAFT_BATCH_ROOM];
    uint32_t triangle[DAFT_BATCH_ROOM]; /* of the instance's mesh; 0 on a sphere */
    uint32_t inner[DAFT_BATCH_ROOM];    /* 1: the viewer sees the surface's inner side, else 0; where points send on */
    uint32_t pixel[DAFT_BATCH_ROOM];    /* where in the tile it counts */
    daft_lanes3 weight;                 /* how much of its light arrives there */
    daft_lanes3 albedo;                 /* the texture's colour, or 1 */
    daft_lanes3 light;                  /* what it sends to the viewer */
    float cosine[DAFT_BATCH_ROOM]; /* between the normal and the direction to the light that `facing` was called for
                                      last; of an area, its form factor */
    daft_varying *varying;         /* NULL: no material in the frame calls for it */
    daft_footprints *footprints;   /* NULL: no filter of textures asks */
    struct daft_crossings *media;  /* render's; NULL: no material in the frame calls for it */
} daft_batch;

typedef struct daft_shade_kernels {
    /* albedo: white, or the texture's colour, filtered in linear light; times the vertices' colour, which is there
     * before. True if any point has a texture. */
    bool (*albedo)(daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                   daft_texture_filter filter);
    /* Of a batch with DAFT_TRAIT_VARIES, after `albedo`: fills what varies, and turns normals as maps say. */
    void (*vary)(daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                 daft_texture_filter filter, const daft_vary_def *def);
    /* light = emission + ambient. */
    void (*ambient)(daft_batch *batch, const daft_surface *materials, const daft_ambient *ambient);
    /* The least and the largest coordinates of the points, one at least. */
    void (*extent)(const daft_lanes3 *points, uint32_t count, daft_vec3 *low, daft_vec3 *high);
    /* Sets the bits of the points that face the light (their normal's side, inside its range and a spot's cone) and
     * gives their number. Sets all points' `cosine`. */
    uint32_t (*facing)(daft_batch *batch, const daft_light_source *source, uint32_t bits[DAFT_BATCH_WORDS]);
    /* Clears the bits of points that send on nothing of the light that `facing` was called for last, which is no area:
     * their colour is black, and their highlight elsewhere, as nearly all of a glass. Gives how many are left. */
    uint32_t (*skip_dark)(const daft_batch *batch, const daft_surface *materials, const daft_light_source *source,
                          uint32_t lit[DAFT_BATCH_WORDS]);
    /* Adds Lambert and Phong of the light that `facing` was called for last, to the points whose bits are set.
     * `arriving`: the fraction of its light that reaches each point, by colour; NULL: all of it. `first`: the ambient
     * light, for the first light of a batch; does what `ambient` does before it adds; NULL: for later ones. */
    void (*direct_light)(daft_batch *batch, const daft_surface *materials, const daft_light_source *source,
                         const uint32_t lit[DAFT_BATCH_WORDS], const daft_lanes3 *arriving, const daft_ambient *first);
    /* The sky's colour in `count` directions of any length. */
    void (*sky)(const daft_sky *sky, const daft_lanes3 *direction, uint32_t count, daft_lanes3 *color);
    /* What fog does on the way of rays first.. to `count`: the fraction of light that comes through, and the fog's own
     * light. `origin` NULL: the camera; `length` NULL: to infinity. Directions of any length. Arrays of results begin
     * with the first ray's. */
    void (*fog)(const daft_air *air, const daft_lanes3 *origin, const daft_lanes3 *direction, const float *length,
                uint32_t first, uint32_t count, float *through, daft_lanes3 *own);
    /* Of the light first.. of `count` rays a factor 2^-loss is left. `loss`: 0 or more, and begins with the first
     * ray's; whole registers of it are read. */
    void (*fade)(daft_lanes3 *light, uint32_t first, uint32_t count, const daft_lanes3 *loss);
    /* color[pixel[i]] = light[i], and += weight[i]·light[i]. */
    void (*scatter)(daft_lanes3 *color, const uint32_t *pixel, uint32_t count, const daft_lanes3 *light);
    void (*scatter_add)(daft_lanes3 *color, const uint32_t *pixel, uint32_t count, const daft_lanes3 *weight,
                        const daft_lanes3 *light);
    /* The light of `count` pixels as it is shown, up to 1 or more. Writes whole registers; may be done in place. */
    void (*tone)(const daft_tone *tone, const float *const light[3], uint32_t count, float *const out[3]);
    /* `count` pixels from linear light to sRGB bytes with alpha 255. */
    void (*encode)(const float *r, const float *g, const float *b, uint32_t count, uint8_t *rgba);
    /* The linear light of `count` pixels' bytes. */
    void (*decode)(const uint8_t *rgba, uint32_t count, float *r, float *g, float *b);
} daft_shade_kernels;

const daft_shade_kernels *daft_shade_kernels_for(int isa);

#endif
