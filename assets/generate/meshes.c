/* assets/meshes: things to collect, goals, and what makes a place: trees, rocks, columns, flags, a floating island. */
#include "mesh.h"

#include <math.h>

static const double TAU = 6.283185307179586;

/* A cut stone: a flat table, a crown of triangles down to the girdle, a point below. 0.35 wide to each side. */
static void gem(mesh *m)
{
    enum { N = 8 };
    vec table[N], girdle[N], culet = v3(0, -0.42, 0);
    for (int i = 0; i < N; i++) {
        double a = -TAU * i / N, b = -TAU * (i + 0.5) / N;
        table[i] = v3(0.20 * cos(a), 0.24, 0.20 * sin(a)), girdle[i] = v3(0.35 * cos(b), 0.10, 0.35 * sin(b));
    }
    use_material(m, "gem");
    add_flat(m, table, N);
    for (int i = 0; i < N; i++) {
        int j = (i + 1) % N;
        add_flat(m, (const vec[]){table[i], girdle[i], table[j]}, 3);
        add_flat(m, (const vec[]){girdle[i], girdle[j], table[j]}, 3);
        add_flat(m, (const vec[]){girdle[i], culet, girdle[j]}, 3);
    }
}

/* Five points, one side of it: a ridge from the middle to each point. `side` 1 faces +Z, -1 faces -Z. */
static void star_side(mesh *m, double outer, double inner, double base, double height, double side)
{
    for (int i = 0; i < 10; i++) {
        double a = TAU * (0.25 + i / 10.0), b = TAU * (0.25 + (i + 1) / 10.0);
        double ra = i % 2 ? inner : outer, rb = i % 2 ? outer : inner;
        vec p = v3(ra * cos(a), ra * sin(a), side * base), q = v3(rb * cos(b), rb * sin(b), side * base);
        vec top = v3(0, 0, side * (base + height));
        if (side > 0)
            add_flat(m, (const vec[]){p, q, top}, 3);
        else
            add_flat(m, (const vec[]){q, p, top}, 3);
    }
}

static void star(mesh *m)
{
    use_material(m, "gold");
    star_side(m, 0.40, 0.17, 0, 0.13, 1);
    star_side(m, 0.40, 0.17, 0, 0.13, -1);
}

/* Turns what a lathe made from standing on Y to facing Z. */
static void tip_over(mesh *m)
{
    for (int i = 0; i < m->corner_count; i++) {
        corner *c = &m->corners[i];
        c->at = v3(c->at.x, -c->at.z, c->at.y), c->normal = v3(c->normal.x, -c->normal.z, c->normal.y);
    }
}

static void coin(mesh *m)
{
    static const double rim[][2] = {{0, -0.025},    {0.26, -0.025}, {0.26, -0.025}, {0.28, -0.045}, {0.28, -0.045},
                                    {0.33, -0.045}, {0.35, -0.025}, {0.35, 0.025},  {0.33, 0.045},  {0.28, 0.045},
                                    {0.28, 0.045},  {0.26, 0.025},  {0.26, 0.025},  {0, 0.025}};
    use_material(m, "gold");
    add_lathe(m, rim, 14, 32, 0);
    tip_over(m);
    star_side(m, 0.21, 0.085, 0.025, 0.03, 1);
    star_side(m, 0.21, 0.085, 0.025, 0.03, -1);
}

/* A ring to pass through, about the Z axis, with its middle at the origin. */
static void ring(mesh *m)
{
    use_material(m, "gold");
    add_torus(m, v3(0, 0, 0), 1.4, 0.14, 40, 12, 0, TAU);
}

static void cup(mesh *m)
{
    static const double profile[][2] = {{0, 0},       {0.26, 0},     {0.26, 0},    {0.27, 0.05}, {0.22, 0.09},
                                        {0.08, 0.14}, {0.055, 0.22}, {0.06, 0.30}, {0.12, 0.36}, {0.24, 0.44},
                                        {0.31, 0.58}, {0.34, 0.76},  {0.36, 0.80}, {0.36, 0.80}, {0.33, 0.80},
                                        {0.33, 0.80}, {0.28, 0.58},  {0.20, 0.47}, {0, 0.44}};
    use_material(m, "gold");
    add_lathe(m, profile, 19, 28, 0);
    add_torus(m, v3(-0.355, 0.62, 0), 0.13, 0.028, 12, 8, TAU * 0.22, TAU * 0.88);
    add_torus(m, v3(0.355, 0.62, 0), 0.13, 0.028, 12, 8, -TAU * 0.38, TAU * 0.28);
}

/* A wine glass with walls, closed: up the outer side, over the lip, and down the inner one. 0.31 wide to each
 * side, 1.12 high. */
static void goblet(mesh *m)
{
    static const double profile[][2] = {{0, 0},        {0.30, 0},     {0.30, 0},     {0.312, 0.012}, {0.27, 0.03},
                                        {0.12, 0.055}, {0.05, 0.10},  {0.034, 0.20}, {0.034, 0.40},  {0.06, 0.485},
                                        {0.15, 0.545}, {0.235, 0.63}, {0.288, 0.74}, {0.305, 0.86},  {0.298, 1.0},
                                        {0.28, 1.11},  {0.272, 1.12}, {0.264, 1.11}, {0.281, 1.0},   {0.287, 0.86},
                                        {0.27, 0.75},  {0.22, 0.65},  {0.14, 0.575}, {0.06, 0.545},  {0, 0.54}};
    use_material(m, "glass");
    add_lathe(m, profile, 25, 40, 0);
}

/* Three sides, of 0.7, and 1.2 long, lying on one. */
static void prism(mesh *m)
{
    const double half = 0.6, side = 0.7, high = 0.606217783;
    const vec left[3] = {v3(-half, 0, side / 2), v3(-half, 0, -side / 2), v3(-half, high, 0)};
    const vec right[3] = {v3(half, 0, side / 2), v3(half, 0, -side / 2), v3(half, high, 0)};
    use_material(m, "glass");
    add_flat(m, (const vec[]){left[0], left[2], left[1]}, 3);
    add_flat(m, (const vec[]){right[0], right[1], right[2]}, 3);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        add_flat(m, (const vec[]){left[i], left[j], right[j], right[i]}, 4);
    }
}

static void trunk(mesh *m, double height)
{
    vec low[7], high[7];
    for (int i = 0; i < 7; i++) {
        double a = -TAU * i / 7, r = 0.15 + 0.03 * hash01(i, 0, 71);
        low[i] = v3(r * cos(a), 0, r * sin(a)), high[i] = v3(0.6 * r * cos(a), height, 0.6 * r * sin(a));
    }
    use_material(m, "bark");
    for (int i = 0; i < 7; i++) {
        int j = (i + 1) % 7;
        add_flat(m, (const vec[]){low[i], low[j], high[j], high[i]}, 4);
    }
}

static void pine(mesh *m)
{
    trunk(m, 0.8);
    for (int layer = 0; layer < 4; layer++) {
        enum { N = 9 };
        double base = 0.55 + 0.5 * layer, radius = 0.85 - 0.17 * layer, tip = base + 0.95 - 0.08 * layer;
        vec brim[N], under = v3(0, base + 0.12, 0);
        for (int i = 0; i < N; i++) {
            double a = -TAU * (i + 0.5 * (layer % 2)) / N, r = radius * (0.92 + 0.16 * hash01(i, layer, 72));
            brim[i] = v3(r * cos(a), base + 0.08 * (hash01(i, layer, 73) - 0.5), r * sin(a));
        }
        use_material(m, layer % 2 ? "leaf" : "leaf_dark");
        for (int i = 0; i < N; i++) {
            int j = (i + 1) % N;
            add_flat(m, (const vec[]){brim[i], brim[j], v3(0, tip, 0)}, 3);
            add_flat(m, (const vec[]){brim[j], brim[i], under}, 3);
        }
    }
}

static void tree(mesh *m)
{
    trunk(m, 1.3);
    use_material(m, "leaf");
    add_blob(m, v3(0.05, 1.75, 0), v3(0.78, 0.70, 0.78), 1, 0.5, 81);
    use_material(m, "leaf_dark");
    add_blob(m, v3(-0.42, 1.40, 0.25), v3(0.48, 0.42, 0.48), 1, 0.5, 82);
    add_blob(m, v3(0.40, 1.42, -0.32), v3(0.45, 0.40, 0.45), 1, 0.5, 83);
}

static void rock(mesh *m)
{
    use_material(m, "rock");
    add_blob(m, v3(0, 0.32, 0), v3(0.60, 0.45, 0.50), 2, 0.75, 91);
}

/* A Doric column, 3 m high, of the marble texture. */
static void column(mesh *m)
{
    static const double profile[][2] = {
        {0.44, 0},    {0.44, 0.14}, {0.44, 0.14}, {0.40, 0.14}, {0.40, 0.14}, {0.425, 0.18}, {0.42, 0.24},
        {0.36, 0.28}, {0.32, 0.31}, {0.325, 0.9}, {0.315, 1.6}, {0.285, 2.5}, {0.28, 2.62},  {0.28, 2.62},
        {0.31, 2.64}, {0.31, 2.68}, {0.29, 2.70}, {0.29, 2.70}, {0.38, 2.82}, {0.42, 2.86},  {0.42, 2.86},
        {0.46, 2.86}, {0.46, 2.86}, {0.46, 3.0},  {0.46, 3.0},  {0, 3.0}};
    use_material(m, "marble");
    add_lathe(m, profile, 26, 20, 2);
}

/* The cloth's middle at u, v in 0..1: it hangs on the pole at u = 0 and waves more the further out. */
static vec cloth(double u, double v, double side)
{
    double wave = 0.16 * u * sin(7 * u + 1.5 * v), slope = 0.16 * (sin(7 * u + 1.5 * v) + 7 * u * cos(7 * u + 1.5 * v));
    vec n = normal_of(v3(-slope, 0, 1));
    return add(v3(0.05 + 1.1 * u, 1.85 + 0.7 * v - 0.12 * u, wave), times(n, 0.008 * side));
}

static void flag(mesh *m)
{
    static const double pole[][2] = {{0.04, 0},     {0.035, 2.6}, {0.035, 2.6}, {0.07, 2.62},
                                     {0.085, 2.69}, {0.06, 2.75}, {0, 2.78}};
    enum { NU = 12, NV = 4 };
    use_material(m, "silver");
    add_lathe(m, pole, 7, 12, 0);
    use_material(m, "cloth");
    for (int i = 0; i < NU; i++) {
        for (int k = 0; k < NV; k++) {
            double u = (double)i / NU, v = (double)k / NV, s = 1.0 / NU, t = 1.0 / NV;
            add_flat(m, (const vec[]){cloth(u, v, 1), cloth(u + s, v, 1), cloth(u + s, v + t, 1), cloth(u, v + t, 1)},
                     4);
            add_flat(m,
                     (const vec[]){cloth(u, v, -1), cloth(u, v + t, -1), cloth(u + s, v + t, -1), cloth(u + s, v, -1)},
                     4);
        }
    }
}

static vec island_point(double turn, double depth)
{
    double a = -TAU * turn, x = cos(a), z = sin(a);
    double ragged = 1 + 0.35 * fractal3(x * 1.5, depth * 2, z * 1.5, 3, 101);
    double r = (depth <= 0 ? 1 : 0.95 * pow(1 - depth, 0.65)) * ragged * 3;
    double drop = depth <= 0 ? 0 : -3.4 * depth * (1 + 0.25 * fractal3(x * 2, depth, z * 2, 2, 103));
    return v3(r * x, drop, r * z);
}

/* A floating island, 6 m across: grass on top at y = 0, rock that thins out below. */
static void island(mesh *m)
{
    enum { N = 18, LAYERS = 6 };
    use_material(m, "rock");
    for (int k = 0; k < LAYERS; k++) {
        for (int i = 0; i < N; i++) {
            double a = (double)i / N, b = (double)((i + 1) % N) / N;
            double low = (k + 1.0) / LAYERS, high = (double)k / LAYERS;
            vec p = island_point(a, low), q = island_point(b, low), r = island_point(b, high),
                s = island_point(a, high);
            if (k == LAYERS - 1) p = v3(0, -3.4, 0);
            if (k < LAYERS - 1) add_flat(m, (const vec[]){p, q, r}, 3);
            add_flat(m, (const vec[]){p, r, s}, 3);
        }
    }
    use_material(m, "grass");
    corner top[N];
    for (int i = 0; i < N; i++) {
        vec p = island_point((double)i / N, 0);
        top[i] = (corner){p, v3(0, 1, 0), p.x / 2, -p.z / 2};
    }
    add_face(m, top, N, true);
}

/* A floor, 8 m square and 0.4 thick, its top at y = 0, with a border of wood. */
static void slab(mesh *m)
{
    const double r = 4, low = -0.4;
    const vec side[4] = {v3(-r, 0, r), v3(r, 0, r), v3(r, 0, -r), v3(-r, 0, -r)};
    corner top[4];
    for (int i = 0; i < 4; i++) top[i] = (corner){side[i], v3(0, 1, 0), side[i].x / 4, -side[i].z / 4};
    use_material(m, "checker");
    add_face(m, top, 4, true);
    use_material(m, "wood");
    for (int i = 0; i < 4; i++) {
        vec p = side[i], q = side[(i + 1) % 4], down = v3(0, low, 0), n = normal_of(add(p, q));
        corner c[4] = {{add(p, down), n, 0, 0}, {add(q, down), n, 4, 0}, {q, n, 4, 0.2}, {p, n, 0, 0.2}};
        add_face(m, c, 4, true);
    }
    for (int i = 0; i < 4; i++) top[i] = (corner){add(side[3 - i], v3(0, low, 0)), v3(0, -1, 0), 0, 0};
    add_face(m, top, 4, true);
}

/* What glows where a rectangle of light is: 1 by 2, facing down. */
static void panel(mesh *m)
{
    use_material(m, "silver");
    add_flat(m, (const vec[]){v3(-0.5, 0, -1), v3(0.5, 0, -1), v3(0.5, 0, 1), v3(-0.5, 0, 1)}, 4);
}

static const char materials[] =
    "# made by daft_generate, CC0\n"
    "newmtl gold\nKa 0.75 0.55 0.15\nKd 0.62 0.42 0.08\nKs 0.45 0.36 0.16\nNs 120\nillum 3\n\n"
    "newmtl silver\nKa 0.6 0.6 0.62\nKd 0.45 0.46 0.48\nKs 0.4 0.4 0.42\nNs 150\nillum 3\n\n"
    "newmtl gem\nKa 0.1 0.75 0.8\nKd 0.08 0.62 0.70\nKs 0.35 0.4 0.4\nNs 200\nillum 3\n\n"
    "newmtl leaf\nKa 0.24 0.54 0.13\nKd 0.24 0.54 0.13\nKs 0 0 0\nNs 1\nillum 1\n\n"
    "newmtl leaf_dark\nKa 0.13 0.42 0.16\nKd 0.13 0.42 0.16\nKs 0 0 0\nNs 1\nillum 1\n\n"
    "newmtl bark\nKa 0.40 0.27 0.17\nKd 0.40 0.27 0.17\nKs 0 0 0\nNs 1\nillum 1\n\n"
    "newmtl rock\nKa 0.48 0.46 0.44\nKd 0.48 0.46 0.44\nKs 0.03 0.03 0.03\nNs 10\nillum 2\n\n"
    "newmtl grass\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nNs 1\nillum 1\nmap_Kd ../textures/grass.png\n\n"
    "newmtl marble\nKa 1 1 1\nKd 1 1 1\nKs 0.15 0.15 0.15\nNs 60\nillum 2\nmap_Kd ../textures/marble.png\n\n"
    "newmtl checker\nKa 1 1 1\nKd 1 1 1\nKs 0.12 0.12 0.12\nNs 40\nillum 2\nmap_Kd ../textures/checker.png\n\n"
    "newmtl wood\nKa 1 1 1\nKd 1 1 1\nKs 0.05 0.05 0.05\nNs 20\nillum 2\nmap_Kd ../textures/wood.png\n\n"
    "newmtl chrome\nKa 0.02 0.02 0.02\nKd 0.04 0.04 0.05\nKs 0.88 0.89 0.92\nNs 400\nillum 3\n\n"
    "newmtl ruby\nKa 0.6 0.04 0.08\nKd 0.6 0.04 0.08\nKs 0.25 0.2 0.2\nNs 200\nillum 3\n\n"
    "newmtl jade\nKa 0.1 0.5 0.3\nKd 0.1 0.5 0.3\nKs 0.2 0.25 0.2\nNs 150\nillum 3\n\n"
    "newmtl glass\nKa 0 0 0\nKd 0 0 0\nKs 0.6 0.6 0.6\nNs 600\nNi 1.5\nillum 7\n\n"
    "newmtl bottle\nKa 0 0 0\nKd 0 0 0\nKs 0.6 0.6 0.6\nNs 600\nNi 1.5\nTf 0.55 0.92 0.62\nillum 7\n\n"
    "newmtl amber\nKa 0 0 0\nKd 0 0 0\nKs 0.6 0.6 0.6\nNs 400\nNi 1.54\nTf 0.98 0.72 0.3\nillum 7\n\n"
    "newmtl water\nKa 0 0 0\nKd 0 0 0\nKs 0.5 0.5 0.5\nNs 600\nNi 1.33\nTf 0.88 0.96 1\nillum 7\n\n"
    "newmtl veil\nKa 0.9 0.3 0.35\nKd 0.9 0.3 0.35\nKs 0 0 0\nNs 1\nd 0.4\nillum 1\n\n"
    "newmtl cloth\nKa 0.9 0.10 0.08\nKd 0.9 0.10 0.08\nKs 0 0 0\nNs 1\nillum 1\n";

bool generate_meshes(const char *root)
{
    static const mesh_recipe list[] = {
        {"assets/meshes/gem.obj", gem},       {"assets/meshes/star.obj", star},
        {"assets/meshes/coin.obj", coin},     {"assets/meshes/ring.obj", ring},
        {"assets/meshes/cup.obj", cup},       {"assets/meshes/pine.obj", pine},
        {"assets/meshes/tree.obj", tree},     {"assets/meshes/rock.obj", rock},
        {"assets/meshes/column.obj", column}, {"assets/meshes/flag.obj", flag},
        {"assets/meshes/island.obj", island}, {"assets/meshes/slab.obj", slab},
        {"assets/meshes/goblet.obj", goblet}, {"assets/meshes/prism.obj", prism},
        {"assets/meshes/panel.obj", panel},
    };
    return write_text(root, "assets/meshes/meshes.mtl", materials) &&
           write_meshes(root, list, sizeof list / sizeof list[0], NULL);
}
