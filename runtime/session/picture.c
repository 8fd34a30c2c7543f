/* The picture of a session: the scene, what is drawn over it, and the error that stopped it. */
#include "session/state.h"

#include "common/util.h"
#include "game/xray.h"
#include "hud/screens.h"
#include "session/hot.h"

#include <stdio.h>

void session_picture_size(const session_def *def, int *width, int *height)
{
    def->screen->get_size(def->screen, width, height);
    if (def->fixed_size) return;
    double scale = def->scale;
    if ((double)*width * scale > 1920) scale = 1920.0 / (double)*width;
    if ((double)*height * scale > 1080) scale = 1080.0 / (double)*height;
    *width = (int)((double)*width * scale + 0.5);
    *height = (int)((double)*height * scale + 0.5);
    if (*width < 16) *width = 16;
    if (*height < 16) *height = 16;
}

bool session_fit_picture(const session_def *def, daft_image **picture, daft_error *error)
{
    int width, height;
    session_picture_size(def, &width, &height);
    if (*picture && daft_image_width(*picture) == width && daft_image_height(*picture) == height) return true;
    daft_image *fresh = daft_image_create(def->engine, width, height, error);
    if (!fresh) return false;
    daft_image_destroy(*picture);
    *picture = fresh;
    return true;
}

static void draw_overlay(session *s)
{
    overlay_figures figures = {.frames_per_second = s->turn_ms > 0 ? 1000 / s->turn_ms : 0,
                               .frame_ms = s->frame_ms,
                               .update_ms = s->update_ms,
                               .dropped = s->clock.dropped,
                               .counters = daft_scene_counters(s->play->scene),
                               .simulation = daft_scene_sim_counters(s->play->scene),
                               .memory = daft_engine_memory(s->play->def.engine)};
    canvas over = canvas_over(s->picture);
    char quality[160];
    if (s->governs) {
        const governor *g = &s->pace;
        snprintf(quality, sizeof quality, "%s for %.1f ms: %s", governor_rung_at(g->rung)->name, g->target_ms, g->why);
        figures.quality = quality, figures.slow_ms = governor_slow_ms(g);
    }
    panels_place(&s->placed, &over, 312, 640);
    screen_overlay(&over, s->def->face, &figures);
    panels_place(&s->placed, &over, GRAPH_WIDTH + 12, GRAPH_HEIGHT + 24);
    over.origin_y += 12 * over.unit;
    graph_draw(&over, s->def->face, &s->graph, s->governs ? s->pace.target_ms : 1000.0 / 60);
    hot_draw(s);
}

double session_smooth(double before, double now) { return before > 0 ? before * 0.95 + now * 0.05 : now; }

/* The scene; the panel; and over it what the game draws, which the panel must not cover. */
static bool draw_game(session *s, float alpha)
{
    if (!s->pause.open) session_survey(s, alpha);
    session_measure_prices(s, s->picture, alpha);
    if (!game_render(s->play, s->picture, alpha)) return false;
    if (s->xray) {
        const canvas over = canvas_over(s->picture);
        const daft_camera camera = daft_scene_camera(s->play->scene, alpha);
        xray_draw(&over, s->play->scene, &camera);
    }
    if (s->priced) session_draw_prices(s);
    if (s->overlay) draw_overlay(s);
    return game_draw_over(s->play, s->picture);
}

bool session_can_edit(const session *s) { return s->def->editor && s->play->scripts.failure.file[0]; }

static void draw_failure(session *s)
{
    const failure *why = &s->play->scripts.failure;
    canvas over = canvas_over(s->picture);
    char keys[100];
    snprintf(keys, sizeof keys, "R  try again      C  copy%s%s      Esc  leave",
             session_can_edit(s) ? "      E  edit" : "", s->def->watches ? "      F5  the tick before" : "");
    error_report shown = {s->info->title, why->message, why->source, why->trace, why->values, keys};
    if (s->notice[0] && s->notice_ns) shown.keys = s->notice;
    screen_error(&over, s->def->face, &shown);
}

static bool has_kept_tiles(const daft_counters *c)
{
    const uint64_t columns = ((uint64_t)c->width + 31) / 32, rows = ((uint64_t)c->height + 31) / 32;
    return c->tiles_drawn < columns * rows;
}

bool session_draw(session *s, float alpha, daft_error *error)
{
    if (!session_fit_picture(s->def, &s->picture, error)) return false;
    s->drawn = s->play->ticks;
    s->placed = (panels){.marks = &s->play->scripts.texts};
    uint64_t began = clock_now_ns();
    const bool drawn = draw_game(s, alpha);
    if (!drawn && !s->play->failed) return false;
    if (drawn) {
        double ms = (double)(clock_now_ns() - began) / 1e6;
        s->frame_ms = session_smooth(s->frame_ms, ms), s->drawn_ms += ms;
        graph_add_picture(&s->graph, ms, daft_scene_counters(s->play->scene));
        s->reused = has_kept_tiles(daft_scene_counters(s->play->scene));
        if (s->def->stats) frame_times_add(&s->times, ms, daft_scene_counters(s->play->scene));
    } else {
        draw_failure(s);
    }
    const tools_scene now = session_tools_scene(s, alpha);
    tools_draw(&s->tools, &now, s->picture, s->def->face, &s->placed);
    if (s->notice[0] && !(s->play->failed && s->notice_ns)) {
        canvas over = canvas_over(s->picture);
        screen_notice(&over, s->def->face, s->notice, s->notice_ns == 0);
    }
    return true;
}
