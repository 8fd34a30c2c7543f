/* Materials as MTL has them, with Pr and Pm where they are metallic-roughness ones: glTF's base colour, metal and
 * roughness, normals, occlusion, emission, alphaMode and alphaCutoff. */
#include "geometry/foreign/assimp.h"

#include <assimp/GltfMaterial.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader {
    const daft_foreign *from;
    const struct aiMaterial *material;
} reader;

static bool number(const reader *r, const char *key, unsigned type, unsigned index, float *out)
{
    unsigned count = 1;
    float value;
    if (r->from->assimp->numbers(r->material, key, type, index, &value, &count) != aiReturn_SUCCESS || !isfinite(value))
        return false;
    *out = value;
    return true;
}

static bool color(const reader *r, const char *key, unsigned type, unsigned index, daft_vec3 *out)
{
    struct aiColor4D c;
    if (r->from->assimp->color(r->material, key, type, index, &c) != aiReturn_SUCCESS) return false;
    if (!isfinite(c.r) || !isfinite(c.g) || !isfinite(c.b)) return false;
    *out = daft_v3(c.r > 0 ? c.r : 0, c.g > 0 ? c.g : 0, c.b > 0 ? c.b : 0);
    return true;
}

/* ---- pictures ---- */

/* One within the file. A raw one gets the header of a TGA file, which readers of pictures know. */
static bool take_embedded(const daft_foreign *from, const struct aiTexture *texture, uint8_t **out, size_t *out_size)
{
    enum { TGA_HEADER = 18 };
    const bool raw = texture->mHeight > 0;
    const size_t pixels = (size_t)texture->mWidth * texture->mHeight;
    const size_t size = raw ? TGA_HEADER + 4 * pixels : texture->mWidth;
    if (raw && (texture->mWidth > 16384 || texture->mHeight > 16384)) return true;
    uint8_t *bytes = daft_alloc_zero(from->allocator, size ? size : 1, 1);
    if (!bytes) return daft_fail_memory(from->error, "a texture");
    if (raw) { /* type 2: true colour; 32 bits, the top row first */
        const uint8_t header[TGA_HEADER] = {[2] = 2,
                                            [12] = (uint8_t)texture->mWidth,
                                            [13] = (uint8_t)(texture->mWidth >> 8),
                                            [14] = (uint8_t)texture->mHeight,
                                            [15] = (uint8_t)(texture->mHeight >> 8),
                                            [16] = 32,
                                            [17] = 0x28};
        memcpy(bytes, header, sizeof header);
        memcpy(bytes + TGA_HEADER, texture->pcData, 4 * pixels); /* B G R A */
    } else {
        memcpy(bytes, texture->pcData, size);
    }
    *out = bytes, *out_size = size;
    return true;
}

static const struct aiTexture *find_embedded(const struct aiScene *scene, const char *name)
{
    if (name[0] == '*') {
        const unsigned long index = strtoul(name + 1, NULL, 10);
        return index < scene->mNumTextures ? scene->mTextures[index] : NULL;
    }
    const char *slash = strrchr(name, '/');
    for (unsigned i = 0; i < scene->mNumTextures; i++) {
        const char *own = scene->mTextures[i]->mFilename.data, *base = strrchr(own, '/');
        base = base ? base + 1 : own;
        if (base[0] && strcmp(base, slash ? slash + 1 : name) == 0) return scene->mTextures[i];
    }
    return NULL;
}

/* Beside the model as the file says, or right beside it: exporters write paths of their own machine. */
static void place_map(const daft_foreign *from, const char *name, char out[1024])
{
    char folder[1024];
    const char *slash = strrchr(from->path, '/'), *base = strrchr(name, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash + 1 - from->path) : 0, from->path);
    snprintf(out, 1024, "%.500s%.500s", folder, name);
    if (base && !daft_file_exists(from->files, out)) snprintf(out, 1024, "%.500s%.500s", folder, base + 1);
}

/* The map of a use, or the material's own for DAFT_MTL_DIFFUSE. */
static bool take_map(const reader *r, enum aiTextureType type, daft_mtl_use use, daft_mtl *out)
{
    struct aiString name;
    if (r->from->assimp->texture(r->material, type, 0, &name, NULL, NULL, NULL, NULL, NULL, NULL) != aiReturn_SUCCESS)
        return true;
    for (char *c = name.data; *c; c++)
        if (*c == '\\') *c = '/';
    daft_mtl_map *map = use == DAFT_MTL_DIFFUSE ? NULL : daft_mtl_map_at(r->from->allocator, out, use);
    if (!map && use != DAFT_MTL_DIFFUSE) return daft_fail_memory(r->from->error, "a material's maps");
    char *path = map ? map->path : out->diffuse_map;
    const struct aiTexture *embedded = find_embedded(r->from->scene, name.data);
    if (map) map->change.gain = 1;
    if (embedded) { /* the name is its own in the cache of textures */
        snprintf(path, sizeof out->diffuse_map, "%.500s#%.400s", r->from->path, name.data);
        return take_embedded(r->from, embedded, map ? &map->bytes : &out->map_bytes, map ? &map->size : &out->map_size);
    }
    if (name.data[0] && name.data[0] != '*') place_map(r->from, name.data, path);
    return true;
}

/* ---- the material ---- */

/* False: it is no metallic-roughness one. */
static bool from_metal(const reader *r, daft_mtl *out)
{
    float metal = 1, rough = 1;
    const bool has_metal = number(r, AI_MATKEY_METALLIC_FACTOR, &metal);
    const bool has_rough = number(r, AI_MATKEY_ROUGHNESS_FACTOR, &rough);
    daft_vec3 base = out->diffuse;
    color(r, AI_MATKEY_BASE_COLOR, &base);
    out->diffuse = out->ambient = base;
    if (!has_metal && !has_rough) return false;
    out->metallic = fminf(fmaxf(metal, 0), 1), out->roughness = fminf(fmaxf(rough, 0), 1);
    return out->physical = true;
}

/* Of glTF: `opaque` overrules what colours and images say. */
static void take_alpha(const reader *r, daft_mtl *out)
{
    struct aiString mode;
    if (r->from->assimp->string(r->material, AI_MATKEY_GLTF_ALPHAMODE, &mode) != aiReturn_SUCCESS) return;
    number(r, AI_MATKEY_GLTF_ALPHACUTOFF, &out->alpha_cutoff);
    out->alpha_cutoff = fminf(fmaxf(out->alpha_cutoff, 0), 1);
    out->alpha_mode = strcmp(mode.data, "MASK") == 0    ? DAFT_ALPHA_MASK
                      : strcmp(mode.data, "BLEND") == 0 ? DAFT_ALPHA_BLEND
                                                        : DAFT_ALPHA_OPAQUE;
    if (out->alpha_mode == DAFT_ALPHA_OPAQUE) out->opacity = 1;
}

/* KHR_materials_transmission; with a thickness it is a body (KHR_materials_volume), which bends light and absorbs it.
 * False: it lets no light through. */
static bool take_transmission(const reader *r, daft_mtl *out)
{
    float passes = 0, thickness = 0, distance = 0;
    if (!number(r, AI_MATKEY_TRANSMISSION_FACTOR, &passes) || !(passes > 0)) return false;
    out->illum = 7, out->index = 1, out->filter = daft_min3(out->diffuse, daft_v3(1, 1, 1));
    if (passes < 1) out->opacity = 1 - passes;
    if (!number(r, AI_MATKEY_VOLUME_THICKNESS_FACTOR, &thickness) || !(thickness > 0)) return true;
    out->index = 1.5f; /* where the file says nothing */
    if (number(r, AI_MATKEY_REFRACTI, &out->index)) out->index = fminf(fmaxf(out->index, 0.001f), 10);
    if (number(r, AI_MATKEY_VOLUME_ATTENUATION_DISTANCE, &distance) && distance > 0) {
        color(r, AI_MATKEY_VOLUME_ATTENUATION_COLOR, &out->filter);
        out->filter = daft_min3(out->filter, daft_v3(1, 1, 1)), out->tint_distance = distance;
    }
    return true;
}

/* glTF has roughness in green and metal in blue of one image. */
static bool take_physical_maps(const reader *r, daft_mtl *out)
{
    return take_map(r, aiTextureType_DIFFUSE_ROUGHNESS, DAFT_MTL_ROUGHNESS, out) &&
           take_map(r, aiTextureType_METALNESS, DAFT_MTL_METALLIC, out);
}

/* glTF's occlusion, which Assimp has among light maps; of other formats those are what their name says. Baked ones
 * often lie by coordinates of their own. */
static bool take_occlusion(const reader *r, daft_mtl *out)
{
    const enum aiTextureType type =
        daft_foreign_is_gltf(r->from) ? aiTextureType_LIGHTMAP : aiTextureType_AMBIENT_OCCLUSION;
    struct aiString name;
    unsigned set = 0;
    const enum aiReturn found =
        r->from->assimp->texture(r->material, type, 0, &name, NULL, &set, NULL, NULL, NULL, NULL);
    if (found != aiReturn_SUCCESS) return true;
    if (set != 0) {
        daft_warn_at(
            r->from->log, DAFT_ERROR_UNSUPPORTED, r->from->path, 0, 0,
            "the occlusion of the material '%.100s' is left out: it lies by texture coordinates number %u, and "
            "only the first are read",
            out->name, set);
        return true;
    }
    if (number(r, AI_MATKEY_GLTF_TEXTURE_STRENGTH(type, 0), &out->occlusion))
        out->occlusion = fminf(fmaxf(out->occlusion, 0), 1);
    return take_map(r, type, DAFT_MTL_OCCLUSION, out);
}

/* glTF has a scale beside it, of x and y: of the slopes. */
static bool take_normals(const reader *r, daft_mtl *out)
{
    number(r, AI_MATKEY_GLTF_TEXTURE_SCALE(aiTextureType_NORMALS, 0), &out->normal);
    return take_map(r, aiTextureType_NORMALS, DAFT_MTL_NORMAL, out);
}

static bool fill(const reader *r, uint32_t index, daft_mtl *out)
{
    struct aiString name;
    float strength = 1;
    *out = daft_mtl_default();
    snprintf(out->file, sizeof out->file, "%.1000s", r->from->path);
    if (r->from->assimp->string(r->material, AI_MATKEY_NAME, &name) == aiReturn_SUCCESS && name.length > 0)
        snprintf(out->name, sizeof out->name, "%.200s", name.data);
    else
        snprintf(out->name, sizeof out->name, "material %u", index);
    color(r, AI_MATKEY_COLOR_DIFFUSE, &out->diffuse);
    out->ambient = out->diffuse;
    color(r, AI_MATKEY_COLOR_SPECULAR, &out->specular);
    if (number(r, AI_MATKEY_SHININESS_STRENGTH, &strength))
        out->specular = daft_scale(out->specular, fmaxf(strength, 0));
    if (number(r, AI_MATKEY_SHININESS, &out->shininess)) out->shininess = fminf(fmaxf(out->shininess, 0), 1000);
    color(r, AI_MATKEY_COLOR_EMISSIVE, &out->emission);
    if (number(r, AI_MATKEY_OPACITY, &out->opacity)) out->opacity = fminf(fmaxf(out->opacity, 0), 1);
    const bool metallic = from_metal(r, out);
    take_alpha(r, out);
    const bool physical = metallic && !take_transmission(r, out);
    out->physical = physical;
    return take_map(r, aiTextureType_BASE_COLOR, DAFT_MTL_DIFFUSE, out) &&
           (out->diffuse_map[0] || take_map(r, aiTextureType_DIFFUSE, DAFT_MTL_DIFFUSE, out)) &&
           (!physical || take_physical_maps(r, out)) && take_normals(r, out) &&
           take_map(r, aiTextureType_EMISSIVE, DAFT_MTL_EMISSION, out) && take_occlusion(r, out);
}

bool daft_foreign_materials(const daft_foreign *from, daft_mtl_list *out)
{
    const struct aiScene *scene = from->scene;
    if (!daft_grow(from->allocator, &out->items, &out->capacity, scene->mNumMaterials + 1, 0, sizeof *out->items))
        return daft_fail_memory(from->error, "a model's materials");
    for (uint32_t i = 0; i < scene->mNumMaterials; i++) {
        const reader r = {from, scene->mMaterials[i]};
        if (!fill(&r, i, &out->items[out->count++])) return false;
    }
    return true;
}
