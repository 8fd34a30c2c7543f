/* The scene `wine`: glasses, a carafe and a tumbler, with what is in them. Liquids reach half a wall into their glass,
 * whose priority is higher, so that the two touch. In metres, as they are. */
#include "mesh.h"

enum { SIDES = 64 };
#define LATHE(m, profile) add_lathe(m, profile, sizeof profile / sizeof *profile, SIDES, 0)

static void wine_glass(mesh *m)
{
    static const double profile[][2] = {
        {0, 0},           {0.036, 0},       {0.036, 0},       {0.0365, 0.0012}, {0.030, 0.0035}, {0.014, 0.007},
        {0.006, 0.012},   {0.0042, 0.024},  {0.004, 0.060},   {0.0045, 0.080},  {0.009, 0.0885}, {0.020, 0.0985},
        {0.031, 0.112},   {0.0375, 0.130},  {0.040, 0.150},   {0.0385, 0.175},  {0.0345, 0.200}, {0.0325, 0.212},
        {0.0320, 0.2135}, {0.0313, 0.212},  {0.0332, 0.200},  {0.0371, 0.175},  {0.0386, 0.150}, {0.0361, 0.130},
        {0.0296, 0.1132}, {0.0188, 0.1003}, {0.0085, 0.0925}, {0, 0.0910}};
    use_material(m, "glass");
    LATHE(m, profile);
}

/* With a meniscus. */
static void fill_glass(mesh *m, const char *material)
{
    static const double profile[][2] = {{0, 0.0900},      {0.0088, 0.0908}, {0.0194, 0.0994}, {0.0303, 0.1126},
                                        {0.0368, 0.130},  {0.0391, 0.1467}, {0.0391, 0.1467}, {0.0380, 0.1463},
                                        {0.0360, 0.1460}, {0.030, 0.1460},  {0, 0.1460}};
    use_material(m, material);
    LATHE(m, profile);
}

static void red_wine(mesh *m) { fill_glass(m, "red_wine"); }

static void white_wine(mesh *m) { fill_glass(m, "white_wine"); }

static void rose_wine(mesh *m) { fill_glass(m, "rose_wine"); }

static void carafe(mesh *m)
{
    static const double profile[][2] = {
        {0, 0},          {0.055, 0},      {0.055, 0},       {0.058, 0.002},   {0.080, 0.018},
        {0.088, 0.040},  {0.082, 0.065},  {0.060, 0.095},   {0.036, 0.125},   {0.024, 0.155},
        {0.021, 0.190},  {0.023, 0.225},  {0.032, 0.250},   {0.0335, 0.2525}, {0.0310, 0.252},
        {0.0208, 0.226}, {0.0188, 0.190}, {0.0216, 0.155},  {0.0334, 0.126},  {0.0573, 0.0965},
        {0.0793, 0.066}, {0.0853, 0.041}, {0.0778, 0.0205}, {0.055, 0.0058},  {0, 0.0050}};
    use_material(m, "glass");
    LATHE(m, profile);
}

static void carafe_wine(mesh *m)
{
    static const double profile[][2] = {{0, 0.003},       {0.055, 0.0035},  {0.0788, 0.0193}, {0.0867, 0.0405},
                                        {0.0806, 0.0655}, {0.0735, 0.0752}, {0.0735, 0.0752}, {0.0718, 0.0746},
                                        {0.0690, 0.0742}, {0.060, 0.0742},  {0, 0.0742}};
    use_material(m, "red_wine");
    LATHE(m, profile);
}

static void tumbler(mesh *m)
{
    static const double profile[][2] = {{0, 0},           {0.030, 0},       {0.030, 0},      {0.032, 0.002},
                                        {0.0375, 0.0945}, {0.0370, 0.0955}, {0.036, 0.0945}, {0.0308, 0.010},
                                        {0.029, 0.0080},  {0, 0.0080}};
    use_material(m, "glass");
    LATHE(m, profile);
}

static void tumbler_water(mesh *m)
{
    static const double profile[][2] = {{0, 0.0060},      {0.0292, 0.0062}, {0.0316, 0.010},
                                        {0.0353, 0.0707}, {0.0353, 0.0707}, {0.0342, 0.0703},
                                        {0.032, 0.0700},  {0.026, 0.0700},  {0, 0.0700}};
    use_material(m, "water");
    LATHE(m, profile);
}

static void ice(mesh *m)
{
    const double r = 0.0115;
    use_material(m, "ice");
    add_box(m, v3(-r, -r, -r), v3(r, r, r), 1);
    add_flat(m, (const vec[]){v3(-r, -r, -r), v3(r, -r, -r), v3(r, -r, r), v3(-r, -r, r)}, 4);
}

static void table(mesh *m)
{
    use_material(m, "linen");
    add_box(m, v3(-0.62, -0.03, -0.5), v3(0.62, 0, 0.5), 1);
}

static const char materials[] =
    "# made by daft_generate, CC0\n"
    "# tint_distance, metres: the way within in which light takes on Tf. medium_priority: the higher one is there.\n"
    "newmtl glass\nKa 0 0 0\nKd 0 0 0\nKs 0.6 0.6 0.6\nNs 900\nNi 1.5\nTf 0.72 0.93 0.84\ntint_distance 0.1\n"
    "medium_priority 4\nillum 7\n\n"
    "newmtl ice\nKa 0 0 0\nKd 0 0 0\nKs 0.5 0.5 0.5\nNs 300\nNi 1.31\nmedium_priority 3\nillum 7\n\n"
    "newmtl red_wine\nKa 0 0 0\nKd 0 0 0\nKs 0.4 0.4 0.4\nNs 900\nNi 1.35\nTf 0.55 0.025 0.06\ntint_distance 0.025\n"
    "medium_priority 2\nillum 7\n\n"
    "newmtl rose_wine\nKa 0 0 0\nKd 0 0 0\nKs 0.4 0.4 0.4\nNs 900\nNi 1.35\nTf 0.96 0.5 0.42\ntint_distance 0.05\n"
    "medium_priority 2\nillum 7\n\n"
    "newmtl white_wine\nKa 0 0 0\nKd 0 0 0\nKs 0.4 0.4 0.4\nNs 900\nNi 1.35\nTf 0.97 0.86 0.4\ntint_distance 0.05\n"
    "medium_priority 2\nillum 7\n\n"
    "newmtl water\nKa 0 0 0\nKd 0 0 0\nKs 0.4 0.4 0.4\nNs 900\nNi 1.33\nTf 0.6 0.9 0.96\ntint_distance 1\n"
    "medium_priority 2\nillum 7\n\n"
    "newmtl linen\nKa 0.80 0.77 0.72\nKd 0.80 0.77 0.72\nKs 0 0 0\nillum 1\n";

bool generate_wine(const char *root)
{
    static const mesh_recipe list[] = {
        {"assets/meshes/wine/glass.obj", wine_glass}, {"assets/meshes/wine/red.obj", red_wine},
        {"assets/meshes/wine/white.obj", white_wine}, {"assets/meshes/wine/rose.obj", rose_wine},
        {"assets/meshes/wine/carafe.obj", carafe},    {"assets/meshes/wine/carafe_red.obj", carafe_wine},
        {"assets/meshes/wine/tumbler.obj", tumbler},  {"assets/meshes/wine/water.obj", tumbler_water},
        {"assets/meshes/wine/ice.obj", ice},          {"assets/meshes/wine/table.obj", table},
    };
    return write_text(root, "assets/meshes/wine/wine.mtl", materials) &&
           write_meshes(root, list, sizeof list / sizeof list[0], "wine.mtl");
}
