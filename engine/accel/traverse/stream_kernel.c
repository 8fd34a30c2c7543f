/* Streams of rays: packets are made of rays of one octant. A run of rays is sorted by octant, keeping the order within
 * each, and cut into packets of sixteen (in the spirit of Barringer and Akenine-Möller, "Dynamic Ray Stream Traversal",
 * 2014, who regroup at every node; neighbours in a stream are mostly similar to begin with). The sorting is scalar; it
 * is compiled for each instruction set because it calls that one's packets. */
#include "accel/ray_test.h"
#include "accel/traverse/traverse.h"

enum { RUN = 256, OCTANTS = 8 };

static uint32_t octant(daft_vec3 d)
{
    return (uint32_t)(signbit(d.x) != 0) | (uint32_t)(signbit(d.y) != 0) << 1 | (uint32_t)(signbit(d.z) != 0) << 2;
}

/* The numbers of count rays, at most RUN, by octant; each octant's begin at first[octant]. */
static void sort(const daft_ray *rays, uint32_t count, uint16_t order[RUN], uint32_t first[OCTANTS + 1])
{
    uint32_t next[OCTANTS] = {0}, sum = 0;
    uint8_t of[RUN];
    for (uint32_t i = 0; i < count; i++) of[i] = (uint8_t)octant(rays[i].direction), next[of[i]]++;
    for (uint32_t k = 0; k < OCTANTS; k++) {
        uint32_t size = next[k];
        first[k] = next[k] = sum;
        sum += size;
    }
    first[OCTANTS] = sum;
    for (uint32_t i = 0; i < count; i++) order[next[of[i]]++] = (uint16_t)i;
}

/* Fills a packet with the rays order[at..end), at most sixteen; gives how many. */
static uint32_t gather(const daft_ray *rays, const uint16_t *order, uint32_t at, uint32_t end, daft_ray_packet *packet)
{
    uint32_t count = daft_min_u(DAFT_PACKET, end - at);
    for (uint32_t i = 0; i < DAFT_PACKET; i++)
        daft_ray_packet_set(packet, i, &rays[order[at + daft_min_u(i, count - 1)]]);
    return count;
}

static uint32_t first_bits(uint32_t count) { return (1u << count) - 1; }

void DAFT_KERNEL(daft_closest_stream)(const daft_tlas *tlas, const daft_ray *rays, uint32_t count, uint32_t ignore,
                                      daft_hit *hits)
{
    uint16_t order[RUN];
    uint32_t first[OCTANTS + 1];
    daft_ray_packet packet;
    daft_hit found[DAFT_PACKET];
    for (; count; rays += daft_min_u(RUN, count), hits += daft_min_u(RUN, count), count -= daft_min_u(RUN, count)) {
        sort(rays, daft_min_u(RUN, count), order, first);
        for (uint32_t k = 0; k < OCTANTS; k++)
            for (uint32_t at = first[k]; at < first[k + 1]; at += DAFT_PACKET) {
                uint32_t size = gather(rays, order, at, first[k + 1], &packet);
                DAFT_KERNEL(daft_closest_packet)(tlas, &packet, first_bits(size), ignore, found);
                for (uint32_t i = 0; i < size; i++) hits[order[at + i]] = found[i];
            }
    }
}

/* ---- rays in arrays ---- */

/* Strips of columns: rays of square patches of a picture stay closer together than those of its rows. */
enum { STRIPS = 8, STRIP = DAFT_STRIP_ROW / STRIPS, KEYS = OCTANTS * STRIPS };

/* The numbers of the rays from..from + count, by octant, and within one by strip. */
static void sort_arrays(const daft_ray_arrays *rays, uint32_t from, uint32_t count, uint16_t order[RUN],
                        uint32_t first[OCTANTS + 1])
{
    uint32_t next[KEYS] = {0}, sum = 0;
    uint16_t number[RUN];
    uint8_t of[RUN];
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t k = rays->numbers ? rays->numbers[from + i] : from + i;
        const daft_vec3 d = {rays->direction[0][k], rays->direction[1][k], rays->direction[2][k]};
        number[i] = (uint16_t)k, of[i] = (uint8_t)(octant(d) * STRIPS + rays->place[k] / STRIP % STRIPS);
        next[of[i]]++;
    }
    for (uint32_t k = 0; k < KEYS; k++) {
        const uint32_t size = next[k];
        if (k % STRIPS == 0) first[k / STRIPS] = sum;
        next[k] = sum, sum += size;
    }
    first[OCTANTS] = sum;
    for (uint32_t i = 0; i < count; i++) order[next[of[i]]++] = number[i];
}

static uint32_t gather_arrays(const daft_ray_arrays *rays, const uint16_t *order, uint32_t at, uint32_t end,
                              daft_ray_packet *packet)
{
    const uint32_t count = daft_min_u(DAFT_PACKET, end - at);
    for (uint32_t i = 0; i < DAFT_PACKET; i++) {
        const uint32_t k = order[at + daft_min_u(i, count - 1)];
        for (int c = 0; c < 3; c++)
            packet->origin[c][i] = rays->origin[c][k], packet->direction[c][i] = rays->direction[c][k];
    }
    return count;
}

void DAFT_KERNEL(daft_closest_arrays)(const daft_tlas *tlas, const daft_ray_arrays *rays, uint32_t count,
                                      daft_hit *hits)
{
    uint16_t order[RUN];
    uint32_t first[OCTANTS + 1];
    daft_ray_packet packet;
    daft_hit found[DAFT_PACKET];
    for (int i = 0; i < DAFT_PACKET; i++) packet.tmin[i] = 0, packet.tmax[i] = INFINITY;
    for (uint32_t from = 0; from < count; from += RUN) {
        sort_arrays(rays, from, daft_min_u(RUN, count - from), order, first);
        for (uint32_t k = 0; k < OCTANTS; k++)
            for (uint32_t at = first[k]; at < first[k + 1]; at += DAFT_PACKET) {
                const uint32_t size = gather_arrays(rays, order, at, first[k + 1], &packet);
                DAFT_KERNEL(daft_closest_packet)(tlas, &packet, first_bits(size), UINT32_MAX, found);
                for (uint32_t i = 0; i < size; i++) hits[order[at + i]] = found[i];
            }
    }
}

void DAFT_KERNEL(daft_occluded_stream)(const daft_tlas *tlas, const daft_ray *rays, uint32_t count, uint32_t *occluded)
{
    uint16_t order[RUN];
    uint32_t first[OCTANTS + 1];
    daft_ray_packet packet;
    for (uint32_t i = 0; i < (count + 31) / 32; i++) occluded[i] = 0;
    for (uint32_t base = 0; base < count; base += RUN) {
        sort(rays + base, daft_min_u(RUN, count - base), order, first);
        for (uint32_t k = 0; k < OCTANTS; k++)
            for (uint32_t at = first[k]; at < first[k + 1]; at += DAFT_PACKET) {
                uint32_t size = gather(rays + base, order, at, first[k + 1], &packet);
                uint32_t bits = DAFT_KERNEL(daft_occluded_packet)(tlas, &packet, first_bits(size));
                for (uint32_t i = 0; i < size; i++) {
                    uint32_t ray = base + order[at + i];
                    occluded[ray / 32] |= (bits >> i & 1) << ray % 32;
                }
            }
    }
}
