/* The scene `gallery`: a hall of four bays under a coffered vault with a skylight along its crown. x goes down the
 * hall, from 0 to 17.6 m; z across it, from -5 to 5; the vault springs at 5.6 and opens at 8. A pool lies in the
 * middle. */
#include "mesh.h"

#include <math.h>

static const double TAU = 6.283185307179586;
static const double BAY = 4.4, LONG = 17.6, WALL = 5, SPRING = 5.6, RISE = 2.6, OPEN = 1.7, TOP = 8.75;
static const double POOL[4] = {7.0, 10.6, -1.25, 1.25}; /* its rim's outside: from x to x, from z to z */

/* ---- textures ---- */

/* Silk for the walls: an ogee pattern, tone on tone. */
static color silk(double u, double v)
{
    const double row = floor(v * 2), y = v * 2 - row - 0.5, x0 = u * 2 + 0.5 * row, x = x0 - floor(x0) - 0.5;
    const double ogee = fabs(fabs(x) - 0.5 + 0.32 * cos(M_PI * y)), r = hypot(x, 0.8 * y), a = atan2(x, y);
    const double flower =
        smoothstep(0.012, -0.012, r - 0.13 - 0.05 * cos(6 * a)) - smoothstep(0.01, -0.01, fabs(r - 0.075) - 0.012);
    const double figure = clamp01(flower + smoothstep(0.030, 0.020, fabs(ogee - 0.05)));
    const double thread = 0.05 * noise(u * 128, v * 24, 128, 401) + 0.04 * noise(u * 24, v * 128, 128, 403);
    return shade(mix(rgb(0x3d6a64), rgb(0x568a80), 0.85 * figure), 1 + thread);
}

/* Four slabs: three of cream limestone, their corners cut for small squares of slate, and veins. */
static color floor_stone(double u, double v)
{
    const double x = u * 2, y = v * 2, fx = x - floor(x), fy = y - floor(y);
    const double tip = fmin(fx, 1 - fx) + fmin(fy, 1 - fy), joint = fmin(fmin(fx, 1 - fx), fmin(fy, 1 - fy));
    const double tone = hash01((int)floor(x), (int)floor(y), 407);
    const double cloud = fractal(u * 6 + 3 * tone, v * 6, 6, 5, 409);
    const double vein = fabs(fractal(u * 4 + 0.9 * fractal(u * 4, v * 4, 4, 4, 411), v * 4, 4, 5, 413));
    color c = mix(rgb(0xb8aa92), rgb(0xe4dac6), 0.45 + 0.25 * tone + 0.7 * cloud);
    c = mix(rgb(0x9a8467), c, 0.35 + 0.65 * smoothstep(0, 0.06, vein));
    const color slate = mix(rgb(0x23302f), rgb(0x4b5c58), 0.4 + cloud + 0.5 * smoothstep(0.05, 0, vein));
    c = mix(c, slate, smoothstep(0.205, 0.199, tip));
    const double line = fmin(tip > 0.2 ? joint : 1, fabs(tip - 0.2) * 0.7);
    return mix(rgb(0x6f6655), c, smoothstep(0.002, 0.006, line));
}

/* Glass mosaic for the pool. */
static color mosaic(double u, double v)
{
    const double x = u * 16, y = v * 16,
                 e = fmin(fmin(x - floor(x), 1 - x + floor(x)), fmin(y - floor(y), 1 - y + floor(y)));
    const double tone = hash01((int)floor(x) & 15, (int)floor(y) & 15, 417);
    const color c = tone > 0.94 ? rgb(0xd9b45a) : mix(rgb(0x1f6f80), rgb(0x6fc0b8), tone);
    return mix(rgb(0xcfd6cc), c, smoothstep(0.04, 0.09, e));
}

static double swell(double u, double v)
{
    return fractal(u * 5, v * 5, 5, 3, 421) + 0.25 * noise(u * 17, v * 17, 17, 425);
}

/* Normals of small waves. */
static color ripples(double u, double v)
{
    const double e = 1.0 / 512, steep = 0.020;
    const vec n = normal_of(v3((swell(u - e, v) - swell(u + e, v)) / (2 * e) * steep,
                               (swell(u, v - e) - swell(u, v + e)) / (2 * e) * steep, 1));
    return (color){0.5 + 0.5 * n.x, 0.5 + 0.5 * n.y, 0.5 + 0.5 * n.z};
}

static void add_quad(mesh *m, vec a, vec b, vec c, vec d, vec eye)
{
    add_facing(m, (const vec[]){a, b, c, d}, eye, 0, 0);
}

/* ---- the shell ---- */

/* A point of the vault, `out` metres behind its surface; `angle` from the springing up. */
static vec vault(double side, double angle, double x, double out)
{
    return v3(x, SPRING + (RISE + out) * sin(angle), side * (WALL + out) * cos(angle));
}

/* One coffer: a frame, four sides, a field and a rosette. */
static void add_coffer(mesh *m, double side, double a0, double a1, double x0, double x1)
{
    const double da = 0.13 * (a1 - a0), dx = 0.11 * (x1 - x0), deep = 0.17;
    const double a[4] = {a0, a0 + da, a1 - da, a1}, x[4] = {x0, x0 + dx, x1 - dx, x1};
    const vec eye = v3((x0 + x1) / 2, 2, 0), middle = vault(side, (a0 + a1) / 2, (x0 + x1) / 2, deep / 2);
    vec outer[4], inner[4], back[4];
    for (int i = 0; i < 4; i++) {
        const int p = i == 1 || i == 2, q = i > 1;
        outer[i] = vault(side, q ? a[3] : a[0], p ? x[3] : x[0], 0);
        inner[i] = vault(side, q ? a[2] : a[1], p ? x[2] : x[1], 0);
        back[i] = vault(side, q ? a[2] : a[1], p ? x[2] : x[1], deep);
    }
    use_material(m, "stucco");
    for (int i = 0; i < 4; i++) {
        const int j = (i + 1) % 4;
        add_quad(m, outer[i], outer[j], inner[j], inner[i], eye);
        add_quad(m, inner[i], inner[j], back[j], back[i], middle);
    }
    use_material(m, "field");
    add_quad(m, back[0], back[1], back[2], back[3], eye);
    use_material(m, "gilding");
    const vec center = times(add(add(back[0], back[1]), add(back[2], back[3])), 0.25), in = normal_of(sub(eye, center));
    const vec right = times(sub(back[1], back[0]), 0.30), up = times(sub(back[3], back[0]), 0.30);
    vec rim[16];
    for (int i = 0; i < 16; i++) {
        const double t = TAU * i / 16, r = i % 2 ? 0.72 : 1;
        rim[i] = add(add(center, times(in, 0.012)), add(times(right, r * cos(t)), times(up, r * sin(t))));
    }
    for (int i = 0; i < 16; i++) {
        const vec petal[3] = {rim[i], rim[(i + 1) % 16], add(center, times(in, 0.07))};
        const bool turn = dot(cross(sub(petal[1], petal[0]), sub(petal[2], petal[0])), in) < 0;
        add_flat(m, turn ? (const vec[]){petal[1], petal[0], petal[2]} : petal, 3);
    }
}

/* A rib between two bays, from the cornice to the skylight. */
static void add_rib(mesh *m, double side, double x0, double x1)
{
    enum { STEPS = 10 };
    const double top = acos(OPEN / WALL), stand = -0.12;
    use_material(m, "stucco");
    for (int i = 0; i < STEPS; i++) {
        const double a = top * i / STEPS, b = top * (i + 1) / STEPS;
        const vec eye = v3((x0 + x1) / 2, 2, 0);
        add_quad(m, vault(side, a, x0, stand), vault(side, a, x1, stand), vault(side, b, x1, stand),
                 vault(side, b, x0, stand), eye);
        for (int k = 0; k < 2; k++) {
            const double x = k ? x1 : x0;
            add_quad(m, vault(side, a, x, stand), vault(side, b, x, stand), vault(side, b, x, 0), vault(side, a, x, 0),
                     v3(k ? x + 9 : x - 9, 3, 0));
        }
    }
}

/* Profiles of (depth before the wall, height), extruded along x. */
static void add_moulding(mesh *m, const double (*p)[2], int count, double side, double x0, double x1)
{
    for (int i = 0; i + 1 < count; i++) {
        const double z0 = side * (WALL - p[i][0]), z1 = side * (WALL - p[i + 1][0]);
        const double dy = p[i + 1][1] - p[i][1], dd = p[i + 1][0] - p[i][0];
        const vec eye = add(v3(x0, p[i][1], z0), v3(0, -9 * dd, -9 * side * dy)); /* outward along the profile's normal
                                                                                   */
        add_quad(m, v3(x0, p[i][1], z0), v3(x1, p[i][1], z0), v3(x1, p[i + 1][1], z1), v3(x0, p[i + 1][1], z1), eye);
    }
}

static void add_wall(mesh *m, double side)
{
    static const double cornice[][2] = {{0, 4.80},    {0.05, 4.82}, {0.05, 4.98}, {0.14, 5.04},
                                        {0.14, 5.14}, {0.22, 5.18}, {0.30, 5.30}, {0.42, 5.36},
                                        {0.42, 5.46}, {0.34, 5.50}, {0.30, 5.58}, {0, 5.60}};
    static const double rail[][2] = {{0, 4.60}, {0.03, 4.61}, {0.03, 4.66}, {0, 4.67}};
    static const double skirting[][2] = {{0.06, 0}, {0.06, 0.40}, {0.035, 0.44}, {0, 0.45}};
    const vec eye = v3(BAY / 2, 2, 0);
    const double z = side * WALL;
    use_material(m, "silk");
    add_facing(m, (const vec[]){v3(0, 0.45, z), v3(BAY, 0.45, z), v3(BAY, 4.8, z), v3(0, 4.8, z)}, eye, 6, 6);
    use_material(m, "stucco");
    add_moulding(m, cornice, 12, side, 0, BAY);
    use_material(m, "gilding");
    add_moulding(m, rail, 4, side, 0, BAY);
    use_material(m, "slate");
    add_moulding(m, skirting, 4, side, 0, BAY);
}

/* From the floor to the cornice, with a foot and a head. */
static void add_pilaster(mesh *m, double side, double x0, double x1)
{
    static const double parts[][4] = {{0, 0.45, 0.24, 0.07},    {0.45, 0.55, 0.19, 0.03}, {0.55, 4.45, 0.15, 0},
                                      {4.45, 4.52, 0.19, 0.03}, {4.52, 4.72, 0.15, 0},    {4.72, 4.86, 0.22, 0.07}};
    for (int i = 0; i < 6; i++) { /* from, to, how far it stands out, how much wider it is */
        const double *p = parts[i], near = side * (WALL - p[2]);
        use_material(m, i == 0 ? "slate" : i == 4 ? "gilding" : "stucco");
        const double low = fmin(near, side * WALL), high = fmax(near, side * WALL);
        add_block(m, v3(x0 - p[3], p[0], low), v3(x1 + p[3], p[1], high), 2);
    }
}

/* A bay from the middle of one rib to that of the next. */
static void bay(mesh *m)
{
    enum { ROWS = 4, COLUMNS = 4 };
    const double top = acos(OPEN / WALL), rib = 0.32;
    for (int side = -1; side <= 1; side += 2) {
        add_wall(m, side);
        add_rib(m, side, 0, rib), add_rib(m, side, BAY - rib, BAY);
        add_pilaster(m, side, 0, rib - 0.04), add_pilaster(m, side, BAY - rib + 0.04, BAY);
        for (int i = 0; i < ROWS; i++) {
            for (int k = 0; k < COLUMNS; k++) {
                const double wide = (BAY - 2 * rib) / COLUMNS, x = rib + wide * k;
                add_coffer(m, side, top * i / ROWS, top * (i + 1) / ROWS, x, x + wide);
            }
        }
        const double z = side * OPEN, y = SPRING + RISE * sin(top);
        use_material(m, "stucco");
        add_quad(m, v3(0, y, z), v3(BAY, y, z), v3(BAY, TOP, z), v3(0, TOP, z), v3(BAY / 2, y, 0));
        use_material(m, "gilding");
        add_block(m, v3(0, y - 0.02, fmin(z, z - side * 0.08)), v3(BAY, y + 0.08, fmax(z, z - side * 0.08)), 1);
    }
    use_material(m, "iron");
    for (int i = 1; i < 4; i++) {
        const double x = BAY / 4 * i, half = 0.05;
        add_block(m, v3(x - half, TOP - 0.06, -OPEN), v3(x + half, TOP, OPEN), 1);
    }
    for (int i = -1; i <= 1; i++) add_block(m, v3(0, TOP - 0.06, 0.85 * i - 0.05), v3(BAY, TOP, 0.85 * i + 0.05), 1);
    use_material(m, "stucco"); /* the ribs go on across the skylight */
    add_block(m, v3(0, TOP - 0.5, -OPEN), v3(rib, TOP, OPEN), 1);
    add_block(m, v3(BAY - rib, TOP - 0.5, -OPEN), v3(BAY, TOP, OPEN), 1);
}

/* The end walls: silk, a cornice, and a lunette up to the skylight. */
static void ends(mesh *m)
{
    enum { STEPS = 10 };
    const double top = acos(OPEN / WALL);
    for (int end = 0; end < 2; end++) {
        const double x = end ? LONG : 0, in = end ? -1 : 1;
        const vec eye = v3(LONG / 2, 2, 0);
        use_material(m, "silk");
        add_facing(m, (const vec[]){v3(x, 0.45, -WALL), v3(x, 0.45, WALL), v3(x, 4.8, WALL), v3(x, 4.8, -WALL)}, eye,
                   14, 6);
        use_material(m, "stucco");
        add_block(m, v3(fmin(x, x + in * 0.10), 4.8, -WALL), v3(fmax(x, x + in * 0.10), 5.1, WALL), 2);
        add_block(m, v3(fmin(x, x + in * 0.30), 5.1, -WALL), v3(fmax(x, x + in * 0.30), 5.6, WALL), 2);
        vec edge[2 * STEPS + 2];
        for (int i = 0; i <= STEPS; i++) { /* counter-clockwise from inside */
            edge[i] = vault(end ? 1 : -1, top * i / STEPS, x, 0);
            edge[2 * STEPS + 1 - i] = vault(end ? -1 : 1, top * i / STEPS, x, 0);
        }
        add_flat(m, edge, 2 * STEPS + 2);
        add_quad(m, v3(x, SPRING, -OPEN), v3(x, SPRING, OPEN), v3(x, TOP, OPEN), v3(x, TOP, -OPEN), eye);
        use_material(m, "slate");
        add_block(m, v3(fmin(x, x + in * 0.06), 0, -WALL), v3(fmax(x, x + in * 0.06), 0.45, WALL), 2);
    }
    use_material(m, "stucco"); /* a door, behind those who enter */
    add_block(m, v3(0, 0, -1.55), v3(0.16, 3.5, -1.25), 1), add_block(m, v3(0, 0, 1.25), v3(0.16, 3.5, 1.55), 1);
    add_block(m, v3(0, 3.5, -1.70), v3(0.24, 3.9, 1.70), 1);
    use_material(m, "door");
    for (int i = 0; i < 6; i++) {
        const double z = i % 2 ? 0 : 1.25, y = i / 2 * 1.166;
        add_panel(
            m,
            (const vec[]){v3(0.07, y, z), v3(0.07, y, z - 1.25), v3(0.07, y + 1.166, z - 1.25), v3(0.07, y + 1.166, z)},
            0, 0, 1, 1);
    }
}

/* A plane around the pool, so that it can be drawn as a mirror. */
static void ground(mesh *m)
{
    const double xs[] = {0, POOL[0], POOL[1], LONG}, zs[] = {WALL, POOL[3], POOL[2], -WALL}, tile = 2.2;
    use_material(m, "floor");
    for (int i = 0; i < 9; i++) {
        const double x0 = xs[i % 3], x1 = xs[i % 3 + 1], z0 = zs[i / 3], z1 = zs[i / 3 + 1];
        if (i == 4) continue;
        const vec p[4] = {v3(x0, 0, z0), v3(x1, 0, z0), v3(x1, 0, z1), v3(x0, 0, z1)};
        add_panel(m, p, x0 / tile, (WALL - z0) / tile, x1 / tile, (WALL - z1) / tile);
    }
}

/* ---- the pool ---- */

static void basin(mesh *m)
{
    const double wide = 0.36, high = 0.40, deep = -0.30;
    const double x0 = POOL[0] + wide, x1 = POOL[1] - wide, z0 = POOL[2] + wide, z1 = POOL[3] - wide;
    use_material(m, "rim");
    add_box(m, v3(POOL[0], 0, POOL[2]), v3(POOL[1], high, z0), 1.1);
    add_box(m, v3(POOL[0], 0, z1), v3(POOL[1], high, POOL[3]), 1.1);
    add_box(m, v3(POOL[0], 0, z0), v3(x0, high, z1), 1.1), add_box(m, v3(x1, 0, z0), v3(POOL[1], high, z1), 1.1);
    use_material(m, "mosaic");
    const double off = 0.001; /* before the sides of the rim */
    const vec eye = v3((x0 + x1) / 2, 0.2, 0), low = v3(x0 + off, deep, z0 + off), far = v3(x1 - off, deep, z1 - off);
    const vec c[4] = {low, v3(far.x, deep, low.z), far, v3(low.x, deep, far.z)};
    add_facing(m, c, eye, x1 - x0, z1 - z0);
    for (int i = 0; i < 4; i++) {
        const vec a = c[i], b = c[(i + 1) % 4], up = v3(0, high - deep, 0);
        add_facing(m, (const vec[]){a, b, add(b, up), add(a, up)}, eye, length(sub(b, a)), high - deep);
    }
}

/* A closed body, a millimetre off the basin. */
static void water(mesh *m)
{
    const double off = 0.362, high = 0.30;
    const vec a = v3(POOL[0] + off, -0.299, POOL[2] + off), b = v3(POOL[1] - off, high, POOL[3] - off);
    const vec top[4] = {v3(a.x, b.y, b.z), v3(b.x, b.y, b.z), v3(b.x, b.y, a.z), v3(a.x, b.y, a.z)};
    use_material(m, "water");
    const vec inside = v3((a.x + b.x) / 2, 0, 0);
    vec bottom[4];
    for (int i = 0; i < 4; i++) bottom[i] = v3(top[i].x, a.y, top[i].z);
    for (int i = 0; i < 4; i++) {
        const int j = (i + 1) % 4;
        const vec out = add(times(add(top[i], top[j]), 2), times(inside, -3));
        add_quad(m, bottom[i], bottom[j], top[j], top[i], out);
    }
    add_quad(m, bottom[0], bottom[1], bottom[2], bottom[3], add(inside, v3(0, -9, 0)));
    use_material(m, "waves");
    add_facing(m, top, add(inside, v3(0, 9, 0)), (b.x - a.x) / 1.6, (b.z - a.z) / 1.6);
}

static const char LIBRARY[] =
    "# made by daft_generate, CC0\n"
    "newmtl silk\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/gallery/silk.jpg\n\n"
    "newmtl stucco\nKa 0.84 0.80 0.72\nKd 0.84 0.80 0.72\nKs 0 0 0\nillum 1\n\n"
    "newmtl field\nKa 0.26 0.40 0.42\nKd 0.26 0.40 0.42\nKs 0 0 0\nillum 1\n\n"
    "newmtl gilding\nKa 0.80 0.60 0.24\nKd 0.80 0.60 0.24\nKs 0.4 0.32 0.16\nNs 30\nillum 2\n\n"
    "newmtl gold\nKa 0.60 0.43 0.16\nKd 0.66 0.47 0.18\nKs 0.50 0.40 0.20\nNs 35\nillum 2\n\n"
    "newmtl polished_gold\nKa 0.05 0.035 0.01\nKd 0.06 0.045 0.02\nKs 0.95 0.72 0.36\nNs 400\nillum 3\n\n"
    "newmtl brass\nKa 0.22 0.17 0.08\nKd 0.34 0.26 0.12\nKs 0.48 0.38 0.2\nNs 120\nillum 3\n\n"
    "newmtl ebony\nKa 0.07 0.05 0.04\nKd 0.07 0.05 0.04\nKs 0.12 0.12 0.12\nNs 40\nillum 2\n\n"
    "newmtl oak\nKa 0.42 0.29 0.17\nKd 0.42 0.29 0.17\nKs 0.06 0.06 0.06\nNs 20\nillum 2\n\n"
    "newmtl iron\nKa 0.05 0.055 0.06\nKd 0.05 0.055 0.06\nKs 0.1 0.1 0.1\nNs 30\nillum 2\n\n"
    "newmtl floor\nKa 0.72 0.72 0.72\nKd 0.72 0.72 0.72\nKs 0.20 0.20 0.20\nNs 300\nillum 3\nmap_Kd "
    "../../textures/gallery/floor.jpg\n\n"
    "newmtl slate\nKa 0.11 0.125 0.125\nKd 0.11 0.125 0.125\nKs 0.2 0.2 0.2\nNs 60\nillum 2\n\n"
    "newmtl rim\nKa 0.62 0.57 0.50\nKd 0.62 0.57 0.50\nKs 0.10 0.10 0.10\nNs 40\nillum 2\n\n"
    "newmtl marble\nKa 0.86 0.83 0.78\nKd 0.86 0.83 0.78\nKs 0.16 0.16 0.16\nNs 45\nillum 2\n\n"
    "newmtl mosaic\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/gallery/mosaic.jpg\n\n"
    "newmtl water\nKa 0 0 0\nKd 0 0 0\nKs 0.5 0.5 0.5\nNs 600\nNi 1.33\nTf 0.93 0.98 0.98\nillum 7\n\n"
    "newmtl waves\nKa 0 0 0\nKd 0 0 0\nKs 0.5 0.5 0.5\nNs 600\nNi 1.33\nTf 0.93 0.98 0.98\nillum 7\nnorm "
    "../../textures/gallery/ripples.jpg\n\n"
    "newmtl glass\nKa 0 0 0\nKd 0 0 0\nKs 0.6 0.6 0.6\nNs 600\nNi 1.5\nTf 0.985 0.995 0.99\nillum 7\n\n"
    "newmtl blue_glass\nKa 0 0 0\nKd 0 0 0\nKs 0.6 0.6 0.6\nNs 600\nNi 1.52\nTf 0.72 0.90 0.98\nillum 7\n\n"
    "newmtl mirror\nKa 0.02 0.02 0.02\nKd 0.02 0.02 0.02\nKs 0.92 0.93 0.92\nNs 900\nillum 3\n\n"
    "newmtl leather\nKa 0.30 0.12 0.07\nKd 0.30 0.12 0.07\nKs 0.18 0.16 0.14\nNs 25\nillum 2\n\n"
    "newmtl velvet\nKa 0.42 0.05 0.08\nKd 0.42 0.05 0.08\nKs 0 0 0\nillum 1\n\n"
    "newmtl pot\nKa 0.09 0.17 0.24\nKd 0.09 0.17 0.24\nKs 0.10 0.10 0.10\nNs 150\nillum 3\n\n"
    "newmtl soil\nKa 0.12 0.08 0.05\nKd 0.12 0.08 0.05\nKs 0 0 0\nillum 1\n\n"
    "newmtl stem\nKa 0.30 0.34 0.14\nKd 0.30 0.34 0.14\nKs 0 0 0\nillum 1\n\n"
    "newmtl frond\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd ../../textures/gallery/frond.jpg\n"
    "map_d ../../textures/gallery/frond_alpha.png\n\n"
    "newmtl door\nKa 1 1 1\nKd 1 1 1\nKs 0.06 0.06 0.06\nNs 30\nillum 2\nmap_Kd ../../textures/panelling.jpg\n\n"
    "newmtl glow\nKa 1 1 1\nKd 0 0 0\nKe 1.6 1.35 1\nKs 0 0 0\nillum 1\n\n"
#define PAINTING(name)                                                                                                 \
    "newmtl " name "\nKa 1 1 1\nKd 1 1 1\nKs 0.02 0.02 0.02\nNs 20\nillum 2\nmap_Kd ../../textures/gallery/" name      \
    ".jpg\n\n"
    PAINTING("valley") PAINTING("gale") PAINTING("lady") PAINTING("fruit") PAINTING("night") PAINTING("lilies")
        PAINTING("composition") PAINTING("fields");

bool generate_gallery(const char *root)
{
    static const mesh_recipe list[] = {{"assets/meshes/gallery/bay.obj", bay},
                                       {"assets/meshes/gallery/ends.obj", ends},
                                       {"assets/meshes/gallery/ground.obj", ground},
                                       {"assets/meshes/gallery/basin.obj", basin},
                                       {"assets/meshes/gallery/water.obj", water}};
    return paint_square(root, "assets/textures/gallery/silk.jpg", 256, silk) &&
           paint_square(root, "assets/textures/gallery/floor.jpg", 512, floor_stone) &&
           paint_square(root, "assets/textures/gallery/mosaic.jpg", 256, mosaic) &&
           paint_square(root, "assets/textures/gallery/ripples.jpg", 256, ripples) &&
           write_text(root, "assets/meshes/gallery/gallery.mtl", LIBRARY) &&
           write_meshes(root, list, sizeof list / sizeof list[0], "gallery.mtl") && generate_exhibits(root) &&
           generate_statues(root) && generate_paintings(root);
}
