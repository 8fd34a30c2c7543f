/* A list: games have some dozens of sounds, and look one up when it is made. */
#include "sound/cache.h"

#include "common/util.h"

#include <string.h>

struct sound_cache {
    daft_allocator memory; /* that it is from; all zero: malloc */
    uint32_t holders;
    sound *first;
};

sound_cache *sound_cache_open(const daft_allocator *memory)
{
    sound_cache *self = memory_take(memory, sizeof *self);
    if (!self) return NULL;
    *self = (sound_cache){.holders = 1};
    if (memory) self->memory = *memory;
    return self;
}

sound_cache *sound_cache_hold(sound_cache *self)
{
    self->holders++;
    return self;
}

void sound_cache_release(sound_cache *self)
{
    if (!self || --self->holders) return;
    const daft_allocator memory = self->memory;
    memory_release(&memory, self);
}

/* ---- keys ---- */

/* Of two hundred sounds two have the same 64 bits by chance once in 10^15 games. */
static sound_key key_of(const void *bytes, size_t size, sound_key before)
{
    return (sound_key){daft_hash(bytes, size, before.hash), before.size + size};
}

sound_key sound_key_of_file(const void *bytes, size_t size) { return key_of(bytes, size, (sound_key){1, 0}); }

sound_key sound_key_of_synth(const synth_def *def)
{
    const double numbers[] = {def->wave, def->pitch,   def->slide,        def->attack, def->hold,  def->decay,
                              def->cut,  def->vibrato, def->vibrato_rate, def->duty,   def->volume};
    sound_key key = key_of(numbers, sizeof numbers, (sound_key){2, 0});
    if (!def->notes) return key;
    key = key_of(&def->beat, sizeof def->beat, key);
    return key_of(def->notes, strlen(def->notes) + 1, key);
}

/* ---- sounds ---- */

sound *sound_cache_find(const sound_cache *self, sound_key key)
{
    for (sound *s = self ? self->first : NULL; s; s = s->next)
        if (s->key.hash == key.hash && s->key.size == key.size) return sound_hold(s);
    return NULL;
}

void sound_cache_add(sound_cache *self, sound_key key, sound *what)
{
    if (!self) return;
    what->key = key, what->next = self->first, what->link = &self->first;
    if (self->first) self->first->link = &what->next;
    self->first = what;
}
