/* Text as flat contours, for letters in 3D (daft_mesh_extrude). */
#ifndef RUNTIME_LETTERS_H
#define RUNTIME_LETTERS_H

#include "hud/canvas.h"
#include "hud/truetype.h"

/* Contours of all the letters, which may cross each other. */
typedef struct letters {
    daft_vec2 *points;
    uint32_t *counts; /* points of each contour */
    uint32_t point_count, contour_count;
    size_t point_capacity, contour_capacity;
} letters;

/* Metres: `size` is the height of a capital letter. The base line of the last line is at y = 0; x = 0 is each line's
 * left end, middle or right end. Curves become lines that are no farther off than size/400. */
bool letters_make(letters *out, font *face, const char *text, float size, text_align align, daft_error *error);
void letters_free(letters *l);

/* ---- what text.c tells of a font ---- */

/* The outline of a character, until the next call; NULL: the file is damaged there. */
const truetype_outline *font_outline(font *face, uint32_t code);
/* The advance with kerning, and that of a line that ends at a newline or at the end of the text. Font units. */
int font_advance(const font *face, uint32_t code, uint32_t next);
int font_line_advance(const font *face, const char *line);
/* From ascent to descent, font units. */
int font_height(const font *face);

#endif
