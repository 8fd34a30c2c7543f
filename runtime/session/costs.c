/* Files of costs: a line that says what it is, and for each rung its cost and its error, or -1 where it is not known.
 */
#include "session/costs.h"

#include "common/util.h"
#include "files/home.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char HEAD[] = "daft frame costs 4\n";

bool costs_folder(char *out, size_t size) { return home_user_folder("XDG_CACHE_HOME", ".cache", out, size); }

/* A game's name is that of a folder, or of a file. */
static bool path_of(const char *folder, const char *game, char out[PATH_SIZE])
{
    if (!folder) return false;
    const int length =
        snprintf(out, PATH_SIZE, "%s/%016llx.costs", folder, (unsigned long long)daft_hash(game, strlen(game), 0));
    return length > 0 && length < PATH_SIZE;
}

static bool parse(const char *text, governor_costs *out)
{
    if (strncmp(text, HEAD, sizeof HEAD - 1) != 0) return false;
    const char *at = text + sizeof HEAD - 1;
    for (int i = 0; i < GOVERNOR_RUNGS; i++) {
        char *end, *last;
        out->cost[i] = strtod(at, &end);
        out->error[i] = strtod(end, &last);
        if (end == at || last == end || !(out->cost[i] > 0 && out->cost[i] < 20)) return false;
        if (!(out->error[i] >= 0 && out->error[i] <= 1)) out->error[i] = (double)NAN;
        at = last;
    }
    return true;
}

bool costs_load(const char *folder, const char *game, governor_costs *out)
{
    char path[PATH_SIZE];
    daft_error ignored;
    size_t size;
    if (!path_of(folder, game, path)) return false;
    char *text = daft_read_file(NULL, path, &size, &ignored); /* ends with a 0 */
    if (!text) return false;
    const bool good = parse(text, out);
    free(text);
    return good;
}

void costs_save(const char *folder, const char *game, const governor_costs *costs)
{
    char path[PATH_SIZE], text[1024];
    daft_error ignored;
    if (!path_of(folder, game, path)) return;
    size_t size = (size_t)snprintf(text, sizeof text, "%s", HEAD);
    for (int i = 0; i < GOVERNOR_RUNGS; i++)
        size += (size_t)snprintf(text + size, sizeof text - size, "%.4f %.5f\n", costs->cost[i],
                                 isnan(costs->error[i]) ? -1 : costs->error[i]);
    daft_write_file(path, text, size, &ignored);
}
