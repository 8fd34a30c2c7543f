/* Tileable textures: floors, walls and marks. Each is a function of u and v in 0..1 that repeats at the edges. */
#include "generate.h"

#include <math.h>

static const double TAU = 6.283185307179586;

static double cell(double x, int count) { return x * count - floor(x * count); }
/* The distance to the nearest edge of a cell, 0 at the edge and 0.5 in the middle. */
static double edge(double f) { return f < 0.5 ? f : 1 - f; }

/* A light that falls on bevelled tiles from the upper left: brighter on the left and upper rim, darker on the others.
 */
static double bevel(double fu, double fv, double width)
{
    double light = 0;
    if (fu < width) light += 1 - fu / width;
    if (1 - fv < width) light += 1 - (1 - fv) / width;
    if (1 - fu < width) light -= 1 - (1 - fu) / width;
    if (fv < width) light -= 1 - fv / width;
    return light;
}

/* Four by four glazed tiles, warm and cool in turn, each a little different, with light grout. */
static color checker(double u, double v)
{
    double fu = cell(u, 4), fv = cell(v, 4);
    int i = (int)(u * 4), j = (int)(v * 4);
    color tile = (i + j) % 2 ? rgb(0xf1e2c6) : rgb(0x7fa9b5);
    tile = shade(tile, 0.97 + 0.06 * hash01(i, j, 3));
    tile = shade(tile, 1 + 0.05 * fractal(u * 8, v * 8, 8, 4, 11) + 0.045 * bevel(fu, fv, 0.05));
    double grout = fmin(edge(fu), edge(fv));
    return mix(shade(rgb(0xd8d2c4), 1 + 0.05 * noise(u * 64, v * 64, 64, 5)), tile, smoothstep(0.012, 0.022, grout));
}

/* The prototype grid: a unit of ten fine squares, every unit and its half marked. */
static color grid(double u, double v)
{
    double fine = fmin(edge(cell(u, 8)), edge(cell(v, 8))) / 8, unit = fmin(edge(u), edge(v));
    color c = shade(rgb(0x5c6b7a), 1 + 0.03 * noise(u * 32, v * 32, 32, 2));
    c = mix(rgb(0x8796a5), c, smoothstep(0.002, 0.0045, fine));
    return mix(rgb(0xe8eef4), c, smoothstep(0.008, 0.012, unit));
}

/* Four planks along u, each with its own grain and end joint. */
static color wood(double u, double v)
{
    int plank = (int)(v * 4);
    double across = cell(v, 4), joint = hash01(plank, 1, 9), along = u - joint - floor(u - joint);
    double bend = 0.35 * noise(u * 3, v * 4, 12, 20 + plank);
    double rings = sin(TAU * (across * 3.5 + bend + 2 * hash01(plank, 2, 9)) + 2.2 * noise(u * 4, v * 16, 16, 31));
    double fibre = noise(u * 12, v * 192, 192, 41);
    color c = mix(rgb(0xb57b45), rgb(0xd9a568), 0.5 + 0.42 * rings);
    c = shade(c, (0.90 + 0.16 * hash01(plank, 3, 9)) * (1 + 0.07 * fibre));
    double gap = fmin(edge(across) / 4, edge(along));
    return mix(rgb(0x5a3a20), c, smoothstep(0.002, 0.006, gap));
}

/* Flagstones in running bond: rows shifted by half a stone, worn edges. */
static color stone(double u, double v)
{
    int row = (int)(v * 6);
    double shifted = u + (row % 2) / 6.0, su = shifted - floor(shifted);
    int column = (int)(su * 3);
    double fu = cell(su, 3), fv = cell(v, 6);
    double wear = 0.014 * noise(u * 24, v * 24, 24, 6);
    double border = fmin(edge(fu) / 3, edge(fv) / 6) + wear * 0.4;
    double grain = fractal(u * 12, v * 12, 12, 5, 17);
    color c = mix(rgb(0x8f8d86), rgb(0xc9c3b4), 0.5 + 0.35 * (hash01(column, row, 4) - 0.5) + 0.5 * grain);
    c = shade(c, 1 + 0.07 * bevel(fu, fv, 0.07));
    return mix(shade(rgb(0x5d5a54), 1 + 0.2 * grain), c, smoothstep(0.004, 0.012, border));
}

/* Brushed plates with a rivet in each corner. */
static color metal(double u, double v)
{
    double fu = cell(u, 2), fv = cell(v, 2),
           brush = noise(u * 6, v * 160, 960, 8) + 0.6 * noise(u * 20, v * 320, 960, 9);
    color c = shade(rgb(0x9aa3ab), 1 + 0.06 * brush + 0.08 * noise(u * 2, v * 2, 2, 3));
    double border = fmin(edge(fu), edge(fv));
    c = mix(rgb(0x545b62), c, smoothstep(0.008, 0.02, border));
    c = shade(c, 1 + 0.1 * bevel(fu, fv, 0.045));
    double du = edge(fu) - 0.09, dv = edge(fv) - 0.09, r = sqrt(du * du + dv * dv);
    double lit = fu < 0.5 ? -du : du;
    lit += fv < 0.5 ? dv * -1 : dv;
    c = mix(c, shade(rgb(0x596068), 1), smoothstep(0.040, 0.034, r));
    return mix(c, shade(rgb(0xc4ccd3), 1 + 6 * lit), smoothstep(0.033, 0.027, r));
}

/* White stone with veins where the warped noise crosses zero. */
static color marble(double u, double v)
{
    double wu = fractal(u * 3, v * 3, 3, 4, 51), wv = fractal(u * 3, v * 3, 3, 4, 61);
    double x = u * 3 + 1.1 * wu, y = v * 3 + 1.1 * wv;
    double vein = 1 - fabs(fractal(x, y, 3, 5, 71)) * 5.5, fine = 1 - fabs(fractal(x * 2, y * 2, 6, 4, 81)) * 7;
    color c = mix(rgb(0xf3f0ea), rgb(0xd9d8d8), 0.5 + 0.9 * wu);
    c = mix(c, rgb(0x8b8f98), 0.75 * pow(clamp01(vein), 3));
    return mix(c, rgb(0xb59a72), 0.35 * pow(clamp01(fine), 4));
}

static color grass(double u, double v)
{
    double patch = fractal(u * 4, v * 4, 4, 3, 91), blade = noise(u * 90, v * 45, 90, 95),
           tip = noise(u * 45, v * 90, 90, 97);
    color c = mix(rgb(0x5f9e3a), rgb(0x8cc152), 0.5 + 0.9 * patch);
    c = shade(c, 1 + 0.16 * blade + 0.12 * tip);
    return mix(c, rgb(0xd6e487), 0.6 * smoothstep(0.55, 0.8, blade * tip * 3));
}

/* Chevrons that point along +u, for ramps and boosters. */
static color arrows(double u, double v)
{
    double f = u - 0.9 * edge(v) + 1;
    f = cell(f, 2);
    double stripe = smoothstep(0.20, 0.215, f) - smoothstep(0.62, 0.635, f);
    color base = shade(rgb(0xf08a3c), 1 + 0.03 * fractal(u * 8, v * 8, 8, 3, 13));
    color c = mix(base, rgb(0xfff4e0), stripe);
    return mix(rgb(0xb85a1e), c, smoothstep(0.012, 0.022, edge(v)));
}

/* Rings around the middle: the pad one has to reach. */
static color target(double u, double v)
{
    double r = sqrt((u - 0.5) * (u - 0.5) + (v - 0.5) * (v - 0.5));
    double ring = smoothstep(0.06, 0.066, r) - smoothstep(0.16, 0.166, r) + smoothstep(0.26, 0.266, r) -
                  smoothstep(0.36, 0.366, r);
    color c = mix(rgb(0xfff7e6), rgb(0x1fa89a), ring);
    c = mix(c, rgb(0xf3c14b), smoothstep(0.44, 0.446, r));
    c = shade(c, 1 + 0.03 * fractal(u * 8, v * 8, 8, 3, 23));
    return mix(rgb(0xb98a22), c, smoothstep(0.01, 0.018, fmin(edge(u), edge(v))));
}

/* Slanted stripes: keep off, or you will be bumped. */
static color hazard(double u, double v)
{
    double f = cell(u + v, 3);
    double stripe = smoothstep(0.0, 0.015, f) - smoothstep(0.5, 0.515, f);
    return shade(mix(rgb(0x2b2f36), rgb(0xffc933), stripe), 1 + 0.04 * fractal(u * 10, v * 10, 10, 3, 33));
}

static color brick(double u, double v)
{
    int row = (int)(v * 8);
    double shifted = u + (row % 2) / 8.0, su = shifted - floor(shifted);
    int column = (int)(su * 4);
    double border = fmin(edge(cell(su, 4)) / 4, edge(cell(v, 8)) / 8), grain = fractal(u * 24, v * 24, 24, 4, 37);
    color c = mix(rgb(0xa9553f), rgb(0xc9795a), hash01(column, row, 14));
    c = shade(c, 1 + 0.22 * grain + 0.05 * bevel(cell(su, 4), cell(v, 8), 0.08));
    return mix(shade(rgb(0xcfc6b6), 1 + 0.15 * grain), c, smoothstep(0.005, 0.010, border + 0.003 * grain));
}

bool generate_textures(const char *root)
{
    static const struct {
        const char *path;
        int size;
        painter *paint;
    } list[] = {
        {"assets/textures/checker.png", 512, checker}, {"assets/textures/grid.png", 256, grid},
        {"assets/textures/wood.png", 256, wood},       {"assets/textures/stone.png", 256, stone},
        {"assets/textures/metal.png", 256, metal},     {"assets/textures/marble.png", 256, marble},
        {"assets/textures/grass.png", 256, grass},     {"assets/textures/arrows.png", 256, arrows},
        {"assets/textures/target.png", 256, target},   {"assets/textures/hazard.png", 256, hazard},
        {"assets/textures/brick.png", 256, brick},
    };
    for (size_t i = 0; i < sizeof list / sizeof list[0]; i++)
        if (!paint_square(root, list[i].path, list[i].size, list[i].paint)) return false;
    return true;
}
