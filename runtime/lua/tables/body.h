/* lua/tables: the tables of the Lua API, one file each: their functions, and what they do. This header: bodies, as the
 * other tables see them. Public headers: none */
#ifndef RUNTIME_LUA_TABLES_BODY_H
#define RUNTIME_LUA_TABLES_BODY_H

#include "lua/fields.h"

/* Readers of daft.entity's fields. */
api_reader api_read_colliders, api_read_surface, api_read_locks, api_read_layer, api_read_hits;
/* The number of a surface's name, 1 to 63. */
uint32_t api_surface(lua_State *L, host *h, int index, const char *what);
/* {radius, height} or {radius =, height =}: both above 0. Leaves what is not given. */
void api_capsule(lua_State *L, host *h, int index, float *radius, float *height);
/* The bits of a layer's name, or of a list of names. */
uint32_t api_layers(lua_State *L, host *h, int index, const char *what);

#endif
