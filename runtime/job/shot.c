/* Snapshots as JSON. */
#include "job/shot.h"

#include "common/json.h"

#include <stdlib.h>
#include <string.h>

bool shot_write(const shot *self, const char *path, daft_error *error)
{
    draft_file out;
    if (!draft_open(&out, error)) return false;
    fputs("{\n  \"scene\": ", out.file);
    json_put_text(out.file, self->scene);
    fprintf(out.file, ",\n  \"width\": %d,\n  \"height\": %d,\n  \"view\": ", self->width, self->height);
    json_put_struct(out.file, DAFT_STRUCT_VIEW, &self->view, 2);
    fputs("\n}\n", out.file);
    return draft_commit(&out, path, error);
}

/* The folder of `path`, where the scene's name is relative. */
static bool place_scene(shot *self, const char *path, json_reader *in)
{
    char folder[PATH_SIZE], name[PATH_SIZE];
    const char *slash = strrchr(path, '/');
    if (!self->scene[0]) return json_fail(in, "the scene is missing");
    if (!slash || self->scene[0] == '/') return true;
    snprintf(folder, sizeof folder, "%.*s", (int)(slash - path), path);
    memcpy(name, self->scene, sizeof name);
    return path_join(self->scene, sizeof self->scene, folder, name) ||
           json_fail(in, "the name of the scene is too long");
}

static bool get_side(json_reader *in, int *out)
{
    double number;
    if (!json_get_number(in, &number)) return false;
    if (!(number >= 1 && number <= 16384)) return json_fail(in, "a side of the picture: 1 to 16384 pixels expected");
    *out = (int)number;
    return true;
}

static bool read_all(shot *out, json_reader *in)
{
    char key[32];
    if (!json_begin(in)) return false;
    while (json_key(in, key, sizeof key)) {
        bool good = strcmp(key, "scene") == 0    ? json_get_text(in, out->scene, sizeof out->scene)
                    : strcmp(key, "width") == 0  ? get_side(in, &out->width)
                    : strcmp(key, "height") == 0 ? get_side(in, &out->height)
                    : strcmp(key, "view") == 0   ? json_get_struct(in, DAFT_STRUCT_VIEW, &out->view)
                                                 : json_unknown(in, key);
        if (!good) return false;
    }
    if (in->failed || !json_end(in)) return false;
    return (out->width > 0 && out->height > 0) || json_fail(in, "width and height are missing");
}

bool shot_read(shot *out, const char *path, daft_error *error)
{
    size_t size;
    json_reader in;
    *out = (shot){.view = daft_default_view()};
    char *text = daft_read_file(NULL, path, &size, error);
    if (!text) return false;
    json_open(&in, path, text, error);
    bool good = (strlen(text) == size || json_fail(&in, "this is no text")) && read_all(out, &in) &&
                place_scene(out, path, &in);
    free(text);
    return good;
}
