/* Characters of a scene: sim/ moves them after each of the world's steps; the entity of one follows it. */
#include "scene/scene.h"

daft_character_def daft_default_character_def(void)
{
    daft_character_def def;
    daft_struct_default(DAFT_STRUCT_CHARACTER_DEF, &def);
    return def;
}

static bool read_def(daft_scene *scene, const daft_character_def *def, daft_sim_character_def *out, daft_error *error)
{
    if (!daft_check_pointer(error, "def", def) || !daft_struct_check(DAFT_STRUCT_CHARACTER_DEF, def, error))
        return false;
    *out = (daft_sim_character_def){.position = def->position,
                                    .radius = def->radius,
                                    .height = def->height,
                                    .step_height = def->step_height,
                                    .max_slope = def->max_slope,
                                    .acceleration = def->acceleration,
                                    .air_acceleration = def->air_acceleration,
                                    .gravity_scale = def->gravity_scale,
                                    .mass = def->mass,
                                    .push_force = def->push_force,
                                    .layers = def->layers,
                                    .mask = def->mask};
    if (def->entity.id == 0) return true;
    const daft_entity_item *item = daft_entity_find(scene, def->entity, error);
    if (!item) return false;
    if (item->def.parent.id) return daft_fail(error, DAFT_ERROR_ARGUMENT, "a character's entity must have no parent");
    if (item->def.body == DAFT_BODY_DYNAMIC)
        return daft_fail(error, DAFT_ERROR_ARGUMENT,
                         "a character's entity is dynamic; it must be kinematic or no body");
    out->ignore = item->body;
    return true;
}

/* The entity goes where the character is. */
static bool move_entity(daft_scene *scene, const daft_character_item *c, bool teleport, daft_error *error)
{
    daft_transform t;
    if (c->entity.id == 0 || !daft_entity_is_valid(scene, c->entity)) return true;
    if (!daft_entity_get_transform(scene, c->entity, &t, error)) return false;
    daft_dvec3 p = c->now.position;
    if (t.position.x == p.x && t.position.y == p.y && t.position.z == p.z) return true;
    t.position = p;
    return daft_entity_set_transform(scene, c->entity, &t, teleport, error);
}

void daft_characters_move_entities(daft_scene *scene)
{
    for (uint32_t i = 0; i < scene->character_slots.count; i++)
        if (scene->character_slots.items[i].live) move_entity(scene, &scene->characters[i], true, NULL);
}

daft_character daft_character_create(daft_scene *scene, const daft_character_def *def, daft_error *error)
{
    daft_character_item item = {0};
    daft_sim_character_def sim;
    const daft_character none = {0};
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !read_def(scene, def, &sim, error) ||
        !daft_sim_character_init(&item.now, &sim, error) || !daft_scene_world(scene, error))
        return none;
    uint32_t needed = daft_slots_needed(&scene->character_slots, 1);
    if (needed > DAFT_MAX_SLOTS) {
        daft_fail(error, DAFT_ERROR_ARGUMENT, "a scene holds at most %d characters", DAFT_MAX_SLOTS);
        return none;
    }
    if (!daft_slots_reserve(&scene->character_slots, scene->allocator, 1) ||
        !daft_grow(scene->allocator, &scene->characters, &scene->character_capacity, needed,
                   scene->character_slots.count, sizeof *scene->characters)) {
        daft_fail_memory(error, "the list of characters");
        return none;
    }
    item.entity = def->entity;
    if (!move_entity(scene, &item, true, error)) return none;
    daft_character character = {daft_slots_add(&scene->character_slots)};
    scene->characters[daft_handle_index(character.id)] = item;
    return character;
}

static daft_character_item *find(const daft_scene *scene, daft_character character, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene)) return NULL;
    uint32_t index = daft_slots_find(&scene->character_slots, character.id);
    if (index != DAFT_NONE) return &scene->characters[index];
    if (character.id == 0)
        daft_fail(error, DAFT_ERROR_HANDLE, "the character is none (0)");
    else
        daft_fail(error, DAFT_ERROR_HANDLE, "character 0x%x is stale: it was destroyed, or is not one of this scene",
                  character.id);
    return NULL;
}

static daft_character_item *change(const daft_scene *scene, daft_character character, daft_error *error)
{
    return daft_scene_ready(scene, error) ? find(scene, character, error) : NULL;
}

bool daft_character_destroy(daft_scene *scene, daft_character character, daft_error *error)
{
    if (!change(scene, character, error)) return false;
    daft_slots_remove(&scene->character_slots, daft_handle_index(character.id));
    return true;
}

bool daft_character_is_valid(const daft_scene *scene, daft_character character)
{
    return scene && daft_slots_find(&scene->character_slots, character.id) != DAFT_NONE;
}

bool daft_character_walk(daft_scene *scene, daft_character character, daft_vec3 velocity, daft_error *error)
{
    daft_character_item *c = change(scene, character, error);
    if (!c || !daft_check_finite3(error, "velocity", velocity)) return false;
    c->wish.velocity = velocity;
    return true;
}

bool daft_character_jump(daft_scene *scene, daft_character character, float speed, daft_error *error)
{
    daft_character_item *c = change(scene, character, error);
    if (!c || !daft_check_range(error, "speed", (double)speed, 0, 1e4, "from 0 to 1e4 m/s")) return false;
    c->wish.jump = speed;
    return true;
}

bool daft_character_teleport(daft_scene *scene, daft_character character, daft_dvec3 position, daft_error *error)
{
    daft_character_item *c = change(scene, character, error);
    return c && daft_sim_character_teleport(&c->now, position, error) && move_entity(scene, c, true, error);
}

bool daft_character_set_height(daft_scene *scene, daft_character character, float height, daft_error *error)
{
    daft_character_item *c = change(scene, character, error);
    return c && daft_sim_character_set_height(scene->world, &c->now, height, error) &&
           move_entity(scene, c, false, error);
}

bool daft_character_get(daft_scene *scene, daft_character character, daft_character_state *out, daft_error *error)
{
    const daft_character_item *c = find(scene, character, error);
    if (!c || !daft_check_pointer(error, "out", out)) return false;
    *out = (daft_character_state){.position = c->now.position,
                                  .velocity = c->now.velocity,
                                  .height = c->now.def.height,
                                  .grounded = c->now.grounded,
                                  .sliding = c->now.sliding,
                                  .crushed = c->now.crushed,
                                  .ground_normal = c->now.ground_normal,
                                  .turn = c->now.turn};
    if (c->now.grounded) out->ground.id = daft_world_user(scene->world, c->now.ground);
    return true;
}

bool daft_characters_step(daft_scene *scene, float dt, daft_error *error)
{
    for (uint32_t i = 0; i < scene->character_slots.count; i++) {
        daft_character_item *c = &scene->characters[i];
        if (!scene->character_slots.items[i].live) continue;
        if (!daft_entity_is_valid(scene, c->entity)) c->entity.id = c->now.def.ignore = 0;
        if (!daft_sim_character_move(scene->world, &c->now, &c->wish, dt, error) ||
            !move_entity(scene, c, false, error))
            return false;
        c->wish.jump = 0;
    }
    return true;
}

uint64_t daft_characters_hash(const daft_scene *scene, uint64_t hash)
{
    for (uint32_t i = 0; i < scene->character_slots.count; i++)
        if (scene->character_slots.items[i].live) hash = daft_sim_character_hash(&scene->characters[i].now, hash);
    return hash;
}
