/* A byte of a hash for each kind of what an entity is. */
#include "game/fingerprint.h"

#include <stdio.h>
#include <string.h>

static uint32_t byte_of(const void *bytes, size_t size, int shift)
{
    const uint64_t hash = daft_hash(bytes, size, 0);
    return (uint32_t)((hash ^ hash >> 32) & 0xff) << shift;
}

uint32_t fingerprint(daft_scene *scene, daft_entity entity)
{
    daft_entity_def def;
    daft_vec3 velocity[2] = {{0}};
    unsigned char rest[1024];
    if (!daft_entity_get(scene, entity, &def, NULL)) return 0;
    if (def.body == DAFT_BODY_DYNAMIC || def.body == DAFT_BODY_KINEMATIC)
        daft_entity_get_velocity(scene, entity, &velocity[0], &velocity[1], NULL);
    uint32_t print = byte_of(&def.position, sizeof def.position, 0) | byte_of(&def.rotation, sizeof def.rotation, 8) |
                     byte_of(velocity, sizeof velocity, 16);
    def.position = (daft_dvec3){0}, def.rotation = (daft_quat){0, 0, 0, 1};
    const size_t size = daft_struct_pack(DAFT_STRUCT_ENTITY_DEF, &def, rest, sizeof rest);
    return print | byte_of(rest, size < sizeof rest ? size : sizeof rest, 24);
}

const char *fingerprint_name(uint32_t differs, char *buffer, size_t size)
{
    static const char *const NAMES[] = {"position", "rotation", "velocity", "other fields"};
    buffer[0] = 0;
    for (int i = 0; i < 4; i++) {
        if (!(differs >> 8 * i & 0xff)) continue;
        const size_t used = strlen(buffer);
        snprintf(buffer + used, size - used, "%s%s", used ? ", " : "", NAMES[i]);
    }
    return buffer;
}
