/* The plain lines that fill large OBJ files, read at a few cycles a number: where digits end is found for 64 bytes at
 * once, as a mask, so one number's place does not wait for the last one's value; eight digits are then summed in
 * pairs, fours and eights (text.h).
 *
 * Plain is: one blank between numbers, no exponent, no plus sign, at most 8 digits before the point and 16 behind it,
 * 18 in all; of corners, positive indices of at most 8 digits. Whatever is not plain is left to the general reader in
 * obj_read.c, which gives the same bits for what is, and the messages for what is wrong. */
#include "geometry/formats/obj.h"
#include "math/simd/ops.h"

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__

/* So many bytes are read from where a search for digits starts: 64, and eight from a number that ends within them. */
enum { AHEAD = 72 };

static inline uint64_t load_eight(const char *p)
{
    uint64_t eight;
    memcpy(&eight, p, 8);
    return eight;
}

/* The value of the first `count` bytes, which are digits. 1 to 8. */
static inline uint64_t sum_digits(uint64_t eight, unsigned count)
{
    return daft_sum_eight((eight ^ 0x3030303030303030u) << (64 - 8 * count));
}

/* ---- v, vt, vn ---- */

/* What is left of a line, and which of its bytes are no digits; 0: not known any more. */
typedef struct rest {
    const char *at;
    uint64_t others;
} rest;

/* Digits before a point and behind it as one integer, where they do not fit into eight bytes. */
static uint64_t sum_long(const char *p, unsigned before, unsigned behind)
{
    uint64_t value = before ? sum_digits(load_eight(p), before) : 0;
    p += before + 1;
    if (behind > 8) {
        value = value * 100000000 + sum_digits(load_eight(p), 8);
        p += 8, behind -= 8;
    }
    if (behind) value = value * (uint64_t)(int64_t)daft_powers_of_ten[behind] + sum_digits(load_eight(p), behind);
    return value;
}

/* One number and the byte that ends it. False: it is not plain. */
static inline bool scan_real(rest *line, double *out)
{
    const char *p = line->at;
    uint64_t negative = *p == '-', others = line->others >> negative;
    p += negative;
    if (!others) return false;
    unsigned before = (unsigned)__builtin_ctzll(others), behind = 0;
    if (before > 8) return false;
    const char *end = p + before;
    others >>= before + 1;
    if (*end == '.') {
        if (!others) return false;
        behind = (unsigned)__builtin_ctzll(others);
        if (behind > 16) return false;
        end += behind + 1;
        others = others >> behind >> 1;
    }
    uint64_t digits;
    unsigned all = before + behind;
    if (all - 1 < 8 && before < 8) { /* the point is taken out of one word */
        uint64_t low = load_eight(p) & ((UINT64_C(1) << 8 * before) - 1);
        digits = sum_digits(low | load_eight(p + before + 1) << 8 * before, all);
    } else {
        if (all - 1 > 17) return false;
        digits = sum_long(p, before, behind);
    }
    double value = (double)(int64_t)digits / daft_powers_of_ten[behind];
    uint64_t bits;
    memcpy(&bits, &value, 8);
    bits ^= negative << 63; /* signs come as they like: no branch */
    memcpy(out, &bits, 8);
    *line = (rest){end + 1, others};
    return true;
}

/* Three numbers and the line's end, or two (z is left alone); returns what follows, or NULL where they are not plain.
 */
static inline const char *scan_vector(const char *p, int count, double *x, double *y, double *z)
{
    rest line = {p, vu8_nondigits_64(p)};
    if (!scan_real(&line, x) || line.at[-1] != ' ' || !scan_real(&line, y)) return NULL;
    if (count > 2 && (line.at[-1] != ' ' || !scan_real(&line, z))) return NULL;
    if (daft_is_break(line.at[-1])) return line.at;
    return line.at[-1] == ' ' && daft_is_break(*line.at) ? line.at + 1 : NULL;
}

static inline const char *scan_positions(daft_obj_source *s, const char *p, const char *last)
{
    size_t at = s->position_count, room = s->position_room;
    if (room > DAFT_OBJ_MAX_INDEX) room = DAFT_OBJ_MAX_INDEX;
    float *xs = s->x, *ys = s->y, *zs = s->z;
    while (p < last && p[0] == 'v' && p[1] == ' ' && at < room) {
        double x, y, z;
        const char *next = scan_vector(p + 2, 3, &x, &y, &z);
        if (!next) break;
        xs[at] = (float)x, ys[at] = (float)y, zs[at] = (float)z;
        at++;
        p = next;
    }
    s->position_count = at;
    return p;
}

/* One vt or vn: returns what follows. */
static inline const char *scan_attribute(daft_obj_source *s, const char *p)
{
    double x, y, z = 0;
    if (p[1] == 't' && p[2] == ' ' && s->uv_count < s->uv_room && s->uv_count < DAFT_OBJ_MAX_INDEX) {
        const char *next = scan_vector(p + 3, 2, &x, &y, &z);
        if (!next) return p;
        s->uvs[s->uv_count++] = (daft_vec2){(float)x, (float)y};
        return next;
    }
    if (p[1] == 'n' && p[2] == ' ' && s->normal_count < s->normal_room && s->normal_count < DAFT_OBJ_MAX_INDEX) {
        const char *next = scan_vector(p + 3, 3, &x, &y, &z);
        if (!next) return p;
        s->normals[s->normal_count++] = daft_v3((float)x, (float)y, (float)z);
        return next;
    }
    return p;
}

/* ---- f ---- */

/* "1 2 3" and the line's end, in 32 bytes; returns what follows, or NULL. */
static inline const char *scan_triangle(const char *p, uint32_t *out)
{
    uint32_t first = vu8_nondigits_32(p), second = first & (first - 1), third = second & (second - 1);
    if (!third) return NULL;
    unsigned a = (unsigned)__builtin_ctz(first), b = (unsigned)__builtin_ctz(second),
             c = (unsigned)__builtin_ctz(third);
    unsigned lengths[3] = {a, b - a - 1, c - b - 1};
    if (((lengths[0] - 1) | (lengths[1] - 1) | (lengths[2] - 1)) > 7) return NULL;
    if (p[a] != ' ' || p[b] != ' ' || !daft_is_break(p[c])) return NULL;
    uint32_t i = (uint32_t)sum_digits(load_eight(p), lengths[0]);
    uint32_t j = (uint32_t)sum_digits(load_eight(p + a + 1), lengths[1]);
    uint32_t k = (uint32_t)sum_digits(load_eight(p + b + 1), lengths[2]);
    if (!i || !j || !k) return NULL;
    out[0] = i - 1, out[1] = j - 1, out[2] = k - 1;
    return p + c + 1;
}

/* One index and what ends it. */
static inline bool scan_index(rest *line, const char *last, uint32_t *index)
{
    if (!line->others) {
        if (line->at >= last) return false;
        line->others = vu8_nondigits_64(line->at);
        if (!line->others) return false;
    }
    unsigned count = (unsigned)__builtin_ctzll(line->others);
    if (count - 1 > 7) return false;
    *index = (uint32_t)sum_digits(load_eight(line->at), count) - 1;
    line->others >>= count + 1;
    line->at += count + 1;
    return *index != UINT32_MAX;
}

enum { BARE, WITH_UV, WITH_NORMAL, WITH_BOTH };

/* A triangle whose corners are alike: v/vt, v//vn or v/vt/vn. */
static inline const char *scan_corners(const char *p, const char *last, int form, uint32_t *v, uint32_t *vt,
                                       uint32_t *vn)
{
    rest line = {p, 0};
    for (int k = 0; k < 3; k++) {
        if (!scan_index(&line, last, &v[k]) || line.at[-1] != '/') return NULL;
        if (form == WITH_NORMAL) {
            if (*line.at != '/') return NULL;
            line.at++, line.others >>= 1;
        } else if (!scan_index(&line, last, &vt[k])) {
            return NULL;
        }
        if (form == WITH_BOTH && line.at[-1] != '/') return NULL;
        if (form != WITH_UV && !scan_index(&line, last, &vn[k])) return NULL;
        if (k < 2 && line.at[-1] != ' ') return NULL;
    }
    if (daft_is_break(line.at[-1])) return line.at;
    return line.at[-1] == ' ' && daft_is_break(*line.at) ? line.at + 1 : NULL;
}

/* Triangles in a row. What corners have must be what those before have. */
static const char *scan_faces(daft_obj_source *s, const char *p, const char *last)
{
    uint32_t *v = s->corner_positions, *vt = s->corner_uvs, *vn = s->corner_normals;
    int form = (vt ? WITH_UV : 0) + (vn ? WITH_NORMAL : 0);
    size_t first = s->corner_count, at = first, room = s->corner_room < UINT32_MAX ? s->corner_room : UINT32_MAX;
    bool repeats = false;
    while (p < last && p[0] == 'f' && p[1] == ' ' && at + 3 <= room) {
        const char *next = form == BARE          ? scan_triangle(p + 2, v + at)
                           : form == WITH_UV     ? scan_corners(p + 2, last, WITH_UV, v + at, vt + at, NULL)
                           : form == WITH_NORMAL ? scan_corners(p + 2, last, WITH_NORMAL, v + at, NULL, vn + at)
                                                 : scan_corners(p + 2, last, WITH_BOTH, v + at, vt + at, vn + at);
        if (!next) break;
        repeats |= (v[at] == v[at + 1]) | (v[at + 1] == v[at + 2]) | (v[at + 2] == v[at]);
        at += 3;
        p = next;
    }
    if (at == first) return p;
    s->repeats |= repeats;
    s->corner_count = at;
    s->face_count += (at - first) / 3;
    s->triangle_count += (at - first) / 3;
    if (s->largest_face < 3) s->largest_face = 3;
    return p;
}

const char *daft_obj_scan(daft_obj_source *s, const char *p, bool faces)
{
    if (s->text.end - p <= AHEAD + 3) return p;
    const char *last = s->text.end - (AHEAD + 3); /* no line starts here or later: three bytes of keyword come before */
    for (const char *before = NULL; p != before && p < last;) {
        before = p;
        while (*p == '\n' || *p == '\r') p++;
        if (p >= last) break;
        if (p[0] == 'v')
            p = p[1] == ' ' ? scan_positions(s, p, last) : scan_attribute(s, p);
        else if (p[0] == 'f' && faces && !s->faces)
            p = scan_faces(s, p, last);
    }
    return p;
}

#else

const char *daft_obj_scan(daft_obj_source *s, const char *p, bool faces)
{
    (void)s, (void)faces;
    return p;
}

#endif
