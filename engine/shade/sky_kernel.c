/* The sky in given directions: one colour, a gradient from horizon to zenith, or an equirectangular image, bilinear. */
#include "shade/parts.h"

static void sky_constant(daft_vec3 color, uint32_t count, daft_lanes3 *out)
{
    for (uint32_t i = 0; i < count; i += DAFT_VL) lanes_store(out, i, (vf3){vf_set(color.x), vf_set(color.y), vf_set(color.z)});
}

DAFT_INLINE vf3 unit_lanes(vf3 d)
{
    vf length2 = vf3_dot(d, d);
    vf scale = vf_select(vf_lt(vf_set(0), length2), vf_set(1) / vf_sqrt(length2), vf_set(0));
    return (vf3){d.x * scale, d.y * scale, d.z * scale};
}

/* Below the horizon the gradient is mirrored, darkened to two thirds: the light of the ground. */
static void sky_gradient(const daft_sky *sky, const daft_lanes3 *direction, uint32_t count, daft_lanes3 *out)
{
    vf3 h = {vf_set(sky->horizon.x), vf_set(sky->horizon.y), vf_set(sky->horizon.z)};
    vf3 z = {vf_set(sky->zenith.x), vf_set(sky->zenith.y), vf_set(sky->zenith.z)};
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        vf y = unit_lanes(lanes_load(direction, i)).y, rise = vf_sqrt(vf_abs(y));
        vf shade = vf_set(1) + vf_min(y, vf_set(0)) * vf_set(1.0f / 3);
        vf3 color = {(h.x + (z.x - h.x) * rise) * shade, (h.y + (z.y - h.y) * rise) * shade, (h.z + (z.z - h.z) * rise) * shade};
        lanes_store(out, i, color);
    }
}

static void fetch(const daft_sky_image *image, float x, float y, float color[3])
{
    int x0 = (int)(x + 1) - 1, y0 = (int)(y + 1) - 1; /* x and y are -0.5 or more */
    float fx = x - (float)x0, fy = y - (float)y0;
    int xa = x0 < 0 ? image->width - 1 : x0, xb = x0 + 1 < image->width ? x0 + 1 : 0;
    int ya = y0 < 0 ? 0 : y0, yb = y0 + 1 < image->height ? y0 + 1 : image->height - 1;
    const float *above = image->texels + 3 * (size_t)ya * (size_t)image->width;
    const float *below = image->texels + 3 * (size_t)yb * (size_t)image->width;
    for (int k = 0; k < 3; k++) {
        float a = above[3 * xa + k], b = above[3 * xb + k], c = below[3 * xa + k], d = below[3 * xb + k];
        float top = a + (b - a) * fx, bottom = c + (d - c) * fx;
        color[k] = top + (bottom - top) * fy;
    }
}

static void sky_image(const daft_sky_image *image, const daft_lanes3 *direction, uint32_t count, daft_lanes3 *out)
{
    vf width = vf_set((float)image->width), height = vf_set((float)image->height), half = vf_set(0.5f);
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        vf3 d = unit_lanes(lanes_load(direction, i));
        vf u = half + vf_atan2(d.z, d.x) * vf_set(0.159154943f), v = half + vf_asin(d.y) * vf_set(0.318309886f);
        float x[DAFT_VL], y[DAFT_VL];
        vf_store(x, vf_min(vf_max(u * width - half, -half), width - half));
        vf_store(y, vf_min(vf_max((vf_set(1) - v) * height - half, -half), height - vf_set(1)));
        uint32_t used = count - i < DAFT_VL ? count - i : DAFT_VL;
        for (uint32_t k = 0; k < used; k++) {
            float color[3];
            fetch(image, x[k], y[k], color);
            out->x[i + k] = color[0], out->y[i + k] = color[1], out->z[i + k] = color[2];
        }
    }
}

void DAFT_KERNEL(daft_sky_color)(const daft_sky *sky, const daft_lanes3 *direction, uint32_t count, daft_lanes3 *color)
{
    if (sky->kind == DAFT_SKY_IMAGE)
        sky_image(sky->image, direction, count, color);
    else if (sky->kind == DAFT_SKY_GRADIENT)
        sky_gradient(sky, direction, count, color);
    else
        sky_constant(sky->zenith, count, color);
}
