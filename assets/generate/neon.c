/* The scene `neon`: a wet lane of the town at night. Signs of bent glass tubes, lit windows, a vending machine and
 * lamps, all of which light by what they are. Signs stand in the plane z = 0 and are seen from +Z. */
#include "mesh.h"

#include <math.h>

static const double TAU = 6.283185307179586;

/* ---- textures ---- */

/* Where water stands, 0..1. */
static double puddle(double u, double v) { return smoothstep(-0.16, 0.04, fractal(u * 3, v * 3, 3, 4, 211)); }

static color wet_roughness(double u, double v)
{
    int i = 0, j = 0;
    double gap = cobble_gap(u, v, &i, &j), stone = 0.14 + 0.08 * hash01(i, j, 213);
    double r = 0.10 + (stone - 0.10) * smoothstep(0.02, 0.2, gap);
    r += (0.02 - r) * puddle(u, v);
    return (color){r, r, r};
}

/* Stones are domes; puddles cover them. */
static color wet_height(double u, double v)
{
    int i = 0, j = 0;
    double gap = cobble_gap(u, v, &i, &j), h = 0.15 + 0.75 * sqrt(clamp01(gap / 0.55)), water = 0.82;
    h += (water + 0.15 * fmax(h - water, 0) - h) * puddle(u, v);
    return (color){h, h, h};
}

/* A window with a light in the room behind its curtains. */
static color lit_window(double u, double v)
{
    double x = 2 * u - 1, bar = fmin(fabs(x), fmin(fabs(v - 0.34), fabs(v - 0.67)) * 1.6),
           frame = fmin(fmin(u, 1 - u), fmin(v, 1 - v) * 1.6);
    double lamp = exp(-2.2 * (x - 0.2) * (x - 0.2) - 5 * (v - 0.45) * (v - 0.45));
    double fold = 0.5 + 0.5 * sin(TAU * (9 * u + 0.25 * noise(u * 4, v * 2, 64, 217)));
    double curtain = smoothstep(0.52, 0.62, fabs(x) + 0.08 * v);
    color c = mix(rgb(0x8a4a1c), rgb(0xffdf9a), 0.25 + 0.75 * lamp);
    c = mix(c, shade(rgb(0xc4602e), 0.45 + 0.5 * fold), curtain);
    return mix(rgb(0x1a100a), c, fmin(smoothstep(0.02, 0.045, bar), smoothstep(0.045, 0.065, frame)));
}

/* Rows of bottles behind the glass of a machine, and a banner above them. */
static color machine_front(double u, double v)
{
    static const int drinks[6] = {0xff5040, 0x48c8ff, 0xffd040, 0x60e070, 0xff70c0, 0xf0f0ff};
    double edge = fmin(u, 1 - u);
    color back = mix(rgb(0xbfe4ff), rgb(0xf4fbff), 0.5 + 0.5 * cos(TAU * v * 4));
    if (v > 0.86) {
        double wave = 0.93 + 0.025 * sin(TAU * 2 * u);
        return mix(rgb(0xff3d6e), rgb(0xffffff), smoothstep(0.012, 0.004, fabs(v - wave)));
    }
    if (edge < 0.05 || v < 0.16) return v < 0.16 && v > 0.06 && u > 0.2 && u < 0.8 ? rgb(0x05080c) : rgb(0x2a3c50);
    double fy = (v - 0.16) / 0.70 * 4, row = floor(fy), y = fy - row, fx = (u - 0.05) / 0.9 * 7, column = floor(fx),
           x = fabs(fx - column - 0.5);
    if (y < 0.10) return rgb(0x6a7c90);
    double wide = y < 0.62 ? 0.30 : y < 0.78 ? 0.30 - 1.1 * (y - 0.62) : y < 0.90 ? 0.12 : 0;
    color drink = rgb(drinks[(int)(column + 2 * row) % 6]);
    color label = y > 0.26 && y < 0.46 ? mix(drink, rgb(0xffffff), 0.75) : drink;
    return mix(back, shade(label, 1.05 - 1.6 * x), smoothstep(0.012, -0.012, x - wide));
}

/* ---- tubes ---- */

enum { MOST = 256, SIDES = 6 };

/* A pen's path in the plane. */
typedef struct pen {
    vec points[MOST];
    int count;
} pen;

static void go(pen *p, double x, double y)
{
    if (p->count < MOST) p->points[p->count++] = v3(x, y, 0);
}

/* Part of an ellipse; angles in turns, 0 to the right and counter-clockwise. */
static void bend(pen *p, double x, double y, double rx, double ry, double from, double to)
{
    const int steps = (int)ceil(fabs(to - from) * 28);
    for (int i = 0; i <= steps; i++) {
        const double a = TAU * (from + (to - from) * i / steps);
        go(p, x + rx * cos(a), y + ry * sin(a));
    }
}

/* Makes a tube of the path and lifts the pen. Corners are mitred. */
static void blow(mesh *m, pen *p, double radius)
{
    vec ring[2][SIDES], out[SIDES];
    int made = 0;
    for (int i = 0; i < p->count; i++) {
        vec a = p->points[i > 0 ? i - 1 : 0], b = p->points[i], c = p->points[i + 1 < p->count ? i + 1 : i];
        vec before = sub(b, a), after = sub(c, b);
        if (length(before) < 1e-9) before = after;
        if (length(after) < 1e-9) after = before;
        before = times(before, 1 / length(before)), after = times(after, 1 / length(after));
        vec way = add(before, after);
        if (length(way) < 1e-3) way = before;
        way = times(way, 1 / length(way));
        const vec side = v3(-way.y, way.x, 0);
        const double wide = fmin(1 / fmax(dot(way, before), 0.3), 2);
        for (int k = 0; k < SIDES; k++) {
            const double angle = TAU * k / SIDES;
            out[k] = add(times(side, cos(angle)), v3(0, 0, sin(angle)));
            ring[i % 2][k] = add(b, add(times(side, radius * wide * cos(angle)), v3(0, 0, radius * sin(angle))));
        }
        for (int k = 0; made && k < SIDES; k++) {
            const int n = (k + 1) % SIDES, w = (i + 1) % 2;
            const corner f[4] = {{ring[w][n], out[n], 0, 0},
                                 {ring[w][k], out[k], 0, 0},
                                 {ring[i % 2][k], out[k], 0, 0},
                                 {ring[i % 2][n], out[n], 0, 0}};
            add_face(m, f, 4, false);
        }
        made = 1;
    }
    p->count = 0;
}

/* A letter of height h with its lower left corner at x, y. Returns how wide it is. */
static double letter(mesh *m, char which, double x, double y, double h, double radius)
{
    pen p = {.count = 0};
    const double w = 0.56 * h, half = h / 2;
    switch (which) {
    case 'A':
        go(&p, x, y), go(&p, x + w / 2, y + h), go(&p, x + w, y), blow(m, &p, radius);
        go(&p, x + 0.2 * w, y + 0.36 * h), go(&p, x + 0.8 * w, y + 0.36 * h), blow(m, &p, radius);
        break;
    case 'B':
        go(&p, x, y), go(&p, x, y + h), bend(&p, x + 0.45 * w, y + 0.75 * h, 0.45 * w, h / 4, 0.25, -0.25);
        go(&p, x, y + half), blow(m, &p, radius);
        go(&p, x + 0.4 * w, y + half), bend(&p, x + 0.5 * w, y + 0.25 * h, 0.5 * w, h / 4, 0.25, -0.25), go(&p, x, y);
        blow(m, &p, radius);
        break;
    case 'R':
        go(&p, x, y), go(&p, x, y + h), bend(&p, x + 0.45 * w, y + 0.75 * h, 0.5 * w, h / 4, 0.25, -0.25);
        go(&p, x, y + half), blow(m, &p, radius);
        go(&p, x + 0.45 * w, y + half), go(&p, x + w, y), blow(m, &p, radius);
        break;
    case 'H':
        go(&p, x, y), go(&p, x, y + h), blow(m, &p, radius);
        go(&p, x + w, y), go(&p, x + w, y + h), blow(m, &p, radius);
        go(&p, x, y + half), go(&p, x + w, y + half), blow(m, &p, radius);
        break;
    case 'O': bend(&p, x + w / 2, y + half, w / 2, half, 0, 1), blow(m, &p, radius); break;
    case 'T':
        go(&p, x, y + h), go(&p, x + w, y + h), blow(m, &p, radius);
        go(&p, x + w / 2, y + h), go(&p, x + w / 2, y), blow(m, &p, radius);
        break;
    case 'E':
        go(&p, x + w, y + h), go(&p, x, y + h), go(&p, x, y), go(&p, x + w, y), blow(m, &p, radius);
        go(&p, x, y + half), go(&p, x + 0.8 * w, y + half), blow(m, &p, radius);
        break;
    default: go(&p, x, y + h), go(&p, x, y), go(&p, x + w, y), blow(m, &p, radius); break; /* L */
    }
    return w;
}

/* A dark plate behind a sign, and the arm that holds it, which goes off to `side`. */
static void plate(mesh *m, double x0, double y0, double x1, double y1, double side)
{
    use_material(m, "plate");
    add_block(m, v3(x0, y0, -0.10), v3(x1, y1, -0.05), 1);
    const double to = side > 0 ? x1 : x0;
    for (int i = 0; i < 2; i++) {
        const double y = y0 + (y1 - y0) * (i ? 0.85 : 0.15);
        add_block(m, v3(fmin(to, to + side), y - 0.02, -0.095), v3(fmax(to, to + side), y + 0.02, -0.055), 1);
    }
}

/* ---- meshes ---- */

static void sign_bar(mesh *m)
{
    double x = -0.72;
    plate(m, -0.88, -0.42, 0.88, 0.42, -0.7);
    use_material(m, "rose");
    for (const char *c = "BAR"; *c; c++) x += letter(m, *c, x, -0.26, 0.52, 0.026) + 0.21;
}

/* A frame of another colour around the word above. */
static void sign_bar_frame(mesh *m)
{
    pen p = {.count = 0};
    use_material(m, "blue");
    bend(&p, 0.72, 0.26, 0.11, 0.11, 0.25, 0), bend(&p, 0.72, -0.26, 0.11, 0.11, 0, -0.25);
    bend(&p, -0.72, -0.26, 0.11, 0.11, -0.25, -0.5), bend(&p, -0.72, 0.26, 0.11, 0.11, 0.5, 0.25);
    go(&p, 0.72, 0.37);
    blow(m, &p, 0.014);
}

/* A cocktail glass with an olive and a straw. */
static void sign_glass(mesh *m)
{
    pen p = {.count = 0};
    plate(m, -0.5, -0.75, 0.5, 0.75, 0.6);
    use_material(m, "sea");
    go(&p, -0.38, 0.42), go(&p, 0.38, 0.42), go(&p, 0, -0.05), go(&p, -0.38, 0.42), blow(m, &p, 0.02);
    go(&p, 0, -0.05), go(&p, 0, -0.52), blow(m, &p, 0.02);
    go(&p, -0.24, -0.55), go(&p, 0.24, -0.55), blow(m, &p, 0.02);
    use_material(m, "rose");
    go(&p, -0.24, 0.3), go(&p, 0.24, 0.3), blow(m, &p, 0.014);
    go(&p, 0.05, 0.1), go(&p, 0.3, 0.64), blow(m, &p, 0.014);
    use_material(m, "lime");
    bend(&p, -0.12, 0.22, 0.05, 0.05, 0, 1), blow(m, &p, 0.012);
}

static void sign_hotel(mesh *m)
{
    static const char word[] = "HOTEL";
    plate(m, -0.34, -1.62, 0.34, 1.62, 0.6);
    use_material(m, "amber");
    for (int i = 0; i < 5; i++) letter(m, word[i], -0.146, 1.0 - 0.62 * i, 0.44, 0.02);
    pen p = {.count = 0};
    use_material(m, "ember");
    go(&p, -0.27, -1.55), go(&p, 0.27, -1.55), go(&p, 0.27, 1.55), go(&p, -0.27, 1.55), go(&p, -0.27, -1.55);
    blow(m, &p, 0.014);
}

/* 0.84 by 1.36 m, as the facades' openings are, a little before them. */
static void window_lit(mesh *m)
{
    use_material(m, "window");
    add_panel(m, (const vec[]){v3(-0.42, -0.68, 0), v3(0.42, -0.68, 0), v3(0.42, 0.68, 0), v3(-0.42, 0.68, 0)}, 0, 0, 1,
              1);
}

static void machine(mesh *m)
{
    use_material(m, "case");
    add_block(m, v3(-0.5, 0, -0.38), v3(0.5, 1.85, 0.36), 1);
    use_material(m, "front");
    add_panel(m,
              (const vec[]){v3(-0.46, 0.08, 0.37), v3(0.46, 0.08, 0.37), v3(0.46, 1.81, 0.37), v3(-0.46, 1.81, 0.37)},
              0, 0, 1, 1);
}

/* An arm of iron from a wall at z = 0, for a ball of 0.16 m at 0, -0.2, 0.55. */
static void arm(mesh *m)
{
    static const double cap[][2] = {{0.13, -0.09}, {0.05, 0.03}, {0.02, 0.10}, {0, 0.10}};
    use_material(m, "iron");
    m->move = v3(0, 0, 0.55);
    add_lathe(m, cap, 4, 10, 0);
    m->move = v3(0, 0, 0);
    add_block(m, v3(-0.02, 0.08, 0), v3(0.02, 0.12, 0.56), 1);
    add_block(m, v3(-0.05, -0.08, 0), v3(0.05, 0.2, 0.03), 1);
}

/* A shop's, of two. */
static void shop_lit(mesh *m)
{
    use_material(m, "window");
    add_panel(m, (const vec[]){v3(-0.93, -0.68, 0), v3(0.93, -0.68, 0), v3(0.93, 0.68, 0), v3(-0.93, 0.68, 0)}, 0, 0, 2,
              1);
}

/* 60 m along the lane, 24 across; a repeat of the stones is 3 m. */
static void lane(mesh *m)
{
    use_material(m, "stones");
    for (int i = -2; i < 2; i++)
        for (int k = 0; k < 10; k++) {
            const double x = 6.0 * i, z = 8 - 6.0 * k;
            add_panel(m, (const vec[]){v3(x, 0, z), v3(x + 6, 0, z), v3(x + 6, 0, z - 6), v3(x, 0, z - 6)}, 0, 0, 2, 2);
        }
}

/* ---- materials ---- */

#define GLOWS(name, light) "newmtl " name "\nKa 0 0 0\nKd 0.02 0.02 0.02\nKs 0 0 0\nKe " light "\nillum 1\n\n"
#define SHOWS(name, light, file)                                                                                       \
    "newmtl " name "\nKa 0 0 0\nKd 0.02 0.02 0.02\nKs 0 0 0\nKe " light "\nmap_Ke ../../textures/neon/" file           \
    "\nillum 1\n\n"
#define PAINT(name, tint, rough) "newmtl " name "\nKa " tint "\nKd " tint "\nPr " rough "\nPm 0\n\n"

#define PLATE "newmtl plate\nKa 0.004 0.004 0.005\nKd 0.004 0.004 0.005\nKs 0 0 0\nillum 1\n\n"
#define STONES                                                                                                         \
    "newmtl stones\nKa 0.42 0.42 0.44\nKd 0.42 0.42 0.44\nPr 1\nPm 0\nmap_Kd ../../textures/cobble.jpg\n"              \
    "map_Pr ../../textures/neon/wet.jpg\nbump -bm 3 ../../textures/neon/wet_height.png\n"

static const char materials[] =
    "# made by daft_generate, CC0\n" GLOWS("rose", "13 0.5 2.8") GLOWS("blue", "0.4 1.8 10") GLOWS("sea", "0.2 13 11")
        GLOWS("lime", "3 9 0.4") GLOWS("amber", "15 5 0.4") GLOWS("ember", "10 0.9 0.2") GLOWS("globe", "6 4 1.8")
            SHOWS("window", "1.6 1.2 0.8", "window.jpg") SHOWS("front", "1.2 1.2 1.2", "machine.jpg")
                PLATE PAINT("case", "0.34 0.05 0.07", "0.35") PAINT("iron", "0.03 0.03 0.033", "0.5") STONES;

bool generate_neon(const char *root)
{
    static const mesh_recipe list[] = {
        {"assets/meshes/neon/bar.obj", sign_bar},      {"assets/meshes/neon/bar_frame.obj", sign_bar_frame},
        {"assets/meshes/neon/glass.obj", sign_glass},  {"assets/meshes/neon/hotel.obj", sign_hotel},
        {"assets/meshes/neon/window.obj", window_lit}, {"assets/meshes/neon/machine.obj", machine},
        {"assets/meshes/neon/arm.obj", arm},           {"assets/meshes/neon/shop.obj", shop_lit},
        {"assets/meshes/neon/lane.obj", lane},
    };
    return paint_square(root, "assets/textures/neon/wet.jpg", 512, wet_roughness) &&
           paint_square(root, "assets/textures/neon/wet_height.png", 512, wet_height) &&
           paint_square(root, "assets/textures/neon/window.jpg", 256, lit_window) &&
           paint_square(root, "assets/textures/neon/machine.jpg", 256, machine_front) &&
           write_text(root, "assets/meshes/neon/neon.mtl", materials) &&
           write_meshes(root, list, sizeof list / sizeof list[0], "neon.mtl");
}
