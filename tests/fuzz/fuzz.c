/* What the targets share: a folder of their own, with small files for inputs to name. */
#include "fuzz.h"

#include <string.h>
#include <unistd.h>

const fuzz_target FUZZ_TARGETS[FUZZ_TARGET_COUNT] = {{"obj", obj_input, 10, false},
                                                     {"mtl", mtl_input, 10, false},
                                                     {"scene", scene_input, 10, false},
                                                     {"image", image_input, 10, false},
                                                     {"render", render_input, 20, false},
                                                     {"lua", lua_input, 10, true},
                                                     {"recording", recording_input, 10, false},
                                                     {"pack", pack_input, 10, false},
                                                     {"calls", calls_input, 20, false},
                                                     {"state", state_input, 10, false},
                                                     {"font", font_input, 10, false}};

static char folder[256];

static const char *const names[] = {"thing.obj",  "paint.mtl", "picture.png", "other.scene",
                                    "self.scene", "input.obj", "input.scene", "input.image",
                                    "main.lua",   "input.rec", "again.rec",   "input.ttf"};

static const char thing[] = "mtllib paint.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
                            "usemtl red\nf 1/1 3/3 2/2\nf 1/1 2/2 4/3\nusemtl glass\nf 1 4 3\nf 2 3 4\n";
static const char paint[] =
    "newmtl red\nKd 0.8 0.1 0.1\nmap_Kd picture.png\nnewmtl glass\nKd 0 0 0\nKs 1 1 1\nillum 3\n";
static const char other[] = "light 0 5 0 1 1 1\nmesh thing.obj 2 0 0\n";
static const char self[] = "include self.scene\n";

/* 2 by 2 pixels, RGB. */
static const uint8_t picture[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00, 0x00,
    0x02, 0x00, 0x00, 0x00, 0x02, 0x08, 0x02, 0x00, 0x00, 0x00, 0xfd, 0xd4, 0x9a, 0x73, 0x00, 0x00, 0x00, 0x12, 0x49,
    0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0xf8, 0xcf, 0xc0, 0xc0, 0x00, 0xc2, 0x0c, 0xff, 0x81, 0x00, 0x00, 0x1f, 0xee,
    0x05, 0xfb, 0xf1, 0xab, 0xba, 0x77, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

static void clean_up(void)
{
    char path[512];
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        unlink(path);
    }
    rmdir(folder);
}

const char *fuzz_root(void)
{
    static char root[512];
    if (root[0]) return root;
    snprintf(root, sizeof root, "%s", DAFT_ROOT);
    if (access(DAFT_ROOT "/assets", R_OK) == 0) return root;
    char program[480];
    ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    FUZZ_CHECK(length > 0);
    program[length] = 0;
    *strrchr(program, '/') = 0;
    snprintf(root, sizeof root, "%s/daft", program);
    return root;
}

const char *fuzz_write(const char *name, const void *data, size_t size)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", fuzz_folder(), name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file) != 0) {
        perror(path);
        exit(2);
    }
    return path;
}

const char *fuzz_folder(void)
{
    if (folder[0]) return folder;
    const char *temporary = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%.200s/daft-fuzz-XXXXXX", temporary && temporary[0] ? temporary : "/tmp");
    if (!mkdtemp(folder)) {
        perror(folder);
        exit(2);
    }
    atexit(clean_up);
    fuzz_write("thing.obj", thing, sizeof thing - 1);
    fuzz_write("paint.mtl", paint, sizeof paint - 1);
    fuzz_write("picture.png", picture, sizeof picture);
    fuzz_write("other.scene", other, sizeof other - 1);
    fuzz_write("self.scene", self, sizeof self - 1);
    return folder;
}

void fuzz_check_error(bool good, const daft_error *error)
{
    FUZZ_CHECK(good == (error->code == DAFT_OK));
    if (good) return;
    FUZZ_CHECK(memchr(error->message, 0, sizeof error->message) && error->message[0]);
    FUZZ_CHECK(memchr(error->file, 0, sizeof error->file));
    FUZZ_CHECK(error->line >= 0 && error->column >= 0);
    char text[1200];
    FUZZ_CHECK(strlen(daft_error_text(error, text, sizeof text)) < sizeof text);
}
