/* Camera paths: a curve through checkpoints.
 *
 * Positions and the field of view follow cubic Hermite curves whose tangent at a checkpoint is the slope between its
 * neighbours (Catmull and Rom 1974, for checkpoints at any times), at most three times the slower of the slopes beside
 * it (Fritsch and Carlson 1980), so that a camera that is slow before a fast piece does not back up; the ends leave
 * along their one neighbour. Rotations follow the same curve as quaternions, each on the side of the one before it, and
 * are normalised: they are smooth, take the shorter way round, and know no gimbal that could flip. Where a pace of its
 * own replaces the checkpoints' times, the curve is the centripetal one (Yuksel and others 2011), which has no loops.
 */
#include "math/trig.h"
#include "scene/scene.h"

enum { KEYS = 8, STEPS = 32 /* of the curve's length, between two checkpoints */ };

/* A checkpoint as numbers to interpolate: position, rotation (x, y, z, w), field of view. */
typedef struct key {
    double time, value[KEYS];
} key;

/* ---- cameras as quaternions ---- */

/* The camera at rest looks along +X, its right is +Z: first rolled about X, then pitched about Z, then turned about Y.
 */
static void to_rotation(const daft_camera *camera, double q[4])
{
    double y = -(double)camera->yaw / 2, p = -(double)camera->pitch / 2, r = (double)camera->roll / 2;
    double sy = daft_sin(y), cy = daft_cos(y), sp = daft_sin(p), cp = daft_cos(p), sr = daft_sin(r), cr = daft_cos(r);
    q[0] = cy * cp * sr + sy * sp * cr;
    q[1] = sy * cp * cr + cy * sp * sr;
    q[2] = cy * sp * cr - sy * cp * sr;
    q[3] = cy * cp * cr - sy * sp * sr;
}

static void from_rotation(const double q[4], daft_camera *camera)
{
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    double x = q[0] / length, y = q[1] / length, z = q[2] / length, w = q[3] / length;
    daft_dvec3 forward = daft_dv3(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y));
    daft_dvec3 up = daft_dv3(2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x));
    double flat = sqrt(forward.x * forward.x + forward.z * forward.z);
    /* Straight up or down any yaw will do: the roll takes what it leaves. */
    double yaw = flat > 1e-9 ? daft_atan2(forward.z, forward.x) : 0;
    daft_dvec3 level = daft_dv3(-daft_sin(yaw), 0, daft_cos(yaw)), upright = daft_dcross(level, forward);
    camera->yaw = (float)yaw;
    camera->pitch = (float)daft_atan2(-forward.y, flat);
    camera->roll = (float)daft_atan2(daft_ddot(up, level), daft_ddot(up, upright));
}

static key make_key(const daft_checkpoint *point, const key *before)
{
    const daft_camera *c = &point->camera;
    key made = {point->time, {c->position.x, c->position.y, c->position.z, 0, 0, 0, 0, (double)c->fov}};
    double *q = made.value + 3, along = 0;
    to_rotation(c, q);
    for (int i = 0; before && i < 4; i++) along += q[i] * before->value[3 + i];
    for (int i = 0; along < 0 && i < 4; i++) q[i] = -q[i]; /* q and -q are the same rotation: the nearer one */
    return made;
}

/* ---- the curve ---- */

typedef struct curve {
    const daft_checkpoint *points;
    uint32_t count;
    daft_pace pace;
} curve;

static double distance(daft_dvec3 a, daft_dvec3 b)
{
    daft_dvec3 d = daft_dsub(a, b);
    return sqrt(daft_ddot(d, d));
}

/* From checkpoint i to the next: seconds, or where the pace replaces them the root of the distance. */
static double gap(const curve *c, uint32_t i)
{
    if (i + 1 >= c->count) return 0;
    if (c->pace == DAFT_PACE_TIMED) return c->points[i + 1].time - c->points[i].time;
    /* Checkpoints in one place still turn; their piece is short. */
    return sqrt(distance(c->points[i].camera.position, c->points[i + 1].camera.position)) + 1e-3;
}

/* Four keys around the piece from checkpoint i to the next, which begins at time 0; the ends stand for their missing
 * neighbours. */
static void piece_keys(const curve *c, uint32_t i, key out[4])
{
    out[0] = make_key(&c->points[i > 0 ? i - 1 : i], NULL);
    out[1] = make_key(&c->points[i], &out[0]);
    out[2] = make_key(&c->points[i + 1], &out[1]);
    out[3] = make_key(&c->points[i + 2 < c->count ? i + 2 : i + 1], &out[2]);
    out[0].time = i > 0 ? -gap(c, i - 1) : 0;
    out[1].time = 0;
    out[2].time = gap(c, i);
    out[3].time = out[2].time + gap(c, i + 1);
}

/* The slope from `a` to `b` for values first to last - 1; returns its length. */
static double slope(const key *a, const key *b, int first, int last, double out[KEYS])
{
    double length = 0, time = b->time - a->time;
    for (int i = first; i < last; i++) {
        out[i] = time > 0 ? (b->value[i] - a->value[i]) / time : 0;
        length += out[i] * out[i];
    }
    return sqrt(length);
}

static void tangent(const key *before, const key *here, const key *after, int first, int last, double out[KEYS])
{
    double unused[KEYS], come = slope(before, here, first, last, unused), go = slope(here, after, first, last, unused);
    double length = slope(before, after, first, last, out);
    bool end = !(here->time > before->time && after->time > here->time);
    double most = end ? length : 3 * fmin(come, go);
    for (int i = first; i < last && length > most; i++) out[i] *= most / length;
}

static void interpolate(const key k[4], double time, double out[KEYS])
{
    static const int groups[] = {0, 3, 7, KEYS}; /* position, rotation, field of view */
    double length = k[2].time, t = time / length, u = 1 - t, leave[KEYS], arrive[KEYS];
    for (int g = 0; g < 3; g++) {
        tangent(&k[0], &k[1], &k[2], groups[g], groups[g + 1], leave);
        tangent(&k[1], &k[2], &k[3], groups[g], groups[g + 1], arrive);
    }
    for (int i = 0; i < KEYS; i++)
        out[i] = u * u * (1 + 2 * t) * k[1].value[i] + t * t * (3 - 2 * t) * k[2].value[i] +
                 t * u * length * (u * leave[i] - t * arrive[i]);
}

/* ---- pace: which piece, and where on it ---- */

typedef struct place {
    uint32_t piece;
    double time; /* on the piece */
} place;

static place place_at_time(const curve *c, double time)
{
    uint32_t i = 0;
    while (i + 2 < c->count && time >= c->points[i + 1].time) i++;
    return (place){i, time - c->points[i].time};
}

static daft_dvec3 position_on(const key k[4], double time)
{
    double value[KEYS];
    interpolate(k, time, value);
    return daft_dv3(value[0], value[1], value[2]);
}

/* Goes along the curve in STEPS chords a piece until `wanted` metres are behind; *out is where. Returns the whole way.
 */
static double walk(const curve *c, double wanted, place *out)
{
    double gone = 0;
    for (uint32_t i = 0; i + 1 < c->count; i++) {
        key k[4];
        piece_keys(c, i, k);
        daft_dvec3 before = c->points[i].camera.position;
        double step = k[2].time / STEPS;
        for (int s = 1; s <= STEPS; s++) {
            daft_dvec3 here = position_on(k, s * step);
            double chord = distance(before, here);
            if (gone <= wanted && wanted < gone + chord) *out = (place){i, (s - 1 + (wanted - gone) / chord) * step};
            gone += chord;
            before = here;
        }
    }
    return gone;
}

/* part: of the way, 0..1. Where the path has no length, of its checkpoints. */
static place place_at_part(const curve *c, double part)
{
    if (c->pace == DAFT_PACE_EASED) part = part * part * (3 - 2 * part);
    double pieces = part * (c->count - 1);
    uint32_t i = (uint32_t)pieces < c->count - 2 ? (uint32_t)pieces : c->count - 2;
    place found = {i, (pieces - i) * gap(c, i)}, unused;
    walk(c, part * walk(c, -1, &unused), &found);
    return found;
}

/* ---- the interface ---- */

static bool check_points(const daft_checkpoint *points, uint32_t count, daft_error *error)
{
    if (count == 0) return daft_fail(error, DAFT_ERROR_ARGUMENT, "a path needs at least one checkpoint");
    for (uint32_t i = 0; i < count; i++) {
        if (!daft_check_camera(error, "checkpoint", &points[i].camera)) return false;
        if (!isfinite(points[i].time))
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "checkpoint %u: the time must be finite", i);
        if (i > 0 && !(points[i].time > points[i - 1].time))
            return daft_fail(error, DAFT_ERROR_ARGUMENT,
                             "checkpoint %u: its time, %g s, must be after that of the one "
                             "before it, %g s",
                             i, points[i].time, points[i - 1].time);
    }
    return true;
}

static daft_camera camera_at(const curve *c, double time)
{
    const daft_checkpoint *points = c->points;
    double first = points[0].time, last = points[c->count - 1].time;
    if (!(time > first)) return points[0].camera;
    if (time >= last) return points[c->count - 1].camera;
    place here =
        c->pace == DAFT_PACE_TIMED ? place_at_time(c, time) : place_at_part(c, (time - first) / (last - first));
    if (here.time == 0) return points[here.piece].camera;
    key k[4];
    double value[KEYS];
    piece_keys(c, here.piece, k);
    interpolate(k, here.time, value);
    /* The curve may swing past its checkpoints, the field of view must not: it ends at 180 degrees. */
    double wide = fmax(k[1].value[7], k[2].value[7]), narrow = fmin(k[1].value[7], k[2].value[7]);
    daft_camera camera = {.position = daft_dv3(value[0], value[1], value[2]),
                          .fov = (float)fmax(narrow, fmin(value[7], wide))};
    from_rotation(value + 3, &camera);
    return camera;
}

bool daft_path_camera(const daft_checkpoint *points, uint32_t count, daft_pace pace, double time, daft_camera *out,
                      daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "points", points) || !daft_check_pointer(error, "out", out)) return false;
    if (!check_points(points, count, error)) return false;
    if (pace < DAFT_PACE_TIMED || pace > DAFT_PACE_EASED)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "pace: %d is none of timed, constant, eased", (int)pace);
    if (isnan(time)) return daft_fail(error, DAFT_ERROR_ARGUMENT, "time: not a number");
    *out = camera_at(&(curve){points, count, pace}, time);
    return true;
}

uint32_t daft_scene_path_count(const daft_scene *scene) { return scene ? scene->path_count : 0; }

bool daft_scene_get_checkpoint(const daft_scene *scene, uint32_t index, daft_checkpoint *out, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene) || !daft_check_pointer(error, "out", out)) return false;
    if (index >= scene->path_count)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "checkpoint %u of %u; the first is 0", index, scene->path_count);
    *out = scene->path[index];
    return true;
}

bool daft_path_reserve(daft_scene *scene, uint32_t more, daft_error *error)
{
    return daft_grow(scene->allocator, &scene->path, &scene->path_capacity, (size_t)scene->path_count + more,
                     scene->path_count, sizeof *scene->path) ||
           daft_fail_memory(error, "the camera path");
}

void daft_path_insert(daft_scene *scene, const daft_checkpoint *point) { scene->path[scene->path_count++] = *point; }
