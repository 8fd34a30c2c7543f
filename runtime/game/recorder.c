/* Writes recordings, line by line as the game runs: see recording.h, where the format is, and recording.c, which reads
 * it. */
#include "game/recording.h"

#include "game/loop.h"
#include "common/util.h"
#include "game/fingerprint.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

/* What a cut needs to know of a tick. */
typedef struct recorded_tick {
    long begins;   /* in the file, bytes */
    uint16_t hash; /* of the state after it, in part */
} recorded_tick;

struct recorder {
    pthread_mutex_t lock; /* of what follows: recorder_finish may be called from any thread */
    FILE *file;           /* NULL: the recording is in place, or was lost */
    uint64_t ticks;       /* whose input is in the file */
    char path[PATH_SIZE], part[PATH_SIZE + 8];
    recording_state now;   /* the second that is not yet in the file */
    recording_mark *known; /* of entities, by their index: what was told last */
    size_t known_count;
    recorded_tick *past; /* of each tick */
    size_t past_count, past_capacity;
};

enum { INDEX_MASK = (1 << 20) - 1 }; /* an entity's number is its index and a generation above it */

/* The file that is being recorded is locked, so that no other game takes it for a left-over one. */
static bool keep_left_over(const recorder *writer, daft_error *error)
{
    char old[PATH_SIZE + 16];
    int file = open(writer->part, O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) return true;
    bool busy = flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    close(file);
    if (busy) return fail_at(error, writer->path, 0, 0, "another game is being recorded to this file");
    snprintf(old, sizeof old, "%s-old", writer->part);
    return rename(writer->part, old) == 0 ||
           fail_at(error, writer->part, 0, 0, "cannot be renamed: %s", strerror(errno));
}

static bool open_part(recorder *writer, const char *path, daft_error *error)
{
    int length = snprintf(writer->path, sizeof writer->path, "%s", path);
    if (length < 0 || (size_t)length >= sizeof writer->path) return fail_at(error, path, 0, 0, "the name is too long");
    snprintf(writer->part, sizeof writer->part, "%s.part", path);
    if (path_is_folder(path)) return fail_at(error, path, 0, 0, "a folder, not a file");
    if (!keep_left_over(writer, error)) return false;
    int file = open(writer->part, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file < 0) return fail_at(error, path, 0, 0, "cannot be written: %s", strerror(errno));
    flock(file, LOCK_EX | LOCK_NB);
    writer->file = fdopen(file, "w");
    if (writer->file) return true;
    close(file);
    unlink(writer->part);
    return fail(error, DAFT_ERROR_MEMORY, "out of memory for a recording");
}

static void put_head(FILE *file, const recording_head *head)
{
    fprintf(file, "daft-recording 6\ngame %s\nrate %d\nseed %" PRIu64 "\n", head->game, LOOP_RATE, head->seed);
    if (head->pack && head->pack[0]) fprintf(file, "pack %s\n", head->pack);
    if (head->content && head->content[0]) fprintf(file, "content %s\n", head->content);
    if (head->memory) fprintf(file, "limits %" PRIu64 " %.9g\n", head->memory, head->seconds);
}

recorder *recorder_open(const char *path, const recording_head *head, daft_error *error)
{
    recorder *writer = calloc(1, sizeof *writer);
    if (!writer) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a recording");
        return NULL;
    }
    if (!open_part(writer, path, error)) {
        free(writer);
        return NULL;
    }
    pthread_mutex_init(&writer->lock, NULL);
    put_head(writer->file, head);
    return writer;
}

static void put_event(FILE *file, uint64_t tick, const input_event *event)
{
    size_t count;
    static const char *const names[] = {[INPUT_MOVE] = "mouse", [INPUT_MOTION] = "motion", [INPUT_WHEEL] = "wheel"};
    fprintf(file, "%" PRIu64 " ", tick);
    if (event->kind == INPUT_KEY)
        fprintf(file, "%c%s\n", event->down ? '+' : '-', input_key_name(event->key));
    else if (event->kind == INPUT_TEXT)
        fprintf(file, "text %04x\n", (unsigned)event->key);
    else if (event->kind == INPUT_STICK)
        fprintf(file, "stick %.9g %s\n", (double)event->x, input_stick_names(&count)[event->key]);
    else if (event->kind == INPUT_WIDTH)
        fprintf(file, "width %.9g\n", (double)event->x);
    else /* nine digits bring a float back to the bit */
        fprintf(file, "%s %.9g %.9g\n", names[event->kind], (double)event->x, (double)event->y);
}

/* Without memory for it the recording is still right, but cannot be cut. */
static void note_tick(recorder *writer, uint64_t tick)
{
    if (!writer->file || tick != writer->past_count) return;
    if (writer->past_count == writer->past_capacity) {
        const size_t more = writer->past_capacity ? 2 * writer->past_capacity : 1024;
        recorded_tick *grown = realloc(writer->past, more * sizeof *grown);
        if (!grown) return;
        writer->past = grown, writer->past_capacity = more;
    }
    writer->past[writer->past_count++] = (recorded_tick){ftell(writer->file), 0};
}

void recorder_tick(recorder *writer, uint64_t tick, const input_event *events, size_t count)
{
    pthread_mutex_lock(&writer->lock);
    bool marks = tick > 0 && tick % LOOP_RATE == 0 && tick >= writer->ticks; /* once */
    if (writer->file && marks) fprintf(writer->file, "tick %" PRIu64 "\n", tick);
    if (writer->file && marks) fflush(writer->file);
    note_tick(writer, tick);
    for (size_t i = 0; writer->file && i < count; i++) put_event(writer->file, tick, &events[i]);
    writer->ticks = tick + 1;
    pthread_mutex_unlock(&writer->lock);
}

void recorder_line(recorder *writer, uint64_t tick, const char *text)
{
    pthread_mutex_lock(&writer->lock);
    if (writer->file) fprintf(writer->file, "%" PRIu64 " lua %s\n", tick, text);
    pthread_mutex_unlock(&writer->lock);
}

static void put_state(recorder *writer)
{
    const recording_state *now = &writer->now;
    fprintf(writer->file, "state %" PRIu64 " %016" PRIx64 "%s", now->tick, now->hash, now->count ? " " : "");
    for (uint32_t i = 0; i < now->count; i++) fprintf(writer->file, "%04x", (unsigned)now->ticks[i]);
    fputc('\n', writer->file);
    writer->now = (recording_state){0};
}

/* Tells what an entity is, where that is new. False: the line is full. */
static bool put_mark(recorder *writer, recording_mark mark, int *told)
{
    recording_mark *known = &writer->known[mark.entity & INDEX_MASK];
    if (known->entity == mark.entity && known->print == mark.print && known->gone == mark.gone) return true;
    if (*told == RECORDING_MARKS) return false;
    if ((*told)++ == 0) fprintf(writer->file, "entities %" PRIu64, mark.tick);
    *known = mark;
    if (mark.gone)
        fprintf(writer->file, " %x:-", (unsigned)mark.entity);
    else
        fprintf(writer->file, " %x:%08x", (unsigned)mark.entity, (unsigned)mark.print);
    return true;
}

static bool know(recorder *writer, uint32_t entity)
{
    const size_t needed = (size_t)(entity & INDEX_MASK) + 1;
    if (needed <= writer->known_count) return true;
    recording_mark *grown = realloc(writer->known, 2 * needed * sizeof *grown);
    if (!grown) return false;
    memset(grown + writer->known_count, 0, (2 * needed - writer->known_count) * sizeof *grown);
    writer->known = grown, writer->known_count = 2 * needed;
    return true;
}

static void put_entities(recorder *writer, uint64_t ticks, daft_scene *scene)
{
    static const uint32_t most = FINGERPRINT_ENTITIES;
    daft_entity *all = malloc(most * sizeof *all);
    const uint32_t there = all ? daft_scene_entities(scene, all, most) : 0, count = there < most ? there : most;
    int told = 0;
    bool room = true;
    for (size_t i = 0; i < writer->known_count && room; i++) {
        const recording_mark *old = &writer->known[i];
        if (old->entity && !old->gone && !daft_entity_is_valid(scene, (daft_entity){old->entity}))
            room = put_mark(writer, (recording_mark){ticks, old->entity, 0, true}, &told);
    }
    for (uint32_t i = 0; i < count && room; i++)
        room = know(writer, all[i].id) &&
               put_mark(writer, (recording_mark){ticks, all[i].id, fingerprint(scene, all[i]), false}, &told);
    if (told > 0) fputc('\n', writer->file);
    free(all);
}

void recorder_state(recorder *writer, uint64_t ticks, uint64_t hash, daft_scene *scene)
{
    pthread_mutex_lock(&writer->lock);
    recording_state *now = &writer->now;
    if (writer->file) {
        now->tick = ticks, now->hash = hash;
        if (ticks > 0 && ticks <= writer->past_count) writer->past[ticks - 1].hash = (uint16_t)hash;
        if (now->count < RECORDING_SECOND) now->ticks[now->count++] = (uint16_t)hash;
        if (ticks % RECORDING_SECOND == 0) {
            put_state(writer);
            if (scene) put_entities(writer, ticks, scene);
        }
    }
    pthread_mutex_unlock(&writer->lock);
}

/* Entities told of since are to be told anew. */
static void forget_told(recorder *writer, uint64_t ticks)
{
    for (size_t i = 0; i < writer->known_count; i++)
        if (writer->known[i].tick > ticks)
            writer->known[i].print = ~writer->known[i].print, writer->known[i].gone = false;
}

static bool cut_file(recorder *writer, uint64_t ticks)
{
    if (ticks > writer->past_count) return false;
    if (ticks == writer->past_count) return true;
    const long size = writer->past[ticks].begins;
    return fflush(writer->file) == 0 && ftruncate(fileno(writer->file), size) == 0 &&
           fseek(writer->file, size, SEEK_SET) == 0;
}

bool recorder_cut(recorder *writer, uint64_t ticks, uint64_t hash, daft_error *error)
{
    if (!writer) return true;
    pthread_mutex_lock(&writer->lock);
    const bool good = !writer->file || cut_file(writer, ticks);
    if (writer->file && good) {
        writer->past_count = writer->ticks = ticks;
        writer->now = (recording_state){.tick = ticks % RECORDING_SECOND ? ticks : 0, .hash = hash};
        for (uint64_t i = ticks - ticks % RECORDING_SECOND; i < ticks; i++)
            writer->now.ticks[writer->now.count++] = writer->past[i].hash;
        forget_told(writer, ticks);
    }
    pthread_mutex_unlock(&writer->lock);
    return good || fail_at(error, writer->path, 0, 0, "the recording cannot be cut after tick %" PRIu64, ticks);
}

void recorder_script(recorder *writer, const recording_script *script)
{
    if (!writer) return;
    pthread_mutex_lock(&writer->lock);
    if (writer->file) fprintf(writer->file, "script %s %s\n", script->name, script->content);
    pthread_mutex_unlock(&writer->lock);
}

void recorder_saved(recorder *writer, const char *name, const char *text)
{
    if (!writer) return;
    pthread_mutex_lock(&writer->lock);
    if (writer->file) fprintf(writer->file, text ? "saved %s %s\n" : "saved %s\n", name, text);
    pthread_mutex_unlock(&writer->lock);
}

/* Flushes the file and its new name to the disk. */
static bool put_in_place(recorder *writer)
{
    char folder[PATH_SIZE];
    const char *slash = strrchr(writer->path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - writer->path) + 1 : 1, slash ? writer->path : ".");
    if (fflush(writer->file) != 0 || ferror(writer->file) || fsync(fileno(writer->file)) != 0) return false;
    if (rename(writer->part, writer->path) != 0) return false;
    int descriptor = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor >= 0) fsync(descriptor), close(descriptor);
    return true;
}

bool recorder_finish(recorder *writer, daft_error *error)
{
    if (!writer) return true;
    bool good = true;
    pthread_mutex_lock(&writer->lock);
    if (writer->file) {
        if (writer->now.tick > 0) put_state(writer);
        fprintf(writer->file, "end %" PRIu64 "\n", writer->ticks);
        good = put_in_place(writer) || fail_at(error, writer->path, 0, 0, "cannot be written: %s", strerror(errno));
        if (!good) unlink(writer->part);
        fclose(writer->file);
        writer->file = NULL;
    }
    pthread_mutex_unlock(&writer->lock);
    return good;
}

void recorder_free(recorder *writer)
{
    if (!writer) return;
    pthread_mutex_destroy(&writer->lock);
    free(writer->known);
    free(writer->past);
    free(writer);
}
