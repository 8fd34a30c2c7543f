/* What is odd about a mesh: triangles without area, duplicates, edges that are open, crowded or turned.
 *
 * Vertices in one place are one vertex here. Three hash tables give each place, each edge and each turn around three
 * corners the number of the first item that has it; how often an edge is run along, and which way, is counted at its
 * first corner. Open addressing, at most half full: linear in the size of the mesh. */
#include "geometry/trimesh.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void daft_problem_at(const daft_problems *problems, daft_severity severity, daft_status code, const char *file,
                     int line, int column, const char *format, ...)
{
    daft_error problem = {.code = code, .line = line, .column = column};
    snprintf(problem.file, sizeof problem.file, "%s", file ? file : "");
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(problem.message, sizeof problem.message, format, arguments);
    va_end(arguments);
    problems->found(problems->user, severity, &problem);
}

/* ---- tables of what was seen ---- */

typedef struct entry {
    uint32_t key[3], item; /* item + 1; 0: free */
} entry;

typedef struct table {
    entry *entries;
    size_t mask;
} table;

static bool table_make(const daft_allocator *allocator, table *t, size_t items)
{
    size_t size = 16;
    while (size < 2 * items) size *= 2;
    t->entries = daft_alloc_zero(allocator, size, sizeof *t->entries);
    t->mask = size - 1;
    return t->entries != NULL;
}

/* The first item that came with this key: `item` itself if none did. */
static uint32_t table_first(table *t, uint32_t a, uint32_t b, uint32_t c, uint32_t item)
{
    uint32_t key[3] = {a, b, c};
    for (size_t at = daft_hash(key, sizeof key, 0) & t->mask;; at = (at + 1) & t->mask) {
        entry *e = &t->entries[at];
        if (e->item == 0) {
            memcpy(e->key, key, sizeof key);
            e->item = item + 1;
        }
        if (memcmp(e->key, key, sizeof key) == 0) return e->item - 1;
    }
}

/* ---- the check ---- */

typedef struct edge_uses {
    uint32_t forward, backward; /* times it is run along from its lower vertex, and from its higher */
} edge_uses;

typedef struct checker {
    const daft_trimesh *mesh;
    daft_flaw_callback *found;
    void *user;
    daft_mesh_report *report;
    table places, edges, triangles;
    uint32_t *place; /* of each vertex: the first vertex there */
    bool *used;      /* by a triangle */
    edge_uses *uses; /* at the corner that first has the edge */
} checker;

static void tell(const checker *c, daft_flaw flaw, uint32_t triangle, uint32_t *count)
{
    ++*count;
    if (c->found) c->found(c->user, flaw, triangle);
}

static uint32_t bits_of(float value)
{
    uint32_t bits;
    value += 0.0f; /* -0 is the same place as 0 */
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static void look_at_vertices(checker *c)
{
    const daft_trimesh *mesh = c->mesh;
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++) c->used[mesh->indices[i]] = true;
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        if (!c->used[i]) {
            c->report->unused_vertices++;
            continue;
        }
        c->place[i] = table_first(&c->places, bits_of(mesh->x[i]), bits_of(mesh->y[i]), bits_of(mesh->z[i]), i);
        c->report->duplicate_vertices += c->place[i] != i;
    }
}

/* Height over the longest edge below a millionth of it; in double, where floats' products neither over- nor underflow.
 */
static bool has_area(const daft_trimesh *mesh, const uint32_t *corner)
{
    daft_dvec3 p[3];
    for (int k = 0; k < 3; k++) p[k] = daft_to_double(daft_trimesh_position(mesh, corner[k]));
    double longest = 0;
    for (int k = 0; k < 3; k++) {
        daft_dvec3 edge = daft_dsub(p[(k + 1) % 3], p[k]);
        longest = fmax(longest, daft_ddot(edge, edge));
    }
    daft_dvec3 cross = daft_dcross(daft_dsub(p[1], p[0]), daft_dsub(p[2], p[0]));
    return sqrt(daft_ddot(cross, cross)) > 1e-6 * longest;
}

/* The smallest corner first: the same triangle, seen from the same side, whichever corner it began with. */
static void turn_smallest_first(uint32_t v[3])
{
    while (v[1] < v[0] || v[2] < v[0]) {
        uint32_t first = v[0];
        v[0] = v[1], v[1] = v[2], v[2] = first;
    }
}

static void count_edges(checker *c, uint32_t triangle, const uint32_t at[3])
{
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t from = at[k], to = at[(k + 1) % 3];
        if (from == to) continue; /* two corners in one place: no edge of the surface */
        bool forward = from < to;
        uint32_t first = table_first(&c->edges, forward ? from : to, forward ? to : from, 0, 3 * triangle + k);
        if (forward)
            c->uses[first].forward++;
        else
            c->uses[first].backward++;
    }
}

static void look_at_triangles(checker *c)
{
    for (uint32_t i = 0; i < c->mesh->triangle_count; i++) {
        const uint32_t *corner = c->mesh->indices + 3 * (size_t)i;
        uint32_t at[3] = {c->place[corner[0]], c->place[corner[1]], c->place[corner[2]]};
        turn_smallest_first(at);
        if (!has_area(c->mesh, corner))
            tell(c, DAFT_FLAW_NO_AREA, i, &c->report->without_area);
        else if (table_first(&c->triangles, at[0], at[1], at[2], i) != i)
            tell(c, DAFT_FLAW_DUPLICATE, i, &c->report->duplicate_triangles);
        count_edges(c, i, at);
    }
}

static void look_at_edges(checker *c)
{
    for (size_t i = 0; i < 3 * (size_t)c->mesh->triangle_count; i++) {
        edge_uses uses = c->uses[i];
        uint32_t all = uses.forward + uses.backward, triangle = (uint32_t)(i / 3);
        if (all == 1) tell(c, DAFT_FLAW_OPEN, triangle, &c->report->open_edges);
        if (all > 2) tell(c, DAFT_FLAW_NON_MANIFOLD, triangle, &c->report->non_manifold_edges);
        if (all == 2 && uses.forward != 1) tell(c, DAFT_FLAW_TURNED, triangle, &c->report->turned_edges);
    }
}

bool daft_trimesh_check(const daft_allocator *allocator, const daft_trimesh *mesh, daft_flaw_callback *found,
                        void *user, daft_mesh_report *report, daft_error *error)
{
    size_t corners = 3 * (size_t)mesh->triangle_count;
    checker c = {.mesh = mesh, .found = found, .user = user, .report = report};
    *report = (daft_mesh_report){.left_out = mesh->left_out};
    c.place = daft_alloc_zero(allocator, mesh->vertex_count, sizeof *c.place);
    c.used = daft_alloc_zero(allocator, mesh->vertex_count, sizeof *c.used);
    c.uses = daft_alloc_zero(allocator, corners, sizeof *c.uses);
    bool done = c.place && c.used && c.uses && table_make(allocator, &c.places, mesh->vertex_count) &&
                table_make(allocator, &c.edges, corners) && table_make(allocator, &c.triangles, mesh->triangle_count);
    if (done) {
        look_at_vertices(&c);
        look_at_triangles(&c);
        look_at_edges(&c);
    }
    void *memory[] = {c.place, c.used, c.uses, c.places.entries, c.edges.entries, c.triangles.entries};
    for (size_t i = 0; i < DAFT_COUNT_OF(memory); i++) daft_release(allocator, memory[i]);
    return done || daft_fail_memory(error, "checking a mesh");
}
