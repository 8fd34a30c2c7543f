/* Bodies, as the other areas of the API see them. */
#ifndef RUNTIME_API_BODY_H
#define RUNTIME_API_BODY_H

#include "lua/api.h"

/* The fields of daft.entity's table that make the entity a body. What the definition points to stays on the stack. */
void api_read_body(lua_State *L, host *h, daft_entity_def *def);
/* The number of a surface's name, 1 to 63. */
uint32_t api_surface(lua_State *L, host *h, int index, const char *what);
/* {radius, height} or {radius =, height =}: both above 0. Leaves what is not given. */
void api_capsule(lua_State *L, host *h, int index, float *radius, float *height);
/* The bits of a layer's name, or of a list of names. */
uint32_t api_layers(lua_State *L, host *h, int index, const char *what);

#endif
