/* The scene `hall`: walls, floor and ceiling, columns, a mirror in a frame, chandeliers, pedestals. x goes down the
 * hall, from 0 to 24 m; z across it, from -6 to 6; the ceiling is at 7. */
#include "mesh.h"

#include <math.h>

static const double TAU = 6.283185307179586;
enum { BAYS = 6 };
static const double BAY = 4, WALL = 6, ROW = 3.4, TOP = 7;

/* ---- textures ---- */

/* Cream and green marble in squares that stand on a corner, with small dark ones where four meet. */
static color floor_color(double u, double v)
{
    double x = (u + v) * 2, y = (u - v) * 2 + 2, fx = x - floor(x), fy = y - floor(y);
    bool dark = ((int)floor(x) + (int)floor(y)) % 2 != 0;
    double vein = fabs(fractal(u * 6 + 1.1 * fractal(u * 4, v * 4, 4, 4, 11), v * 6, 6, 5, dark ? 13 : 17));
    color c = dark ? mix(rgb(0x8fb0a0), rgb(0x2f5549), smoothstep(0, 0.10, vein))
                   : mix(rgb(0xb9a88c), rgb(0xf0e8d8), smoothstep(0, 0.12, vein));
    double border = fmin(fmin(fx, 1 - fx), fmin(fy, 1 - fy)), tip = fmax(fmin(fx, 1 - fx), fmin(fy, 1 - fy));
    c = mix(rgb(0x6d6455), c, smoothstep(0.008, 0.018, border));
    return tip < 0.14 ? mix(shade(rgb(0x4a2620), 1 + 0.8 * vein), c, smoothstep(0.12, 0.135, tip)) : c;
}

/* Rows of stylised flowers, each between two bending stems, every second row shifted by half. */
static color damask(double u, double v)
{
    double fv = v * 2, row = floor(fv), y = fv - row - 0.5, x = u * 2 + 0.5 * row;
    x = x - floor(x) - 0.5;
    double a = atan2(x, y), r = sqrt(x * x + y * y), petal = 0.20 + 0.07 * cos(6 * a) + 0.03 * cos(12 * a);
    double flower =
        smoothstep(0.012, -0.012, r - petal) - 0.8 * smoothstep(0.010, -0.010, fabs(r - petal * 0.62) - 0.018);
    double stem = fabs(fabs(x) - 0.5 + 0.24 * cos(TAU * 0.5 * (y + 0.5)) * 0.9 - 0.02);
    double vine = smoothstep(0.040, 0.028, stem), leaf = smoothstep(0.09, 0.07, stem + 0.06 * fabs(sin(TAU * 2 * y)));
    double thread = 0.04 * noise(u * 128, v * 32, 128, 7) + 0.03 * noise(u * 32, v * 128, 128, 9);
    color c = mix(rgb(0x7c2430), rgb(0x9a3540), 0.5 + fractal(u * 3, v * 3, 3, 3, 5));
    return shade(mix(c, rgb(0xc89a55), 0.8 * clamp01(fmax(flower, fmax(vine, leaf)))), 1 + thread);
}

/* Wood with one raised field in a frame; one repeat is one panel. */
static color panelling(double u, double v)
{
    double e = fmin(fmin(u, 1 - u), fmin(v, 1 - v)),
           light = (v > 0.5 ? 1 : -1) * (fmin(v, 1 - v) < fmin(u, 1 - u) ? 1 : 0.5);
    double ring = fractal(u * 3, v * 16, 16, 4, 23), fibre = noise(u * 128, v * 8, 128, 25);
    if (e > 0.12) ring = fractal(u * 16, v * 3, 16, 4, 27);
    color c = shade(mix(rgb(0x5a3519), rgb(0x8f5c2e), 0.5 + 1.1 * ring), 1 + 0.07 * fibre);
    c = shade(c, 1 - 0.5 * smoothstep(0.012, 0, e));
    double moulding = smoothstep(0.10, 0.115, e) - smoothstep(0.135, 0.15, e),
           field = smoothstep(0.19, 0.2, e) - smoothstep(0.23, 0.24, e);
    return shade(c, 1 - 0.38 * light * moulding + 0.25 * light * field);
}

/* A coffer: a gilded rose on blue in a stepped frame. */
static color coffer(double u, double v)
{
    double e = fmin(fmin(u, 1 - u), fmin(v, 1 - v)), x = u - 0.5, y = v - 0.5, r = sqrt(x * x + y * y), a = atan2(y, x);
    color c = shade(rgb(0x28406e), 1 + 0.12 * fractal(u * 8, v * 8, 8, 4, 31));
    double rose = 0.16 + 0.05 * cos(8 * a);
    c = mix(c, shade(rgb(0xd9aa4e), 0.75 + 1.6 * r + 0.15 * cos(8 * a)), smoothstep(0.008, -0.008, r - rose));
    c = mix(c, rgb(0x7a4a1c), smoothstep(0.006, -0.006, fabs(r - 0.06) - 0.008));
    c = mix(rgb(0xd9aa4e), c, smoothstep(0.155, 0.165, e));
    return mix(shade(rgb(0xece2cb), 1 + 0.25 * smoothstep(0.05, 0.12, e) - 0.35 * smoothstep(0.10, 0.14, e)), c,
               smoothstep(0.135, 0.145, e));
}

/* u goes across the runner. */
static color carpet(double u, double v)
{
    double e = fmin(u, 1 - u), x = u - 0.5, y = v - 0.5, diamond = fabs(x) * 1.6 + fabs(y);
    color c = rgb(0x8a1f26);
    double stripe =
        smoothstep(0.004, -0.004, fabs(e - 0.10) - 0.012) + smoothstep(0.004, -0.004, fabs(e - 0.15) - 0.006);
    double figure =
        smoothstep(0.01, -0.01, fabs(diamond - 0.36) - 0.025) + smoothstep(0.01, -0.01, fabs(diamond - 0.18) - 0.05);
    c = mix(c, rgb(0x1d2c52), e < 0.085 ? 1 : smoothstep(0.01, -0.01, diamond - 0.30) * 0.85);
    c = mix(c, rgb(0xd7b063), clamp01(stripe + (e > 0.17 ? figure : 0)));
    double knots = fabs(sin(TAU * 7 * v)) * 0.5;
    if (e < 0.08) c = mix(c, rgb(0xd7b063), smoothstep(0.02, 0, fabs(e - 0.025 - 0.03 * knots) - 0.006));
    return shade(c, 1 + 0.10 * noise(u * 100, v * 100, 100, 41) + 0.06 * noise(u * 20, v * 20, 20, 43));
}

/* A tall window of leaded glass with the evening behind it; v goes up, the arch is part of the picture. */
static color window_color(double u, double v)
{
    double x = (u - 0.5) * 2, arch = v > 0.75 ? sqrt(x * x + pow((v - 0.75) * 4, 2)) : fabs(x);
    if (arch > 0.96) return shade(rgb(0xd8cdb8), arch > 0.99 ? 0.9 : 0.6);
    double du = u * 5, dv = v * 12, lead = fmin(fabs(du - floor(du) - 0.5) - 0.0, fabs(dv - floor(dv) - 0.5));
    color glow = mix(rgb(0xffd9a0), rgb(0x86b7e6), smoothstep(0.05, 0.9, v));
    double tint = hash01((int)du, (int)dv, 47);
    color glass = mix(glow,
                      tint < 0.12   ? rgb(0xd9603f)
                      : tint < 0.24 ? rgb(0x4a9a6a)
                      : tint < 0.36 ? rgb(0xe8c14f)
                                    : glow,
                      0.55);
    glass = shade(glass, 0.85 + 0.25 * hash01((int)du, (int)dv, 49));
    double edge = fmin(fmin(du - floor(du), 1 - du + floor(du)) / 5, fmin(dv - floor(dv), 1 - dv + floor(dv)) / 3);
    (void)lead;
    return mix(rgb(0x2c2a28), glass, smoothstep(0.010, 0.018, edge) * smoothstep(0.95, 0.92, arch));
}

/* ---- the shell ---- */

static void add_rectangle(mesh *m, vec origin, vec right, vec up, double u, double v)
{
    add_panel(m, (const vec[]){origin, add(origin, right), add(add(origin, right), up), add(origin, up)}, 0, 0, u, v);
}

/* One bay of a long wall: panelling, damask with a window in it, a cornice and a pilaster. `side` is -1 or 1. */
static void add_bay(mesh *m, double x, double side)
{
    double z = side * WALL, s = -side; /* seen from inside, +X is right on the far side at -z */
    vec right = v3(BAY * s * -side * 1, 0, 0);
    right.x = side < 0 ? BAY : -BAY;
    double start = side < 0 ? x : x + BAY, step = side < 0 ? 1 : -1;
    use_material(m, "panelling");
    add_rectangle(m, v3(start, 0, z), right, v3(0, 1.3, 0), 4, 1);
    use_material(m, "damask");
    add_rectangle(m, v3(start, 1.3, z), v3(step * 1.1, 0, 0), v3(0, 4.5, 0), 0.55, 2.25);
    add_rectangle(m, v3(start + step * 2.9, 1.3, z), v3(step * 1.1, 0, 0), v3(0, 4.5, 0), 0.55, 2.25);
    add_rectangle(m, v3(start + step * 1.1, 1.3, z), v3(step * 1.8, 0, 0), v3(0, 0.3, 0), 0.9, 0.15);
    add_rectangle(m, v3(start + step * 1.1, 5.2, z), v3(step * 1.8, 0, 0), v3(0, 0.6, 0), 0.9, 0.3);
    use_material(m, "window");
    add_rectangle(m, v3(start + step * 1.1, 1.6, z), v3(step * 1.8, 0, 0), v3(0, 3.6, 0), 1, 1);
    use_material(m, "stucco");
    double near = fmin(z, z - side * 0.12), far = fmax(z, z - side * 0.12);
    add_box(m, v3(x - 0.22, 0, near), v3(x + 0.22, 5.8, far), 2);
    near = fmin(z, z - side * 0.35), far = fmax(z, z - side * 0.35);
    add_box(m, v3(x, 5.8, near), v3(x + BAY, 6.15, far), 2);
    add_rectangle(m, v3(x, 5.8, near), v3(BAY, 0, 0), v3(0, 0, far - near), 2, 0.2);
    near = fmin(z, z - side * 0.10), far = fmax(z, z - side * 0.10);
    add_box(m, v3(x, 1.302, near), v3(x + BAY, 1.40, far), 2); /* off the panelling's edge */
    use_material(m, "damask");
    add_rectangle(m, v3(start, 6.15, z), right, v3(0, TOP - 6.15, 0), 2, 0.42);
}

static void add_ceiling(mesh *m)
{
    use_material(m, "coffer");
    for (int i = 0; i < 3 * BAYS; i++) {
        for (int k = -4; k <= 4; k++) {
            double a = BAY / 3 * i, z = BAY / 3 * (k - 0.5);
            add_rectangle(m, v3(a, TOP, z), v3(BAY / 3, 0, 0), v3(0, 0, BAY / 3), 1, 1);
        }
    }
    use_material(m, "stucco");
    for (int side = -1; side <= 1; side += 2) { /* the beams that the columns carry */
        double z = side * ROW;
        add_box(m, v3(0, 5.7, z - 0.38), v3(BAY * BAYS, 6.3, z + 0.38), 2);
        add_rectangle(m, v3(0, 5.7, z - 0.38), v3(BAY * BAYS, 0, 0), v3(0, 0, 0.76), 12, 0.4);
        add_box(m, v3(0, 6.3, z - 0.46), v3(BAY * BAYS, 6.42, z + 0.46), 2);
        add_box(m, v3(0, 6.42, z - 0.30), v3(BAY * BAYS, TOP, z + 0.30), 2);
    }
}

static void add_end(mesh *m, double x, double facing)
{
    double z = facing > 0 ? WALL : -WALL, step = facing > 0 ? -1 : 1; /* from the left, seen from inside */
    use_material(m, "panelling");
    add_rectangle(m, v3(x, 0, z), v3(0, 0, 12 * step), v3(0, 1.3, 0), 12, 1);
    use_material(m, "damask");
    add_rectangle(m, v3(x, 1.3, z), v3(0, 0, 12 * step), v3(0, TOP - 1.3, 0), 6, 2.85);
    use_material(m, "stucco");
    double near = fmin(x, x + 0.1 * facing), far = fmax(x, x + 0.1 * facing);
    add_box(m, v3(near, 1.3, -WALL), v3(far, 1.4, WALL), 2);
}

static void shell(mesh *m)
{
    use_material(m, "floor");
    for (int i = 0; i < BAYS; i++) add_rectangle(m, v3(BAY * i, 0, WALL), v3(BAY, 0, 0), v3(0, 0, -12), 2, 6);
    for (int i = 0; i < BAYS; i++) add_bay(m, BAY * i, -1), add_bay(m, BAY * i, 1);
    add_ceiling(m);
    add_end(m, 0, 1), add_end(m, BAY * BAYS, -1);
    use_material(m, "carpet");
    for (int i = 0; i < 10; i++) add_rectangle(m, v3(0.8 + 2.2 * i, 0.012, 1.1), v3(2.2, 0, 0), v3(0, 0, -2.2), 1, 1);
    for (int i = m->corner_count - 40; i < m->corner_count; i++) { /* its pattern runs along x */
        double u = m->corners[i].u;
        m->corners[i].u = m->corners[i].v, m->corners[i].v = u;
    }
}

/* ---- what stands in it ---- */

/* A fluted column of 5.7 m: the profile turned, its shaft hollowed by twenty flutes. */
static corner column_corner(const double (*profile)[2], int count, int i, int k, int sides)
{
    double a = -TAU * (k % sides) / sides, y = profile[i][1],
           shaft = smoothstep(0.55, 0.75, y) * smoothstep(5.05, 4.85, y);
    double hollow = 1 - 0.075 * shaft * fabs(sin(10 * a)), r = profile[i][0] * hollow;
    const double *p = profile[i > 0 ? i - 1 : i], *q = profile[i + 1 < count ? i + 1 : i];
    double dr = q[0] - p[0], dy = q[1] - p[1], across = -0.075 * shaft * 10 * cos(10 * a) * (sin(10 * a) < 0 ? -1 : 1);
    vec out = v3(cos(a), 0, sin(a)), round = v3(-sin(a), 0, cos(a));
    vec n = normal_of(add(sub(times(out, dy), times(round, across * dy)), v3(0, -dr, 0)));
    return (corner){v3(r * out.x, y, r * out.z), n, 3.0 * k / sides, y / 1.3};
}

static void column(mesh *m)
{
    static const double profile[][2] = {{0.52, 0.22}, {0.56, 0.30}, {0.52, 0.38}, {0.46, 0.42}, {0.45, 0.50},
                                        {0.43, 0.55}, {0.42, 0.75}, {0.42, 2.0},  {0.40, 3.4},  {0.37, 4.85},
                                        {0.37, 5.05}, {0.41, 5.10}, {0.41, 5.16}, {0.38, 5.20}, {0.40, 5.30},
                                        {0.52, 5.42}, {0.54, 5.50}};
    enum { COUNT = sizeof profile / sizeof profile[0], SIDES = 80 };
    use_material(m, "white_marble");
    for (int i = 0; i + 1 < COUNT; i++) {
        for (int k = 0; k < SIDES; k++) {
            const corner c[4] = {
                column_corner(profile, COUNT, i, k + 1, SIDES), column_corner(profile, COUNT, i, k, SIDES),
                column_corner(profile, COUNT, i + 1, k, SIDES), column_corner(profile, COUNT, i + 1, k + 1, SIDES)};
            const corner outward[4] = {c[1], c[0], c[3], c[2]};
            add_face(m, outward, 4, true);
        }
    }
    add_box(m, v3(-0.62, 0, -0.62), v3(0.62, 0.22, 0.62), 1.3);
    add_box(m, v3(-0.58, 5.5, -0.58), v3(0.58, 5.7, 0.58), 1.3);
    add_rectangle(m, v3(-0.58, 5.5, -0.58), v3(1.16, 0, 0), v3(0, 0, 1.16), 1, 1);
}

/* Glass of 4.4 by 4.2 m that faces -X, in a gilded frame. */
static void mirror(mesh *m)
{
    const double half = 2.2, high = 4.2;
    use_material(m, "mirror");
    add_flat(m, (const vec[]){v3(0, 0, -half), v3(0, 0, half), v3(0, high, half), v3(0, high, -half)}, 4);
    static const double steps[][3] = {{0.00, 0.10, 0.05}, {0.10, 0.22, 0.14}, {0.22, 0.30, 0.08}}; /* from, to, how far
                                                                                                      it stands out */
    use_material(m, "gold");
    for (int i = 0; i < 3; i++) {
        double a = steps[i][0], b = steps[i][1], x = -steps[i][2];
        for (int side = -1; side <= 1; side += 2) {
            double z0 = fmin(side * (half + a), side * (half + b)), z1 = fmax(side * (half + a), side * (half + b));
            add_box(m, v3(x, -b, z0), v3(0.05, high + b, z1), 1);
            double y0 = side < 0 ? -b : high + a, y1 = side < 0 ? -a : high + b;
            add_box(m, v3(x, y0, -half - a), v3(0.05, y1, half + a), 1);
            add_rectangle(m, v3(x, y0, half + a), v3(0, 0, -2 * (half + a)), v3(0.05 - x, 0, 0), 1, 1);
        }
    }
    for (int i = 0; i < 2; i++) add_torus(m, v3(-0.1, high + 0.42, (i - 0.5) * 0.7), 0.26, 0.05, 20, 8, 0, TAU);
    add_blob(m, v3(-0.12, high + 0.5, 0), v3(0.14, 0.26, 0.26), 2, 0.1, 3);
}

static void pedestal(mesh *m)
{
    static const double profile[][2] = {{0.78, 0},    {0.78, 0.16}, {0.78, 0.16}, {0.70, 0.16}, {0.70, 0.16},
                                        {0.68, 0.22}, {0.60, 0.28}, {0.58, 0.30}, {0.58, 0.30}, {0.58, 0.92},
                                        {0.58, 0.92}, {0.62, 0.95}, {0.70, 0.98}, {0.72, 1.02}, {0.72, 1.02},
                                        {0.72, 1.10}, {0.72, 1.10}, {0, 1.10}};
    use_material(m, "green_marble");
    add_lathe(m, profile, 18, 48, 4);
}

/* Two rings of candles on a chain; its middle is at the origin, the chain goes up to 2.2 m. */
static void chandelier(mesh *m)
{
    static const double stem[][2] = {{0, -0.34},  {0.06, -0.28}, {0.03, -0.20}, {0.10, -0.05}, {0.05, 0.15},
                                     {0.03, 0.3}, {0.07, 0.45},  {0.015, 0.6},  {0.015, 2.2}};
    static const double candle[][2] = {{0, 0},        {0.05, 0.01},  {0.05, 0.01}, {0.022, 0.03},
                                       {0.022, 0.15}, {0.022, 0.15}, {0, 0.15}};
    static const double flame[][2] = {{0, 0.15}, {0.018, 0.18}, {0.014, 0.21}, {0, 0.25}};
    use_material(m, "gold");
    add_lathe(m, stem, 9, 16, 0);
    for (int tier = 0; tier < 2; tier++) {
        double radius = tier ? 0.45 : 0.85, y = tier ? 0.30 : 0.0;
        int count = tier ? 6 : 10, first = m->corner_count;
        use_material(m, "gold");
        add_torus(m, v3(0, 0, 0), radius, 0.028, 48, 8, 0, TAU);
        for (int i = first; i < m->corner_count; i++) { /* lay it flat */
            corner *c = &m->corners[i];
            c->at = v3(c->at.x, y + c->at.z, -c->at.y), c->normal = v3(c->normal.x, c->normal.z, -c->normal.y);
        }
        for (int i = 0; i < count; i++) {
            double a = TAU * i / count;
            m->move = v3(radius * cos(a), y, radius * sin(a));
            use_material(m, "wax"), add_lathe(m, candle, 7, 10, 0);
            use_material(m, "flame"), add_lathe(m, flame, 4, 8, 0);
            m->move = v3(0, 0, 0);
            use_material(m, "gold");
            if (i % 2) continue;
            vec p = v3(radius * cos(a), y, radius * sin(a)), q = v3(0.03 * cos(a), y + 0.35, 0.03 * sin(a)),
                w = v3(-0.012 * sin(a), 0, 0.012 * cos(a));
            add_flat(m, (const vec[]){sub(p, w), add(p, w), add(q, w), sub(q, w)}, 4);
            add_flat(m, (const vec[]){add(p, w), sub(p, w), sub(q, w), add(q, w)}, 4);
        }
    }
}

static const char materials[] =
    "# made by daft_generate, CC0\n"
    "newmtl floor\nKa 1 1 1\nKd 1 1 1\nKs 0.1 0.1 0.1\nNs 60\nillum 2\nmap_Kd ../../textures/hall_floor.jpg\n\n"
    "newmtl panelling\nKa 1 1 1\nKd 1 1 1\nKs 0.06 0.06 0.06\nNs 30\nillum 2\nmap_Kd ../../textures/panelling.jpg\n\n"
    "newmtl damask\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/damask.jpg\n\n"
    "newmtl coffer\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/coffer.jpg\n\n"
    "newmtl carpet\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/carpet.jpg\n\n"
    "newmtl window\nKa 3.6 3.6 3.6\nKd 0.25 0.25 0.25\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/window.jpg\n\n"
    "newmtl stucco\nKa 0.86 0.82 0.74\nKd 0.86 0.82 0.74\nKs 0 0 0\nillum 1\n\n"
    "newmtl white_marble\nKa 0.88 0.86 0.82\nKd 0.88 0.86 0.82\nKs 0.18 0.18 0.18\nNs 50\nillum 2\n\n"
    "newmtl green_marble\nKa 0.42 0.62 0.52\nKd 0.42 0.62 0.52\nKs 0.2 0.2 0.2\nNs 60\nillum 2\nmap_Kd "
    "../../textures/marble.png\n\n"
    "newmtl bronze\nKa 0.50 0.34 0.18\nKd 0.50 0.34 0.18\nKs 0.55 0.42 0.25\nNs 40\nillum 2\n\n"
    "newmtl gold\nKa 0.80 0.60 0.22\nKd 0.80 0.60 0.22\nKs 0.6 0.5 0.25\nNs 60\nillum 2\n\n"
    "newmtl mirror\nKa 0.02 0.02 0.02\nKd 0.02 0.02 0.02\nKs 0.92 0.93 0.92\nNs 900\nillum 3\n\n"
    "newmtl wax\nKa 0.95 0.90 0.78\nKd 0.95 0.90 0.78\nKe 0.2 0.15 0.08\nKs 0 0 0\nillum 1\n\n"
    "newmtl flame\nKa 1 0.8 0.4\nKd 0 0 0\nKe 1 0.85 0.5\nKs 0 0 0\nillum 1\n";

bool generate_hall(const char *root)
{
    static const mesh_recipe list[] = {
        {"assets/meshes/hall/shell.obj", shell},           {"assets/meshes/hall/column.obj", column},
        {"assets/meshes/hall/mirror.obj", mirror},         {"assets/meshes/hall/pedestal.obj", pedestal},
        {"assets/meshes/hall/chandelier.obj", chandelier},
    };
    return paint_square(root, "assets/textures/hall_floor.jpg", 512, floor_color) &&
           paint_square(root, "assets/textures/damask.jpg", 256, damask) &&
           paint_square(root, "assets/textures/panelling.jpg", 256, panelling) &&
           paint_square(root, "assets/textures/coffer.jpg", 256, coffer) &&
           paint_square(root, "assets/textures/carpet.jpg", 256, carpet) &&
           paint_square(root, "assets/textures/window.jpg", 256, window_color) &&
           write_text(root, "assets/meshes/hall/hall.mtl", materials) &&
           write_meshes(root, list, sizeof list / sizeof list[0], "hall.mtl") && generate_sculptures(root);
}
