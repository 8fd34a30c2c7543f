/* The scene `forest`: plants and rocks of 200 to 3,000 triangles, the ground with a path through it, and where each of
 * the thousand stands. Crowns are rough balls under a texture of leaves, with single sprigs that break their outline.
 */
#include "mesh.h"

#include <math.h>

static const double TAU = 6.283185307179586;

/* ---- textures: leaves, needles, bark, the ground ---- */

static double edge_distance(double f) { return f < 0.5 ? f : 1 - f; }

/* The distance in cells to the nearest leaf's middle line, and which leaf it is: leaves lie on a jittered grid, and
 * those with a higher hash lie on top. */
static color leaf_layer(double u, double v, int count, int seed, color dark, color bright)
{
    color c = shade(dark, 0.55);
    double top = -1;
    int cu = (int)floor(u * count), cv = (int)floor(v * count);
    for (int dy = -1; dy <= 1; dy++) {
        for (int dx = -1; dx <= 1; dx++) {
            int i = cu + dx, j = cv + dy, wi = (i + count) % count, wj = (j + count) % count;
            double rank = hash01(wi, wj, seed), angle = TAU * hash01(wi, wj, seed + 1);
            double x = u * count - i - 0.2 - 0.6 * hash01(wi, wj, seed + 2);
            double y = v * count - j - 0.2 - 0.6 * hash01(wi, wj, seed + 3);
            double along = x * cos(angle) + y * sin(angle), across = -x * sin(angle) + y * cos(angle);
            double width = 0.38 * (1 - along * along / 0.72);
            if (fabs(along) > 0.85 || fabs(across) > width || rank < top) continue;
            top = rank;
            double vein = smoothstep(0, 0.05, fabs(across)), rim = smoothstep(0, 0.12, width - fabs(across));
            c = shade(mix(dark, bright, rank * rank), (0.8 + 0.2 * vein) * (0.72 + 0.28 * rim) + 0.12 * along);
        }
    }
    return c;
}

static color leaves(double u, double v) { return leaf_layer(u, v, 11, 201, rgb(0x3f7f27), rgb(0x9fd052)); }

static color birch_leaves(double u, double v) { return leaf_layer(u, v, 14, 211, rgb(0x7d9c2c), rgb(0xe6d65a)); }

static color needles(double u, double v)
{
    double spine = noise(u * 24, v * 6, 48, 221), strand = noise(u * 60, v * 8, 120, 223);
    color c = mix(rgb(0x1d4a30), rgb(0x5f9a5c), 0.5 + 0.5 * spine + 0.45 * strand);
    return shade(c, 0.75 + 0.3 * edge_distance(v));
}

static color bark(double u, double v)
{
    double warp = 0.12 * fractal(u * 4, v * 4, 4, 3, 231), ridge = fabs(noise((u + warp) * 14, v * 5, 70, 233));
    color c = mix(rgb(0x3d2a1d), rgb(0x8a6a4c), smoothstep(0.02, 0.5, ridge));
    return shade(mix(c, rgb(0x6f7f4a), 0.5 * smoothstep(0.1, 0.45, fractal(u * 3, v * 3, 3, 4, 237))),
                 1 + 0.25 * noise(u * 40, v * 30, 240, 235));
}

static color birch_bark(double u, double v)
{
    double line = noise(u * 5, v * 34, 170, 241),
           mark = smoothstep(0.42, 0.62, line + 0.25 * noise(u * 9, v * 9, 9, 243));
    color c = shade(mix(rgb(0xe9e4d8), rgb(0xc9bfae), 0.5 + fractal(u * 4, v * 8, 8, 4, 245)), 1 + 0.04 * line);
    return mix(c, rgb(0x2f2a27), mark);
}

/* Moss, old leaves and twigs. */
static color floor_color(double u, double v)
{
    double moss = fractal(u * 5, v * 5, 5, 5, 251), fine = noise(u * 70, v * 70, 70, 253);
    color c = mix(rgb(0x5d4a2c), rgb(0x5f8a37), smoothstep(-0.22, 0.2, moss));
    c = shade(c, 1 + 0.22 * fine + 0.2 * noise(u * 28, v * 28, 28, 255));
    color litter = leaf_layer(u, v, 24, 257, rgb(0x6f4f2a), rgb(0xc08a48));
    return mix(c, litter, 0.75 * smoothstep(0.18, 0.32, fractal(u * 9, v * 9, 9, 3, 259) + 0.12));
}

/* u goes across: trodden earth with two tracks, and moss that creeps in from both sides. */
static color path_color(double u, double v)
{
    double ragged = 0.10 * noise(v * 9, u * 9, 9, 261) + 0.05 * noise(v * 31, u * 31, 31, 263);
    double middle = fabs(u - 0.5), earth = smoothstep(0.44, 0.34, middle + ragged);
    color c = mix(rgb(0x9a7b52), rgb(0xc4a376), 0.5 + 0.8 * fractal(u * 6, v * 6, 6, 5, 265));
    c = shade(c, 1 - 0.16 * smoothstep(0.10, 0.02, fabs(middle - 0.17)) + 0.1 * noise(u * 60, v * 60, 60, 267));
    double stone = hash01((int)(u * 26), (int)(v * 26), 269), su = u * 26 - floor(u * 26) - 0.5,
           sv = v * 26 - floor(v * 26) - 0.5;
    if (stone > 0.93)
        c = mix(c, shade(rgb(0xb5aea0), 1.05 + 0.5 * (sv - su)),
                smoothstep(0.40, 0.30, sqrt(su * su + sv * sv) + 0.3 * (1 - stone)));
    return mix(floor_color(u, v), c, earth);
}

static color rock_color(double u, double v)
{
    double grain = fractal(u * 6, v * 6, 6, 6, 271), crack = fabs(fractal(u * 4, v * 4, 4, 4, 273));
    color c = mix(rgb(0x6d6a66), rgb(0xb3aea4), 0.5 + 0.9 * grain);
    c = mix(rgb(0x4c4a48), c, smoothstep(0.0, 0.05, crack));
    return mix(c, rgb(0x7f9150), 0.7 * smoothstep(0.12, 0.3, fractal(u * 5, v * 5, 5, 4, 277)));
}

static bool paint_forest(const char *root)
{
    return paint_square(root, "assets/textures/leaves.jpg", 256, leaves) &&
           paint_square(root, "assets/textures/birch_leaves.jpg", 256, birch_leaves) &&
           paint_square(root, "assets/textures/needles.jpg", 256, needles) &&
           paint_square(root, "assets/textures/bark.jpg", 256, bark) &&
           paint_square(root, "assets/textures/birch_bark.jpg", 256, birch_bark) &&
           paint_square(root, "assets/textures/forest_floor.jpg", 512, floor_color) &&
           paint_square(root, "assets/textures/path.jpg", 512, path_color) &&
           paint_square(root, "assets/textures/rock.jpg", 256, rock_color);
}

/* ---- plants and rocks ---- */

/* Kites of leaves that stand out of an ellipsoid, so that its outline is not a ball's. */
static void add_sprigs(mesh *m, vec center, vec radius, int count, double size, int seed)
{
    for (int i = 0; i < count; i++) {
        vec d = random_direction(i, seed),
            base = add(center, v3(0.86 * d.x * radius.x, 0.86 * d.y * radius.y, 0.86 * d.z * radius.z));
        vec out = normal_of(add(add(d, v3(0, 0.25, 0)), times(random_direction(i, seed + 1), 0.7)));
        vec side = normal_of(cross(out, random_direction(i, seed + 2))),
            normal = normal_of(add(times(d, 2), cross(side, out)));
        double s = size * (0.7 + 0.6 * hash01(i, 3, seed)), u = hash01(i, 4, seed), v = hash01(i, 5, seed);
        vec middle = add(base, times(out, 0.5 * s)), tip = add(base, times(out, s));
        const corner c[4] = {{base, normal, u, v},
                             {add(middle, times(side, 0.36 * s)), normal, u + 0.3, v + 0.2},
                             {tip, normal, u, v + 0.45},
                             {sub(middle, times(side, 0.36 * s)), normal, u - 0.3, v + 0.2}};
        add_face(m, c, 4, true);
    }
}

static void add_crown(mesh *m, vec center, vec radius, int level, int sprigs, double size, int seed)
{
    add_soft_blob(m, center, radius, level, 0.55, seed, 1.1, 0.65);
    add_sprigs(m, center, radius, sprigs, size, seed + 40);
}

static void oak_of(mesh *m, int seed)
{
    vec spine[6];
    double radii[6], lean = 0.5 * (hash01(0, 0, seed) - 0.5);
    for (int i = 0; i < 6; i++) {
        double t = i / 5.0;
        spine[i] = v3(lean * t * t + 0.08 * noise(t * 3, 0.5, 64, seed), 3.4 * t - 0.25,
                      0.1 * noise(t * 3, 7.5, 64, seed + 1));
        radii[i] = 0.23 * (1 - 0.55 * t) + 0.16 * pow(1 - t, 6);
    }
    use_material(m, "bark");
    add_tube(m, spine, radii, 6, 9, 1.4);
    for (int i = 0; i < 4; i++) {
        double a = TAU * (i + 0.6 * hash01(i, 7, seed)) / 4;
        vec from = spine[3 + i % 2], tip = add(from, v3(1.15 * cos(a), 1.0, 1.15 * sin(a)));
        add_tube(m, (const vec[]){from, times(add(from, add(tip, v3(0, -0.2, 0))), 0.5), tip},
                 (const double[]){0.11 + 0.003 * i, 0.08, 0.04}, 3, 6, 1.4); /* two start at one point: no shared rings
                                                                              */
    }
    use_material(m, "leaves");
    vec top = add(spine[5], v3(0, 1.0, 0));
    add_crown(m, top, v3(1.45, 1.2, 1.45), 2, 120, 0.5, seed + 11);
    for (int i = 0; i < 5; i++) {
        double a = TAU * (i + 0.5 * hash01(i, 8, seed)) / 5, r = 1.15 + 0.4 * hash01(i, 9, seed);
        vec at = v3(top.x + r * cos(a), 3.0 + 1.1 * hash01(i, 10, seed), top.z + r * sin(a));
        double s = 0.72 + 0.32 * hash01(i, 11, seed);
        use_material(m, i % 2 ? "leaves_dark" : "leaves");
        add_crown(m, at, v3(s, 0.8 * s, s), i % 2 ? 1 : 2, 60, 0.45, seed + 20 + i);
    }
}

static void oak(mesh *m) { oak_of(m, 300); }
static void oak_wide(mesh *m) { oak_of(m, 340); }

static void birch_of(mesh *m, int seed)
{
    vec spine[8];
    double radii[8];
    for (int i = 0; i < 8; i++) {
        double t = i / 7.0;
        spine[i] = v3(0.7 * (hash01(0, 1, seed) - 0.5) * t * t + 0.06 * noise(t * 4, 0.5, 64, seed), 6.2 * t - 0.2,
                      0.5 * (hash01(0, 2, seed) - 0.5) * t * t);
        radii[i] = 0.13 * (1 - 0.85 * t) + 0.03;
    }
    use_material(m, "birch_bark");
    add_tube(m, spine, radii, 8, 8, 1.2);
    for (int i = 0; i < 9; i++) {
        double a = TAU * 0.381966 * i, t = 0.42 + 0.06 * i, reach = 1.25 * (1.15 - t);
        vec from = add(spine[(int)(t * 7)], v3(0, 0.2, 0)), tip = add(from, v3(reach * cos(a), 0.55, reach * sin(a)));
        use_material(m, "birch_bark");
        add_tube(m, (const vec[]){from, tip}, (const double[]){0.04 + 0.001 * i, 0.015}, 2, 4, 1);
        use_material(m, "birch_leaves");
        double s = 0.5 + 0.25 * hash01(i, 12, seed);
        add_crown(m, add(tip, v3(0, -0.05, 0)), v3(s, 0.85 * s, s), 1, 45, 0.36, seed + 30 + i);
    }
    add_crown(m, add(spine[7], v3(0, -0.1, 0)), v3(0.5, 0.8, 0.5), 1, 50, 0.34, seed + 60);
}

static void birch(mesh *m) { birch_of(m, 400); }
static void birch_slim(mesh *m) { birch_of(m, 430); }

/* Branches in whorls, each two bent panels that droop to a tip; shorter the higher. */
static void spruce_of(mesh *m, int whorls, double height, double spread, int seed)
{
    static const double stem[][2] = {{0.30, -0.2}, {0.21, 0.3}, {0.18, 1.2}, {0.02, 1.0}};
    double profile[4][2];
    for (int i = 0; i < 4; i++)
        profile[i][0] = stem[i][0] * height / 7, profile[i][1] = i < 3 ? stem[i][1] : 0.97 * height;
    use_material(m, "bark");
    add_lathe(m, profile, 4, 8, 2);
    for (int k = 0; k < whorls; k++) {
        double t = (double)k / whorls, low = 0.75 + (height - 0.75) * pow(t, 0.92), reach = spread * (1 - 0.93 * t);
        int branches = k < whorls / 2 ? 11 : k < whorls - 2 ? 9 : 6;
        use_material(m, k % 3 ? "needles" : "needles_dark");
        for (int i = 0; i < branches; i++) {
            double a = TAU * (i + 0.37 * k + 0.35 * hash01(i, k, seed)) / branches,
                   r = reach * (0.8 + 0.35 * hash01(i, k, seed + 1));
            double half = TAU * 0.56 / branches, droop = 0.30 * r, y = low + 0.10 * (hash01(i, k, seed + 2) - 0.5);
            vec root = v3(0, y + 0.42 * reach + 0.18, 0), tip = v3(r * cos(a), y - droop, r * sin(a));
            vec left = v3(0.66 * r * cos(a - half), y - 0.25 * droop, 0.66 * r * sin(a - half));
            vec right = v3(0.66 * r * cos(a + half), y - 0.25 * droop, 0.66 * r * sin(a + half));
            vec ridge = v3(0.62 * r * cos(a), y + 0.20 * r, 0.62 * r * sin(a));
            vec up = normal_of(v3(cos(a), 1.1, sin(a)));
            const corner top = {root, up, 0.5, 0}, middle = {ridge, up, 0.5, 0.6}, end = {tip, up, 0.5, 1};
            vec ln = normal_of(v3(cos(a - 2 * half), 0.8, sin(a - 2 * half))),
                rn = normal_of(v3(cos(a + 2 * half), 0.8, sin(a + 2 * half)));
            const corner l = {left, ln, 0, 0.6}, rr = {right, rn, 1, 0.6};
            add_face(m, (const corner[]){top, middle, l}, 3, true),
                add_face(m, (const corner[]){middle, end, l}, 3, true);
            add_face(m, (const corner[]){top, rr, middle}, 3, true),
                add_face(m, (const corner[]){middle, rr, end}, 3, true);
        }
    }
}

static void spruce(mesh *m) { spruce_of(m, 15, 7.5, 1.75, 500); }
static void spruce_young(mesh *m) { spruce_of(m, 9, 3.4, 1.15, 520); }

static void bush(mesh *m)
{
    use_material(m, "leaves_dark");
    add_crown(m, v3(0.30, 0.42, 0.1), v3(0.55, 0.46, 0.5), 1, 60, 0.3, 611);
    use_material(m, "leaves");
    add_crown(m, v3(-0.25, 0.36, 0.2), v3(0.5, 0.42, 0.5), 1, 60, 0.28, 621);
    add_crown(m, v3(-0.02, 0.5, -0.3), v3(0.52, 0.5, 0.46), 1, 60, 0.28, 631);
}

/* The same with berries. */
static void berries(mesh *m)
{
    bush(m);
    use_material(m, "berry");
    for (int i = 0; i < 24; i++) {
        vec d = random_direction(i, 641);
        add_blob(m, v3(0.72 * d.x, 0.45 + 0.4 * d.y, 0.68 * d.z), v3(0.04, 0.04, 0.04), 0, 0, 1);
    }
}

/* Fronds that rise and bend over, each of two rows of panels with a crease. */
static void fern(mesh *m)
{
    enum { FRONDS = 11, PARTS = 6 };
    use_material(m, "fern");
    for (int i = 0; i < FRONDS; i++) {
        double a = TAU * (i + 0.5 * hash01(i, 0, 651)) / FRONDS, length_ = 0.75 + 0.35 * hash01(i, 1, 651),
               rise = 0.75 + 0.4 * hash01(i, 2, 651);
        vec out = v3(cos(a), 0, sin(a)), side = v3(-sin(a), 0, cos(a));
        for (int k = 0; k < PARTS; k++) {
            double s[2] = {(double)k / PARTS, (k + 1.0) / PARTS};
            vec mid[2], left[2], right[2];
            for (int j = 0; j < 2; j++) {
                double t = s[j], width = 0.30 * length_ * sin(3.0 * pow(t, 0.7)) + 0.01;
                mid[j] = add(times(out, length_ * t), v3(0, rise * (1.5 * t - 1.35 * t * t), 0));
                left[j] = add(mid[j], add(times(side, -0.5 * width), v3(0, -0.12 * width, 0)));
                right[j] = add(mid[j], add(times(side, 0.5 * width), v3(0, -0.12 * width, 0)));
            }
            add_panel(m, (const vec[]){mid[0], left[0], left[1], mid[1]}, 0.5, 2 * s[0], 0, 2 * s[1]);
            add_panel(m, (const vec[]){right[0], mid[0], mid[1], right[1]}, 1, 2 * s[0], 0.5, 2 * s[1]);
        }
    }
}

/* Bent blades of grass and a few flowers among them. */
static void tuft(mesh *m)
{
    use_material(m, "blade");
    for (int i = 0; i < 70; i++) {
        double a = TAU * hash01(i, 0, 661), r = 0.42 * sqrt(hash01(i, 1, 661)), tall = 0.22 + 0.30 * hash01(i, 2, 661),
               b = TAU * hash01(i, 3, 661);
        vec root = v3(r * cos(a), -0.02, r * sin(a)), side = v3(0.012 * sin(b), 0, -0.012 * cos(b)),
            bend = v3(0.35 * tall * cos(b), 0, 0.35 * tall * sin(b));
        vec middle = add(root, add(v3(0, 0.62 * tall, 0), times(bend, 0.4))),
            tip = add(root, add(v3(0, tall, 0), bend));
        add_panel(m, (const vec[]){sub(root, side), add(root, side), add(middle, side), sub(middle, side)}, 0, 0, 0.1,
                  0.6);
        add_flat(m, (const vec[]){sub(middle, side), add(middle, side), tip}, 3);
    }
    use_material(m, "petal");
    for (int i = 0; i < 5; i++) {
        double a = TAU * (i + 0.5) / 5, r = 0.18 + 0.16 * hash01(i, 4, 661);
        add_blob(m, v3(r * cos(a), 0.36 + 0.12 * hash01(i, 5, 661), r * sin(a)), v3(0.035, 0.022, 0.035), 0, 0, 1);
    }
}

static void boulder(mesh *m)
{
    use_material(m, "rock");
    add_soft_blob(m, v3(0, 0.42, 0), v3(0.95, 0.72, 0.8), 3, 0.8, 671, 1.3, 0.25);
}

static void stones(mesh *m)
{
    use_material(m, "rock");
    add_soft_blob(m, v3(-0.3, 0.14, 0.1), v3(0.36, 0.27, 0.32), 2, 0.7, 681, 0.9, 0.25);
    add_soft_blob(m, v3(0.34, 0.10, -0.16), v3(0.27, 0.19, 0.25), 1, 0.7, 683, 0.9, 0.25);
    add_soft_blob(m, v3(0.10, 0.07, 0.36), v3(0.18, 0.13, 0.17), 1, 0.7, 685, 0.9, 0.25);
}

/* A sawn stump with mushrooms. */
static void stump(mesh *m)
{
    static const double wood[][2] = {{0.52, -0.1}, {0.40, 0.06}, {0.34, 0.22}, {0.33, 0.46}, {0.33, 0.46}, {0, 0.47}};
    static const double cap[][2] = {{0.03, 0},    {0.022, 0.10},  {0.022, 0.10}, {0.10, 0.09},
                                    {0.10, 0.09}, {0.095, 0.125}, {0.06, 0.16},  {0, 0.175}};
    use_material(m, "bark");
    add_lathe(m, wood, 6, 14, 3);
    use_material(m, "mushroom");
    for (int i = 0; i < 3; i++) {
        m->move = v3(0.45 + 0.13 * i, 0, 0.28 - 0.24 * i);
        add_lathe(m, cap, 8, 10, 0);
    }
    m->move = v3(0, 0, 0);
}

/* ---- the ground ---- */

static double path_at(double x) { return 3.6 * sin(x / 13) + 1.6 * sin(x / 6.3 + 1); }

static double height_at(double x, double z)
{
    double w = fabs(z - path_at(x)), off = fmax(0, w - 2.5), hills = fractal3(x / 17, 0.5, z / 17, 4, 701);
    return 0.9 * fractal3(x / 31, 3.5, 0.5, 2, 703) + 2.6 * hills * smoothstep(1.5, 14, w) + 0.006 * off * off;
}

static corner ground_corner(double x, double w, bool path)
{
    double z = path_at(x) + w, y = height_at(x, z), e = 0.05;
    vec n = normal_of(v3((y - height_at(x + e, z)) / e, 1, (y - height_at(x, z + e)) / e));
    return (corner){v3(x, y, z), n, path ? (w + 1.9) / 3.8 : x / 4, path ? x / 3.8 : -z / 4};
}

static void ground(mesh *m)
{
    static const double across[] = {-62,  -48,  -38,  -30,  -24,   -19, -15,  -12, -9.5, -7.5, -6,
                                    -4.6, -3.4, -2.6, -1.9, -0.95, 0,   0.95, 1.9, 2.6,  3.4,  4.6,
                                    6,    7.5,  9.5,  12,   15,    19,  24,   30,  38,   48,   62};
    enum { COLUMNS = sizeof across / sizeof across[0] - 1, ROWS = 104 };
    for (int i = 0; i < ROWS; i++) {
        double a = -16 + 1.4 * i, b = a + 1.4;
        for (int k = 0; k < COLUMNS; k++) {
            double w = across[k], x = across[k + 1];
            bool path = fabs(w + x) < 3.8;
            use_material(m, path ? "path" : "floor");
            const corner c[4] = {ground_corner(a, w, path), ground_corner(a, x, path), ground_corner(b, x, path),
                                 ground_corner(b, w, path)};
            add_face(m, c, 4, true);
        }
    }
}

/* ---- what stands where ---- */

typedef struct kind {
    const char *mesh;
    int count;
    double near, far;   /* metres from the path's middle */
    double small, tall; /* scale */
    double sink;        /* metres below the ground */
    double room;        /* metres around it, at scale 1, that it keeps free of others of its height */
} kind;

typedef struct place {
    double x, z, size, room;
} place;

/* Whether two would stand in each other. */
static bool crowded(const place *taken, int count, place p)
{
    for (int i = 0; i < count; i++) {
        double x = taken[i].x - p.x, z = taken[i].z - p.z, apart = taken[i].room + p.room;
        if (x * x + z * z < apart * apart) return true;
    }
    return false;
}

/* The first free one of some random places; the last, if none is. */
static place find_place(const kind *k, int i, int seed, const place *taken, int count)
{
    place p = {0, 0, 1, 0};
    for (int t = 0; t < 40; t++) {
        double far = pow(hash01(i, 1 + 8 * t, seed), 1.6), side = hash01(i, 2 + 8 * t, seed) < 0.5 ? -1 : 1;
        p.x = -12 + 134 * (i + hash01(i, 8 * t, seed)) / k->count;
        p.z = path_at(p.x) + side * (k->near + (k->far - k->near) * far);
        p.size = k->small + (k->tall - k->small) * hash01(i, 3 + 8 * t, seed);
        p.room = k->room * p.size;
        if (!crowded(taken, count, p)) break;
    }
    return p;
}

static bool write_plants(const char *root)
{
    static const kind kinds[] = {
        {"oak", 95, 5.0, 42, 0.9, 1.5, 0.1, 1.5},     {"oak_wide", 75, 5.4, 42, 0.9, 1.5, 0.1, 1.5},
        {"birch", 70, 3.6, 26, 0.9, 1.35, 0.05, 0.8}, {"birch_slim", 60, 3.3, 26, 0.8, 1.3, 0.05, 0.8},
        {"spruce", 130, 6.0, 54, 0.9, 1.7, 0.1, 1.1}, {"spruce_young", 60, 3.8, 30, 0.6, 1.3, 0.05, 0.8},
        {"bush", 90, 2.9, 22, 0.8, 1.7, 0.06, 0.5},   {"berries", 50, 2.7, 14, 0.7, 1.2, 0.06, 0.5},
        {"boulder", 45, 3.3, 26, 0.5, 1.7, 0.2, 0.7}, {"stump", 20, 2.7, 14, 0.8, 1.3, 0.05, 0.4},
        {"stones", 55, 2.0, 9, 0.5, 1.4, 0.03, 0.3},  {"fern", 120, 2.3, 14, 0.6, 1.2, 0.03, 0.4},
        {"tuft", 130, 1.75, 8, 0.8, 1.5, 0.01, 0.2},
    };
    enum { MAX_PLANTS = 1000 };
    place taken[MAX_PLANTS];
    int count = 0;
    FILE *f = open_output(root, "assets/scenes/parts/forest.scene");
    if (!f) return false;
    fprintf(f, "# made by daft_generate, CC0: a thousand trees, bushes and rocks along a path\n");
    for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
        for (int i = 0; i < kinds[k].count && count < MAX_PLANTS; i++) {
            place p = find_place(&kinds[k], i, 800 + 10 * (int)k, taken, count);
            taken[count++] = p;
            fprintf(f, "mesh ../../meshes/forest/%s.obj %.2f %.2f %.2f %.2f 0 %.0f 0\n", kinds[k].mesh, p.x,
                    height_at(p.x, p.z) - kinds[k].sink, p.z, p.size, 360 * hash01(i, 4, 800 + 10 * (int)k));
        }
    }
    return close_output(f, "assets/scenes/parts/forest.scene");
}

static const char materials[] =
    "# made by daft_generate, CC0\n"
    "newmtl bark\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/bark.jpg\n\n"
    "newmtl birch_bark\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/birch_bark.jpg\n\n"
    "newmtl leaves\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/leaves.jpg\n\n"
    "newmtl leaves_dark\nKa 0.62 0.78 0.66\nKd 0.62 0.78 0.66\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/leaves.jpg\n\n"
    "newmtl birch_leaves\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/birch_leaves.jpg\n\n"
    "newmtl needles\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/needles.jpg\n\n"
    "newmtl needles_dark\nKa 0.7 0.8 0.85\nKd 0.7 0.8 0.85\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/needles.jpg\n\n"
    "newmtl fern\nKa 1.15 1.25 0.8\nKd 1.15 1.25 0.8\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/needles.jpg\n\n"
    "newmtl blade\nKa 0.42 0.60 0.16\nKd 0.42 0.60 0.16\nKs 0 0 0\nillum 1\n\n"
    "newmtl petal\nKa 0.95 0.85 0.95\nKd 0.95 0.85 0.95\nKs 0 0 0\nillum 1\n\n"
    "newmtl berry\nKa 0.75 0.05 0.08\nKd 0.75 0.05 0.08\nKs 0 0 0\nillum 1\n\n"
    "newmtl mushroom\nKa 0.78 0.32 0.14\nKd 0.78 0.32 0.14\nKs 0 0 0\nillum 1\n\n"
    "newmtl rock\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/rock.jpg\n\n"
    "newmtl floor\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/forest_floor.jpg\n\n"
    "newmtl path\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/path.jpg\n";

bool generate_forest(const char *root)
{
    static const mesh_recipe list[] = {
        {"assets/meshes/forest/oak.obj", oak},         {"assets/meshes/forest/oak_wide.obj", oak_wide},
        {"assets/meshes/forest/birch.obj", birch},     {"assets/meshes/forest/birch_slim.obj", birch_slim},
        {"assets/meshes/forest/spruce.obj", spruce},   {"assets/meshes/forest/spruce_young.obj", spruce_young},
        {"assets/meshes/forest/bush.obj", bush},       {"assets/meshes/forest/berries.obj", berries},
        {"assets/meshes/forest/fern.obj", fern},       {"assets/meshes/forest/tuft.obj", tuft},
        {"assets/meshes/forest/boulder.obj", boulder}, {"assets/meshes/forest/stones.obj", stones},
        {"assets/meshes/forest/stump.obj", stump},     {"assets/meshes/forest/ground.obj", ground},
    };
    return paint_forest(root) && write_text(root, "assets/meshes/forest/forest.mtl", materials) &&
           write_meshes(root, list, sizeof list / sizeof list[0], "forest.mtl") && write_plants(root);
}
