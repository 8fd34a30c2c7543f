/* daft.material and daft.mesh: what entities look like. */
#include "lua/fields.h"

#include "common/util.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <stddef.h>
#include <string.h>

/* Registry key of the table from a material's description to its handle. */
static const char MATERIALS_KEY;

/* ---- what nothing holds ----
 *
 * A game's handles of materials and meshes hold them, until Lua collects the handle. What is given by name or
 * description is held only by what uses it. api_collect frees the rest; that it comes after a full collection of Lua,
 * between two callbacks, when a certain number has been made, makes it the same in every replay, whatever Lua collects
 * in between. */

/* What a material with a texture, and how many corners of a mesh, count as in host.made, beside one for the asset. */
enum { TEXTURED = 8, CORNERS = 4096 };

int api_collect(lua_State *L)
{
    host *h = api_host(L);
    lua_pushnil(L);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &MATERIALS_KEY);
    api_begin_letters_collection(L);
    lua_gc(L, LUA_GCCOLLECT);
    api_end_letters_collection(L);
    daft_scene_collect(h->def.scene);
    return 0;
}

/* The upvalue says of which type the handle is. */
int api_release_handle(lua_State *L)
{
    host *h = api_host(L);
    api_handle *handle = lua_touserdata(L, 1);
    bool is_mesh = lua_tointeger(L, lua_upvalueindex(1)) == API_MESH;
    if (!handle || !handle->id) return 0;
    if (is_mesh)
        daft_mesh_release(h->def.scene, (daft_mesh){handle->id}, NULL);
    else
        daft_material_release(h->def.scene, (daft_material){handle->id}, NULL);
    handle->id = 0;
    return 0;
}

/* ---- textures ---- */

static const char *const EXTENSIONS[] = {"", ".png", ".jpg", ".jpeg", ".tga", ".bmp"};

/* NAME, textures/NAME and their usual extensions, in the game's folder and in assets/. */
static bool find_texture(const host *h, const char *name, char *out, size_t size)
{
    for (size_t i = 0; i < COUNT_OF(EXTENSIONS); i++) {
        char file[PATH_SIZE];
        snprintf(file, sizeof file, "textures/%.480s%s", name, EXTENSIONS[i]);
        if (host_find_file(h, file, out, size, NULL) || host_find_file(h, file + 9, out, size, NULL)) return true;
    }
    return false;
}

static int by_text(const void *a, const void *b) { return strcmp(*(char *const *)a, *(char *const *)b); }

typedef struct name_list {
    char *names[64];
    size_t count;
} name_list;

/* Adds the name without its extension. */
static void add_name(void *user, const char *name)
{
    name_list *list = user;
    const char *dot = strrchr(name, '.');
    if (!dot || list->count == COUNT_OF(list->names)) return;
    list->names[list->count] = strndup(name, (size_t)(dot - name));
    if (list->names[list->count]) list->count++;
}

/* Says which textures there are. Everything is freed before the error is raised. */
static void no_texture(lua_State *L, host *h, const char *what, const char *name)
{
    char message[700];
    name_list list = {.count = 0};
    daft_files_list(h->def.files, "textures", add_name, &list);
    char **names = list.names;
    size_t count = list.count;
    qsort(names, count, sizeof *names, by_text);
    const char *near = nearest_name(name, (const char *const *)names, count);
    int used = snprintf(message, sizeof message, "%s: there is no texture '%.200s'", what, name);
    if (near) used += snprintf(message + used, sizeof message - (size_t)used, ": did you mean '%.80s'?", near);
    used += snprintf(message + used, sizeof message - (size_t)used, " (there are: ");
    for (size_t i = 0; i < count; i++) {
        if ((size_t)used < sizeof message)
            used += snprintf(message + used, sizeof message - (size_t)used, "%s%s", i ? ", " : "", names[i]);
        free(names[i]);
    }
    api_error(L, h, "%s)", message);
}

static daft_texture load_texture(lua_State *L, host *h, const char *what, const char *name)
{
    char path[PATH_SIZE];
    if (!find_texture(h, name, path, sizeof path)) no_texture(L, h, what, name);
    daft_error error;
    daft_texture texture = daft_texture_load(h->def.scene, path, &error);
    if (texture.id == 0) api_engine_error(L, h, &error);
    return texture;
}

/* ---- materials ---- */

/* With a texture and no colour of its own a material is white. */
static void read_texture(lua_State *L, host *h, int table, void *out)
{
    daft_material_def *def = out;
    const daft_vec3 white = {1, 1, 1};
    def->diffuse_map = load_texture(L, h, "texture", api_text(L, h, -1, "texture"));
    if (api_has_field(L, table, "color")) return;
    def->diffuse = white;
    if (!api_has_field(L, table, "ambient")) def->ambient = white;
}

/* The images of the other maps, by their key. */
static const struct {
    const char *key;
    size_t offset;
} MAPS[] = {
    {"ambient_texture", offsetof(daft_material_def, ambient_map)},
    {"specular_texture", offsetof(daft_material_def, specular_map)},
    {"emission_texture", offsetof(daft_material_def, emission_map)},
    {"shininess_texture", offsetof(daft_material_def, shininess_map)},
    {"roughness_texture", offsetof(daft_material_def, roughness_map)},
    {"metallic_texture", offsetof(daft_material_def, metallic_map)},
    {"normal_texture", offsetof(daft_material_def, normal_map)},
    {"bump_texture", offsetof(daft_material_def, bump_map)},
    {"alpha_texture", offsetof(daft_material_def, alpha_map)},
    {"occlusion_texture", offsetof(daft_material_def, occlusion_map)},
    {"reflection_texture", offsetof(daft_material_def, reflection_map)},
};

static void read_map(lua_State *L, host *h, daft_material_def *def, size_t map)
{
    const daft_texture texture = load_texture(L, h, MAPS[map].key, api_text(L, h, -1, MAPS[map].key));
    memcpy((char *)def + MAPS[map].offset, &texture, sizeof texture);
}

#define READ_MAP(number)                                                                                               \
    static void read_map_##number(lua_State *L, host *h, int table, void *out)                                         \
    {                                                                                                                  \
        (void)table;                                                                                                   \
        read_map(L, h, out, number);                                                                                   \
    }
READ_MAP(0)
READ_MAP(1)
READ_MAP(2)
READ_MAP(3)
READ_MAP(4)
READ_MAP(5)
READ_MAP(6)
READ_MAP(7)
READ_MAP(8)
READ_MAP(9)
READ_MAP(10)

/* A colour is of all light, unless the ambient one has its own. */
static void color_ambient(lua_State *L, host *h, int table, void *out)
{
    (void)h;
    daft_material_def *def = out;
    if (!api_has_field(L, table, "ambient")) def->ambient = def->diffuse;
}

static const api_special SPECIALS[] = {
    {.name = "color",
     .after = color_ambient,
     .doc = "Lambert's reflection, and that of ambient light unless ambient is given; white where there is a texture"},
    {.name = "texture",
     .read = read_texture,
     .value = "\"name\"",
     .doc = "An image: \"checker\" is textures/checker.png in the game's folder or in assets/"},
    {.name = "ambient_texture", .read = read_map_0, .value = "\"name\""},
    {.name = "specular_texture", .read = read_map_1, .value = "\"name\""},
    {.name = "emission_texture", .read = read_map_2, .value = "\"name\""},
    {.name = "shininess_texture", .read = read_map_3, .value = "\"name\""},
    {.name = "roughness_texture", .read = read_map_4, .value = "\"name\""},
    {.name = "metallic_texture", .read = read_map_5, .value = "\"name\""},
    {.name = "normal_texture", .read = read_map_6, .value = "\"name\""},
    {.name = "bump_texture", .read = read_map_7, .value = "\"name\""},
    {.name = "alpha_texture", .read = read_map_8, .value = "\"name\""},
    {.name = "occlusion_texture", .read = read_map_9, .value = "\"name\""},
    {.name = "reflection_texture", .read = read_map_10, .value = "\"name\""}};

const api_form api_material_form = {"material", "daft.material", DAFT_STRUCT_MATERIAL_DEF,
                                    -1,         SPECIALS,        COUNT_OF(SPECIALS)};

/* Changes what the table at `table` names. */
static void read_material(lua_State *L, host *h, int table, daft_material_def *def)
{
    int top = lua_gettop(L);
    api_read_struct(L, h, table, "material", &api_material_form, def);
    lua_settop(L, top);
}

static daft_material create(lua_State *L, host *h, const daft_material_def *def)
{
    daft_error error;
    daft_material material = daft_material_create(h->def.scene, def, &error);
    if (material.id == 0) api_engine_error(L, h, &error);
    h->made += def->diffuse_map.id ? TEXTURED : 1;
    if (def->diffuse_map.id) daft_texture_release(h->def.scene, def->diffuse_map, NULL); /* the material uses it */
    for (size_t i = 0; i < COUNT_OF(MAPS); i++) {
        daft_texture map;
        memcpy(&map, (const char *)def + MAPS[i].offset, sizeof map);
        if (map.id) daft_texture_release(h->def.scene, map, NULL);
    }
    return material;
}

/* Materials of equal description are one, so that making entities in a loop does not make materials without end. They
 * are found by a text; returns false and leaves nothing, or true and the handle in *out. */
static bool find_shared(lua_State *L, const char *key, size_t length, daft_material *out)
{
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &MATERIALS_KEY) == LUA_TNIL) {
        lua_pop(L, 1);
        lua_newtable(L);
        lua_pushvalue(L, -1);
        lua_rawsetp(L, LUA_REGISTRYINDEX, &MATERIALS_KEY);
    }
    lua_pushlstring(L, key, length);
    bool found = lua_rawget(L, -2) == LUA_TNUMBER;
    out->id = (uint32_t)lua_tointeger(L, -1);
    lua_pop(L, 2);
    return found;
}

static void keep_shared(lua_State *L, const char *key, size_t length, daft_material material)
{
    lua_rawgetp(L, LUA_REGISTRYINDEX, &MATERIALS_KEY);
    lua_pushlstring(L, key, length);
    lua_pushinteger(L, (lua_Integer)material.id);
    lua_rawset(L, -3);
    lua_pop(L, 1);
}

static daft_material shared_material(lua_State *L, host *h, const daft_material_def *def)
{
    char key[512];
    size_t size = daft_struct_pack(DAFT_STRUCT_MATERIAL_DEF, def, key, sizeof key);
    daft_material material;
    bool fits = size <= sizeof key;
    if (fits && find_shared(L, key, size, &material)) return material;
    material = create(L, h, def);
    daft_material_release(h->def.scene, material, NULL);
    if (fits) keep_shared(L, key, size, material);
    return material;
}

static daft_material material_file(lua_State *L, host *h, const char *name)
{
    const char *hash = strchr(name, '#');
    char file[PATH_SIZE / 2], path[PATH_SIZE], full[PATH_SIZE * 2];
    snprintf(file, sizeof file, "%.*s", (int)(hash ? hash - name : (long)strlen(name)), name);
    daft_error error;
    if (!host_find_file(h, file, path, sizeof path, &error)) api_engine_error(L, h, &error);
    snprintf(full, sizeof full, "%s%s", path, hash ? hash : "");
    daft_material material = daft_material_load(h->def.scene, full, &error);
    if (material.id == 0) api_engine_error(L, h, &error);
    daft_material_release(h->def.scene, material, NULL);
    return material;
}

daft_material api_material_at(lua_State *L, host *h, int index, const char *what)
{
    index = lua_absindex(L, index);
    const api_handle *handle = api_test_handle(L, index, API_MATERIAL);
    if (handle) return (daft_material){handle->id};
    daft_material_def def = daft_default_material_def();
    if (lua_type(L, index) == LUA_TTABLE) {
        read_material(L, h, index, &def);
        return shared_material(L, h, &def);
    }
    if (lua_type(L, index) != LUA_TSTRING)
        api_wrong(L, h, index, what, "texture name, \"#rrggbb\", \"file.mtl#name\", table or material");
    const char *name = api_text(L, h, index, what);
    if (name[0] == '#') {
        def.diffuse = def.ambient = api_color(L, h, index, what);
    } else if (strstr(name, ".mtl")) {
        return material_file(L, h, name);
    } else {
        def.diffuse = def.ambient = (daft_vec3){1, 1, 1};
        def.diffuse_map = load_texture(L, h, what, name);
    }
    return shared_material(L, h, &def);
}

static int new_material(lua_State *L, host *h)
{
    daft_material_def def = daft_default_material_def();
    if (lua_type(L, 1) == LUA_TSTRING && strstr(lua_tostring(L, 1), ".mtl")) {
        daft_error error;
        if (!daft_material_get(h->def.scene, api_material_at(L, h, 1, "material"), &def, &error))
            api_engine_error(L, h, &error);
    } else {
        if (lua_type(L, 1) != LUA_TTABLE) api_wrong(L, h, 1, "material", "table or \"file.mtl#name\"");
        read_material(L, h, 1, &def);
    }
    api_handle *handle = api_new_handle(L, API_MATERIAL, 0);
    handle->id = create(L, h, &def).id;
    return 1;
}

static int set_material(lua_State *L, host *h)
{
    daft_material material = {api_check_handle(L, h, 1, API_MATERIAL, "material")->id};
    daft_material_def def;
    daft_error error;
    if (!daft_material_get(h->def.scene, material, &def, &error)) api_engine_error(L, h, &error);
    if (lua_type(L, 2) != LUA_TTABLE) api_wrong(L, h, 2, "material", "table");
    read_material(L, h, 2, &def);
    if (!daft_material_set(h->def.scene, material, &def, &error)) api_engine_error(L, h, &error);
    return 0;
}

/* Other entities with the same material keep theirs. */
static int repaint(lua_State *L, host *h)
{
    const daft_entity entity = api_entity_at(L, h, 1, "entity");
    daft_entity_def about;
    daft_material_def def = daft_default_material_def();
    daft_error error;
    if (!daft_entity_get(h->def.scene, entity, &about, &error)) api_engine_error(L, h, &error);
    if (!about.material.id && about.shape == DAFT_SHAPE_MESH)
        api_error(L, h, "it shows the materials of its mesh: give it one of its own first");
    if (about.material.id && !daft_material_get(h->def.scene, about.material, &def, &error))
        api_engine_error(L, h, &error);
    if (lua_type(L, 2) != LUA_TTABLE) api_wrong(L, h, 2, "material", "table");
    read_material(L, h, 2, &def);
    if (!daft_entity_set_material(h->def.scene, entity, shared_material(L, h, &def), &error))
        api_engine_error(L, h, &error);
    return 0;
}

/* ---- meshes ---- */

/* Holds what it loads. */
static daft_mesh load_mesh(lua_State *L, host *h, int index, const char *what)
{
    if (lua_type(L, index) != LUA_TSTRING) api_wrong(L, h, index, what, "file name or mesh");
    const char *name = api_text(L, h, index, what);
    char path[PATH_SIZE], file[PATH_SIZE];
    snprintf(file, sizeof file, "meshes/%.900s", name);
    daft_error error;
    if (!host_find_file(h, name, path, sizeof path, NULL) && !host_find_file(h, file, path, sizeof path, NULL) &&
        !host_find_file(h, name, path, sizeof path, &error)) /* for its message, which lists folders */
        api_engine_error(L, h, &error);
    daft_mesh mesh = daft_mesh_load(h->def.scene, path, &error);
    if (mesh.id == 0) api_engine_error(L, h, &error);
    return mesh;
}

daft_mesh api_mesh_at(lua_State *L, host *h, int index, const char *what)
{
    const api_handle *handle = api_test_handle(L, index, API_MESH);
    if (handle) return (daft_mesh){handle->id};
    daft_mesh mesh = load_mesh(L, h, index, what);
    daft_mesh_release(h->def.scene, mesh, NULL);
    return mesh;
}

static const char *const MESH_FIELDS[] = {"positions", "normals", "uvs", "triangles"};

/* {x, y, z} on top as floats. */
static void read_tuple(lua_State *L, host *h, const char *what, int width, float *out)
{
    if (lua_type(L, -1) != LUA_TTABLE || lua_rawlen(L, -1) != (size_t)width)
        api_wrong(L, h, -1, what, width == 2 ? "{u, v}" : "{x, y, z}");
    for (int k = 0; k < width; k++) {
        lua_rawgeti(L, -1, k + 1);
        out[k] = api_float(L, h, -1, what);
        lua_pop(L, 1);
    }
}

/* A list of lists of `width` numbers, or of the numbers one after another, as floats, in a userdata that stays on the
 * stack. NULL where the field is nil. */
static float *read_list(lua_State *L, host *h, int table, const char *name, int width, size_t *count)
{
    if (!api_field(L, table, name)) {
        lua_pushnil(L);
        return NULL;
    }
    if (lua_type(L, -1) != LUA_TTABLE) api_wrong(L, h, -1, name, "list");
    const size_t length = lua_rawlen(L, -1);
    const bool flat = lua_rawgeti(L, -1, 1) == LUA_TNUMBER;
    lua_pop(L, 1);
    if (flat && length % (size_t)width != 0)
        api_error(L, h, "%s: %zu numbers are not so many times %d", name, length, width);
    *count = flat ? length / (size_t)width : length;
    float *out = lua_newuserdatauv(L, (*count + 1) * (size_t)width * sizeof *out, 0);
    for (size_t i = 0; i < length; i++) {
        char what[48];
        api_poll(L, i);
        lua_rawgeti(L, -2, (lua_Integer)i + 1);
        const double number = flat && lua_type(L, -1) == LUA_TNUMBER ? lua_tonumber(L, -1) : HUGE_VAL;
        if (fabs(number) < 1e30) { /* the usual case, before a name is made for messages */
            out[i] = (float)number;
        } else {
            snprintf(what, sizeof what, "%s[%zu]", name, i + 1);
            if (flat)
                out[i] = api_float(L, h, -1, what);
            else
                read_tuple(L, h, what, width, out + i * (size_t)width);
        }
        lua_pop(L, 1);
    }
    lua_remove(L, -2);
    return out;
}

static uint32_t *read_triangles(lua_State *L, host *h, size_t vertices, size_t *count)
{
    if (!api_field(L, 1, "triangles") || lua_type(L, -1) != LUA_TTABLE)
        api_error(L, h, "triangles: a list of {a, b, c} expected");
    *count = lua_rawlen(L, -1);
    uint32_t *out = lua_newuserdatauv(L, (*count + 1) * 3 * sizeof *out, 0);
    for (size_t i = 0; i < *count * 3; i++) {
        char what[48];
        snprintf(what, sizeof what, "triangles[%zu]", i / 3 + 1);
        api_poll(L, i);
        lua_rawgeti(L, -2, (lua_Integer)(i / 3) + 1);
        if (lua_type(L, -1) != LUA_TTABLE || lua_rawlen(L, -1) != 3) api_wrong(L, h, -1, what, "{a, b, c}");
        lua_rawgeti(L, -1, (lua_Integer)(i % 3) + 1);
        lua_Integer vertex = api_whole(L, h, -1, what);
        if (vertex < 1 || (size_t)vertex > vertices)
            api_error(L, h, "%s: a position from 1 to %zu expected, got %lld", what, vertices, (long long)vertex);
        out[i] = (uint32_t)(vertex - 1);
        lua_pop(L, 2);
    }
    lua_remove(L, -2);
    return out;
}

/* The same triangles, their corners elsewhere. */
static int set_mesh(lua_State *L, host *h)
{
    static const char *const FIELDS[] = {"positions", "normals"};
    const daft_mesh mesh = {api_check_handle(L, h, 1, API_MESH, "mesh")->id};
    size_t positions = 0, normals = 0;
    lua_settop(L, 2);
    api_fields(L, h, 2, "mesh", FIELDS, COUNT_OF(FIELDS));
    const daft_vec3 *at = (daft_vec3 *)read_list(L, h, 2, "positions", 3, &positions);
    const daft_vec3 *up = (daft_vec3 *)read_list(L, h, 2, "normals", 3, &normals);
    if (!at) api_error(L, h, "positions: a list of {x, y, z} expected, got nil");
    if (up && normals != positions) api_error(L, h, "as many normals as positions expected");
    daft_error error;
    if (!daft_mesh_set_positions(h->def.scene, mesh, at, up, (uint32_t)positions, &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int new_mesh(lua_State *L, host *h)
{
    if (lua_type(L, 1) == LUA_TTABLE && api_has_field(L, 1, "text")) return api_push_letters(L, h, 1);
    api_handle *handle = api_new_handle(L, API_MESH, 0);
    int top = lua_gettop(L);
    if (lua_type(L, 1) == LUA_TTABLE) {
        api_fields(L, h, 1, "mesh", MESH_FIELDS, COUNT_OF(MESH_FIELDS));
        size_t positions = 0, normals = 0, uvs = 0, triangles = 0;
        daft_mesh_def def = daft_default_mesh_def();
        def.positions = (daft_vec3 *)read_list(L, h, 1, "positions", 3, &positions);
        def.normals = (daft_vec3 *)read_list(L, h, 1, "normals", 3, &normals);
        def.uvs = (daft_vec2 *)read_list(L, h, 1, "uvs", 2, &uvs);
        if (!def.positions) api_error(L, h, "positions: a list of {x, y, z} expected, got nil");
        if ((def.normals && normals != positions) || (def.uvs && uvs != positions))
            api_error(L, h, "as many normals and uvs as positions expected");
        def.indices = read_triangles(L, h, positions, &triangles);
        def.vertex_count = (uint32_t)positions;
        def.triangle_count = (uint32_t)triangles;
        daft_error error;
        handle->id = daft_mesh_create(h->def.scene, &def, &error).id;
        if (handle->id == 0) api_engine_error(L, h, &error);
        h->made += 1 + (uint32_t)((positions + 3 * triangles) / CORNERS);
    } else if (api_test_handle(L, 1, API_MESH)) {
        lua_settop(L, 1);
        return 1;
    } else {
        handle->id = load_mesh(L, h, 1, "mesh").id;
        h->made++;
    }
    lua_settop(L, top);
    return 1;
}

static int mesh_bounds(lua_State *L, host *h)
{
    daft_mesh_info info;
    daft_error error;
    if (!daft_mesh_get_info(h->def.scene, api_mesh_at(L, h, 1, "mesh"), &info, &error)) api_engine_error(L, h, &error);
    api_push_vec3(L, (double)info.low.x, (double)info.low.y, (double)info.low.z);
    api_push_vec3(L, (double)info.high.x, (double)info.high.y, (double)info.high.z);
    return 2;
}

static const api_function FUNCTIONS[] = {
    {"material", "{...} -> material",
     "Or \"file.mtl#name\". Where a material is wanted, such a table, a texture's name or a colour do too.",
     new_material, API_CHANGES},
    {"entity:repaint", "{...}", "Changes what the table names of its material, for it alone.", repaint, API_CHANGES},
    {"material:set", "{...}", "Changes what the table names, for everything that has this material.", set_material,
     API_CHANGES},
    {"mesh",
     "(\"file.obj\") or {positions =, triangles =, normals =, uvs =} or {text =, size =, depth =, align =, font =} -> "
     "mesh",
     "Loads a mesh, or makes one: positions is a list of {x, y, z}, triangles of {a, b, c} counted from 1,\n"
     "counter-clockwise seen from the front; normals and uvs are optional, one a position.\n"
     "{text = \"HELLO\", size = 1, depth = 0.2, align = \"center\", font =}: letters of that height and depth, in "
     "metres,\n"
     "seen from +z; the last line stands on y = 0, and x = 0 is its middle, \"left\" or \"right\" end. The same text "
     "and\n"
     "sizes give the same mesh.",
     new_mesh, API_CHANGES},
    {"mesh:set", "{positions =, normals =}",
     "Moves the corners: as many positions as it was made with. The normals are computed again unless given.", set_mesh,
     API_CHANGES},
    {"mesh:bounds", "() -> {x, y, z}, {x, y, z}", "The lowest and highest coordinates.", mesh_bounds, 0},
};

const api_area api_material = {"Materials and meshes", FUNCTIONS, COUNT_OF(FUNCTIONS)};
