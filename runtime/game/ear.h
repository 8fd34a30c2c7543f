/* The ear is the camera: how loud, from where and through what each voice of a scene is heard. */
#ifndef RUNTIME_GAME_EAR_H
#define RUNTIME_GAME_EAR_H

#include "sound/sound.h"

/* Sets gain, side and muffle of each voice that has a place, by one ray for each that is not too far. Changes nothing
 * else: what the game does is the same whether anybody listens. */
void ear_listen(mixer *m, daft_scene *scene);

#endif
