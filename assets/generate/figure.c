/* A figure with a skeleton, and the clips idle, walk, run and wave, as one glTF file (.glb): assets/meshes/figure.glb.
 * It stands at the origin, 1.75 m high, and faces +Z. Each limb is a capsule whose first quarter follows its parent
 * half-way, so that elbows and knees bend. */
#include "generate.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

#define PI 3.14159265358979323846

enum { SIDES = 14, RINGS = 9, JOINTS = 13, MATERIALS = 4, KEYS = 13, MOST = 65536 };
enum { HIPS, CHEST, HEAD, ARM_L, FOREARM_L, ARM_R, FOREARM_R, THIGH_L, SHIN_L, FOOT_L, THIGH_R, SHIN_R, FOOT_R };
enum { SHIRT, SKIN, TROUSERS, SHOES };

typedef struct joint {
    const char *name;
    int parent;
    double at[3];
} joint;

static const joint SKELETON[JOINTS] = {{"hips", -1, {0, 0.95, 0}},
                                       {"chest", HIPS, {0, 1.15, 0}},
                                       {"head", CHEST, {0, 1.47, 0}},
                                       {"arm.L", CHEST, {0.2, 1.38, 0}},
                                       {"forearm.L", ARM_L, {0.27, 1.11, 0}},
                                       {"arm.R", CHEST, {-0.2, 1.38, 0}},
                                       {"forearm.R", ARM_R, {-0.27, 1.11, 0}},
                                       {"thigh.L", HIPS, {0.1, 0.9, 0}},
                                       {"shin.L", THIGH_L, {0.105, 0.5, 0}},
                                       {"foot.L", SHIN_L, {0.105, 0.09, -0.01}},
                                       {"thigh.R", HIPS, {-0.1, 0.9, 0}},
                                       {"shin.R", THIGH_R, {-0.105, 0.5, 0}},
                                       {"foot.R", SHIN_R, {-0.105, 0.09, -0.01}}};

typedef struct vertex {
    float position[3], normal[3];
    uint8_t joints[4], weights[4];
} vertex;

typedef struct part {
    vertex vertices[4096];
    uint16_t indices[24576];
    int vertex_count, index_count;
} part;

static part parts[MATERIALS];

/* ---- the skin ---- */

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void unit(double v[3])
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++) v[i] /= length;
}

/* along: 0 at the capsule's begin, 1 at its end. */
static void bind(vertex *v, int bone, double along)
{
    const int parent = SKELETON[bone].parent;
    const double half = parent < 0 || along > 0.3 ? 0 : 0.5 * (1 - (along > 0 ? along : 0) / 0.3);
    v->joints[0] = (uint8_t)bone, v->joints[1] = (uint8_t)(parent < 0 ? 0 : parent);
    v->weights[1] = (uint8_t)lrint(255 * half), v->weights[0] = (uint8_t)(255 - v->weights[1]);
}

/* A capsule from a to b with radii ra and rb, `wide` times as wide across as it is deep. */
static void capsule(int material, int bone, const double a[3], const double b[3], double ra, double rb, double wide)
{
    static const double UP[RINGS] = {-90, -60, -30, 0, 0, 0, 30, 60, 90}, ALONG[RINGS] = {0, 0, 0, 0, 0.5, 1, 1, 1, 1};
    part *p = &parts[material];
    double axis[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, side[3], depth[3] = {0, 0, 1};
    const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    unit(axis);
    if (fabs(axis[2]) > 0.9) depth[2] = 0, depth[1] = 1;
    cross(axis, depth, side), unit(side), cross(side, axis, depth);
    const int first = p->vertex_count;
    for (int r = 0; r < RINGS; r++)
        for (int k = 0; k < SIDES; k++) {
            const double angle = 2 * PI * k / SIDES, up = UP[r] * PI / 180, t = ALONG[r], radius = ra + (rb - ra) * t;
            vertex *v = &p->vertices[p->vertex_count++];
            double n[3];
            for (int i = 0; i < 3; i++) {
                const double x = cos(up) * cos(angle) * side[i], z = cos(up) * sin(angle) * depth[i];
                v->position[i] = (float)(a[i] + axis[i] * (length * t + radius * sin(up)) + radius * (wide * x + z));
                n[i] = x / wide + z + axis[i] * (sin(up) + (ra - rb) / (length + 1e-9) * cos(up));
            }
            unit(n);
            for (int i = 0; i < 3; i++) v->normal[i] = (float)n[i];
            bind(v, bone, t + radius * sin(up) / (length + 1e-9));
        }
    for (int r = 0; r + 1 < RINGS; r++)
        for (int k = 0; k < SIDES; k++) {
            const uint16_t c = (uint16_t)(first + r * SIDES + k), d = (uint16_t)(first + r * SIDES + (k + 1) % SIDES);
            const uint16_t e = (uint16_t)(c + SIDES), f = (uint16_t)(d + SIDES);
            const uint16_t one[3] = {c, d, f}, two[3] = {c, f, e};
            if (r > 0)
                memcpy(p->indices + p->index_count, one, sizeof one), p->index_count += 3; /* a pole is one place */
            if (r + 2 < RINGS) memcpy(p->indices + p->index_count, two, sizeof two), p->index_count += 3;
        }
}

static void limb(int material, int bone, double x, double y, double z, double ra, double rb)
{
    capsule(material, bone, SKELETON[bone].at, (double[3]){x, y, z}, ra, rb, 1);
}

static void body(void)
{
    capsule(TROUSERS, HIPS, (double[3]){0, 0.92, 0}, (double[3]){0, 1.0, 0}, 0.115, 0.11, 1.45);
    capsule(SHIRT, CHEST, (double[3]){0, 1.07, 0}, (double[3]){0, 1.33, 0}, 0.112, 0.125, 1.5);
    capsule(SKIN, HEAD, (double[3]){0, 1.44, 0}, (double[3]){0, 1.52, 0}, 0.05, 0.05, 1);
    capsule(SKIN, HEAD, (double[3]){0, 1.6, 0.01}, (double[3]){0, 1.645, 0.01}, 0.1, 0.105, 0.9);
    for (int s = 0; s < 2; s++) {
        const double x = s ? -1 : 1;
        const int arm = s ? ARM_R : ARM_L, leg = s ? THIGH_R : THIGH_L;
        limb(SHIRT, arm, 0.265 * x, 1.13, 0, 0.062, 0.05);
        limb(SKIN, arm + 1, 0.3 * x, 0.87, 0.03, 0.046, 0.034);
        capsule(SKIN, arm + 1, (double[3]){0.302 * x, 0.84, 0.035}, (double[3]){0.306 * x, 0.79, 0.045}, 0.042, 0.034,
                0.7);
        limb(TROUSERS, leg, 0.105 * x, 0.52, 0, 0.092, 0.068);
        limb(TROUSERS, leg + 1, 0.105 * x, 0.12, -0.01, 0.066, 0.046);
        capsule(SHOES, leg + 2, (double[3]){0.105 * x, 0.055, -0.03}, (double[3]){0.112 * x, 0.045, 0.13}, 0.055, 0.045,
                1);
    }
}

/* ---- clips ---- */

/* A joint's angles, radians: about x, z, y; and how far the hips are off their place, upwards. */
typedef struct stance {
    double x[JOINTS], z[JOINTS], y[JOINTS], rise;
} stance;

/* `t`: 0..1 of the clip. Legs forwards and elbows bent are negative about x, knees bent positive. */
static void stride(stance *s, double t, double swing, double knee, double arm, double elbow, double lean)
{
    const double phase = 2 * PI * t;
    for (int k = 0; k < 2; k++) {
        const double p = phase + (k ? PI : 0), lift = sin(p + 0.5 * PI);
        const int leg = k ? THIGH_R : THIGH_L, hand = k ? ARM_R : ARM_L;
        s->x[leg] = -swing * sin(p) - 0.1 * swing;
        s->x[leg + 1] = knee * (0.12 + (lift > 0 ? lift * lift : 0));
        s->x[leg + 2] = 0.35 * swing * sin(p) - 0.15 * s->x[leg + 1];
        s->x[hand] = arm * sin(p), s->z[hand] = k ? -0.06 : 0.06;
        s->x[hand + 1] = -elbow * (1 - 0.5 * sin(p));
    }
    s->x[CHEST] = lean, s->y[CHEST] = 0.12 * sin(phase), s->y[HIPS] = -0.1 * sin(phase);
    s->y[HEAD] = -0.04 * sin(phase), s->x[HEAD] = -0.7 * lean;
    s->rise = 0.02 * cos(2 * phase) * swing / 0.45 - 0.015;
}

static void idle(stance *s, double t)
{
    const double breath = sin(2 * PI * t);
    s->x[CHEST] = 0.02 * breath, s->x[HEAD] = -0.02 * breath, s->y[HEAD] = 0.12 * sin(2 * PI * t + 0.8);
    s->z[ARM_L] = 0.05 + 0.015 * breath, s->z[ARM_R] = -s->z[ARM_L];
    s->x[FOREARM_L] = s->x[FOREARM_R] = -0.12 - 0.02 * breath;
    s->rise = 0.004 * breath;
}

static void pose_at(int clip, double t, stance *s)
{
    memset(s, 0, sizeof *s);
    switch (clip) {
    case 0: idle(s, t); break;
    case 1: stride(s, t, 0.45, 0.75, 0.4, 0.35, 0.03); break;
    case 2: stride(s, t, 0.8, 1.5, 0.85, 1.5, 0.16); break;
    default:
        idle(s, t);
        s->z[ARM_R] = -2.5, s->x[ARM_R] = 0;
        s->z[FOREARM_R] = -0.15 + 0.5 * sin(4 * PI * t), s->x[FOREARM_R] = 0;
        s->z[CHEST] = 0.05, s->z[HEAD] = 0.08;
    }
}

static const struct {
    const char *name;
    double seconds;
} CLIPS[] = {{"idle", 3.2}, {"walk", 1.0}, {"run", 0.62}, {"wave", 1.4}};
enum { CLIP_COUNT = sizeof CLIPS / sizeof *CLIPS };

/* y after z after x. */
static void quaternion(double x, double z, double y, float out[4])
{
    const double a = sin(x / 2), b = cos(x / 2), c = sin(z / 2), d = cos(z / 2), e = sin(y / 2), f = cos(y / 2);
    const double qx = a * d, qy = a * c, qz = b * c, qw = b * d; /* z · x */
    out[0] = (float)(f * qx + e * qz), out[1] = (float)(f * qy + e * qw);
    out[2] = (float)(f * qz - e * qx), out[3] = (float)(f * qw - e * qy);
}

/* ---- the file ---- */

static uint8_t bytes[1 << 20];
static char text[MOST], views[MOST / 2], accessors[MOST / 2];
static size_t used;
static int accessor_count;

static int put(const void *data, size_t size, int component, const char *type, size_t count, const char *more)
{
    memcpy(bytes + used, data, size);
    const size_t v = strlen(views), a = strlen(accessors);
    const char *comma = accessor_count ? "," : "";
    snprintf(views + v, sizeof views - v, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", comma, used, size);
    snprintf(accessors + a, sizeof accessors - a,
             "%s{\"bufferView\":%d,\"componentType\":%d,\"type\":\"%s\",\"count\":%zu%s}", comma, accessor_count,
             component, type, count, more);
    used = (used + size + 3) / 4 * 4;
    return accessor_count++;
}

static void __attribute__((format(printf, 1, 2))) add(const char *format, ...)
{
    va_list list;
    const size_t at = strlen(text);
    va_start(list, format);
    vsnprintf(text + at, sizeof text - at, format, list);
    va_end(list);
}

/* One array of the part's vertices: `size` bytes at `offset` of each. */
static int put_attribute(const part *p, size_t offset, size_t size, int component, const char *type, const char *more)
{
    static uint8_t list[4096 * 16];
    for (int i = 0; i < p->vertex_count; i++)
        memcpy(list + (size_t)i * size, (const uint8_t *)&p->vertices[i] + offset, size);
    return put(list, (size_t)p->vertex_count * size, component, type, (size_t)p->vertex_count, more);
}

static void put_primitive(const part *p, int material)
{
    float low[3] = {1e9f, 1e9f, 1e9f}, high[3] = {-1e9f, -1e9f, -1e9f};
    char range[200];
    for (int i = 0; i < p->vertex_count; i++)
        for (int k = 0; k < 3; k++) {
            low[k] = fminf(low[k], p->vertices[i].position[k]);
            high[k] = fmaxf(high[k], p->vertices[i].position[k]);
        }
    snprintf(range, sizeof range, ",\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]", (double)low[0], (double)low[1],
             (double)low[2], (double)high[0], (double)high[1], (double)high[2]);
    const int position = put_attribute(p, offsetof(vertex, position), 12, 5126, "VEC3", range);
    const int normal = put_attribute(p, offsetof(vertex, normal), 12, 5126, "VEC3", "");
    const int joints = put_attribute(p, offsetof(vertex, joints), 4, 5121, "VEC4", "");
    const int weights = put_attribute(p, offsetof(vertex, weights), 4, 5121, "VEC4", ",\"normalized\":true");
    const int indices = put(p->indices, 2 * (size_t)p->index_count, 5123, "SCALAR", (size_t)p->index_count, "");
    add("%s{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d,\"JOINTS_0\":%d,\"WEIGHTS_0\":%d},\"indices\":%d,"
        "\"material\":%d}",
        material ? "," : "", position, normal, joints, weights, indices, material);
}

static void put_clip(int clip)
{
    float times[KEYS], turns[KEYS][4], places[KEYS][3];
    stance s;
    char channels[4096] = "", range[64];
    for (int k = 0; k < KEYS; k++) times[k] = (float)(CLIPS[clip].seconds * k / (KEYS - 1));
    snprintf(range, sizeof range, ",\"min\":[0],\"max\":[%.9g]", (double)times[KEYS - 1]);
    const int input = put(times, sizeof times, 5126, "SCALAR", KEYS, range);
    add("%s{\"name\":\"%s\",\"samplers\":[", clip ? "," : "", CLIPS[clip].name);
    for (int j = 0; j <= JOINTS; j++) {
        for (int k = 0; k < KEYS; k++) {
            pose_at(clip, (double)k / (KEYS - 1), &s);
            if (j < JOINTS) quaternion(s.x[j], s.z[j], s.y[j], turns[k]);
            places[k][0] = 0, places[k][1] = (float)(SKELETON[HIPS].at[1] + s.rise), places[k][2] = 0;
        }
        const int output = j < JOINTS ? put(turns, sizeof turns, 5126, "VEC4", KEYS, "")
                                      : put(places, sizeof places, 5126, "VEC3", KEYS, "");
        const size_t at = strlen(channels);
        add("%s{\"input\":%d,\"output\":%d}", j ? "," : "", input, output);
        snprintf(channels + at, sizeof channels - at, "%s{\"sampler\":%d,\"target\":{\"node\":%d,\"path\":\"%s\"}}",
                 j ? "," : "", j, j < JOINTS ? j + 1 : HIPS + 1, j < JOINTS ? "rotation" : "translation");
    }
    add("],\"channels\":[%s]}", channels);
}

static void put_nodes(void)
{
    add("\"nodes\":[{\"name\":\"figure\",\"mesh\":0,\"skin\":0}");
    for (int j = 0; j < JOINTS; j++) {
        const int parent = SKELETON[j].parent;
        char children[64] = "";
        double at[3];
        for (int i = 0; i < 3; i++) at[i] = SKELETON[j].at[i] - (parent < 0 ? 0 : SKELETON[parent].at[i]);
        for (int c = 0; c < JOINTS; c++)
            if (SKELETON[c].parent == j)
                snprintf(children + strlen(children), sizeof children - strlen(children), "%s%d",
                         children[0] ? "," : "", c + 1);
        add(",{\"name\":\"%s\",\"translation\":[%.9g,%.9g,%.9g]", SKELETON[j].name, at[0], at[1], at[2]);
        if (children[0]) add(",\"children\":[%s]", children);
        add("}");
    }
    add("],");
}

static int put_binds(void)
{
    float binds[JOINTS][16] = {{0}};
    for (int j = 0; j < JOINTS; j++) {
        for (int i = 0; i < 4; i++) binds[j][5 * i] = 1;
        for (int i = 0; i < 3; i++) binds[j][12 + i] = (float)-SKELETON[j].at[i];
    }
    return put(binds, sizeof binds, 5126, "MAT4", JOINTS, "");
}

static void put_text(void)
{
    static const char *const names[MATERIALS] = {"shirt", "skin", "trousers", "shoes"};
    static const double colors[MATERIALS][3] = {
        {0.72, 0.12, 0.08}, {0.72, 0.42, 0.28}, {0.06, 0.11, 0.24}, {0.09, 0.06, 0.04}};
    add("{\"asset\":{\"version\":\"2.0\",\"generator\":\"daft_generate\",\"copyright\":\"CC0\"},\"scene\":0,"
        "\"scenes\":[{\"nodes\":[0,1]}],");
    put_nodes();
    add("\"materials\":[");
    for (int i = 0; i < MATERIALS; i++)
        add("%s{\"name\":\"%s\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[%g,%g,%g,1],\"metallicFactor\":0,"
            "\"roughnessFactor\":0.7}}",
            i ? "," : "", names[i], colors[i][0], colors[i][1], colors[i][2]);
    add("],\"meshes\":[{\"name\":\"figure\",\"primitives\":[");
    for (int i = 0; i < MATERIALS; i++) put_primitive(&parts[i], i);
    add("]}],\"skins\":[{\"joints\":[");
    for (int j = 0; j < JOINTS; j++) add("%s%d", j ? "," : "", j + 1);
    add("],\"inverseBindMatrices\":%d}],\"animations\":[", put_binds());
    for (int i = 0; i < CLIP_COUNT; i++) put_clip(i);
    add("],\"bufferViews\":[%s],\"accessors\":[%s],\"buffers\":[{\"byteLength\":%zu}]}", views, accessors, used);
    while (strlen(text) % 4) add(" ");
}

static void put_word(FILE *file, size_t word)
{
    for (int i = 0; i < 4; i++) fputc((int)(word >> 8 * i & 255), file);
}

bool generate_figure(const char *root)
{
    static const char path[] = "assets/meshes/figure.glb";
    body();
    put_text();
    FILE *file = open_output(root, path);
    if (!file) return false;
    fputs("glTF", file);
    put_word(file, 2), put_word(file, 12 + 8 + strlen(text) + 8 + used);
    put_word(file, strlen(text)), fputs("JSON", file), fputs(text, file);
    put_word(file, used), fwrite("BIN", 1, 4, file), fwrite(bytes, 1, used, file);
    return close_output(file, path);
}
