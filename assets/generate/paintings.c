/* The paintings of the gallery. Each is a picture given as a function, laid down again as two layers of brush strokes:
 * a stroke has the picture's colour at its own middle, follows a flow, and shows its bristles. */
#include "generate.h"

#include <math.h>
#include <stdlib.h>

/* ---- the brush ---- */

typedef double flow(double u, double v); /* the direction of strokes, radians */

typedef struct brush {
    painter *picture;
    flow *along;
    double aspect; /* width over height */
    int cells;     /* strokes of the coarse layer over the height; the fine one has twice as many */
    int seed;
} brush;

typedef struct stroke {
    double x, y, cosine, sine; /* its middle in cells, its direction */
    double rank;               /* above those of lower ones */
    color paint;
} stroke;

enum { MOST_ROWS = 140, MOST_COLUMNS = 282 };

/* The strokes of a layer, one for each cell, with a border of one cell. */
typedef struct layer {
    double aspect, cells;
    int seed;
    stroke strokes[MOST_ROWS][MOST_COLUMNS];
} layer;

/* What is being painted: paint_square() asks for colours by u and v alone. */
static layer coarse, fine;
static painter *underneath;

static void plan_layer(layer *l, const brush *b, int cells, int seed)
{
    l->aspect = b->aspect, l->cells = cells, l->seed = seed;
    for (int y = 0; y < cells + 2; y++) {
        for (int x = 0; x < (int)ceil(cells * b->aspect) + 2; x++) {
            stroke *s = &l->strokes[y][x];
            s->x = x - 0.85 + 0.7 * hash01(x, y, seed + 1), s->y = y - 0.85 + 0.7 * hash01(x, y, seed + 2);
            const double u = clamp01(s->x / cells / b->aspect), v = clamp01(s->y / cells);
            const double a = b->along(u, v) + 0.5 * (hash01(x, y, seed + 3) - 0.5);
            const double tint = 0.09 * (hash01(x, y, seed + 4) - 0.5);
            const color c = shade(b->picture(u, v), 1 + 0.5 * tint);
            s->cosine = cos(a), s->sine = sin(a), s->rank = hash01(x, y, seed);
            s->paint = (color){c.r * (1 + tint), c.g, c.b * (1 - tint)};
        }
    }
}

/* The colour of the uppermost stroke over the point; false where there is none. */
static bool stroke_color(const layer *l, double u, double v, color *out)
{
    const double x = u * l->aspect * l->cells, y = v * l->cells;
    const int ix = (int)floor(x), iy = (int)floor(y);
    const stroke *top = NULL;
    double on = 0, beside = 0; /* -1..1 along and across it */
    for (int i = 0; i < 9; i++) {
        const stroke *s = &l->strokes[iy + i / 3][ix + i % 3];
        const double along = ((x - s->x) * s->cosine + (y - s->y) * s->sine) / 1.15,
                     across = ((y - s->y) * s->cosine - (x - s->x) * s->sine) / 0.36;
        if (fabs(along) > 1 || fabs(across) > 1 - 0.35 * along * along || (top && s->rank < top->rank)) continue;
        top = s, on = along, beside = across;
    }
    if (!top) return false;
    const double bristle = noise(beside * 5, on * 0.8 + 40 * top->rank, 4096, l->seed + 5);
    *out = shade(top->paint, 1 + 0.07 * bristle + 0.06 * beside * (beside > 0 ? 1 : 0.6));
    return true;
}

static color brushed(double u, double v)
{
    color c;
    if (!stroke_color(&fine, u, v, &c) && !stroke_color(&coarse, u, v, &c)) c = underneath(u, v);
    return shade(c, 1 + 0.03 * noise(u * coarse.aspect * 200, v * 200, 4096, 3)); /* the canvas */
}

static bool paint(const char *root, const char *path, const brush *b)
{
    underneath = b->picture;
    plan_layer(&coarse, b, b->cells, b->seed);
    plan_layer(&fine, b, 2 * b->cells, b->seed + 10);
    return paint_square(root, path, 512, brushed);
}

static double level(double u, double v) { return 0.25 * noise(u * 5, v * 9, 4096, 71); }

static double slanted(double u, double v) { return 0.9 + 0.9 * noise(u * 3, v * 3, 4096, 73); }

/* ---- shapes ---- */

/* 1 inside an ellipse, with an edge that is `soft` of its radius wide. */
static double oval(double x, double y, double rx, double ry, double soft)
{
    return smoothstep(1 + soft, 1 - soft, sqrt(x * x / (rx * rx) + y * y / (ry * ry)));
}

/* A ball lit from the upper left over what is below; x and y from its middle in radii. */
static color ball(color below, double x, double y, color c, double shine)
{
    const double r2 = x * x + y * y;
    if (r2 > 1) return below;
    const double z = sqrt(1 - r2), lit = clamp01(-0.55 * x + 0.6 * y + 0.58 * z);
    const double gloss = pow(clamp01(-0.30 * x + 0.38 * y + 0.87 * z), 40);
    c = shade(c, 0.16 + 0.98 * lit + 0.12 * clamp01(0.6 * x - 0.7 * y) * z);
    return mix(below, mix(c, rgb(0xfff4dc), shine * gloss), smoothstep(1, 0.94, r2));
}

/* ---- a valley with a lake, at sunset ---- */

static double ridge(double u, int i)
{
    static const double height[] = {0.60, 0.545, 0.475, 0.40}, rough[] = {0.20, 0.13, 0.09, 0.05};
    return height[i] + rough[i] * fractal(u * (2.2 + i) + 7.3 * i, 0.5, 4096, 5, 81 + i) +
           0.05 * (i == 0 ? sin(5 * u + 1.2) : 0) - (i == 3 ? 0.05 * sin(3 * u) : 0);
}

static color valley_sky(double u, double v)
{
    color c = mix(rgb(0xf6c987), rgb(0x5f86ad), smoothstep(0.45, 1.0, v));
    const double d = hypot((u - 0.66) * 1.5, v - 0.62);
    const double cloud = smoothstep(0.02, 0.42, fractal(u * 3 + 2, v * 8, 4096, 5, 87)) * smoothstep(0.5, 0.7, v);
    c = mix(c, mix(rgb(0xe8a46f), rgb(0xf9ead2), smoothstep(0.9, 0.3, d)), 0.85 * cloud);
    return mix(c, rgb(0xfff3cf), 0.95 * exp(-pow(d / 0.13, 2)) + 0.35 * exp(-d / 0.3));
}

static color valley_land(double u, double v)
{
    static const int far_to_near[] = {0x8c8fae, 0x6f7c8f, 0x4d6a5f, 0x36502f};
    color c = valley_sky(u, v);
    for (int i = 0; i < 4; i++) {
        const double top = ridge(u, i);
        if (v > top) continue;
        const double sunny = 0.5 + 0.5 * noise(u * 14 + 3 * v, (top - v) * 16, 4096, 91 + i);
        c = mix(rgb(far_to_near[i]), rgb(i < 2 ? 0xe2b08f : 0xb59a4d), 0.42 * sunny * smoothstep(0.16, 0, top - v));
        c = mix(c, rgb(0xd9b79a), (0.45 - 0.12 * i) * smoothstep(0.02, 0.14, top - v) * (i < 3)); /* haze below */
    }
    return c;
}

static color valley(double u, double v)
{
    const double shore = 0.335 + 0.012 * noise(u * 7, 0, 4096, 95);
    color c = valley_land(u, v);
    if (v < shore) {
        c = mix(valley_land(u + 0.008 * noise(u * 4, v * 50, 4096, 97), 2 * shore - v), rgb(0x54708a), 0.22);
        c = mix(c, rgb(0xffe3ac),
                0.7 * smoothstep(0.1, 0.5, noise(u * 9, v * 70, 4096, 99)) * exp(-pow((u - 0.66) / 0.10, 2)));
    }
    const double bank = 0.15 - 0.16 * u + 0.05 * fractal(u * 6, 0.3, 4096, 4, 101);
    if (v < bank) c = mix(rgb(0x2b2f18), rgb(0x7d7431), 0.7 * smoothstep(0.08, 0, bank - v));
    for (int i = 0; i < 3; i++) { /* trees on the near shore */
        const double x = u - 0.10 - 0.10 * i, y = v - 0.52 + 0.09 * i, n = 0.20 * fractal(u * 22, v * 22, 4096, 3, 103);
        if (fabs(x + 0.02 * sin(9 * v)) < 0.009 && v < 0.5 - 0.08 * i && v > 0.05) c = rgb(0x2a1d12);
        const double crown = hypot(x / (0.085 - 0.01 * i), y / (0.21 - 0.03 * i)) + n;
        if (crown < 1) c = mix(rgb(0x1c2412), rgb(0x86803a), clamp01(0.4 + 2.2 * x + 1.2 * y + 1.6 * n) * 0.8);
    }
    return c;
}

/* Level, but upright where trunks and grass are. */
static double shore(double u, double v)
{
    return u < 0.36 && v < 0.34 ? 1.45 + 0.3 * noise(u * 9, v * 9, 4096, 105) : level(u, v);
}

/* ---- a lady by candle light ---- */

static color lady_face(color c, double x, double y)
{
    const double fx = x + 0.004, fy = y - 0.655, shape = hypot(fx / 0.135, fy / (fy < 0 ? 0.205 : 0.175));
    if (shape > 1) return c;
    const double lit = clamp01(0.80 - 2.6 * fx + 0.5 * fy - 0.35 * shape * shape);
    color skin = mix(rgb(0x5d3220), rgb(0xf1cda4), lit);
    skin = mix(skin, rgb(0xcf7f62),
               0.40 * (oval(fx + 0.07, fy + 0.055, 0.05, 0.045, 0.9) + oval(fx - 0.06, fy + 0.055, 0.04, 0.04, 0.9)));
    skin = shade(skin, 1 - 0.42 * oval(fx - 0.012, fy + 0.025, 0.013, 0.055, 0.9)); /* beside the nose */
    skin = shade(skin, 1 - 0.30 * oval(fx, fy + 0.075, 0.022, 0.008, 0.8));
    skin = mix(skin, rgb(0xa8423a), 0.9 * oval(fx, fy + 0.112, 0.034, 0.013, 0.5));
    skin = shade(skin, 1 - 0.5 * oval(fx, fy + 0.112, 0.032, 0.003, 0.7));
    for (int side = -1; side <= 1; side += 2) {
        const double ex = fx - side * 0.056, ey = fy - 0.022;
        skin = shade(skin, 1 - 0.32 * oval(ex, ey - 0.006, 0.036, 0.026, 0.7));
        skin = mix(skin, rgb(0xe9dfcd), oval(ex, ey, 0.026, 0.011, 0.35));
        skin = mix(skin, rgb(0x2a1a10), oval(ex + 0.003, ey, 0.0115, 0.0115, 0.25));
        skin = mix(skin, rgb(0xffffff), oval(ex + 0.007, ey + 0.004, 0.0035, 0.0035, 0.4));
        skin = mix(skin, rgb(0x3a2114), 0.85 * oval(ex, ey - 0.011 + 9 * ex * ex, 0.030, 0.004, 0.6));
        skin = mix(skin, rgb(0x4a2c1a), 0.8 * oval(ex, ey - 0.042 + 7 * ex * ex, 0.036, 0.006, 0.7));
    }
    return mix(c, skin, smoothstep(1, 0.94, shape));
}

static color lady(double u, double v)
{
    const double x = (u - 0.5) * 0.78, y = v; /* of a height of 1 */
    color c = mix(rgb(0x17110c), rgb(0x6a4b2b), exp(-pow(hypot(x + 0.16, y - 0.72) / 0.30, 2)));
    c = shade(c, 1 + 0.25 * fractal(u * 5, v * 5, 4096, 4, 111));
    const double hair = hypot(x / 0.185, (y - 0.655) / 0.265) + 0.05 * noise(atan2(x, y - 0.6) * 9, y * 3, 4096, 113);
    c = mix(c, mix(rgb(0x21120b), rgb(0x8a4f23), clamp01(0.45 - 2.6 * x + 0.4 * sin(50 * x + 14 * y))),
            smoothstep(1.02, 0.96, hair));
    const double chest = hypot(x / 0.40, (y - 0.02) / 0.40);
    if (chest < 1) { /* a gown of blue silk with folds */
        const double fold =
            0.5 + 0.5 * sin(26 * x + 9 * y * (x < 0 ? -1 : 1) + 3 * fractal(x * 6, y * 4, 4096, 3, 115));
        c = mix(rgb(0x0f1f38), rgb(0x4f86b4), clamp01(0.62 * fold + 0.28 - 1.5 * x));
    }
    const double neckline = hypot(x / 0.17, (y - 0.42) / 0.13);
    if (chest < 1.12 && neckline < 1 && y < 0.45) c = mix(rgb(0x8a5a3c), rgb(0xecc8a2), clamp01(0.62 - 2.6 * x));
    if (fabs(x) < 0.068 && y > 0.36 && y < 0.56) c = mix(rgb(0x57311f), rgb(0xd9ab83), clamp01(0.50 - 4.5 * x));
    if (fabs(neckline - 1) < 0.11 && y < 0.41) /* lace */
        c = mix(rgb(0xb9ab93), rgb(0xfbf3e2), clamp01(0.6 - 1.8 * x + 0.3 * sin(150 * atan2(x, 0.42 - y) / 4)));
    for (int i = -5; i <= 5; i++) /* pearls */
        c = ball(c, (x - 0.0185 * i) / 0.0105, (y - 0.408 - 0.0019 * i * i) / 0.0105, rgb(0xf0e6d4), 0.9);
    c = lady_face(c, x, y);
    const double fringe = hypot(x / 0.155, (y - 0.72) / 0.21);
    if (y > 0.80 - 0.42 * fabs(x - 0.02) && fringe < 1)
        c = mix(rgb(0x24140c), rgb(0x91572a), clamp01(0.5 - 2.4 * x + 0.4 * sin(70 * x)));
    return ball(c, (x + 0.142) / 0.017, (y - 0.565) / 0.022, rgb(0xe8e4da), 1); /* an ear-ring */
}

/* ---- fruit and a jug ---- */

static color jug(color c, double x, double y)
{
    const double t = clamp01(y / 0.50),
                 half = 0.125 * sin(0.45 + 2.2 * pow(t, 0.8)) * (t > 0.75 ? 1 + 1.2 * (t - 0.75) : 1);
    const double handle = fabs(hypot((x - 0.115) / 0.8, y - 0.31) - 0.105);
    if (handle < 0.018 && x > 0.06)
        c = mix(rgb(0xd9dee2), rgb(0x55636f), clamp01(0.5 + 18 * (hypot(x - 0.115, y - 0.31) - 0.1)));
    if (y < 0 || y > 0.50 || fabs(x) > half) return c;
    const double side = x / half, lit = clamp01(0.72 - 0.62 * side - 0.35 * side * side * side);
    color glaze = mix(rgb(0x3d4650), rgb(0xf3f3ee), lit);
    const double a = asin(side), vine = sin(6 * a + 4 * sin(14 * y)) * sin(42 * y);
    if ((y > 0.10 && y < 0.36 && vine > 0.25) || fabs(y - 0.08) < 0.008 || fabs(y - 0.385) < 0.008)
        glaze = mix(rgb(0x14244d), rgb(0x4f72b8), lit);
    return mix(glaze, rgb(0xffffff), 0.9 * oval(side + 0.42, (y - 0.30) * 4, 0.10, 0.25, 0.8));
}

static color fruit(double u, double v)
{
    static const struct {
        double x, y, r;
        int hue;
        double shine;
    } balls[] = {{0.60, 0.375, 0.085, 0xd8761c, 0.5}, {0.75, 0.385, 0.09, 0xb3262a, 0.8},
                 {0.885, 0.36, 0.078, 0x9fae3a, 0.6}, {0.675, 0.475, 0.08, 0xe0a52b, 0.5},
                 {0.82, 0.475, 0.078, 0xc73f2c, 0.8}, {0.53, 0.305, 0.07, 0xe9c23a, 0.5},
                 {0.99, 0.29, 0.074, 0xd8761c, 0.5}};
    const double x = u * 1.25, y = v;
    color c = mix(rgb(0x14120e), rgb(0x5a5238), smoothstep(1.1, 0.1, hypot(x - 0.3, y - 0.85)));
    c = shade(c, 1 + 0.3 * fractal(u * 4, v * 4, 4096, 4, 121));
    if (y < 0.27) { /* a cloth */
        const double fold = fractal(x * 3 + 2 * y, y * 3 - x, 4096, 4, 123);
        c = mix(rgb(0x746a58), rgb(0xf4ead6), clamp01(0.72 + 1.3 * fold - 0.4 * (x - 0.5) - 0.8 * (0.2 - y)));
        if (y < 0.10 + 0.03 * sin(7 * x))
            c = shade(mix(rgb(0x3a1d10), rgb(0x6f3b1d), 0.5 + fractal(x * 2, y * 30, 4096, 3, 125)), 0.9);
    }
    c = shade(c, 1 - 0.7 * oval(x - 0.80, y - 0.235, 0.36, 0.055, 0.6)); /* what it all stands in */
    c = shade(c, 1 - 0.6 * oval(x - 0.36, y - 0.225, 0.20, 0.04, 0.6));
    c = jug(c, x - 0.30, y - 0.215);
    const double bowl = hypot((x - 0.75) / 0.27, (y - 0.40) / 0.175);
    for (int i = 0; i < 5; i++)
        c = ball(c, (x - balls[i].x) / balls[i].r, (y - balls[i].y - 0.02) / balls[i].r, rgb(balls[i].hue),
                 balls[i].shine);
    if (bowl < 1 && y < 0.40 - 0.10 * cos(4 * (x - 0.75))) {
        c = mix(rgb(0x2a1a10), rgb(0xc08a4e), clamp01(0.75 - 2.2 * (x - 0.66) + 0.8 * (y - 0.30)));
        c = shade(c, 1 - 0.25 * (fabs(sin(60 * (y + 0.3 * pow(x - 0.75, 2)))) > 0.9));
    }
    for (int i = 0; i < 22; i++) { /* grapes hang over the rim */
        const double gx = 0.515 + 0.10 * (hash01(i, 0, 127) - 0.5) * (1 - 0.025 * i), gy = 0.42 - 0.0085 * i;
        c = ball(c, (x - gx) / 0.026, (y - gy) / 0.027, mix(rgb(0x2d1a3e), rgb(0x5a3566), hash01(i, 1, 127)), 0.9);
    }
    for (int i = 5; i < 7; i++)
        c = ball(c, (x - balls[i].x - (i == 5 ? 0.09 : 0.06)) / balls[i].r, (y - balls[i].y + 0.06) / balls[i].r,
                 rgb(balls[i].hue), balls[i].shine);
    return c;
}

/* ---- a composition of circles, wedges and lines ---- */

static color composition(double u, double v)
{
    static const struct {
        double x, y, r;
        int hue;
    } discs[] = {{0.33, 0.66, 0.235, 0xd9a520}, {0.33, 0.66, 0.165, 0xc0392b}, {0.33, 0.66, 0.095, 0x1d2d50},
                 {0.70, 0.34, 0.165, 0x2a6f7f}, {0.70, 0.34, 0.10, 0xefe3c2},  {0.70, 0.34, 0.05, 0x1a1a1a},
                 {0.80, 0.79, 0.075, 0xc0392b}, {0.17, 0.22, 0.085, 0x3f5f9f}, {0.52, 0.14, 0.045, 0xd9a520}};
    const double grain = 1 + 0.045 * fractal(u * 40, v * 40, 4096, 3, 131) + 0.02 * noise(u * 200, v * 200, 4096, 3);
    color c = mix(rgb(0xf1e6cb), rgb(0xdcc9a0), 0.5 + fractal(u * 3, v * 3, 4096, 3, 133));
    const double wedge = v - 0.05 - 1.25 * (u - 0.1), other = v - 0.98 + 0.42 * (u - 0.05);
    if (wedge > 0 && wedge < 0.16 * (1 - u) && u > 0.06) c = mix(c, rgb(0x1f1f1f), 0.9);
    if (other < 0 && other > -0.10 * u && u > 0.3) c = mix(c, rgb(0x7f9f8f), 0.8);
    for (int i = 0; i < 9; i++) {
        const double d = hypot(u - discs[i].x, v - discs[i].y) - discs[i].r;
        color hue = rgb(discs[i].hue);
        if (wedge > 0 && wedge < 0.16 * (1 - u)) hue = mix(hue, rgb(0xf7efdc), 0.35); /* where shapes cross */
        c = mix(c, hue, 0.93 * smoothstep(0.003, -0.003, d));
    }
    for (int i = 0; i < 5; i++) { /* a fan of lines, and a ladder */
        const double a = 0.35 + 0.11 * i, d = fabs((u - 0.58) * sin(a) - (v - 0.46) * cos(a));
        if (u > 0.58 && u < 0.97) c = mix(c, rgb(0x1a1a1a), smoothstep(0.005, 0.003, d));
        if (u > 0.08 && u < 0.36)
            c = mix(c, rgb(0x1a1a1a), smoothstep(0.0045, 0.0025, fabs(v - 0.33 - 0.018 * i - 0.22 * (u - 0.1))));
    }
    for (int i = 0; i < 12; i++) { /* a small board */
        const double bx = (u - 0.55) / 0.045 - i % 4, by = (v - 0.60) / 0.045 - i / 4;
        if (bx > 0 && bx < 1 && by > 0 && by < 1) c = (i + i / 4) % 2 ? rgb(0x1d2d50) : rgb(0xe7d7ad);
    }
    return shade(c, grain);
}

/* ---- a night of whirls ---- */

static const double whirls[4][3] = {{0.42, 0.66, 0.17}, {0.63, 0.58, 0.12}, {0.17, 0.80, 0.11}, {0.86, 0.80, 0.13}};

static double whirling(double u, double v)
{
    double x = 1, y = 0.35 * sin(5 * u);
    for (int i = 0; i < 4; i++) {
        const double dx = (u - whirls[i][0]) * 1.3, dy = v - whirls[i][1], d = hypot(dx, dy) + 1e-6;
        const double pull = 3.2 * exp(-pow(d / (1.3 * whirls[i][2]), 2)) * (i % 2 ? -1 : 1);
        x += -dy / d * pull, y += dx / d * pull;
    }
    return v < 0.3 ? 0.25 * sin(9 * u) : atan2(y, x);
}

static color night(double u, double v)
{
    const double hill = 0.30 + 0.07 * sin(4 * u + 1) + 0.02 * fractal(u * 5, 0, 4096, 3, 141);
    color c = mix(rgb(0x7fa6b8), rgb(0x1b2f6b), smoothstep(0.25, 0.75, v));
    const double band = 0.5 + 0.5 * sin(34 * (v - 0.06 * sin(6 * u)) + 6 * fractal(u * 3, v * 3, 4096, 3, 143));
    c = mix(c, mix(rgb(0x2b58a8), rgb(0xa9c6cf), band), 0.45 * smoothstep(0.85, 0.5, v));
    for (int i = 0; i < 4; i++) {
        const double dx = (u - whirls[i][0]) * 1.3, dy = v - whirls[i][1], d = hypot(dx, dy) / whirls[i][2],
                     a = atan2(dy, dx);
        const double arm = 0.5 + 0.5 * sin((i % 2 ? -2 : 2) * a + 9 * d);
        c = mix(c, mix(rgb(0x35619f), rgb(0xdfe4c8), arm), 0.85 * exp(-d * d * 0.9));
    }
    for (int i = 0; i < 9; i++) { /* stars, and the moon */
        const double x = i == 8 ? 0.90 : 0.06 + 0.115 * i, y = i == 8 ? 0.88 : 0.62 + 0.33 * hash01(i, 0, 147);
        const double d = hypot((u - x) * 1.3, v - y) / (i == 8 ? 0.075 : 0.028 + 0.022 * hash01(i, 1, 147));
        c = mix(c, mix(rgb(0xf6e9a0), rgb(0xf2b632), clamp01(d)), exp(-d * d * 0.75));
        c = mix(c, rgb(0xf4e08a), 0.35 * exp(-pow((d - 1.9) / 0.3, 2)));
    }
    if (v < hill) c = mix(rgb(0x12203d), rgb(0x3f6a78), 0.5 + 0.5 * sin(60 * (hill - v) + 5 * u));
    for (int i = 0; i < 11; i++) { /* the village */
        const double x = u - 0.36 - 0.052 * i, base = 0.12 + 0.03 * hash01(i, 2, 149),
                     high = 0.055 + 0.03 * hash01(i, 3, 149);
        if (fabs(x) < 0.021 && v > base && v < base + high)
            c = hash01((int)(u * 90), (int)(v * 60), 151) > 0.80 ? rgb(0xf5c04a) : rgb(0x263a55);
        if (v > base + high && v < base + high + 0.04 - 1.6 * fabs(x)) c = rgb(0x5a3a35);
    }
    const double spire = u - 0.60;
    if (v > 0.13 && v < 0.40 - 14 * fabs(spire) && fabs(spire) < 0.018) c = rgb(0x1d2c44);
    const double tree = fabs(u - 0.11 - 0.018 * sin(16 * v)) / (0.075 * pow(clamp01(1 - v / 0.93), 0.6) + 1e-6);
    if (v < 0.93)
        c = mix(c, mix(rgb(0x0d140e), rgb(0x39452a), 0.5 + 0.5 * sin(90 * (u + 0.15 * sin(11 * v)))),
                smoothstep(1.05, 0.9, tree));
    return c;
}

/* ---- water lilies ---- */

static color lilies(double u, double v)
{
    const double x = u * 2, deep = fractal(x * 2.2, v * 1.4, 4096, 4, 161),
                 drop = fractal(x * 7, v * 1.6, 4096, 4, 163);
    color c = mix(rgb(0x2e4f63), rgb(0x7fa3a0), clamp01(0.35 + 0.5 * v + 1.2 * deep));
    c = mix(c, rgb(0x3c5a33), smoothstep(0.05, 0.40, drop + 0.25 * (v - 0.45))); /* willows, mirrored */
    c = mix(c, rgb(0xc9a9c4), 0.8 * smoothstep(0.12, 0.45, fractal(x * 2 + 5, v * 2.4, 4096, 4, 167))); /* and clouds */
    for (int i = 0; i < 60; i++) {
        const int group = i / 10;
        const double gy = 0.10 + 0.135 * group + 0.04 * hash01(group, 0, 171), size = 1.25 - 0.95 * gy;
        const double gx = 2 * hash01(group, 1, 175), px = gx + 0.62 * size * (hash01(i, 2, 171) - 0.5),
                     py = gy + 0.11 * size * (hash01(i, 3, 171) - 0.5);
        const double dx = (x - px) / (0.095 * size), dy = (v - py) / (0.026 * size), a = atan2(dy, dx);
        const double d = hypot(dx, dy) + 0.08 * sin(5 * a + i), cut = fabs(a - 2.2 * hash01(i, 4, 171));
        if (d < 1 && cut > 0.22)
            c = mix(rgb(0x35603c), rgb(0xa9c487), clamp01(0.35 + 0.4 * dy + 0.5 * hash01(i, 5, 171)));
        if (hash01(i, 6, 171) > 0.66) { /* a flower */
            const double fx = (x - px) / (0.034 * size), fy = (v - py - 0.016 * size) / (0.024 * size),
                         f = hypot(fx, fy);
            if (f < 0.8 + 0.25 * cos(7 * atan2(fy, fx)))
                c = mix(rgb(0xfbf0e4), i % 3 ? rgb(0xd9738f) : rgb(0xe9d9a0), clamp01(f * 0.9 - 0.1 * fy));
            if (f < 0.25) c = rgb(0xf2c53a);
        }
    }
    return c;
}

/* ---- a ship in a gale ---- */

/* Along the waves, and up the masts. */
static double swell(double u, double v)
{
    if (fabs(u - 0.64) < 0.13 && v > 0.45 && v < 0.85) return 1.4;
    return 0.5 * sin(11 * u + 6 * v) + 0.4 * noise(u * 4, v * 4, 4096, 181);
}

static color gale(double u, double v)
{
    const double x = u * 1.5;
    color c = mix(rgb(0xd8c79a), rgb(0x3a4655), smoothstep(0.35, 0.95, v + 0.35 * fractal(x * 2, v * 3, 4096, 5, 183)));
    c = mix(c, rgb(0xf7ecc8), exp(-pow(hypot(x - 0.42, v - 0.60) / 0.20, 2)));
    const double sx = x - 0.92 - 0.16 * (v - 0.4), sy = v - 0.33; /* the ship heels */
    if (sy > 0 && sy < 0.10 && fabs(sx) < 0.14 + 0.5 * sy - 0.9 * pow(clamp01(0.08 - sy), 2))
        c = mix(rgb(0x1a120c), rgb(0x6b4526), clamp01(0.5 - 3 * sx));
    for (int m = -1; m <= 1; m++) {
        const double mx = sx - 0.09 * m, high = 0.44 - 0.06 * abs(m);
        for (int k = 0; k < 3; k++) {
            const double low = 0.13 + 0.105 * k, t = (sy - low) / 0.092, wide = 0.052 - 0.011 * k;
            if (t > 0 && t < 1 && sy < high && fabs(mx + 0.02 * sin(M_PI * t)) < wide * (1 - 0.18 * t))
                c = mix(rgb(0x8a7553), rgb(0xf5e8c8), clamp01(0.65 - 7 * mx + 0.3 * sin(M_PI * t)));
        }
        if (fabs(mx) < 0.0045 && sy > 0.08 && sy < high + 0.02) c = rgb(0x1d140d);
    }
    for (int i = 0; i < 5; i++) { /* waves, from the far ones to the near */
        const double k = 5.5 - 0.75 * i, p = k * x + 1.9 * i,
                     crest = 0.41 - 0.085 * i + (0.018 + 0.013 * i) * (sin(p) + 0.45 * sin(2 * p + 0.8)) +
                             0.014 * fractal(x * 9, i, 4096, 4, 187);
        if (v > crest) continue;
        const double depth = crest - v, foam = fractal(x * 14, v * 30 + 9 * i, 4096, 4, 189);
        c = mix(rgb(0x9fb39a), rgb(0x17303a), smoothstep(0, 0.11, depth));
        c = mix(c, rgb(0x3f6f6a), 0.6 * smoothstep(0.05, 0.3, foam));
        c = mix(c, rgb(0xf3efe0),
                smoothstep(0.022 + 0.006 * i, 0.002, depth + 0.05 * foam) * smoothstep(-0.7, 0.8, sin(p + 0.5)));
        c = mix(c, rgb(0xe9d9a6), 0.35 * exp(-pow((x - 0.42) / 0.16, 2)) * smoothstep(0.1, 0.4, foam));
    }
    return c;
}

/* ---- fields of colour ---- */

static color fields(double u, double v)
{
    static const struct {
        double low, high;
        int hue;
    } field[] = {{0.06, 0.34, 0xd98a1f}, {0.385, 0.455, 0xf0d9a8}, {0.50, 0.94, 0xb3261e}};
    color c = shade(rgb(0x5b1a1f), 1 + 0.25 * fractal(u * 4, v * 4, 4096, 4, 191));
    for (int i = 0; i < 3; i++) {
        const double rag = 0.02 * fractal(u * 9 + i, v * 9, 4096, 4, 193),
                     wash = fractal(u * 3 + i, v * 5, 4096, 5, 195);
        const double e = fmin(fmin(u - 0.07, 0.93 - u) * 0.8, fmin(v - field[i].low, field[i].high - v)) + rag;
        c = mix(c, shade(rgb(field[i].hue), 1 + 0.30 * wash), 0.94 * smoothstep(-0.012, 0.022, e));
    }
    return shade(c, 1 + 0.03 * noise(u * 160, v * 200, 4096, 3));
}

bool generate_paintings(const char *root)
{
    return paint(root, "assets/textures/gallery/valley.jpg", &(brush){valley, shore, 1.5, 56, 201}) &&
           paint(root, "assets/textures/gallery/lady.jpg", &(brush){lady, slanted, 0.78, 66, 221}) &&
           paint(root, "assets/textures/gallery/fruit.jpg", &(brush){fruit, slanted, 1.25, 60, 241}) &&
           paint(root, "assets/textures/gallery/night.jpg", &(brush){night, whirling, 1.3, 40, 261}) &&
           paint(root, "assets/textures/gallery/lilies.jpg", &(brush){lilies, level, 2, 46, 281}) &&
           paint(root, "assets/textures/gallery/gale.jpg", &(brush){gale, swell, 1.5, 50, 301}) &&
           paint_square(root, "assets/textures/gallery/composition.jpg", 512, composition) &&
           paint_square(root, "assets/textures/gallery/fields.jpg", 256, fields);
}
