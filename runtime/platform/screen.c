/* Pictures in a window: see screen.h. */
#include "platform/screen.h"

#include "common/util.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* ---- which way ---- */

/* On Linux a card shows itself by its device; elsewhere there is always one to speak of. Asking first saves loading an
 * emulated OpenGL, which takes longer than the rest of the start. */
static bool may_have_card(void)
{
#ifdef __linux__
    static const char *const devices[] = {"/dev/dri", "/dev/nvidiactl", "/dev/dxg", "/dev/kgsl-3d0", "/dev/mali0"};
    for (size_t i = 0; i < COUNT_OF(devices); i++)
        if (access(devices[i], F_OK) == 0) return true;
    return false;
#else
    return true;
#endif
}

/* Whether the renderer is a program that plays a card: Mesa's llvmpipe, softpipe and swrast, SwiftShader, Apple's. */
static bool is_emulated(SDL_Renderer *renderer)
{
    SDL_RendererInfo info;
    if (SDL_GetRendererInfo(renderer, &info) != 0 || (info.flags & SDL_RENDERER_SOFTWARE)) return true;
    if (!info.name || strncmp(info.name, "opengl", 6) != 0) return false;
    enum { RENDERER = 0x1f01 }; /* GL_RENDERER */
    const char *(*get)(unsigned) = NULL;
    void *found = SDL_GL_GetProcAddress("glGetString");
    memcpy(&get, &found, sizeof get);
    const char *name = get ? get(RENDERER) : NULL;
    static const char *const programs[] = {"llvmpipe", "softpipe", "swrast", "SwiftShader", "Software"};
    for (size_t i = 0; name && i < COUNT_OF(programs); i++)
        if (strstr(name, programs[i])) return true;
    return false;
}

bool screen_open(screen *out, SDL_Window *window)
{
    *out = (screen){.window = window};
    SDL_SetHint(SDL_HINT_RENDER_SCALE_QUALITY, "1");
    SDL_SetHint(SDL_HINT_FRAMEBUFFER_ACCELERATION, "0"); /* the surface is pixels, not another renderer */
    if (may_have_card()) out->renderer = SDL_CreateRenderer(window, -1, SDL_RENDERER_PRESENTVSYNC);
    if (out->renderer && is_emulated(out->renderer)) {
        SDL_DestroyRenderer(out->renderer);
        out->renderer = NULL;
    }
    SDL_RendererInfo info;
    out->vsync = out->renderer && SDL_GetRendererInfo(out->renderer, &info) == 0 &&
                 (info.flags & SDL_RENDERER_PRESENTVSYNC) != 0;
    return out->renderer || SDL_GetWindowSurface(window);
}

void screen_close(screen *self)
{
    if (self->texture) SDL_DestroyTexture(self->texture);
    if (self->renderer) SDL_DestroyRenderer(self->renderer);
    SDL_FreeSurface(self->picture);
}

bool screen_size(const screen *self, int *width, int *height)
{
    if (self->renderer) return SDL_GetRendererOutputSize(self->renderer, width, height) == 0;
    const SDL_Surface *window = SDL_GetWindowSurface(self->window);
    if (window) *width = window->w, *height = window->h;
    return window != NULL;
}

/* ---- with a card ---- */

static bool show_texture(screen *self, const daft_image *picture, daft_error *error)
{
    const int width = daft_image_width(picture), height = daft_image_height(picture);
    if (!self->texture || width != self->width || height != self->height) {
        if (self->texture) SDL_DestroyTexture(self->texture);
        self->texture =
            SDL_CreateTexture(self->renderer, SDL_PIXELFORMAT_RGBA32, SDL_TEXTUREACCESS_STREAMING, width, height);
        if (!self->texture) return fail(error, DAFT_ERROR_UNSUPPORTED, "no texture for the window: %s", SDL_GetError());
        SDL_SetTextureBlendMode(self->texture, SDL_BLENDMODE_NONE);
        self->width = width, self->height = height;
    }
    SDL_UpdateTexture(self->texture, NULL, daft_image_pixels((daft_image *)(uintptr_t)picture), 4 * width);
    SDL_RenderCopy(self->renderer, self->texture, NULL, NULL);
    SDL_RenderPresent(self->renderer);
    return true;
}

/* ---- without ---- */

void screen_pack(const uint8_t *rgba, size_t count, int red, int green, int blue, uint32_t *out)
{
    for (size_t i = 0; i < count; i++) {
        uint32_t word; /* the compiler makes lanes of words, not of bytes */
        memcpy(&word, rgba + 4 * i, 4);
        word = SDL_SwapLE32(word);
        out[i] = (word & 255) << red | (word >> 8 & 255) << green | (word >> 16 & 255) << blue;
    }
}

static bool has_whole_bytes(const SDL_PixelFormat *format)
{
    return format->BytesPerPixel == 4 && format->Rloss == 0 && format->Gloss == 0 && format->Bloss == 0;
}

/* The picture into a surface of its size that has_whole_bytes. */
static void pack_rows(const daft_image *picture, SDL_Surface *to)
{
    const int width = daft_image_width(picture), height = daft_image_height(picture);
    const SDL_PixelFormat *format = to->format;
    const uint8_t *rgba = daft_image_pixels((daft_image *)(uintptr_t)picture);
    for (int y = 0; y < height; y++)
        screen_pack(rgba + (size_t)y * (size_t)width * 4, (size_t)width, format->Rshift, format->Gshift, format->Bshift,
                    (uint32_t *)(void *)((char *)to->pixels + (ptrdiff_t)y * to->pitch));
}

static bool fit_picture(screen *self, int width, int height, daft_error *error)
{
    if (self->picture && self->width == width && self->height == height) return true;
    SDL_FreeSurface(self->picture);
    self->picture = SDL_CreateRGBSurfaceWithFormat(0, width, height, 32, SDL_PIXELFORMAT_RGB888);
    self->width = width, self->height = height;
    return self->picture || fail(error, DAFT_ERROR_MEMORY, "no memory for the window's picture: %s", SDL_GetError());
}

/* By a picture of the window's format where that has whole bytes, which stretches smoothly; else as SDL converts. */
static bool show_other(screen *self, const daft_image *picture, SDL_Surface *window, daft_error *error)
{
    if (!fit_picture(self, daft_image_width(picture), daft_image_height(picture), error)) return false;
    pack_rows(picture, self->picture);
    const bool same = window->format->format == self->picture->format->format;
    if (!same || SDL_SoftStretchLinear(self->picture, NULL, window, NULL) != 0)
        SDL_BlitScaled(self->picture, NULL, window, NULL);
    return true;
}

static bool show_surface(screen *self, const daft_image *picture, daft_error *error)
{
    SDL_Surface *window = SDL_GetWindowSurface(self->window); /* another one after the window's size has changed */
    if (!window) return fail(error, DAFT_ERROR_UNSUPPORTED, "no pixels for the window: %s", SDL_GetError());
    if (SDL_MUSTLOCK(window)) SDL_LockSurface(window);
    const bool fits = daft_image_width(picture) == window->w && daft_image_height(picture) == window->h;
    bool good = true;
    if (fits && has_whole_bytes(window->format))
        pack_rows(picture, window);
    else
        good = show_other(self, picture, window, error);
    if (SDL_MUSTLOCK(window)) SDL_UnlockSurface(window);
    if (good) SDL_UpdateWindowSurface(self->window);
    return good;
}

bool screen_show(screen *self, const daft_image *picture, daft_error *error)
{
    return self->renderer ? show_texture(self, picture, error) : show_surface(self, picture, error);
}
