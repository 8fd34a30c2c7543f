/* Any bytes as a saved state of bodies: as they are, or as changes of a good one. What loads goes on without harm and
 * is finite; what does not leaves the scene as it was. */
#include "fuzz.h"

#include <math.h>
#include <string.h>

enum { BODIES = 6, WORLD_HEADER = 112, TICKS = 5 };

typedef struct stand {
    daft_engine *engine;
    daft_scene *scene;
    daft_entity bodies[BODIES];
} stand;

/* Boxes and spheres on a floor, a hinge and a character. */
static void build(stand *s)
{
    s->scene = daft_scene_create(s->engine, NULL);
    FUZZ_CHECK(s->scene);
    for (int i = 0; i < BODIES; i++) {
        daft_entity_def def = daft_default_entity_def();
        def.shape = i % 2 ? DAFT_SHAPE_SPHERE : DAFT_SHAPE_BOX;
        def.body = i ? DAFT_BODY_DYNAMIC : DAFT_BODY_STATIC;
        if (!i) def.size = (daft_vec3){9, 1, 9};
        def.position = (daft_dvec3){0.3 * i, i, 0};
        s->bodies[i] = daft_entity_create(s->scene, &def, NULL);
        FUZZ_CHECK(s->bodies[i].id);
    }
    daft_joint_def joint = daft_default_joint_def();
    joint.kind = DAFT_JOINT_HINGE;
    joint.a = s->bodies[1], joint.b = s->bodies[2];
    joint.axis = (daft_vec3){0, 0, 1};
    FUZZ_CHECK(daft_joint_create(s->scene, &joint, NULL).id);
    daft_character_def walker = daft_default_character_def();
    walker.position = (daft_dvec3){3, 2, 0};
    FUZZ_CHECK(daft_character_create(s->scene, &walker, NULL).id);
    for (int i = 0; i < TICKS; i++) FUZZ_CHECK(daft_scene_step(s->scene, 1.0f / 60, NULL));
}

/* Changes of a good state, four bytes each: where, what, and whether it is set or added. */
static void change(uint8_t *state, size_t state_size, const uint8_t *data, size_t size)
{
    for (size_t i = 0; i + 4 <= size; i += 4) {
        size_t at = (size_t)(data[i] | data[i + 1] << 8) % state_size;
        state[at] = data[i + 3] & 1 ? data[i + 2] : (uint8_t)(state[at] + data[i + 2]);
    }
}

/* The hash in the header of the world, which is at the end, so that changes get past it. */
static void sign(uint8_t *state, size_t size)
{
    uint64_t world;
    memcpy(&world, state + 48, sizeof world); /* state_header.world_bytes of engine/scene/physics/save.c */
    if (world <= WORLD_HEADER || world > size) return;
    uint8_t *at = state + size - world;
    uint64_t hash = daft_hash(at + WORLD_HEADER, world - WORLD_HEADER, 0);
    memcpy(at + WORLD_HEADER - sizeof hash, &hash, sizeof hash);
}

static void go_on(stand *s)
{
    daft_error error = {0};
    for (int i = 0; i < TICKS; i++) FUZZ_CHECK(daft_scene_step(s->scene, 1.0f / 60, &error));
    for (int i = 0; i < BODIES; i++) {
        daft_transform pose;
        FUZZ_CHECK(daft_entity_get_transform(s->scene, s->bodies[i], &pose, &error));
        FUZZ_CHECK(isfinite(pose.position.x) && isfinite(pose.position.y) && isfinite(pose.rotation.w));
    }
}

int state_input(const uint8_t *data, size_t size)
{
    static stand s;
    if (!s.engine) {
        daft_engine_def def = daft_default_engine_def();
        def.threads = 1;
        s.engine = daft_engine_create(&def, NULL);
        FUZZ_CHECK(s.engine);
    }
    if (size == 0) return 0;
    build(&s);
    daft_error error = {0};
    uint64_t before = daft_scene_hash(s.scene);
    size_t good_size = daft_scene_save_bodies(s.scene, NULL, 0, NULL);
    uint8_t *state = malloc(good_size);
    FUZZ_CHECK(state && daft_scene_save_bodies(s.scene, state, good_size, NULL) == good_size);
    bool raw = data[0] == 255;
    if (!raw) change(state, good_size, data + 1, size - 1);
    if (data[0] & 1) sign(state, good_size);
    bool good = raw ? daft_scene_load_bodies(s.scene, data + 1, size - 1, &error)
                    : daft_scene_load_bodies(s.scene, state, good_size, &error);
    fuzz_check_error(good, &error);
    FUZZ_CHECK(good || daft_scene_hash(s.scene) == before);
    go_on(&s);
    free(state);
    daft_scene_destroy(s.scene);
    return 0;
}
