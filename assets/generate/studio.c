/* The scene `studio`: metals from polished to rough, frosted glass, and a waxed floor that shows them. */
#include "mesh.h"

#include <math.h>

static void floor_tiles(mesh *m)
{
    const double r = 7;
    use_material(m, "floor");
    add_panel(m, (const vec[]){v3(-r, 0, r), v3(r, 0, r), v3(r, 0, -r), v3(-r, 0, -r)}, 0, 0, 5, 5);
}

/* A wall of coloured panels behind it all, for the metals to show. */
static void screen(mesh *m)
{
    static const char *const names[] = {"plum", "ochre", "teal", "cream"};
    for (int i = 0; i < 8; i++) {
        const double x = -7 + 1.75 * i, high = 2.6 + 0.5 * (i % 3);
        use_material(m, names[(i * 3 + i / 4) % 4]);
        add_box(m, v3(x, 0, -7), v3(x + 1.7, high, -6.8), 1);
    }
}

static void vase(mesh *m)
{
    static const double profile[][2] = {
        {0, 0.02},    {0.26, 0},    {0.28, 0.02}, {0.24, 0.06}, {0.34, 0.25}, {0.42, 0.50}, {0.38, 0.78}, {0.22, 1.0},
        {0.14, 1.14}, {0.15, 1.24}, {0.22, 1.34}, {0.22, 1.34}, {0.20, 1.35}, {0.13, 1.24}, {0.12, 1.14}, {0, 1.0}};
    use_material(m, "copper");
    add_lathe(m, profile, 16, 64, 0);
}

static void frosted_block(mesh *m)
{
    const vec low = v3(-0.75, 0.02, -0.06), high = v3(0.75, 1.5, 0.06);
    use_material(m, "frosted");
    add_box(m, low, high, 1);
    add_flat(m,
             (const vec[]){v3(low.x, low.y, low.z), v3(high.x, low.y, low.z), v3(high.x, low.y, high.z),
                           v3(low.x, low.y, high.z)},
             4);
}

static const char materials[] =
    "# made by daft_generate, CC0\n"
    "newmtl floor\nKa 0.55 0.55 0.55\nKd 0.55 0.55 0.55\nKs 0.32 0.32 0.34\nNs 90\nPr 0.32\nillum 3\nmap_Kd "
    "../../textures/hall_floor.jpg\n\n"
    "newmtl polished\nKa 0.04 0.04 0.04\nKd 0.04 0.04 0.04\nKs 0.86 0.87 0.9\nNs 900\nillum 3\n\n"
    "newmtl satin\nKa 0.04 0.04 0.04\nKd 0.04 0.04 0.04\nKs 0.86 0.87 0.9\nNs 300\nPr 0.2\nillum 3\n\n"
    "newmtl brushed\nKa 0.05 0.05 0.05\nKd 0.05 0.05 0.05\nKs 0.82 0.83 0.86\nNs 120\nPr 0.38\nillum 3\n\n"
    "newmtl blasted\nKa 0.06 0.06 0.06\nKd 0.06 0.06 0.06\nKs 0.78 0.79 0.82\nNs 30\nPr 0.62\nillum 3\n\n"
    "newmtl brass\nKa 0.08 0.06 0.02\nKd 0.08 0.06 0.02\nKs 0.9 0.68 0.3\nNs 200\nPr 0.28\nillum 3\n\n"
    "newmtl copper\nKa 0.08 0.04 0.03\nKd 0.08 0.04 0.03\nKs 0.92 0.55 0.4\nNs 100\nPr 0.34\nillum 3\n\n"
    "newmtl frosted\nKa 0 0 0\nKd 0 0 0\nKs 0.5 0.5 0.5\nNs 100\nNi 1.5\nTf 0.88 0.97 0.94\nPr 0.34\nillum 7\n\n"
    "newmtl plum\nKa 0.36 0.10 0.22\nKd 0.36 0.10 0.22\nKs 0 0 0\nillum 1\n\n"
    "newmtl ochre\nKa 0.78 0.48 0.12\nKd 0.78 0.48 0.12\nKs 0 0 0\nillum 1\n\n"
    "newmtl teal\nKa 0.08 0.36 0.38\nKd 0.08 0.36 0.38\nKs 0 0 0\nillum 1\n\n"
    "newmtl cream\nKa 0.80 0.76 0.64\nKd 0.80 0.76 0.64\nKs 0 0 0\nillum 1\n";

bool generate_studio(const char *root)
{
    static const mesh_recipe list[] = {
        {"assets/meshes/studio/floor.obj", floor_tiles},
        {"assets/meshes/studio/screen.obj", screen},
        {"assets/meshes/studio/vase.obj", vase},
        {"assets/meshes/studio/block.obj", frosted_block},
    };
    return write_text(root, "assets/meshes/studio/studio.mtl", materials) &&
           write_meshes(root, list, sizeof list / sizeof list[0], "studio.mtl");
}
