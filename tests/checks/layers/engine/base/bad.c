/* Every line with "expect" must be found, and no other. In a comment: #include "scene/scene.h", printf("x"), exit(1). */
#include "daft.h"
#include "base/base.h"
#include "bad.h"
#include <stdio.h>
#include "math/vec.h" /* expect: base/ is below math/ */
#  include "../scene/scene.h" /* expect: base/ is below scene/ */
#include "../../runtime/loop.h" /* expect: engine/ uses nothing above it */
#include "game/game.h" /* expect: engine/ uses nothing above it */
#include <SDL2/SDL.h> /* expect: engine/ has no SDL and no Lua */
#include <lua5.4/lua.h> /* expect: engine/ has no SDL and no Lua */
#include "lauxlib.h" /* expect: engine/ has no SDL and no Lua */
#include <render/render.h> /* expect: base/ is below render/ */
/*
#include "scene/scene.h"
    exit(1);
*/
const char *words = "printf(stdout) exit(1) \" abort()"; // printf("x")
void good(FILE *file) { fprintf(file, "exit(1)"); snprintf(0, 0, "x"); my_exit(1); exit_loop(); }
__attribute__((format(printf, 1, 2))) void also_good(const char *format, ...);
void bad(void)
{
    printf("x"); /* expect: engine/ reads and prints nothing by itself */
    puts ("x"); /* expect: engine/ reads and prints nothing by itself */
    fprintf(stderr, "x"); /* expect: engine/ reads and prints nothing by itself */
    FILE *out = stdout; /* expect: engine/ reads and prints nothing by itself */
    perror("x"); /* expect: engine/ reads and prints nothing by itself */
    exit(1); /* expect: engine/ returns errors */
    if (bad) abort(); /* expect: engine/ returns errors */
}
