/* The triangles of meshes and height fields by number, and which of them a box meets, at rest or on its way. */
#include "sim/shape/triangles.h"

#include "accel/bvh.h"

enum { BLOCK = 8 }; /* cells of a field's finest block; see heightfield.c */

daft_dvec3 daft_triangle_normal(const daft_vec3 corners[3])
{
    daft_dvec3 a = daft_to_double(corners[0]);
    daft_dvec3 n = daft_dcross(daft_dsub(daft_to_double(corners[1]), a), daft_dsub(daft_to_double(corners[2]), a));
    double length = sqrt(daft_ddot(n, n));
    return length > 0 ? daft_dscale(n, 1 / length) : daft_dv3(0, 1, 0);
}

/* ---- one triangle ---- */

static daft_vec3 sample(const daft_height_field *f, uint32_t column, uint32_t row)
{
    return daft_v3((float)column * f->spacing_x, f->heights[(size_t)row * f->columns + column],
                   (float)row * f->spacing_z);
}

/* Also false outside of the field, where columns and rows wrap round to huge ones. */
static bool is_cell(const daft_height_field *f, uint32_t column, uint32_t row)
{
    if (column >= f->columns - 1 || row >= f->rows - 1) return false;
    const float *h = f->heights + (size_t)row * f->columns + column;
    return isfinite(h[0]) && isfinite(h[1]) && isfinite(h[f->columns]) && isfinite(h[f->columns + 1]);
}

static bool field_triangle(const daft_height_field *f, uint32_t triangle, daft_vec3 corners[3])
{
    uint32_t cell = triangle / 2, column = cell % (f->columns - 1), row = cell / (f->columns - 1);
    if (!is_cell(f, column, row)) return false;
    corners[0] = sample(f, column, row);
    corners[1] = sample(f, column + (triangle & 1), row + 1);
    corners[2] = sample(f, column + 1, row + 1 - (triangle & 1));
    return true;
}

bool daft_triangle_get(const daft_sim_shape *s, uint32_t triangle, daft_vec3 corners[3])
{
    if (s->type == DAFT_GEOMETRY_FIELD) return field_triangle(s->field, triangle, corners);
    if (s->mesh->no_area[triangle]) return false;
    const daft_trimesh *mesh = s->mesh->mesh;
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t v = mesh->indices[3 * (size_t)triangle + k];
        corners[k] = daft_v3(mesh->x[v], mesh->y[v], mesh->z[v]);
    }
    return true;
}

/* For both triangles of a cell and their three edges: the cell across, relative to the own, and which triangle and
 * edge. */
static const struct across {
    int8_t cell_x, cell_z;
    uint8_t triangle, k;
} field_across[2][3] = {{{-1, 0, 1, 1}, {0, 1, 1, 2}, {0, 0, 1, 0}}, {{0, 0, 0, 2}, {1, 0, 0, 0}, {0, -1, 0, 1}}};

bool daft_triangle_across(const daft_sim_shape *s, uint32_t triangle, uint32_t k, uint32_t *other, uint32_t *other_k)
{
    if (s->type == DAFT_GEOMETRY_FIELD) {
        const daft_height_field *f = s->field;
        const struct across *a = &field_across[triangle & 1][k];
        uint32_t cell = triangle / 2, column = cell % (f->columns - 1), row = cell / (f->columns - 1);
        column = (uint32_t)((int)column + a->cell_x), row = (uint32_t)((int)row + a->cell_z);
        *other = 2 * (row * (f->columns - 1) + column) + a->triangle, *other_k = a->k;
        return is_cell(f, column, row);
    }
    uint32_t across = s->mesh->neighbours[3 * (size_t)triangle + k];
    *other = across / 3, *other_k = across % 3;
    return across != DAFT_NO_FEATURE;
}

/* ---- at rest ---- */

static void visit_leaf(const daft_bvh *bvh, uint32_t code, daft_triangle_visit *visit, void *context)
{
    uint32_t first = (code & ~DAFT_CHILD_LEAF) >> 2, blocks = (code & 3) + 1;
    for (uint32_t b = first; b < first + blocks; b++)
        for (uint32_t i = 0; i < DAFT_BLOCK; i++)
            if (bvh->blocks[b].triangle[i] != DAFT_NO_TRIANGLE) visit(context, bvh->blocks[b].triangle[i]);
}

static void query_mesh(const daft_bvh *bvh, const daft_aabb *q, daft_triangle_visit *visit, void *context)
{
    uint32_t stack[DAFT_STACK], depth = 0;
    if (bvh->nodes.count > 0) stack[depth++] = 0;
    while (depth > 0) {
        const daft_node *n = &bvh->nodes.items[stack[--depth]];
        for (int i = 0; i < DAFT_WIDTH; i++) {
            if (n->child[i] == DAFT_CHILD_NONE) continue;
            if (n->bounds[0][i] > q->high.x || n->bounds[1][i] > q->high.y || n->bounds[2][i] > q->high.z) continue;
            if (n->bounds[3][i] < q->low.x || n->bounds[4][i] < q->low.y || n->bounds[5][i] < q->low.z) continue;
            if (n->child[i] & DAFT_CHILD_LEAF)
                visit_leaf(bvh, n->child[i], visit, context);
            else if (depth < DAFT_STACK)
                stack[depth++] = n->child[i];
        }
    }
}

/* The cell that holds x, within 0..count - 1. */
static uint32_t cell_at(float x, float spacing, uint32_t count)
{
    float cell = x / spacing;
    if (!(cell > 0)) return 0;
    return cell < (float)(count - 1) ? (uint32_t)cell : count - 1;
}

static void visit_cells(const daft_height_field *f, const uint32_t from[2], const uint32_t to[2], float low, float high,
                        daft_triangle_visit *visit, void *context)
{
    for (uint32_t row = from[1]; row <= to[1]; row++)
        for (uint32_t column = from[0]; column <= to[0]; column++) {
            const float *h = f->heights + (size_t)row * f->columns + column, *k = h + f->columns;
            if (!is_cell(f, column, row)) continue;
            if (h[0] > high && h[1] > high && k[0] > high && k[1] > high) continue;
            if (h[0] < low && h[1] < low && k[0] < low && k[1] < low) continue;
            uint32_t cell = row * (f->columns - 1) + column;
            visit(context, 2 * cell);
            visit(context, 2 * cell + 1);
        }
}

static void query_field(const daft_height_field *f, const daft_aabb *q, daft_triangle_visit *visit, void *context)
{
    float x = (float)(f->columns - 1) * f->spacing_x, z = (float)(f->rows - 1) * f->spacing_z;
    if (!(q->low.y <= f->high && q->high.y >= f->low) || q->low.x > x || q->low.z > z || q->high.x < 0 || q->high.z < 0)
        return;
    uint32_t from[2] = {cell_at(q->low.x, f->spacing_x, f->columns - 1), cell_at(q->low.z, f->spacing_z, f->rows - 1)};
    uint32_t to[2] = {cell_at(q->high.x, f->spacing_x, f->columns - 1), cell_at(q->high.z, f->spacing_z, f->rows - 1)};
    visit_cells(f, from, to, q->low.y, q->high.y, visit, context);
}

void daft_triangles_query(const daft_sim_shape *s, const daft_aabb *bounds, daft_triangle_visit *visit, void *context)
{
    if (s->type == DAFT_GEOMETRY_FIELD)
        query_field(s->field, bounds, visit, context);
    else
        query_mesh(s->mesh->bvh, bounds, visit, context);
}

/* ---- on the way ---- */

bool daft_sweep_meets(daft_dvec3 origin, daft_dvec3 direction, daft_dvec3 reach, daft_dvec3 low, daft_dvec3 high,
                      double tmax, double *enter)
{
    double first = 0, last = tmax;
    for (int k = 0; k < 3; k++) {
        double o = daft_dv3_at(origin, k), d = daft_dv3_at(direction, k), r = daft_dv3_at(reach, k);
        double more = r + 1e-12 * (fabs(o) + fabs(d));
        double l = daft_dv3_at(low, k) - more, h = daft_dv3_at(high, k) + more;
        if (d == 0) {
            if (o < l || o > h) return false;
            continue;
        }
        double t0 = (l - o) / d, t1 = (h - o) / d;
        first = fmax(first, fmin(t0, t1));
        last = fmin(last, fmax(t0, t1));
    }
    *enter = first;
    return first <= last;
}

typedef struct sweep {
    daft_dvec3 origin, direction, reach;
    const double *tmax;
    daft_triangle_visit *visit;
    void *context;
} sweep;

typedef struct entry {
    double enter;
    uint32_t code;
} entry;

/* Sorts so that the first is the farthest: the nearest is popped first. */
static void sort_entries(entry *list, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        entry moved = list[i];
        uint32_t k = i;
        for (; k > 0 && list[k - 1].enter < moved.enter; k--) list[k] = list[k - 1];
        list[k] = moved;
    }
}

static uint32_t push_children(const sweep *s, const daft_node *n, entry *stack, uint32_t depth)
{
    uint32_t count = 0;
    for (int i = 0; i < DAFT_WIDTH && depth + count < DAFT_STACK; i++) {
        const float(*b)[DAFT_WIDTH] = n->bounds;
        entry e = {0, n->child[i]};
        if (e.code == DAFT_CHILD_NONE) continue;
        daft_dvec3 low = daft_dv3((double)b[0][i], (double)b[1][i], (double)b[2][i]);
        daft_dvec3 high = daft_dv3((double)b[3][i], (double)b[4][i], (double)b[5][i]);
        if (daft_sweep_meets(s->origin, s->direction, s->reach, low, high, *s->tmax, &e.enter))
            stack[depth + count++] = e;
    }
    sort_entries(stack + depth, count);
    return depth + count;
}

static void sweep_mesh(const sweep *s, const daft_bvh *bvh)
{
    entry stack[DAFT_STACK];
    uint32_t depth = 0;
    if (bvh->nodes.count > 0) stack[depth++] = (entry){0, 0};
    while (depth > 0) {
        entry e = stack[--depth];
        if (e.enter > *s->tmax) continue;
        if (e.code & DAFT_CHILD_LEAF)
            visit_leaf(bvh, e.code, s->visit, s->context);
        else
            depth = push_children(s, &bvh->nodes.items[e.code], stack, depth);
    }
}

/* Box of a field's block; false for a hole. */
static bool block_box(const daft_height_field *f, uint32_t level, uint32_t x, uint32_t z, daft_dvec3 *low,
                      daft_dvec3 *high)
{
    const float *range = f->ranges + 2 * (size_t)(f->level_first[level] + z * f->level_columns[level] + x);
    if (isnan(range[0])) return false;
    double width = (double)(BLOCK << level) * (double)f->spacing_x,
           depth = (double)(BLOCK << level) * (double)f->spacing_z;
    *low = daft_dv3(x * width, (double)range[0], z * depth);
    *high = daft_dv3((x + 1) * width, (double)range[1], (z + 1) * depth);
    return true;
}

static void sweep_cells(const sweep *s, const daft_height_field *f, uint32_t x, uint32_t z)
{
    for (uint32_t row = z * BLOCK; row < (z + 1) * BLOCK && row < f->rows - 1; row++)
        for (uint32_t column = x * BLOCK; column < (x + 1) * BLOCK && column < f->columns - 1; column++) {
            double enter, dx = (double)f->spacing_x, dz = (double)f->spacing_z;
            if (!is_cell(f, column, row)) continue;
            daft_dvec3 low = daft_dv3(column * dx, (double)f->low, row * dz);
            daft_dvec3 high = daft_dv3((column + 1) * dx, (double)f->high, (row + 1) * dz);
            if (!daft_sweep_meets(s->origin, s->direction, s->reach, low, high, *s->tmax, &enter)) continue;
            uint32_t cell = row * (f->columns - 1) + column;
            s->visit(s->context, 2 * cell);
            s->visit(s->context, 2 * cell + 1);
        }
}

/* The depth of recursion is the number of levels. */
static void sweep_block(const sweep *s, const daft_height_field *f, uint32_t level, uint32_t x, uint32_t z)
{
    entry list[4];
    uint32_t count = 0;
    if (level == 0) {
        sweep_cells(s, f, x, z);
        return;
    }
    for (uint32_t i = 0; i < 4; i++) {
        uint32_t cx = 2 * x + (i & 1), cz = 2 * z + (i >> 1);
        daft_dvec3 low, high;
        if (cx >= f->level_columns[level - 1] || cz >= f->level_rows[level - 1]) continue;
        if (!block_box(f, level - 1, cx, cz, &low, &high)) continue;
        entry e = {0, i};
        if (daft_sweep_meets(s->origin, s->direction, s->reach, low, high, *s->tmax, &e.enter)) list[count++] = e;
    }
    sort_entries(list, count);
    while (count > 0) {
        entry e = list[--count];
        if (e.enter <= *s->tmax) sweep_block(s, f, level - 1, 2 * x + (e.code & 1), 2 * z + (e.code >> 1));
    }
}

void daft_triangles_sweep(const daft_sim_shape *s, daft_dvec3 origin, daft_dvec3 direction, daft_dvec3 reach,
                          const double *tmax, daft_triangle_visit *visit, void *context)
{
    sweep w = {origin, direction, reach, tmax, visit, context};
    if (s->type == DAFT_GEOMETRY_FIELD)
        sweep_block(&w, s->field, s->field->levels - 1, 0, 0);
    else
        sweep_mesh(&w, s->mesh->bvh);
}
