// tinyobjloader on the same file: triangulated, materials not looked for, as ours is timed without pictures.
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

extern "C" double bench_clock_ms(int threads);

static double load(const char *path, size_t *triangles)
{
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warning, error;
    double start = bench_clock_ms(1);
    if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, path, nullptr, true)) return -1;
    double ms = bench_clock_ms(1) - start;
    *triangles = 0;
    for (const tinyobj::shape_t &shape : shapes) *triangles += shape.mesh.num_face_vertices.size();
    return ms;
}

typedef double bench_obj_loader(const char *path, size_t *triangles);
extern "C" bench_obj_loader *bench_find_tinyobj(void) { return load; }
