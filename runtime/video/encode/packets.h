/* packets: the encoded frames of one clip, in memory and in a file. */
#ifndef RUNTIME_VIDEO_PACKETS_H
#define RUNTIME_VIDEO_PACKETS_H

#include "daft.h"

typedef struct packet {
    int64_t shown, decoded; /* in frames, from the start of the clip; `decoded` may be negative */
    uint32_t size;
    bool key;
} packet;

typedef struct packet_list {
    uint8_t *bytes; /* a packet and its bytes, again and again */
    size_t size, capacity;
} packet_list;

/* False: out of memory. */
bool packets_add(packet_list *list, const packet *head, const uint8_t *bytes);
/* The packet at *at, and moves *at on. NULL at the end. */
const uint8_t *packets_next(const packet_list *list, size_t *at, packet *head);
void packets_free(packet_list *list);

/* A clip's file holds `frames`, `key` and a hash of all. */
bool packets_save(const packet_list *list, const char *path, uint64_t key, uint32_t frames, daft_error *error);
/* False where there is no such file, it is damaged, or it was made with another key. */
bool packets_load(packet_list *list, const char *path, uint64_t key, uint32_t *frames);

#endif
