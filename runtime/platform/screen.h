/* How a picture gets into an SDL window: through the graphics card where there is one, which waits for the display's
 * beat and stretches; else straight into the window's pixels, since a renderer that emulates a card costs a processor
 * more than all that a small picture takes to draw. */
#ifndef SCREEN_H
#define SCREEN_H

#include "daft.h"

#include <SDL.h>

typedef struct screen {
    SDL_Window *window;
    SDL_Renderer *renderer; /* NULL: by the window's surface */
    SDL_Texture *texture;   /* the renderer's, of the picture's size */
    SDL_Surface *picture;   /* without a renderer, and only where the window has another size or format */
    int width, height;      /* of texture or picture */
    bool vsync;             /* showing a picture waits for the display */
} screen;

/* False: SDL_GetError says why. */
bool screen_open(screen *out, SDL_Window *window);
void screen_close(screen *self);
/* In pixels, which may be more than the window's units. False: it is not known now. */
bool screen_size(const screen *self, int *width, int *height);
/* Of any size: it fills the window. */
bool screen_show(screen *self, const daft_image *picture, daft_error *error);

/* RGBA bytes as 32-bit words with red, green and blue where the shifts say, the rest 0. */
void screen_pack(const uint8_t *rgba, size_t count, int red, int green, int blue, uint32_t *out);

#endif
