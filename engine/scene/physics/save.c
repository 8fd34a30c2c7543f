/* The bodies' state as bytes: which entity has which body, the joints' handles, the characters, and the world's own
 * bytes.
 *
 *   header, `bodies` × {entity, body}, `joints` × slot, `joints` × joint, `characters` × character, the world
 *
 * What it needs to be in the scene, entities with their bodies and characters, is compared before anything is changed.
 */
#include "scene/scene.h"

#include <string.h>

static const char MAGIC[8] = "DAFTSIM";

typedef struct state_header {
    char magic[8];
    uint32_t version, header_bytes;
    uint32_t bodies, joints; /* joints: slots ever used */
    uint32_t characters, pad;
    uint32_t live, free_count, first_free, last_free; /* of the joints' slots */
    uint64_t world_bytes;
} state_header;

typedef struct state_body {
    uint32_t entity, body;
} state_body;

typedef struct state_character {
    uint32_t character;
    daft_sim_walk_wish wish;
    daft_sim_character now;
} state_character;

static uint32_t count_bodies(const daft_scene *scene)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->entity_slots.count; i++)
        count += scene->entity_slots.items[i].live && scene->entities[i].body;
    return count;
}

static size_t fixed_bytes(const state_header *h)
{
    return sizeof *h + h->bodies * sizeof(state_body) + h->joints * (sizeof(daft_slot) + sizeof(daft_joint_item)) +
           h->characters * sizeof(state_character);
}

static void write_state(const daft_scene *scene, const state_header *header, const void *world, char *out)
{
    memcpy(out, header, sizeof *header);
    out += sizeof *header;
    for (uint32_t i = 0; i < scene->entity_slots.count; i++) {
        if (!scene->entity_slots.items[i].live || !scene->entities[i].body) continue;
        state_body body = {daft_slots_handle(&scene->entity_slots, i), scene->entities[i].body};
        memcpy(out, &body, sizeof body);
        out += sizeof body;
    }
    size_t slots = header->joints * sizeof(daft_slot), joints = header->joints * sizeof(daft_joint_item);
    if (slots) memcpy(out, scene->joint_slots.items, slots);
    out += slots;
    if (joints) memcpy(out, scene->joints, joints);
    out += joints;
    for (uint32_t i = 0; i < scene->character_slots.count; i++) {
        if (!scene->character_slots.items[i].live) continue;
        const daft_character_item *item = &scene->characters[i];
        state_character c;
        memset(&c, 0, sizeof c); /* padding is no state */
        c.character = daft_slots_handle(&scene->character_slots, i), c.wish = item->wish, c.now = item->now;
        memcpy(out, &c, sizeof c);
        out += sizeof c;
    }
    if (header->world_bytes) memcpy(out, world, (size_t)header->world_bytes);
}

size_t daft_scene_save_bodies(const daft_scene *scene, void *out, size_t capacity, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene)) return 0;
    void *world = NULL;
    size_t world_bytes = 0;
    if (scene->world && !daft_world_save(scene->world, &world, &world_bytes, error)) return 0;
    const daft_slots *slots = &scene->joint_slots;
    state_header header = {.version = 1,
                           .header_bytes = sizeof header,
                           .bodies = count_bodies(scene),
                           .joints = slots->count,
                           .characters = scene->character_slots.live,
                           .live = slots->live,
                           .free_count = slots->free_count,
                           .first_free = slots->first_free,
                           .last_free = slots->last_free,
                           .world_bytes = world_bytes};
    memcpy(header.magic, MAGIC, sizeof MAGIC);
    size_t size = fixed_bytes(&header) + world_bytes;
    if (out && capacity >= size) write_state(scene, &header, world, out);
    daft_release(scene->allocator, world);
    return size;
}

static bool damaged(daft_error *error)
{
    return daft_fail(error, DAFT_ERROR_SYNTAX, "these bytes are not a saved state of bodies, or are damaged");
}

static bool bodies_match(const daft_scene *scene, const state_header *header, const char *at, daft_error *error)
{
    if (header->bodies != count_bodies(scene))
        return daft_fail(error, DAFT_ERROR_ARGUMENT,
                         "the state has %u bodies and the scene has %u: it must be loaded into the same entities",
                         header->bodies, count_bodies(scene));
    for (uint32_t i = 0; i < header->bodies; i++) {
        state_body body;
        memcpy(&body, at + i * sizeof body, sizeof body);
        uint32_t index = daft_slots_find(&scene->entity_slots, body.entity);
        if (index == DAFT_NONE || scene->entities[index].body != body.body)
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "entity 0x%x of the state is not in the scene as it was",
                             body.entity);
    }
    return true;
}

static bool flag_at(const char *at, size_t offset) { return (unsigned char)at[offset] <= 1; }

/* What a character could have come to be. */
static bool character_sound(const char *at)
{
    state_character c;
    const char *now = at + offsetof(state_character, now);
    if (!flag_at(now, offsetof(daft_sim_character, grounded)) || !flag_at(now, offsetof(daft_sim_character, sliding)) ||
        !flag_at(now, offsetof(daft_sim_character, crushed)))
        return false;
    memcpy(&c, at, sizeof c);
    const daft_sim_character *n = &c.now;
    daft_sim_character made;
    return daft_sim_character_init(&made, &n->def, NULL) && daft_body_check_position(n->position, NULL) &&
           daft_finite3(n->velocity) && daft_finite3(n->ground_normal) && daft_finite3(n->ground_velocity) &&
           isfinite(n->turn) && daft_dfinite3(n->ground_local) && daft_dfinite3(n->ground_position) &&
           daft_check_rotation(NULL, "", n->ground_rotation) && daft_finite3(c.wish.velocity) && c.wish.jump >= 0 &&
           c.wish.jump <= 1e4f;
}

static bool characters_match(const daft_scene *scene, const state_header *header, const char *at, daft_error *error)
{
    bool same = header->characters == scene->character_slots.live;
    for (uint32_t i = 0; same && i < header->characters; i++, at += sizeof(state_character)) {
        uint32_t handle;
        memcpy(&handle, at, sizeof handle);
        same = daft_slots_find(&scene->character_slots, handle) != DAFT_NONE;
        if (same && !character_sound(at)) return damaged(error);
    }
    return same || daft_fail(error, DAFT_ERROR_ARGUMENT, "the scene has not the characters that the state has");
}

static void characters_load(daft_scene *scene, uint32_t count, const char *at)
{
    for (uint32_t i = 0; i < count; i++, at += sizeof(state_character)) {
        state_character c;
        memcpy(&c, at, sizeof c);
        daft_character_item *item = &scene->characters[daft_handle_index(c.character)];
        item->now = c.now, item->wish = c.wish;
    }
    daft_characters_move_entities(scene);
}

/* A list of slots is sound where each free one is in the queue once. */
static bool slots_sound(const state_header *h, const char *at)
{
    uint32_t live = 0, seen = 0;
    daft_slot slot;
    for (uint32_t i = 0; i < h->joints; i++) {
        memcpy(&slot, at + i * sizeof slot, sizeof slot.next_free + sizeof slot.generation);
        unsigned char flag = (unsigned char)at[i * sizeof slot + offsetof(daft_slot, live)];
        if (flag > 1 || slot.generation > DAFT_MAX_GENERATION) return false;
        live += flag;
    }
    for (uint32_t i = h->first_free; i != DAFT_NONE; seen++) {
        if (i >= h->joints || seen >= h->free_count || at[i * sizeof slot + offsetof(daft_slot, live)]) return false;
        if (seen + 1 == h->free_count && i != h->last_free) return false;
        memcpy(&slot.next_free, at + i * sizeof slot + offsetof(daft_slot, next_free), sizeof slot.next_free);
        i = slot.next_free;
    }
    return live == h->live && seen == h->free_count;
}

static bool joints_reserve(daft_scene *scene, uint32_t count, daft_error *error)
{
    daft_slots *slots = &scene->joint_slots;
    return (daft_grow(scene->allocator, &slots->items, &slots->capacity, count, slots->count, sizeof *slots->items) &&
            daft_grow(scene->allocator, &scene->joints, &scene->joint_capacity, count, slots->count,
                      sizeof *scene->joints)) ||
           daft_fail_memory(error, "the list of joints");
}

static bool header_read(const void *bytes, size_t size, state_header *h)
{
    if (!bytes || size < sizeof *h) return false;
    memcpy(h, bytes, sizeof *h);
    return memcmp(h->magic, MAGIC, sizeof MAGIC) == 0 && h->version == 1 && h->header_bytes == sizeof *h &&
           h->bodies <= DAFT_MAX_SLOTS && h->joints <= DAFT_MAX_SLOTS && h->characters <= DAFT_MAX_SLOTS &&
           fixed_bytes(h) <= size && h->world_bytes == size - fixed_bytes(h);
}

bool daft_scene_load_bodies(daft_scene *scene, const void *bytes, size_t size, daft_error *error)
{
    state_header h;
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error)) return false;
    if (!header_read(bytes, size, &h)) return damaged(error);
    const char *bodies = (const char *)bytes + sizeof h, *slots = bodies + h.bodies * sizeof(state_body);
    const char *joints = slots + h.joints * sizeof(daft_slot),
               *characters = joints + h.joints * sizeof(daft_joint_item);
    const char *world = characters + h.characters * sizeof(state_character);
    if (!bodies_match(scene, &h, bodies, error) || !characters_match(scene, &h, characters, error)) return false;
    if (!slots_sound(&h, slots)) return damaged(error);
    if (h.world_bytes == 0) return true; /* there was no world, so there is no body to put back */
    if (!joints_reserve(scene, h.joints, error) || !daft_scene_world(scene, error) ||
        !daft_world_load(scene->world, world, (size_t)h.world_bytes, daft_geometry_find, scene, error))
        return false;
    if (h.joints) {
        memcpy(scene->joint_slots.items, slots, h.joints * sizeof(daft_slot));
        memcpy(scene->joints, joints, h.joints * sizeof(daft_joint_item));
    }
    daft_slots *s = &scene->joint_slots;
    s->count = h.joints, s->live = h.live, s->free_count = h.free_count, s->first_free = h.first_free,
    s->last_free = h.last_free;
    daft_scene_pull_all_poses(scene);
    characters_load(scene, h.characters, characters);
    return true;
}
