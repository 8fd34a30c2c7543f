/* The sky in given directions: one colour, a gradient from horizon to zenith, or images, bilinear: one
 * equirectangular, or the six of a cube. */
#include "shade/batch_lanes.h"

static void sky_constant(daft_vec3 color, uint32_t count, daft_lanes3 *out)
{
    for (uint32_t i = 0; i < count; i += DAFT_VL)
        lanes_store(out, i, (vf3){vf_set(color.x), vf_set(color.y), vf_set(color.z)});
}

DAFT_INLINE vf3 unit_lanes(vf3 d)
{
    vf length2 = vf3_dot(d, d);
    vf scale = vf_if_then_else(vf_lt(vf_set(0), length2), vf_set(1) / vf_sqrt(length2), vf_set(0));
    return (vf3){d.x * scale, d.y * scale, d.z * scale};
}

/* Below the horizon the gradient is mirrored and darkens to two thirds at the nadir. */
static void sky_gradient(const daft_sky *sky, const daft_lanes3 *direction, uint32_t count, daft_lanes3 *out)
{
    vf3 h = {vf_set(sky->horizon.x), vf_set(sky->horizon.y), vf_set(sky->horizon.z)};
    vf3 z = {vf_set(sky->zenith.x), vf_set(sky->zenith.y), vf_set(sky->zenith.z)};
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        vf y = unit_lanes(lanes_load(direction, i)).y, rise = vf_sqrt(vf_abs(y));
        vf shade = vf_set(1) + vf_min(y, vf_set(0)) * vf_set(1.0f / 3);
        vf3 color = {(h.x + (z.x - h.x) * rise) * shade, (h.y + (z.y - h.y) * rise) * shade,
                     (h.z + (z.z - h.z) * rise) * shade};
        lanes_store(out, i, color);
    }
}

/* Offsets in floats of the four texels around each lane's point, and the weights between them. */
typedef struct taps {
    vi above_left, above_right, below_left, below_right;
    vf across, down;
} taps;

/* x in -0.5..width - 0.5, y in -0.5..height - 1: the image wraps around, and ends at its poles. */
DAFT_INLINE taps place_taps(const daft_sky_image *image, vf x, vf y)
{
    vf x0 = vf_floor(x), y0 = vf_floor(y), zero = vf_set(0), one = vf_set(1);
    vf right = vf_set((float)(image->width - 1)), bottom = vf_set((float)(image->height - 1));
    vi xa = vi_convert_to(vf_if_then_else(vf_lt(x0, zero), right, x0)),
       xb = vi_convert_to(vf_if_then_else(vf_lt(x0, right), x0 + one, zero));
    vi width = vi_set(image->width), three = vi_set(3);
    vi ya = vi_convert_to(vf_max(y0, zero)) * width, yb = vi_convert_to(vf_min(y0 + one, bottom)) * width;
    return (taps){(ya + xa) * three, (ya + xb) * three, (yb + xa) * three, (yb + xb) * three, x - x0, y - y0};
}

DAFT_INLINE vf blend_texels(vf a, vf b, vf c, vf d, vf across, vf down)
{
    vf top = a + (b - a) * across, bottom = c + (d - c) * across;
    return top + (bottom - top) * down;
}

DAFT_INLINE vf fetch(const daft_sky_image *image, const taps *t, int channel)
{
    const float *texels = image->texels + channel;
    return blend_texels(vf_gather_index(texels, t->above_left), vf_gather_index(texels, t->above_right),
                        vf_gather_index(texels, t->below_left), vf_gather_index(texels, t->below_right), t->across,
                        t->down);
}

/* Directions side by side in the picture see texels side by side: NEAR of them in a row stand in one table, which is
 * looked up much faster than memory. False: these do not, or the table would reach beyond the image. */
enum { NEAR = 10, NEAR_FLOATS = 32 };
_Static_assert(3 * NEAR <= NEAR_FLOATS, "a table holds the texels");

DAFT_INLINE bool fetch_near(const daft_sky_image *image, vf x, vf y, vf3 *color)
{
    const vf x0 = vf_floor(x), y0 = vf_floor(y), zero = vf_set(0);
    const float first = x0[0] < x0[DAFT_VL - 1] ? x0[0] : x0[DAFT_VL - 1]; /* the least, where they are in a row */
    const int width = image->width, bottom = image->height - 1, column = (int)first;
    const size_t most = 3 * (size_t)width * (size_t)image->height;
    if (first < 0 || column > width - NEAR) return false;
    if (vbits_from_mask(vm_and(vf_le(vf_set(first), x0), vf_le(x0, vf_set(first + NEAR - 2)))) != DAFT_ALL_LANES)
        return false;
    const vi left = vi_convert_to(x0 - vf_set(first)) * vi_set(3), right = left + vi_set(3);
    *color = (vf3){zero, zero, zero};
    for (vbits rest = DAFT_ALL_LANES; rest;) {
        const float row = y0[__builtin_ctz(rest)];
        const vbits here = rest & vbits_from_mask(vf_le(y0, vf_set(row))) & vbits_from_mask(vf_le(vf_set(row), y0));
        const int y1 = daft_max_i((int)row, 0), y2 = daft_min_i((int)row + 1, bottom);
        if (3 * ((size_t)y2 * (size_t)width + (size_t)column) + NEAR_FLOATS > most) return false;
        const float *above = image->texels + 3 * ((size_t)y1 * (size_t)width + (size_t)column),
                    *below = image->texels + 3 * ((size_t)y2 * (size_t)width + (size_t)column);
        vf sum[3];
        for (int k = 0; k < 3; k++) {
            const vi a = left + vi_set(k), b = right + vi_set(k);
            sum[k] = blend_texels(vf_table_lookup32(above, a), vf_table_lookup32(above, b), vf_table_lookup32(below, a),
                                  vf_table_lookup32(below, b), x - x0, y - y0);
        }
        const vm m = vm_from_bits(here);
        *color = (vf3){vf_if_then_else(m, sum[0], color->x), vf_if_then_else(m, sum[1], color->y),
                       vf_if_then_else(m, sum[2], color->z)};
        rest &= ~here;
    }
    return true;
}

static void sky_image(const daft_sky_image *image, const daft_lanes3 *direction, uint32_t count, daft_lanes3 *out)
{
    vf width = vf_set((float)image->width), height = vf_set((float)image->height), half = vf_set(0.5f);
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        vf3 d = lanes_load(direction, i);
        vf level = vf_sqrt(d.x * d.x + d.z * d.z);
        vf u = half + vf_atan2(d.z, d.x) * vf_set(0.159154943f), v = half + vf_atan2(d.y, level) * vf_set(0.318309886f);
        /* NaN directions sample a corner, lanes past the last what the first does. */
        vf x = vf_min(vf_max(u * width - half, -half), width - half);
        vf y = vf_min(vf_max((vf_set(1) - v) * height - half, -half), height - vf_set(1));
        const vm used = vm_from_bits(vbits_first_n((int)daft_min_u(count - i, DAFT_VL)));
        x = vf_if_then_else(used, x, vf_set(x[0])), y = vf_if_then_else(used, y, vf_set(y[0]));
        vf3 color;
        if (!fetch_near(image, x, y, &color)) {
            const taps t = place_taps(image, x, y);
            color = (vf3){fetch(image, &t, 0), fetch(image, &t, 1), fetch(image, &t, 2)};
        }
        lanes_store(out, i, color);
    }
}

/* Which of three a lane has: by the largest of x, y, z. */
DAFT_INLINE vf pick(vm is_x, vm is_y, vf x, vf y, vf z)
{
    return vf_if_then_else(is_x, x, vf_if_then_else(is_y, y, z));
}

/* The faces' places and axes are those of image/cube.c. */
static void sky_cube(const daft_sky_image *image, const daft_lanes3 *direction, uint32_t count, daft_lanes3 *out)
{
    const vf zero = vf_set(0), one = vf_set(1), half = vf_set(0.5f * (float)(image->width - 2));
    const vf last = vf_set((float)(image->width - 2)); /* the last texel that has one beside it */
    const vi width = vi_set(image->width), three = vi_set(3);
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        const vf3 d = lanes_load(direction, i);
        const vf ax = vf_abs(d.x), ay = vf_abs(d.y), az = vf_abs(d.z);
        const vm is_x = vm_and(vf_le(ay, ax), vf_le(az, ax)), is_y = vf_le(az, ay);
        const vf turn_x = vf_if_then_else(vf_lt(d.x, zero), -one, one),
                 turn_y = vf_if_then_else(vf_lt(d.y, zero), -one, one),
                 turn_z = vf_if_then_else(vf_lt(zero, d.z), -one, one);
        const vf face = pick(is_x, is_y, vf_set(0.5f) - turn_x * vf_set(0.5f), vf_set(2.5f) - turn_y * vf_set(0.5f),
                             vf_set(4.5f) - turn_z * vf_set(0.5f));
        const vf depth = pick(is_x, is_y, ax, ay, az);
        const vf right = pick(is_x, is_y, d.z * turn_x, d.x, d.x * turn_z),
                 down = pick(is_x, is_y, -d.y, -d.z * turn_y, -d.y);
        const vf inverse = vf_if_then_else(vf_lt(zero, depth), one / depth, zero);
        /* Texel 0 is the frame's. NaN directions sample a corner. */
        const vf x = vf_min(vf_max(half * (right * inverse + one) + vf_set(0.5f), zero), last + vf_set(0.5f)),
                 y = vf_min(vf_max(half * (down * inverse + one) + vf_set(0.5f), zero), last + vf_set(0.5f));
        const vf x0 = vf_min(vf_floor(x), last), y0 = vf_min(vf_floor(y), last);
        const vi row = vi_convert_to(face) * width + vi_convert_to(y0), at = (row * width + vi_convert_to(x0)) * three;
        const taps t = {at, at + three, at + width * three, at + width * three + three, x - x0, y - y0};
        lanes_store(out, i, (vf3){fetch(image, &t, 0), fetch(image, &t, 1), fetch(image, &t, 2)});
    }
}

/* By chords, which tell small angles apart where cosines do not. */
static void add_sun(const daft_sky *sky, const daft_lanes3 *direction, uint32_t count, daft_lanes3 *out)
{
    const vf zero = vf_set(0);
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        const vf3 d = lanes_load(direction, i), c = lanes_load(out, i);
        const vf unit = vf_set(1) / vf_sqrt(vf3_dot(d, d));
        const vf3 off = {d.x * unit - vf_set(sky->to_sun.x), d.y * unit - vf_set(sky->to_sun.y),
                         d.z * unit - vf_set(sky->to_sun.z)};
        const vm within = vf_lt(vf3_dot(off, off), vf_set(sky->sun_chord2));
        if (!vbits_from_mask(within)) continue;
        lanes_store(out, i,
                    (vf3){c.x + vf_if_then_else(within, vf_set(sky->sun.x), zero),
                          c.y + vf_if_then_else(within, vf_set(sky->sun.y), zero),
                          c.z + vf_if_then_else(within, vf_set(sky->sun.z), zero)});
    }
}

void DAFT_KERNEL(daft_sky_color)(const daft_sky *sky, const daft_lanes3 *direction, uint32_t count, daft_lanes3 *color)
{
    if (sky->kind == DAFT_SKY_IMAGE)
        sky_image(sky->image, direction, count, color);
    else if (sky->kind == DAFT_SKY_CUBE)
        sky_cube(sky->image, direction, count, color);
    else if (sky->kind == DAFT_SKY_GRADIENT)
        sky_gradient(sky, direction, count, color);
    else
        sky_constant(sky->zenith, count, color);
    if (sky->sun_chord2 > 0) add_sun(sky, direction, count, color);
}
