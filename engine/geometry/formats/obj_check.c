/* What is odd about an OBJ file, with the line of each: values that are not finite or lie far out, normals without
 * length, vertices that nothing uses or that are there twice, and what daft_trimesh_check finds.
 *
 * Of each kind the first few are told with their places, then how many more there were: a place costs a walk through
 * the text. */
#include "geometry/formats/obj.h"
#include "geometry/trimesh.h"

#include <stdio.h>

enum { PLACES = 5 };

typedef enum kind {
    NOT_FINITE,
    FAR_OUT,
    UV_NOT_FINITE,
    UV_FAR_OUT,
    NO_NORMAL,
    FLAWS, /* DAFT_FLAW_… follow */
    KIND_COUNT = FLAWS + DAFT_FLAW_COUNT
} kind;

typedef struct checker {
    daft_obj_source *source;
    size_t count[KIND_COUNT];
    uint32_t last_face[DAFT_FLAW_COUNT];  /* + 1: a polygon's triangles are told once */
    uint32_t first_face[DAFT_FLAW_COUNT]; /* + 1 */
} checker;

static const struct {
    daft_severity severity;
    const char *statement, *text;
    const char *more; /* what the rest is called; no text: told as a sum, by tell_sums */
} KINDS[KIND_COUNT] = {
    {DAFT_SEVERITY_WARNING, "v", "the vertex is not finite: faces that use it are left out", "vertices are not finite"},
    {DAFT_SEVERITY_WARNING, "v", "the vertex is more than 1e15 from the origin: floats cannot hold what is near it",
     "vertices are more than 1e15 from the origin"},
    {DAFT_SEVERITY_WARNING, "vt", "the texture coordinate is not finite: its corners have none",
     "texture coordinates are not finite"},
    {DAFT_SEVERITY_WARNING, "vt", "the texture coordinate is beyond 10,000 repeats: the texture will flicker",
     "texture coordinates are beyond 10,000 repeats"},
    {DAFT_SEVERITY_WARNING, "vn", "the normal has no direction: the faces' own is used", "normals have no direction"},
    [FLAWS + DAFT_FLAW_NO_AREA] = {DAFT_SEVERITY_WARNING, "f", "the face has a triangle without area: it is not seen",
                                   "faces have triangles without area"},
    [FLAWS + DAFT_FLAW_DUPLICATE] = {DAFT_SEVERITY_WARNING, "f", "the face covers one with the same corners",
                                     "faces cover one with the same corners"},
    [FLAWS + DAFT_FLAW_OPEN] = {DAFT_SEVERITY_NOTE, "f", NULL, NULL},
    [FLAWS + DAFT_FLAW_NON_MANIFOLD] = {DAFT_SEVERITY_NOTE, "f", NULL, NULL},
    [FLAWS + DAFT_FLAW_TURNED] = {DAFT_SEVERITY_WARNING, "f", NULL, NULL},
};

/* The index-th statement of this kind, as the reader counts them. */
static const char *find_statement(const daft_text *text, const char *keyword, size_t index)
{
    size_t length = strlen(keyword);
    for (const char *p = text->begin; p < text->end;) {
        if (daft_is_break(*p)) {
            p++;
            continue;
        }
        p = daft_skip_blanks(p);
        if (strncmp(p, keyword, length) == 0 && daft_token_ends(text, p + length) && index-- == 0) return p;
        p = *p == '#' ? daft_skip_comment(text, p) : daft_skip_statement(text, p);
    }
    return text->begin;
}

static void tell(const checker *c, daft_severity severity, const char *keyword, size_t index, const char *message)
{
    const daft_text *text = &c->source->text;
    int line = 0, column = 0;
    if (keyword) daft_text_place(text, find_statement(text, keyword, index), &line, &column);
    daft_problem_at(c->source->problems, severity, DAFT_ERROR_SYNTAX, text->path, line, column, "%s", message);
}

static void tell_kind(checker *c, kind which, size_t index)
{
    if (c->count[which]++ < PLACES) tell(c, KINDS[which].severity, KINDS[which].statement, index, KINDS[which].text);
}

static void tell_rest(const checker *c)
{
    for (int i = 0; i < KIND_COUNT; i++) {
        if (c->count[i] <= PLACES || !KINDS[i].more) continue;
        daft_problem_at(c->source->problems, KINDS[i].severity, DAFT_ERROR_SYNTAX, c->source->text.path, 0, 0,
                        "and %zu more: %zu %s", c->count[i] - PLACES, c->count[i], KINDS[i].more);
    }
}

/* ---- the arrays, before the mesh is made of them ---- */

static void look_at_values(checker *c)
{
    const daft_obj_source *s = c->source;
    const float far = 1e15f;
    for (size_t i = 0; i < s->position_count; i++) {
        daft_vec3 p = daft_obj_position(s, i);
        if (!daft_finite3(p))
            tell_kind(c, NOT_FINITE, i);
        else if (fabsf(p.x) > far || fabsf(p.y) > far || fabsf(p.z) > far)
            tell_kind(c, FAR_OUT, i);
    }
    for (size_t i = 0; i < s->uv_count; i++) {
        daft_vec2 uv = s->uvs[i];
        if (!isfinite(uv.x) || !isfinite(uv.y))
            tell_kind(c, UV_NOT_FINITE, i);
        else if (fabsf(uv.x) > 1e4f || fabsf(uv.y) > 1e4f)
            tell_kind(c, UV_FAR_OUT, i);
    }
    size_t other_lengths = 0;
    for (size_t i = 0; i < s->normal_count; i++) {
        daft_dvec3 n = daft_to_double(s->normals[i]);
        double length = sqrt(daft_ddot(n, n));
        if (!(length > 0) || !isfinite(length))
            tell_kind(c, NO_NORMAL, i);
        else
            other_lengths += fabs(length - 1) > 0.01;
    }
    if (other_lengths == 0) return;
    char message[120];
    snprintf(message, sizeof message, "%zu of %zu normals are not of length 1: they are scaled to it", other_lengths,
             s->normal_count);
    tell(c, DAFT_SEVERITY_NOTE, NULL, 0, message);
}

/* ---- the mesh ---- */

static void on_flaw(void *user, daft_flaw flaw, uint32_t triangle)
{
    checker *c = user;
    uint32_t face = c->source->face_of[triangle];
    if (!c->first_face[flaw]) c->first_face[flaw] = face + 1;
    if (KINDS[FLAWS + flaw].text && c->last_face[flaw] != face + 1) tell_kind(c, (kind)(FLAWS + flaw), face);
    c->last_face[flaw] = face + 1;
}

static void tell_edges(const checker *c, daft_flaw flaw, uint32_t count, const char *one, const char *many)
{
    if (count == 0) return;
    char message[160];
    snprintf(message, sizeof message, "%u %s", count, count == 1 ? one : many);
    tell(c, KINDS[FLAWS + flaw].severity, "f", c->first_face[flaw] - 1, message);
}

static void tell_sums(const checker *c, const daft_mesh_report *report)
{
    tell_edges(c, DAFT_FLAW_OPEN, report->open_edges, "open edge: the mesh is not closed (the first is here)",
               "open edges: the mesh is not closed (the first is here)");
    tell_edges(c, DAFT_FLAW_NON_MANIFOLD, report->non_manifold_edges,
               "edge is shared by more than two triangles: no solid has such (the first is here)",
               "edges are shared by more than two triangles: no solid has such (the first is here)");
    tell_edges(c, DAFT_FLAW_TURNED, report->turned_edges,
               "edge lies between triangles that face opposite ways (the first is here)",
               "edges lie between triangles that face opposite ways (the first is here)");
    char message[160];
    snprintf(message, sizeof message, "vertices in the place of an earlier one: %u", report->duplicate_vertices);
    if (report->duplicate_vertices) tell(c, DAFT_SEVERITY_NOTE, NULL, 0, message);
    snprintf(message, sizeof message, "vertices that no triangle uses: %u", report->unused_vertices);
    if (report->unused_vertices) tell(c, DAFT_SEVERITY_NOTE, NULL, 0, message);
}

static bool look_at_mesh(checker *c, const daft_trimesh *mesh, daft_error *error)
{
    daft_mesh_report report;
    if (!daft_trimesh_check(c->source->allocator, mesh, on_flaw, c, &report, error)) return false;
    tell_sums(c, &report);
    tell_rest(c);
    return true;
}

static bool check(daft_obj_source *source, daft_obj *obj, daft_error *error)
{
    checker c = {.source = source};
    if (!daft_obj_read(source, error)) return false;
    look_at_values(&c);
    source->face_of = daft_alloc(source->allocator, source->triangle_count, sizeof *source->face_of);
    if (!source->face_of) return daft_fail_memory(error, "checking a mesh");
    return daft_obj_make_mesh(source, &obj->mesh, error) && daft_obj_make_slots(source, &obj->slots, error) &&
           daft_obj_make_normals(source, &obj->mesh, error) && look_at_mesh(&c, &obj->mesh, error);
}

bool daft_obj_check(const daft_allocator *allocator, const daft_files *files, const char *path, const daft_log *log,
                    const daft_problems *problems, daft_obj *out, daft_error *error)
{
    size_t size;
    char *text = daft_file_read(allocator, files, path, &size, error);
    if (!text) return false;
    daft_obj obj = {0};
    daft_obj_source source = {
        .text = daft_text_open(path, text, size, log), .allocator = allocator, .files = files, .problems = problems};
    bool done = check(&source, &obj, error);
    obj.mesh.slot_count = (uint32_t)obj.slots.count;
    if (done) daft_text_close(&source.text);
    daft_obj_source_free(&source);
    daft_release(allocator, text);
    if (done)
        *out = obj;
    else
        daft_obj_free(allocator, &obj);
    return done;
}
