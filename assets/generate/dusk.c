/* assets/sky/dusk.hdr: an equirectangular sky after a warm day, in linear light, for scenes that it lights alone. The
 * sun stands 5 degrees above the horizon and is some two hundred times brighter than the sky; high clouds catch its
 * light from below. */
#include "generate.h"

#include <math.h>
#include <stdlib.h>

static const double PI = 3.141592653589793;
enum { WIDTH = 512, HEIGHT = 256 };

static const double SUN[3] = {0.70, 0.087, -0.709};

typedef struct light {
    double r, g, b;
} light;

static light blend(light a, light b, double t)
{
    t = clamp01(t);
    return (light){a.r + (b.r - a.r) * t, a.g + (b.g - a.g) * t, a.b + (b.b - a.b) * t};
}

static light plus(light a, light b, double t) { return (light){a.r + b.r * t, a.g + b.g * t, a.b + b.b * t}; }

static light clear(const double d[3], double angle)
{
    const light zenith = {0.07, 0.15, 0.42}, low = {0.30, 0.26, 0.42}, warm = {2.1, 0.80, 0.22},
                rose = {0.75, 0.36, 0.38};
    const double up = d[1] > 0 ? d[1] : 0, low_part = exp(-up * 4.5);
    light c = blend(zenith, low, low_part);
    c = plus(c, rose, 0.8 * exp(-up * 7) * exp(-angle * 0.7));
    c = plus(c, warm, exp(-up * 5) * exp(-angle * 1.6));
    return plus(c, (light){6, 3.2, 1.2}, exp(-angle * 9));
}

/* Streaks: the noise is drawn out along one axis. */
static light clouds(const double d[3], double angle, light sky)
{
    const double height = d[1] + 0.06, x = d[0] / height, z = d[2] / height;
    const double shape = fractal3(x * 0.28 + 1.7, z * 0.85, 2.5, 6, 15) + 0.3 * fractal3(x * 1.1, z * 2.6, 5.5, 5, 25);
    const double cover = smoothstep(0.02, 0.42, shape) * smoothstep(0.01, 0.16, d[1]);
    const light lit = {2.9, 1.15, 0.48}, grey = {0.20, 0.19, 0.30};
    return blend(sky, blend(grey, lit, 0.12 + 1.1 * exp(-angle * 1.15)), 0.85 * cover);
}

/* Land in the haze: as bright as the sky above it, then dark. */
static light below(const double d[3], double angle)
{
    const double flat[3] = {d[0], 0, d[2]};
    const light land = {0.15, 0.105, 0.10};
    return blend(clear(flat, angle), land, smoothstep(0.0, 0.22, -d[1]));
}

static light seen(const double d[3])
{
    const double toward = d[0] * SUN[0] + d[1] * SUN[1] + d[2] * SUN[2], angle = acos(fmin(1, fmax(-1, toward)));
    if (d[1] < 0) return below(d, angle);
    const light c = clouds(d, angle, clear(d, angle));
    return plus(c, (light){620, 340, 140}, exp(-angle * angle * 4200));
}

bool generate_dusk(const char *root)
{
    const char *path = "assets/sky/dusk.hdr";
    float *texels = malloc(sizeof *texels * 3 * WIDTH * HEIGHT);
    if (!texels) {
        fprintf(stderr, "%s: out of memory\n", path);
        return false;
    }
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            light sum = {0, 0, 0};
            for (int i = 0; i < 16; i++) {
                const double longitude = 2 * PI * ((x + (i % 4 + 0.5) / 4) / WIDTH - 0.5);
                const double latitude = PI * (0.5 - (y + (i / 4 + 0.5) / 4) / HEIGHT);
                const double d[3] = {cos(latitude) * cos(longitude), sin(latitude), cos(latitude) * sin(longitude)};
                sum = plus(sum, seen(d), 1.0 / 16);
            }
            float *to = texels + 3 * ((size_t)y * WIDTH + (size_t)x);
            to[0] = (float)sum.r, to[1] = (float)sum.g, to[2] = (float)sum.b;
        }
    const bool ok = write_hdr(root, path, WIDTH, HEIGHT, texels);
    free(texels);
    return ok;
}
