/* The list of games over a small scene: a chrome ball among coloured ones, seen from an orbiting camera. */
#include "session/menu.h"

#include "common/util.h"

#include <stdio.h>
#include <string.h>

static const canvas_color WHITE = {245, 247, 250, 255}, GREY = {176, 188, 206, 255}, DARK = {12, 17, 30, 205},
                          CHOSEN = {64, 132, 255, 235};

static const float ROW = 104, TOP = 176, LEFT = 64, WIDTH = 560;

typedef struct menu {
    const session_def *def;
    const game_info *games;
    size_t count, chosen, first; /* first: the row on top */
    daft_scene *scene;
    daft_image *picture;
    bool picked, left, mouse_moved;
    float mouse_x, mouse_y;
} menu;

/* ---- the background scene ---- */

static bool add_ball(daft_scene *scene, double x, double z, float radius, daft_vec3 color, float mirror,
                     daft_error *error)
{
    daft_material_def look = daft_default_material_def();
    look.diffuse = look.ambient = color;
    look.mirror = mirror;
    daft_entity_def ball = daft_default_entity_def();
    ball.shape = DAFT_SHAPE_SPHERE;
    ball.radius = radius;
    ball.position = (daft_dvec3){x, (double)radius, z};
    ball.material = daft_material_create(scene, &look, error);
    return ball.material.id && daft_entity_create(scene, &ball, error).id;
}

static bool build_scene(menu *m, daft_error *error)
{
    m->scene = daft_scene_create(m->def->engine, error);
    if (!m->scene) return false;
    daft_scene_set_sky_gradient(m->scene, (daft_vec3){0.06f, 0.16f, 0.42f}, (daft_vec3){0.62f, 0.74f, 0.9f});
    daft_scene_set_ambient(m->scene, (daft_vec3){0.32f, 0.34f, 0.4f});
    daft_light_def sun = daft_default_light_def();
    sun.kind = DAFT_LIGHT_SUN;
    sun.direction = (daft_vec3){-1, -1.6f, -0.7f};
    sun.color = (daft_vec3){1, 0.95f, 0.86f};
    if (!daft_light_create(m->scene, &sun, error).id) return false;

    daft_material_def paint = daft_default_material_def();
    paint.diffuse = paint.ambient = (daft_vec3){1, 1, 1};
    paint.map_scale = (daft_vec2){0.25f, 0.25f}; /* squares of two metres */
    char path[PATH_SIZE];
    if (path_join(path, sizeof path, m->def->where->assets, "textures/checker.png") && path_is_file(path))
        paint.diffuse_map = daft_texture_load(m->scene, path, NULL);
    daft_entity_def floor = daft_default_entity_def();
    floor.shape = DAFT_SHAPE_BOX;
    floor.size = (daft_vec3){60, 1, 60};
    floor.position = (daft_dvec3){0, -0.5, 0};
    floor.material = daft_material_create(m->scene, &paint, error);
    if (!floor.material.id || !daft_entity_create(m->scene, &floor, error).id) return false;

    static const daft_vec3 colors[] = {{0.85f, 0.12f, 0.08f}, {0.95f, 0.55f, 0.05f}, {0.1f, 0.5f, 0.16f},
                                       {0.05f, 0.2f, 0.75f},  {0.45f, 0.08f, 0.55f}, {0.05f, 0.5f, 0.55f}};
    if (!add_ball(m->scene, 0, 0, 1.5f, (daft_vec3){0.25f, 0.25f, 0.25f}, 0.85f, error)) return false;
    for (size_t i = 0; i < COUNT_OF(colors); i++) {
        double angle = 6.283185307179586 * (double)i / (double)COUNT_OF(colors);
        float radius = i % 2 ? 0.55f : 0.8f;
        if (!add_ball(m->scene, 3 * daft_cos(angle), 3 * daft_sin(angle), radius, colors[i], 0.15f, error))
            return false;
    }
    return true;
}

static bool draw_scene(menu *m, double seconds, daft_error *error)
{
    /* The camera looks a little left of the balls, so that they stand right of the list. */
    double turn = 0.6 + seconds * 0.12;
    daft_dvec3 from = {9 * daft_cos(turn), 3.2, 9 * daft_sin(turn)};
    daft_view view = daft_default_view();
    view.camera = daft_camera_look_at(from, (daft_dvec3){0, 0.9, 0}, 1.15f);
    view.camera.yaw -= 0.26f;
    return daft_render(m->scene, &view, m->picture, error);
}

/* ---- the list ---- */

static size_t visible_rows(const menu *m)
{
    size_t rows = (size_t)((CANVAS_HEIGHT - TOP - 70) / ROW);
    return m->count < rows ? m->count : rows;
}

/* Draws as many whole words as fit in two lines. */
static void draw_description(const canvas *over, font *face, const char *description, float y, const text_style *style)
{
    char text[512];
    snprintf(text, sizeof text, "%s", description);
    const float room = 2.5f * text_line_height(style->size);
    for (char *blank; text_draw_wrapped(NULL, face, text, 0, 0, WIDTH - 40, style) > room;) {
        if (!(blank = strrchr(text, ' '))) return;
        blank[0] = 0;
    }
    text_draw_wrapped(over, face, text, LEFT + 20, y, WIDTH - 40, style);
}

static void draw_list(menu *m)
{
    canvas over = canvas_over(m->picture);
    canvas_rect(&over, 0, 0, LEFT + WIDTH + LEFT, CANVAS_HEIGHT, (canvas_color){12, 17, 30, 110});
    font *face = m->def->face;
    text_style title = {76, WHITE, TEXT_LEFT, true}, style = {22, GREY, TEXT_LEFT, true};
    text_draw(&over, face, "DAFT", LEFT, 44, &title);
    style.color = WHITE;
    text_draw(&over, face, m->count ? "Choose a game" : "There is no game in games/ yet", LEFT + 4, 128, &style);
    for (size_t row = 0; row < visible_rows(m); row++) {
        const game_info *game = &m->games[m->first + row];
        bool chosen = m->first + row == m->chosen;
        float y = TOP + ROW * (float)row;
        canvas_rect(&over, LEFT, y, WIDTH, ROW - 8, chosen ? CHOSEN : DARK);
        style = (text_style){28, WHITE, TEXT_LEFT, false};
        text_draw(&over, face, game->title, LEFT + 20, y + 10, &style);
        style.size = 18, style.color = chosen ? WHITE : GREY;
        draw_description(&over, face, game->description, y + 45, &style);
    }
    canvas_rect(&over, 0, CANVAS_HEIGHT - 56, canvas_hud_width(&over), 56, DARK);
    style = (text_style){18, WHITE, TEXT_LEFT, true};
    text_draw(&over, face, "Up / Down  choose      Return  play      F11  full screen      Esc  leave", LEFT + 4,
              CANVAS_HEIGHT - 40, &style);
}

/* ---- choosing ---- */

static void choose(menu *m, size_t which)
{
    m->chosen = which;
    size_t rows = visible_rows(m);
    if (m->chosen < m->first) m->first = m->chosen;
    if (m->chosen >= m->first + rows) m->first = m->chosen + 1 - rows;
}

/* The row under the mouse, or `count` for none. */
static size_t row_under_mouse(const menu *m)
{
    if (m->mouse_x < LEFT || m->mouse_x > LEFT + WIDTH || m->mouse_y < TOP) return m->count;
    size_t row = (size_t)((m->mouse_y - TOP) / ROW);
    return row < visible_rows(m) ? m->first + row : m->count;
}

static void take_key(menu *m, const char *key)
{
    if (strcmp(key, "escape") == 0) m->left = true;
    if (m->count == 0) return;
    if (strcmp(key, "up") == 0) choose(m, (m->chosen + m->count - 1) % m->count);
    if (strcmp(key, "down") == 0) choose(m, (m->chosen + 1) % m->count);
    if (strcmp(key, "home") == 0) choose(m, 0);
    if (strcmp(key, "end") == 0) choose(m, m->count - 1);
    if (strcmp(key, "return") == 0 || strcmp(key, "space") == 0 || strcmp(key, "keypad enter") == 0) m->picked = true;
    if (strcmp(key, "mouse1") == 0 && row_under_mouse(m) < m->count) {
        choose(m, row_under_mouse(m));
        m->picked = true;
    }
}

static void take_events(menu *m)
{
    platform *screen = m->def->screen;
    for (platform_event event; screen->poll(screen, &event);) {
        if (event.kind == PLATFORM_CLOSE) m->left = true;
        if (event.kind != PLATFORM_INPUT) continue;
        session_scale_mouse(screen, &event.input);
        if (event.input.kind == INPUT_MOVE) {
            m->mouse_x = event.input.x, m->mouse_y = event.input.y;
            if (row_under_mouse(m) < m->count) m->chosen = row_under_mouse(m);
        } else if (event.input.kind == INPUT_WHEEL && m->count > 0 && event.input.y != 0) {
            if (event.input.y < 0 && m->chosen + 1 < m->count) choose(m, m->chosen + 1);
            if (event.input.y > 0 && m->chosen > 0) choose(m, m->chosen - 1);
        } else if (event.input.kind == INPUT_KEY && event.input.down) {
            take_key(m, input_key_name(event.input.key));
        }
    }
}

static bool show(menu *m, daft_error *error)
{
    platform *screen = m->def->screen;
    if (!build_scene(m, error)) return false;
    choose(m, m->chosen < m->count ? m->chosen : 0);
    uint64_t began = screen->now_ns(screen);
    while (!m->left && !m->picked) {
        take_events(m);
        if (screen->wants_frame(screen)) {
            double seconds = (double)(screen->now_ns(screen) - began) / 1e9;
            if (!session_fit_picture(m->def, &m->picture, error) || !draw_scene(m, seconds, error)) return false;
            draw_list(m);
            if (!screen->present(screen, m->picture, error)) return false;
        }
        screen->end_frame(screen);
    }
    return true;
}

menu_end menu_show(const session_def *def, const game_info *games, size_t count, size_t *chosen, daft_error *error)
{
    menu m = {.def = def, .games = games, .count = count, .chosen = *chosen};
    def->screen->set_title(def->screen, "DAFT");
    bool good = show(&m, error);
    daft_scene_destroy(m.scene);
    daft_image_destroy(m.picture);
    *chosen = m.chosen;
    return !good ? MENU_FAILED : m.picked && !m.left ? MENU_CHOSEN : MENU_LEFT;
}
