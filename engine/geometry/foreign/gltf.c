/* The JSON of a glTF file beside what Assimp has made of it. Its nodes are told by where they hang: Assimp keeps the
 * hierarchy, and puts a node of its own above where a scene has several roots. */
#include "geometry/foreign/assimp.h"

#include <string.h>

static const daft_json NOTHING = {NULL, NULL};

static uint32_t word_at(const uint8_t *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

/* ---- the text ---- */

/* A GLB is a header of 12 bytes and chunks: length, type, bytes; the first is the JSON, the second the binary. */
static void find_chunks(daft_gltf *g)
{
    enum { HEADER = 12, CHUNK = 8, JSON = 0x4e4f534a, BINARY = 0x004e4942 };
    const uint8_t *b = g->from->bytes;
    const size_t size = g->from->size, text = HEADER + CHUNK;
    if (size < text || word_at(b + HEADER + 4) != JSON) return;
    const size_t length = word_at(b + HEADER) < size - text ? word_at(b + HEADER) : size - text;
    g->root = daft_json_open((const char *)b + text, length);
    const size_t next = text + (length + 3) / 4 * 4;
    if (next + CHUNK > size || word_at(b + next + 4) != BINARY) return;
    const size_t all = size - next - CHUNK, own = word_at(b + next);
    g->binary = b + next + CHUNK, g->binary_size = own < all ? own : all;
}

static bool list_items(daft_gltf *g, daft_json array, daft_gltf_list *out)
{
    uint32_t count = 0;
    for (daft_json i = daft_json_first(array); i.at; i = daft_json_next(i)) count++;
    out->items = daft_arena_alloc(&g->arena, (size_t)count + 1, sizeof *out->items);
    if (!out->items) return false;
    for (daft_json i = daft_json_first(array); i.at; i = daft_json_next(i)) out->items[out->count++] = i;
    return true;
}

static daft_json item_at(const daft_gltf_list *list, daft_json number)
{
    const uint32_t index = daft_json_index(number);
    return index < list->count ? list->items[index] : NOTHING;
}

static daft_json punctual(daft_json owner)
{
    return daft_json_member(daft_json_member(owner, "extensions"), "KHR_lights_punctual");
}

/* ---- nodes ---- */

static bool is_named(const daft_gltf *g, uint32_t number, const char *name)
{
    char own[1024];
    daft_json_string(daft_json_member(g->nodes.items[number], "name"), own, sizeof own);
    return strncmp(own, name, strlen(own)) == 0; /* Assimp may lengthen one */
}

/* next: of each node the file's number of the next of its children. */
static void match_nodes(daft_gltf *g, const daft_foreign_nodes *nodes, daft_json *next)
{
    daft_gltf_list scenes = {0};
    if (!list_items(g, daft_json_member(g->root, "scenes"), &scenes)) return;
    const uint32_t scene = daft_json_index(daft_json_member(g->root, "scene"));
    const daft_json shown = scenes.count == 0 ? NOTHING : scenes.items[scene < scenes.count ? scene : 0];
    daft_json roots = daft_json_first(daft_json_member(shown, "nodes"));
    const bool alone = roots.at && !daft_json_next(roots).at;
    for (uint32_t i = 0; i < nodes->count; i++) {
        const uint32_t parent = nodes->items[i].parent;
        next[i] = i == 0 && !alone ? roots : NOTHING;
        daft_json *from = i == 0 ? &roots : &next[parent];
        if (i == 0 && !alone) continue;
        const uint32_t number = daft_json_index(*from);
        *from = daft_json_next(*from);
        if (number >= g->nodes.count || !is_named(g, number, nodes->items[i].node->mName.data)) continue;
        g->node_of[i] = number;
        next[i] = daft_json_first(daft_json_member(g->nodes.items[number], "children"));
    }
}

bool daft_gltf_begin(const daft_foreign *from, daft_gltf *g)
{
    *g = (daft_gltf){.from = from};
    daft_arena_init(&g->arena, from->allocator);
    if (from->format && strcmp(from->format, "glb") == 0)
        find_chunks(g);
    else if (from->format && strcmp(from->format, "gltf") == 0)
        g->root = daft_json_open(from->bytes, from->size);
    if (!g->root.at) return true;
    bool done = list_items(g, daft_json_member(g->root, "nodes"), &g->nodes) &&
                list_items(g, daft_json_member(g->root, "animations"), &g->clips) &&
                list_items(g, daft_json_member(g->root, "accessors"), &g->accessors) &&
                list_items(g, daft_json_member(g->root, "bufferViews"), &g->views) &&
                list_items(g, daft_json_member(g->root, "buffers"), &g->buffers) &&
                list_items(g, daft_json_member(g->root, "cameras"), &g->cameras) &&
                list_items(g, daft_json_member(punctual(g->root), "lights"), &g->lights);
    if (done) g->bytes = daft_arena_alloc(&g->arena, (size_t)g->buffers.count + 1, sizeof *g->bytes);
    if (done) g->numbers = daft_arena_alloc(&g->arena, (size_t)g->accessors.count + 1, sizeof *g->numbers);
    if (!g->bytes || !g->numbers) return daft_fail_memory(from->error, "a glTF file");
    memset(g->bytes, 0, g->buffers.count * sizeof *g->bytes);
    memset(g->numbers, 0, g->accessors.count * sizeof *g->numbers);
    return true;
}

bool daft_gltf_open(const daft_foreign *from, const daft_foreign_nodes *nodes, daft_gltf *g)
{
    if (!daft_gltf_begin(from, g)) return false;
    g->node_count = nodes->count;
    if (!g->root.at) return true;
    g->node_of = daft_arena_alloc(&g->arena, nodes->count, sizeof *g->node_of);
    daft_json *next = daft_arena_alloc(&g->arena, nodes->count, sizeof *next);
    if (!g->node_of || !next) return daft_fail_memory(from->error, "a glTF file");
    for (uint32_t i = 0; i < nodes->count; i++) g->node_of[i] = UINT32_MAX;
    match_nodes(g, nodes, next);
    return true;
}

void daft_gltf_close(daft_gltf *gltf) { daft_arena_free(&gltf->arena); }

static daft_json node_at(const daft_gltf *g, uint32_t node)
{
    return g->root.at && g->node_of[node] != UINT32_MAX ? g->nodes.items[g->node_of[node]] : NOTHING;
}

daft_json daft_gltf_camera(const daft_gltf *gltf, uint32_t node)
{
    return item_at(&gltf->cameras, daft_json_member(node_at(gltf, node), "camera"));
}

daft_json daft_gltf_light(const daft_gltf *gltf, uint32_t node)
{
    return item_at(&gltf->lights, daft_json_member(punctual(node_at(gltf, node)), "light"));
}

/* ---- clips ---- */

static daft_json item_of(daft_json array, uint32_t index)
{
    daft_json item = daft_json_first(array);
    while (item.at && index-- > 0) item = daft_json_next(item);
    return item;
}

bool daft_gltf_is_linear(const daft_gltf *gltf, uint32_t clip)
{
    if (!gltf->root.at || clip >= gltf->clips.count) return true;
    daft_json s = daft_json_first(daft_json_member(gltf->clips.items[clip], "samplers"));
    for (; s.at; s = daft_json_next(s)) {
        const daft_json between = daft_json_member(s, "interpolation");
        if (between.at && !daft_json_is(between, "LINEAR")) return false;
    }
    return true;
}

daft_json daft_gltf_sampler(const daft_gltf *gltf, uint32_t clip, uint32_t node, const char *path)
{
    if (!gltf->root.at || clip >= gltf->clips.count || gltf->node_of[node] == UINT32_MAX) return NOTHING;
    const daft_json about = gltf->clips.items[clip];
    for (daft_json c = daft_json_first(daft_json_member(about, "channels")); c.at; c = daft_json_next(c)) {
        const daft_json target = daft_json_member(c, "target");
        if (daft_json_index(daft_json_member(target, "node")) == gltf->node_of[node] &&
            daft_json_is(daft_json_member(target, "path"), path))
            return item_of(daft_json_member(about, "samplers"), daft_json_index(daft_json_member(c, "sampler")));
    }
    return NOTHING;
}

/* ---- buffers ---- */

static int base64_value(char c)
{
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/* RFC 4648, up to what is none of it. */
static void decode(daft_gltf *g, const char *text, const char *end, struct daft_gltf_bytes *out)
{
    uint8_t *bytes = daft_arena_alloc(&g->arena, (size_t)(end - text) / 4 * 3 + 3, 1);
    uint32_t kept = 0;
    int bits = 0, value;
    for (; bytes && text < end && (value = base64_value(*text)) >= 0; text++) {
        kept = kept << 6 | (uint32_t)value, bits += 6;
        if (bits >= 8) bits -= 8, bytes[out->size++] = (uint8_t)(kept >> bits);
    }
    out->at = bytes, g->out_of_memory |= !bytes;
}

static void read_file(daft_gltf *g, daft_json uri, struct daft_gltf_bytes *out)
{
    char name[1024], path[1024];
    daft_error why = {0};
    size_t size;
    daft_json_string(uri, name, sizeof name);
    if (!name[0] || !daft_path_beside(g->from->path, name, path, sizeof path)) return;
    char *bytes = daft_file_read(g->from->allocator, g->from->files, path, &size, &why);
    uint8_t *copy = bytes ? daft_arena_alloc(&g->arena, size + 1, 1) : NULL;
    if (copy) memcpy(copy, bytes, size), out->at = copy, out->size = size;
    g->out_of_memory |= bytes ? !copy : why.code == DAFT_ERROR_MEMORY;
    daft_release(g->from->allocator, bytes);
}

static const struct daft_gltf_bytes *buffer_at(daft_gltf *g, uint32_t index)
{
    static const char DATA[] = "\"data:", MARK[] = ";base64,";
    if (index >= g->buffers.count) return NULL;
    struct daft_gltf_bytes *out = &g->bytes[index];
    const daft_json uri = daft_json_member(g->buffers.items[index], "uri");
    if (out->asked) return out;
    out->asked = true;
    if (!uri.at) {
        if (index == 0) out->at = g->binary, out->size = g->binary_size;
        return out;
    }
    const size_t left = (size_t)(uri.end - uri.at);
    if (left < sizeof DATA || memcmp(uri.at, DATA, sizeof DATA - 1) != 0) {
        read_file(g, uri, out);
        return out;
    }
    const char *at = uri.at + sizeof DATA - 1, *comma = memchr(at, ',', left - (sizeof DATA - 1));
    const size_t mark = sizeof MARK - 1;
    const char *quote = comma ? memchr(comma, '"', (size_t)(uri.end - comma)) : NULL;
    if (quote && (size_t)(comma + 1 - at) >= mark && memcmp(comma + 1 - mark, MARK, mark) == 0)
        decode(g, comma + 1, quote, out);
    return out;
}

static size_t width_of(daft_json accessor)
{
    static const struct {
        const char *type;
        size_t width;
    } known[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
    for (size_t i = 0; i < DAFT_COUNT_OF(known); i++)
        if (daft_json_is(daft_json_member(accessor, "type"), known[i].type)) return known[i].width;
    return 0;
}

/* A whole number of 0 or more; what is none is 2^53, which fits nowhere. */
static uint64_t size_at(daft_json owner, const char *name, double other)
{
    const daft_json value = daft_json_member(owner, name);
    const double number = value.at ? daft_json_number(value, -1) : other;
    return number >= 0 && number < 0x1p53 ? (uint64_t)number : (uint64_t)1 << 53;
}

static size_t bytes_of(uint32_t type)
{
    static const uint8_t BYTES[] = {1, 1, 2, 2, 0, 4, 4};
    return type >= 5120 && type < 5120 + sizeof BYTES ? BYTES[type - 5120] : 0;
}

bool daft_gltf_locate(daft_gltf *g, daft_json accessor, daft_gltf_packed *out)
{
    const daft_json view = item_at(&g->views, daft_json_member(accessor, "bufferView")),
                    normalized = daft_json_member(accessor, "normalized");
    const uint32_t type = daft_json_index(daft_json_member(accessor, "componentType"));
    const size_t width = width_of(accessor), size = width * bytes_of(type);
    if (!view.at || !size || daft_json_member(accessor, "sparse").at || daft_json_member(view, "extensions").at)
        return false;
    const struct daft_gltf_bytes *buffer = buffer_at(g, daft_json_index(daft_json_member(view, "buffer")));
    const uint64_t items = size_at(accessor, "count", 0), stride = size_at(view, "byteStride", (double)size),
                   first = size_at(view, "byteOffset", 0) + size_at(accessor, "byteOffset", 0);
    if (!buffer || !buffer->at || items == 0 || items > buffer->size || stride > buffer->size || stride < size ||
        first > buffer->size || (items - 1) * stride + size > buffer->size - first)
        return false;
    *out = (daft_gltf_packed){.first = buffer->at + first,
                              .items = (size_t)items,
                              .stride = (size_t)stride,
                              .width = width,
                              .type = type,
                              .normalized = normalized.at && *normalized.at == 't'};
    return true;
}

/* NULL: see daft_gltf_floats. */
static float *read_floats(daft_gltf *g, daft_json accessor, size_t *count)
{
    enum { FLOAT = 5126 };
    daft_gltf_packed p;
    if (!daft_gltf_locate(g, accessor, &p) || p.type != FLOAT) return NULL;
    float *out = daft_arena_alloc(&g->arena, p.items * p.width, sizeof *out);
    g->out_of_memory |= !out;
    for (size_t i = 0; out && i < p.items; i++)
        memcpy(out + i * p.width, p.first + i * p.stride, p.width * sizeof *out);
    *count = p.items * p.width;
    return out;
}

const float *daft_gltf_floats(daft_gltf *g, daft_json number, size_t *count)
{
    const uint32_t index = daft_json_index(number);
    if (index >= g->accessors.count) return NULL;
    struct daft_gltf_numbers *numbers = &g->numbers[index];
    if (!numbers->at) numbers->at = read_floats(g, g->accessors.items[index], &numbers->count);
    *count = numbers->count;
    return numbers->at;
}
