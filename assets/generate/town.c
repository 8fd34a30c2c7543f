/* The scene `town`: five hundred houses around a square with a fountain and a church. Houses are boxes with roofs, in a
 * few shapes and colours; streets run in rings around the square and outwards from it. The square's middle is the
 * origin. */
#include "mesh.h"

#include <math.h>

static const double TAU = 6.283185307179586;

/* ---- textures ---- */

/* Plaster, warm white, so that the material's colour tints it. */
static color plaster_at(double u, double v)
{
    double stain = fractal(u * 4, v * 4, 4, 5, 51), grain = noise(u * 90, v * 90, 90, 53);
    return shade(mix(rgb(0xe9e2d4), rgb(0xfdf9f0), 0.5 + 0.9 * stain), 1 + 0.035 * grain);
}

/* Glass that mirrors sky and houses, with a cross of wood; x and y in -1..1 of the opening. */
static color pane(double x, double y, color wood)
{
    color glass = mix(rgb(0x33465c), rgb(0x9fc0d8), smoothstep(-0.6, 1.0, y + 0.35 * x));
    double bar = fmin(fabs(x), fmin(fabs(y - 0.33), fabs(y + 0.33))), frame = fmin(1 - fabs(x), 1 - fabs(y));
    glass = mix(wood, glass, smoothstep(0.05, 0.08, bar));
    return mix(wood, glass, smoothstep(0.10, 0.13, frame));
}

/* A shutter's slats. */
static color shutter(double y, color paint)
{
    double slat = y * 9 - floor(y * 9);
    return shade(paint, 0.72 + 0.4 * slat);
}

/* One window with shutters; a repeat is 2.4 m wide and 3 m high. */
static color facade(double u, double v)
{
    color wall = plaster_at(u, v), wood = rgb(0xf2eee4);
    double x = (u - 0.5) * 2.4, y = v * 3 - 1.65, w = 0.42, h = 0.68, ax = fabs(x);
    if (ax < w && fabs(y) < h) return shade(pane(x / w, y / h, wood), y > h - 0.08 || x < -w + 0.05 ? 0.6 : 1);
    if (ax < w + 0.07 && fabs(y) < h + 0.07) return shade(rgb(0xe8e0d0), ax > w + 0.05 ? 0.8 : 1);
    if (ax > w + 0.09 && ax < w + 0.50 && fabs(y) < h) {
        double e = fmin(fmin(ax - w - 0.09, w + 0.50 - ax), h - fabs(y));
        return e < 0.05 ? rgb(0x486b52) : shutter((y + h) / (2 * h), rgb(0x54795e));
    }
    if (ax < w + 0.16 && y < -h && y > -h - 0.14) return shade(rgb(0xb9b2a4), y > -h - 0.04 ? 1.1 : 0.85);
    double below = smoothstep(0.5, 0, -h - 0.14 - y) * (ax < w && y < -h ? 0.10 : 0);
    double band = smoothstep(0.03, 0.02, fabs(v * 3 - 0.04));
    return shade(mix(wall, rgb(0xcfc6b4), 0.8 * band), 1 - below);
}

/* Ground floor: a door beside a window, above a base of stone; a repeat is 4.8 by 3 m. */
static color shopfront(double u, double v)
{
    color wall = plaster_at(u, v);
    double x = u * 4.8, y = v * 3;
    if (y < 0.55 && fabs(x - 1.4) > 0.62) {
        double row = floor(y / 0.275), fx = x / 0.8 + 0.5 * row,
               e = fmin(fmin(fx - floor(fx), 1 - fx + floor(fx)) * 0.8,
                        fmin(y / 0.275 - row, 1 - y / 0.275 + row) * 0.275);
        color stone = shade(rgb(0x9c958a), 0.85 + 0.25 * hash01((int)floor(fx) % 6, (int)row, 55) +
                                               0.5 * fractal(u * 24, v * 24, 24, 3, 57));
        return mix(rgb(0x6a655e), stone, smoothstep(0.01, 0.025, e));
    }
    double dx = x - 1.4, arch = y > 2.0 ? sqrt(dx * dx + (y - 2.0) * (y - 2.0)) : fabs(dx);
    if (arch < 0.52) {
        if (y > 2.0) return pane(dx / 0.52, (y - 2.25) / 0.35, rgb(0x5a3a22));
        double plank = dx * 5.2 - floor(dx * 5.2), e = fmin(plank, 1 - plank);
        color door = shade(rgb(0x7a4c2a),
                           0.8 + 0.3 * hash01((int)floor(dx * 5.2) + 8, 1, 59) + 0.12 * noise(u * 90, v * 9, 90, 61));
        if (dx > 0.30 && dx < 0.38 && fabs(y - 1.0) < 0.05) return rgb(0xd8b85a);
        return mix(rgb(0x3a2414), door, smoothstep(0.02, 0.10, e));
    }
    if (arch < 0.66) return shade(rgb(0xd9d0bd), arch < 0.54 ? 0.7 : 1);
    double wx = x - 3.4, wy = y - 1.6;
    if (fabs(wx) < 0.72 && fabs(wy) < 0.68) return pane(wx / 0.72, wy / 0.68, rgb(0xf2eee4));
    if (fabs(wx) < 0.80 && fabs(wy) < 0.76) return rgb(0xe0d7c5);
    if (fabs(wx) < 0.86 && wy < -0.68 && wy > -1.0) { /* a box of flowers */
        double n = noise(x * 14, y * 14, 256, 63);
        return wy < -0.84 ? rgb(0x7d5636) : n > 0.25 ? rgb(0xd8434e) : n > 0.05 ? rgb(0xf0a0b0) : rgb(0x4f8440);
    }
    return wall;
}

/* Half-timbering: posts, rails, a brace, and a window; a repeat is 2.4 by 3 m. */
static color timber(double u, double v)
{
    double x = (u - 0.5) * 2.4, y = v * 3, w = 0.36, h = 0.55, wy = y - 1.75,
           warp = 0.012 * noise(u * 12, v * 12, 12, 65);
    color wall = plaster_at(u, v), beam = shade(rgb(0x5b3d27), 1 + 0.25 * noise(u * 60, v * 60, 60, 67));
    if (fabs(x) < w && fabs(wy) < h) return pane(x / w, wy / h, rgb(0xe8e0d0));
    double post = fmin(fabs(fabs(x) - 1.2), fabs(fabs(x) - w - 0.09)) + warp,
           rail = fmin(fmin(y, 3 - y), fmin(fabs(wy - h - 0.08), fabs(wy + h + 0.08))) + warp;
    double brace = fabs(fabs(x) - 0.45 - 0.33 * (y - 0.1) / 0.95 * 1.6) * 0.85;
    bool timbered = post < 0.085 || rail < 0.085 || (y < 1.1 && fabs(x) > 0.45 && brace < 0.07);
    return timbered ? beam : shade(wall, fmin(post, rail) < 0.10 ? 0.82 : 1);
}

/* Rows of round tiles, each over the next. u along the ridge, v up the slope; a repeat is 2 m. */
static color roof(double u, double v)
{
    double row = floor(v * 10), fv = v * 10 - row, x = u * 12 + 0.5 * fmod(row, 2), column = floor(x),
           fx = x - column - 0.5;
    double tip = 0.30 - 0.9 * fx * fx; /* the lower end is round */
    bool below = fv < 0.28 - tip + 0.02;
    if (below) row -= 1, x = u * 12 + 0.5 * fmod(row + 10, 2), column = floor(x), fx = x - column - 0.5, fv += 1;
    double tint = hash01((int)column % 12, (int)(row + 10) % 10, 71), curve = 1 - 2.2 * fx * fx;
    color c = mix(mix(rgb(0x9e4a32), rgb(0xcf7a52), tint), rgb(0x8a6a50),
                  0.6 * smoothstep(0.86, 0.96, hash01((int)column % 12, (int)(row + 10) % 10, 73)));
    c = shade(c, (0.72 + 0.35 * curve) * (1.08 - 0.28 * smoothstep(0.2, 1.3, fv)));
    return mix(shade(c, 1 + 0.16 * noise(u * 40, v * 40, 40, 75)), rgb(0x6f7a48),
               0.35 * smoothstep(0.2, 0.4, fractal(u * 5, v * 5, 5, 3, 77)));
}

/* Cobbles on a jittered grid. */
double cobble_gap(double u, double v, int *bi, int *bj)
{
    enum { N = 18 };
    double best = 9, second = 9, x = u * N, y = v * N;
    for (int j = -1; j <= 1; j++) {
        for (int i = -1; i <= 1; i++) {
            int cx = (int)floor(x) + i, cy = (int)floor(y) + j, wx = (cx + N) % N, wy = (cy + N) % N;
            double dx = x - cx - 0.25 - 0.5 * hash01(wx, wy, 81) - 0.0, dy = y - cy - 0.25 - 0.5 * hash01(wx, wy, 83),
                   d = sqrt(dx * dx + dy * dy);
            if (d < best)
                second = best, best = d, *bi = wx, *bj = wy;
            else if (d < second)
                second = d;
        }
    }
    return second - best;
}

static color cobble(double u, double v)
{
    int bi = 0, bj = 0;
    double gap = cobble_gap(u, v, &bi, &bj), grain = fractal(u * 24, v * 24, 24, 4, 85);
    color c = mix(rgb(0x8f8a82), rgb(0xc8bfae), hash01(bi, bj, 87));
    c = mix(c, rgb(0xa58a72), hash01(bi, bj, 89) > 0.8 ? 0.7 : 0.0);
    c = shade(c, (0.78 + 0.30 * smoothstep(0.05, 0.5, gap)) * (1 + 0.30 * grain));
    return mix(rgb(0x57524b), c, smoothstep(0.03, 0.11, gap));
}

/* ---- houses: the middle of the ground floor at the origin, the front towards +Z ---- */

typedef struct house {
    double width, depth, floors, pitch; /* metres; floors of 3 m; the roof's rise to half its depth */
    const char *wall, *front, *roof;
    bool timbered;
} house;

static void add_wall(mesh *m, vec a, vec b, double low, double high, double bay)
{
    double wide = length(sub(b, a)), bays = fmax(1, round(wide / bay));
    add_panel(m, (const vec[]){v3(a.x, low, a.z), v3(b.x, low, b.z), v3(b.x, high, b.z), v3(a.x, high, a.z)}, 0, 0,
              bays, (high - low) / 3);
}

static void add_walls(mesh *m, double x, double z, double low, double high, double bay)
{
    const vec c[4] = {v3(-x, 0, z), v3(x, 0, z), v3(x, 0, -z), v3(-x, 0, -z)};
    for (int i = 0; i < 4; i++) add_wall(m, c[i], c[(i + 1) % 4], low, high, bay);
}

static void add_chimney(mesh *m, double x, double z, double low, double high)
{
    use_material(m, "brick");
    add_box(m, v3(x - 0.28, low, z - 0.28), v3(x + 0.28, high, z + 0.28), 1.2);
    use_material(m, "stone");
    add_box(m, v3(x - 0.34, high, z - 0.34), v3(x + 0.34, high + 0.12, z + 0.34), 1.2);
    add_panel(m,
              (const vec[]){v3(x - 0.34, high, z - 0.34), v3(x + 0.34, high, z - 0.34), v3(x + 0.34, high, z + 0.34),
                            v3(x - 0.34, high, z + 0.34)},
              0, 0, 0.5, 0.5);
}

/* Two slopes along x with eaves that stand out, and gables below them. */
static void add_gable_roof(mesh *m, const house *h, double low)
{
    double x = h->width / 2, z = h->depth / 2, out = 0.45, rise = h->pitch * z, top = low + rise,
           eaves = low - out * h->pitch, long_ = sqrt(rise * rise + z * z) + 0.6;
    use_material(m, h->wall);
    for (int side = -1; side <= 1; side += 2) {
        const vec p[3] = {v3(side * x, low, side * z), v3(side * x, low, -side * z), v3(side * x, top, 0)};
        vec n = v3(side, 0, 0);
        const corner c[3] = {{p[0], n, 0.05, 0.02}, {p[1], n, 0.2, 0.02}, {p[2], n, 0.12, 0.1}};
        add_face(m, c, 3, true);
    }
    use_material(m, h->roof);
    for (int side = -1; side <= 1; side += 2) {
        double s = side, r = x + 0.35, thick = 0.14;
        const vec up[4] = {v3(-s * r, eaves, s * (z + out)), v3(s * r, eaves, s * (z + out)), v3(s * r, top, 0),
                           v3(-s * r, top, 0)};
        add_panel(m, up, 0, 0, h->width / 2, long_ / 2);
        vec d = v3(0, -thick, 0);
        const vec under[4] = {add(up[3], d), add(up[2], d), add(up[1], d), add(up[0], d)};
        use_material(m, "beam");
        add_panel(m, under, 0, 0, 1, 1);
        add_panel(m, (const vec[]){add(up[0], d), add(up[1], d), up[1], up[0]}, 0, 0, 1, 1);
        add_panel(m, (const vec[]){add(up[1], d), add(up[2], d), up[2], up[1]}, 0, 0, 1, 1);
        add_panel(m, (const vec[]){add(up[3], d), add(up[0], d), up[0], up[3]}, 0, 0, 1, 1);
        use_material(m, h->roof);
    }
}

/* Four slopes to a ridge, or to one point where the house is square. */
static void add_hip_roof(mesh *m, const house *h, double low)
{
    double out = 0.4, x = h->width / 2 + out, z = h->depth / 2 + out, top = low + h->pitch * (z - out),
           ridge = fmax(x - z, 0);
    const vec c[4] = {v3(-x, low, z), v3(x, low, z), v3(x, low, -z), v3(-x, low, -z)}, a = v3(-ridge, top, 0),
              b = v3(ridge, top, 0);
    double slope = sqrt((top - low) * (top - low) + z * z) / 2;
    use_material(m, h->roof);
    add_panel(m, (const vec[]){c[0], c[1], b, a}, 0, 0, x, slope);
    add_panel(m, (const vec[]){c[2], c[3], a, b}, 0, 0, x, slope);
    for (int i = 0; i < 2; i++) {
        vec p = c[i ? 3 : 1], q = c[i ? 0 : 2], t = i ? a : b, n = normal_of(cross(sub(q, p), sub(t, p)));
        const corner slope_end[3] = {{p, n, 0, 0}, {q, n, z, 0}, {t, n, z / 2, slope}};
        add_face(m, slope_end, 3, true);
    }
    use_material(m, "beam");
    add_panel(m, (const vec[]){c[3], c[2], c[1], c[0]}, 0, 0, 1, 1);
}

static void add_dormer(mesh *m, const house *h, double x, double low)
{
    double z = h->depth / 2 - 0.5, y = low + 0.45, w = 0.75;
    use_material(m, h->wall);
    add_panel(m, (const vec[]){v3(x - w, y, z), v3(x + w, y, z), v3(x + w, y + 1.3, z), v3(x - w, y + 1.3, z)}, 0.19,
              0.30, 0.81, 0.82);
    add_panel(m, (const vec[]){v3(x + w, y, z), v3(x + w, y, z - 2), v3(x + w, y + 1.3, z - 2), v3(x + w, y + 1.3, z)},
              0, 0, 0.1, 0.05);
    add_panel(m, (const vec[]){v3(x - w, y, z - 2), v3(x - w, y, z), v3(x - w, y + 1.3, z), v3(x - w, y + 1.3, z - 2)},
              0, 0, 0.1, 0.05);
    use_material(m, h->roof);
    const vec ridge[2] = {v3(x, y + 1.9, z + 0.2), v3(x, y + 1.9, z - 2.4)};
    add_panel(m,
              (const vec[]){v3(x + w + 0.2, y + 1.15, z + 0.2), v3(x + w + 0.2, y + 1.15, z - 2.4), ridge[1], ridge[0]},
              0, 0, 1.2, 0.5);
    add_panel(m,
              (const vec[]){v3(x - w - 0.2, y + 1.15, z - 2.4), v3(x - w - 0.2, y + 1.15, z + 0.2), ridge[0], ridge[1]},
              0, 0, 1.2, 0.5);
    use_material(m, h->wall);
    vec n = v3(0, 0, 1);
    const corner gable[3] = {
        {v3(x - w, y + 1.3, z), n, 0, 0.02}, {v3(x + w, y + 1.3, z), n, 0.1, 0.02}, {v3(x, y + 1.8, z), n, 0.05, 0.06}};
    add_face(m, gable, 3, true);
}

static void build(mesh *m, const house *h, bool hip, int dormers)
{
    double x = h->width / 2, z = h->depth / 2, high = 3 * h->floors;
    use_material(m, h->front);
    add_walls(m, x, z, 0, 3, 4.8);
    use_material(m, h->wall);
    if (h->timbered) { /* upper floors stand out over the street */
        double out = 0.35;
        add_walls(m, x + out, z + out, 3, high, 2.4);
        use_material(m, "beam");
        add_panel(m,
                  (const vec[]){v3(-x - out, 3, -z - out), v3(x + out, 3, -z - out), v3(x + out, 3, z + out),
                                v3(-x - out, 3, z + out)},
                  0, 0, 1, 1);
    } else if (high > 3) {
        add_walls(m, x, z, 3, high, 2.4);
    }
    house wide = *h;
    if (h->timbered) wide.width += 0.7, wide.depth += 0.7;
    if (hip)
        add_hip_roof(m, &wide, high);
    else
        add_gable_roof(m, &wide, high);
    for (int i = 0; i < dormers; i++) add_dormer(m, &wide, (i - 0.5 * (dormers - 1)) * 2.6, high);
    add_chimney(m, 0.28 * h->width, -0.18 * h->depth, high, high + h->pitch * z * 0.9 + 0.8);
}

static void cottage(mesh *m) { build(m, &(house){7.2, 6.5, 1, 1.15, "cream", "front_cream", "roof", false}, false, 1); }
static void cottage_blue(mesh *m)
{
    build(m, &(house){6.6, 6.0, 1, 1.2, "blue", "front_blue", "roof_dark", false}, false, 0);
}
static void house_rose(mesh *m) { build(m, &(house){7.2, 7.2, 2, 1.0, "rose", "front_rose", "roof", false}, false, 2); }
static void house_ochre(mesh *m)
{
    build(m, &(house){9.6, 7.8, 2, 0.8, "ochre", "front_ochre", "roof", false}, true, 0);
}
static void house_white(mesh *m)
{
    build(m, &(house){7.2, 8.4, 3, 0.9, "white", "front_white", "roof_dark", false}, false, 1);
}
static void house_green(mesh *m)
{
    build(m, &(house){9.6, 8.0, 3, 0.75, "green", "front_green", "roof", false}, true, 0);
}
static void timber_high(mesh *m)
{
    build(m, &(house){6.2, 7.4, 3, 1.35, "timber", "front_white", "roof", true}, false, 1);
}
static void timber_low(mesh *m)
{
    build(m, &(house){8.4, 6.8, 2, 1.25, "timber_ochre", "front_ochre", "roof_dark", true}, false, 2);
}
static void tower_house(mesh *m)
{
    build(m, &(house){6.6, 6.6, 4, 1.1, "cream", "front_cream", "roof_dark", false}, true, 0);
}

/* A nave with a tower in front of it, a spire on that, and a clock. */
static void church(mesh *m)
{
    house nave = {11, 22, 3.2, 1.2, "stone_wall", "stone_wall", "roof_dark", false};
    m->move = v3(0, 0, -14);
    use_material(m, "stone_wall");
    add_walls(m, 5.5, 11, 0, 9.6, 2.4);
    double x = nave.width / 2, z = nave.depth / 2, top = 9.6 + 7;
    for (int side = -1; side <= 1; side += 2) {
        const vec gable[3] = {v3(-side * x, 9.6, side * z), v3(side * x, 9.6, side * z), v3(0, top, side * z)};
        add_flat(m, gable, 3);
    }
    use_material(m, "roof_dark");
    add_panel(m,
              (const vec[]){v3(x + 0.5, 9.1, z + 0.4), v3(x + 0.5, 9.1, -z - 0.4), v3(0, top + 0.1, -z - 0.4),
                            v3(0, top + 0.1, z + 0.4)},
              0, 0, 11, 4.6);
    add_panel(m,
              (const vec[]){v3(-x - 0.5, 9.1, -z - 0.4), v3(-x - 0.5, 9.1, z + 0.4), v3(0, top + 0.1, z + 0.4),
                            v3(0, top + 0.1, -z - 0.4)},
              0, 0, 11, 4.6);
    m->move = v3(0, 0, 0);
    use_material(m, "stone_wall");
    add_walls(m, 3.2, 3.2, 0, 24, 2.4);
    use_material(m, "stone");
    for (int i = 1; i < 4; i++) add_box(m, v3(-3.4, 8.0 * i - 0.3, -3.4), v3(3.4, 8.0 * i, 3.4), 1.2);
    add_panel(m, (const vec[]){v3(-1.1, 0, 3.25), v3(1.1, 0, 3.25), v3(1.1, 3.2, 3.25), v3(-1.1, 3.2, 3.25)}, 0, 0, 1,
              1);
    use_material(m, "front_white");
    add_panel(m, (const vec[]){v3(-0.95, 0, 3.28), v3(0.95, 0, 3.28), v3(0.95, 3.0, 3.28), v3(-0.95, 3.0, 3.28)}, 0.17,
              0.0, 0.41, 0.88);
    use_material(m, "clock");
    for (int i = 0; i < 4; i++) {
        double a = TAU / 4 * i, c = cos(a), s = sin(a);
        vec out = v3(s, 0, c), right = v3(c, 0, -s), o = add(times(out, 3.24), v3(0, 20.4, 0));
        add_panel(m,
                  (const vec[]){
                      add(o, add(times(right, -1.6), v3(0, -1.6, 0))), add(o, add(times(right, 1.6), v3(0, -1.6, 0))),
                      add(o, add(times(right, 1.6), v3(0, 1.6, 0))), add(o, add(times(right, -1.6), v3(0, 1.6, 0)))},
                  0, 0, 1, 1);
    }
    static const double spire[][2] = {{4.6, 23.9}, {3.4, 26.5}, {1.6, 33}, {0.12, 42}, {0.12, 42}, {0.12, 43}, {0, 43}};
    use_material(m, "copper");
    add_lathe(m, spire, 4, 8, 0);
    use_material(m, "gold");
    add_blob(m, v3(0, 42.3, 0), v3(0.45, 0.45, 0.45), 2, 0, 1);
}

static color clock_color(double u, double v)
{
    double x = u - 0.5, y = v - 0.5, r = sqrt(x * x + y * y), a = atan2(x, y) / TAU * 12, tick = fabs(a - round(a));
    color c = r > 0.47 ? rgb(0xb9b2a4) : r > 0.43 ? rgb(0xd7aa48) : rgb(0xf6f1e4);
    if (r < 0.40 && r > 0.33 && tick < 0.10) return rgb(0x2b2a2a);
    double hour = fabs(x * 0.5 - y * 0.866 + 0), minute = fabs(x * 0.95 + y * 0.31);
    if ((hour < 0.022 && r < 0.22 && x * 0.866 + y * 0.5 > 0) ||
        (minute < 0.014 && r < 0.35 && -x * 0.31 + y * 0.95 > 0))
        return rgb(0x2b2a2a);
    return c;
}

/* ---- the square ---- */

static void fountain(mesh *m)
{
    static const double steps[][2] = {{4.6, 0},    {4.6, 0.16}, {4.6, 0.16}, {4.1, 0.16},
                                      {4.1, 0.16}, {4.1, 0.32}, {4.1, 0.32}, {3.5, 0.32}};
    static const double basin[][2] = {{3.5, 0.32},  {3.55, 0.45}, {3.4, 0.55}, {3.4, 0.95},  {3.4, 0.95}, {3.6, 1.02},
                                      {3.62, 1.12}, {3.55, 1.16}, {3.2, 1.16}, {3.15, 1.12}, {3.15, 0.5}};
    static const double stem[][2] = {{0.75, 0.5},  {0.6, 0.9},   {0.42, 1.2},  {0.36, 1.7},  {0.5, 1.9},   {0.40, 2.0},
                                     {0.55, 2.15}, {1.2, 2.35},  {1.55, 2.6},  {1.62, 2.68}, {1.52, 2.70}, {1.1, 2.5},
                                     {0.3, 2.42},  {0.26, 2.9},  {0.34, 3.05}, {0.24, 3.15}, {0.35, 3.3},  {0.7, 3.45},
                                     {0.82, 3.6},  {0.74, 3.62}, {0.2, 3.5},   {0.14, 3.8},  {0.2, 3.95},  {0, 4.1}};
    static const double pool[][2] = {{3.15, 1.0}, {0, 1.0}}, dish[][2] = {{1.45, 2.64}, {0, 2.64}};
    use_material(m, "stone"), add_lathe(m, steps, 8, 8, 8);
    use_material(m, "pale"), add_lathe(m, basin, 11, 48, 10), add_lathe(m, stem, 24, 40, 4);
    use_material(m, "water"), add_lathe(m, pool, 2, 48, 0), add_lathe(m, dish, 2, 32, 0);
    for (int i = 0; i < 8; i++) { /* jets from the dish's rim into the pool */
        double a = TAU * (i + 0.5) / 8;
        for (int k = 0; k < 9; k++) {
            double s = k / 9.0, t = (k + 1) / 9.0, r0 = 1.5 + 0.9 * s, r1 = 1.5 + 0.9 * t,
                   y0 = 2.68 + 0.35 * s - 2.03 * s * s, y1 = 2.68 + 0.35 * t - 2.03 * t * t, w = 0.035 + 0.03 * t;
            vec side = v3(-sin(a) * w, 0, cos(a) * w), p = v3(r0 * cos(a), y0, r0 * sin(a)),
                q = v3(r1 * cos(a), y1, r1 * sin(a)), n = v3(cos(a), 0.3, sin(a));
            const corner c[4] = {
                {sub(p, side), n, 0, 0}, {add(p, side), n, 1, 0}, {add(q, side), n, 1, 1}, {sub(q, side), n, 0, 1}};
            use_material(m, "spray");
            add_face(m, c, 4, false);
        }
    }
}

static void lantern(mesh *m)
{
    static const double post[][2] = {{0.22, 0},   {0.20, 0.2},  {0.08, 0.4},  {0.06, 1.5},
                                     {0.05, 3.0}, {0.12, 3.05}, {0.12, 3.05}, {0.05, 3.1}};
    static const double glass[][2] = {{0.10, 3.1}, {0.20, 3.55}},
                        cap[][2] = {{0.27, 3.53}, {0.05, 3.8}, {0.04, 3.9}, {0, 3.95}};
    use_material(m, "iron"), add_lathe(m, post, 8, 10, 0);
    use_material(m, "lamp"), add_lathe(m, glass, 2, 6, 0);
    use_material(m, "iron"), add_lathe(m, cap, 4, 6, 0);
}

/* A stall with a striped awning and crates of fruit. */
static void stall(mesh *m)
{
    use_material(m, "beam");
    for (int i = 0; i < 4; i++) {
        double x = i % 2 ? 1.4 : -1.4, z = i / 2 ? 0.9 : -0.9;
        add_box(m, v3(x - 0.05, 0, z - 0.05), v3(x + 0.05, z > 0 ? 2.1 : 2.6, z + 0.05), 1);
    }
    add_box(m, v3(-1.4, 0.8, -0.5), v3(1.4, 0.9, 0.9), 1);
    for (int i = 0; i < 8; i++) {
        double x0 = -1.6 + 0.4 * i, x1 = x0 + 0.4;
        use_material(m, i % 2 ? "awning" : "linen");
        add_panel(m, (const vec[]){v3(x0, 2.05, 1.3), v3(x1, 2.05, 1.3), v3(x1, 2.75, -1.1), v3(x0, 2.75, -1.1)}, 0, 0,
                  1, 1);
        add_panel(m, (const vec[]){v3(x0, 1.8, 1.3), v3(x1, 1.8, 1.3), v3(x1, 2.05, 1.3), v3(x0, 2.05, 1.3)}, 0, 0, 1,
                  1);
    }
    for (int i = 0; i < 18; i++) {
        static const char *const fruit[3] = {"apple", "orange", "lime"};
        use_material(m, fruit[i / 6]);
        add_blob(m, v3(-1.15 + 0.42 * (i / 3), 0.98, 0.0 + 0.3 * (i % 3)), v3(0.13, 0.12, 0.13), 1, 0, 1);
    }
}

static void ground(mesh *m)
{
    use_material(m, "cobble");
    for (int i = -6; i < 6; i++)
        for (int k = -6; k < 6; k++) {
            double a = 14.0 * i, b = 14.0 * k;
            add_panel(m, (const vec[]){v3(a, 0, b + 14), v3(a + 14, 0, b + 14), v3(a + 14, 0, b), v3(a, 0, b)}, 0, 0, 5,
                      5);
        }
    use_material(m, "meadow");
    for (int i = -10; i < 10; i++) {
        for (int k = -10; k < 10; k++) {
            if (i >= -2 && i < 2 && k >= -2 && k < 2) continue;
            corner c[4];
            for (int j = 0; j < 4; j++) {
                double x = 42.0 * (i + (j == 1 || j == 2)), z = 42.0 * (k + (j < 2)), r = sqrt(x * x + z * z);
                double y = 34 * smoothstep(130, 420, r) * (0.7 + 0.9 * fractal3(x / 130, 0.5, z / 130, 3, 91)) - 0.05;
                c[j] = (corner){v3(x, y, z), v3(0, 1, 0), x / 7, -z / 7};
            }
            vec n = normal_of(cross(sub(c[1].at, c[0].at), sub(c[2].at, c[0].at)));
            for (int j = 0; j < 4; j++) c[j].normal = n;
            add_face(m, (const corner[]){c[0], c[1], c[2]}, 3, true),
                add_face(m, (const corner[]){c[0], c[2], c[3]}, 3, true);
        }
    }
}

/* ---- where the houses stand ---- */

static void put(FILE *f, const char *mesh_name, double x, double y, double z, double scale, double turn)
{
    fprintf(f, "mesh ../../meshes/%s.obj %.2f %.2f %.2f %.2f 0 %.0f 0\n", mesh_name, x, y, z, scale,
            turn - 360 * floor(turn / 360));
}

/* Houses of a ring, shoulder to shoulder but for the streets, their fronts inwards or outwards. */
static int put_ring(FILE *f, double radius, int ring, bool inwards, int wanted)
{
    static const char *const kinds[9] = {"house_rose", "timber_high", "house_ochre", "house_white", "timber_low",
                                         "cottage",    "house_green", "tower_house", "cottage_blue"};
    static const double widths[9] = {7.2, 6.9, 9.6, 7.2, 9.1, 7.2, 9.6, 6.6, 6.6};
    int streets = ring < 2 ? 6 : ring < 6 ? 8 : 12, made = 0;
    double street = 5.5 / radius / TAU, turn = 0;
    for (int n = 0; turn < 1 && made < wanted; n++) {
        int kind = (int)(hash01(n, ring, 93) * (ring < 1 ? 5 : ring > 6 ? 9 : 8.99));
        double scale = 0.94 + 0.14 * hash01(n, ring, 95),
               wide = (widths[kind] * scale + 0.15 + 0.5 * hash01(n, ring, 97)) / radius / TAU;
        double sector = floor(turn * streets), end = (sector + 1) / streets - street / 2;
        if (turn - sector / streets < street / 2) turn = sector / streets + street / 2;
        if (turn + wide > end) {
            turn = (sector + 1) / streets;
            continue;
        }
        double a = TAU * (turn + wide / 2) + 0.13 * ring, r = radius + 1.2 * (hash01(n, ring, 99) - 0.5);
        bool before_church = inwards && fabs(remainder(a - TAU * 0.04, TAU)) < 0.38 && ring < 2;
        turn += wide;
        if (before_church) continue;
        char path[64];
        snprintf(path, sizeof path, "town/%s", kinds[kind]);
        double facing = 90 - a * 360 / TAU + (inwards ? 180 : 0) + 3 * (hash01(n, ring, 101) - 0.5);
        put(f, path, r * cos(a), 0, r * sin(a), scale, facing), made++;
    }
    return made;
}

static bool write_houses(const char *root)
{
    const char *path = "assets/scenes/parts/town.scene";
    FILE *f = open_output(root, path);
    if (!f) return false;
    fprintf(f, "# made by daft_generate, CC0: five hundred houses in rings, what stands on the square, trees\n");
    int houses = 0;
    for (int ring = 0; houses < 500; ring++) /* rows back to back, a street after every second */
        houses += put_ring(f, 27 + 15.5 * (ring / 2) * 1.35 + 9.0 * (ring % 2), ring, ring % 2 == 0, 500 - houses);
    for (int i = 0; i < 10; i++) {
        double a = TAU * (i + 0.5) / 10;
        put(f, "town/lantern", 13 * cos(a), 0, 13 * sin(a), 1, 0);
        if (i % 5 != 0)
            put(f, i % 2 ? "forest/oak" : "forest/birch", 18.5 * cos(a + 0.2), 0, 18.5 * sin(a + 0.2),
                1.0 + 0.2 * hash01(i, 1, 103), 40 * i);
    }
    for (int i = 0; i < 6; i++)
        put(f, "town/stall", 9.5 * cos(2.0 + 0.42 * i), 0, 9.5 * sin(2.0 + 0.42 * i), 1,
            90 - (2.0 + 0.42 * i) * 360 / TAU + 180);
    for (int i = 0; i < 160; i++) {
        double a = TAU * hash01(i, 2, 105), r = 150 + 180 * hash01(i, 3, 105), x = r * cos(a), z = r * sin(a);
        double y = 34 * smoothstep(130, 420, r) * (0.7 + 0.9 * fractal3(x / 130, 0.5, z / 130, 3, 91)) - 0.6;
        put(f, i % 3 ? "forest/oak" : "forest/spruce", x, y, z, 1.6 + 1.2 * hash01(i, 4, 105), 360 * hash01(i, 5, 105));
    }
    return close_output(f, path);
}

#define TINTED(name, tint)                                                                                             \
    "newmtl " name "\nKa " tint "\nKd " tint "\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/facade.jpg\n\n"               \
    "newmtl front_" name "\nKa " tint "\nKd " tint "\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/shopfront.jpg\n\n"
#define TEXTURED(name, tint, file)                                                                                     \
    "newmtl " name "\nKa " tint "\nKd " tint "\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/" file "\n\n"
#define PLAIN(name, tint) "newmtl " name "\nKa " tint "\nKd " tint "\nKs 0 0 0\nillum 1\n\n"

static const char materials[] = "# made by daft_generate, CC0\n" TINTED("cream", "0.98 0.92 0.74")
    TINTED("blue", "0.66 0.78 0.90") TINTED("rose", "0.96 0.72 0.64") TINTED("ochre", "0.95 0.78 0.46")
        TINTED("white", "0.97 0.96 0.93") TINTED("green", "0.76 0.86 0.68") TEXTURED("timber", "1 1 1", "timber.jpg")
            TEXTURED("timber_ochre", "1 0.88 0.62", "timber.jpg") TEXTURED("roof", "1 1 1", "roof.jpg")
                TEXTURED("roof_dark", "0.70 0.62 0.66", "roof.jpg") TEXTURED("stone_wall", "1 0.97 0.90", "stone.png")
                    TEXTURED("stone", "0.95 0.93 0.88", "stone.png") TEXTURED("pale", "1 1 1", "marble.png")
                        TEXTURED("brick", "1 1 1", "brick.png") TEXTURED("cobble", "1 1 1", "cobble.jpg")
                            TEXTURED("meadow", "1 1 1", "grass.png") TEXTURED("clock", "1 1 1", "clock.png")
                                TEXTURED("beam", "0.55 0.45 0.38", "wood.png") PLAIN("copper", "0.36 0.62 0.54") PLAIN(
                                    "iron", "0.10 0.11 0.12") PLAIN("lamp", "1 0.9 0.6") PLAIN("spray", "0.85 0.93 1")
                                    PLAIN("awning", "0.80 0.16 0.14") PLAIN("linen", "0.96 0.94 0.88")
                                        PLAIN("apple", "0.75 0.10 0.08") PLAIN("orange", "0.95 0.50 0.08") PLAIN(
                                            "lime", "0.55 0.72 0.15") "newmtl gold\nKa 0.75 0.55 0.15\nKd 0.62 0.42 "
                                                                      "0.08\nKs 0.45 0.36 0.16\nNs 120\nillum 3\n\n"
                                                                      "newmtl water\nKa 0.10 0.22 0.28\nKd 0.10 0.22 "
                                                                      "0.28\nKs 0.45 0.47 0.50\nNs 400\nillum 3\n";

bool generate_town(const char *root)
{
    static const mesh_recipe list[] = {
        {"assets/meshes/town/cottage.obj", cottage},
        {"assets/meshes/town/cottage_blue.obj", cottage_blue},
        {"assets/meshes/town/house_rose.obj", house_rose},
        {"assets/meshes/town/house_ochre.obj", house_ochre},
        {"assets/meshes/town/house_white.obj", house_white},
        {"assets/meshes/town/house_green.obj", house_green},
        {"assets/meshes/town/timber_high.obj", timber_high},
        {"assets/meshes/town/timber_low.obj", timber_low},
        {"assets/meshes/town/tower_house.obj", tower_house},
        {"assets/meshes/town/church.obj", church},
        {"assets/meshes/town/fountain.obj", fountain},
        {"assets/meshes/town/lantern.obj", lantern},
        {"assets/meshes/town/stall.obj", stall},
        {"assets/meshes/town/ground.obj", ground},
    };
    return paint_square(root, "assets/textures/facade.jpg", 256, facade) &&
           paint_square(root, "assets/textures/shopfront.jpg", 512, shopfront) &&
           paint_square(root, "assets/textures/timber.jpg", 256, timber) &&
           paint_square(root, "assets/textures/roof.jpg", 256, roof) &&
           paint_square(root, "assets/textures/cobble.jpg", 512, cobble) &&
           paint_square(root, "assets/textures/clock.png", 128, clock_color) &&
           write_text(root, "assets/meshes/town/town.mtl", materials) &&
           write_meshes(root, list, sizeof list / sizeof list[0], "town.mtl") && write_houses(root);
}
