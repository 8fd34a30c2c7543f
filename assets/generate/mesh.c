/* Mesh building blocks and OBJ out. */
#include "mesh.h"

#include <math.h>
#include <string.h>
#include <stdlib.h>

static const double TAU = 6.283185307179586;

vec add(vec a, vec b) { return v3(a.x + b.x, a.y + b.y, a.z + b.z); }
vec sub(vec a, vec b) { return v3(a.x - b.x, a.y - b.y, a.z - b.z); }
vec times(vec a, double s) { return v3(a.x * s, a.y * s, a.z * s); }
vec cross(vec a, vec b) { return v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x); }
double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double length(vec a) { return sqrt(a.x * a.x + a.y * a.y + a.z * a.z); }
vec normal_of(vec a)
{
    double l = length(a);
    return l > 0 ? times(a, 1 / l) : v3(0, 1, 0);
}

void use_material(mesh *m, const char *name)
{
    for (m->material = 0; m->material < m->material_count; m->material++)
        if (strcmp(m->materials[m->material], name) == 0) return;
    m->materials[m->material_count++] = name;
}

void add_face(mesh *m, const corner *corners, int count, bool textured)
{
    if (m->face_count >= MAX_FACES || m->corner_count + count > MAX_CORNERS) return;
    m->faces[m->face_count++] = (face){m->corner_count, count, m->material, textured};
    for (int i = 0; i < count; i++) {
        corner c = corners[i];
        c.at = add(c.at, m->move);
        m->corners[m->corner_count++] = c;
    }
}

void add_flat(mesh *m, const vec *points, int count)
{
    corner corners[64];
    vec sum = v3(0, 0, 0); /* Newell's method: right for any polygon */
    for (int i = 0; i < count; i++) sum = add(sum, cross(points[i], points[(i + 1) % count]));
    for (int i = 0; i < count && i < 64; i++) corners[i] = (corner){points[i], normal_of(sum), 0, 0};
    add_face(m, corners, count, false);
}

static bool same_point(const double *a, const double *b) { return fabs(a[0] - b[0]) + fabs(a[1] - b[1]) < 1e-9; }

/* The profile's outward normal at the end `i` of the piece between i and i + step. */
static void profile_normal(const double (*p)[2], int count, int i, int step, double out[2])
{
    int before = step > 0 ? i - 1 : i, after = step > 0 ? i + 1 : i; /* the piece itself is [i, i+1] or [i-1, i] */
    double r, h;
    if (step > 0)
        before = i > 0 && !same_point(p[i - 1], p[i]) ? i - 1 : i, after = i + 1;
    else
        before = i - 1, after = i + 1 < count && !same_point(p[i + 1], p[i]) ? i + 1 : i;
    r = p[after][0] - p[before][0], h = p[after][1] - p[before][1];
    double l = sqrt(r * r + h * h);
    out[0] = h / l, out[1] = -r / l;
}

void add_lathe(mesh *m, const double (*profile)[2], int count, int sides, double repeat)
{
    double travelled = 0;
    for (int i = 0; i + 1 < count; i++) {
        const double *p = profile[i], *q = profile[i + 1];
        if (same_point(p, q)) continue;
        double np[2], nq[2], step = sqrt((q[0] - p[0]) * (q[0] - p[0]) + (q[1] - p[1]) * (q[1] - p[1]));
        profile_normal(profile, count, i, 1, np), profile_normal(profile, count, i + 1, -1, nq);
        for (int k = 0; k < sides; k++) {
            corner c[4];
            for (int j = 0; j < 4; j++) {
                int turn = k + (j == 1 || j == 2);
                const double *a = j < 2 ? p : q, *n = j < 2 ? np : nq;
                /* From +X towards -Z, so that going up and round is counter-clockwise from outside. */
                double angle = TAU * (turn % sides) / sides, x = cos(angle), z = -sin(angle);
                c[j].at = v3(a[0] * x, a[1], a[0] * z), c[j].normal = v3(n[0] * x, n[1], n[0] * z);
                c[j].u = repeat * turn / sides, c[j].v = travelled + (j < 2 ? 0 : step);
            }
            if (p[0] < 1e-9) c[1] = c[2], c[2] = c[3];
            bool triangle = p[0] < 1e-9 || q[0] < 1e-9;
            add_face(m, c, triangle ? 3 : 4, repeat > 0);
        }
        travelled += step;
    }
}

static corner torus_corner(vec center, double major, double minor, double a, double b)
{
    vec out = v3(cos(a), sin(a), 0), normal = add(times(out, cos(b)), v3(0, 0, sin(b)));
    return (corner){add(center, add(times(out, major), times(normal, minor))), normal, 0, 0};
}

void add_torus(mesh *m, vec center, double major, double minor, int around, int across, double from, double to)
{
    bool whole = fabs(to - from - TAU) < 1e-9;
    for (int i = 0; i < around; i++) {
        int next = whole ? (i + 1) % around : i + 1;
        double a = from + (to - from) * i / around, b = from + (to - from) * next / around;
        for (int k = 0; k < across; k++) {
            double s = TAU * k / across, t = TAU * ((k + 1) % across) / across;
            corner c[4] = {torus_corner(center, major, minor, a, s), torus_corner(center, major, minor, b, s),
                           torus_corner(center, major, minor, b, t), torus_corner(center, major, minor, a, t)};
            add_face(m, c, 4, false);
        }
    }
}

typedef struct blob {
    mesh *m;
    vec center, radius;
    double rough;
    int seed;
    double tile, soft; /* tile 0: no texture, flat normals */
} blob;

static vec blob_point(const blob *b, vec d)
{
    double push = 1 + b->rough * fractal3(d.x * 1.7, d.y * 1.7, d.z * 1.7, 3, b->seed);
    return add(b->center, v3(d.x * b->radius.x * push, d.y * b->radius.y * push, d.z * b->radius.z * push));
}

/* Texture coordinates along the two axes that the normal points along least. */
static void project(corner *c, vec n, double tile)
{
    double x = fabs(n.x), y = fabs(n.y), z = fabs(n.z);
    c->u = (x > y && x > z ? c->at.z : c->at.x) / tile;
    c->v = (y > x && y > z ? c->at.z : c->at.y) / tile;
}

static void add_soft_triangle(const blob *b, const vec points[3], const vec directions[3])
{
    corner c[3];
    vec flat = normal_of(cross(sub(points[1], points[0]), sub(points[2], points[0])));
    for (int i = 0; i < 3; i++) {
        vec round =
            normal_of(v3(directions[i].x / b->radius.x, directions[i].y / b->radius.y, directions[i].z / b->radius.z));
        c[i] = (corner){points[i], normal_of(add(times(round, b->soft), times(flat, 1 - b->soft))), 0, 0};
        project(&c[i], flat, b->tile);
    }
    add_face(b->m, c, 3, true);
}

static void split(const blob *b, vec p, vec q, vec r, int level)
{
    if (level == 0) {
        vec triangle[3] = {blob_point(b, p), blob_point(b, q), blob_point(b, r)};
        if (b->tile > 0)
            add_soft_triangle(b, triangle, (const vec[]){p, q, r});
        else
            add_flat(b->m, triangle, 3);
        return;
    }
    vec pq = normal_of(add(p, q)), qr = normal_of(add(q, r)), rp = normal_of(add(r, p));
    split(b, p, pq, rp, level - 1), split(b, q, qr, pq, level - 1);
    split(b, r, rp, qr, level - 1), split(b, pq, qr, rp, level - 1);
}

static void add_icosahedron(const blob *b, int level)
{
    static const double g = 1.618033988749895;
    const vec v[12] = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                       {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    static const int f[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                 {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                 {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (int i = 0; i < 20; i++) split(b, normal_of(v[f[i][0]]), normal_of(v[f[i][1]]), normal_of(v[f[i][2]]), level);
}

void add_blob(mesh *m, vec center, vec radius, int level, double rough, int seed)
{
    blob b = {m, center, radius, rough, seed, 0, 0};
    add_icosahedron(&b, level);
}

void add_soft_blob(mesh *m, vec center, vec radius, int level, double rough, int seed, double tile, double soft)
{
    blob b = {m, center, radius, rough, seed, tile, soft};
    add_icosahedron(&b, level);
}

vec random_direction(int i, int seed)
{
    double y = 2 * hash01(i, 1, seed) - 1, a = 6.283185307179586 * hash01(i, 2, seed), r = sqrt(1 - y * y);
    return v3(r * cos(a), y, r * sin(a));
}

void add_tube(mesh *m, const vec *points, const double *radii, int count, int sides, double tile)
{
    for (int i = 0; i + 1 < count; i++) {
        for (int k = 0; k < sides; k++) {
            corner c[4];
            for (int j = 0; j < 4; j++) {
                int at = i + (j > 1), turn = k + (j == 1 || j == 2);
                double a = -6.283185307179586 * (turn % sides) / sides;
                vec out = v3(cos(a), 0, sin(a));
                c[j] = (corner){add(points[at], times(out, radii[at])), out, (double)turn / sides, points[at].y / tile};
            }
            add_face(m, c, 4, true);
        }
    }
}

void add_panel(mesh *m, const vec p[4], double u0, double v0, double u1, double v1)
{
    vec n = normal_of(cross(sub(p[1], p[0]), sub(p[2], p[0])));
    const corner c[4] = {{p[0], n, u0, v0}, {p[1], n, u1, v0}, {p[2], n, u1, v1}, {p[3], n, u0, v1}};
    add_face(m, c, 4, true);
}

void add_box(mesh *m, vec a, vec b, double tile)
{
    double x = (b.x - a.x) / tile, y = (b.y - a.y) / tile, z = (b.z - a.z) / tile;
    add_panel(m, (const vec[]){v3(a.x, a.y, b.z), v3(b.x, a.y, b.z), v3(b.x, b.y, b.z), v3(a.x, b.y, b.z)}, 0, 0, x, y);
    add_panel(m, (const vec[]){v3(b.x, a.y, a.z), v3(a.x, a.y, a.z), v3(a.x, b.y, a.z), v3(b.x, b.y, a.z)}, 0, 0, x, y);
    add_panel(m, (const vec[]){v3(b.x, a.y, b.z), v3(b.x, a.y, a.z), v3(b.x, b.y, a.z), v3(b.x, b.y, b.z)}, 0, 0, z, y);
    add_panel(m, (const vec[]){v3(a.x, a.y, a.z), v3(a.x, a.y, b.z), v3(a.x, b.y, b.z), v3(a.x, b.y, a.z)}, 0, 0, z, y);
    add_panel(m, (const vec[]){v3(a.x, b.y, b.z), v3(b.x, b.y, b.z), v3(b.x, b.y, a.z), v3(a.x, b.y, a.z)}, 0, 0, x, z);
}

void add_facing(mesh *m, const vec p[4], vec eye, double u, double v)
{
    vec n = normal_of(cross(sub(p[2], p[0]), sub(p[3], p[1])));
    const bool away = dot(n, sub(eye, p[0])) < 0;
    if (away) n = times(n, -1);
    const corner c[4] = {{p[0], n, 0, 0}, {p[1], n, u, 0}, {p[2], n, u, v}, {p[3], n, 0, v}};
    const corner turned[4] = {c[0], c[3], c[2], c[1]};
    add_face(m, away ? turned : c, 4, u > 0);
}

void add_block(mesh *m, vec low, vec high, double tile)
{
    add_box(m, low, high, tile);
    const vec bottom[4] = {low, v3(high.x, low.y, low.z), v3(high.x, low.y, high.z), v3(low.x, low.y, high.z)};
    add_panel(m, bottom, 0, 0, (high.x - low.x) / tile, (high.z - low.z) / tile);
}

void add_surface(mesh *m, surface *at, int across, int up)
{
    const double e = 1e-4;
    for (int i = 0; i < across; i++) {
        for (int k = 0; k < up; k++) {
            corner c[4];
            for (int j = 0; j < 4; j++) {
                const double u = (double)(i + (j == 1 || j == 2)) / across, v = (double)(k + (j > 1)) / up;
                const double w = fmin(fmax(v, 2 * e), 1 - 2 * e);
                c[j] = (corner){
                    at(u, v), normal_of(cross(sub(at(u + e, w), at(u - e, w)), sub(at(u, w + e), at(u, w - e)))), u, v};
            }
            if (length(sub(c[0].at, c[1].at)) < 1e-6) c[1] = c[2], c[2] = c[3];
            const bool triangle = length(sub(c[2].at, c[3].at)) < 1e-6 ||
                                  length(sub(c[0].at, at((double)(i + 1) / across, (double)k / up))) < 1e-6;
            add_face(m, c, triangle ? 3 : 4, false);
        }
    }
}

/* ---- OBJ ---- */

/* Rounded triples without repeats, numbered from 1 as OBJ does. */
typedef struct pool {
    long items[MAX_CORNERS][3];
    int count;
} pool;

static int pooled(pool *p, double x, double y, double z, double scale)
{
    long item[3] = {lround(x * scale), lround(y * scale), lround(z * scale)};
    for (int i = 0; i < p->count; i++)
        if (memcmp(p->items[i], item, sizeof item) == 0) return i + 1;
    memcpy(p->items[p->count], item, sizeof item);
    return ++p->count;
}

static void write_pool(FILE *file, const pool *p, const char *word, int numbers, double scale)
{
    for (int i = 0; i < p->count; i++) {
        fprintf(file, "%s", word);
        for (int k = 0; k < numbers; k++) fprintf(file, " %.6g", (double)p->items[i][k] / scale);
        fputc('\n', file);
    }
}

static void write_faces(FILE *file, const mesh *m, const int (*numbers)[3])
{
    int material = -1;
    for (int i = 0; i < m->face_count; i++) {
        const face *f = &m->faces[i];
        if (f->material != material) fprintf(file, "usemtl %s\n", m->materials[f->material]);
        material = f->material;
        fputc('f', file);
        for (int k = f->first; k < f->first + f->count; k++) {
            if (f->textured)
                fprintf(file, " %d/%d/%d", numbers[k][0], numbers[k][1], numbers[k][2]);
            else
                fprintf(file, " %d//%d", numbers[k][0], numbers[k][2]);
        }
        fputc('\n', file);
    }
}

bool write_mesh(const char *root, const char *path, const mesh *m)
{
    pool *pools = calloc(3, sizeof *pools);
    int(*numbers)[3] = calloc(MAX_CORNERS, sizeof *numbers);
    FILE *file = pools && numbers ? open_output(root, path) : NULL;
    bool ok = file != NULL;
    if (ok) {
        for (int i = 0; i < m->face_count; i++) {
            for (int k = m->faces[i].first; k < m->faces[i].first + m->faces[i].count; k++) {
                const corner *c = &m->corners[k];
                numbers[k][0] = pooled(&pools[0], c->at.x, c->at.y, c->at.z, 1e4);
                if (m->faces[i].textured) numbers[k][1] = pooled(&pools[1], c->u, c->v, 0, 1e4);
                numbers[k][2] = pooled(&pools[2], c->normal.x, c->normal.y, c->normal.z, 1e3);
            }
        }
        fprintf(file, "# made by daft_generate, CC0\nmtllib %s\n", m->library ? m->library : "meshes.mtl");
        write_pool(file, &pools[0], "v", 3, 1e4);
        write_pool(file, &pools[1], "vt", 2, 1e4);
        write_pool(file, &pools[2], "vn", 3, 1e3);
        write_faces(file, m, (const int(*)[3])numbers);
        ok = close_output(file, path);
    }
    free(pools), free(numbers);
    return ok;
}

bool write_text(const char *root, const char *path, const char *text)
{
    FILE *file = open_output(root, path);
    if (!file) return false;
    fputs(text, file);
    return close_output(file, path);
}

bool write_meshes(const char *root, const mesh_recipe *list, size_t count, const char *library)
{
    mesh *m = malloc(sizeof *m);
    bool ok = m != NULL;
    for (size_t i = 0; i < count && ok; i++) {
        *m = (mesh){.library = library};
        list[i].make(m);
        ok = write_mesh(root, list[i].path, m);
    }
    free(m);
    return ok;
}
