/* daft help fields: the structs of the C library, the tables of Lua and the options of .scene files as tables in
 * Markdown, from the lists of fields. The manual's tables are made by it (docs/tables.sh). */
#include "cli/commands.h"

#include "common/util.h"
#include "lua/fields.h"

#include <stdio.h>
#include <string.h>

/* A '|' would end the column. */
static void put_cell(const char *text, bool code)
{
    fputs(code && *text ? "| `" : "| ", stdout);
    for (const char *c = text; *c; c++) fputs(*c == '|' ? "\\|" : (char[2]){*c, 0}, stdout);
    fputs(code && *text ? "` " : " ", stdout);
}

/* ---- C ---- */

static const char *const TYPES[DAFT_FIELD_TYPE_COUNT] = {[DAFT_FIELD_BOOL] = "bool",
                                                         [DAFT_FIELD_INT] = "int",
                                                         [DAFT_FIELD_UINT] = "uint32_t",
                                                         [DAFT_FIELD_UINT64] = "uint64_t",
                                                         [DAFT_FIELD_FLOAT] = "float",
                                                         [DAFT_FIELD_DOUBLE] = "double",
                                                         [DAFT_FIELD_CHOICE] = "enum",
                                                         [DAFT_FIELD_VEC2] = "daft_vec2",
                                                         [DAFT_FIELD_VEC3] = "daft_vec3",
                                                         [DAFT_FIELD_COLOR] = "daft_vec3",
                                                         [DAFT_FIELD_DIRECTION] = "daft_vec3",
                                                         [DAFT_FIELD_POSITION] = "daft_dvec3",
                                                         [DAFT_FIELD_ROTATION] = "daft_quat",
                                                         [DAFT_FIELD_MESH] = "daft_mesh",
                                                         [DAFT_FIELD_TEXTURE] = "daft_texture",
                                                         [DAFT_FIELD_MATERIAL] = "daft_material",
                                                         [DAFT_FIELD_ENTITY] = "daft_entity",
                                                         [DAFT_FIELD_STRUCT] = "struct",
                                                         [DAFT_FIELD_TEXT] = "const char *",
                                                         [DAFT_FIELD_OTHER] = ""};

static void print_struct(daft_struct which)
{
    uint32_t count;
    const daft_field *fields = daft_fields(which, &count);
    _Alignas(16) char defaults[2048];
    if (daft_struct_size(which) > sizeof defaults) return;
    daft_struct_default(which, defaults);
    bool counts = which == DAFT_STRUCT_COUNTERS || which == DAFT_STRUCT_SIM_COUNTERS; /* read, not set */
    puts(counts ? "| field | type | unit | means |\n|---|---|---|---|"
                : "| field | type | unit | range | default | means |\n|---|---|---|---|---|---|");
    for (uint32_t i = 0; i < count; i++) {
        const daft_field *field = &fields[i];
        char range[200], initial[200];
        put_cell(field->name, true);
        put_cell(TYPES[field->type], true);
        put_cell(field->unit ? field->unit : "", false);
        if (!counts) {
            put_cell(daft_field_range(field, range, sizeof range), false);
            put_cell(daft_field_print(field, defaults, initial, sizeof initial), false);
        }
        put_cell(field->doc, false);
        puts("|");
    }
}

/* ---- Lua ---- */

static void print_row(void *unused, const char *name, const char *value, const char *initial, const char *doc)
{
    (void)unused;
    put_cell(name, true);
    put_cell(value, false);
    put_cell(initial, true);
    put_cell(doc, false);
    puts("|");
}

static void print_form(const api_form *form)
{
    puts("| field | value | default | means |\n|---|---|---|---|");
    api_describe_form(form, print_row, NULL);
}

/* ---- .scene ---- */

/* Items with options, and the kind of light or shape that each makes. */
static const struct {
    const char *name;
    daft_struct which;
    uint32_t kind;
} ITEMS[] = {{"camera", DAFT_STRUCT_CAMERA, 0},
             {"light", DAFT_STRUCT_LIGHT_DEF, DAFT_LIGHT_POINT},
             {"sun", DAFT_STRUCT_LIGHT_DEF, DAFT_LIGHT_SUN},
             {"spot", DAFT_STRUCT_LIGHT_DEF, DAFT_LIGHT_SPOT},
             {"rectangle", DAFT_STRUCT_LIGHT_DEF, DAFT_LIGHT_RECTANGLE},
             {"sphere", DAFT_STRUCT_ENTITY_DEF, DAFT_SHAPE_SPHERE},
             {"mesh", DAFT_STRUCT_ENTITY_DEF, DAFT_SHAPE_MESH},
             {"material", DAFT_STRUCT_MATERIAL_DEF, 0},
             {"fog", DAFT_STRUCT_FOG, 0},
             {"exposure", DAFT_STRUCT_EXPOSURE, 0},
             {"quality", DAFT_STRUCT_QUALITY, 0}};

/* "light, sun, spot": the items whose kind uses the field. */
static void list_items(daft_struct which, const daft_field *field, char *out, size_t size)
{
    size_t used = 0;
    out[0] = 0;
    for (size_t i = 0; i < COUNT_OF(ITEMS) && used < size; i++)
        if (ITEMS[i].which == which && (!field->kinds || field->kinds >> ITEMS[i].kind & 1))
            used += (size_t)snprintf(out + used, size - used, "%s%s", used ? ", " : "", ITEMS[i].name);
}

static void print_option(daft_struct which, const daft_field *field, const void *defaults)
{
    char text[200];
    bool angle = field->unit && strcmp(field->unit, "rad") == 0;
    put_cell(field->scene, true);
    list_items(which, field, text, sizeof text);
    put_cell(text, false);
    put_cell(angle ? "degrees" : daft_field_range(field, text, sizeof text), false);
    put_cell(daft_field_print(field, defaults, text, sizeof text), false);
    put_cell(field->doc, false);
    puts("|");
}

static void print_options(void)
{
    puts("| option | of | value | default | means |\n|---|---|---|---|---|");
    for (size_t i = 0; i < COUNT_OF(ITEMS); i++) {
        uint32_t count;
        const daft_field *fields = daft_fields(ITEMS[i].which, &count);
        _Alignas(16) char defaults[2048];
        if (i > 0 && ITEMS[i].which == ITEMS[i - 1].which) continue;
        daft_struct_default(ITEMS[i].which, defaults);
        for (uint32_t k = 0; k < count; k++)
            if (fields[k].scene) print_option(ITEMS[i].which, &fields[k], defaults);
    }
}

/* ---- which ---- */

static void print_names(void)
{
    size_t count;
    const api_form *const *forms = api_forms(&count);
    printf("usage: daft help fields NAME\n\nTables in Markdown of\n  scene: the options of .scene files\n");
    for (size_t i = 0; i < count; i++) printf("  %s\n", forms[i]->title);
    for (daft_struct which = 0; which < DAFT_STRUCT_COUNT; which++) printf("  %s\n", daft_struct_name(which));
}

int command_fields(int argc, char **argv)
{
    size_t count;
    const api_form *const *forms = api_forms(&count);
    if (argc < 2) return print_names(), STATUS_DONE;
    if (strcmp(argv[1], "scene") == 0) return print_options(), STATUS_DONE;
    for (size_t i = 0; i < count; i++)
        if (strcmp(argv[1], forms[i]->title) == 0) return print_form(forms[i]), STATUS_DONE;
    for (daft_struct which = 0; which < DAFT_STRUCT_COUNT; which++)
        if (strcmp(argv[1], daft_struct_name(which)) == 0) return print_struct(which), STATUS_DONE;
    fprintf(stderr, "daft help fields: nothing has the name '%s'\nTry 'daft help fields'.\n", argv[1]);
    return STATUS_BAD_USAGE;
}
