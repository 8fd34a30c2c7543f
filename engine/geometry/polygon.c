/* Polygons to triangles, in double, relative to the first corner.
 *
 * Ear clipping (Meisters 1975; with each corner's convexity kept up to date as in Eberly, "Triangulation by ear
 * clipping"): an ear is a convex corner whose triangle holds no other corner. Only reflex corners can lie in it; they
 * are sorted along one axis, so that a test looks at those beside the triangle only. */
#include "geometry/polygon.h"

#include <string.h>

enum { TESTS_PER_CORNER = 4096 };

static bool replace(const daft_allocator *allocator, void *array_pointer, size_t count, size_t size)
{
    void *fresh = daft_alloc(allocator, count, size), *old;
    if (!fresh) return false;
    memcpy(&old, array_pointer, sizeof old);
    daft_release(allocator, old);
    memcpy(array_pointer, &fresh, sizeof fresh);
    return true;
}

bool daft_polygon_reserve(const daft_allocator *allocator, daft_polygon *polygon, uint32_t count)
{
    if (count <= polygon->capacity) return true;
    size_t room = (size_t)count + count / 2 + 8;
    if (room > UINT32_MAX / 3) room = count;
    polygon->capacity = 0;
    if (!replace(allocator, &polygon->points, room, sizeof(daft_dvec3))) return false;
    if (!replace(allocator, &polygon->triangles, 3 * room, sizeof(uint32_t))) return false;
    if (!replace(allocator, &polygon->next, room, sizeof(uint32_t))) return false;
    if (!replace(allocator, &polygon->previous, room, sizeof(uint32_t))) return false;
    if (!replace(allocator, &polygon->u, room, sizeof(double))) return false;
    if (!replace(allocator, &polygon->v, room, sizeof(double))) return false;
    if (!replace(allocator, &polygon->sorted, room, sizeof(uint32_t))) return false;
    if (!replace(allocator, &polygon->reflex, room, 1)) return false;
    polygon->capacity = (uint32_t)room;
    return true;
}

void daft_polygon_free(const daft_allocator *allocator, daft_polygon *polygon)
{
    daft_release(allocator, polygon->points);
    daft_release(allocator, polygon->triangles);
    daft_release(allocator, polygon->next);
    daft_release(allocator, polygon->previous);
    daft_release(allocator, polygon->u);
    daft_release(allocator, polygon->v);
    daft_release(allocator, polygon->sorted);
    daft_release(allocator, polygon->reflex);
    *polygon = (daft_polygon){0};
}

static void put(uint32_t **out, uint32_t a, uint32_t b, uint32_t c)
{
    (*out)[0] = a, (*out)[1] = b, (*out)[2] = c;
    *out += 3;
}

static daft_dvec3 normal_of(daft_dvec3 a, daft_dvec3 b, daft_dvec3 c)
{
    return daft_dcross(daft_dsub(b, a), daft_dsub(c, a));
}

/* The first diagonal, unless its two triangles face apart and the other diagonal's do not. */
static void cut_quad(const daft_dvec3 *p, uint32_t *out)
{
    double first = daft_ddot(normal_of(p[0], p[1], p[2]), normal_of(p[0], p[2], p[3]));
    double second = daft_ddot(normal_of(p[1], p[2], p[3]), normal_of(p[1], p[3], p[0]));
    if (first > 0 || !(second > 0)) {
        put(&out, 0, 1, 2);
        put(&out, 0, 2, 3);
    } else {
        put(&out, 1, 2, 3);
        put(&out, 1, 3, 0);
    }
}

static double cross_at(const daft_polygon *polygon, uint32_t a, uint32_t b, uint32_t c)
{
    const double *u = polygon->u, *v = polygon->v;
    return (u[b] - u[a]) * (v[c] - v[a]) - (v[b] - v[a]) * (u[c] - u[a]);
}

/* Drops the coordinate in which the polygon's vector area (Newell) is largest, keeping the winding counter-clockwise.
 */
static void project(daft_polygon *polygon, uint32_t count)
{
    const daft_dvec3 *p = polygon->points;
    daft_dvec3 area = {0, 0, 0};
    for (uint32_t i = 1; i + 1 < count; i++) area = daft_dadd(area, normal_of(p[0], p[i], p[i + 1]));
    double x = fabs(area.x), y = fabs(area.y), z = fabs(area.z);
    int axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    bool flip = (axis == 0 ? area.x : axis == 1 ? area.y : area.z) < 0;
    for (uint32_t i = 0; i < count; i++) {
        double u = axis == 0 ? p[i].y : axis == 1 ? p[i].z : p[i].x;
        double v = axis == 0 ? p[i].z : axis == 1 ? p[i].x : p[i].y;
        polygon->u[i] = flip ? v : u;
        polygon->v[i] = flip ? u : v;
    }
}

/* No reflex corner, and it goes round once: both coordinates change direction at most twice. */
static bool is_convex(const daft_polygon *polygon, uint32_t count)
{
    unsigned turns = 0;
    double last_u = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t b = i + 1 < count ? i + 1 : 0, c = b + 1 < count ? b + 1 : 0;
        if (!(cross_at(polygon, i, b, c) >= 0)) return false;
        double du = polygon->u[b] - polygon->u[i];
        if (du == 0) continue;
        turns += last_u * du < 0;
        last_u = du > 0 ? 1 : -1;
    }
    return turns <= 2;
}

static void update_reflex(daft_polygon *polygon, uint32_t i)
{
    polygon->reflex[i] = !(cross_at(polygon, polygon->previous[i], i, polygon->next[i]) > 0);
}

static bool same_point(const daft_polygon *polygon, uint32_t a, uint32_t b)
{
    return polygon->u[a] == polygon->u[b] && polygon->v[a] == polygon->v[b];
}

/* Heap sort of corners by u: no recursion, no worst case. */
static void sift_down(const double *u, uint32_t *heap, uint32_t at, uint32_t count)
{
    for (uint32_t child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && u[heap[child + 1]] > u[heap[child]]) child++;
        if (!(u[heap[child]] > u[heap[at]])) return;
        uint32_t swapped = heap[at];
        heap[at] = heap[child], heap[child] = swapped;
    }
}

static void sort_by_u(const double *u, uint32_t *corners, uint32_t count)
{
    for (uint32_t i = count / 2; i-- > 0;) sift_down(u, corners, i, count);
    for (uint32_t left = count; left > 1;) {
        left--;
        uint32_t swapped = corners[0];
        corners[0] = corners[left], corners[left] = swapped;
        sift_down(u, corners, 0, left);
    }
}

/* The first sorted corner whose u is not below `low`. */
static uint32_t first_from(const daft_polygon *polygon, uint32_t count, double low)
{
    uint32_t first = 0;
    while (count > 0) {
        uint32_t half = count / 2;
        if (polygon->u[polygon->sorted[first + half]] < low)
            first += half + 1, count -= half + 1;
        else
            count = half;
    }
    return first;
}

/* Corners on the same spot as one of the triangle's do not count as inside: outlines with holes touch themselves along
 * the cut to the hole. */
static bool is_inside(const daft_polygon *polygon, uint32_t a, uint32_t b, uint32_t c, uint32_t p)
{
    if (p == a || p == b || p == c || !polygon->reflex[p]) return false;
    if (cross_at(polygon, a, b, p) < 0 || cross_at(polygon, b, c, p) < 0 || cross_at(polygon, c, a, p) < 0)
        return false;
    return !same_point(polygon, p, a) && !same_point(polygon, p, b) && !same_point(polygon, p, c);
}

static bool is_ear(const daft_polygon *polygon, uint32_t i, uint32_t reflex_count, uint64_t *budget)
{
    --*budget;
    if (polygon->reflex[i]) return false;
    uint32_t a = polygon->previous[i], c = polygon->next[i];
    const double *u = polygon->u;
    double low = fmin(u[a], fmin(u[i], u[c])), high = fmax(u[a], fmax(u[i], u[c]));
    for (uint32_t k = first_from(polygon, reflex_count, low); k < reflex_count; k++) {
        uint32_t p = polygon->sorted[k];
        if (u[p] > high) break;
        if (*budget == 0) return false;
        --*budget;
        if (is_inside(polygon, a, i, c, p)) return false;
    }
    return true;
}

static void clip(daft_polygon *polygon, uint32_t i, uint32_t **out)
{
    uint32_t a = polygon->previous[i], c = polygon->next[i];
    put(out, a, i, c);
    polygon->next[a] = c;
    polygon->previous[c] = a;
    polygon->reflex[i] = 0;
    update_reflex(polygon, a);
    update_reflex(polygon, c);
}

/* The corner to cut where the outline has no ear (it crosses or touches itself): one that takes no area, if any. */
static uint32_t corner_without_area(const daft_polygon *polygon, uint32_t start)
{
    uint32_t i = start;
    do {
        if (cross_at(polygon, polygon->previous[i], i, polygon->next[i]) == 0) return i;
        i = polygon->next[i];
    } while (i != start);
    return start;
}

/* Rings the corners; returns how many of them are reflex. */
static uint32_t prepare_ears(daft_polygon *polygon, uint32_t count)
{
    uint32_t reflex_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        polygon->next[i] = i + 1 < count ? i + 1 : 0;
        polygon->previous[i] = i ? i - 1 : count - 1;
        update_reflex(polygon, i);
        if (polygon->reflex[i]) polygon->sorted[reflex_count++] = i;
    }
    sort_by_u(polygon->u, polygon->sorted, reflex_count);
    return reflex_count;
}

static bool clip_ears(daft_polygon *polygon, uint32_t count)
{
    uint32_t *out = polygon->triangles;
    uint32_t reflex_count = prepare_ears(polygon, count);
    uint64_t budget = (uint64_t)count * TESTS_PER_CORNER;
    uint32_t at = 0, tried = 0;
    for (uint32_t left = count; left > 3;) {
        uint32_t next = polygon->next[at];
        if (budget > 0 && tried < left && !is_ear(polygon, at, reflex_count, &budget)) {
            tried++;
            at = next;
            continue;
        }
        if (tried >= left) {
            at = corner_without_area(polygon, at);
            next = polygon->next[at];
        }
        clip(polygon, at, &out);
        left--;
        tried = 0;
        at = polygon->next[next]; /* skipping one keeps the triangles from becoming a fan of slivers */
    }
    put(&out, polygon->previous[at], at, polygon->next[at]);
    return budget > 0;
}

bool daft_polygon_triangulate(daft_polygon *polygon, uint32_t count)
{
    uint32_t *out = polygon->triangles;
    if (count == 3) {
        put(&out, 0, 1, 2);
        return true;
    }
    if (count == 4) {
        cut_quad(polygon->points, out);
        return true;
    }
    project(polygon, count);
    if (!is_convex(polygon, count)) return clip_ears(polygon, count);
    for (uint32_t i = 1; i + 1 < count; i++) put(&out, 0, i, i + 1);
    return true;
}
