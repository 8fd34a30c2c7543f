/* The reference that `daft help lua` prints, from the tables of functions. */
#include "lua/fields.h"

#include "common/util.h"

#include <stdio.h>
#include <string.h>

enum { NAME_WIDTH = 20, VALUE_WIDTH = 36 };

static void print_field(void *unused, const char *name, const char *value, const char *initial, const char *doc)
{
    (void)unused;
    printf("        %-*s %-*s %s", NAME_WIDTH, name, VALUE_WIDTH, value, doc);
    printf(*initial ? " (%s)\n" : "\n", initial);
}

/* The fields of the tables that the function takes. */
static void print_forms(const char *function)
{
    size_t count;
    const api_form *const *forms = api_forms(&count);
    for (size_t i = 0; i < count; i++) {
        if (strcmp(forms[i]->function, function) != 0) continue;
        if (strstr(forms[i]->title, function) == NULL || strstr(forms[i]->title, "options"))
            printf("      %s:\n", forms[i]->title);
        api_describe_form(forms[i], print_field, NULL);
    }
}

static void print_function(const api_function *function)
{
    printf("  %s%s%s\n", strchr(function->name, ':') ? "" : "daft.", function->name, function->form);
    for (const char *line = function->doc; line;) {
        const char *end = strchr(line, '\n');
        printf("      %.*s\n", (int)(end ? end - line : (long)strlen(line)), line);
        line = end ? end + 1 : NULL;
    }
    print_forms(function->name);
}

static void print_all(void)
{
    size_t areas;
    const api_area *const *all = api_areas(&areas);
    printf(
        "The functions of a DAFT game. It may define daft.load(), daft.update(dt), daft.draw(),\n"
        "daft.keypressed(key), daft.keyreleased(key) and daft.textinput(letter); dt is always 1/60 s.\n"
        "For live reload: daft.keep() returns what daft.reload(old) of the new code is given.\n"
        "Metres, seconds, kilograms, radians; Y is up. Colours: \"#rgb\" or \"#rrggbb\" (sRGB), {r, g, b} (linear).\n");
    for (size_t area = 0; area < areas; area++) {
        printf("\n%s\n", all[area]->title);
        for (size_t i = 0; i < all[area]->count; i++) print_function(&all[area]->functions[i]);
    }
}

/* Whether it is the function, or the type or table that it is in, or the method's name alone. */
static bool answers(const api_function *function, const char *name)
{
    const size_t length = strlen(name);
    const char *colon = strchr(function->name, ':');
    if (strncmp(function->name, name, length) == 0 && strchr(":.", function->name[length])) return true;
    return colon && strcmp(colon + 1, name) == 0;
}

bool api_print_reference(const char *name, const char **near)
{
    enum { MOST = 512 };
    const char *names[MOST];
    size_t areas, count = 0;
    const api_area *const *all = api_areas(&areas);
    bool found = false;
    if (!name) {
        print_all();
        return true;
    }
    if (strncmp(name, "daft.", 5) == 0) name += 5;
    for (size_t area = 0; area < areas; area++)
        for (size_t i = 0; i < all[area]->count; i++) {
            const api_function *function = &all[area]->functions[i];
            const char *colon = strchr(function->name, ':');
            if (count + 2 <= MOST) names[count++] = function->name;
            if (count + 1 <= MOST && colon) names[count++] = colon + 1;
            if (!answers(function, name)) continue;
            print_function(function);
            found = true;
        }
    *near = found ? NULL : nearest_name(name, names, count);
    return found;
}
