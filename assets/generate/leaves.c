/* The scene `leaves`: trees and a hedge of leaf cards, each a square with a twig on it whose alpha is cut out (map_d),
 * so that a few hundred squares are some thousand leaves, and so are their shadows. */
#include "mesh.h"

#include <math.h>

static const double TAU = 6.283185307179586;

/* ---- the twig ---- */

typedef struct leaf {
    double x, y, angle, size;
} leaf;

enum { LEAVES = 11 };

/* Two rows along the stem, shorter towards the tip, and one at its end. */
static leaf leaf_of(int i)
{
    const double t = 0.14 + 0.072 * i, side = i % 2 ? 1 : -1;
    const double turn = side * (0.95 - 0.045 * i + 0.18 * (hash01(i, 0, 901) - 0.5));
    if (i == LEAVES - 1) return (leaf){0.5, 0.74, 0.06, 0.25};
    return (leaf){0.5 + 0.012 * side, t - 0.1, turn, 0.37 - 0.013 * i + 0.04 * hash01(i, 1, 901)};
}

/* Whether a leaf covers the place; where on it: along its middle 0..1, across -1..1. */
static bool on_leaf(const leaf *l, double u, double v, double *along, double *across)
{
    const double x = u - l->x, y = v - l->y;
    const double a = (x * sin(l->angle) + y * cos(l->angle)) / l->size,
                 b = (x * cos(l->angle) - y * sin(l->angle)) / l->size;
    if (a < 0 || a > 1) return false;
    const double bend = b + 0.06 * sin(3 * a), tooth = 0.012 * fabs(sin(a * 26));
    const double half = 0.30 * pow(sin(M_PI * pow(a, 0.82)), 0.85) * (1 - 0.12 * a) + 0.006 - tooth;
    *along = a, *across = half > 0 ? bend / half : 2;
    return fabs(*across) < 1;
}

static bool on_stem(double u, double v) { return v < 0.78 && fabs(u - 0.5) < 0.009 * (1.3 - v); }

static color leaf_color(int i, double along, double across)
{
    const double old = hash01(i, 2, 903), side = 0.5 + 0.5 * sin((along - 0.25 * fabs(across)) * 44);
    color c = mix(rgb(0x4f7f2c), rgb(0xa3b94c), 0.25 + 0.6 * old);
    c = shade(c, 0.86 + 0.10 * side + 0.10 * across);
    return mix(rgb(0xcfe08a), c, smoothstep(0.02, 0.12, fabs(across)) * (0.75 + 0.25 * along));
}

/* The twig's colour, which goes on around it: filters mix what lies behind the outline into it. */
static color twig(double u, double v)
{
    double along, across;
    for (int i = LEAVES - 1; i >= 0; i--) {
        const leaf l = leaf_of(i);
        if (on_leaf(&l, u, v, &along, &across)) return leaf_color(i, along, across);
    }
    return on_stem(u, v) ? rgb(0x6d7a3a) : rgb(0x6fa03a);
}

static color twig_alpha(double u, double v)
{
    double along, across;
    bool there = on_stem(u, v);
    for (int i = 0; i < LEAVES && !there; i++) {
        const leaf l = leaf_of(i);
        there = on_leaf(&l, u, v, &along, &across);
    }
    return there ? (color){1, 1, 1} : (color){0, 0, 0};
}

/* ---- trees and the hedge ---- */

/* A square that grows from `base` along `out`; its light is the crown's, towards `away`. */
static void add_card(mesh *m, vec base, vec out, vec away, double size, double turn)
{
    const vec flat = normal_of(cross(out, add(away, v3(0.013, 0.7, 0.007)))), up = normal_of(cross(flat, out));
    const vec side = normal_of(add(times(flat, cos(turn)), times(up, sin(turn))));
    vec n = normal_of(cross(side, out));
    const double facing = n.x * away.x + n.y * away.y + n.z * away.z;
    if (facing < 0) n = times(n, -1);
    const vec normal = normal_of(add(times(n, 0.6), away)), half = times(side, 0.5 * size), far = times(out, size);
    const corner c[4] = {{sub(base, half), normal, 0, 0},
                         {add(base, half), normal, 1, 0},
                         {add(add(base, half), far), normal, 1, 1},
                         {add(sub(base, half), far), normal, 0, 1}};
    add_face(m, c, 4, true);
}

/* Cards all over an ellipsoid, most of them near its outside, the inner ones darker; they hang a little. */
static void add_cards(mesh *m, vec center, vec radius, int count, double size, int seed)
{
    for (int i = 0; i < count; i++) {
        const vec d = random_direction(i, seed);
        const double r = 0.35 + 0.5 * sqrt(hash01(i, 3, seed));
        use_material(m, r < 0.66 ? "twig_dark" : "twig");
        const vec base = add(center, v3(r * d.x * radius.x, r * d.y * radius.y, r * d.z * radius.z));
        const vec out = normal_of(add(add(d, v3(0, -0.25, 0)), times(random_direction(i, seed + 1), 0.6)));
        add_card(m, base, out, normal_of(add(d, v3(0, 0.35, 0))), size * (0.75 + 0.5 * hash01(i, 4, seed)),
                 TAU * hash01(i, 5, seed));
    }
}

/* A trunk, limbs, and a crown on each limb and on top. */
static void tree_of(mesh *m, int limbs, double tall, double wide, int seed)
{
    enum { RINGS = 7 };
    vec spine[RINGS];
    double radii[RINGS];
    for (int i = 0; i < RINGS; i++) {
        const double t = i / (RINGS - 1.0);
        spine[i] = v3(0.5 * (hash01(0, 0, seed) - 0.5) * t * t + 0.10 * noise(t * 3, 0.5, 64, seed), tall * t - 0.1,
                      0.12 * noise(t * 3, 7.5, 64, seed + 1));
        radii[i] = 0.25 * (1 - 0.72 * t) + 0.14 * pow(1 - t, 6);
    }
    use_material(m, "bark");
    add_tube(m, spine, radii, RINGS, 11, 1.4);
    for (int i = 0; i < limbs; i++) {
        const double a = TAU * (0.381966 * i + 0.06 * hash01(i, 1, seed)), rise = 0.45 + 0.5 * i / limbs,
                     reach = wide * (1.1 - 0.45 * i / limbs) * (0.85 + 0.3 * hash01(i, 2, seed));
        const vec from = spine[2 + (int)(rise * 4)],
                  tip = add(from, v3(reach * cos(a), 0.5 + 0.7 * hash01(i, 3, seed), reach * sin(a)));
        const vec middle = add(times(add(from, tip), 0.5), v3(0, -0.14, 0));
        use_material(m, "bark");
        add_tube(m, (const vec[]){from, middle, tip}, (const double[]){0.085 + 0.002 * i, 0.06, 0.02}, 3, 6, 1.4);
        add_cards(m, tip, v3(1.15, 0.75, 1.15), 62, 0.42, seed + 20 + 3 * i);
        add_cards(m, middle, v3(0.85, 0.5, 0.85), 16, 0.40, seed + 120 + 3 * i);
    }
    add_cards(m, add(spine[RINGS - 1], v3(0, 0.5, 0)), v3(1.3, 0.95, 1.3), 74, 0.42, seed + 11);
}

static void tree(mesh *m) { tree_of(m, 9, 4.6, 1.9, 910); }
static void tree_slim(mesh *m) { tree_of(m, 6, 4.0, 1.35, 940); }

/* A metre and a half of it. */
static void hedge(mesh *m)
{
    enum { CARDS = 300 };
    use_material(m, "bark");
    for (int i = 0; i < 3; i++) {
        const double x = -0.5 + 0.5 * i + 0.1 * hash01(i, 0, 961);
        add_tube(m, (const vec[]){v3(x, -0.1, 0), v3(x + 0.1, 0.9, 0.05)}, (const double[]){0.05 + 0.001 * i, 0.02}, 2,
                 6, 1);
    }
    use_material(m, "twig_dark");
    for (int i = 0; i < CARDS; i++) {
        const double x = 1.5 * (hash01(i, 1, 961) - 0.5), y = 1.25 * hash01(i, 2, 961),
                     z = 0.8 * (hash01(i, 3, 961) - 0.5);
        const vec away = normal_of(v3(0.2 * x, 1.2 * pow(y / 1.2, 3), 2.2 * z));
        const vec out = normal_of(add(add(away, v3(0, 0.35, 0)), times(random_direction(i, 963), 0.55)));
        add_card(m, v3(x, y, z), out, away, 0.27 * (0.8 + 0.4 * hash01(i, 4, 961)), TAU * hash01(i, 5, 961));
    }
}

/* ---- the walk ---- */

/* Panels of the ground between two z, from x = -10 to 32; one repeat of the texture in `tile` metres. */
static void add_strip(mesh *m, double z0, double z1, double tile)
{
    enum { PANELS = 6 };
    for (int i = 0; i < PANELS; i++) {
        const double x = -10 + 7.0 * i;
        add_panel(m, (const vec[]){v3(x, 0, z1), v3(x + 7, 0, z1), v3(x + 7, 0, z0), v3(x, 0, z0)}, x / tile,
                  -z1 / tile, (x + 7) / tile, -z0 / tile);
    }
}

/* A paved walk between kerbs, lawns beside it, and a wall across its end. */
static void walk(mesh *m)
{
    use_material(m, "cobble");
    add_strip(m, -2.1, 2.1, 2.1);
    use_material(m, "grass");
    add_strip(m, -22, -2.1, 3), add_strip(m, 2.1, 22, 3);
    use_material(m, "coping");
    for (int i = 0; i < 2; i++) {
        const double z = i ? 2.1 : -2.28;
        add_box(m, v3(-10, -0.05, z), v3(28.6, 0.09, z + 0.18), 1);
    }
    use_material(m, "wall");
    m->move = v3(28.6, 0, 0);
    add_box(m, v3(0, -0.1, -22), v3(0.4, 3.0, 22), 2);
    use_material(m, "coping");
    add_box(m, v3(-0.08, 3.0, -22), v3(0.48, 3.16, 22), 1.5);
    m->move = v3(0, 0, 0);
}

/* Its back to +X. */
static void bench(mesh *m)
{
    use_material(m, "wood");
    for (int i = 0; i < 4; i++) add_box(m, v3(-0.24 + 0.13 * i, 0.42, -0.9), v3(-0.13 + 0.13 * i, 0.46, 0.9), 0.9);
    for (int i = 0; i < 3; i++) add_box(m, v3(0.28, 0.56 + 0.13 * i, -0.9), v3(0.32, 0.66 + 0.13 * i, 0.9), 0.9);
    use_material(m, "coping");
    for (int i = 0; i < 2; i++) {
        const double z = i ? 0.66 : -0.78;
        add_box(m, v3(-0.2, 0, z), v3(0.3, 0.42, z + 0.12), 0.6);
        add_box(m, v3(0.32, 0, z), v3(0.38, 0.92, z + 0.12), 0.6);
    }
}

static const char LIBRARY[] =
    "# made by daft_generate, CC0\n"
    "newmtl bark\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/bark.jpg\n\n"
    "newmtl twig\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd -clamp on ../../textures/twig.jpg\n"
    "map_d -clamp on ../../textures/twig_alpha.png\n\n"
    "newmtl twig_dark\nKa 0.62 0.72 0.6\nKd 0.62 0.72 0.6\nKs 0 0 0\nillum 1\n"
    "map_Kd -clamp on ../../textures/twig.jpg\nmap_d -clamp on ../../textures/twig_alpha.png\n\n"
    "newmtl cobble\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/cobble.jpg\n\n"
    "newmtl grass\nKa 0.8 0.5 0.62\nKd 0.8 0.5 0.62\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/grass.png\n\n"
    "newmtl wall\nKa 0.78 0.8 0.76\nKd 0.78 0.8 0.76\nKs 0 0 0\nillum 1\n"
    "map_Kd ../../textures/brick.png\n\n"
    "newmtl coping\nKa 0.9 0.88 0.84\nKd 0.9 0.88 0.84\nKs 0 0 0\nillum 1\n"
    "map_Kd ../../textures/stone.png\n\n"
    "newmtl wood\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/wood.png\n";

bool generate_leaves(const char *root)
{
    static const mesh_recipe list[] = {
        {"assets/meshes/leaves/tree.obj", tree},   {"assets/meshes/leaves/tree_slim.obj", tree_slim},
        {"assets/meshes/leaves/hedge.obj", hedge}, {"assets/meshes/leaves/walk.obj", walk},
        {"assets/meshes/leaves/bench.obj", bench},
    };
    return paint_square(root, "assets/textures/twig.jpg", 256, twig) &&
           paint_square(root, "assets/textures/twig_alpha.png", 256, twig_alpha) &&
           write_text(root, "assets/meshes/leaves/leaves.mtl", LIBRARY) &&
           write_meshes(root, list, sizeof list / sizeof list[0], "leaves.mtl");
}
