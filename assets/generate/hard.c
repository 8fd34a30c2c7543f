/* assets/scenes/hard: meshes of the scenes whose difficulty is numerical. Plain shapes with few triangles; the scenes
 * beside them put them where floats are short of digits. */
#include "generate.h"

enum { NEEDLES = 150, STRIPES = 16 };

static FILE *begin(const char *root, const char *path, const char *material)
{
    FILE *f = open_output(root, path);
    if (f) fprintf(f, "# made by daft_generate, CC0\nmtllib hard.mtl\nusemtl %s\n", material);
    return f;
}

/* Slim three-sided pyramids, 17 mm wide and up to 3 m tall, on a square of 16 m: from nearby they are pixels wide, from
 * afar a small part of one. */
static bool needles(const char *root)
{
    const char *path = "assets/scenes/hard/needles.obj";
    FILE *f = begin(root, path, "bone");
    if (!f) return false;
    for (int i = 0; i < NEEDLES; i++) {
        double x = 16 * hash01(i, 0, 3) - 8, z = 16 * hash01(i, 1, 3) - 8, tall = 1.5 + 1.5 * hash01(i, 2, 3);
        double lean_x = 0.3 * hash01(i, 3, 3) - 0.15, lean_z = 0.3 * hash01(i, 4, 3) - 0.15;
        fprintf(f, "v %.4f 0 %.4f\nv %.4f 0 %.4f\nv %.4f 0 %.4f\nv %.4f %.4f %.4f\n", x + 0.01, z, x - 0.005,
                z - 0.0087, x - 0.005, z + 0.0087, x + lean_x, tall, z + lean_z);
    }
    for (int i = 0; i < NEEDLES; i++) {
        int a = 4 * i + 1, b = a + 1, c = a + 2, top = a + 3;
        fprintf(f, "f %d %d %d\nf %d %d %d\nf %d %d %d\nf %d %d %d\n", b, a, top, c, b, top, a, c, top, a, b, c);
    }
    return close_output(f, path);
}

/* Upright strips of half their pitch on the square -1..1 of y and z, seen from -x. */
static bool stripes(const char *root)
{
    const char *path = "assets/scenes/hard/stripes.obj";
    FILE *f = begin(root, path, "red");
    if (!f) return false;
    for (int i = 0; i < STRIPES; i++) {
        double a = -1 + 2.0 * i / STRIPES, b = a + 1.0 / STRIPES;
        fprintf(f, "v 0 -1 %g\nv 0 -1 %g\nv 0 1 %g\nv 0 1 %g\n", a, b, b, a);
    }
    for (int i = 0; i < STRIPES; i++) fprintf(f, "f %d %d %d %d\n", 4 * i + 1, 4 * i + 2, 4 * i + 3, 4 * i + 4);
    return close_output(f, path);
}

/* The whole square, in one piece: a wall facing -x, or a ground facing up. */
static bool square(const char *root, const char *path, const char *material, bool ground)
{
    static const int SIGN[4][2] = {{-1, -1}, {-1, 1}, {1, 1}, {1, -1}};
    FILE *f = begin(root, path, material);
    if (!f) return false;
    for (int i = 0; i < 4; i++) {
        int a = SIGN[i][0], b = SIGN[i][1];
        if (ground)
            fprintf(f, "v %d 0 %d\n", a, b);
        else
            fprintf(f, "v 0 %d %d\n", a, b);
    }
    fputs("f 1 2 3 4\n", f);
    return close_output(f, path);
}

/* Corner i has bit k of i set where its k-th coordinate is the high one. */
static bool block(const char *root, const char *path, const char *material, const double low[3], const double high[3])
{
    FILE *f = begin(root, path, material);
    if (!f) return false;
    for (int i = 0; i < 8; i++)
        fprintf(f, "v %g %g %g\n", (i & 1 ? high : low)[0], (i & 2 ? high : low)[1], (i & 4 ? high : low)[2]);
    fputs("f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n", f);
    return close_output(f, path);
}

bool generate_hard(const char *root)
{
    static const double CUBE[2][3] = {{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}},
                        RIDGE[2][3] = {{-0.005, -1, -0.01}, {0, 1, 0.01}};
    return needles(root) && stripes(root) && square(root, "assets/scenes/hard/wall.obj", "green", false) &&
           square(root, "assets/scenes/hard/ground.obj", "sand", true) &&
           block(root, "assets/scenes/hard/cube.obj", "bone", CUBE[0], CUBE[1]) &&
           block(root, "assets/scenes/hard/ridge.obj", "red", RIDGE[0], RIDGE[1]);
}
