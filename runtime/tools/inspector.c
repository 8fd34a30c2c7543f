/* The fields of an entity as rows, and what keys and the mouse do with them. */
#include "tools/inspector.h"

#include "common/util.h"

#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- rows ---- */

/* NULL: there is no more room. */
static inspector_row *add_row(inspector *self, const char *label, inspector_form form, const char *change)
{
    if (self->count == INSPECTOR_ROWS) return NULL;
    inspector_row *row = &self->rows[self->count++];
    row->label = label, row->form = form, row->change = change;
    row->value[0] = row->exact[0] = 0, row->is_color = false;
    return row;
}

static void add_text(inspector *self, const char *label, inspector_form form, const char *change, const char *format,
                     ...) __attribute__((format(printf, 5, 6)));
static void add_text(inspector *self, const char *label, inspector_form form, const char *change, const char *format,
                     ...)
{
    inspector_row *row = add_row(self, label, form, change);
    va_list arguments;
    va_start(arguments, format);
    if (row) vsnprintf(row->value, sizeof row->value, format, arguments);
    va_end(arguments);
}

static void add_flag(inspector *self, const char *label, const char *change, bool on)
{
    add_text(self, label, change ? FORM_FLAG : FORM_FIXED, change, "%s", on ? "true" : "false");
}

/* The shortest text that is read back as the same number. */
static void put_number(char *out, size_t size, double value, bool single)
{
    for (int digits = 6; digits <= 17; digits++) {
        const int length = snprintf(out, size, "%.*g", digits, value);
        if (length < 0 || (size_t)length >= size) return;
        if (single ? strtof(out, NULL) == (float)value : strtod(out, NULL) == value) return;
    }
}

/* `single`: floats, whose decimals end sooner. `braces`: as a table. */
static void add_numbers(inspector *self, const char *label, const char *change, const double *values, int count,
                        bool single, bool braces)
{
    inspector_row *row = add_row(self, label, change ? FORM_VALUE : FORM_FIXED, change);
    if (!row) return;
    for (int i = 0; i < count; i++) {
        const size_t shown = strlen(row->value), exact = strlen(row->exact);
        snprintf(row->value + shown, sizeof row->value - shown, "%s%.4g", i > 0 ? ", " : "", values[i] + 0.0);
        snprintf(row->exact + exact, sizeof row->exact - exact, "%s", i > 0 ? ", " : braces ? "{" : "");
        const size_t used = strlen(row->exact);
        put_number(row->exact + used, sizeof row->exact - used, values[i], single);
    }
    const size_t used = strlen(row->exact);
    snprintf(row->exact + used, sizeof row->exact - used, "%s", braces ? "}" : "");
}

static void add_number(inspector *self, const char *label, const char *change, float value)
{
    add_numbers(self, label, change, &(double){(double)value}, 1, true, false);
}

static void add_vector(inspector *self, const char *label, const char *change, daft_vec3 v)
{
    add_numbers(self, label, change, (const double[3]){(double)v.x, (double)v.y, (double)v.z}, 3, true, false);
}

static void add_color(inspector *self, const char *label, const char *change, daft_vec3 v)
{
    add_numbers(self, label, change, (const double[3]){(double)v.x, (double)v.y, (double)v.z}, 3, true, true);
    inspector_row *row = &self->rows[self->count - 1];
    row->is_color = true, row->color = v;
}

static void add_place(inspector *self, const char *label, const char *change, daft_dvec3 v)
{
    add_numbers(self, label, change, (const double[3]){v.x, v.y, v.z}, 3, false, false);
}

static daft_dvec3 turn(daft_quat q, daft_dvec3 v)
{
    const double x = (double)q.x, y = (double)q.y, z = (double)q.z, w = (double)q.w;
    const daft_dvec3 t = {2 * (y * v.z - z * v.y), 2 * (z * v.x - x * v.z), 2 * (x * v.y - y * v.x)};
    return (daft_dvec3){v.x + w * t.x + y * t.z - z * t.y, v.y + w * t.y + z * t.x - x * t.z,
                        v.z + w * t.z + x * t.y - y * t.x};
}

/* Yaw, pitch and roll in the camera's sense: api_quat_from_angles gives the rotation back. */
static void add_rotation(inspector *self, daft_quat q)
{
    const daft_dvec3 forward = turn(q, (daft_dvec3){1, 0, 0}), up = turn(q, (daft_dvec3){0, 1, 0});
    const double yaw = atan2(forward.z, forward.x), pitch = -asin(fmax(-1, fmin(1, forward.y)));
    const daft_dvec3 right = {-sin(yaw), 0, cos(yaw)}; /* of no roll, and so is the upward direction right × forward */
    const daft_dvec3 above = {right.y * forward.z - right.z * forward.y, right.z * forward.x - right.x * forward.z,
                              right.x * forward.y - right.y * forward.x};
    const double roll =
        atan2(up.x * right.x + up.y * right.y + up.z * right.z, up.x * above.x + up.y * above.y + up.z * above.z);
    add_numbers(self, "yaw, pitch, roll", ":rotation($)", (const double[3]){yaw, pitch, roll}, 3, true, false);
}

/* ---- what an entity is ---- */

static void read_shape(inspector *self, daft_scene *scene, const daft_entity_def *def)
{
    daft_mesh_info info;
    if (def->shape == DAFT_SHAPE_SPHERE) add_number(self, "sphere, radius", NULL, def->radius);
    if (def->shape == DAFT_SHAPE_BOX) add_vector(self, "box, size", NULL, def->size);
    if (def->shape == DAFT_SHAPE_MESH && daft_mesh_get_info(scene, def->mesh, &info, NULL))
        add_text(self, "mesh", FORM_FIXED, NULL, "%" PRIu32 " triangles", info.triangle_count);
}

static void read_place(inspector *self, daft_scene *scene, const daft_entity_def *def)
{
    daft_transform world;
    add_place(self, "position", ":position($)", def->position);
    if (def->parent.id && daft_entity_get_world_transform(scene, self->chosen, &world, NULL)) {
        add_place(self, "position in the world", ":world_position($)", world.position);
        add_text(self, "parent", FORM_VALUE, ":parent($)", "entity_%" PRIu32, def->parent.id);
    }
    add_rotation(self, def->rotation);
    add_vector(self, "scale", ":scale($)", def->scale);
    add_flag(self, "visible", ":visible($)", def->visible);
    add_flag(self, "casts shadow", NULL, def->casts_shadow);
}

static void read_material(inspector *self, daft_scene *scene, const daft_entity_def *def)
{
    char name[100] = "";
    daft_material_def m = daft_default_material_def();
    const bool own = def->material.id && daft_material_get(scene, def->material, &m, NULL);
    if (def->shape == DAFT_SHAPE_NONE) return;
    if (own) daft_material_name(scene, def->material, name, sizeof name);
    add_text(self, "material", FORM_PAINT, ":material($)", "%s",
             name[0]                         ? name
             : own                           ? "its own"
             : def->shape == DAFT_SHAPE_MESH ? "those of the mesh"
                                             : "the default");
    if (!own && def->shape == DAFT_SHAPE_MESH) return;
    add_color(self, "  color", ":repaint{color = $}", m.diffuse);
    add_color(self, "  emission", ":repaint{emission = $}", m.emission);
    add_number(self, "  mirror", ":repaint{mirror = $}", m.mirror);
    add_number(self, "  roughness", ":repaint{roughness = $}", m.roughness);
    add_number(self, "  metallic", ":repaint{metallic = $}", m.metallic);
    add_number(self, "  transmission", ":repaint{transmission = $}", m.transmission);
    add_number(self, "  opacity", ":repaint{opacity = $}", m.opacity);
}

static void read_body(inspector *self, daft_scene *scene, const daft_entity_def *def)
{
    char kind[32];
    float mass = 0;
    bool awake = false;
    daft_vec3 linear = {0, 0, 0}, angular = {0, 0, 0};
    const daft_field *field = daft_field_find(DAFT_STRUCT_ENTITY_DEF, "body");
    add_text(self, "body", FORM_FIXED, NULL, "%s%s", field ? daft_field_print(field, def, kind, sizeof kind) : "",
             def->sensor ? ", a sensor" : "");
    if (def->body == DAFT_BODY_NONE) return;
    if (def->body != DAFT_BODY_STATIC && daft_entity_get_velocity(scene, self->chosen, &linear, &angular, NULL)) {
        add_vector(self, "velocity", ":velocity($)", linear);
        add_vector(self, "angular velocity", ":angular_velocity($)", angular);
    }
    if (def->body == DAFT_BODY_DYNAMIC && daft_entity_get_awake(scene, self->chosen, &awake, NULL))
        add_flag(self, "awake", ":awake($)", awake);
    if (def->body == DAFT_BODY_DYNAMIC && daft_entity_get_mass(scene, self->chosen, &mass, NULL))
        add_number(self, "mass, kg", NULL, mass);
    add_number(self, "friction", NULL, def->friction);
    add_number(self, "restitution", NULL, def->restitution);
    if (def->body == DAFT_BODY_DYNAMIC) add_number(self, "gravity scale", NULL, def->gravity_scale);
}

void inspector_read(inspector *self, daft_scene *scene, host *scripts)
{
    char name[ENTITY_TEXT], tags[ENTITY_TEXT];
    daft_entity_def def;
    self->count = 0;
    if (!self->chosen.id) {
        snprintf(self->title, sizeof self->title, "Click on something");
        return;
    }
    if (!daft_entity_get(scene, self->chosen, &def, NULL)) {
        snprintf(self->title, sizeof self->title, "entity_%" PRIu32 " is gone", self->chosen.id);
        self->edits = false;
        return;
    }
    host_entity_texts(scripts, self->chosen.id, name, tags);
    snprintf(self->title, sizeof self->title, "entity_%" PRIu32, self->chosen.id);
    add_text(self, "name", FORM_TEXT, ".name = $", "%s", name);
    add_text(self, "tags", FORM_NAMES, NULL, "%s", tags);
    read_shape(self, scene, &def);
    read_place(self, scene, &def);
    read_material(self, scene, &def);
    read_body(self, scene, &def);
    if (self->at >= self->count) self->at = self->count - 1;
}

/* ---- changes ---- */

static void put(char *out, const char *text)
{
    const size_t used = strlen(out);
    snprintf(out + used, STATEMENT_SIZE - used, "%s", text);
}

/* A string of Lua. */
static void put_string(char *out, const char *text, size_t length)
{
    put(out, "\"");
    for (size_t i = 0; i < length; i++) {
        if (text[i] == '"' || text[i] == '\\') put(out, "\\");
        put(out, (const char[2]){text[i], 0});
    }
    put(out, "\"");
}

/* Names with commas between them as strings; an empty text gives none. */
static void put_names(char *out, const char *text)
{
    const char *comma = "";
    while (*text) {
        text += strspn(text, " ,");
        size_t length = strcspn(text, ",");
        const char *next = text + length;
        while (length > 0 && text[length - 1] == ' ') length--;
        if (length > 0) put(out, comma), put_string(out, text, length), comma = ", ";
        text = next;
    }
}

/* "#ff0000" needs no quotes, and the numbers of a colour no braces. */
static void put_value(char *out, const inspector_row *row, const char *typed)
{
    const bool bare = row->form == FORM_TEXT || (row->form == FORM_PAINT && !strchr("{\"'", typed[0]));
    const bool numbers = row->is_color && typed[0] && strchr("0123456789.-", typed[0]);
    if (bare || (typed[0] == '#' && row->form == FORM_VALUE))
        put_string(out, typed, strlen(typed));
    else
        put(out, numbers ? "{" : ""), put(out, typed), put(out, numbers ? "}" : "");
}

static void write_line(inspector *self, const inspector_row *row, const char *typed)
{
    char entity[32];
    self->line[0] = 0;
    snprintf(entity, sizeof entity, "entity_%" PRIu32, self->chosen.id);
    if (row->form == FORM_NAMES) { /* in place of those that are there */
        snprintf(self->line, sizeof self->line, "for _, tag in ipairs(%s:tags()) do %s:untag(tag) end", entity, entity);
        if (typed[strspn(typed, " ,")] == 0) return;
        put(self->line, " "), put(self->line, entity), put(self->line, ":tag(");
        put_names(self->line, typed);
        put(self->line, ")");
        return;
    }
    const char *place = strchr(row->change, '$');
    put(self->line, entity);
    snprintf(self->line + strlen(self->line), sizeof self->line - strlen(self->line), "%.*s",
             (int)(place - row->change), row->change);
    put_value(self->line, row, typed + strspn(typed, " "));
    put(self->line, place + 1);
}

static inspector_wish begin_edit(inspector *self)
{
    const inspector_row *row = &self->rows[self->at];
    self->told[0] = 0;
    if (self->at >= self->count) return INSPECTOR_KEEP;
    if (row->form == FORM_FLAG) {
        write_line(self, row, strcmp(row->value, "true") == 0 ? "false" : "true");
        return INSPECTOR_RUN;
    }
    if (row->form == FORM_FIXED) {
        snprintf(self->told, sizeof self->told, "It cannot be changed while the game runs.");
        return INSPECTOR_KEEP;
    }
    edit_set(&self->edit, row->form == FORM_PAINT ? "" : row->exact[0] ? row->exact : row->value);
    self->edits = true;
    return INSPECTOR_KEEP;
}

void inspector_answered(inspector *self, const char *line, const char *answer, bool good)
{
    static const char place[] = "console:1: ";
    if (!self->open || strcmp(line, self->line) != 0) return;
    self->line[0] = 0;
    if (good) self->edits = false;
    if (strncmp(answer, place, sizeof place - 1) == 0) answer += sizeof place - 1;
    snprintf(self->told, sizeof self->told, "%s", good ? "" : answer);
}

/* ---- events ---- */

void inspector_show(inspector *self, bool open)
{
    self->open = open, self->edits = self->ctrl = false;
    self->held.key = -1, self->told[0] = 0, self->box.width = 0;
}

void inspector_choose(inspector *self, daft_entity entity)
{
    if (entity.id != self->chosen.id) self->at = self->first = 0;
    self->chosen = entity, self->edits = false, self->told[0] = 0;
}

size_t inspector_visible(const inspector *self)
{
    const float room = self->box.height - INSPECTOR_HEAD - 40; /* the foot */
    return room > INSPECTOR_ROW ? (size_t)(room / INSPECTOR_ROW) : 1;
}

static void select_row(inspector *self, long at)
{
    const size_t visible = inspector_visible(self);
    if (self->edits || self->count == 0) return;
    self->at = at < 0 ? 0 : (size_t)at >= self->count ? self->count - 1 : (size_t)at;
    if (self->at < self->first) self->first = self->at;
    if (self->at >= self->first + visible) self->first = self->at - visible + 1;
}

static inspector_wish click(inspector *self)
{
    const float x = self->mouse_x - self->box.x, y = self->mouse_y - self->box.y;
    self->edits = false;
    if (!(x >= 0 && x < self->box.width && y >= 0 && y < self->box.height)) return INSPECTOR_PICK;
    const float row = floorf((y - INSPECTOR_HEAD) / INSPECTOR_ROW) + (float)self->first;
    if (row < 0 || row >= (float)self->count || row >= (float)(self->first + inspector_visible(self)))
        return INSPECTOR_KEEP;
    self->at = (size_t)row;
    return begin_edit(self);
}

static inspector_wish press_editing(inspector *self, const char *key)
{
    const bool enter = strcmp(key, "return") == 0 || strcmp(key, "keypad enter") == 0;
    if (strcmp(key, "escape") == 0) self->edits = false, self->told[0] = 0;
    if (enter) write_line(self, &self->rows[self->at], self->edit.text);
    if (!enter) edit_key(&self->edit, key, self->ctrl);
    return enter ? INSPECTOR_RUN : INSPECTOR_KEEP;
}

static inspector_wish press(inspector *self, const char *key)
{
    if (strcmp(key, "mouse1") == 0) return click(self);
    if (strncmp(key, "mouse", 5) == 0) return INSPECTOR_KEEP;
    if (self->edits) return press_editing(self, key);
    if (strcmp(key, "escape") == 0) return INSPECTOR_CLOSE;
    if (self->count == 0) return INSPECTOR_PASS;
    if (strcmp(key, "up") == 0)
        select_row(self, (long)self->at - 1);
    else if (strcmp(key, "down") == 0)
        select_row(self, (long)self->at + 1);
    else if (strcmp(key, "return") == 0 || strcmp(key, "keypad enter") == 0)
        return begin_edit(self);
    else
        return INSPECTOR_PASS;
    return INSPECTOR_KEEP;
}

inspector_wish inspector_take(inspector *self, const input_event *event, uint64_t now_ns)
{
    const char *key = event->kind == INPUT_KEY ? input_key_name(input_letter(event)) : NULL;
    switch (event->kind) {
    case INPUT_MOVE: self->mouse_x = event->x, self->mouse_y = event->y; return INSPECTOR_KEEP;
    case INPUT_MOTION: return INSPECTOR_KEEP;
    case INPUT_WHEEL: select_row(self, (long)self->at - (long)event->y); return INSPECTOR_KEEP;
    case INPUT_TEXT:
        if (self->edits && !self->ctrl) edit_type(&self->edit, event->key);
        return self->edits ? INSPECTOR_KEEP : INSPECTOR_PASS;
    default: break;
    }
    if (!key) return INSPECTOR_PASS;
    if (strstr(key, " ctrl") || strstr(key, " gui")) self->ctrl = event->down;
    repeat_key(&self->held, input_letter(event), event->down, now_ns);
    return event->down ? press(self, key) : INSPECTOR_PASS;
}

/* Keys that move and delete. */
void inspector_repeat(inspector *self, uint64_t now_ns)
{
    const char *key = input_key_name(repeat_next(&self->held, now_ns));
    if (!key) return;
    if (self->edits) edit_key(&self->edit, key, self->ctrl);
    if (strcmp(key, "up") == 0) select_row(self, (long)self->at - 1);
    if (strcmp(key, "down") == 0) select_row(self, (long)self->at + 1);
}
