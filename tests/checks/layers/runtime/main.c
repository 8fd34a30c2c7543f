#include "daft.h"
#include "loop.h"
#include "lua/api.h"
#include <SDL.h>
#include <math.h>
#include "base/base.h" /* expect: runtime/ uses nothing of engine/ but daft.h */
#include <scene/scene.h> /* expect: runtime/ uses nothing of engine/ but daft.h */
int main(void) { printf("games may print\n"); exit(0); }
