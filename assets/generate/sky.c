/* assets/sky/day.jpg: an equirectangular day sky, u = 0.5 + atan2(dz, dx)/2pi, v = 0.5 + asin(dy)/pi, v = 1 on top.
 * A gradient from the zenith to a hazy horizon, the sun's glow, clouds on a plane high above, and a soft sea of mist
 * below: the games' courses float in it. JPEG, since a sky is smooth and PNG would be eight times as large. */
#include "generate.h"

#include <math.h>
#include <stdlib.h>

static const double PI = 3.141592653589793;
enum { WIDTH = 1536, HEIGHT = 768 };

/* Towards the sun: scenes that use this sky have sunlight along (0.35, -0.75, 0.55). */
static const double SUN[3] = {-0.352, 0.755, -0.553};

/* How thick the clouds are in a direction above the horizon, 0..1, and how much light comes through them. */
static double clouds(const double d[3], double *light)
{
    double height = d[1] + 0.10, x = d[0] / height, z = d[2] / height; /* a layer that bends down towards the horizon */
    double shape = fractal3(x * 0.55 + 3, z * 0.55, 1.5, 6, 5), detail = fractal3(x * 1.9, z * 1.9, 4.5, 5, 15);
    double cover = shape + 0.25 * detail;
    double towards = fractal3((x + SUN[0] * 0.25) * 0.55 + 3, (z + SUN[2] * 0.25) * 0.55, 1.5, 6, 5);
    *light = clamp01(0.75 + 1.3 * (shape - towards) - 0.35 * cover);
    return smoothstep(0.04, 0.34, cover) * smoothstep(0.0, 0.10, d[1]);
}

/* Far hills of mist, seen below the horizon. */
static color below(const double d[3])
{
    double depth = -d[1], height = depth + 0.05, x = d[0] / height, z = d[2] / height;
    double mist = fractal3(x * 0.8, z * 0.8, 9.5, 5, 25);
    color far = rgb(0xdcebf3), deep = rgb(0x6aa5d0), white = rgb(0xf4f9fb);
    color c = mix(far, deep, smoothstep(0.0, 0.75, depth));
    return mix(c, white, 0.85 * smoothstep(0.0, 0.4, mist) * smoothstep(0.01, 0.15, depth));
}

static color above(const double d[3])
{
    double t = d[1];
    color c = mix(rgb(0xdcebf3), rgb(0x8fc4ee), smoothstep(0.0, 0.22, t));
    c = mix(c, rgb(0x2f77c4), smoothstep(0.12, 0.95, t));
    double toward = d[0] * SUN[0] + d[1] * SUN[1] + d[2] * SUN[2], angle = acos(fmin(1, fmax(-1, toward)));
    c = mix(c, rgb(0xfff3d6), 0.55 * exp(-angle * 4.5));
    double light, cover = clouds(d, &light);
    color cloud = mix(rgb(0xaebfd2), rgb(0xffffff), light);
    c = mix(c, mix(cloud, rgb(0xfff3d6), 0.5 * exp(-angle * 3)), 0.92 * cover);
    c = mix(c, rgb(0xfffbea), 0.9 * exp(-angle * angle * 90));
    return mix(c, rgb(0xffffff), smoothstep(0.075, 0.045, angle));
}

static color sky(const double d[3]) { return d[1] >= 0 ? above(d) : below(d); }

static void paint_row(int y, uint8_t *out)
{
    for (int x = 0; x < WIDTH; x++) {
        double sum[3] = {0, 0, 0};
        for (int i = 0; i < 4; i++) {
            double longitude = 2 * PI * ((x + (i % 2 + 0.5) / 2) / WIDTH - 0.5);
            double latitude = PI * (0.5 - (y + (i / 2 + 0.5) / 2) / HEIGHT);
            double d[3] = {cos(latitude) * cos(longitude), sin(latitude), cos(latitude) * sin(longitude)};
            color c = sky(d);
            sum[0] += c.r / 4, sum[1] += c.g / 4, sum[2] += c.b / 4;
        }
        for (int k = 0; k < 3; k++) *out++ = (uint8_t)(clamp01(sum[k]) * 255 + 0.5);
    }
}

bool generate_sky(const char *root)
{
    const char *path = "assets/sky/day.jpg";
    picture p = {WIDTH, HEIGHT, malloc((size_t)WIDTH * HEIGHT * 3)};
    if (!p.pixels) {
        fprintf(stderr, "%s: out of memory\n", path);
        return false;
    }
    for (int y = 0; y < HEIGHT; y++) paint_row(y, p.pixels + (size_t)y * WIDTH * 3);
    bool ok = write_jpeg(root, path, &p, 92);
    free(p.pixels);
    return ok;
}
