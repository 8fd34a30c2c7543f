/* Skies of six images. The images are as seen from within, turned as the faces of cube maps are everywhere (OpenGL 4.6,
 * 8.13), with z mirrored, since its coordinates are left-handed there: so sets of six join at their edges.
 *
 * Each face is kept with a frame of texels one wide, copies of those beside it on the other faces, so that bilinear
 * filtering on a face takes in its neighbours. Both faces at an edge then see the mean of the same two texels on it; at
 * a corner, where only three texels meet, the fourth is their mean. So there are no seams. */
#include "image/color.h"
#include "image/image.h"
#include "math/trig.h"

#include <math.h>
#include <string.h>

/* Of a face: the direction of its middle, and those in which x and y of its image grow. */
typedef struct axes {
    double middle[3], right[3], down[3];
} axes;

static const axes FACES[6] = {
    {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}},
    {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}, {{0, 0, -1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}},
};

daft_dvec3 daft_cube_direction(int face, double x, double y)
{
    const axes *a = &FACES[face];
    const double s = 2 * x - 1, t = 2 * y - 1;
    return (daft_dvec3){a->middle[0] + s * a->right[0] + t * a->down[0],
                        a->middle[1] + s * a->right[1] + t * a->down[1],
                        a->middle[2] + s * a->right[2] + t * a->down[2]};
}

static double along(const double axis[3], daft_dvec3 d) { return axis[0] * d.x + axis[1] * d.y + axis[2] * d.z; }

/* The face in a direction, and the place in it: 0 to 1 from its upper left corner. */
static int face_in(daft_dvec3 d, double *x, double *y)
{
    const double ax = fabs(d.x), ay = fabs(d.y), az = fabs(d.z);
    const int face = ax >= ay && ax >= az ? (d.x < 0 ? 1 : 0) : ay >= az ? (d.y < 0 ? 3 : 2) : (d.z > 0 ? 5 : 4);
    const axes *a = &FACES[face];
    const double depth = along(a->middle, d);
    *x = 0.5 * (along(a->right, d) / depth + 1), *y = 0.5 * (along(a->down, d) / depth + 1);
    return face;
}

/* Texel x, y of a face; -1 and `side` are the frame's. */
static float *texel_of(const daft_sky_image *sky, int face, int x, int y)
{
    return sky->texels + 3 * ((size_t)(face * sky->width + y + 1) * (size_t)sky->width + (size_t)(x + 1));
}

static int place_of(double x, int side) { return daft_max_i(0, daft_min_i((int)(x * side), side - 1)); }

/* The texel beside x, y of the frame: that on the other face which its middle is seen in. */
static void copy_beside(const daft_sky_image *sky, int face, int x, int y)
{
    const int side = sky->width - 2;
    double u, v;
    const int other = face_in(daft_cube_direction(face, (x + 0.5) / side, (y + 0.5) / side), &u, &v);
    memcpy(texel_of(sky, face, x, y), texel_of(sky, other, place_of(u, side), place_of(v, side)), 3 * sizeof(float));
}

/* x and y: -1 or `side`. */
static void fill_corner(const daft_sky_image *sky, int face, int x, int y)
{
    const int side = sky->width - 2, inside_x = x < 0 ? 0 : side - 1, inside_y = y < 0 ? 0 : side - 1;
    const float *a = texel_of(sky, face, inside_x, inside_y), *b = texel_of(sky, face, x, inside_y),
                *c = texel_of(sky, face, inside_x, y);
    float *to = texel_of(sky, face, x, y);
    for (int k = 0; k < 3; k++) to[k] = (a[k] + b[k] + c[k]) * (1.0f / 3);
}

static void frame_faces(const daft_sky_image *sky)
{
    const int side = sky->width - 2;
    for (int face = 0; face < 6; face++) {
        for (int i = 0; i < side; i++) {
            copy_beside(sky, face, i, -1), copy_beside(sky, face, i, side);
            copy_beside(sky, face, -1, i), copy_beside(sky, face, side, i);
        }
        for (int k = 0; k < 4; k++) fill_corner(sky, face, k & 1 ? side : -1, k & 2 ? side : -1);
    }
}

static bool check_face(const daft_sky_image *face, const char *path, int side, daft_error *error)
{
    if (face->width != face->height)
        return daft_fail_at(error, DAFT_ERROR_UNSUPPORTED, path, 0, 0,
                            "the image is %d by %d pixels; those of a cube are square", face->width, face->height);
    if (face->width > DAFT_MAX_CUBE_SIDE)
        return daft_fail_at(error, DAFT_ERROR_UNSUPPORTED, path, 0, 0,
                            "the image is %d pixels a side; those of a cube have at most %d", face->width,
                            DAFT_MAX_CUBE_SIDE);
    return face->width == side ||
           daft_fail_at(error, DAFT_ERROR_UNSUPPORTED, path, 0, 0,
                        "the image is %d pixels a side, but the first of the cube %d", face->width, side);
}

/* Puts an image into its place; the first makes room for all. */
static bool take_face(const daft_allocator *allocator, const daft_sky_image *face, int number, const char *path,
                      daft_sky_image *out, daft_error *error)
{
    const int side = face->width;
    if (!check_face(face, path, number ? out->width - 2 : side, error)) return false;
    if (number == 0) {
        const size_t width = (size_t)side + 2;
        float *texels = daft_alloc(allocator, 6 * 3 * width * width, sizeof *texels);
        if (!texels) return daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0, "out of memory for the sky");
        *out = (daft_sky_image){.width = side + 2, .height = 6 * (side + 2), .texels = texels, .cube = true};
    }
    for (int y = 0; y < side; y++)
        memcpy(texel_of(out, number, 0, y), face->texels + 3 * (size_t)y * (size_t)side,
               3 * (size_t)side * sizeof *out->texels);
    return true;
}

bool daft_sky_decode_cube(const daft_allocator *allocator, const daft_image_file files[6], daft_sky_image *out,
                          daft_error *error)
{
    *out = (daft_sky_image){0};
    for (int i = 0; i < 6; i++) {
        daft_sky_image face;
        bool done = daft_sky_decode(allocator, &files[i], &face, error);
        if (done) {
            done = take_face(allocator, &face, i, files[i].path, out, error);
            daft_sky_free(allocator, &face);
        }
        if (done) continue;
        daft_sky_free(allocator, out);
        return false;
    }
    frame_faces(out);
    return true;
}

/* ---- as one image all around ---- */

/* Between the four texels around a direction; the frame has those beyond the face. */
static void look(const daft_sky_image *cube, daft_dvec3 d, float out[3])
{
    double u, v;
    const int side = cube->width - 2, face = face_in(d, &u, &v);
    const float x = (float)(u * side - 0.5), y = (float)(v * side - 0.5);
    const int left = daft_max_i(-1, daft_min_i((int)floorf(x), side - 1)),
              top = daft_max_i(-1, daft_min_i((int)floorf(y), side - 1));
    const float s = x - (float)left, t = y - (float)top;
    const float *a = texel_of(cube, face, left, top), *b = texel_of(cube, face, left, top + 1);
    for (int k = 0; k < 3; k++) {
        const float above = a[k] + s * (a[k + 3] - a[k]), below = b[k] + s * (b[k + 3] - b[k]);
        out[k] = above + t * (below - above);
    }
}

void daft_cube_unroll(const daft_sky_image *cube, int width, int height, uint8_t *texels)
{
    const double pi = 3.14159265358979323846;
    daft_srgb_table table;
    daft_srgb_table_make(&table);
    for (int y = 0; y < height; y++) {
        const double up = pi * (0.5 - (y + 0.5) / height), level = daft_cos(up), above = daft_sin(up);
        for (int x = 0; x < width; x++) {
            const double around = 2 * pi * ((x + 0.5) / width - 0.5);
            float light[3];
            look(cube, daft_dv3(level * daft_cos(around), above, level * daft_sin(around)), light);
            uint8_t *to = texels + 4 * ((size_t)y * (size_t)width + (size_t)x);
            for (int k = 0; k < 3; k++) to[k] = daft_srgb_byte(&table, light[k]);
            to[3] = 255;
        }
    }
}
