/* Libraries as the dynamic linker has them in memory: their names, and what they need, by their ELF headers (System V
 * ABI, chapter 5; symbol versions as in the Linux Standard Base). */
#include "files/libraries.h"

#include <stdlib.h>
#include <string.h>

bool libraries_desktop_has(const char *name)
{
    static const char *const DESKTOP[] = {
        /* glibc */
        "ld-linux", "libc", "libm", "libmvec", "libpthread", "libdl", "librt", "libutil", "libresolv", "libanl",
        /* the compiler's own, which graphics drivers need too */
        "libgcc_s", "libstdc++",
        /* the window system; libXss and libdecor-0 are not everywhere */
        "libX11", "libX11-xcb", "libxcb", "libXext", "libXcursor", "libXi", "libXfixes", "libXrandr", "libXrender",
        "libXau", "libXdmcp", "libwayland-client", "libwayland-cursor", "libwayland-egl", "libwayland-server",
        "libxkbcommon",
        /* graphics */
        "libGL", "libEGL", "libGLX", "libOpenGL", "libGLdispatch", "libglapi", "libdrm", "libgbm", "libvulkan",
        /* sound; libjack is not everywhere, and nobody talks to its server */
        "libasound", "libpulse", "libpulse-simple", "libpipewire-0.3",
        /* what the desktop's own libraries use */
        "libdbus-1", "libglib-2.0", "libgobject-2.0", "libgmodule-2.0", "libgthread-2.0", "libgio-2.0", "libz",
        "libexpat"};
    const char *end = strstr(name, ".so");
    const size_t length = end ? (size_t)(end - name) : 0;
    for (size_t i = 0; i < COUNT_OF(DESKTOP); i++)
        if (strlen(DESKTOP[i]) == length && strncmp(name, DESKTOP[i], length) == 0) return true;
    return strncmp(name, "ld-", 3) == 0 || strncmp(name, "libc.musl-", 10) == 0;
}

#ifdef __linux__

#include <dlfcn.h>
#include <link.h>

bool libraries_load_assimp(daft_error *error)
{
#ifdef DAFT_ASSIMP_LIBRARY
    if (dlopen(DAFT_ASSIMP_LIBRARY, RTLD_LAZY | RTLD_LOCAL)) return true; /* it stays, as the engine's own does */
    return fail(error, DAFT_ERROR_UNSUPPORTED,
                "the game has models that take Assimp, and %s cannot be loaded: install "
                "libassimp5 (Debian)",
                DAFT_ASSIMP_LIBRARY);
#else
    return fail(error, DAFT_ERROR_UNSUPPORTED,
                "the game has models that take Assimp, and this program was built without "
                "it: install libassimp-dev (Debian) and build again");
#endif
}

/* ---- what is loaded ---- */

enum { NEEDS = 64 };

typedef struct object {
    const char *path, *name; /* the program has neither */
    const char *needs[NEEDS];
    size_t need_count;
    int glibc;
    bool wanted, host; /* needed by the program; by what a desktop has */
} object;

typedef struct process {
    object objects[LIBRARIES];
    size_t count;
    bool full;
} process;

/* Some systems put addresses into the dynamic section in memory, others leave the offsets of the file. */
static const char *locate(const struct dl_phdr_info *info, ElfW(Addr) value)
{
    return (const char *)(value < info->dlpi_addr ? info->dlpi_addr + value : value);
}

/* The newest GLIBC_2.x of what this object asks of others. */
static int newest_glibc(const char *names, const char *first)
{
    int newest = 0;
    for (const char *at = first; at;) {
        const ElfW(Verneed) *need = (const void *)at;
        const char *version = at + need->vn_aux;
        for (int i = 0; i < need->vn_cnt; i++) {
            const ElfW(Vernaux) *one = (const void *)version;
            int minor;
            if (sscanf(names + one->vna_name, "GLIBC_2.%d", &minor) == 1 && minor > newest) newest = minor;
            version += one->vna_next;
        }
        at = need->vn_next ? at + need->vn_next : NULL;
    }
    return newest;
}

static void read_dynamic(object *o, const struct dl_phdr_info *info, const ElfW(Dyn) * dynamic)
{
    const char *names = NULL, *versions = NULL;
    for (const ElfW(Dyn) *d = dynamic; d->d_tag != DT_NULL; d++) {
        if (d->d_tag == DT_STRTAB) names = locate(info, d->d_un.d_ptr);
        if (d->d_tag == DT_VERNEED) versions = locate(info, d->d_un.d_ptr);
    }
    for (const ElfW(Dyn) *d = dynamic; names && d->d_tag != DT_NULL; d++) {
        if (d->d_tag == DT_SONAME) o->name = names + d->d_un.d_val;
        if (d->d_tag == DT_NEEDED && o->need_count < NEEDS) o->needs[o->need_count++] = names + d->d_un.d_val;
    }
    if (names && versions) o->glibc = newest_glibc(names, versions);
}

static int take(struct dl_phdr_info *info, size_t size, void *user)
{
    process *all = user;
    (void)size;
    all->full = all->count == LIBRARIES;
    if (all->full) return 1;
    object *o = &all->objects[all->count++];
    *o = (object){.path = info->dlpi_name};
    for (int i = 0; i < info->dlpi_phnum; i++)
        if (info->dlpi_phdr[i].p_type == PT_DYNAMIC)
            read_dynamic(o, info, (const void *)(info->dlpi_addr + info->dlpi_phdr[i].p_vaddr));
    if (!o->name && o->path[0]) o->name = strrchr(o->path, '/') ? strrchr(o->path, '/') + 1 : o->path;
    return 0;
}

static object *find(process *all, const char *name)
{
    for (size_t i = 1; i < all->count; i++)
        if (strcmp(all->objects[i].name, name) == 0) return &all->objects[i];
    return NULL;
}

/* ---- what to carry ---- */

/* All that a desktop's library needs, it has there. */
static void mark_host(process *all, object *o)
{
    if (o->host) return;
    o->host = true;
    for (size_t i = 0; i < o->need_count; i++) {
        object *next = find(all, o->needs[i]);
        if (next) mark_host(all, next);
    }
}

static void note_desktop(libraries *out, const char *name)
{
    for (size_t i = 0; i < out->desktop_count; i++)
        if (strcmp(out->desktop[i], name) == 0) return;
    if (out->desktop_count < LIBRARIES) out->desktop[out->desktop_count++] = name;
}

static bool mark_wanted(process *all, object *o, libraries *out, daft_error *error)
{
    if (o->wanted) return true;
    o->wanted = true;
    if (o->glibc > out->glibc) out->glibc = o->glibc;
    for (size_t i = 0; i < o->need_count; i++) {
        const char *name = o->needs[i];
        object *next = find(all, name);
        if (libraries_desktop_has(name))
            note_desktop(out, name);
        else if (!next)
            return fail(error, DAFT_ERROR_IO, "%s is needed, but it is not loaded: it cannot be packed", name);
        else if (!mark_wanted(all, next, out, error))
            return false;
    }
    return true;
}

/* The kernel's own object has no file; and what the user has put before all programs is not this one's. */
static bool is_foreign(const object *o)
{
    const char *preloaded = getenv("LD_PRELOAD");
    return !strchr(o->path, '/') || (preloaded && strstr(preloaded, strrchr(o->path, '/') + 1));
}

/* The program's first; then what was loaded by name, as libraries load parts of their own, with no desktop's library
 * needing it. */
static bool mark(process *all, libraries *out, daft_error *error)
{
    for (size_t i = 1; i < all->count; i++)
        if (libraries_desktop_has(all->objects[i].name)) mark_host(all, &all->objects[i]);
    if (!mark_wanted(all, &all->objects[0], out, error)) return false;
    for (size_t i = 1; i < all->count; i++) {
        object *o = &all->objects[i];
        const bool first = find(all, o->name) == o; /* of two with one name */
        if (first && !o->wanted && !o->host && !is_foreign(o) && !mark_wanted(all, o, out, error)) return false;
    }
    return true;
}

static bool carry(libraries *out, const object *o, daft_error *error)
{
    library *to = &out->carried[out->carried_count++];
    char *path = realpath(o->path, NULL);
    if (snprintf(to->name, sizeof to->name, "%s", o->name) >= (int)sizeof to->name || !path ||
        snprintf(to->path, sizeof to->path, "%s", path) >= (int)sizeof to->path) {
        free(path);
        return fail(error, DAFT_ERROR_IO, "%s: this library's file cannot be found", o->path);
    }
    free(path);
    return true;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const library *)a)->name, ((const library *)b)->name);
}
static int by_text(const void *a, const void *b) { return strcmp(*(const char *const *)a, *(const char *const *)b); }

bool libraries_find(libraries *out, daft_error *error)
{
    process *all = calloc(1, sizeof *all);
    if (!all) return fail(error, DAFT_ERROR_MEMORY, "out of memory for the list of libraries");
    memset(out, 0, sizeof *out);
    dl_iterate_phdr(take, all);
    bool good = !all->full || fail(error, DAFT_ERROR_IO, "more than %d libraries are loaded", (int)LIBRARIES);
    good = good && mark(all, out, error);
    for (size_t i = 1; good && i < all->count; i++)
        if (all->objects[i].wanted) good = carry(out, &all->objects[i], error);
    free(all);
    qsort(out->carried, out->carried_count, sizeof *out->carried, by_name);
    qsort(out->desktop, out->desktop_count, sizeof *out->desktop, by_text);
    return good;
}

#else

static bool only_linux(daft_error *error)
{
    return fail(error, DAFT_ERROR_UNSUPPORTED, "which libraries a program takes is known on Linux only");
}

bool libraries_load_assimp(daft_error *error) { return only_linux(error); }
bool libraries_find(libraries *out, daft_error *error)
{
    (void)out;
    return only_linux(error);
}

#endif
