/* The keys of the window. */
#include "view/keys.h"

#include "common/util.h"
#include "view/picture/draw.h"
#include "view/view.h"

#include <stdio.h>
#include <string.h>

static const view_key KEYS[] = {
    {"W A S D", "fly forward, left, back, right", {NULL}, VIEW_NOTHING, 0},
    {"E, Q", "fly up, down", {NULL}, VIEW_NOTHING, 0},
    {"arrow keys", "look around", {NULL}, VIEW_NOTHING, 0},
    {"Shift, Ctrl", "held: four times as fast, four times as slow", {NULL}, VIEW_NOTHING, 0},
    {"wheel", "change the speed; over a picture: zoom", {NULL}, VIEW_NOTHING, 0},
    {"left drag", "look around; over a picture: move it", {NULL}, VIEW_NOTHING, 0},
    {"right drag", "turn around what lies under the cursor", {NULL}, VIEW_NOTHING, 0},
    {"click", "say what lies under the cursor", {NULL}, VIEW_NOTHING, 0},
    {"gamepad",
     "left stick: fly; right stick: look; triggers: down, up; A V, B O, X P, Y Home",
     {NULL},
     VIEW_NOTHING,
     0},
    {"O", "turn around what lies under the cursor, also by keys; again: fly", {"o", "pad b"}, VIEW_ORBIT, 0},
    {"Home", "show all of it", {"home", "pad y"}, VIEW_FRAME_ALL, 0},
    {"Backspace", "back to the file's camera", {"backspace"}, VIEW_START, 0},
    {"I", "shading on and off", {"i"}, VIEW_TOGGLE, DAFT_WITHOUT_SHADING},
    {"R", "ambient light", {"r"}, VIEW_TOGGLE, DAFT_WITHOUT_AMBIENT},
    {"T", "diffuse light", {"t"}, VIEW_TOGGLE, DAFT_WITHOUT_DIFFUSE},
    {"Y", "highlights", {"y"}, VIEW_TOGGLE, DAFT_WITHOUT_SPECULAR},
    {"K", "shadows", {"k"}, VIEW_TOGGLE, VIEW_WITHOUT_SHADOWS},
    {"L", "mirrors", {"l"}, VIEW_TOGGLE, VIEW_WITHOUT_MIRRORS},
    {"X", "textures", {"x"}, VIEW_TOGGLE, DAFT_WITHOUT_TEXTURES},
    {"G", "edges of triangles", {"g"}, VIEW_WIRES, 0},
    {"1", "the picture", {"1", "keypad 1"}, VIEW_CHANNEL, VIEW_PICTURE},
    {"2", "depth: near is bright", {"2", "keypad 2"}, VIEW_CHANNEL, VIEW_DEPTH},
    {"3", "normals: x, y, z as red, green, blue", {"3", "keypad 3"}, VIEW_CHANNEL, VIEW_NORMAL},
    {"4", "albedo: surfaces in their own colour", {"4", "keypad 4"}, VIEW_CHANNEL, VIEW_ALBEDO},
    {"5", "entities, each in a colour", {"5", "keypad 5"}, VIEW_CHANNEL, VIEW_ENTITY},
    {"6", "triangles, each in a colour", {"6", "keypad 6"}, VIEW_CHANNEL, VIEW_TRIANGLE},
    {"7", "motion since the last picture: right is red, down is green", {"7", "keypad 7"}, VIEW_CHANNEL, VIEW_MOTION},
    {"8", "rays that each pixel costs: blue 1, red 4, yellow 16, white 64", {"8", "keypad 8"}, VIEW_CHANNEL, VIEW_COST},
    {"V", "add a checkpoint of the camera path where you are", {"v", "pad a"}, VIEW_CHECKPOINT, 0},
    {"M", "move the checkpoint nearest to the cursor here", {"m"}, VIEW_MOVE, 0},
    {"Delete", "remove that checkpoint", {"delete"}, VIEW_REMOVE, 0},
    {"comma", "reach it half a second sooner", {","}, VIEW_SOONER, 0},
    {"point", "reach it half a second later", {"."}, VIEW_LATER, 0},
    {"C", "save the camera path into the scene file", {"c"}, VIEW_SAVE, 0},
    {"B", "film along the camera path, while you go on flying", {"b"}, VIEW_FILM, 0},
    {"Z", "films: at the checkpoints' times, at a constant speed, slow at both ends", {"z"}, VIEW_PACE, 0},
    {"P", "take a snapshot at the best quality, while you go on flying", {"p", "pad x"}, VIEW_SNAPSHOT, 0},
    {"U", "the size of snapshots and films", {"u"}, VIEW_SIZE, 0},
    {"F5", "load the file again", {"f5"}, VIEW_RELOAD, 0},
    {"F1", "what the picture costs", {"f1"}, VIEW_PLAN, 0},
    {"H or ?", "these keys", {"h", "/", "pad start"}, VIEW_KEYS, 0},
    {"F11", "full screen", {NULL}, VIEW_NOTHING, 0},
    {"Esc", "cancel the snapshot or film; else leave", {"escape", "pad back"}, VIEW_LEAVE, 0},
};

const view_key *view_keys(size_t *count)
{
    *count = COUNT_OF(KEYS);
    return KEYS;
}

const view_key *view_key_find(const char *name)
{
    for (size_t i = 0; i < COUNT_OF(KEYS); i++)
        for (size_t k = 0; k < COUNT_OF(KEYS[i].keys); k++)
            if (KEYS[i].keys[k] && strcmp(name, KEYS[i].keys[k]) == 0) return &KEYS[i];
    return NULL;
}

const char *view_keys_text(char *out, size_t size)
{
    size_t used = (size_t)snprintf(out, size,
                                   "Keys (a file that is dropped on the window is opened; one that is saved is "
                                   "loaded again):");
    for (size_t i = 0; i < COUNT_OF(KEYS) && used < size; i++)
        used += (size_t)snprintf(out + used, size - used, "\n  %-12s %s", KEYS[i].shown, KEYS[i].does);
    return out;
}
