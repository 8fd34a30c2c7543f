/* Meshes, textures and the sky as OpenGL keeps them, each made when it is first met. */
#include "llvmpipe/peer.h"

#include "math/simd/dispatch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { VERTEX_FLOATS = 8 }; /* position, normal, u, v */

/* ---- meshes ---- */

/* Corners that share position, normal and u, v are one vertex. */
typedef struct welder {
    uint32_t (*keys)[3], *numbers, mask; /* a hash table; numbers UINT32_MAX: empty */
    float *vertices;
    uint32_t *indices, count;
} welder;

static uint32_t weld(welder *w, const daft_trimesh *mesh, uint32_t corner)
{
    const uint32_t position = mesh->indices[corner];
    const uint32_t normal = mesh->normal_indices ? mesh->normal_indices[corner] : position;
    const uint32_t uv = !mesh->uvs ? DAFT_NO_UV : mesh->uv_indices ? mesh->uv_indices[corner] : position;
    uint32_t at = (position * 73856093u ^ normal * 19349663u ^ uv * 83492791u) & w->mask;
    for (; w->numbers[at] != UINT32_MAX; at = (at + 1) & w->mask)
        if (w->keys[at][0] == position && w->keys[at][1] == normal && w->keys[at][2] == uv) return w->numbers[at];
    w->keys[at][0] = position, w->keys[at][1] = normal, w->keys[at][2] = uv;
    const daft_vec3 n = mesh->normals[normal];
    const daft_vec2 t = uv == DAFT_NO_UV ? (daft_vec2){0, 0} : mesh->uvs[uv];
    const float vertex[VERTEX_FLOATS] = {
        mesh->x[position], mesh->y[position], mesh->z[position], n.x, n.y, n.z, t.x, 1 - t.y};
    memcpy(w->vertices + VERTEX_FLOATS * (size_t)w->count, vertex, sizeof vertex);
    return w->numbers[at] = w->count++;
}

static bool welder_begin(welder *w, uint32_t corners)
{
    uint32_t size = 64;
    while (size < 2 * corners) size *= 2;
    *w = (welder){.mask = size - 1};
    w->keys = malloc(size * sizeof *w->keys);
    w->numbers = malloc(size * sizeof *w->numbers);
    w->vertices = malloc(corners * VERTEX_FLOATS * sizeof(float));
    w->indices = malloc(corners * sizeof *w->indices);
    if (w->numbers) memset(w->numbers, 0xff, size * sizeof *w->numbers);
    return w->keys && w->numbers && w->vertices && w->indices;
}

static void welder_free(welder *w) { free(w->keys), free(w->numbers), free(w->vertices), free(w->indices); }

/* Rows of placements follow from location 3 on. */
static void enable_placements(void)
{
    for (GLuint i = 3; i < 6; i++) glEnableVertexAttribArray(i), glVertexAttribDivisor(i, 1);
}

/* `positions`: three floats a vertex, and `indices` into them, as many as the mesh has. */
static void upload_positions(peer_mesh *out, const float *positions, uint32_t count, const uint32_t *indices,
                             uint32_t index_count)
{
    GLuint buffers[2];
    glGenVertexArrays(1, &out->position_array);
    glGenBuffers(2, buffers);
    glBindVertexArray(out->position_array);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(3 * count * sizeof *positions), positions, GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(index_count * sizeof *indices), indices, GL_STATIC_DRAW);
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 3 * sizeof(float), NULL);
    enable_placements();
}

static bool upload(peer_mesh *out, const welder *w, uint32_t index_count)
{
    glGenVertexArrays(1, &out->array);
    glGenBuffers(1, &out->vertices), glGenBuffers(1, &out->indices);
    glBindVertexArray(out->array);
    glBindBuffer(GL_ARRAY_BUFFER, out->vertices);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(w->count * VERTEX_FLOATS * sizeof(float)), w->vertices, GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, out->indices);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(index_count * sizeof *w->indices), w->indices, GL_STATIC_DRAW);
    const GLint sizes[] = {3, 3, 2}, offsets[] = {0, 3, 6};
    for (GLuint i = 0; i < 3; i++) {
        glEnableVertexAttribArray(i);
        glVertexAttribPointer(i, sizes[i], GL_FLOAT, GL_FALSE, VERTEX_FLOATS * sizeof(float),
                              (const void *)((size_t)offsets[i] * sizeof(float)));
    }
    enable_placements();
    return glGetError() == GL_NO_ERROR;
}

static uint64_t edge_hash(uint32_t from, uint32_t to)
{
    uint64_t h = (from * UINT64_C(0x9e3779b97f4a7c15)) ^ (to + UINT64_C(0x7f4a7c15));
    h = (h ^ h >> 31) * UINT64_C(0xbf58476d1ce4e5b9);
    return h ^ h >> 29;
}

/* Each edge is passed as often one way as the other, so the sum is 0; that of others hardly ever is. */
static bool is_closed(const daft_trimesh *mesh)
{
    uint64_t sum = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *c = mesh->indices + 3 * (size_t)t;
        for (int k = 0; k < 3; k++) sum += edge_hash(c[k], c[(k + 1) % 3]) - edge_hash(c[(k + 1) % 3], c[k]);
    }
    return sum == 0;
}

/* Without normals and u, v there are fewer vertices. `order`: the mesh's corners, as the welded indices go. */
static bool upload_mesh_positions(peer_mesh *out, const daft_trimesh *mesh, uint32_t *order, uint32_t count)
{
    float *positions = malloc(3 * (size_t)daft_max_u(mesh->vertex_count, 1) * sizeof *positions);
    if (!positions) return false;
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        positions[3 * i] = mesh->x[i], positions[3 * i + 1] = mesh->y[i], positions[3 * i + 2] = mesh->z[i];
    for (uint32_t i = 0; i < count; i++) order[i] = mesh->indices[order[i]];
    upload_positions(out, positions, mesh->vertex_count, order, count);
    free(positions);
    return true;
}

/* The triangles slot by slot. */
static bool make_mesh(peer_mesh *out, const daft_trimesh *mesh)
{
    welder w;
    const uint32_t slots = daft_max_u(mesh->slot_count, 1);
    out->ranges = calloc(slots, sizeof *out->ranges);
    uint32_t *order = malloc(3 * (size_t)daft_max_u(mesh->triangle_count, 1) * sizeof *order), used = 0;
    bool good = welder_begin(&w, 3 * daft_max_u(mesh->triangle_count, 1)) && out->ranges && order;
    for (uint32_t slot = 0; good && slot < slots; slot++) {
        const uint32_t first = used;
        for (uint32_t t = 0; t < mesh->triangle_count; t++)
            if ((mesh->slots ? mesh->slots[t] : 0) == slot)
                for (uint32_t k = 0; k < 3; k++, used++) w.indices[used] = weld(&w, mesh, order[used] = 3 * t + k);
        if (used > first) out->ranges[out->range_count++] = (peer_range){slot, first, used - first};
    }
    out->triangle_count = mesh->triangle_count, out->closed = is_closed(mesh);
    good = good && upload_mesh_positions(out, mesh, order, used) && upload(out, &w, used);
    free(order);
    welder_free(&w);
    return good;
}

enum { ROUND = 48, HIGH = 24 }; /* quads of a sphere */

/* u, v as the engine has them: u once around y from -X over -Z, v = 1 at the top. */
static bool make_sphere(peer_mesh *out)
{
    welder w;
    float positions[(ROUND + 1) * (HIGH + 1)][3];
    out->ranges = calloc(1, sizeof *out->ranges);
    bool good = welder_begin(&w, 6 * ROUND * HIGH) && out->ranges;
    for (int j = 0; good && j <= HIGH; j++) {
        for (int i = 0; i <= ROUND; i++) {
            const float u = (float)i / ROUND, v = (float)j / HIGH, turn = 6.28318531f * (u - 0.5f),
                        rise = 3.14159265f * (0.5f - v);
            const float x = cosf(rise) * cosf(turn), y = sinf(rise), z = cosf(rise) * sinf(turn);
            const float vertex[VERTEX_FLOATS] = {x, y, z, x, y, z, u, v};
            memcpy(w.vertices + VERTEX_FLOATS * (size_t)w.count++, vertex, sizeof vertex);
        }
    }
    uint32_t used = 0;
    for (uint32_t j = 0; good && j < HIGH; j++) {
        for (uint32_t i = 0; i < ROUND; i++) {
            const uint32_t a = j * (ROUND + 1) + i, b = a + ROUND + 1, quad[6] = {a, a + 1, b, a + 1, b + 1, b};
            memcpy(w.indices + used, quad, sizeof quad), used += 6;
        }
    }
    if (good) out->ranges[out->range_count++] = (peer_range){0, 0, used};
    out->closed = true;
    if (good) {
        for (uint32_t i = 0; i < w.count; i++)
            memcpy(positions[i], w.vertices + VERTEX_FLOATS * (size_t)i, sizeof positions[i]);
        upload_positions(out, positions[0], w.count, w.indices, used);
    }
    good = good && upload(out, &w, used);
    welder_free(&w);
    return good;
}

uint32_t peer_mesh_of(peer_assets *a, const daft_trimesh *mesh)
{
    for (uint32_t i = 0; i < a->mesh_count; i++)
        if (a->meshes[i].source == mesh && (!mesh || a->meshes[i].triangle_count == mesh->triangle_count)) return i;
    if (!daft_grow(&a->allocator, &a->meshes, &a->mesh_capacity, a->mesh_count + 1, a->mesh_count, sizeof *a->meshes))
        return UINT32_MAX;
    peer_mesh *fresh = &a->meshes[a->mesh_count];
    *fresh = (peer_mesh){.source = mesh};
    if (!(mesh ? make_mesh(fresh, mesh) : make_sphere(fresh))) return UINT32_MAX;
    return (uint32_t)a->mesh_count++;
}

/* ---- textures ---- */

/* The engine's own levels. */
GLuint peer_texture_of(peer_assets *a, const daft_texture_data *t, bool linear)
{
    for (size_t i = 0; i < a->texture_count; i++)
        if (a->textures[i].source == t->texels[0] && a->textures[i].linear == linear) return a->textures[i].name;
    if (!daft_grow(&a->allocator, &a->textures, &a->texture_capacity, a->texture_count + 1, a->texture_count,
                   sizeof *a->textures))
        return 0;
    GLuint name;
    glGenTextures(1, &name);
    glBindTexture(GL_TEXTURE_2D, name);
    for (int i = 0; i < t->levels; i++)
        glTexImage2D(GL_TEXTURE_2D, i, linear ? GL_RGBA8 : GL_SRGB8_ALPHA8, t->width[i], t->height[i], 0, GL_RGBA,
                     GL_UNSIGNED_BYTE, t->texels[i]);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, t->levels - 1);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER,
                    a->trilinear ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR_MIPMAP_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    a->textures[a->texture_count++] = (peer_texture){t->texels[0], linear, name};
    return name;
}

void peer_set_opacity(peer_assets *a, const daft_snapshot *s, const daft_surface *m, GLuint program)
{
    const float channel[4] = {m->alpha_channel == 0, m->alpha_channel == 1, m->alpha_channel == 2,
                              m->alpha_channel == 3};
    glUniform1f(glGetUniformLocation(program, "opacity"), m->opacity);
    glUniform1f(glGetUniformLocation(program, "cutoff"), m->cutoff);
    glUniform2f(glGetUniformLocation(program, "map_scale"), m->map_scale.x, m->map_scale.y);
    if (m->maps[DAFT_MAP_ALPHA] == DAFT_NO_TEXTURE) return;
    glUniform4fv(glGetUniformLocation(program, "channel"), 1, channel);
    glUniform1i(glGetUniformLocation(program, "opacity_map"), 3);
    glActiveTexture(GL_TEXTURE3);
    glBindTexture(GL_TEXTURE_2D, peer_texture_of(a, &s->textures[m->maps[DAFT_MAP_ALPHA]], true));
}

/* ---- the sky ---- */

/* The direction of a texel of a face, s and t in -1..1 (OpenGL 3.3 core, 3.8.10, table 3.19). */
static daft_vec3 face_direction(int face, float s, float t)
{
    const daft_vec3 towards[6] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t}, {s, -1, -t}, {s, -t, 1}, {-s, -t, -1}};
    return towards[face];
}

static uint8_t encode(float linear)
{
    const float c = fminf(fmaxf(linear, 0), 1);
    return (uint8_t)(255 * (c <= 0.0031308f ? 12.92f * c : 1.055f * powf(c, 1 / 2.4f) - 0.055f) + 0.5f);
}

/* One row of a face: floats where `bright`, else bytes. */
static void bake_row(const daft_sky *sky, int face, int row, int size, bool bright, void *pixels)
{
    static daft_lanes3 direction, color;
    const daft_shade_kernels *shade = daft_shade_kernels_for(daft_isa_best());
    for (int i = 0; i < size; i++) {
        const daft_vec3 d =
            face_direction(face, 2 * ((float)i + 0.5f) / (float)size - 1, 2 * ((float)row + 0.5f) / (float)size - 1);
        direction.x[i] = d.x, direction.y[i] = d.y, direction.z[i] = d.z;
    }
    shade->sky(sky, &direction, (uint32_t)size, &color);
    for (int i = 0; i < size; i++) {
        const float light[4] = {color.x[i], color.y[i], color.z[i], 1};
        const uint8_t texel[4] = {encode(light[0]), encode(light[1]), encode(light[2]), 255};
        if (bright)
            memcpy((float *)pixels + 4 * i, light, sizeof light);
        else
            memcpy((uint8_t *)pixels + 4 * i, texel, sizeof texel);
    }
}

/* Brighter than white: of half floats. */
static bool is_bright(const daft_sky *sky)
{
    if (sky->kind != DAFT_SKY_IMAGE) return false;
    const size_t count = 3 * (size_t)sky->image->width * (size_t)sky->image->height;
    for (size_t i = 0; i < count; i++)
        if (sky->image->texels[i] > 1.001f) return true;
    return false;
}

static int face_size(const daft_sky *sky)
{
    int size = 64;
    while (sky->kind == DAFT_SKY_IMAGE && size < DAFT_BATCH && size < sky->image->width / 4) size *= 2;
    return size;
}

GLuint peer_sky_of(peer_assets *a, const daft_sky *sky)
{
    if (a->sky && memcmp(&a->shown, sky, sizeof *sky) == 0) return a->sky;
    const int size = face_size(sky);
    const bool bright = is_bright(sky);
    const size_t row_bytes = 4 * (size_t)size * (bright ? sizeof(float) : 1);
    uint8_t *face = malloc(row_bytes * (size_t)size);
    if (!face) return 0;
    if (!a->sky) glGenTextures(1, &a->sky);
    glBindTexture(GL_TEXTURE_CUBE_MAP, a->sky);
    for (int i = 0; i < 6; i++) {
        for (int row = 0; row < size; row++) bake_row(sky, i, row, size, bright, face + (size_t)row * row_bytes);
        glTexImage2D(GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)i, 0, bright ? GL_RGBA16F : GL_SRGB8_ALPHA8, size, size,
                     0, GL_RGBA, bright ? GL_FLOAT : GL_UNSIGNED_BYTE, face);
    }
    free(face);
    glGenerateMipmap(GL_TEXTURE_CUBE_MAP);
    glTexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
    glTexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    a->shown = *sky;
    a->sky_levels = 1;
    for (int side = size; side > 1; side /= 2) a->sky_levels++;
    return a->sky;
}

void peer_assets_free(peer_assets *a)
{
    for (size_t i = 0; i < a->mesh_count; i++) free(a->meshes[i].ranges);
    daft_release(&a->allocator, a->meshes);
    daft_release(&a->allocator, a->textures);
}
