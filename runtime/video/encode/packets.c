/* The encoded frames of one clip. A file is a clip_head, then the packets' bytes as in memory, of this machine's order.
 */
#include "video/encode/packets.h"

#include "common/util.h"

#include <stdlib.h>
#include <string.h>

typedef struct clip_head {
    char magic[8];
    uint64_t key, hash, size;
    uint32_t frames, unused;
} clip_head;

static const char MAGIC[8] = "daftclip";

bool packets_add(packet_list *list, const packet *head, const uint8_t *bytes)
{
    size_t needed = list->size + sizeof *head + head->size;
    if (needed > list->capacity) {
        size_t capacity = needed * 2;
        uint8_t *more = realloc(list->bytes, capacity);
        if (!more) return false;
        list->bytes = more, list->capacity = capacity;
    }
    memcpy(list->bytes + list->size, head, sizeof *head);
    if (head->size > 0) memcpy(list->bytes + list->size + sizeof *head, bytes, head->size);
    list->size = needed;
    return true;
}

const uint8_t *packets_next(const packet_list *list, size_t *at, packet *head)
{
    if (list->size - *at < sizeof *head) return NULL;
    memcpy(head, list->bytes + *at, sizeof *head);
    if (list->size - *at - sizeof *head < head->size) return NULL;
    const uint8_t *bytes = list->bytes + *at + sizeof *head;
    *at += sizeof *head + head->size;
    return bytes;
}

void packets_free(packet_list *list)
{
    free(list->bytes);
    *list = (packet_list){0};
}

static uint64_t hash_of(const clip_head *head, const void *bytes)
{
    return daft_hash(bytes, (size_t)head->size, head->key ^ head->frames);
}

bool packets_save(const packet_list *list, const char *path, uint64_t key, uint32_t frames, daft_error *error)
{
    clip_head head = {.key = key, .size = list->size, .frames = frames};
    memcpy(head.magic, MAGIC, sizeof MAGIC);
    head.hash = hash_of(&head, list->bytes);
    daft_writer *writer = daft_writer_begin(path, error);
    if (!writer) return false;
    daft_writer_put(writer, &head, sizeof head);
    daft_writer_put(writer, list->bytes, list->size);
    return daft_writer_commit(writer, error);
}

bool packets_load(packet_list *list, const char *path, uint64_t key, uint32_t *frames)
{
    clip_head head;
    size_t size;
    if (!path_is_file(path)) return false;
    char *bytes = daft_read_file(NULL, path, &size, NULL);
    bool good = bytes && size >= sizeof head;
    if (good) memcpy(&head, bytes, sizeof head);
    good = good && memcmp(head.magic, MAGIC, sizeof MAGIC) == 0 && head.key == key && head.size == size - sizeof head &&
           head.hash == hash_of(&head, bytes + sizeof head);
    if (good) {
        memmove(bytes, bytes + sizeof head, (size_t)head.size);
        *list = (packet_list){(uint8_t *)bytes, (size_t)head.size, size};
        *frames = head.frames;
    } else {
        free(bytes);
    }
    return good;
}
