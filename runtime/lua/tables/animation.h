/* Playing clips, for daft.entity too. */
#ifndef RUNTIME_LUA_ANIMATION_H
#define RUNTIME_LUA_ANIMATION_H

#include "lua/api.h"

/* How the clip is played whose name or number is at the index. */
daft_play_def api_read_play(lua_State *L, host *h, int index, daft_mesh mesh);

#endif
