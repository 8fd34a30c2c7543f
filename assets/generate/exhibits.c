/* What hangs and stands in the scene `gallery`: frames, lamps, a knot, glass, benches, ropes, palms. */
#include "mesh.h"

#include <math.h>

static const double TAU = 6.283185307179586, LONG = 17.6;

/* ---- what hangs on the walls ---- */

/* Mouldings around w×h metres, mitred: (how far out, how far from the wall) pairs. It faces +Z. */
static void add_frame(mesh *m, double w, double h, const double (*p)[2], int count, const char *const *names)
{
    for (int i = 0; i + 1 < count; i++) {
        use_material(m, names[i]);
        vec a[4], b[4];
        for (int k = 0; k < 4; k++) {
            const double x = k == 1 || k == 2 ? 1 : -1, y = k > 1 ? 1 : -1;
            a[k] = v3(x * (w / 2 + p[i][0]), y * (h / 2 + p[i][0]), p[i][1]);
            b[k] = v3(x * (w / 2 + p[i + 1][0]), y * (h / 2 + p[i + 1][0]), p[i + 1][1]);
        }
        for (int k = 0; k < 4; k++) {
            const int j = (k + 1) % 4;
            add_flat(m, (const vec[]){b[k], b[j], a[j], a[k]}, 4);
        }
    }
}

static void add_canvas(mesh *m, double w, double h, const char *name)
{
    use_material(m, name);
    add_panel(m,
              (const vec[]){v3(-w / 2, -h / 2, 0.02), v3(w / 2, -h / 2, 0.02), v3(w / 2, h / 2, 0.02),
                            v3(-w / 2, h / 2, 0.02)},
              0, 0, 1, 1);
}

static void add_gold_frame(mesh *m, double w, double h, double s)
{
    const double p[][2] = {{0, 0.03},          {0.018 * s, 0.05}, {0.03 * s, 0.045}, {0.06 * s, 0.05},
                           {0.085 * s, 0.085}, {0.11 * s, 0.105}, {0.14 * s, 0.10},  {0.155 * s, 0.075},
                           {0.175 * s, 0.08},  {0.19 * s, 0.06},  {0.20 * s, 0}};
    static const char *const names[] = {"gold", "gold", "gold", "gold", "gold", "gold", "gold", "gold", "gold", "gold"};
    add_frame(m, w, h, p, 11, names);
}

static void add_dark_frame(mesh *m, double w, double h)
{
    static const double p[][2] = {{0, 0.03},    {0.02, 0.045}, {0.03, 0.04}, {0.06, 0.075},
                                  {0.10, 0.08}, {0.13, 0.05},  {0.14, 0}};
    static const char *const names[] = {"gold", "gold", "ebony", "ebony", "ebony", "ebony"};
    add_frame(m, w, h, p, 7, names);
}

static void add_thin_frame(mesh *m, double w, double h, const char *name)
{
    static const double p[][2] = {{0.012, 0.02}, {0.012, 0.06}, {0.035, 0.06}, {0.035, 0}};
    const char *const names[] = {name, name, name};
    use_material(m, "ebony");
    add_facing(m,
               (const vec[]){v3(-w / 2 - 0.02, -h / 2 - 0.02, 0.015), v3(w / 2 + 0.02, -h / 2 - 0.02, 0.015),
                             v3(w / 2 + 0.02, h / 2 + 0.02, 0.015), v3(-w / 2 - 0.02, h / 2 + 0.02, 0.015)},
               v3(0, 0, 9), 0, 0);
    add_frame(m, w, h, p, 4, names);
}

static void valley(mesh *m) { add_canvas(m, 3.9, 2.6, "valley"), add_gold_frame(m, 3.9, 2.6, 1.35); }
static void gale(mesh *m) { add_canvas(m, 2.25, 1.5, "gale"), add_gold_frame(m, 2.25, 1.5, 1); }
static void lady(mesh *m) { add_canvas(m, 1.33, 1.7, "lady"), add_gold_frame(m, 1.33, 1.7, 1); }
static void fruit(mesh *m) { add_canvas(m, 1.75, 1.4, "fruit"), add_dark_frame(m, 1.75, 1.4); }
static void night(mesh *m) { add_canvas(m, 2.21, 1.7, "night"), add_gold_frame(m, 2.21, 1.7, 0.8); }
static void lilies(mesh *m) { add_canvas(m, 3.2, 1.6, "lilies"), add_thin_frame(m, 3.2, 1.6, "oak"); }
static void composition(mesh *m) { add_canvas(m, 1.8, 1.8, "composition"), add_thin_frame(m, 1.8, 1.8, "ebony"); }
static void fields(mesh *m) { add_canvas(m, 1.6, 2.0, "fields"), add_thin_frame(m, 1.6, 2.0, "ebony"); }
static void looking_glass_frame(mesh *m) { add_gold_frame(m, 1.7, 2.9, 1.2); }

/* A mesh of its own, which is drawn as a mirror. */
static void looking_glass(mesh *m)
{
    use_material(m, "mirror");
    add_flat(m,
             (const vec[]){v3(-0.85, -1.45, 0.03), v3(0.85, -1.45, 0.03), v3(0.85, 1.45, 0.03), v3(-0.85, 1.45, 0.03)},
             4);
}

/* A spotlight under a rail: it hangs at the origin and points along +Z and down. */
static void spotlight(mesh *m)
{
    static const double can[][2] = {{0.015, 0.13},  {0.05, 0.12},   {0.055, 0.10},
                                    {0.055, -0.08}, {0.055, -0.08}, {0.048, -0.08}};
    static const double glow[][2] = {{0.0475, -0.07}, {0, -0.071}};
    use_material(m, "iron");
    add_lathe(m, can, 6, 20, 0);
    const int first = m->corner_count;
    use_material(m, "glow");
    add_lathe(m, glow, 2, 20, 0);
    for (int i = 0; i < m->corner_count; i++) { /* tilt it by 40 degrees */
        corner *c = &m->corners[i];
        const double s = 0.643, k = 0.766;
        if (i >= first) c->normal = v3(0, -1, 0);
        c->at = v3(c->at.x, k * c->at.y + s * c->at.z, k * c->at.z - s * c->at.y);
        c->normal = v3(c->normal.x, k * c->normal.y + s * c->normal.z, k * c->normal.z - s * c->normal.y);
    }
    use_material(m, "iron");
    add_block(m, v3(-0.012, 0.05, -0.012), v3(0.012, 0.30, 0.012), 1);
}

/* A lamp on a wall: a plate, an arm, and a globe that glows. It faces +Z. */
static void sconce(mesh *m)
{
    static const double cup[][2] = {{0.012, -0.06}, {0.012, 0}, {0.045, 0.02}, {0.052, 0.04}, {0.03, 0.04}};
    use_material(m, "brass");
    add_block(m, v3(-0.05, -0.16, 0), v3(0.05, 0.10, 0.02), 1);
    add_block(m, v3(-0.012, -0.06, 0.02), v3(0.012, -0.036, 0.15), 1);
    m->move = v3(0, 0, 0.14);
    add_lathe(m, cup, 5, 20, 0);
    m->move = v3(0, 0.105, 0.14);
    use_material(m, "glow");
    double globe[9][2];
    for (int i = 0; i < 9; i++) globe[i][0] = 0.08 * sin(TAU * i / 16), globe[i][1] = -0.08 * cos(TAU * i / 16);
    add_lathe(m, (const double(*)[2])globe, 9, 20, 0);
    m->move = v3(0, 0, 0);
}

/* Rails for them, hung from the vault. */
static void rails(mesh *m)
{
    use_material(m, "iron");
    for (int side = -1; side <= 1; side += 2) {
        const double z = side * 2.9;
        add_block(m, v3(1.2, 5.30, z - 0.025), v3(LONG - 1.2, 5.35, z + 0.025), 1);
        for (int i = 0; i < 4; i++)
            add_block(m, v3(2.2 + 4.4 * i - 0.008, 5.35, z - 0.008), v3(2.2 + 4.4 * i + 0.008, 7.7, z + 0.008), 1);
    }
}

/* ---- what stands on the floor ---- */

static void plinth(mesh *m)
{
    use_material(m, "slate");
    add_box(m, v3(-0.36, 0, -0.36), v3(0.36, 0.12, 0.36), 1);
    use_material(m, "rim");
    add_box(m, v3(-0.29, 0.12, -0.29), v3(0.29, 0.98, 0.29), 1.1);
    add_block(m, v3(-0.33, 0.98, -0.33), v3(0.33, 1.05, 0.33), 1.1);
}

/* A trefoil, its foot at the origin. */
static vec trefoil_spine(double t)
{
    const double a = TAU * t, r = 0.26 + 0.13 * cos(3 * a);
    return v3(r * cos(2 * a), 0.50 + r * sin(2 * a), 0.16 * sin(3 * a));
}

static vec trefoil(double u, double v)
{
    const vec at = trefoil_spine(v), d = normal_of(sub(trefoil_spine(v + 1e-4), trefoil_spine(v - 1e-4)));
    const vec side = normal_of(cross(d, sub(at, v3(0, 0.50, 0)))), up = cross(side, d);
    const double a = -TAU * u;
    return add(at, add(times(side, 0.078 * cos(a)), times(up, 0.078 * sin(a))));
}

static void knot(mesh *m)
{
    use_material(m, "polished_gold");
    add_surface(m, trefoil, 16, 110);
    use_material(m, "slate");
    add_block(m, v3(-0.16, -0.62, -0.16), v3(0.16, 0.06, 0.16), 1);
}

/* A flame of glass with five twisted flutes. */
static vec glass_flame(double u, double v)
{
    const double a = -TAU * u, r = 0.19 * pow(sin(M_PI * pow(v, 0.72)), 0.85) * (1 - 0.35 * v);
    const double fluted = r * (1 + 0.10 * cos(5 * (a + 1.6 * v)));
    const double bend = 0.03 * sin(5 * v);
    return v3(fluted * cos(a) + bend, 0.06 + 0.80 * v, fluted * sin(a));
}

static void flame(mesh *m)
{
    use_material(m, "blue_glass");
    add_surface(m, glass_flame, 50, 34);
}

static void foot(mesh *m)
{
    static const double profile[][2] = {{0.13, 0},    {0.13, 0.015},  {0.13, 0.015}, {0.05, 0.03},
                                        {0.03, 0.05}, {0.045, 0.075}, {0, 0.07}};
    use_material(m, "brass");
    add_lathe(m, profile, 7, 32, 0);
}

static const double CASE_LOW = 0.90, CASE_HIGH = 1.65, CASE_HALF = 0.42;

/* A case of thin glass, to stand over a table: a box in a box, both closed. */
static void glass_case(mesh *m)
{
    const double thick = 0.008, half = CASE_HALF, inner = half - thick;
    use_material(m, "glass");
    add_block(m, v3(-half, CASE_LOW, -half), v3(half, CASE_HIGH, half), 1);
    const int first = m->face_count;
    add_block(m, v3(-inner, CASE_LOW + thick, -inner), v3(inner, CASE_HIGH - thick, inner), 1);
    for (int i = first; i < m->face_count; i++) { /* it faces inwards */
        corner *c = &m->corners[m->faces[i].first];
        const corner t = c[1];
        c[1] = c[3], c[3] = t;
        for (int k = 0; k < 4; k++) c[k].normal = times(c[k].normal, -1);
    }
}

/* The table, with brass along the upright edges of the case. */
static void table(mesh *m)
{
    use_material(m, "ebony");
    add_block(m, v3(-0.46, 0.82, -0.46), v3(0.46, 0.88, 0.46), 1);
    for (int i = 0; i < 4; i++) {
        const double x = i % 2 ? 0.38 : -0.44, z = i / 2 ? 0.38 : -0.44;
        add_box(m, v3(x, 0, z), v3(x + 0.06, 0.82, z + 0.06), 1);
    }
    use_material(m, "velvet");
    add_box(m, v3(-0.40, 0.88, -0.40), v3(0.40, 0.895, 0.40), 1);
    use_material(m, "brass");
    for (int i = 0; i < 4; i++) {
        const double x = i % 2 ? CASE_HALF + 0.001 : -CASE_HALF - 0.015,
                     z = i / 2 ? CASE_HALF + 0.001 : -CASE_HALF - 0.015;
        add_box(m, v3(x, 0.88, z), v3(x + 0.014, CASE_HIGH + 0.014, z + 0.014), 1);
    }
}

static void bench(mesh *m)
{
    use_material(m, "leather");
    add_block(m, v3(-0.30, 0.36, -0.90), v3(0.30, 0.45, 0.90), 0.5);
    add_block(m, v3(-0.27, 0.45, -0.87), v3(0.27, 0.475, 0.87), 0.5);
    use_material(m, "brass");
    add_block(m, v3(-0.28, 0.33, -0.88), v3(0.28, 0.36, 0.88), 1);
    for (int i = 0; i < 4; i++) {
        const double x = i % 2 ? 0.22 : -0.26, z = i / 2 ? 0.78 : -0.82;
        add_box(m, v3(x, 0, z), v3(x + 0.04, 0.33, z + 0.04), 1);
    }
}

/* A post of brass, and a rope to the next, 1.5 m along +Z. */
static vec rope_at(double u, double v)
{
    const double z = 1.5 * v, y = 0.88 - 0.95 * v * (1 - v), slope = -0.95 * (1 - 2 * v) / 1.5, a = TAU * u;
    const vec up = normal_of(v3(0, 1, -slope));
    return add(v3(0, y, z), add(times(v3(1, 0, 0), 0.019 * cos(a)), times(up, 0.019 * sin(a))));
}

static void post(mesh *m)
{
    static const double profile[][2] = {{0.16, 0},     {0.16, 0.02},  {0.15, 0.035}, {0.05, 0.05},
                                        {0.022, 0.07}, {0.022, 0.84}, {0.04, 0.85},  {0.04, 0.91},
                                        {0.025, 0.92}, {0.04, 0.95},  {0.035, 0.98}, {0, 0.99}};
    use_material(m, "brass");
    add_lathe(m, profile, 12, 24, 0);
}

static void rope(mesh *m)
{
    use_material(m, "velvet");
    add_surface(m, rope_at, 10, 20);
}

/* ---- a palm's frond: leaflets on both sides of its rib, which goes up the middle of the picture ---- */

enum { LEAFLETS = 21 };

static bool on_frond(double u, double v, double *along, double *across)
{
    const double s = fabs(u - 0.5), t = v - 0.42 * s, at = (t - 0.05) / 0.86 * LEAFLETS + (u < 0.5 ? 0.5 : 0);
    *along = 0, *across = 0;
    if (s < 0.012 * (1.15 - v) && v < 0.94) return true;
    if (t < 0.05 || t > 0.91) return false;
    const double reach = 0.49 * pow(sin(M_PI * (0.16 + 0.80 * t)), 0.7) * (0.92 + 0.16 * hash01((int)at, u < 0.5, 431));
    *along = s / reach, *across = (at - floor(at) - 0.5) / (0.40 * sqrt(fmax(1 - pow(*along, 1.6), 0)) + 1e-6);
    return s < reach && fabs(*across) < 1;
}

static color frond(double u, double v)
{
    double along, across;
    if (!on_frond(u, v, &along, &across)) return rgb(0x47762f);
    if (along < 1e-9) return rgb(0x8f9a4a);
    const double tone = hash01((int)(v * 40), u < 0.5, 433);
    color c = mix(rgb(0x2f6428), rgb(0x6f9c3c), 0.3 + 0.4 * tone + 0.25 * across);
    c = mix(c, rgb(0xb9a85a), 0.7 * smoothstep(0.86, 1, along));
    return shade(c, 1 - 0.22 * smoothstep(0.25, 0, fabs(across)));
}

static color frond_alpha(double u, double v)
{
    double along, across;
    return on_frond(u, v, &along, &across) ? (color){1, 1, 1} : (color){0, 0, 0};
}

/* ---- a palm in a pot ---- */

/* A frond from `base`, that leaves towards angle `a`, rises by `rise` and bends over; folded along its rib. */
static void add_frond(mesh *m, vec base, double a, double rise, double reach, double wide)
{
    enum { STEPS = 6 };
    const vec out = v3(cos(a), 0, sin(a)), side = v3(-sin(a), 0, cos(a));
    vec at[STEPS + 1], up[STEPS + 1];
    double tilt = rise;
    at[0] = base;
    for (int i = 0; i <= STEPS; i++) {
        up[i] = add(times(out, -sin(tilt)), v3(0, cos(tilt), 0));
        if (i < STEPS) at[i + 1] = add(at[i], times(add(times(out, cos(tilt)), v3(0, sin(tilt), 0)), reach / STEPS));
        tilt -= 0.085 + 0.055 * i;
    }
    for (int i = 0; i < STEPS; i++) {
        for (int s = -1; s <= 1; s += 2) {
            const double v0 = (double)i / STEPS, v1 = (double)(i + 1) / STEPS;
            const vec droop0 = add(times(side, s * wide / 2 * 0.93), times(up[i], 0.18 * wide)),
                      droop1 = add(times(side, s * wide / 2 * 0.93), times(up[i + 1], 0.18 * wide));
            const vec n0 = normal_of(add(up[i], times(side, -0.35 * s))),
                      n1 = normal_of(add(up[i + 1], times(side, -0.35 * s)));
            const double edge = s < 0 ? 0 : 1;
            const corner c[4] = {{at[i], n0, 0.5, v0},
                                 {add(at[i], droop0), n0, edge, v0},
                                 {add(at[i + 1], droop1), n1, edge, v1},
                                 {at[i + 1], n1, 0.5, v1}};
            const corner turned[4] = {c[0], c[3], c[2], c[1]};
            add_face(m, s > 0 ? turned : c, 4, true);
        }
    }
}

static void palm(mesh *m)
{
    enum { FRONDS = 17 };
    static const double pot[][2] = {{0, 0.0},     {0.20, 0},    {0.20, 0},    {0.24, 0.10}, {0.31, 0.34}, {0.33, 0.48},
                                    {0.31, 0.54}, {0.34, 0.57}, {0.34, 0.60}, {0.30, 0.60}, {0.29, 0.52}};
    static const double soil[][2] = {{0.295, 0.53}, {0.15, 0.55}, {0, 0.56}};
    use_material(m, "pot");
    add_lathe(m, pot, 11, 40, 0);
    use_material(m, "soil");
    add_lathe(m, soil, 3, 20, 0);
    for (int i = 0; i < 4; i++) { /* stems */
        const double a = 1.3 + 1.55 * i, x = 0.05 * cos(a), z = 0.05 * sin(a), high = 0.95 + 0.16 * i;
        use_material(m, "stem");
        add_tube(m, (const vec[]){v3(x, 0.5, z), v3(1.6 * x, 0.75, 1.6 * z), v3(2.2 * x, high, 2.2 * z)},
                 (const double[]){0.024, 0.019, 0.014}, 3, 8, 1);
    }
    use_material(m, "frond");
    for (int i = 0; i < FRONDS; i++) {
        const double a = 2.39996 * i + 0.4 * hash01(i, 0, 441), young = (double)i / FRONDS, s = 1.3 + 1.55 * (i % 4);
        const vec base = v3(0.11 * cos(s), 0.86 + 0.16 * (i % 4), 0.11 * sin(s));
        add_frond(m, base, a, 0.55 + 0.85 * young, 1.15 + 0.35 * hash01(i, 1, 441) + 0.1 * young, 0.52);
    }
}

bool generate_exhibits(const char *root)
{
    static const mesh_recipe list[] = {
        {"assets/meshes/gallery/looking_glass.obj", looking_glass},
        {"assets/meshes/gallery/looking_glass_frame.obj", looking_glass_frame},
        {"assets/meshes/gallery/rails.obj", rails},
        {"assets/meshes/gallery/spotlight.obj", spotlight},
        {"assets/meshes/gallery/sconce.obj", sconce},
        {"assets/meshes/gallery/plinth.obj", plinth},
        {"assets/meshes/gallery/knot.obj", knot},
        {"assets/meshes/gallery/flame.obj", flame},
        {"assets/meshes/gallery/foot.obj", foot},
        {"assets/meshes/gallery/table.obj", table},
        {"assets/meshes/gallery/bench.obj", bench},
        {"assets/meshes/gallery/post.obj", post},
        {"assets/meshes/gallery/rope.obj", rope},
        {"assets/meshes/gallery/palm.obj", palm},
        {"assets/meshes/gallery/valley.obj", valley},
        {"assets/meshes/gallery/gale.obj", gale},
        {"assets/meshes/gallery/lady.obj", lady},
        {"assets/meshes/gallery/fruit.obj", fruit},
        {"assets/meshes/gallery/night.obj", night},
        {"assets/meshes/gallery/lilies.obj", lilies},
        {"assets/meshes/gallery/composition.obj", composition},
        {"assets/meshes/gallery/fields.obj", fields},
        {"assets/meshes/gallery/case.obj", glass_case},
    };
    return paint_square(root, "assets/textures/gallery/frond.jpg", 256, frond) &&
           paint_square(root, "assets/textures/gallery/frond_alpha.png", 256, frond_alpha) &&
           write_meshes(root, list, sizeof list / sizeof list[0], "gallery.mtl");
}
