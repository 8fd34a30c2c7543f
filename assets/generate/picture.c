/* Pictures: colours, painting with supersampling, PNG and JPEG out. */
#include "generate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb_image_write.h>
#pragma GCC diagnostic pop

color rgb(int hex) { return (color){(hex >> 16 & 255) / 255.0, (hex >> 8 & 255) / 255.0, (hex & 255) / 255.0}; }
double clamp01(double x) { return x < 0 ? 0 : x > 1 ? 1 : x; }
color mix(color a, color b, double t)
{
    t = clamp01(t);
    return (color){a.r + (b.r - a.r) * t, a.g + (b.g - a.g) * t, a.b + (b.b - a.b) * t};
}
color shade(color c, double factor) { return (color){c.r * factor, c.g * factor, c.b * factor}; }
double smoothstep(double low, double high, double x)
{
    double t = clamp01((x - low) / (high - low));
    return t * t * (3 - 2 * t);
}

static uint8_t to_byte(double x) { return (uint8_t)(clamp01(x) * 255 + 0.5); }

static void put_bytes(void *context, void *data, int size) { fwrite(data, 1, (size_t)size, (FILE *)context); }

static bool write_png(const char *root, const char *path, const picture *p)
{
    FILE *file = open_output(root, path);
    if (!file) return false;
    stbi_write_png_compression_level = 64; /* longer match chains: a tenth smaller, and time does not matter here */
    stbi_write_png_to_func(put_bytes, file, p->width, p->height, 3, p->pixels, p->width * 3);
    return close_output(file, path);
}

bool write_jpeg(const char *root, const char *path, const picture *p, int quality)
{
    FILE *file = open_output(root, path);
    if (!file) return false;
    stbi_write_jpg_to_func(put_bytes, file, p->width, p->height, 3, p->pixels, quality);
    return close_output(file, path);
}

bool write_hdr(const char *root, const char *path, int width, int height, const float *light)
{
    FILE *file = open_output(root, path);
    if (!file) return false;
    stbi_write_hdr_to_func(put_bytes, file, width, height, 3, light);
    return close_output(file, path);
}

/* The mean of 3×3 samples inside the pixel whose top left corner is (x, y). */
static color paint_pixel(painter *paint, int x, int y, int size)
{
    color sum = {0, 0, 0};
    for (int i = 0; i < 9; i++) {
        double u = (x + (i % 3 + 0.5) / 3) / size, v = 1 - (y + (i / 3 + 0.5) / 3) / size;
        color c = paint(u, v);
        sum.r += c.r / 9, sum.g += c.g / 9, sum.b += c.b / 9;
    }
    return sum;
}

bool paint_square(const char *root, const char *path, int size, painter *paint)
{
    picture p = {size, size, malloc((size_t)size * (size_t)size * 3)};
    if (!p.pixels) {
        fprintf(stderr, "%s: out of memory\n", path);
        return false;
    }
    uint8_t *out = p.pixels;
    for (int y = 0; y < size; y++) {
        for (int x = 0; x < size; x++) {
            color c = paint_pixel(paint, x, y, size);
            *out++ = to_byte(c.r), *out++ = to_byte(c.g), *out++ = to_byte(c.b);
        }
    }
    bool ok = strstr(path, ".jpg") ? write_jpeg(root, path, &p, 85) : write_png(root, path, &p);
    free(p.pixels);
    return ok;
}
