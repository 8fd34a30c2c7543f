/* Rows of the reference picture. */
#include "view/picture/refine.h"

#include <math.h>
#include <string.h>

enum { TILE = 32, TARGET_MS = 15 };

static const daft_preset PASSES[] = {DAFT_PRESET_HIGH, DAFT_PRESET_REFERENCE};

static void begin_pass(refinement *r, int pass)
{
    r->pass = pass;
    r->row = 0;
    r->squares = r->sums = 0;
    r->rows = TILE;
}

void refine_restart(refinement *r) { begin_pass(r, 0); }

bool refine_is_done(const refinement *r) { return r->pass == (int)COUNT_OF(PASSES); }

daft_preset refine_quality(const refinement *r)
{
    return r->pass < (int)COUNT_OF(PASSES) ? PASSES[r->pass] : DAFT_PRESET_REFERENCE;
}

void refine_free(refinement *r)
{
    daft_image_destroy(r->fine);
    *r = (refinement){0};
}

static bool fit(refinement *r, daft_engine *engine, const daft_image *picture, daft_error *error)
{
    int width = daft_image_width(picture), height = daft_image_height(picture);
    if (r->fine && daft_image_width(r->fine) == width && daft_image_height(r->fine) == height) return true;
    daft_image_destroy(r->fine);
    r->fine = daft_image_create(engine, width, height, error);
    return r->fine != NULL;
}

/* Takes the rows over, and notes how much they differ. */
static void take(refinement *r, int first, int count, daft_image *picture)
{
    size_t width = (size_t)daft_image_width(picture), begin = 4 * width * (size_t)first,
           size = 4 * width * (size_t)count;
    uint8_t *before = daft_image_pixels(picture) + begin;
    const uint8_t *after = daft_image_pixels(r->fine) + begin;
    for (size_t i = 0; i < size; i++) {
        double d = (double)(after[i] - before[i]) / 255;
        if (i % 4 != 3) r->squares += d * d;
    }
    r->sums += (double)size * 3 / 4;
    memcpy(before, after, size);
}

static bool go_on(void *user, float done)
{
    (void)done;
    const refine_job *job = user;
    return !job->asked(job->user);
}

static void choose_rows(refinement *r, double ms)
{
    if (ms < TARGET_MS / 2.0 && r->rows < 1024) r->rows *= 2;
    if (ms > TARGET_MS && r->rows > TILE) r->rows = r->rows / 2 / TILE * TILE;
    if (r->rows < TILE) r->rows = TILE;
}

bool refine_step(refinement *r, const refine_job *job, daft_error *error)
{
    int height = daft_image_height(job->picture), left = height - r->row;
    *error = (daft_error){0};
    if (refine_is_done(r) || !fit(r, job->engine, job->picture, error)) return false;
    daft_view view = daft_default_view();
    draw_set_view(job->look, job->scene, &view);
    view.quality = daft_preset_quality(refine_quality(r));
    view.first_row = r->row;
    view.row_count = r->rows < left ? r->rows : left;
    view.progress = go_on;
    view.progress_user = (void *)(uintptr_t)job;
    uint64_t began = clock_now_ns();
    bool drawn = daft_render(job->scene, &view, r->fine, error);
    if (!drawn && error->code == DAFT_ERROR_CANCELLED) *error = (daft_error){0};
    if (!drawn) return false;
    take(r, r->row, view.row_count, job->picture);
    r->row += view.row_count;
    choose_rows(r, (double)(clock_now_ns() - began) / 1e6);
    if (r->row == height) begin_pass(r, r->pass + 1);
    return true;
}

double refine_error(const refinement *r, int height)
{
    if (!(r->sums > 0)) return -1;
    double left = (double)(height - r->row) / height;
    return sqrt(r->squares / r->sums * left);
}
