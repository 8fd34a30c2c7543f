/* Gradient noise that repeats (Perlin 2002: quintic weights, hashed gradients), and sums of it. */
#include "generate.h"

#include <math.h>

static uint32_t mix_bits(uint32_t h)
{
    h ^= h >> 16, h *= 0x7feb352du;
    h ^= h >> 15, h *= 0x846ca68bu;
    return h ^ (h >> 16);
}

static uint32_t hash3(int x, int y, int z)
{
    return mix_bits((uint32_t)x + mix_bits((uint32_t)y + mix_bits((uint32_t)z + 0x9e3779b9u)));
}

double hash01(int x, int y, int seed) { return hash3(x, y, seed) / 4294967296.0; }

static double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }
static double lerp(double a, double b, double t) { return a + (b - a) * t; }
static int wrap(int i, int period) { return ((i % period) + period) % period; }

static double gradient2(int x, int y, int period, int seed, double dx, double dy)
{
    double angle = 6.283185307179586 * hash01(wrap(x, period), wrap(y, period), seed);
    return cos(angle) * dx + sin(angle) * dy;
}

double noise(double x, double y, int period, int seed)
{
    int ix = (int)floor(x), iy = (int)floor(y);
    double dx = x - ix, dy = y - iy, u = fade(dx), v = fade(dy);
    double low = lerp(gradient2(ix, iy, period, seed, dx, dy), gradient2(ix + 1, iy, period, seed, dx - 1, dy), u);
    double high = lerp(gradient2(ix, iy + 1, period, seed, dx, dy - 1),
                       gradient2(ix + 1, iy + 1, period, seed, dx - 1, dy - 1), u);
    return 1.4 * lerp(low, high, v);
}

double fractal(double x, double y, int period, int octaves, int seed)
{
    double sum = 0, strength = 0.5;
    for (int i = 0; i < octaves; i++) {
        sum += strength * noise(x, y, period, seed + i);
        x *= 2, y *= 2, period *= 2, strength /= 2;
    }
    return sum;
}

static double gradient3(int x, int y, int z, int seed, double dx, double dy, double dz)
{
    static const double g[12][3] = {{1, 1, 0},  {-1, 1, 0},  {1, -1, 0}, {-1, -1, 0}, {1, 0, 1},  {-1, 0, 1},
                                    {1, 0, -1}, {-1, 0, -1}, {0, 1, 1},  {0, -1, 1},  {0, 1, -1}, {0, -1, -1}};
    const double *a = g[hash3(x, y, z + 7919 * seed) % 12];
    return a[0] * dx + a[1] * dy + a[2] * dz;
}

static double noise3(double x, double y, double z, int seed)
{
    int ix = (int)floor(x), iy = (int)floor(y), iz = (int)floor(z);
    double dx = x - ix, dy = y - iy, dz = z - iz, corner[8];
    for (int i = 0; i < 8; i++) {
        int a = i & 1, b = i >> 1 & 1, c = i >> 2;
        corner[i] = gradient3(ix + a, iy + b, iz + c, seed, dx - a, dy - b, dz - c);
    }
    double u = fade(dx), v = fade(dy), w = fade(dz);
    double low = lerp(lerp(corner[0], corner[1], u), lerp(corner[2], corner[3], u), v);
    double high = lerp(lerp(corner[4], corner[5], u), lerp(corner[6], corner[7], u), v);
    return lerp(low, high, w);
}

double fractal3(double x, double y, double z, int octaves, int seed)
{
    double sum = 0, strength = 0.5;
    for (int i = 0; i < octaves; i++) {
        sum += strength * noise3(x, y, z, seed + i);
        x *= 2, y *= 2, z *= 2, strength /= 2;
    }
    return sum;
}
