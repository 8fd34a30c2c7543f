/* Which cells of a grid over a mesh are inside (inner.h), and how far.
 *
 * Cells that a triangle or a cap's box reaches into are walls. The others that hang together by faces have one winding
 * number, which one line tells: crossings of half a line are decided exactly, edges and corners given to one triangle each. */
#include "accel/find_inner.h"
#include "math/exact.h"

enum {
    FINE = 40,       /* cells along the longest axis, and a ring of one around */
    WORK_A_TRIANGLE = 24,
    ROOMS = 16       /* of those that hang together, so many are asked for their number */
};
#define SLACK 0x1p-8 /* of a cell: over rounding */

enum { OPEN, WALL, OUTSIDE, INSIDE, HOLLOW };

typedef struct grid {
    daft_inner_search *s;
    uint8_t *kind;
    uint32_t *stack;
    uint64_t work;
} grid;

/* False: cells would not be much larger than what floats can tell there. */
static bool lay_out(daft_inner_search *s)
{
    const float *low = &s->mesh->low.x, *high = &s->mesh->high.x;
    double longest = 0, farthest = 0;
    for (int k = 0; k < 3; k++) {
        longest = fmax(longest, (double)high[k] - (double)low[k]);
        farthest = fmax(farthest, fmax(fabs((double)low[k]), fabs((double)high[k])));
    }
    s->cell = longest / FINE, s->cell_count = 1;
    if (!(s->cell > farthest * 0x1p-19)) return false;
    for (int k = 0; k < 3; k++) {
        double size = (double)high[k] - (double)low[k];
        s->size[k] = (uint32_t)(size / s->cell + 0.5) + 3;
        s->low[k] = (double)low[k] + 0.5 * (size - s->size[k] * s->cell);
        s->cell_count *= s->size[k];
    }
    return true;
}

/* The cells that an interval touches, a little larger: always of the grid. */
static void cells_of(const daft_inner_search *s, int k, double low, double high, uint32_t range[2])
{
    double last = s->size[k] - 1, from = (low - s->low[k]) / s->cell - SLACK, to = (high - s->low[k]) / s->cell + SLACK;
    range[0] = (uint32_t)fmin(fmax(from, 0), last), range[1] = (uint32_t)fmin(fmax(to, 0), last);
}

/* A plane n·p = at; n = 0 meets all boxes. */
typedef struct plane {
    daft_dvec3 n;
    double at, reach; /* of a cell along n */
} plane;

/* False: that is too much work. */
static bool mark(grid *g, const double low[3], const double high[3], const plane *cut)
{
    const daft_inner_search *s = g->s;
    uint32_t r[3][2];
    for (int k = 0; k < 3; k++) cells_of(s, k, low[k], high[k], r[k]);
    uint64_t cells = (uint64_t)(r[0][1] - r[0][0] + 1) * (r[1][1] - r[1][0] + 1) * (r[2][1] - r[2][0] + 1);
    bool small = cells <= 4;
    if (g->work < cells) return false;
    g->work -= cells;
    for (uint32_t z = r[2][0]; z <= r[2][1]; z++)
        for (uint32_t y = r[1][0]; y <= r[1][1]; y++)
            for (uint32_t x = r[0][0]; x <= r[0][1]; x++) {
                uint32_t cell = (z * s->size[1] + y) * s->size[0] + x;
                if (!small && fabs(daft_ddot(cut->n, daft_cell_middle(s, cell)) - cut->at) > cut->reach) continue;
                g->kind[cell] = WALL;
            }
    return true;
}

static daft_dvec3 corner(const daft_trimesh *mesh, uint32_t triangle, uint32_t k)
{
    uint32_t vertex = mesh->indices[3 * (size_t)triangle + k];
    return daft_dv3((double)mesh->x[vertex], (double)mesh->y[vertex], (double)mesh->z[vertex]);
}

static bool mark_triangle(grid *g, uint32_t triangle)
{
    daft_dvec3 a = corner(g->s->mesh, triangle, 0), b = corner(g->s->mesh, triangle, 1), c = corner(g->s->mesh, triangle, 2);
    const double low[3] = {fmin(a.x, fmin(b.x, c.x)), fmin(a.y, fmin(b.y, c.y)), fmin(a.z, fmin(b.z, c.z))};
    const double high[3] = {fmax(a.x, fmax(b.x, c.x)), fmax(a.y, fmax(b.y, c.y)), fmax(a.z, fmax(b.z, c.z))};
    plane cut = {.n = daft_dcross(daft_dsub(b, a), daft_dsub(c, a))};
    cut.at = daft_ddot(cut.n, a);
    cut.reach = (fabs(cut.n.x) + fabs(cut.n.y) + fabs(cut.n.z)) * g->s->cell * (0.5 + SLACK);
    return mark(g, low, high, &cut);
}

static bool mark_walls(grid *g)
{
    const daft_inner *caps = g->s->out;
    const plane none = {.reach = 0};
    for (uint32_t i = 0; i < caps->cap_count; i++) {
        double low[3], high[3];
        for (int k = 0; k < 3; k++) low[k] = (double)caps->caps.bounds[k][i], high[k] = (double)caps->caps.bounds[3 + k][i];
        if (!mark(g, low, high, &none)) return false;
    }
    for (uint32_t i = 0; i < g->s->mesh->triangle_count; i++)
        if (!mark_triangle(g, i)) return false;
    return true;
}

/* All open cells that hang together with this one become of a kind; gives their number. They are on the stack then. */
static uint32_t flood(grid *g, uint32_t first, uint8_t kind)
{
    const uint32_t *size = g->s->size, step[3] = {1, size[0], size[0] * size[1]};
    uint32_t done = 0, count = 1;
    g->stack[0] = first, g->kind[first] = kind;
    for (; done < count; done++) {
        uint32_t cell = g->stack[done];
        const uint32_t at[3] = {cell % size[0], cell / size[0] % size[1], cell / step[2]};
        for (int side = 0; side < 6; side++) {
            int k = side / 2;
            if (side % 2 ? at[k] + 1 == size[k] : at[k] == 0) continue;
            uint32_t next = side % 2 ? cell + step[k] : cell - step[k];
            if (g->kind[next] != OPEN) continue;
            g->kind[next] = kind, g->stack[count++] = next;
        }
    }
    return count;
}

/* ---- winding numbers ---- */

/* Half a line, from a point along an axis or against it. */
typedef struct half_line {
    daft_vec3 from;
    int axis;
    bool back;
} half_line;

static daft_vec3 direction_of(const half_line *l)
{
    daft_vec3 d = {0, 0, 0};
    (&d.x)[l->axis] = l->back ? -1 : 1;
    return d;
}

static bool meets_caps(const daft_inner *caps, const half_line *l)
{
    const float *p = &l->from.x;
    for (uint32_t i = 0; i < caps->cap_count; i++) {
        bool meets = true;
        for (int k = 0; k < 3; k++) {
            bool low = p[k] >= caps->caps.bounds[k][i], high = p[k] <= caps->caps.bounds[3 + k][i];
            meets = meets && (k != l->axis ? low && high : l->back ? low : high);
        }
        if (meets) return true;
    }
    return false;
}

/* Whether it may meet a box around the triangle. */
static bool may_cross(const half_line *l, const daft_vec3 c[3])
{
    for (int k = 0; k < 3; k++) {
        float p = (&l->from.x)[k], a = (&c[0].x)[k], b = (&c[1].x)[k], d = (&c[2].x)[k];
        bool low = p < a && p < b && p < d, high = p > a && p > b && p > d;
        if (k != l->axis ? low || high : l->back ? low : high) return false;
    }
    return true;
}

/* Adds what crosses it: 1 where it goes out. False: that is not sure. */
static bool add_crossing(const half_line *l, const daft_vec3 c[3], double clear, int *sum)
{
    daft_vec3 d = direction_of(l);
    if (!daft_line_hits(l->from, c[0], c[1], c[2], d)) return true;
    daft_dvec3 a = daft_to_double(c[0]), n = daft_dcross(daft_dsub(daft_to_double(c[1]), a), daft_dsub(daft_to_double(c[2]), a));
    double slope = daft_ddot(n, daft_to_double(d)), t = daft_ddot(n, daft_dsub(a, daft_to_double(l->from))) / slope;
    if (!(fabs(slope) > 1e-9 * sqrt(daft_ddot(n, n))) || !(fabs(t) > clear)) return false;
    if (t > 0) *sum += slope > 0 ? 1 : -1;
    return true;
}

/* The winding number along the half line's start. False: it is not sure. */
static bool wind(const grid *g, const half_line *l, int *sum)
{
    const daft_trimesh *mesh = g->s->mesh;
    *sum = 0;
    if (meets_caps(g->s->out, l)) return false;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *v = &mesh->indices[3 * (size_t)i];
        const daft_vec3 c[3] = {{mesh->x[v[0]], mesh->y[v[0]], mesh->z[v[0]]},
                                {mesh->x[v[1]], mesh->y[v[1]], mesh->z[v[1]]},
                                {mesh->x[v[2]], mesh->y[v[2]], mesh->z[v[2]]}};
        if (may_cross(l, c) && !add_crossing(l, c, g->s->cell / 4, sum)) return false;
    }
    return true;
}

/* Whether the cells that hang together with this one are known to be inside. */
static bool is_inside(const grid *g, uint32_t cell)
{
    half_line l = {.from = daft_to_float(daft_cell_middle(g->s, cell))};
    for (int side = 0; side < 6; side++) {
        int sum;
        l.axis = side / 2, l.back = side % 2;
        if (wind(g, &l, &sum)) return sum != 0;
    }
    return false;
}

/* Parts the open cells; gives whether any are inside. */
static bool part_rooms(grid *g)
{
    bool any = false;
    uint32_t rooms = 0, least = g->s->cell_count / 4096 + 8;
    flood(g, 0, OUTSIDE);
    for (uint32_t i = 0; i < g->s->cell_count && rooms < ROOMS; i++) {
        if (g->kind[i] != OPEN) continue;
        uint32_t count = flood(g, i, HOLLOW);
        if (count < least) continue;
        rooms++;
        if (!is_inside(g, g->stack[count / 2])) continue;
        any = true;
        for (uint32_t k = 0; k < count; k++) g->kind[g->stack[k]] = INSIDE;
    }
    return any;
}

/* ---- how far inside ---- */

/* The least of what the 13 neighbours before a cell, or after it, say. Cells at the grid's border are not inside. */
static void deepen(const daft_inner_search *s, uint32_t cell, int32_t sign)
{
    int32_t row = (int32_t)s->size[0], slice = row * (int32_t)s->size[1];
    uint32_t least = UINT16_MAX;
    for (int32_t z = -1; z <= 0; z++)
        for (int32_t y = -1; y <= -z; y++)
            for (int32_t x = -1; x <= (z || y ? 1 : -1); x++) {
                uint32_t steps = (uint32_t)((x != 0) + (y != 0) + (z != 0));
                uint32_t depth = s->depth[(int32_t)cell + sign * (z * slice + y * row + x)] + steps + 2u;
                least = daft_min_u(least, depth);
            }
    s->depth[cell] = (uint16_t)daft_min_u(s->depth[cell], least);
}

/* Chamfer distances of 3, 4 and 5 (Borgefors, "Distance transformations in arbitrary dimensions", 1984). */
static void measure(grid *g)
{
    daft_inner_search *s = g->s;
    for (uint32_t i = 0; i < s->cell_count; i++) s->depth[i] = g->kind[i] == INSIDE ? UINT16_MAX : 0;
    for (uint32_t i = 0; i < s->cell_count; i++)
        if (s->depth[i]) deepen(s, i, 1);
    for (uint32_t i = s->cell_count; i-- > 0;)
        if (s->depth[i]) deepen(s, i, -1);
}

bool daft_inner_fill(daft_inner_search *s)
{
    if (!lay_out(s)) return false;
    grid g = {.s = s, .work = WORK_A_TRIANGLE * (uint64_t)s->mesh->triangle_count + 16 * (uint64_t)s->cell_count};
    s->depth = daft_alloc(s->allocator, s->cell_count, sizeof *s->depth);
    g.kind = daft_alloc_zero(s->allocator, s->cell_count, sizeof *g.kind);
    g.stack = daft_alloc(s->allocator, s->cell_count, sizeof *g.stack);
    bool done = s->depth && g.kind && g.stack && mark_walls(&g) && part_rooms(&g);
    if (done) measure(&g);
    daft_release(s->allocator, g.kind);
    daft_release(s->allocator, g.stack);
    return done;
}
