/* scene/animation: entities that play clips. play.c has the tracks, which are the game's state; posed.c the poses,
 * which are picture; sight.c which of them a picture can do without. Public headers: none; scene/scene.h has the
 * functions. */
#ifndef DAFT_SCENE_ANIMATION_H
#define DAFT_SCENE_ANIMATION_H

#include "scene/scene.h"

/* The layers of the pose at `alpha` between the last two ticks. Returns how many. */
uint32_t daft_tracks_layers(const daft_scene *scene, const daft_animated *animated, const daft_rig *rig, float alpha,
                            daft_rig_layer out[DAFT_RIG_LAYERS]);
static inline const daft_mesh_item *daft_animated_mesh(const daft_scene *scene, const daft_animated *animated)
{
    const daft_entity_def *def = &scene->entities[animated->entity].def;
    return scene->assets.meshes[daft_asset_index(def->mesh.id)];
}

#endif
