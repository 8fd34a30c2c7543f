/* daft_generate ROOT: writes every generated file below ROOT/assets. */
#include "generate.h"

#include <string.h>
#include <errno.h>

FILE *open_output(const char *root, const char *path)
{
    char full[4096];
    if (snprintf(full, sizeof full, "%s/%s", root, path) >= (int)sizeof full) {
        fprintf(stderr, "%s: the path is too long\n", path);
        return NULL;
    }
    FILE *file = fopen(full, "wb");
    if (!file) fprintf(stderr, "%s: cannot write: %s\n", full, strerror(errno));
    return file;
}

bool close_output(FILE *file, const char *path)
{
    bool bad = ferror(file) != 0;
    if (fclose(file) != 0) bad = true;
    if (bad) fprintf(stderr, "%s: writing failed\n", path);
    return !bad;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: daft_generate ROOT\n");
        return 2;
    }
    bool ok = generate_font(argv[1]) && generate_textures(argv[1]) && generate_sky(argv[1]) && generate_dusk(argv[1]) &&
              generate_meshes(argv[1]) && generate_hard(argv[1]) && generate_forest(argv[1]) &&
              generate_hall(argv[1]) && generate_town(argv[1]) && generate_studio(argv[1]) &&
              generate_figure(argv[1]) && generate_leaves(argv[1]) && generate_gallery(argv[1]) &&
              generate_wine(argv[1]) && generate_neon(argv[1]);
    return ok ? 0 : 1;
}
