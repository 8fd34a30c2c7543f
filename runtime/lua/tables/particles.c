/* daft.particles: many small things that fly, from one call. They are picture alone: no ray and no body meets them, and
 * nothing a game can ask depends on whether anybody looks. Each system has a sequence of random numbers of its own and
 * moves with the game's time, so a film of a replay shows the same.
 *
 * A system is a mesh of quads or octagons that face the camera. The simulation of a tick moves points; only a picture
 * that is drawn turns them into triangles, at its own moment between two ticks, and shows the entity that has the mesh
 * while it is drawn. Positions are floats relative to where the system was made. */
#include "lua/fields.h"

#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 50000, MOST_OF_ALL = 100000, QUAD = 4, ROUND = 8 };

static const float LONGEST = 1e4f; /* metres, metres a second, seconds: of what numbers make sense */

typedef struct range {
    float low, high;
} range;

typedef struct particle {
    daft_vec3 at, velocity;
    float age, life; /* seconds */
    float radius;    /* as a fraction of the system's */
} particle;

typedef struct particle_system {
    api_handle handle; /* first: see api_set_type */
    host *h;
    struct particle_system *next;
    daft_entity entity, carrier; /* what is drawn; what it goes with, or none */
    daft_mesh mesh;
    daft_dvec3 origin, place; /* of the floats; where new ones begin */
    daft_vec3 direction, gravity;
    range life, speed, size; /* size: radius in metres at the beginning and the end of a life */
    float spread, area, drag, rate, owed;
    uint32_t capacity, count, corners;
    random_state random;
    particle *all;
    daft_vec3 *positions, *normals; /* of the mesh, for the picture that is drawn */
    uint64_t *order, *spare;        /* Morton codes with indices below: see sort_for_tree */
    uint64_t bytes;                 /* counted towards the engine's limit */
} particle_system;

static float uniform(particle_system *s, float low, float high)
{
    return low + (high - low) * (float)((double)(random_next(&s->random) >> 11) * 0x1p-53);
}

/* ---- the tick ---- */

/* A direction within `spread` of the system's, even over the cap of the sphere. */
static daft_vec3 random_direction(particle_system *s, float spread)
{
    const double z = 1 - (double)uniform(s, 0, 1) * (1 - daft_cos((double)spread));
    const double turn = (double)uniform(s, 0, 1) * 6.283185307179586, r = sqrt(fmax(0, 1 - z * z));
    const double x = r * daft_cos(turn), y = r * daft_sin(turn);
    const daft_vec3 d = s->direction;
    /* Two axes across the direction: Duff and others, "Building an Orthonormal Basis, Revisited", 2017. */
    const double sign = d.z < 0 ? -1 : 1, a = -1 / (sign + (double)d.z), b = (double)d.x * (double)d.y * a;
    const double ux = 1 + sign * (double)d.x * (double)d.x * a, uy = sign * b, uz = -sign * (double)d.x;
    const double vx = b, vy = sign + (double)d.y * (double)d.y * a, vz = -(double)d.y;
    return (daft_vec3){(float)(x * ux + y * vx + z * (double)d.x), (float)(x * uy + y * vy + z * (double)d.y),
                       (float)(x * uz + y * vz + z * (double)d.z)};
}

static daft_vec3 along(daft_vec3 a, daft_vec3 d, float t)
{
    return (daft_vec3){a.x + d.x * t, a.y + d.y * t, a.z + d.z * t};
}

/* So many at a place of the world, as far as there is room. */
static void emit(particle_system *s, uint32_t count, daft_dvec3 place)
{
    const daft_vec3 none = {0, 0, 0};
    const daft_vec3 middle = {(float)(place.x - s->origin.x), (float)(place.y - s->origin.y),
                              (float)(place.z - s->origin.z)};
    for (; count > 0 && s->count < s->capacity; count--) {
        daft_vec3 start = middle;
        if (s->area > 0) /* anywhere in the ball */
            start = along(middle, random_direction(s, 3.1415927f),
                          s->area * (float)daft_pow((double)uniform(s, 0, 1), 1.0 / 3));
        const daft_vec3 way = random_direction(s, s->spread);
        s->all[s->count++] = (particle){.at = start,
                                        .velocity = along(none, way, uniform(s, s->speed.low, s->speed.high)),
                                        .life = uniform(s, s->life.low, s->life.high),
                                        .radius = uniform(s, 0.7f, 1)};
    }
}

static void move(particle_system *s, float dt)
{
    const float keep = 1 / (1 + s->drag * dt);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < s->count; i++) {
        particle p = s->all[i];
        p.age += dt;
        if (p.age >= p.life) continue;
        p.velocity = along(p.velocity, s->gravity, dt);
        p.velocity = (daft_vec3){p.velocity.x * keep, p.velocity.y * keep, p.velocity.z * keep};
        p.at = along(p.at, p.velocity, dt);
        s->all[kept++] = p;
    }
    s->count = kept;
}

static void follow(particle_system *s)
{
    daft_transform transform;
    daft_error error;
    if (!s->carrier.id) return;
    if (daft_entity_get_world_transform(s->h->def.scene, s->carrier, &transform, &error))
        s->place = transform.position;
    else
        s->carrier.id = 0, s->rate = 0; /* what made them is gone */
}

void host_step_particles(host *h, double dt)
{
    if (!(dt > 0)) return;
    for (particle_system *s = h->particles; s; s = s->next) {
        move(s, (float)dt);
        follow(s);
        s->owed += s->rate * (float)dt;
        const uint32_t due = (uint32_t)fminf(s->owed, MOST);
        s->owed -= (float)due;
        emit(s, due, s->place);
    }
}

/* ---- the picture ---- */

typedef struct axes {
    daft_vec3 right, up, back; /* of the camera, unit */
} axes;

static axes axes_of(const daft_camera *c)
{
    const daft_vec3 f = daft_camera_ray(c, 0.5, 0.5, 1), r = daft_camera_ray(c, 1, 0.5, 1);
    const float along_f = r.x * f.x + r.y * f.y + r.z * f.z;
    daft_vec3 right = {r.x - along_f * f.x, r.y - along_f * f.y, r.z - along_f * f.z};
    const float length = sqrtf(right.x * right.x + right.y * right.y + right.z * right.z);
    right = (daft_vec3){right.x / length, right.y / length, right.z / length};
    const daft_vec3 up = {right.y * f.z - right.z * f.y, right.z * f.x - right.x * f.z, right.x * f.y - right.y * f.x};
    return (axes){right, up, {-f.x, -f.y, -f.z}};
}

/* The corners of a quad or an octagon around the middle, counter-clockwise. */
static void corner_of(uint32_t corners, uint32_t i, float *x, float *y)
{
    static const float SIDE = 0.70710678f, OCTAGON[ROUND][2] = {{1, 0},  {SIDE, SIDE},   {0, 1},  {-SIDE, SIDE},
                                                                {-1, 0}, {-SIDE, -SIDE}, {0, -1}, {SIDE, -SIDE}};
    const uint32_t at = corners == QUAD ? 2 * i + 1 : i;
    *x = OCTAGON[at][0], *y = OCTAGON[at][1];
}

/* ---- order ----
 *
 * The mesh's tree is refitted, not built anew: its first positions lie along a Morton curve, and so do those of each
 * picture, since the particles are sorted by their Morton codes (Morton 1966). The leaves then hold neighbours, as in a
 * linear BVH (Lauterbach and others 2009), at the price of a radix sort. */

enum { MORTON_BITS = 10 /* of each coordinate */, DIGIT = 10, DIGITS = 3 };

/* Every third bit of a number of ten. */
static uint32_t spread_bits(uint32_t v)
{
    v = (v | v << 16) & 0x030000FFu;
    v = (v | v << 8) & 0x0300F00Fu;
    v = (v | v << 4) & 0x030C30C3u;
    return (v | v << 2) & 0x09249249u;
}

/* The other way round. */
static uint32_t gather_bits(uint32_t v)
{
    v &= 0x09249249u;
    v = (v | v >> 2) & 0x030C30C3u;
    v = (v | v >> 4) & 0x0300F00Fu;
    v = (v | v >> 8) & 0x030000FFu;
    return (v | v >> 16) & 0x3FFu;
}

static uint32_t cell_of(float value, float low, float scale)
{
    const float cell = (value - low) * scale;
    return cell > 0 ? (uint32_t)fminf(cell, (1 << MORTON_BITS) - 1) : 0;
}

/* By digits of the codes, which stand above the indices. */
static void radix_sort(uint64_t **items, uint64_t **spare, uint32_t count)
{
    for (int digit = 0; digit < DIGITS; digit++) {
        uint32_t begin[1 << DIGIT] = {0}, sum = 0;
        const int shift = 32 + digit * DIGIT;
        for (uint32_t i = 0; i < count; i++) begin[(*items)[i] >> shift & ((1 << DIGIT) - 1)]++;
        for (int k = 0; k < 1 << DIGIT; k++) {
            const uint32_t here = begin[k];
            begin[k] = sum;
            sum += here;
        }
        for (uint32_t i = 0; i < count; i++) (*spare)[begin[(*items)[i] >> shift & ((1 << DIGIT) - 1)]++] = (*items)[i];
        uint64_t *other = *items;
        *items = *spare, *spare = other;
    }
}

static void sort_for_tree(particle_system *s)
{
    daft_vec3 low = s->all[0].at, high = low;
    for (uint32_t i = 1; i < s->count; i++) {
        const daft_vec3 p = s->all[i].at;
        low = (daft_vec3){fminf(low.x, p.x), fminf(low.y, p.y), fminf(low.z, p.z)};
        high = (daft_vec3){fmaxf(high.x, p.x), fmaxf(high.y, p.y), fmaxf(high.z, p.z)};
    }
    const float side = fmaxf(high.x - low.x, fmaxf(high.y - low.y, high.z - low.z));
    const float scale = side > 0 ? (1 << MORTON_BITS) / side : 0;
    for (uint32_t i = 0; i < s->count; i++) {
        const daft_vec3 p = s->all[i].at;
        const uint32_t code = spread_bits(cell_of(p.x, low.x, scale)) | spread_bits(cell_of(p.y, low.y, scale)) << 1 |
                              spread_bits(cell_of(p.z, low.z, scale)) << 2;
        s->order[i] = (uint64_t)code << 32 | i;
    }
    radix_sort(&s->order, &s->spare, s->count);
}

/* What has not been emitted lies, without a size, where something is. */
static void fill_mesh(particle_system *s, const axes *a, float ahead)
{
    daft_vec3 last = {0, 0, 0};
    sort_for_tree(s);
    for (uint32_t i = 0; i < s->capacity; i++) {
        float radius = 0;
        if (i < s->count) {
            const particle *p = &s->all[(uint32_t)s->order[i]];
            const float part = fmaxf(0, fminf(1, (p->age + ahead) / p->life));
            radius = p->radius * (s->size.low + (s->size.high - s->size.low) * part);
            last = along(p->at, p->velocity, ahead);
        }
        for (uint32_t k = 0; k < s->corners; k++) {
            float x, y;
            corner_of(s->corners, k, &x, &y);
            s->positions[i * s->corners + k] = along(along(last, a->right, x * radius), a->up, y * radius);
            s->normals[i * s->corners + k] = a->back;
        }
    }
}

static bool is_seen(const particle_system *s) { return s->count > 0; }

void host_show_particles(host *h, const daft_camera *camera, double ahead)
{
    const axes a = axes_of(camera);
    for (particle_system *s = h->particles; s; s = s->next) {
        if (!is_seen(s) || !daft_entity_is_valid(h->def.scene, s->entity)) continue;
        fill_mesh(s, &a, (float)ahead);
        if (daft_mesh_set_positions(h->def.scene, s->mesh, s->positions, s->normals, s->capacity * s->corners, NULL))
            daft_entity_set_visible(h->def.scene, s->entity, true, NULL);
    }
}

void host_hide_particles(host *h)
{
    for (particle_system *s = h->particles; s; s = s->next)
        if (is_seen(s)) daft_entity_set_visible(h->def.scene, s->entity, false, NULL);
}

/* ---- life ---- */

static void forget(particle_system *s)
{
    host *h = s->h;
    for (particle_system **at = &h->particles; *at; at = &(*at)->next)
        if (*at == s) {
            *at = s->next;
            break;
        }
    h->particle_count -= s->capacity;
    if (daft_entity_is_valid(h->def.scene, s->entity)) daft_entity_destroy(h->def.scene, s->entity, NULL);
    if (s->mesh.id) daft_mesh_release(h->def.scene, s->mesh, NULL);
    void *const arrays[] = {s->all, s->positions, s->normals, s->order, s->spare};
    for (size_t i = 0; i < COUNT_OF(arrays); i++) memory_release(h->def.memory, arrays[i]);
    daft_engine_unreserve(h->def.engine, s->bytes);
    s->h = NULL;
}

int api_release_particles(lua_State *L)
{
    particle_system *s = lua_touserdata(L, 1);
    if (s && s->h) forget(s);
    return 0;
}

/* Registry key of the table that keeps systems alive, by id. */
static const char SYSTEMS_KEY;

static void keep_alive(lua_State *L, int index, bool keep)
{
    const particle_system *s = lua_touserdata(L, index);
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &SYSTEMS_KEY) == LUA_TNIL) {
        lua_pop(L, 1);
        lua_newtable(L);
        lua_pushvalue(L, -1);
        lua_rawsetp(L, LUA_REGISTRYINDEX, &SYSTEMS_KEY);
    }
    if (keep)
        lua_pushvalue(L, index);
    else
        lua_pushnil(L);
    lua_rawseti(L, -2, (lua_Integer)s->handle.id);
    lua_pop(L, 1);
}

/* `count` is at most what daft_engine_reserve has granted. */
static void *take_zero(const host *h, uint64_t count, size_t size)
{
    void *memory = memory_take(h->def.memory, (size_t)count * size);
    if (memory) memset(memory, 0, (size_t)count * size);
    return memory;
}

/* False: memory is out. */
static bool allocate(particle_system *s, uint32_t count, uint32_t corners)
{
    const uint64_t vertices = (uint64_t)count * corners;
    const uint64_t bytes = count * (sizeof(particle) + 2 * sizeof(uint64_t)) + vertices * 2 * sizeof(daft_vec3);
    if (!daft_engine_reserve(s->h->def.engine, bytes)) return false;
    s->bytes = bytes;
    s->all = take_zero(s->h, count, sizeof *s->all);
    s->positions = take_zero(s->h, vertices, sizeof *s->positions);
    s->normals = take_zero(s->h, vertices, sizeof *s->normals);
    s->order = take_zero(s->h, count, sizeof *s->order);
    s->spare = take_zero(s->h, count, sizeof *s->spare);
    s->capacity = count, s->corners = corners;
    s->h->particle_count += count;
    return s->all && s->positions && s->normals && s->order && s->spare;
}

/* A fan of triangles for each particle; at first they stand along a Morton curve. */
static bool make_mesh(particle_system *s, daft_error *error)
{
    const uint32_t triangles = s->corners - 2, count = s->capacity * triangles;
    uint32_t *indices = malloc((size_t)count * 3 * sizeof *indices);
    daft_vec2 *uvs = malloc((size_t)s->capacity * s->corners * sizeof *uvs);
    const axes level = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (uint32_t i = 0; indices && uvs && i < s->capacity; i++) {
        for (uint32_t k = 0; k < s->corners; k++) {
            float x, y;
            corner_of(s->corners, k, &x, &y);
            const float wide = s->corners == QUAD ? 0.70710678f : 0.5f;
            uvs[i * s->corners + k] = (daft_vec2){0.5f + wide * x, 0.5f + wide * y};
            s->positions[i * s->corners + k] = (daft_vec3){
                (float)gather_bits(i) + 0.2f * x, (float)gather_bits(i >> 1) + 0.2f * y, (float)gather_bits(i >> 2)};
            s->normals[i * s->corners + k] = level.back;
        }
        for (uint32_t k = 0; k < triangles; k++) {
            uint32_t *corner = indices + 3 * ((size_t)i * triangles + k);
            corner[0] = i * s->corners, corner[1] = i * s->corners + k + 1, corner[2] = i * s->corners + k + 2;
        }
    }
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = s->positions, def.normals = s->normals, def.uvs = uvs, def.indices = indices;
    def.vertex_count = s->capacity * s->corners, def.triangle_count = count;
    if (indices && uvs) s->mesh = daft_mesh_create(s->h->def.scene, &def, error);
    free(indices), free(uvs);
    return s->mesh.id != 0;
}

static bool make_entity(particle_system *s, daft_material material, daft_error *error)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = s->mesh, def.material = material;
    def.position = s->origin, def.visible = false, def.casts_shadow = false;
    s->entity = daft_entity_create(s->h->def.scene, &def, error);
    return s->entity.id != 0;
}

/* ---- what the script says ---- */

static float read_limited(lua_State *L, host *h, const char *name, float low, float high)
{
    const float value = api_float(L, h, -1, name);
    if (!(value >= low && value <= high))
        api_error(L, h, "%s: %g to %g expected, got %g", name, (double)low, (double)high, (double)value);
    return value;
}

/* What daft.particles is told. */
typedef struct particles_wish {
    uint32_t count, shape; /* shape: 0 round, 1 quad */
    daft_material material;
    daft_dvec3 place;
    daft_entity carrier;
    daft_vec3 direction, gravity;
    range life, speed, size;
    float spread, area, drag, rate;
    lua_Integer seed;
} particles_wish;

/* A number, or {low, high}. */
static range read_range(lua_State *L, host *h, const char *name, float low)
{
    range r;
    if (lua_type(L, -1) == LUA_TNUMBER) {
        r.low = r.high = read_limited(L, h, name, low, LONGEST);
        return r;
    }
    if (!lua_istable(L, -1) || lua_rawlen(L, -1) != 2) api_wrong(L, h, -1, name, "number or {from, to}");
    for (int i = 0; i < 2; i++) {
        lua_rawgeti(L, -1, i + 1);
        *(i ? &r.high : &r.low) = read_limited(L, h, name, low, LONGEST);
        lua_pop(L, 1);
    }
    return r;
}

static void read_life(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((particles_wish *)out)->life = read_range(L, h, "life", 1e-3f);
}

static void read_speed(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((particles_wish *)out)->speed = read_range(L, h, "speed", 0);
}

static void read_size(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((particles_wish *)out)->size = read_range(L, h, "size", 0);
}

static daft_vec3 unit(lua_State *L, host *h, daft_vec3 v)
{
    const double length = sqrt((double)v.x * (double)v.x + (double)v.y * (double)v.y + (double)v.z * (double)v.z);
    if (!(length > 1e-12) || !isfinite(length)) api_error(L, h, "direction: it has no length");
    return (daft_vec3){(float)((double)v.x / length), (float)((double)v.y / length), (float)((double)v.z / length)};
}

/* The place at `index`; an entity there carries what begins. */
static void read_place(lua_State *L, host *h, int index, daft_dvec3 *place, daft_entity *carrier)
{
    const api_handle *at = api_test_handle(L, index, API_ENTITY);
    *place = api_place(L, h, index, "position");
    carrier->id = at ? at->id : 0;
}

static void read_position(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    read_place(L, h, lua_gettop(L), &((particles_wish *)out)->place, &((particles_wish *)out)->carrier);
}

static void read_direction(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((particles_wish *)out)->direction = unit(L, h, api_vec3(L, h, -1, "direction"));
}

static void read_seed(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((particles_wish *)out)->seed = api_whole(L, h, -1, "seed");
}

static void set_default(void *out)
{
    const particles_wish wish = {
        .count = 1000, .direction = {0, 1, 0}, .life = {1, 1}, .speed = {1, 1}, .size = {0.05f, 0.05f}, .spread = 0.5f};
    memcpy(out, &wish, sizeof wish);
}

static const char *const SHAPES[] = {"round", "quad"};

#define ROW(member, kind, ...) API_ROW(particles_wish, member, #member, kind, __VA_ARGS__)

static const daft_field ROWS[] = {
    ROW(count, DAFT_FIELD_UINT, .min = 1, .max = MOST, .doc = "The most at once"),
    ROW(material, DAFT_FIELD_MATERIAL, .doc = "What they look like; sparks and flames have an emission"),
    ROW(area, DAFT_FIELD_FLOAT, .unit = "m", .max = 1e4, .doc = "Radius around their place in which they begin"),
    ROW(direction, DAFT_FIELD_DIRECTION, .doc = "Where they fly"),
    ROW(spread, DAFT_FIELD_FLOAT, .unit = "rad", .max = (double)3.1415927f,
        .doc = "The angle around it within which they do; pi: everywhere"),
    ROW(gravity, DAFT_FIELD_VEC3, .unit = "m/s²", .doc = "What pulls them"),
    ROW(drag, DAFT_FIELD_FLOAT, .unit = "1/s", .max = 1000,
        .doc = "The fraction of its speed that one loses in a second, where it is small"),
    ROW(rate, DAFT_FIELD_FLOAT, .unit = "1/s", .max = MOST * 60.0, .doc = "How many begin in a second"),
    ROW(shape, DAFT_FIELD_CHOICE, .choices = SHAPES, .choice_count = COUNT_OF(SHAPES),
        .doc = "Octagons, or squares with a texture's whole picture"),
};
const api_list api_particles_list = {ROWS, COUNT_OF(ROWS), set_default};
static const api_special SPECIALS[] = {
    {.name = "direction", .read = read_direction},
    {"position", read_position, NULL, "{x, y, z} or entity, m",
     "Where they begin: a place, or an entity that carries the system; {0, 0, 0} unless given"},
    {"speed", read_speed, NULL, "number or {from, to}, m/s", "Of each, chosen between the two; 1 unless given"},
    {"life", read_life, NULL, "number or {from, to}, s", "Of each, chosen between the two; 1 unless given"},
    {"size", read_size, NULL, "number or {from, to}, m",
     "The radius, from the beginning to the end of a life; 0.05 unless given"},
    {"seed", read_seed, NULL, "whole number", "Of its sequence of random numbers; 0 unless given"}};
const api_form api_particles_form = {"particles", "daft.particles", DAFT_STRUCT_COUNT,
                                     -1,          SPECIALS,         COUNT_OF(SPECIALS)};

static int create(lua_State *L, host *h)
{
    particles_wish wish;
    set_default(&wish);
    lua_settop(L, 1);
    particle_system *s = lua_newuserdatauv(L, sizeof *s, 0);
    memset(s, 0, sizeof *s);
    api_set_type(L, API_PARTICLES);
    api_read_struct(L, h, 1, NULL, &api_particles_form, &wish);
    if (h->particle_count + (uint64_t)wish.count > MOST_OF_ALL)
        api_error(L, h, "count: all systems together have at most %d particles", (int)MOST_OF_ALL);
    s->life = wish.life, s->speed = wish.speed, s->size = wish.size;
    s->spread = wish.spread, s->area = wish.area, s->drag = wish.drag, s->rate = wish.rate;
    s->direction = wish.direction, s->gravity = wish.gravity;
    s->place = s->origin = wish.place, s->carrier = wish.carrier;
    random_seed(&s->random, (uint64_t)wish.seed);
    s->handle.id = ++h->systems;
    s->h = h, s->next = h->particles, h->particles = s;
    daft_error error = {0};
    if (!allocate(s, wish.count, wish.shape == 0 ? ROUND : QUAD)) {
        forget(s);
        api_error(L, h, "not enough memory");
    }
    if (!make_mesh(s, &error) || !make_entity(s, wish.material, &error)) {
        forget(s);
        api_engine_error(L, h, &error);
    }
    keep_alive(L, 2, true);
    lua_settop(L, 2);
    return 1;
}

static particle_system *system_at(lua_State *L, host *h)
{
    particle_system *s = (particle_system *)api_check_handle(L, h, 1, API_PARTICLES, "particles");
    if (!s->h) api_error(L, h, "they have been destroyed");
    return s;
}

static int burst(lua_State *L, host *h)
{
    particle_system *s = system_at(L, h);
    const lua_Integer count = api_whole(L, h, 2, "count");
    if (count < 0) api_error(L, h, "count: 0 or more expected, got %lld", (long long)count);
    follow(s);
    const daft_dvec3 place = lua_isnoneornil(L, 3) ? s->place : api_place(L, h, 3, "place");
    emit(s, count < MOST ? (uint32_t)count : MOST, place);
    return 0;
}

static int rate(lua_State *L, host *h)
{
    particle_system *s = system_at(L, h);
    if (lua_gettop(L) < 2) {
        lua_pushnumber(L, (double)s->rate);
        return 1;
    }
    api_check_may_change(L, h);
    lua_settop(L, 2);
    s->rate = read_limited(L, h, "rate", 0, MOST * 60.0f);
    return 0;
}

static int position(lua_State *L, host *h)
{
    particle_system *s = system_at(L, h);
    read_place(L, h, 2, &s->place, &s->carrier);
    return 0;
}

static int direction(lua_State *L, host *h)
{
    particle_system *s = system_at(L, h);
    s->direction = unit(L, h, api_triple(L, h, 2, "direction"));
    return 0;
}

static int count(lua_State *L, host *h)
{
    lua_pushinteger(L, (lua_Integer)system_at(L, h)->count);
    return 1;
}

static int clear(lua_State *L, host *h)
{
    system_at(L, h)->count = 0;
    return 0;
}

static int destroy(lua_State *L, host *h)
{
    particle_system *s = system_at(L, h);
    keep_alive(L, 1, false);
    forget(s);
    return 0;
}

static int valid(lua_State *L, host *h)
{
    lua_pushboolean(L, ((particle_system *)api_check_handle(L, h, 1, API_PARTICLES, "particles"))->h != NULL);
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"particles", "{...} -> particles", "Many small things that fly and are only seen: no ray and no body meets them.",
     create, API_CHANGES},
    {"particles:burst", "(count [, place])", "So many at once, as far as there is room.", burst, API_CHANGES},
    {"particles:rate", "([rate]) -> rate", "How many begin in a second.", rate, 0},
    {"particles:position", "(place)", "Where they begin: a place, or an entity that carries them.", position,
     API_CHANGES},
    {"particles:direction", "(x, y, z)", "Where they fly.", direction, API_CHANGES},
    {"particles:count", "() -> number", "How many there are now.", count, 0},
    {"particles:clear", "()", "Takes away those that fly.", clear, API_CHANGES},
    {"particles:destroy", "()", "Takes it out of the game.", destroy, API_CHANGES},
    {"particles:valid", "() -> boolean", "False once it has been destroyed.", valid, 0},
};

const api_area api_particles = {"Particles", FUNCTIONS, COUNT_OF(FUNCTIONS)};
