/* runtime: daft video: formats, the same bits however a film was made, going on after a kill, and errors. */
#include "daft.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <signal.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include "runtime_program.h"
#include "video/blur.h"
#include "video/encode/packets.h"

static char output[OUTPUT_SIZE], folder[] = "/tmp/daft-video-XXXXXX";

#define SMALL "--size 160x90 --quality draft"

static int shell(const char *format, ...) __attribute__((format(printf, 1, 2)));
static int shell(const char *format, ...)
{
    char command[2048];
    va_list list;
    va_start(list, format);
    vsnprintf(command, sizeof command, format, list);
    va_end(list);
    int status = system(command);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static int make_folder(void **unused)
{
    (void)unused;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **unused)
{
    (void)unused;
    return shell("rm -rf '%s'", folder);
}

/* A build without FFmpeg's libraries still has pictures and raw frames. */
static void need_ffmpeg(void)
{
    run_daft(output, "video marble -o %s/probe.mp4 --to 0.02 " SMALL, folder);
    if (strstr(output, "without FFmpeg") || strstr(output, "no encoder")) {
        print_message("skipped: %s", output);
        skip();
    }
}

static void every_format_holds_its_frames(void **unused)
{
    (void)unused;
    need_ffmpeg();
    /* What the files start with, or have a few bytes on: ISO 14496-12, Matroska's EBML, GIF89a. */
    static const struct {
        const char *name, *magic;
        long at;
    } files[] = {{"a.mp4", "ftyp", 4}, {"a.webm", "\x1a\x45\xdf\xa3", 0}, {"a.gif", "GIF89a", 0}};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        char path[128], head[16] = "";
        snprintf(path, sizeof path, "%s/%s", folder, files[i].name);
        int status = run_daft(output, "video marble -o %s --to 0.4 " SMALL, path);
        assert_status(status, 0, output);
        FILE *file = fopen(path, "rb");
        assert_non_null(file);
        size_t got = fread(head, 1, sizeof head, file);
        fclose(file);
        assert_int_equal(got, sizeof head);
        assert_memory_equal(head + files[i].at, files[i].magic, strlen(files[i].magic));
        snprintf(path, sizeof path, "%s/%s.parts", folder, files[i].name);
        assert_int_not_equal(access(path, F_OK), 0);
    }
}

/* A player that is not ours counts the frames. */
static void a_player_sees_every_frame(void **unused)
{
    (void)unused;
    need_ffmpeg();
    if (shell("command -v ffprobe >/dev/null 2>&1") != 0) {
        print_message("skipped: ffprobe is not installed");
        skip();
    }
    int status = run_daft(output, "video marble -o %s/count.mp4 --fps 30 --from 1 --to 4.5 " SMALL, folder);
    assert_status(status, 0, output);
    assert_int_equal(shell("test \"$(ffprobe -v error -select_streams v -count_frames -show_entries "
                           "stream=nb_read_frames,width,height,r_frame_rate -of csv=p=0 %s/count.mp4)\" = "
                           "160,90,30/1,105",
                           folder),
                     0);
}

/* Games sound, in MP4 and WebM; as long as the picture, from where it begins. Scenes are silent. */
static void films_of_games_sound(void **unused)
{
    (void)unused;
    need_ffmpeg();
    static const struct {
        const char *name, *what, *codec;
    } films[] = {
        {"s.mp4", "marble", "mp4a"}, {"s.webm", "marble", "A_OPUS"}, {"q.mp4", "assets/scenes/hello.scene", NULL}};
    for (size_t i = 0; i < sizeof films / sizeof films[0]; i++) {
        char path[128];
        size_t size;
        daft_error error;
        snprintf(path, sizeof path, "%s/%s", folder, films[i].name);
        int status = run_daft(output, "video %s -o %s --from 1 --to 3 " SMALL, films[i].what, path);
        assert_status(status, 0, output);
        char *bytes = daft_read_file(NULL, path, &size, &error);
        assert_non_null(bytes);
        const char *codec = films[i].codec ? films[i].codec : "mp4a";
        const bool silent = strstr(output, "the film is silent") != NULL; /* an FFmpeg without that encoder */
        assert_int_equal(memmem(bytes, size, codec, strlen(codec)) != NULL, films[i].codec != NULL && !silent);
        free(bytes);
        if (!films[i].codec || silent || shell("command -v ffprobe >/dev/null") != 0) continue;
        assert_int_equal(shell("ffprobe -v error -select_streams a -show_entries packet=pts_time -of csv=p=0 %s | "
                               "awk -F, '{ last = $1 } END { exit !(NR > 80 && last > 1.9 && last < 2.05) }'",
                               path),
                         0);
    }
}

static void threads_do_not_change_the_film(void **unused)
{
    (void)unused;
    need_ffmpeg();
    for (int threads = 1; threads <= 3; threads++) {
        int status =
            run_daft(output, "video marble -o %s/t%d.mp4 --to 2.5 --threads %d " SMALL, folder, threads, threads);
        assert_status(status, 0, output);
    }
    assert_int_equal(shell("cmp %s/t1.mp4 %s/t2.mp4 && cmp %s/t1.mp4 %s/t3.mp4", folder, folder, folder, folder), 0);
    /* x264's macroblock tree once let memory that nobody had written into the film. */
    setenv("MALLOC_PERTURB_", "170", 1);
    int status = run_daft(output, "video marble -o %s/t4.mp4 --to 2.5 " SMALL, folder);
    unsetenv("MALLOC_PERTURB_");
    assert_status(status, 0, output);
    assert_int_equal(shell("cmp %s/t1.mp4 %s/t4.mp4", folder, folder), 0);
}

/* Runs the program and kills it after `ms` milliseconds. */
static void kill_after(const char *path, int ms)
{
    pid_t child = fork();
    if (child == 0) {
        if (!freopen("/dev/null", "w", stderr) || chdir(DAFT_ROOT) != 0) _exit(127);
        execl(DAFT_PROGRAM, "daft", "video", "marble", "-o", path, "--to", "8", "--size", "160x90", "-q", "draft",
              NULL);
        _exit(127);
    }
    usleep((useconds_t)ms * 1000);
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
}

static void a_killed_film_goes_on(void **unused)
{
    (void)unused;
    need_ffmpeg();
    char path[128];
    int status = run_daft(output, "video marble -o %s/whole.mp4 --to 8 " SMALL, folder);
    assert_status(status, 0, output);
    snprintf(path, sizeof path, "%s/killed.mp4", folder);
    for (int ms = 100; ms <= 900; ms += 200) kill_after(path, ms);
    assert_int_equal(
        shell("ls -A %s | grep -c killed.mp4$ >/dev/null && ! cmp -s %s/whole.mp4 %s", folder, folder, path), 1);
    /* A clip that was damaged meanwhile is made again. */
    shell("test ! -e %s.parts/000001 || printf x | dd of=%s.parts/000001 bs=1 seek=100 conv=notrunc 2>/dev/null", path,
          path);
    status = run_daft(output, "video marble -o %s --to 8 " SMALL, path);
    assert_status(status, 0, output);
    assert_int_equal(shell("cmp %s/whole.mp4 %s", folder, path), 0);
}

static void pictures_are_numbered_and_taken_over(void **unused)
{
    (void)unused;
    int status = run_daft(output, "video marble -o %s/p%%03d.png --to 0.1 --motion-blur 3 " SMALL, folder);
    assert_status(status, 0, output);
    assert_int_equal(shell("test $(ls %s | grep -c '^p00[0-5].png$') = 6", folder), 0);
    assert_int_equal(shell("test $('%s' video marble -o - --to 0.1 " SMALL " 2>/dev/null | wc -c) = %d", DAFT_PROGRAM,
                           6 * 160 * 90 * 4),
                     0);
}

static void a_scene_is_filmed_along_its_path(void **unused)
{
    (void)unused;
    char path[128];
    snprintf(path, sizeof path, "%s/path.scene", folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "camera 0 0 5 0 180\npath 0 0 0 0 0 0\npath 1 0 0 0 0 90\nskybox %s/assets/sky/day.jpg\n", DAFT_ROOT);
    fclose(file);
    int status = run_daft(output, "video %s -o %s/s%%d.png --fps 2 --size 32x18", path, folder);
    assert_status(status, 0, output);
    assert_int_equal(shell("test -e %s/s1.png && test ! -e %s/s2.png && ! cmp -s %s/s0.png %s/s1.png", folder, folder,
                           folder, folder),
                     0);
    status = run_daft(output, "render %s -o %s/camera.png --size 32x18 --quality high", path, folder);
    assert_status(status, 0, output);
    status = run_daft(output, "video %s -o %s/c%%d.png --fps 2 --to 1 --size 32x18 --camera 0", path, folder);
    assert_status(status, 0, output);
    assert_int_equal(
        shell("cmp %s/camera.png %s/c1.png && ! cmp -s %s/c1.png %s/s1.png", folder, folder, folder, folder), 0);
    status = run_daft(output, "video %s -o %s/c%%d.png --pace fast", path, folder);
    assert_status(status, 2, output);
}

static void motion_blur_is_a_mean_in_linear_light(void **unused)
{
    (void)unused;
    blur state;
    daft_error error;
    uint8_t black[4] = {0, 0, 0, 255}, white[4] = {255, 255, 255, 255}, out[4];
    assert_true(blur_open(&state, 1, &error));
    blur_add(&state, black);
    blur_add(&state, white);
    blur_take(&state, out);
    assert_int_equal(out[0], 188); /* half of the light in sRGB, IEC 61966-2-1 */
    assert_int_equal(out[3], 255);
    for (int byte = 0; byte < 256; byte++) { /* the mean of equal pictures is that picture */
        uint8_t same[4] = {(uint8_t)byte, (uint8_t)(255 - byte), 7, 0};
        for (int i = 0; i < 3; i++) blur_add(&state, same);
        blur_take(&state, out);
        assert_memory_equal(out, same, 3);
    }
    blur_close(&state);
}

static void damaged_clips_are_refused(void **unused)
{
    (void)unused;
    char path[128];
    packet_list list = {0}, back = {0};
    packet head = {.shown = 1, .decoded = -1, .size = 3, .key = true};
    uint32_t frames = 0;
    daft_error error;
    snprintf(path, sizeof path, "%s/clip", folder);
    assert_true(packets_add(&list, &head, (const uint8_t *)"abc"));
    assert_true(packets_save(&list, path, 5, 7, &error));
    assert_true(packets_load(&back, path, 5, &frames));
    assert_int_equal(frames, 7);
    size_t at = 0;
    packet read;
    const uint8_t *bytes = packets_next(&back, &at, &read);
    assert_non_null(bytes);
    assert_memory_equal(bytes, "abc", 3);
    assert_int_equal(read.decoded, -1);
    assert_null(packets_next(&back, &at, &read));
    packets_free(&back);
    assert_false(packets_load(&back, path, 6, &frames));
    for (long cut = 0; cut < 60; cut += 7) {
        assert_int_equal(shell("head -c %ld %s > %s.cut", cut, path, path), 0);
        char shorter[160];
        snprintf(shorter, sizeof shorter, "%s.cut", path);
        assert_false(packets_load(&back, shorter, 5, &frames));
    }
    packets_free(&list);
}

static void mistakes_are_told_before_anything_is_drawn(void **unused)
{
    (void)unused;
    static const struct {
        const char *arguments, *says;
        int status;
    } wrong[] = {{"marble", "-o FILE is missing", 2},
                 {"marble -o a.avi", "ends in .mp4, .webm, .gif or .png", 2},
                 {"marble -o a.png", "frame%05d.png", 1},
                 {"marble -o a%s.png", "frame%05d.png", 1},
                 {"marble -o a%d%d.png", "frame%05d.png", 1},
                 {"marble -o a.mp4 --from 5 --to 5", "--to: a second after --from", 2},
                 {"marble -o a.mp4 --fps 0", "--fps", 2},
                 {"assets/scenes/temple.scene -o a.mp4 --replay b", "a scene has no recording", 2},
                 {"nogame -o %05d.png", "there is no game 'nogame'", 1},
                 {"missing.scene -o %05d.png", "missing.scene", 1},
                 {"marble -o /nonexistent/a%05d.png --to 0.02", "cannot be made", 1},
                 {"marble -o %05d.png --from 500 --to 501 --size 16x16", "ended before second 500", 1},
                 {"tests/games/broken_load -o %05d.png --to 1 --size 16x16", "got the string 'here'", 1}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        int status = run_daft(output, "video %s", wrong[i].arguments);
        assert_status(status, wrong[i].status, output);
        assert_says(output, wrong[i].says);
    }
    int status = run_daft(output, "video marble -o - --to 0.1 " SMALL " >/dev/full");
    assert_status(status, 1, output);
    assert_int_not_equal(shell("cd '%s' && ls -d *.parts 2>/dev/null", DAFT_ROOT), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_format_holds_its_frames),
        cmocka_unit_test(a_player_sees_every_frame),
        cmocka_unit_test(films_of_games_sound),
        cmocka_unit_test(threads_do_not_change_the_film),
        cmocka_unit_test(a_killed_film_goes_on),
        cmocka_unit_test(pictures_are_numbered_and_taken_over),
        cmocka_unit_test(a_scene_is_filmed_along_its_path),
        cmocka_unit_test(motion_blur_is_a_mean_in_linear_light),
        cmocka_unit_test(damaged_clips_are_refused),
        cmocka_unit_test(mistakes_are_told_before_anything_is_drawn),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
