/* Redrawing only what changed. A picture is kept with all that decided it: camera, lights, instances, materials; and of
 * each tile with the box of the points that were lit and the box of the directions in which they sent rays on. The next
 * picture by the same camera asks of each tile whether a change may reach it:
 *
 * - an instance that moved, came, went or looks different: where it is or was on the screen; where the shaft from a
 *   tile's points to a light meets its bounds; where the shaft of a tile's mirrored and refracted rays does;
 * - a light: where it reaches a tile's points.
 *
 * Shafts are boxes that move along a box of directions, as in "Shaft culling for efficient ray-cast radiosity" (Haines
 * and Wallace 1991), with intervals in place of planes. All tests err towards drawing, so the picture has the bytes of
 * a full one. Tiles beside these are drawn too, since antialiasing compares neighbours.
 *
 * Sampled light differs from picture to picture, so a frame with some is drawn in full until nothing has changed for
 * twice as many pictures as are averaged; then it is kept as it is. */
#include "render/redraw.h"

#include "render/denoise.h"

#include <math.h>
#include <string.h>

/* Changed instances that are followed one by one; with more, the picture is drawn in full. Each costs up to a
 * microsecond a row of tiles. */
enum { MOST_CHANGES = 48 };

/* ---- boxes and shafts ---- */

static bool is_empty(const daft_reach *b) { return !(b->low.x <= b->high.x); }

/* Spawn offsets and roundings move the points of a box by far less than a thousandth of its size and place. */
static daft_reach widened(const daft_reach *b)
{
    const float far = fmaxf(daft_length(b->low), daft_length(b->high)), by = 1e-3f * far + 1e-6f;
    return (daft_reach){daft_sub(b->low, daft_v3(by, by, by)), daft_add(b->high, daft_v3(by, by, by))};
}

/* Narrows first..last to where a + slope·t <= b. */
static void narrow(float a, float slope, float b, float *first, float *last)
{
    if (slope > 0)
        *last = fminf(*last, (b - a) / slope);
    else if (slope < 0)
        *first = fmaxf(*first, (b - a) / slope);
    else if (a > b)
        *last = -1;
}

/* Whether the box from, its low corner moving by `low` and its high one by `high` in a unit of time, meets a box before
 * `end`. */
static bool shaft_meets(const daft_reach *from, daft_vec3 low, daft_vec3 high, float end, const daft_reach *box)
{
    float first = 0, last = end;
    for (int k = 0; k < 3; k++) {
        narrow(daft_v3_at(from->low, k), daft_v3_at(low, k), daft_v3_at(box->high, k), &first, &last);
        narrow(-daft_v3_at(from->high, k), -daft_v3_at(high, k), -daft_v3_at(box->low, k), &first, &last);
    }
    return !(first > last * 1.0001f + 1e-6f);
}

static bool shadow_may_fall(const daft_reach *points, const daft_light_source *light, const daft_reach *box)
{
    if (is_empty(points)) return false;
    if (light->sun) return shaft_meets(points, light->to_light, light->to_light, INFINITY, box);
    return shaft_meets(points, daft_sub(light->position, points->low), daft_sub(light->position, points->high), 1, box);
}

static bool in_range(const daft_reach *points, const daft_light_source *light)
{
    if (is_empty(points)) return false;
    if (light->sun || !(light->range > 0)) return true;
    const daft_vec3 near = daft_max3(points->low, daft_min3(points->high, light->position)),
                    apart = daft_sub(near, light->position);
    return daft_dot(apart, apart) <= light->range * light->range * 1.001f;
}

/* ---- what changed ---- */

typedef struct change {
    daft_reach box;     /* in frame space */
    int x0, x1, y0, y1; /* tiles that it may cover, and no pixels beside them; x0 > x1: none */
    bool shades;        /* casts shadows */
} change;

typedef struct changes {
    const daft_frame *frame;
    change items[MOST_CHANGES];
    uint32_t count;
    bool full; /* too many, or of what is everywhere */
} changes;

/* Tiles that a box of frame space may cover on the screen, by its corners. */
static void cover(const daft_snapshot *s, change *c)
{
    float low_x = INFINITY, high_x = -INFINITY, low_y = INFINITY, high_y = -INFINITY, near = INFINITY;
    for (int k = 0; k < 8; k++) {
        const daft_vec3 p = {k & 1 ? c->box.high.x : c->box.low.x, k & 2 ? c->box.high.y : c->box.low.y,
                             k & 4 ? c->box.high.z : c->box.low.z};
        const float z = daft_dot(s->forward, p), x = s->focal * daft_dot(s->right, p) / z,
                    y = -s->focal * daft_dot(s->up, p) / z;
        near = fminf(near, z);
        low_x = fminf(low_x, x), high_x = fmaxf(high_x, x), low_y = fminf(low_y, y), high_y = fmaxf(high_y, y);
    }
    const int columns = (int)daft_tile_columns(s), rows = (s->height + DAFT_TILE - 1) / DAFT_TILE;
    const float far = daft_length(daft_max3(daft_neg(c->box.low), c->box.high));
    c->x0 = c->y0 = 0, c->x1 = columns - 1, c->y1 = rows - 1;
    if (!(near > 1e-4f * far)) return; /* beside or behind the camera, or through its plane: it may be anywhere */
    const float half_x = (float)s->width * 0.5f, half_y = (float)s->height * 0.5f, limit = 1e6f;
    const int first_x = (int)floorf(fmaxf(low_x + half_x, -limit)) - 3,
              last_x = (int)ceilf(fminf(high_x + half_x, limit)) + 3,
              first_y = (int)floorf(fmaxf(low_y + half_y, -limit)) - 3,
              last_y = (int)ceilf(fminf(high_y + half_y, limit)) + 3;
    c->x0 = daft_max_i(first_x, 0) / DAFT_TILE, c->x1 = last_x < 0 ? -1 : daft_min_i(last_x / DAFT_TILE, columns - 1);
    c->y0 = daft_max_i(first_y, 0) / DAFT_TILE, c->y1 = last_y < 0 ? -1 : daft_min_i(last_y / DAFT_TILE, rows - 1);
}

static void add_change(changes *all, const daft_kept_instance *item)
{
    if (all->count == MOST_CHANGES) {
        all->full = true;
        return;
    }
    const daft_reach box = {item->low, item->high};
    change *c = &all->items[all->count++];
    const uint32_t shades = DAFT_INSTANCE_CASTS_SHADOW | DAFT_INSTANCE_TINTS_SHADOW | DAFT_INSTANCE_FILTERS_SHADOW;
    *c = (change){.box = widened(&box), .shades = item->flags & shades};
    cover(all->frame->snapshot, c);
}

static daft_kept_instance summary(const daft_instance *i)
{
    const uint32_t slots = i->mesh && i->mesh->slot_count ? i->mesh->slot_count : 1;
    return (daft_kept_instance){.to_frame = i->to_frame,
                                .to_object = i->to_object,
                                .low = i->low,
                                .high = i->high,
                                .radius = i->radius,
                                .entity = i->entity,
                                .order = i->order,
                                .flags = i->flags,
                                .slots = slots,
                                .shape = i->mesh ? i->shape : 0,
                                .materials = daft_hash(i->materials, slots * sizeof *i->materials, 0)};
}

static bool same_floats(const float *a, const float *b, int count)
{
    bool same = true;
    for (int i = 0; i < count; i++) same = same && a[i] == b[i];
    return same;
}

static bool same_place(const daft_affine *a, const daft_affine *b)
{
    return same_floats(a->m, b->m, 9) && same_floats(a->t, b->t, 3);
}

static bool same_instance(const daft_kept_instance *a, const daft_kept_instance *b)
{
    return a->entity == b->entity && a->flags == b->flags && a->shape == b->shape && a->slots == b->slots &&
           a->materials == b->materials && a->radius == b->radius && same_place(&a->to_frame, &b->to_frame) &&
           same_place(&a->to_object, &b->to_object) && same_floats(&a->low.x, &b->low.x, 3) &&
           same_floats(&a->high.x, &b->high.x, 3);
}

static bool any_looks_new(const daft_kept *k, const daft_instance *i, uint32_t slots)
{
    for (uint32_t s = 0; s < slots; s++)
        if (k->recoloured[i->materials[s]]) return true;
    return false;
}

/* Both lists are in entity order. */
static void compare_instances(const daft_kept *k, const daft_snapshot *s, bool recoloured, changes *all)
{
    uint32_t old = 0;
    if (k->revision && k->revision == s->revision && !recoloured) return;
    for (uint32_t i = 0; i < s->instance_count && !all->full; i++) {
        const daft_kept_instance now = summary(&s->instances[i]);
        while (old < k->instance_count && k->instances[old].order < now.order) add_change(all, &k->instances[old++]);
        const daft_kept_instance *then =
            old < k->instance_count && k->instances[old].entity == now.entity ? &k->instances[old++] : NULL;
        if (then && same_instance(then, &now) && !(recoloured && any_looks_new(k, &s->instances[i], now.slots)))
            continue;
        if (then) add_change(all, then);
        add_change(all, &now);
    }
    while (old < k->instance_count && !all->full) add_change(all, &k->instances[old++]);
}

/* Bit patterns: a NaN equals itself. */
static bool compare_materials(daft_kept *k, const daft_snapshot *s)
{
    bool some = false;
    for (uint32_t i = 0; i < s->material_count; i++) {
        const bool same =
            i < k->material_count && memcmp(&k->materials[i], &s->materials[i], sizeof *s->materials) == 0;
        some |= k->recoloured[i] = !same;
    }
    return some;
}

/* `scale` and `upscale` are not the renderer's. */
static bool same_quality(const daft_quality *a, const daft_quality *b)
{
    return a->visibility == b->visibility && a->tree == b->tree && a->samples == b->samples &&
           a->edge_samples == b->edge_samples && a->edge_contrast == b->edge_contrast && a->shadows == b->shadows &&
           a->shadow_samples == b->shadow_samples && a->occlusion_samples == b->occlusion_samples &&
           a->mirror_depth == b->mirror_depth && a->refraction_depth == b->refraction_depth &&
           a->min_weight == b->min_weight && a->glossy_samples == b->glossy_samples &&
           a->texture_filter == b->texture_filter && a->denoise == b->denoise && a->half_light == b->half_light;
}

static bool same_sky(const daft_sky *a, const daft_sky *b)
{
    return a->kind == b->kind && a->image == b->image && same_floats(&a->zenith.x, &b->zenith.x, 3) &&
           same_floats(&a->horizon.x, &b->horizon.x, 3) && same_floats(&a->sun.x, &b->sun.x, 3) &&
           same_floats(&a->to_sun.x, &b->to_sun.x, 3) && a->sun_chord2 == b->sun_chord2;
}

/* By the same camera, so that places on the screen are the same. */
static bool same_view(const daft_snapshot *a, const daft_snapshot *b)
{
    return a->width == b->width && a->height == b->height && a->focal == b->focal && a->eye.x == b->eye.x &&
           a->eye.y == b->eye.y && a->eye.z == b->eye.z && same_floats(&a->right.x, &b->right.x, 3) &&
           same_floats(&a->up.x, &b->up.x, 3) && same_floats(&a->forward.x, &b->forward.x, 3);
}

static bool same_ambient(const daft_ambient *a, const daft_ambient *b)
{
    return a->by_normal == b->by_normal && same_floats(&a->color.x, &b->color.x, 3) &&
           same_floats(&a->harmonics[0].x, &b->harmonics[0].x, 3 * DAFT_HARMONICS);
}

/* What every tile may depend on. */
static bool same_everywhere(const daft_snapshot *a, const daft_snapshot *b)
{
    return a->looks == b->looks && a->occlusion == b->occlusion && same_ambient(&a->ambient, &b->ambient) &&
           a->tone.ev == b->tone.ev && a->tone.curve == b->tone.curve && a->light_count == b->light_count &&
           memcmp(&a->air, &b->air, sizeof a->air) == 0 && same_sky(&a->sky, &b->sky) &&
           same_quality(&a->quality, &b->quality);
}

static bool same_light(const daft_light_source *a, const daft_light_source *b)
{
    return a->sun == b->sun && a->casts_shadow == b->casts_shadow && a->spot == b->spot && a->range == b->range &&
           a->inverse_square == b->inverse_square && a->radius == b->radius && a->cone_cosine == b->cone_cosine &&
           a->cone_scale == b->cone_scale && same_floats(&a->position.x, &b->position.x, 3) &&
           same_floats(&a->to_light.x, &b->to_light.x, 3) && same_floats(&a->color.x, &b->color.x, 3) &&
           a->area == b->area && same_floats(&a->edges[0].x, &b->edges[0].x, 6) && a->entity == b->entity &&
           a->bounded == b->bounded && same_floats(&a->bounds.middle.x, &b->bounds.middle.x, 3) &&
           same_floats(&a->bounds.axes[0].x, &b->bounds.axes[0].x, 9);
}

/* ---- which tiles ---- */

static bool change_reaches(const daft_frame *frame, const change *c, const daft_kept_tile *tile, int column, int row)
{
    const daft_snapshot *s = frame->snapshot;
    if (column >= c->x0 && column <= c->x1 && row >= c->y0 && row <= c->y1) return true;
    for (int pass = 0; pass < 2; pass++)
        for (int later = 0; later < 2; later++) {
            const daft_reach points = widened(&tile->pass[pass].points[later]), *rays = &tile->pass[pass].rays[later];
            if (is_empty(&points)) continue;
            if (!is_empty(rays) && shaft_meets(&points, rays->low, rays->high, INFINITY, &c->box)) return true;
            for (uint32_t i = 0; c->shades && frame->plan.shadows && i < s->light_count; i++)
                if (s->lights[i].casts_shadow && in_range(&points, &s->lights[i]) &&
                    shadow_may_fall(&points, &s->lights[i], &c->box))
                    return true;
        }
    return false;
}

static bool light_reaches(const daft_light_source *light, const daft_kept_tile *tile)
{
    for (int i = 0; i < 4; i++)
        if (in_range(&tile->pass[i / 2].points[i % 2], light)) return true;
    return false;
}

static void find_reached(void *context, uint32_t number, uint32_t worker)
{
    (void)worker;
    const changes *all = context;
    const daft_frame *frame = all->frame;
    const daft_snapshot *s = frame->snapshot;
    daft_kept *k = frame->kept;
    const int columns = (int)daft_tile_columns(s), column = (int)number % columns, row = (int)number / columns;
    const daft_kept_tile *tile = &k->tiles[number];
    bool reached = false;
    for (uint32_t i = 0; i < all->count && !reached; i++)
        reached = change_reaches(frame, &all->items[i], tile, column, row);
    for (uint32_t i = 0; i < s->light_count && !reached; i++)
        reached = !same_light(&k->lights[i], &s->lights[i]) &&
                  (light_reaches(&k->lights[i], tile) || light_reaches(&s->lights[i], tile));
    k->state[number] = reached ? DAFT_TILE_REACHED : DAFT_TILE_KEPT;
}

/* Marks the tiles around those that have the mark `of`. */
static void spread(daft_kept *k, int columns, int rows, uint8_t of)
{
    for (int y = 0; y < rows; y++)
        for (int x = 0; x < columns; x++) {
            uint8_t *own = &k->state[y * columns + x];
            for (int n = 0; n < 9 && !*own; n++) {
                const int beside = x + n % 3 - 1, below = y + n / 3 - 1;
                if (beside < 0 || below < 0 || beside >= columns || below >= rows) continue;
                if (k->state[below * columns + beside] == of) *own = of + 1;
            }
        }
}

/* Without antialiasing only tiles that are reached are drawn. */
static void list_tiles(daft_frame *frame)
{
    daft_kept *k = frame->kept;
    const int columns = (int)daft_tile_columns(frame->snapshot), rows = (int)k->tile_count / columns;
    if (frame->edge_scale) spread(k, columns, rows, DAFT_TILE_REACHED), spread(k, columns, rows, DAFT_TILE_MIXED);
    frame->tiles = k->lists, frame->mixed = k->lists + k->tile_count;
    frame->listed = frame->mixed_count = 0;
    for (uint32_t i = 0; i < k->tile_count; i++) {
        if (k->state[i]) k->lists[frame->listed++] = i;
        if (k->state[i] == DAFT_TILE_REACHED || k->state[i] == DAFT_TILE_MIXED)
            k->lists[k->tile_count + frame->mixed_count++] = i;
    }
}

/* ---- the picture that is kept ---- */

static bool kept_reserve(daft_frame *frame, daft_error *error)
{
    const daft_snapshot *s = frame->snapshot;
    const daft_allocator *allocator = &frame->renderer->allocator;
    daft_kept *k = s->kept;
    const size_t tiles = daft_tile_columns(s) * (size_t)((s->height + DAFT_TILE - 1) / DAFT_TILE);
    k->tile_count = (uint32_t)tiles;
    return (daft_grow(allocator, &k->pixels, &k->pixel_capacity, 4 * (size_t)s->width * (size_t)s->height, 0, 1) &&
            daft_grow(allocator, &k->tiles, &k->tile_capacity, tiles, 0, sizeof *k->tiles) &&
            daft_grow(allocator, &k->state, &k->state_capacity, tiles, 0, 1) &&
            daft_grow(allocator, &k->lists, &k->list_capacity, 2 * tiles, 0, sizeof *k->lists)) ||
           daft_fail_memory(error, "the picture that is kept");
}

/* Copies a tile between two pictures of the frame's size. */
static void copy_tile(const daft_snapshot *s, uint32_t number, uint8_t *to, const uint8_t *from)
{
    const int columns = (int)daft_tile_columns(s), x = (int)number % columns * DAFT_TILE,
              y = (int)number / columns * DAFT_TILE, end = daft_min_i(y + DAFT_TILE, s->height);
    const size_t bytes = 4 * (size_t)daft_min_i(DAFT_TILE, s->width - x), stride = 4 * (size_t)s->width;
    for (int row = y; row < end; row++) {
        const size_t at = (size_t)row * stride + 4 * (size_t)x;
        memcpy(to + at, from + at, bytes);
    }
}

static bool remember_instances(daft_kept *k, const daft_allocator *allocator, const daft_snapshot *s, daft_error *error)
{
    if (k->revision && k->revision == s->revision) return true;
    if (!daft_grow(allocator, &k->instances, &k->instance_capacity, s->instance_count, 0, sizeof *k->instances))
        return daft_fail_memory(error, "the instances of a picture");
    for (uint32_t i = 0; i < s->instance_count; i++) k->instances[i] = summary(&s->instances[i]);
    k->instance_count = s->instance_count, k->revision = s->revision;
    return true;
}

static bool remember(daft_kept *k, const daft_allocator *allocator, const daft_snapshot *s, daft_error *error)
{
    if (!daft_grow(allocator, &k->materials, &k->material_capacity, s->material_count, 0, sizeof *k->materials) ||
        !daft_grow(allocator, &k->lights, &k->light_capacity, s->light_count, 0, sizeof *k->lights))
        return daft_fail_memory(error, "the materials of a picture");
    memcpy(k->materials, s->materials, s->material_count * sizeof *k->materials);
    if (s->light_count) memcpy(k->lights, s->lights, s->light_count * sizeof *k->lights);
    k->material_count = s->material_count;
    return remember_instances(k, allocator, s, error);
}

void daft_kept_free(daft_kept *k, const daft_allocator *allocator)
{
    void *all[] = {k->pixels, k->tiles, k->state, k->lists, k->instances, k->materials, k->recoloured, k->lights};
    for (size_t i = 0; i < DAFT_COUNT_OF(all); i++) daft_release(allocator, all[i]);
    *k = (daft_kept){0};
}

/* ---- frames ---- */

/* Bands, and pictures whose channels are asked for, are drawn in full; so is what a grid of samples refines. */
static bool may_keep(const daft_frame *frame)
{
    const daft_snapshot *s = frame->snapshot;
    const daft_frame_aov none = {0};
    return s->kept && s->row_count == s->height && frame->edge_scale <= 1 &&
           memcmp(&frame->target->aov, &none, sizeof none) == 0;
}

static bool is_sampled(const daft_plan *plan) { return plan->samples_light || plan->glossy; }

/* Of a picture that is as the one before. False: sampled light has not settled. */
static bool settled(const daft_frame *frame)
{
    return !is_sampled(&frame->plan) || frame->kept->still >= (frame->plan.denoise ? 2 * DAFT_LONGEST_PAST : 1);
}

static bool find_changes(daft_frame *frame, changes *all, daft_error *error)
{
    daft_kept *k = frame->kept;
    const daft_snapshot *s = frame->snapshot;
    if (!daft_grow(&frame->renderer->allocator, &k->recoloured, &k->recoloured_capacity, s->material_count, 0, 1))
        return daft_fail_memory(error, "the materials that changed");
    const bool recoloured = compare_materials(k, s);
    compare_instances(k, s, recoloured, all);
    return true;
}

static bool any_light_changed(const daft_kept *k, const daft_snapshot *s)
{
    for (uint32_t i = 0; i < s->light_count; i++)
        if (!same_light(&k->lights[i], &s->lights[i])) return true;
    return false;
}

/* The tiles to draw where the picture before is kept. */
static bool choose_tiles(daft_frame *frame, daft_error *error)
{
    daft_kept *k = frame->kept;
    const daft_snapshot *s = frame->snapshot;
    changes all = {.frame = frame};
    if (!find_changes(frame, &all, error)) return false;
    const bool lights = any_light_changed(k, s), some = all.count || all.full || lights;
    k->still = some ? 0 : k->still + 1;
    if (all.full || (some && is_sampled(&frame->plan)) || (!some && !settled(frame))) return true;
    if (some)
        daft_parallel_for(frame->renderer->threads, k->tile_count, find_reached, &all);
    else
        memset(k->state, 0, k->tile_count);
    list_tiles(frame);
    memcpy(frame->target->pixels, k->pixels, 4 * (size_t)s->width * (size_t)s->height);
    return true;
}

/* A camera that moves keeps nothing, and pays nothing for it. */
bool daft_redraw_begin(daft_frame *frame, daft_error *error)
{
    const daft_snapshot *s = frame->snapshot;
    frame->kept = NULL, frame->tiles = NULL;
    if (!may_keep(frame)) return true;
    daft_kept *k = s->kept;
    const bool first = !k->view.width, still = !first && same_view(&k->view, s);
    const bool known = k->some && still && same_everywhere(&k->view, s);
    k->view = *s;
    if (!first && !still) k->some = false;
    if (!first && !still) return true;
    frame->kept = k;
    if (!known) k->still = 0;
    if (!kept_reserve(frame, error) || (known && !choose_tiles(frame, error))) return false;
    k->some = false; /* until it is drawn */
    return true;
}

bool daft_redraw_end(daft_frame *frame, daft_error *error)
{
    daft_kept *k = frame->kept;
    const daft_snapshot *s = frame->snapshot;
    if (!k) return true;
    for (uint32_t i = 0; frame->tiles && i < frame->listed; i++)
        if (k->state[frame->tiles[i]] == DAFT_TILE_BESIDE)
            copy_tile(s, frame->tiles[i], frame->target->pixels, k->pixels);
    const uint32_t *fresh = frame->edge_scale ? frame->mixed : frame->tiles;
    const uint32_t count = frame->edge_scale ? frame->mixed_count : frame->listed;
    for (uint32_t i = 0; frame->tiles && i < count; i++) copy_tile(s, fresh[i], k->pixels, frame->target->pixels);
    if (!frame->tiles) memcpy(k->pixels, frame->target->pixels, 4 * (size_t)s->width * (size_t)s->height);
    k->some = remember(k, &frame->renderer->allocator, s, error);
    return k->some;
}
