/* The lists of fields of the public structs: that they are complete, and what is made from them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "scene/fields/fields.h"
#include "sim/character/character.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Calls `body` with each struct and field. */
#define EACH_FIELD(which, field)                                                                                       \
    for (daft_struct which = 0; which < DAFT_STRUCT_COUNT; which++)                                                    \
        for (const daft_field *field = daft_fields(which, NULL), *end = field + field_count(which); field < end;       \
             field++)

static uint32_t field_count(daft_struct which)
{
    uint32_t count;
    daft_fields(which, &count);
    return count;
}

enum { LARGEST = 1024 };

static void make_default(daft_struct which, char *out)
{
    assert_true(daft_struct_size(which) <= LARGEST);
    daft_struct_default(which, out);
}

/* ---- completeness ---- */

static char *read_header(void)
{
    FILE *file = fopen(DAFT_ROOT "/engine/daft.h", "rb");
    assert_non_null(file);
    char *text = calloc(1, 1 << 20);
    assert_true(fread(text, 1, (1 << 20) - 1, file) > 10000);
    fclose(file);
    for (char *c = text; (c = strstr(c, "/*"));) { /* comments become blanks */
        char *end = strstr(c, "*/") + 2;
        memset(c, ' ', (size_t)(end - c));
        c = end;
    }
    return text;
}

/* The name that a declarator ends with: "*user" -> user, "effects[N]" -> effects, "(*warn)(void)" -> warn. */
static void declared_name(const char *from, const char *to, char *out, size_t size)
{
    const char *start = from, *call = memchr(from, '(', (size_t)(to - from));
    const char *bracket = memchr(from, '[', (size_t)(to - from));
    if (call)
        for (start = call + 1; !isalpha((unsigned char)*start); start++) {
        }
    const char *end = call ? start : bracket ? bracket : to;
    if (call)
        while (isalnum((unsigned char)*end) || *end == '_') end++;
    while (!isalnum((unsigned char)end[-1])) end--;
    if (!call)
        for (start = end; isalnum((unsigned char)start[-1]) || start[-1] == '_'; start--) {
        }
    snprintf(out, size, "%.*s", (int)(end - start), start);
}

/* Whether the members of the struct in daft.h are the rows of its list, in the same order. */
static void assert_members(const char *header, daft_struct which)
{
    char opening[96], closing[96], name[64];
    uint32_t row = 0;
    snprintf(opening, sizeof opening, "typedef struct %s {", daft_struct_name(which));
    snprintf(closing, sizeof closing, "} %s;", daft_struct_name(which));
    const char *at = strstr(header, opening);
    assert_non_null(at);
    at += strlen(opening);
    const char *end = strstr(at, closing);
    assert_non_null(end);
    for (int depth = 0; at < end; at++) { /* a declarator ends at a comma or a semicolon outside brackets */
        const char *start = at;
        for (; at < end && (depth > 0 || (*at != ',' && *at != ';')); at++) depth += (*at == '(') - (*at == ')');
        if (at == end) break;
        declared_name(start, at, name, sizeof name);
        if (row >= field_count(which)) fail_msg("%s.%s has no row", daft_struct_name(which), name);
        assert_string_equal(daft_fields(which, NULL)[row++].name, name);
    }
    assert_int_equal(row, field_count(which));
}

static void every_member_has_a_row(void **state)
{
    (void)state;
    char *header = read_header();
    for (daft_struct which = 0; which < DAFT_STRUCT_COUNT; which++) assert_members(header, which);
    free(header);
}

/* No byte lies between two rows but padding, which is less than the alignment that it serves. */
static void rows_cover_every_byte(void **state)
{
    (void)state;
    for (daft_struct which = 0; which < DAFT_STRUCT_COUNT; which++) {
        size_t at = 0;
        const daft_field *fields = daft_fields(which, NULL);
        for (uint32_t i = 0; i < field_count(which); i++) {
            if (fields[i].offset < at || fields[i].offset - at >= sizeof(double))
                fail_msg("%s.%s begins at byte %zu, the row before ends at %zu", daft_struct_name(which),
                         fields[i].name, fields[i].offset, at);
            at = fields[i].offset + fields[i].size;
        }
        assert_true(daft_struct_size(which) - at < sizeof(double));
    }
}

static void every_field_is_described(void **state)
{
    (void)state;
    EACH_FIELD(which, field)
    {
        size_t length = field->doc ? strlen(field->doc) : 0;
        if (length < 5 || field->doc[length - 1] == '.') fail_msg("%s.%s", daft_struct_name(which), field->name);
        for (const daft_field *other = daft_fields(which, NULL); other < field; other++) {
            assert_string_not_equal(other->name, field->name);
            if (other->lua && field->lua) assert_string_not_equal(other->lua, field->lua);
            if (other->scene && field->scene) assert_string_not_equal(other->scene, field->scene);
        }
        assert_ptr_equal(daft_field_find(which, field->name), field);
    }
    assert_null(daft_fields(DAFT_STRUCT_COUNT, NULL));
    assert_null(daft_field_find(DAFT_STRUCT_VIEW, "nothing"));
    assert_string_equal(daft_struct_name((daft_struct)-1), "unknown");
}

/* ---- defaults ---- */

static void defaults_are_in_range(void **state)
{
    (void)state;
    for (daft_struct which = 0; which < DAFT_STRUCT_COUNT; which++) {
        char value[LARGEST];
        daft_error error;
        make_default(which, value);
        if (!daft_struct_check(which, value, &error)) fail_msg("%s: %s", daft_struct_name(which), error.message);
    }
    daft_light_def light = daft_default_light_def();
    assert_true(light.inner_angle == (float)(DAFT_PI / 8) && light.color.y == 1 && light.casts_shadow);
    daft_material_def material = daft_default_material_def();
    assert_true(material.refractive_index == 1.5f && material.diffuse.z == 0.8f && !material.diffuse_map.id);
    daft_view view = daft_default_view();
    assert_true(view.camera.fov == (float)(DAFT_PI / 2) && view.quality.samples == 1 &&
                view.quality.edge_samples == 4 && !view.progress);
}

static void the_default_quality_is_that_of_games(void **state)
{
    (void)state;
    const daft_quality game = daft_preset_quality(DAFT_PRESET_GAME);
    daft_quality first;
    uint8_t bytes[2][sizeof game];
    daft_struct_default(DAFT_STRUCT_QUALITY, &first);
    const size_t size = daft_struct_pack(DAFT_STRUCT_QUALITY, &game, bytes[0], sizeof game);
    assert_int_equal(daft_struct_pack(DAFT_STRUCT_QUALITY, &first, bytes[1], sizeof game), size);
    assert_memory_equal(bytes[0], bytes[1], size);
}

/* sim/ has defaults of its own, since it knows nothing of scenes. */
static void the_simulations_defaults_are_the_same(void **state)
{
    (void)state;
    daft_joint_def joint = daft_default_joint_def();
    daft_sim_joint_def sim = daft_default_sim_joint_def();
    assert_true(joint.kind == sim.kind && joint.hertz == sim.hertz && joint.damping == sim.damping);
    assert_memory_equal(&joint.axis, &sim.axis, sizeof sim.axis);
    daft_character_def c = daft_default_character_def();
    daft_sim_character_def s = daft_default_sim_character_def();
    assert_true(c.radius == s.radius && c.height == s.height && c.step_height == s.step_height && c.mass == s.mass);
    assert_true(c.max_slope == s.max_slope && c.acceleration == s.acceleration && c.push_force == s.push_force);
    assert_true(c.air_acceleration == s.air_acceleration && c.gravity_scale == s.gravity_scale);
    assert_true(c.layers == s.layers && c.mask == s.mask);
}

/* ---- checks ---- */

/* Each number just outside its range is refused, by its name; NaN and infinity always. */
static void what_is_out_of_range_is_refused(void **state)
{
    (void)state;
    uint32_t refused = 0;
    EACH_FIELD(which, field)
    {
        char value[LARGEST];
        daft_error error;
        double numbers[4], bad[] = {(double)NAN, (double)INFINITY, field->min - 1, field->max * 2 + 1};
        bool one_sided = isinf(field->max), any = field->min == 0 && field->max == 0;
        make_default(which, value);
        uint32_t count = daft_field_numbers(field, value, numbers);
        bool real =
            field->type >= DAFT_FIELD_FLOAT && field->type <= DAFT_FIELD_ROTATION && field->type != DAFT_FIELD_CHOICE;
        for (size_t k = 0; real && k < (any ? 2 : one_sided ? 3 : 4); k++) {
            double changed[4];
            memcpy(changed, numbers, sizeof changed);
            changed[count - 1] = bad[k];
            daft_field_set_numbers(field, value, changed);
            assert_false(daft_field_check(field, value, "", &error));
            assert_int_equal(strncmp(error.message, field->name, strlen(field->name)), 0);
            refused++;
        }
    }
    assert_true(refused > 200);
}

static void kinds_use_their_fields_alone(void **state)
{
    (void)state;
    daft_error error;
    daft_light_def def = daft_default_light_def();
    def.direction = daft_v3(0, 0, 0), def.outer_angle = 4;
    assert_true(daft_struct_check(DAFT_STRUCT_LIGHT_DEF, &def, &error)); /* a point has neither */
    def.kind = DAFT_LIGHT_SUN;
    assert_false(daft_struct_check(DAFT_STRUCT_LIGHT_DEF, &def, &error));
    assert_string_equal(error.message, "direction is 0, 0, 0; it must have a length");
    def.kind = DAFT_LIGHT_SPOT, def.direction.x = 1;
    assert_false(daft_struct_check(DAFT_STRUCT_LIGHT_DEF, &def, &error));
    assert_string_equal(error.message, "outer_angle is 4; it must be above 0 and at most 3.14159 rad");
    def.kind = (daft_light_kind)7;
    assert_false(daft_struct_check(DAFT_STRUCT_LIGHT_DEF, &def, &error));
    assert_string_equal(error.message, "kind is 7; it must be point, sun, spot or rectangle");
    def.cookie = 0;
    assert_false(daft_struct_check(DAFT_STRUCT_LIGHT_DEF, &def, &error));
    assert_string_equal(error.message, "the definition is not initialised: start from daft_default_light_def()");
    daft_view view = daft_default_view();
    view.camera.fov = 4;
    assert_false(daft_struct_check(DAFT_STRUCT_VIEW, &view, &error));
    assert_string_equal(error.message, "camera.fov is 4; it must be between 1e-06 and 3.1415 rad");
}

/* ---- bytes, hashes ---- */

/* A change of any field shows in the bytes, and in the hash unless the field is flagged. */
static void every_change_shows(void **state)
{
    (void)state;
    EACH_FIELD(which, field)
    {
        char value[LARGEST], packed[2][LARGEST];
        double numbers[4];
        make_default(which, value);
        uint32_t count = daft_field_numbers(field, value, numbers);
        size_t bytes = daft_struct_pack(which, value, packed[0], LARGEST);
        uint64_t hash = daft_struct_hash(which, value, 0);
        if (count == 0) continue;
        numbers[count - 1] = numbers[count - 1] == 1 ? 0 : 1;
        daft_field_set_numbers(field, value, numbers);
        assert_int_equal(daft_struct_pack(which, value, packed[1], LARGEST), bytes);
        assert_memory_not_equal(packed[0], packed[1], bytes);
        bool hashed = !(field->flags & (DAFT_FIELD_NOT_HASHED | DAFT_FIELD_HASHED_USED));
        if ((daft_struct_hash(which, value, 0) != hash) != hashed)
            fail_msg("%s.%s is%s hashed", daft_struct_name(which), field->name, hashed ? " not" : "");
    }
}

/* ---- text ---- */

static void text_goes_both_ways(void **state)
{
    (void)state;
    daft_error error;
    EACH_FIELD(which, field)
    {
        char value[LARGEST], again[LARGEST], text[200];
        make_default(which, value);
        make_default(which, again);
        if (field->type >= DAFT_FIELD_MESH) continue;
        daft_field_print(field, value, text, sizeof text);
        memset(again + field->offset, 0, field->size);
        if (!daft_field_parse(field, text, again, &error)) { /* axes of nothing, counts */
            fail_msg("%s.%s: %s", daft_struct_name(which), field->name, error.message);
        }
        assert_memory_equal(again + field->offset, value + field->offset, field->size);
    }
    daft_light_def def = daft_default_light_def(), same = def;
    const daft_field *color = daft_field_find(DAFT_STRUCT_LIGHT_DEF, "color"), *kind = color - 3;
    assert_true(daft_field_parse(color, "0.25, 1e2,3", &def, &error) && def.color.x == 0.25f && def.color.y == 100);
    assert_true(daft_field_parse(kind, "spot", &def, &error) && def.kind == DAFT_LIGHT_SPOT);
    const struct {
        const daft_field *field;
        const char *text, *says;
    } bad[] = {{color, "1, 2", "color is '1, 2'; it must be numbers with commas between them"},
               {color, "1, 2, 3, 4", "it must be numbers"},
               {color, "1, 2, -3", "color.z is -3; it must be finite and 0 or more"},
               {color, "1, 2, nan", "it must be numbers"},
               {kind, "light", "kind is 'light'; it must be point, sun, spot or rectangle"},
               {color + 1, "perhaps", "casts_shadow is 'perhaps'; it must be true or false"},
               {color - 4, "1", "cookie cannot be set from text"}};
    for (size_t i = 0; i < DAFT_COUNT_OF(bad); i++) {
        def = same;
        assert_false(daft_field_parse(bad[i].field, bad[i].text, &def, &error));
        if (!strstr(error.message, bad[i].says)) fail_msg("'%s' says: %s", bad[i].text, error.message);
        assert_memory_equal(&def, &same, sizeof def);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_member_has_a_row),
        cmocka_unit_test(rows_cover_every_byte),
        cmocka_unit_test(every_field_is_described),
        cmocka_unit_test(defaults_are_in_range),
        cmocka_unit_test(the_default_quality_is_that_of_games),
        cmocka_unit_test(the_simulations_defaults_are_the_same),
        cmocka_unit_test(what_is_out_of_range_is_refused),
        cmocka_unit_test(kinds_use_their_fields_alone),
        cmocka_unit_test(every_change_shows),
        cmocka_unit_test(text_goes_both_ways),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
