/* llvmpipe: users' frames as OpenGL draws them without a GPU, by Mesa's rasterizer llvmpipe, in a program of its own
 * (daft_llvmpipe), which daft_bench runs with --peers. It draws the engine's snapshots, so both show the same things:
 * the same meshes, textures, materials, lights, sky and camera. It draws them as games do: buffers and textures stay
 * on OpenGL's side; what is out of sight and what faces away is left out; one call draws all instances of a mesh, front
 * to back; bilinear textures with mipmaps; light by pixel, Lambert and Phong, and that of the sky by the normal; masks,
 * also in the shadow map, and what blends, farthest first; the sun's shadows by a map of 2048², nine taps, up to 60 m;
 * the sky, also in mirrors and glass, from a cube map; exposure and its curve. Lights that have a size are points,
 * mirrors show nothing but the sky, and there are neither maps of normals, heights, roughness and occlusion, nor
 * facets, nor fog: there it does less than the engine.
 *
 * Two peers: spots and point lights cast no shadows; or (`all_shadows`) the strongest eight of each do, by a depth map
 * of their cone or a depth cube, and textures are trilinear.
 *
 *   main.c the command line, scenes and demos   peer.c a frame   shadow.c casters, the sun's map   lamps.c maps of
 *   lamps   groups.c what is drawn   upload.c meshes, textures, the sky   programs.c shaders */
#ifndef DAFT_BENCH_LLVMPIPE_H
#define DAFT_BENCH_LLVMPIPE_H

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>

#include "render/render.h"

/* ---- upload.c ---- */

/* Triangles of one material slot. */
typedef struct peer_range {
    uint32_t slot, first, count; /* indices */
} peer_range;

typedef struct peer_mesh {
    const daft_trimesh *source; /* NULL: the unit sphere */
    uint32_t triangle_count;
    bool closed; /* its inner side is never seen */
    GLuint array, vertices, indices;
    GLuint position_array; /* the same triangles without normals and u, v: of fewer vertices */
    peer_range *ranges;
    uint32_t range_count;
} peer_mesh;

typedef struct peer_texture {
    const uint8_t *source;
    bool linear; /* its bytes are no colours */
    GLuint name;
} peer_texture;

typedef struct peer_assets {
    daft_allocator allocator;
    bool trilinear; /* two levels of textures; else the nearest */
    peer_mesh *meshes;
    size_t mesh_count, mesh_capacity;
    peer_texture *textures;
    size_t texture_count, texture_capacity;
    GLuint sky;
    daft_sky shown; /* by that cube map */
    int sky_levels;
} peer_assets;

/* The number of a mesh, uploaded when it is first met; UINT32_MAX: out of memory. */
uint32_t peer_mesh_of(peer_assets *assets, const daft_trimesh *mesh);
GLuint peer_texture_of(peer_assets *assets, const daft_texture_data *texture, bool linear);
/* The uniforms of a material's opacity, and its map. The program is in use. */
void peer_set_opacity(peer_assets *assets, const daft_snapshot *snapshot, const daft_surface *material, GLuint program);
/* The cube map of the sky; 0: out of memory. */
GLuint peer_sky_of(peer_assets *assets, const daft_sky *sky);
void peer_assets_free(peer_assets *assets);

/* ---- groups.c ---- */

/* Instances of one mesh that are drawn by one call. */
typedef struct peer_group {
    uint32_t mesh, range, material; /* range UINT32_MAX: all of the mesh */
    uint32_t first, count;          /* in the buffer of placements */
    float nearest;                  /* metres */
    bool turned;                    /* some placement mirrors, so that triangles turn the other way */
    bool blends;
} peer_group;

typedef struct peer_groups {
    peer_group *items;
    struct peer_item *parts;
    float *placements; /* 12 each: the rows of an affine map */
    size_t count, part_count, group_capacity, part_capacity, placement_capacity;
    GLuint buffer;
} peer_groups;

/* Planes: a point p is inside where dot(xyz, p) + w >= 0. */
typedef struct peer_planes {
    float at[6][4];
    int count;
} peer_planes;

/* Which instances: those that touch the planes' inside, by their distance. */
typedef struct peer_pick {
    peer_planes inside;
    daft_vec3 from;
    bool casters;     /* what casts shadows, whatever its materials unless these are masks */
    uint32_t glowing; /* an entity that is no caster; 0: none */
} peer_pick;

bool peer_is_outside(const daft_instance *instance, const peer_planes *inside);
/* From the point to the instance's bounds, metres. */
float peer_distance(const daft_instance *instance, daft_vec3 from);
/* What of the snapshot is picked, nearest first, then what blends, farthest first. False: out of memory. */
bool peer_groups_fill(peer_groups *groups, peer_assets *assets, const daft_snapshot *snapshot, const peer_pick *pick);
/* `positions`: the shader reads nothing else. */
void peer_group_draw(const peer_groups *groups, const peer_assets *assets, const peer_group *group, bool positions);
void peer_groups_free(peer_groups *groups, const daft_allocator *allocator);

/* ---- programs.c ---- */

enum {
    PEER_LIGHTS = 32, /* as many as one pixel is lit by; the scenes have up to 24 */
    PEER_MAPS = 8     /* cubes, and as many maps of cones */
};

/* What a surface's shader does: bits. */
enum {
    PEER_TEXTURE = 1,
    PEER_SPECULAR = 2,
    PEER_MIRROR = 4,
    PEER_CLEAR = 8,
    PEER_OPACITY = 16, /* by a map */
    PEER_MASK = 32,
    PEER_BLEND = 64,
    PEER_PROGRAMS = 128
};

uint32_t peer_traits_of(const daft_surface *material);

/* What all shaders of a frame do: how many lights there are of each kind, the first `cubes` of the points and `cones`
 * of the spots with shadows; the first sun has the shadow map where `shadow` says so; `around`: ambient light depends
 * on the normal. */
typedef struct peer_frame_traits {
    int suns, points, spots, cubes, cones;
    bool shadow, around, exposed;
    daft_tone_curve curve;
} peer_frame_traits;
/* Linked programs, 0 where they fail, with a message. */
GLuint peer_surface_program(uint32_t traits, const peer_frame_traits *frame);
GLuint peer_depth_program(bool mask);
GLuint peer_sky_program(const peer_frame_traits *frame);

/* ---- shadow.c ---- */

/* What draws depth alone: of what is solid, and of masks. */
typedef struct peer_casters {
    GLuint programs[2];
    peer_groups groups;
} peer_casters;

bool peer_casters_create(peer_casters *casters);
/* Clears the depth of the framebuffer that is bound, and draws what is picked. `to_clip`: column-major. False: out of
 * memory. */
bool peer_casters_draw(peer_casters *casters, peer_assets *assets, const daft_snapshot *snapshot, const peer_pick *pick,
                       const float to_clip[16]);
void peer_casters_free(peer_casters *casters, const daft_allocator *allocator);

typedef struct peer_shadow {
    GLuint map, target;
    float from_frame[16]; /* to the map: x, y and depth, 0..1; column-major */
} peer_shadow;

bool peer_shadow_create(peer_shadow *shadow);
/* Draws the map of a sun. False: out of memory. */
bool peer_shadow_draw(peer_shadow *shadow, peer_casters *casters, peer_assets *assets, const daft_snapshot *snapshot,
                      const daft_light_source *sun);

/* ---- lamps.c ---- */

/* The lights of a snapshot as shaders have them: suns, points, spots, those with maps first of their kind. */
typedef struct peer_lights {
    const daft_light_source *items[PEER_LIGHTS];
    int suns, points, spots, cubes, cones;
} peer_lights;

/* `maps`: lamps that cast shadows have maps, the strongest PEER_MAPS of a kind. */
void peer_lights_find(peer_lights *lights, const daft_snapshot *snapshot, bool maps);

/* The camera's planes, and the corners of what lies within them: the eye and four at the far end. */
typedef struct peer_sight {
    peer_planes inside;
    daft_vec3 corners[5];
} peer_sight;

typedef struct peer_lamps {
    GLuint maps, target; /* an array of depth: six faces of each cube, then cones */
    /* Depth in a map is x + y / the distance along its axis. */
    float cube_depth[PEER_MAPS][2], cone_depth[PEER_MAPS][2];
    daft_vec3 cone_across[PEER_MAPS], cone_up[PEER_MAPS]; /* as long as half the map is wide at a metre, inverted */
} peer_lamps;

bool peer_lamps_create(peer_lamps *lamps);
/* Draws the maps, but for those faces in which nothing that is lit is in sight. False: out of memory. */
bool peer_lamps_draw(peer_lamps *lamps, peer_casters *casters, peer_assets *assets, const daft_snapshot *snapshot,
                     const peer_lights *lights, const peer_sight *sight);

/* ---- peer.c ---- */

typedef struct peer peer;
typedef struct peer_def {
    int width, height, threads;
    bool antialiased; /* four samples a pixel */
    bool all_shadows; /* of lamps, too, and trilinear textures */
} peer_def;

/* NULL: a message says why. One at a time in a process. */
peer *peer_create(const peer_def *def);
void peer_destroy(peer *self);
/* Draws, and waits until it is done. */
bool peer_draw(peer *self, const daft_snapshot *snapshot);
/* The picture: RGBA, top row first. */
void peer_read(peer *self, uint8_t *rgba);

#endif
