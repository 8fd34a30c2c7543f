/* xray: what the simulation sees, drawn over the picture: the edges of bodies, awake (green), asleep (blue), standing
 * (grey), moved by the game (orange), sensors (violet), and contacts with their normals (red). Nothing hides them. */
#ifndef RUNTIME_GAME_XRAY_H
#define RUNTIME_GAME_XRAY_H

#include "hud/canvas.h"

/* Within XRAY_METRES of the camera; at most XRAY_EDGES of them. */
enum { XRAY_METRES = 60, XRAY_EDGES = 20000, XRAY_CONTACTS = 4000 };

/* Returns how many lines there are to draw; nothing is drawn where memory is out. */
uint32_t xray_draw(const canvas *target, daft_scene *scene, const daft_camera *camera);
/* One entity's outline: a ball's edge, else the edges of its box. Draws nothing for one that is gone. */
void xray_outline(const canvas *target, daft_scene *scene, const daft_camera *camera, daft_entity entity);

#endif
