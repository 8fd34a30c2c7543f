/* The rays of a laser scanner: which way each leaves, from where, and when. */
#include "math/trig.h"
#include "scene/fields/check.h"
#include "scene/query/query.h"

enum { MOST_RAYS = 1 << 28 };

daft_scan_def daft_default_scan_def(void)
{
    daft_scan_def def;
    daft_struct_default(DAFT_STRUCT_SCAN_DEF, &def);
    return def;
}

static uint64_t rays_of(const daft_scan_def *def)
{
    return def->pattern == DAFT_SCAN_RAYS ? def->ray_count : (uint64_t)def->rows * def->columns;
}

bool daft_scan_def_check(const daft_scan_def *def, daft_error *error)
{
    if (!daft_check_pointer(error, "def", def) || !daft_struct_check(DAFT_STRUCT_SCAN_DEF, def, error)) return false;
    const uint64_t rays = rays_of(def);
    if (rays > MOST_RAYS)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "%llu rays in one scan; at most %d are possible",
                         (unsigned long long)rays, (int)MOST_RAYS);
    if (!(def->max_range >= def->min_range))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "max_range is %g; it must be at least min_range, %g",
                         (double)def->max_range, (double)def->min_range);
    if (def->pattern != DAFT_SCAN_RAYS) return true;
    if (def->ray_count > 0 && !daft_check_pointer(error, "rays", def->rays)) return false;
    for (uint32_t i = 0; i < def->ray_count; i++)
        if (!daft_check_direction(error, "one of the rays", def->rays[i])) return false;
    return true;
}

uint32_t daft_scan_size(const daft_scan_def *def)
{
    return daft_scan_def_check(def, NULL) ? (uint32_t)rays_of(def) : 0;
}

/* ---- directions ---- */

/* Angle number i of `count` from `first` to `last`; around a circle the last is the one before the first again. */
static double angle_at(double first, double last, uint32_t count, uint32_t i, bool around)
{
    const uint32_t steps = around ? count : count - 1;
    return steps == 0 ? first : first + (last - first) * i / steps;
}

static void row_of(const daft_scan_def *def, uint32_t i, double out[2])
{
    const double angle = angle_at((double)def->bottom, (double)def->top, def->rows, i, false);
    out[0] = daft_sin(angle), out[1] = daft_cos(angle);
}

static void column_of(const daft_scan_def *def, uint32_t i, double out[2])
{
    const bool around = def->pattern == DAFT_SCAN_SPINNING;
    const double first = around ? 0 : (double)def->left, last = around ? 2 * DAFT_PI : (double)def->right;
    const double angle = angle_at(first, last, def->columns, i, around);
    out[0] = daft_sin(angle), out[1] = daft_cos(angle);
}

static daft_dvec3 from_angles(const double row[2], const double column[2])
{
    return daft_dv3(row[1] * column[1], row[0], row[1] * column[0]);
}

/* Without its sines and cosines. */
static daft_scan_table plain_table(const daft_scan_def *def)
{
    enum { LIST_LINE = 1024 };
    const bool spins = def->pattern == DAFT_SCAN_SPINNING;
    if (def->pattern == DAFT_SCAN_RAYS)
        return (daft_scan_table){.def = def, .fast = LIST_LINE, .slow = (def->ray_count + LIST_LINE - 1) / LIST_LINE};
    return (daft_scan_table){
        .def = def, .fast = spins ? def->rows : def->columns, .slow = spins ? def->columns : def->rows};
}

bool daft_scan_table_open(const daft_allocator *allocator, const daft_scan_def *def, daft_scan_table *out,
                          daft_error *error)
{
    *out = plain_table(def);
    if (def->pattern == DAFT_SCAN_RAYS) return true;
    out->row = daft_alloc(allocator, (size_t)def->rows + def->columns, 2 * sizeof *out->row);
    if (!out->row) return daft_fail_memory(error, "a scan");
    out->column = out->row + 2 * (size_t)def->rows;
    for (uint32_t i = 0; i < def->rows; i++) row_of(def, i, &out->row[2 * i]);
    for (uint32_t i = 0; i < def->columns; i++) column_of(def, i, &out->column[2 * i]);
    return true;
}

void daft_scan_table_close(const daft_allocator *allocator, daft_scan_table *table)
{
    daft_release(allocator, table->row);
}

/* ---- the sensor's way ---- */

typedef struct pose {
    daft_dvec3 position;
    double m[9]; /* from the sensor's axes to the world's */
} pose;

static void multiply(const double a[9], const double b[9], double out[9])
{
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++)
            out[3 * row + k] = a[3 * row] * b[k] + a[3 * row + 1] * b[3 + k] + a[3 * row + 2] * b[6 + k];
}

/* Turned about a unit axis (Rodrigues). */
static void turn(daft_dvec3 axis, double angle, double m[9])
{
    const double s = daft_sin(angle), c = daft_cos(angle), x = axis.x, y = axis.y, z = axis.z, d = 1 - c;
    const double turned[9] = {c + d * x * x,     d * x * y - s * z, d * x * z + s * y, d * x * y + s * z, c + d * y * y,
                              d * y * z - s * x, d * x * z - s * y, d * y * z + s * x, c + d * z * z};
    double old[9];
    for (int i = 0; i < 9; i++) old[i] = m[i];
    multiply(turned, old, m);
}

static pose pose_at(const daft_scan_def *def, double time)
{
    const daft_dvec3 spin = daft_to_double(def->spin);
    const double rate = sqrt(daft_ddot(spin, spin));
    pose p = {.position = daft_dadd(def->position, daft_dscale(daft_to_double(def->velocity), time))};
    daft_quat_matrix(daft_quat_normalize(def->rotation), p.m);
    if (rate * time != 0) turn(daft_dscale(spin, 1 / rate), rate * time, p.m);
    return p;
}

/* When a ray leaves. Those of a column of beams leave together, and so do those of a row of a grid. */
static double time_of(const daft_scan_table *table, uint32_t line, uint32_t number)
{
    const daft_scan_def *def = table->def;
    const bool list = def->pattern == DAFT_SCAN_RAYS;
    const double share = list ? ((double)line * table->fast + number) / def->ray_count : (double)line / table->slow;
    return (double)def->duration * share;
}

static daft_vec3 to_world(const pose *p, daft_dvec3 v)
{
    const double *m = p->m;
    return daft_v3((float)(m[0] * v.x + m[1] * v.y + m[2] * v.z), (float)(m[3] * v.x + m[4] * v.y + m[5] * v.z),
                   (float)(m[6] * v.x + m[7] * v.y + m[8] * v.z));
}

static daft_dvec3 unit(daft_vec3 v)
{
    const daft_dvec3 d = daft_to_double(v);
    return daft_dscale(d, 1 / sqrt(daft_ddot(d, d)));
}

void daft_scan_lines(const daft_scan_table *table, uint32_t line, uint32_t first, uint32_t count, daft_scan_line *out)
{
    const daft_scan_def *def = table->def;
    double time = time_of(table, line, first);
    pose p = pose_at(def, time);
    const bool spins = def->pattern == DAFT_SCAN_SPINNING, list = def->pattern == DAFT_SCAN_RAYS;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t other = first + i, row = spins ? other : line, column = spins ? line : other;
        if (list && i > 0 && def->duration > 0) time = time_of(table, line, other), p = pose_at(def, time);
        const daft_dvec3 own = table->row ? from_angles(&table->row[2 * row], &table->column[2 * column])
                                          : unit(def->rays[(size_t)line * table->fast + other]);
        out[i] = (daft_scan_line){p.position, to_world(&p, own), time};
    }
}

bool daft_scan_ray(const daft_scan_def *def, uint32_t index, daft_dvec3 *origin, daft_vec3 *direction, double *seconds,
                   daft_error *error)
{
    double row[2], column[2];
    daft_error_clear(error);
    if (!daft_scan_def_check(def, error)) return false;
    if (index >= rays_of(def))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "ray %u; the scan has %u", index, (uint32_t)rays_of(def));
    const daft_scan_table table = plain_table(def);
    const bool spins = def->pattern == DAFT_SCAN_SPINNING, list = def->pattern == DAFT_SCAN_RAYS;
    const uint32_t line = index / table.fast, other = index % table.fast;
    const double time = time_of(&table, line, other);
    const pose p = pose_at(def, time);
    if (!list) row_of(def, spins ? other : line, row), column_of(def, spins ? line : other, column);
    if (origin) *origin = p.position;
    if (direction) *direction = to_world(&p, list ? unit(def->rays[index]) : from_angles(row, column));
    if (seconds) *seconds = time;
    return true;
}
