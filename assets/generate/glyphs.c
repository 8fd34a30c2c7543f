/* The letters of our own font, "DAFT": a geometric sans of one stroke width. Skeletons are in the language of stroke.c;
 * capitals are 610 high, small letters 420, ascenders 650, descenders -200 (pen's centres, 1000 to the em).
 * Round letters overshoot by 8, as the eye wants it. */
#include "generate.h"

/* Side bearings by how an edge looks: straight stems need the most air, slanted and open edges the least. */
#define STEM  68
#define ROUND 46
#define SLANT 20
#define OPEN  34

#define BOWL_e "M 20 222 L 407 222 E 204 210 204 218 3 318"
#define BOWL_a "O 203 210 203 218 ; M 414 424 L 414 0"
#define BOWL_o "O 210 210 210 218"
#define BOWL_u "M 0 420 L 0 190 E 190 190 190 198 180 360 ; M 380 420 L 380 0"
#define BIG_A  "M 0 0 L 260 610 L 520 0 ; M 85 190 L 435 190"
#define BIG_O  "O 315 305 315 313"
#define BIG_U  "M 0 610 L 0 235 E 235 235 235 243 180 360 L 470 610"
#define BIG_S  "E 190 456 185 162 30 270 E 190 143 200 151 90 -150"

const glyph font_glyphs[] = {
    {' ', 130, 130, ""},
    {'!', 70, 70, "M 56 610 L 56 200 ; D 56 10 56"},
    {'"', 60, 60, "M 0 610 L 0 450 ; M 150 610 L 150 450"},
    {'#', OPEN, OPEN, "M 110 0 L 170 610 ; M 310 0 L 370 610 ; M 0 200 L 460 200 ; M 20 410 L 480 410"},
    {'$', ROUND, ROUND, BIG_S " ; M 195 710 L 195 -100"},
    {'%', ROUND, ROUND, "O 115 490 115 125 ; O 465 120 115 125 ; M 470 610 L 110 0"},
    {'&', ROUND, OPEN, "M 470 0 L 104 408 E 210 490 138 128 220 -40 L 95 287 E 190 150 190 158 120 320 L 455 270"},
    {'\'', 60, 60, "M 0 610 L 0 450"},
    {'(', 60, OPEN, "E 400 255 400 560 140 220"},
    {')', OPEN, 60, "E -306 255 400 560 40 -40"},
    {'*', OPEN, OPEN, "M 145 620 L 145 320 ; M 15 545 L 275 395 ; M 15 395 L 275 545"},
    {'+', OPEN, OPEN, "M 0 270 L 380 270 ; M 190 80 L 190 460"},
    {',', 50, 60, "M 40 30 L 0 -110"},
    {'-', OPEN, OPEN, "M 0 240 L 210 240"},
    {'.', 60, 60, "D 56 10 56"},
    {'/', SLANT, SLANT, "M 0 -60 L 270 670"},
    {'0', 0, 0, "O 200 305 200 313"},
    {'1', 0, 0, "M 0 475 L 150 610 L 150 0"},
    {'2', 0, 0, "E 195 430 185 188 160 -42 L 0 0 L 400 0"},
    {'3', 0, 0, "E 185 459 168 161 150 -90 L 130 298 ; M 130 298 L 185 298 E 185 145 195 153 90 -150"},
    {'4', 0, 0, "M 310 0 L 310 610 L 0 165 L 410 165"},
    {'5', 0, 0, "M 355 610 L 65 610 L 37 325 E 190 195 200 203 140 -150"},
    {'6', 0, 0, "O 200 190 200 198 ; M 235 615 L 33 297"},
    {'7', 0, 0, "M 0 610 L 390 610 L 130 0"},
    {'8', 0, 0, "O 195 462 163 156 ; O 195 150 198 158"},
    {'9', 0, 0, "O 200 420 200 198 ; M 165 -5 L 367 313"},
    {':', 60, 60, "D 56 10 56 ; D 56 370 56"},
    {';', 50, 60, "D 56 370 56 ; M 50 30 L 10 -110"},
    {'<', OPEN, OPEN, "M 360 470 L 0 270 L 360 70"},
    {'=', OPEN, OPEN, "M 0 180 L 380 180 ; M 0 370 L 380 370"},
    {'>', OPEN, OPEN, "M 0 470 L 360 270 L 0 70"},
    {'?', OPEN, OPEN, "E 170 448 170 170 165 -50 L 180 265 L 170 200 ; D 170 10 56"},
    {'@', ROUND, ROUND, "O 315 215 125 145 ; M 440 360 L 440 190 E 535 190 95 92 180 360 E 320 215 310 325 -4 305"},
    {'A', SLANT, SLANT, BIG_A},
    {'B', STEM, ROUND, "M 20 308 L 205 308 E 205 459 151 151 -90 90 L 0 610 L 0 0 L 225 0 E 225 154 168 154 -90 90"},
    {'C', ROUND, OPEN, "E 310 305 310 313 42 318"},
    {'D', STEM, ROUND, "M 0 0 L 0 610 L 180 610 E 180 305 290 305 90 -90 Z"},
    {'E', STEM, OPEN, "M 360 610 L 0 610 L 0 0 L 360 0 ; M 20 310 L 320 310"},
    {'F', STEM, OPEN, "M 350 610 L 0 610 L 0 0 ; M 20 300 L 305 300"},
    {'G', ROUND, ROUND, "E 310 305 310 313 42 360 L 350 305"},
    {'H', STEM, STEM, "M 0 0 L 0 610 ; M 470 0 L 470 610 ; M 20 310 L 450 310"},
    {'I', STEM, STEM, "M 0 0 L 0 610"},
    {'J', OPEN, STEM, "M 300 610 L 300 165 E 140 165 160 173 0 -150"},
    {'K', STEM, SLANT, "M 0 0 L 0 610 ; M 395 610 L 20 230 ; M 145 357 L 415 0"},
    {'L', STEM, OPEN, "M 0 610 L 0 0 L 330 0"},
    {'M', STEM, STEM, "M 0 0 L 0 610 L 290 130 L 580 610 L 580 0"},
    {'N', STEM, STEM, "M 0 0 L 0 610 L 470 0 L 470 610"},
    {'O', ROUND, ROUND, BIG_O},
    {'P', STEM, ROUND, "M 0 0 L 0 610 L 215 610 E 215 440 172 170 90 -90 L 20 270"},
    {'Q', ROUND, ROUND, BIG_O " ; M 410 165 L 595 -20"},
    {'R', STEM, OPEN, "M 0 0 L 0 610 L 215 610 E 215 445 168 165 90 -90 L 20 280 ; M 205 280 L 395 0"},
    {'S', ROUND, ROUND, BIG_S},
    {'T', OPEN, OPEN, "M 0 610 L 460 610 ; M 230 590 L 230 0"},
    {'U', STEM, STEM, BIG_U},
    {'V', SLANT, SLANT, "M 0 610 L 255 0 L 510 610"},
    {'W', SLANT, SLANT, "M 0 610 L 190 0 L 375 520 L 560 0 L 750 610"},
    {'X', SLANT, SLANT, "M 0 0 L 440 610 ; M 0 610 L 440 0"},
    {'Y', SLANT, SLANT, "M 0 610 L 240 290 L 480 610 ; M 240 280 L 240 0"},
    {'Z', OPEN, OPEN, "M 0 610 L 430 610 L 0 0 L 430 0"},
    {'[', 60, OPEN, "M 130 680 L 0 680 L 0 -110 L 130 -110"},
    {'\\', SLANT, SLANT, "M 0 670 L 270 -60"},
    {']', OPEN, 60, "M 0 680 L 130 680 L 130 -110 L 0 -110"},
    {'^', OPEN, OPEN, "M 0 390 L 150 610 L 300 390"},
    {'_', 0, 0, "M 0 -110 L 420 -110"},
    {'`', OPEN, OPEN, "M 0 630 L 100 530"},
    {'a', ROUND, STEM, BOWL_a},
    {'b', STEM, ROUND, "M 0 650 L 0 0 ; O 211 210 203 218"},
    {'c', ROUND, OPEN, "E 205 210 205 218 45 315"},
    {'d', ROUND, STEM, "O 203 210 203 218 ; M 414 650 L 414 0"},
    {'e', ROUND, ROUND, BOWL_e},
    {'f', OPEN, SLANT, "E 210 525 120 133 65 180 L 90 0 ; M 0 420 L 220 420"},
    {'g', ROUND, STEM, "O 203 210 203 218 ; M 414 424 L 414 -20 E 212 -20 202 186 0 -150"},
    {'h', STEM, STEM, "M 0 650 L 0 0 ; E 190 233 190 195 175 0 L 380 0"},
    {'i', STEM, STEM, "M 0 420 L 0 0 ; D 0 595 58"},
    {'j', SLANT, STEM, "M 110 420 L 110 -80 E 0 -80 110 126 0 -80 ; D 110 595 58"},
    {'k', STEM, SLANT, "M 0 650 L 0 0 ; M 320 420 L 15 135 ; M 125 238 L 340 0"},
    {'l', STEM, OPEN, "M 0 650 L 0 105 E 100 105 100 110 180 285"},
    {'m', STEM, STEM, "M 0 420 L 0 0 ; E 160 250 160 178 175 0 L 320 0 ; E 480 250 160 178 175 0 L 640 0"},
    {'n', STEM, STEM, "M 0 420 L 0 0 ; E 190 233 190 195 175 0 L 380 0"},
    {'o', ROUND, ROUND, BOWL_o},
    {'p', STEM, ROUND, "M 0 424 L 0 -200 ; O 211 210 203 218"},
    {'q', ROUND, STEM, "O 203 210 203 218 ; M 414 424 L 414 -200"},
    {'r', STEM, SLANT, "M 0 420 L 0 0 ; E 180 233 180 195 175 65"},
    {'s', ROUND, ROUND, "E 150 315 143 113 32 270 E 150 97 155 105 90 -150"},
    {'t', OPEN, OPEN, "M 100 570 L 100 120 E 215 120 115 126 180 285 ; M 0 420 L 235 420"},
    {'u', STEM, STEM, BOWL_u},
    {'v', SLANT, SLANT, "M 0 420 L 190 0 L 380 420"},
    {'w', SLANT, SLANT, "M 0 420 L 150 0 L 300 350 L 450 0 L 600 420"},
    {'x', SLANT, SLANT, "M 0 0 L 350 420 ; M 0 420 L 350 0"},
    {'y', SLANT, SLANT, "M 0 420 L 195 0 ; M 390 420 L 102 -200"},
    {'z', OPEN, OPEN, "M 0 420 L 335 420 L 0 0 L 335 0"},
    {'{', OPEN, OPEN, "E 170 590 90 90 90 180 L 80 365 L 0 285 L 80 205 L 80 -20 E 170 -20 90 90 180 270"},
    {'|', 80, 80, "M 0 720 L 0 -140"},
    {'}', OPEN, OPEN, "E 0 590 90 90 90 0 L 90 365 L 170 285 L 90 205 L 90 -20 E 0 -20 90 90 0 -90"},
    {'~', OPEN, OPEN, "E 100 230 100 90 180 45 E 320 288 100 90 225 360"},
    {0xb0, OPEN, OPEN, "O 100 515 100 100"},                                                    /* degree */
    {0xb7, OPEN, OPEN, "D 56 240 56"},                                                          /* middle dot */
    {0xc4, SLANT, SLANT, BIG_A " ; D 160 770 56 ; D 360 770 56"},                               /* Ä */
    {0xd6, ROUND, ROUND, BIG_O " ; D 210 770 56 ; D 420 770 56"},                               /* Ö */
    {0xd7, OPEN, OPEN, "M 0 100 L 330 430 ; M 0 430 L 330 100"},                                /* × */
    {0xdc, STEM, STEM, BIG_U " ; D 130 770 56 ; D 340 770 56"},                                 /* Ü */
    {0xdf, STEM, ROUND, "M 0 0 L 0 480 E 155 480 155 178 180 -65 ; E 200 158 190 166 80 -115"}, /* ß */
    {0xe4, ROUND, STEM, BOWL_a " ; D 110 595 54 ; D 300 595 54"},                               /* ä */
    {0xe8, ROUND, ROUND, BOWL_e " ; M 150 650 L 240 560"},                                      /* è */
    {0xe9, ROUND, ROUND, BOWL_e " ; M 260 650 L 170 560"},                                      /* é */
    {0xf6, ROUND, ROUND, BOWL_o " ; D 115 595 54 ; D 305 595 54"},                              /* ö */
    {0xfc, STEM, STEM, BOWL_u " ; D 95 595 54 ; D 285 595 54"},                                 /* ü */
    {0x2013, OPEN, OPEN, "M 0 240 L 400 240"},                                                  /* en dash */
    {0x2014, OPEN, OPEN, "M 0 240 L 800 240"},                                                  /* em dash */
    {0x2018, OPEN, OPEN, "M 0 480 L 45 620"},                                                   /* single quotes */
    {0x2019, OPEN, OPEN, "M 45 620 L 0 480"},
    {0x201c, OPEN, OPEN, "M 0 480 L 45 620 ; M 130 480 L 175 620"}, /* double quotes */
    {0x201d, OPEN, OPEN, "M 45 620 L 0 480 ; M 175 620 L 130 480"},
    {0x2022, OPEN, OPEN, "D 110 270 110"},                                                    /* bullet */
    {0x2026, 60, 60, "D 56 10 56 ; D 266 10 56 ; D 476 10 56"},                               /* ellipsis */
    {0x20ac, OPEN, OPEN, "E 360 305 290 313 45 315 ; M 0 365 L 390 365 ; M 0 245 L 370 245"}, /* € */
    {0x2190, OPEN, OPEN, "M 560 270 L 0 270 ; M 200 460 L 0 270 L 200 80"},                   /* ← */
    {0x2191, OPEN, OPEN, "M 190 0 L 190 560 ; M 0 360 L 190 560 L 380 360"},                  /* ↑ */
    {0x2192, OPEN, OPEN, "M 0 270 L 560 270 ; M 360 460 L 560 270 L 360 80"},                 /* → */
    {0x2193, OPEN, OPEN, "M 190 560 L 190 0 ; M 0 200 L 190 0 L 380 200"},                    /* ↓ */
    {0x25c6, OPEN, OPEN, "M 230 590 L 0 290 L 230 -10 L 460 290 F"},                          /* ◆ */
    {0x25cf, OPEN, OPEN, "D 270 290 290"},                                                    /* ● */
    {0x2605, OPEN, OPEN,
     "M 285 600 L 356 397 L 570 393 L 399 263 L 461 57 L 285 180 L 109 57 L 171 263 L 0 393 "
     "L 214 397 F"},                                                                       /* ★ */
    {0x2665, OPEN, OPEN, "E 135 430 135 140 15 207 L 270 20 E 405 430 135 140 -27 165 F"}, /* ♥ */
    {0x2713, OPEN, OPEN, "M 0 270 L 170 80 L 480 520"},                                    /* ✓ */
};
const int font_glyph_count = (int)(sizeof font_glyphs / sizeof font_glyphs[0]);
