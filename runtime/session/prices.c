/* F2: what each effect of the picture takes, and what the next better and the next cheaper setting of each knob would
 * cost and change in it. */
#include "session/state.h"

#include "common/util.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const canvas_color BACK = {10, 14, 24, 205}, WHITE = {255, 255, 255, 255}, GREY = {170, 180, 195, 255},
                          GREEN = {120, 225, 150, 255}, AMBER = {255, 190, 90, 255};

/* HUD units: of the panel, of a line, and of its columns from its left. */
enum { WIDTH = 900, LINE = 19, TOP = 12, KNOB = 16, NOW = 170, CHEAPER = 300, BETTER = 600 };

enum { LEAST = 4 /* measures before a figure is shown */ };

void session_toggle_prices(session *s)
{
    s->priced = !s->priced;
    if (s->priced)
        probe_begin(&s->prices, s->def->engine);
    else
        probe_end(&s->prices);
}

typedef struct measure {
    session *s;
    int width, height;
} measure;

static bool look(void *user, daft_scene *scene, const daft_view *view, daft_error *error)
{
    const measure *m = user;
    return probe_step(&m->s->prices, scene, view, m->width, m->height, error);
}

void session_measure_prices(session *s, daft_image *picture, float alpha)
{
    const uint64_t began = clock_now_ns();
    if (!s->priced || s->play->failed || began < s->prices_rest_ns) return;
    daft_error error;
    measure m = {s, daft_image_width(picture), daft_image_height(picture)};
    const bool good = game_show(s->play, alpha, look, &m, &error);
    const uint64_t ended = clock_now_ns();
    s->prices_rest_ns = ended + (ended - began); /* at most half of the time goes into it */
    if (good || s->play->failed) return;
    session_toggle_prices(s);
    char text[HOST_MESSAGE];
    snprintf(text, sizeof text, "F2: %.200s", error.message);
    session_tell(s, text);
}

/* ---- the panel --------------------------------------------------------------------------------------------------- */

/* Where lines are put. */
typedef struct pen {
    const canvas *over;
    font *face;
    float x, y;
} pen;

static void put(const pen *p, float x, canvas_color color, const char *text)
{
    const text_style style = {16, color, TEXT_LEFT, false};
    text_draw(p->over, p->face, text, p->x + x, p->y, &style);
}

/* Of "shadow_samples=4" the value, of a list all of it. */
static const char *short_name(const char *setting)
{
    const char *value = strchr(setting, '=');
    return value && !strchr(setting, ',') ? value + 1 : setting;
}

/* Settings of several knobs in two words: "1, edges 16 x0.5". */
static void write_setting(const char *setting, char out[64])
{
    int samples, edges;
    double scale, contrast;
    char filter[16];
    const int found = sscanf(setting, "samples=%d,edge_samples=%d,edge_contrast=%lf", &samples, &edges, &contrast);
    if (found == 3 && contrast != 1)
        snprintf(out, 64, "%d, edges %d x%g", samples, edges, contrast);
    else if (found >= 2)
        snprintf(out, 64, edges ? "%d, edges %d" : "%d", samples, edges);
    else if (sscanf(setting, "scale=%lf,upscale=%15s", &scale, filter) == 2)
        snprintf(out, 64, "%g %s", scale, filter);
    else
        snprintf(out, 64, "%s", short_name(setting));
}

static void put_figure(const pen *p, float x, const probe_figure *f)
{
    char text[160], setting[64];
    double ms, uncertain, change;
    if (!f->setting) return;
    write_setting(f->setting, setting);
    put(p, x, WHITE, setting);
    if (f->count < LEAST || !probe_sum(f, &ms, &uncertain, &change)) {
        put(p, x + 125, GREY, knob_is_by_rays(f->setting) ? "not here: too slow" : "...");
        return;
    }
    const bool told = fabs(ms) > 3 * uncertain && fabs(ms) >= 0.005;
    if (told)
        snprintf(text, sizeof text, "%+.2f ms", ms);
    else
        snprintf(text, sizeof text, "within %.2f ms", fmax(fabs(ms), fmax(3 * uncertain, 0.01)));
    put(p, x + 125, !told ? GREY : ms > 0 ? AMBER : GREEN, text);
    snprintf(text, sizeof text, change > 0 ? "%.4f" : "same", change);
    put(p, x + 232, change > 0 ? WHITE : GREY, text);
}

static void put_head(pen *p)
{
    const float columns[2] = {CHEAPER, BETTER};
    put(p, KNOB, GREY, "knob");
    put(p, NOW, GREY, "now");
    for (int i = 0; i < 2; i++) {
        put(p, columns[i], GREY, i ? "next better" : "next cheaper");
        put(p, columns[i] + 125, GREY, "costs");
        put(p, columns[i] + 232, GREY, "FLIP");
    }
    p->y += LINE;
}

static void put_effects(pen *p, const daft_counters *c)
{
    char text[96];
    int count = 0;
    snprintf(text, sizeof text, "This picture, %d x %d, took %.2f ms:", c->width, c->height, c->frame_ms);
    put(p, KNOB, WHITE, text);
    p->y += LINE;
    for (size_t i = 0; i < DAFT_EFFECT_COUNT; i++) {
        const daft_effect *e = &c->effects[i];
        if (!e->name || !e->ran || e->ms < 0.005) continue;
        snprintf(text, sizeof text, "%s %.2f", e->name, e->ms);
        put(p, KNOB + 145.0f * (float)(count % 6), GREY, text);
        if (++count % 6 == 0) p->y += LINE;
    }
    p->y += count % 6 ? 1.5f * LINE : 0.5f * LINE;
}

void session_draw_prices(session *s)
{
    const canvas over = canvas_over(s->picture);
    const float height = TOP + LINE * (KNOBS + 5.5f), width = canvas_hud_width(&over);
    pen p = {&over, s->def->face, fmaxf(12, width - WIDTH - 12), CANVAS_HEIGHT - height - 12};
    panels_take(&s->placed, (panel_box){p.x, p.y, WIDTH, height});
    canvas_rect(&over, p.x, p.y, WIDTH, height, BACK);
    p.y += TOP;
    put_effects(&p, daft_scene_counters(s->play->scene));
    put_head(&p);
    for (size_t k = 0; k < KNOBS; k++, p.y += LINE) {
        const probe_row *row = &s->prices.rows[k];
        char setting[64];
        if (!row->knob) continue;
        put(&p, KNOB, WHITE, row->knob->name);
        write_setting(row->now ? row->now : "its own", setting);
        put(&p, NOW, GREY, setting);
        put_figure(&p, CHEAPER, &row->cheaper);
        put_figure(&p, BETTER, &row->better);
    }
    p.y += 4;
    put(&p, KNOB, GREY,
        "Measured on the last seconds' frames, which takes up to half of the time. FLIP: how differently it looks, 0 "
        "to 1.");
}
