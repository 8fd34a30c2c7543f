/* graph: how long the last frames took, as bars, with the worst of them and what took its time (F1). Promises: keeping
 * the figures is a few additions a frame and allocates nothing; drawing reads them only. */
#ifndef RUNTIME_HUD_GRAPH_H
#define RUNTIME_HUD_GRAPH_H

#include "hud/canvas.h"

enum { GRAPH_FRAMES = 240, GRAPH_TEXT = 200 };
static const float GRAPH_WIDTH = 504, GRAPH_HEIGHT = 178; /* HUD units */

/* Milliseconds. */
typedef struct graph_frame {
    float total;                      /* from the begin of its turn of the loop to that of the next */
    float update, picture;            /* of it; the rest is waiting and showing the picture */
    float scene;                      /* of the picture: daft_render; what is left are the game's texts and panels */
    float effects[DAFT_EFFECT_COUNT]; /* of the scene */
} graph_frame;

typedef struct frame_graph {
    graph_frame frames[GRAPH_FRAMES]; /* a ring */
    uint32_t count, next;             /* kept; where the next one goes */
    graph_frame now;                  /* the frame at work */
    const char *names[DAFT_EFFECT_COUNT];
} frame_graph;

void graph_add_update(frame_graph *self, double ms);
void graph_add_picture(frame_graph *self, double ms, const daft_counters *counters);
/* The frame at work is over. `total` 0: it says nothing, and is forgotten. */
void graph_end_frame(frame_graph *self, double total);

/* The longest of the frames that are kept; NULL: none are. */
const graph_frame *graph_worst(const frame_graph *self);
/* What took most of its time, the three largest parts: "shadows 12.1, updates 3.0, lighting 2.2 ms". */
const char *graph_describe(const frame_graph *self, const graph_frame *frame, char out[GRAPH_TEXT]);

/* At 0, 0. `target`: milliseconds that a frame may take. */
void graph_draw(const canvas *target, font *face, const frame_graph *self, double target_ms);

#endif
