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
    {0xa1, 70, 70, "M 0 220 L 0 -190 ; D 0 430 56"}, /* ¡ */
    {0xa3, OPEN, OPEN,
     "M 380 0 L 0 0 L 60 0 E 40 160 80 160 -80 60 L 60 430 E 210 450 150 165 180 30 ; M 0 290 L 290 290"}, /* £ */
    {0xab, OPEN, OPEN, "M 160 400 L 0 230 L 160 60 ; M 340 400 L 180 230 L 340 60"},                       /* « */
    {0xb0, OPEN, OPEN, "O 100 515 100 100"},                                                               /* degree */
    {0xb7, OPEN, OPEN, "D 56 240 56"},                                                  /* middle dot */
    {0xbb, OPEN, OPEN, "M 0 400 L 160 230 L 0 60 ; M 180 400 L 340 230 L 180 60"},      /* » */
    {0xbf, OPEN, OPEN, "M 175 230 L 165 165 E 170 -18 170 170 120 345 ; D 175 420 56"}, /* ¿ */
    {0xc4, SLANT, SLANT, BIG_A " ; D 160 770 56 ; D 360 770 56"},                       /* Ä */
    {0xc6, SLANT, OPEN,
     "M 0 0 L 330 610 L 690 610 ; M 350 610 L 350 0 L 690 0 ; M 110 190 L 340 190 ; M 360 310 L 640 310"}, /* Æ */
    {0xd0, SLANT, ROUND, "M 90 0 L 90 610 L 270 610 E 270 305 290 305 90 -90 Z ; M 0 310 L 260 310"},      /* Ð */
    {0xd6, ROUND, ROUND, BIG_O " ; D 210 770 56 ; D 420 770 56"},                                          /* Ö */
    {0xd7, OPEN, OPEN, "M 0 100 L 330 430 ; M 0 430 L 330 100"},                                           /* × */
    {0xd8, ROUND, ROUND, "O 315 305 315 313 ; M 60 -30 L 570 640"},                                        /* Ø */
    {0xdc, STEM, STEM, BIG_U " ; D 130 770 56 ; D 340 770 56"},                                            /* Ü */
    {0xde, STEM, ROUND, "M 0 0 L 0 610 ; M 20 490 L 200 490 E 200 325 172 165 90 -90 L 20 160"},           /* Þ */
    {0xdf, STEM, ROUND, "M 0 0 L 0 480 E 155 480 155 178 180 -65 ; E 200 158 190 166 80 -115"},            /* ß */
    {0xe4, ROUND, STEM, BOWL_a " ; D 110 595 54 ; D 300 595 54"},                                          /* ä */
    {0xe6, ROUND, ROUND, "O 175 210 175 218 ; M 360 222 L 645 222 E 505 210 145 218 3 318 ; M 350 424 L 350 0"}, /* æ */
    {0xe8, ROUND, ROUND, BOWL_e " ; M 150 650 L 240 560"},                                          /* è */
    {0xe9, ROUND, ROUND, BOWL_e " ; M 260 650 L 170 560"},                                          /* é */
    {0xf0, ROUND, ROUND, "O 203 200 203 208 ; M 404 230 L 350 430 L 150 650 ; M 60 480 L 330 600"}, /* ð */
    {0xf6, ROUND, ROUND, BOWL_o " ; D 115 595 54 ; D 305 595 54"},                                  /* ö */
    {0xf8, ROUND, ROUND, "O 210 210 210 218 ; M 30 -20 L 390 440"},                                 /* ø */
    {0xfc, STEM, STEM, BOWL_u " ; D 95 595 54 ; D 285 595 54"},                                     /* ü */
    {0xfe, STEM, ROUND, "M 0 650 L 0 -200 ; O 211 210 203 218"},                                    /* þ */
    {0x111, ROUND, OPEN, "O 203 210 203 218 ; M 414 650 L 414 0 ; M 260 540 L 510 540"},            /* đ */
    {0x131, STEM, STEM, "M 0 420 L 0 0"},                                                           /* ı */
    {0x141, SLANT, OPEN, "M 90 610 L 90 0 L 420 0 ; M 0 240 L 260 390"},                            /* Ł */
    {0x142, SLANT, OPEN, "M 90 650 L 90 105 E 190 105 100 110 180 285 ; M 0 270 L 200 400"},        /* ł */
    {0x152, ROUND, OPEN,
     "E 305 305 305 305 90 270 L 690 0 ; M 305 610 L 690 610 ; M 350 610 L 350 0 ; M 360 310 L 640 310"}, /* Œ */
    {0x153, ROUND, ROUND, "O 195 210 195 218 ; M 405 222 L 700 222 E 550 210 155 218 3 318"},             /* œ */
    {0x393, STEM, OPEN, "M 350 610 L 0 610 L 0 0"},                                                       /* Γ */
    {0x394, SLANT, SLANT, "M 0 0 L 260 610 L 520 0 Z"},                                                   /* Δ */
    {0x398, ROUND, ROUND, "O 315 305 315 313 ; M 190 305 L 440 305"},                                     /* Θ */
    {0x39b, SLANT, SLANT, "M 0 0 L 255 610 L 510 0"},                                                     /* Λ */
    {0x39e, OPEN, OPEN, "M 0 610 L 400 610 ; M 50 310 L 350 310 ; M 0 0 L 400 0"},                        /* Ξ */
    {0x3a0, STEM, STEM, "M 0 0 L 0 610 L 470 610 L 470 0"},                                               /* Π */
    {0x3a3, OPEN, OPEN, "M 400 610 L 0 610 L 230 310 L 0 0 L 410 0"},                                     /* Σ */
    {0x3a6, ROUND, ROUND, "O 290 305 290 195 ; M 290 650 L 290 -40"},                                     /* Φ */
    {0x3a8, STEM, STEM, "M 0 610 L 0 400 E 240 400 240 220 180 360 L 480 610 ; M 240 610 L 240 0"},       /* Ψ */
    {0x3a9, OPEN, OPEN, "M 0 0 L 145 0 E 290 330 290 285 240 -60 L 435 0 L 580 0"},                       /* Ω */
    {0x3b1, ROUND, OPEN, "O 203 210 203 218 ; M 414 424 L 414 90 E 484 90 70 90 180 280"},                /* α */
    {0x3b2, STEM, ROUND, "M 0 -200 L 0 480 E 155 480 155 178 180 -65 ; E 200 158 190 166 80 -180"},       /* β */
    {0x3b3, SLANT, SLANT, "M 0 420 L 190 0 L 190 -200 ; M 380 420 L 190 0"},                              /* γ */
    {0x3b4, ROUND, ROUND, "O 200 200 200 208 ; E 210 545 110 95 20 200 L 345 350"},                       /* δ */
    {0x3b5, ROUND, OPEN, "E 180 315 165 103 40 270 ; E 180 104 180 112 90 320"},                          /* ε */
    {0x3b6, OPEN, OPEN, "M 20 650 L 300 650 E 300 200 300 210 130 270 L 330 -10 E 330 -80 60 70 90 -60"}, /* ζ */
    {0x3b7, STEM, STEM, "M 0 420 L 0 0 ; E 190 233 190 195 175 0 L 380 -200"},                            /* η */
    {0x3b8, ROUND, ROUND, "O 190 305 190 330 ; M 15 305 L 365 305"},                                      /* θ */
    {0x3b9, STEM, OPEN, "M 0 420 L 0 100 E 90 100 90 110 180 285"},                                       /* ι */
    {0x3ba, STEM, SLANT, "M 0 420 L 0 0 ; M 300 420 L 15 150 ; M 115 240 L 320 0"},                       /* κ */
    {0x3bb, SLANT, SLANT, "M 30 650 L 110 650 L 370 0 ; M 205 415 L 0 0"},                                /* λ */
    {0x3bc, STEM, STEM, "M 0 -200 L 0 420 ; E 190 190 190 198 180 360 L 380 420 ; M 380 200 L 380 0"},    /* μ */
    {0x3be, OPEN, OPEN,
     "M 20 650 L 310 650 ; E 210 520 160 130 100 270 ; E 220 190 220 200 90 270 L 260 -10 E 260 -80 60 70 90 "
     "-60"},                                                                                             /* ξ */
    {0x3c0, OPEN, OPEN, "M 0 420 L 440 420 ; M 90 410 L 90 0 ; M 340 410 L 340 0"},                      /* π */
    {0x3c2, ROUND, OPEN, "E 205 210 205 218 45 270 L 240 -8 E 240 -80 60 72 90 -60"},                    /* ς */
    {0x3c3, ROUND, OPEN, "O 200 200 200 208 ; M 200 408 L 440 408"},                                     /* σ */
    {0x3c4, OPEN, OPEN, "M 0 420 L 340 420 ; M 170 410 L 170 100 E 250 100 80 108 180 285"},             /* τ */
    {0x3c5, STEM, STEM, "M 0 420 L 0 190 E 190 190 190 198 180 360 L 380 420"},                          /* υ */
    {0x3c6, ROUND, ROUND, "O 250 210 250 218 ; M 250 600 L 250 -200"},                                   /* φ */
    {0x3c7, SLANT, SLANT, "M 0 420 L 340 -200 ; M 0 -200 L 340 420"},                                    /* χ */
    {0x3c8, STEM, STEM, "M 0 420 L 0 200 E 230 200 230 208 180 360 L 460 420 ; M 230 600 L 230 -200"},   /* ψ */
    {0x3c9, ROUND, ROUND, "E 140 200 140 208 120 360 ; E 420 200 140 208 180 420"},                      /* ω */
    {0x404, ROUND, OPEN, "E 310 305 310 313 42 318 ; M 20 305 L 350 305"},                               /* Є */
    {0x411, STEM, ROUND, "M 360 610 L 0 610 L 0 0 L 225 0 E 225 172 172 172 -90 90 L 20 344"},           /* Б */
    {0x414, OPEN, OPEN, "M 60 10 L 150 610 L 430 610 L 430 0 ; M 0 -130 L 0 0 L 520 0 L 520 -130"},      /* Д */
    {0x416, SLANT, SLANT, "M 330 610 L 330 0 ; M 20 610 L 300 305 L 0 0 ; M 640 610 L 360 305 L 660 0"}, /* Ж */
    {0x417, OPEN, ROUND, "E 185 459 168 161 150 -90 L 130 298 ; M 130 298 L 185 298 E 185 145 195 153 90 -150"}, /* З */
    {0x418, STEM, STEM, "M 0 610 L 0 0 L 470 610 L 470 0"},                                                  /* И */
    {0x41b, SLANT, STEM, "M 0 0 L 150 610 L 440 610 L 440 0"},                                               /* Л */
    {0x423, SLANT, SLANT, "M 0 610 L 235 240 ; M 460 610 L 130 0 L 50 0"},                                   /* У */
    {0x426, STEM, OPEN, "M 0 610 L 0 0 L 540 0 L 540 -130 ; M 460 610 L 460 0"},                             /* Ц */
    {0x427, STEM, STEM, "M 0 610 L 0 430 E 170 430 170 160 180 270 L 410 270 ; M 410 610 L 410 0"},          /* Ч */
    {0x428, STEM, STEM, "M 0 610 L 0 0 L 640 0 L 640 610 ; M 320 610 L 320 0"},                              /* Ш */
    {0x429, STEM, OPEN, "M 0 610 L 0 0 L 720 0 L 720 -130 ; M 320 610 L 320 0 ; M 640 610 L 640 0"},         /* Щ */
    {0x42a, OPEN, ROUND, "M 0 610 L 130 610 L 130 0 L 330 0 E 330 172 168 172 -90 90 L 150 344"},            /* Ъ */
    {0x42b, STEM, STEM, "M 0 610 L 0 0 L 190 0 E 190 172 168 172 -90 90 L 20 344 ; M 520 610 L 520 0"},      /* Ы */
    {0x42c, STEM, ROUND, "M 0 610 L 0 0 L 210 0 E 210 172 172 172 -90 90 L 20 344"},                         /* Ь */
    {0x42d, OPEN, ROUND, "E 250 305 310 313 138 -138 ; M 200 305 L 555 305"},                                /* Э */
    {0x42e, STEM, ROUND, "M 0 610 L 0 0 ; M 20 305 L 150 305 ; O 420 305 265 313"},                          /* Ю */
    {0x42f, OPEN, STEM, "M 395 0 L 395 610 L 180 610 E 180 445 168 165 90 270 L 375 280 ; M 190 280 L 0 0"}, /* Я */
    {0x431, ROUND, ROUND, "O 203 200 203 208 ; E 230 330 228 300 180 100 L 390 660"},                        /* б */
    {0x432, STEM, ROUND,
     "M 20 215 L 170 215 E 170 317 103 103 -90 90 L 0 420 L 0 0 L 180 0 E 180 107 115 107 -90 90"},      /* в */
    {0x433, STEM, OPEN, "M 270 420 L 0 420 L 0 0"},                                                      /* г */
    {0x434, OPEN, OPEN, "M 60 10 L 120 420 L 340 420 L 340 0 ; M 0 -120 L 0 0 L 410 0 L 410 -120"},      /* д */
    {0x436, SLANT, SLANT, "M 260 420 L 260 0 ; M 20 420 L 240 210 L 0 0 ; M 500 420 L 280 210 L 520 0"}, /* ж */
    {0x437, OPEN, ROUND, "E 150 318 130 110 150 -90 L 110 208 ; M 110 208 L 150 208 E 150 100 150 108 90 -150"}, /* з */
    {0x438, STEM, STEM, "M 0 420 L 0 0 L 350 420 L 350 0"},                                                  /* и */
    {0x43b, SLANT, STEM, "M 0 0 L 110 420 L 350 420 L 350 0"},                                               /* л */
    {0x43c, STEM, STEM, "M 0 0 L 0 420 L 220 90 L 440 420 L 440 0"},                                         /* м */
    {0x43d, STEM, STEM, "M 0 420 L 0 0 ; M 350 420 L 350 0 ; M 20 215 L 330 215"},                           /* н */
    {0x43f, STEM, STEM, "M 0 0 L 0 420 L 350 420 L 350 0"},                                                  /* п */
    {0x442, OPEN, OPEN, "M 0 420 L 360 420 ; M 180 400 L 180 0"},                                            /* т */
    {0x446, STEM, OPEN, "M 0 420 L 0 0 L 410 0 L 410 -120 ; M 340 420 L 340 0"},                             /* ц */
    {0x447, STEM, STEM, "M 0 420 L 0 290 E 130 290 130 110 180 270 L 320 180 ; M 320 420 L 320 0"},          /* ч */
    {0x448, STEM, STEM, "M 0 420 L 0 0 L 500 0 L 500 420 ; M 250 420 L 250 0"},                              /* ш */
    {0x449, STEM, OPEN, "M 0 420 L 0 0 L 570 0 L 570 -120 ; M 250 420 L 250 0 ; M 500 420 L 500 0"},         /* щ */
    {0x44a, OPEN, ROUND, "M 0 420 L 100 420 L 100 0 L 250 0 E 250 122 122 122 -90 90 L 120 244"},            /* ъ */
    {0x44b, STEM, STEM, "M 0 420 L 0 0 L 150 0 E 150 122 122 122 -90 90 L 20 244 ; M 390 420 L 390 0"},      /* ы */
    {0x44c, STEM, ROUND, "M 0 420 L 0 0 L 160 0 E 160 122 122 122 -90 90 L 20 244"},                         /* ь */
    {0x44d, OPEN, ROUND, "E 170 210 205 218 135 -135 ; M 130 210 L 365 210"},                                /* э */
    {0x44e, STEM, ROUND, "M 0 420 L 0 0 ; M 20 210 L 120 210 ; O 300 210 180 218"},                          /* ю */
    {0x44f, OPEN, STEM, "M 320 0 L 320 420 L 140 420 E 140 310 120 110 90 270 L 300 200 ; M 140 200 L 0 0"}, /* я */
    {0x454, ROUND, OPEN, "E 205 210 205 218 45 315 ; M 20 210 L 240 210"},                                   /* є */
    {0x490, STEM, OPEN, "M 350 710 L 350 610 L 0 610 L 0 0"},                                                /* Ґ */
    {0x491, STEM, OPEN, "M 270 510 L 270 420 L 0 420 L 0 0"},                                                /* ґ */
    {0x2013, OPEN, OPEN, "M 0 240 L 400 240"}, /* en dash */
    {0x2014, OPEN, OPEN, "M 0 240 L 800 240"}, /* em dash */
    {0x2018, OPEN, OPEN, "M 0 480 L 45 620"},  /* single quotes */
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

/* Marks of small letters, around x = 0; capitals have those above them higher. Each is named in generate.h. */
const glyph_mark font_marks[MARKS] = {
    [MARK_NONE] = {"", false},
    [MARK_GRAVE] = {"M -50 655 L 40 560", false},
    [MARK_ACUTE] = {"M 50 655 L -40 560", false},
    [MARK_CIRCUMFLEX] = {"M -90 560 L 0 650 L 90 560", false},
    [MARK_CARON] = {"M -90 650 L 0 560 L 90 650", false},
    [MARK_TILDE] = {"E -60 585 55 45 180 45 E 61 614 55 45 225 360", false},
    [MARK_DIAERESIS] = {"D -95 595 54 ; D 95 595 54", false},
    [MARK_DOT] = {"D 0 595 56", false},
    [MARK_RING] = {"O 0 610 62 62", false},
    [MARK_MACRON] = {"M -100 600 L 100 600", false},
    [MARK_BREVE] = {"E 0 660 100 90 190 350", false},
    [MARK_DOUBLE_ACUTE] = {"M -30 650 L -105 560 ; M 115 650 L 40 560", false},
    [MARK_CEDILLA] = {"M 30 -60 L -25 -170", true},
    [MARK_OGONEK] = {"E 110 -75 80 80 110 280", true},
};

/* A base letter with a mark, or a letter that looks like another. */
const composed font_composed[] = {
    {0xb5, 0x3bc, MARK_NONE},         /* µ */
    {0xc0, 0x41, MARK_GRAVE},         /* À */
    {0xc1, 0x41, MARK_ACUTE},         /* Á */
    {0xc2, 0x41, MARK_CIRCUMFLEX},    /* Â */
    {0xc3, 0x41, MARK_TILDE},         /* Ã */
    {0xc5, 0x41, MARK_RING},          /* Å */
    {0xc7, 0x43, MARK_CEDILLA},       /* Ç */
    {0xc8, 0x45, MARK_GRAVE},         /* È */
    {0xc9, 0x45, MARK_ACUTE},         /* É */
    {0xca, 0x45, MARK_CIRCUMFLEX},    /* Ê */
    {0xcb, 0x45, MARK_DIAERESIS},     /* Ë */
    {0xcc, 0x49, MARK_GRAVE},         /* Ì */
    {0xcd, 0x49, MARK_ACUTE},         /* Í */
    {0xce, 0x49, MARK_CIRCUMFLEX},    /* Î */
    {0xcf, 0x49, MARK_DIAERESIS},     /* Ï */
    {0xd1, 0x4e, MARK_TILDE},         /* Ñ */
    {0xd2, 0x4f, MARK_GRAVE},         /* Ò */
    {0xd3, 0x4f, MARK_ACUTE},         /* Ó */
    {0xd4, 0x4f, MARK_CIRCUMFLEX},    /* Ô */
    {0xd5, 0x4f, MARK_TILDE},         /* Õ */
    {0xd9, 0x55, MARK_GRAVE},         /* Ù */
    {0xda, 0x55, MARK_ACUTE},         /* Ú */
    {0xdb, 0x55, MARK_CIRCUMFLEX},    /* Û */
    {0xdd, 0x59, MARK_ACUTE},         /* Ý */
    {0xe0, 0x61, MARK_GRAVE},         /* à */
    {0xe1, 0x61, MARK_ACUTE},         /* á */
    {0xe2, 0x61, MARK_CIRCUMFLEX},    /* â */
    {0xe3, 0x61, MARK_TILDE},         /* ã */
    {0xe5, 0x61, MARK_RING},          /* å */
    {0xe7, 0x63, MARK_CEDILLA},       /* ç */
    {0xea, 0x65, MARK_CIRCUMFLEX},    /* ê */
    {0xeb, 0x65, MARK_DIAERESIS},     /* ë */
    {0xec, 0x131, MARK_GRAVE},        /* ì */
    {0xed, 0x131, MARK_ACUTE},        /* í */
    {0xee, 0x131, MARK_CIRCUMFLEX},   /* î */
    {0xef, 0x131, MARK_DIAERESIS},    /* ï */
    {0xf1, 0x6e, MARK_TILDE},         /* ñ */
    {0xf2, 0x6f, MARK_GRAVE},         /* ò */
    {0xf3, 0x6f, MARK_ACUTE},         /* ó */
    {0xf4, 0x6f, MARK_CIRCUMFLEX},    /* ô */
    {0xf5, 0x6f, MARK_TILDE},         /* õ */
    {0xf9, 0x75, MARK_GRAVE},         /* ù */
    {0xfa, 0x75, MARK_ACUTE},         /* ú */
    {0xfb, 0x75, MARK_CIRCUMFLEX},    /* û */
    {0xfd, 0x79, MARK_ACUTE},         /* ý */
    {0xff, 0x79, MARK_DIAERESIS},     /* ÿ */
    {0x100, 0x41, MARK_MACRON},       /* Ā */
    {0x101, 0x61, MARK_MACRON},       /* ā */
    {0x102, 0x41, MARK_BREVE},        /* Ă */
    {0x103, 0x61, MARK_BREVE},        /* ă */
    {0x104, 0x41, MARK_OGONEK},       /* Ą */
    {0x105, 0x61, MARK_OGONEK},       /* ą */
    {0x106, 0x43, MARK_ACUTE},        /* Ć */
    {0x107, 0x63, MARK_ACUTE},        /* ć */
    {0x108, 0x43, MARK_CIRCUMFLEX},   /* Ĉ */
    {0x109, 0x63, MARK_CIRCUMFLEX},   /* ĉ */
    {0x10a, 0x43, MARK_DOT},          /* Ċ */
    {0x10b, 0x63, MARK_DOT},          /* ċ */
    {0x10c, 0x43, MARK_CARON},        /* Č */
    {0x10d, 0x63, MARK_CARON},        /* č */
    {0x10e, 0x44, MARK_CARON},        /* Ď */
    {0x10f, 0x64, MARK_CARON},        /* ď */
    {0x110, 0xd0, MARK_NONE},         /* Đ */
    {0x112, 0x45, MARK_MACRON},       /* Ē */
    {0x113, 0x65, MARK_MACRON},       /* ē */
    {0x114, 0x45, MARK_BREVE},        /* Ĕ */
    {0x115, 0x65, MARK_BREVE},        /* ĕ */
    {0x116, 0x45, MARK_DOT},          /* Ė */
    {0x117, 0x65, MARK_DOT},          /* ė */
    {0x118, 0x45, MARK_OGONEK},       /* Ę */
    {0x119, 0x65, MARK_OGONEK},       /* ę */
    {0x11a, 0x45, MARK_CARON},        /* Ě */
    {0x11b, 0x65, MARK_CARON},        /* ě */
    {0x11c, 0x47, MARK_CIRCUMFLEX},   /* Ĝ */
    {0x11d, 0x67, MARK_CIRCUMFLEX},   /* ĝ */
    {0x11e, 0x47, MARK_BREVE},        /* Ğ */
    {0x11f, 0x67, MARK_BREVE},        /* ğ */
    {0x120, 0x47, MARK_DOT},          /* Ġ */
    {0x121, 0x67, MARK_DOT},          /* ġ */
    {0x122, 0x47, MARK_CEDILLA},      /* Ģ */
    {0x123, 0x67, MARK_CEDILLA},      /* ģ */
    {0x124, 0x48, MARK_CIRCUMFLEX},   /* Ĥ */
    {0x125, 0x68, MARK_CIRCUMFLEX},   /* ĥ */
    {0x128, 0x49, MARK_TILDE},        /* Ĩ */
    {0x129, 0x131, MARK_TILDE},       /* ĩ */
    {0x12a, 0x49, MARK_MACRON},       /* Ī */
    {0x12b, 0x131, MARK_MACRON},      /* ī */
    {0x12c, 0x49, MARK_BREVE},        /* Ĭ */
    {0x12d, 0x131, MARK_BREVE},       /* ĭ */
    {0x12e, 0x49, MARK_OGONEK},       /* Į */
    {0x12f, 0x131, MARK_OGONEK},      /* į */
    {0x130, 0x49, MARK_DOT},          /* İ */
    {0x134, 0x4a, MARK_CIRCUMFLEX},   /* Ĵ */
    {0x135, 0x6a, MARK_CIRCUMFLEX},   /* ĵ */
    {0x136, 0x4b, MARK_CEDILLA},      /* Ķ */
    {0x137, 0x6b, MARK_CEDILLA},      /* ķ */
    {0x139, 0x4c, MARK_ACUTE},        /* Ĺ */
    {0x13a, 0x6c, MARK_ACUTE},        /* ĺ */
    {0x13b, 0x4c, MARK_CEDILLA},      /* Ļ */
    {0x13c, 0x6c, MARK_CEDILLA},      /* ļ */
    {0x13d, 0x4c, MARK_CARON},        /* Ľ */
    {0x13e, 0x6c, MARK_CARON},        /* ľ */
    {0x143, 0x4e, MARK_ACUTE},        /* Ń */
    {0x144, 0x6e, MARK_ACUTE},        /* ń */
    {0x145, 0x4e, MARK_CEDILLA},      /* Ņ */
    {0x146, 0x6e, MARK_CEDILLA},      /* ņ */
    {0x147, 0x4e, MARK_CARON},        /* Ň */
    {0x148, 0x6e, MARK_CARON},        /* ň */
    {0x14c, 0x4f, MARK_MACRON},       /* Ō */
    {0x14d, 0x6f, MARK_MACRON},       /* ō */
    {0x14e, 0x4f, MARK_BREVE},        /* Ŏ */
    {0x14f, 0x6f, MARK_BREVE},        /* ŏ */
    {0x150, 0x4f, MARK_DOUBLE_ACUTE}, /* Ő */
    {0x151, 0x6f, MARK_DOUBLE_ACUTE}, /* ő */
    {0x154, 0x52, MARK_ACUTE},        /* Ŕ */
    {0x155, 0x72, MARK_ACUTE},        /* ŕ */
    {0x156, 0x52, MARK_CEDILLA},      /* Ŗ */
    {0x157, 0x72, MARK_CEDILLA},      /* ŗ */
    {0x158, 0x52, MARK_CARON},        /* Ř */
    {0x159, 0x72, MARK_CARON},        /* ř */
    {0x15a, 0x53, MARK_ACUTE},        /* Ś */
    {0x15b, 0x73, MARK_ACUTE},        /* ś */
    {0x15c, 0x53, MARK_CIRCUMFLEX},   /* Ŝ */
    {0x15d, 0x73, MARK_CIRCUMFLEX},   /* ŝ */
    {0x15e, 0x53, MARK_CEDILLA},      /* Ş */
    {0x15f, 0x73, MARK_CEDILLA},      /* ş */
    {0x160, 0x53, MARK_CARON},        /* Š */
    {0x161, 0x73, MARK_CARON},        /* š */
    {0x162, 0x54, MARK_CEDILLA},      /* Ţ */
    {0x163, 0x74, MARK_CEDILLA},      /* ţ */
    {0x164, 0x54, MARK_CARON},        /* Ť */
    {0x165, 0x74, MARK_CARON},        /* ť */
    {0x168, 0x55, MARK_TILDE},        /* Ũ */
    {0x169, 0x75, MARK_TILDE},        /* ũ */
    {0x16a, 0x55, MARK_MACRON},       /* Ū */
    {0x16b, 0x75, MARK_MACRON},       /* ū */
    {0x16c, 0x55, MARK_BREVE},        /* Ŭ */
    {0x16d, 0x75, MARK_BREVE},        /* ŭ */
    {0x16e, 0x55, MARK_RING},         /* Ů */
    {0x16f, 0x75, MARK_RING},         /* ů */
    {0x170, 0x55, MARK_DOUBLE_ACUTE}, /* Ű */
    {0x171, 0x75, MARK_DOUBLE_ACUTE}, /* ű */
    {0x172, 0x55, MARK_OGONEK},       /* Ų */
    {0x173, 0x75, MARK_OGONEK},       /* ų */
    {0x174, 0x57, MARK_CIRCUMFLEX},   /* Ŵ */
    {0x175, 0x77, MARK_CIRCUMFLEX},   /* ŵ */
    {0x176, 0x59, MARK_CIRCUMFLEX},   /* Ŷ */
    {0x177, 0x79, MARK_CIRCUMFLEX},   /* ŷ */
    {0x178, 0x59, MARK_DIAERESIS},    /* Ÿ */
    {0x179, 0x5a, MARK_ACUTE},        /* Ź */
    {0x17a, 0x7a, MARK_ACUTE},        /* ź */
    {0x17b, 0x5a, MARK_DOT},          /* Ż */
    {0x17c, 0x7a, MARK_DOT},          /* ż */
    {0x17d, 0x5a, MARK_CARON},        /* Ž */
    {0x17e, 0x7a, MARK_CARON},        /* ž */
    {0x218, 0x53, MARK_CEDILLA},      /* Ș */
    {0x219, 0x73, MARK_CEDILLA},      /* ș */
    {0x21a, 0x54, MARK_CEDILLA},      /* Ț */
    {0x21b, 0x74, MARK_CEDILLA},      /* ț */
    {0x386, 0x41, MARK_ACUTE},        /* Ά */
    {0x388, 0x45, MARK_ACUTE},        /* Έ */
    {0x389, 0x48, MARK_ACUTE},        /* Ή */
    {0x38a, 0x49, MARK_ACUTE},        /* Ί */
    {0x38c, 0x4f, MARK_ACUTE},        /* Ό */
    {0x38e, 0x59, MARK_ACUTE},        /* Ύ */
    {0x38f, 0x3a9, MARK_ACUTE},       /* Ώ */
    {0x391, 0x41, MARK_NONE},         /* Α */
    {0x392, 0x42, MARK_NONE},         /* Β */
    {0x395, 0x45, MARK_NONE},         /* Ε */
    {0x396, 0x5a, MARK_NONE},         /* Ζ */
    {0x397, 0x48, MARK_NONE},         /* Η */
    {0x399, 0x49, MARK_NONE},         /* Ι */
    {0x39a, 0x4b, MARK_NONE},         /* Κ */
    {0x39c, 0x4d, MARK_NONE},         /* Μ */
    {0x39d, 0x4e, MARK_NONE},         /* Ν */
    {0x39f, 0x4f, MARK_NONE},         /* Ο */
    {0x3a1, 0x50, MARK_NONE},         /* Ρ */
    {0x3a4, 0x54, MARK_NONE},         /* Τ */
    {0x3a5, 0x59, MARK_NONE},         /* Υ */
    {0x3a7, 0x58, MARK_NONE},         /* Χ */
    {0x3aa, 0x49, MARK_DIAERESIS},    /* Ϊ */
    {0x3ab, 0x59, MARK_DIAERESIS},    /* Ϋ */
    {0x3ac, 0x3b1, MARK_ACUTE},       /* ά */
    {0x3ad, 0x3b5, MARK_ACUTE},       /* έ */
    {0x3ae, 0x3b7, MARK_ACUTE},       /* ή */
    {0x3af, 0x3b9, MARK_ACUTE},       /* ί */
    {0x3bd, 0x76, MARK_NONE},         /* ν */
    {0x3bf, 0x6f, MARK_NONE},         /* ο */
    {0x3c1, 0x70, MARK_NONE},         /* ρ */
    {0x3ca, 0x3b9, MARK_DIAERESIS},   /* ϊ */
    {0x3cb, 0x3c5, MARK_DIAERESIS},   /* ϋ */
    {0x3cc, 0x6f, MARK_ACUTE},        /* ό */
    {0x3cd, 0x3c5, MARK_ACUTE},       /* ύ */
    {0x3ce, 0x3c9, MARK_ACUTE},       /* ώ */
    {0x401, 0x45, MARK_DIAERESIS},    /* Ё */
    {0x405, 0x53, MARK_NONE},         /* Ѕ */
    {0x406, 0x49, MARK_NONE},         /* І */
    {0x407, 0x49, MARK_DIAERESIS},    /* Ї */
    {0x408, 0x4a, MARK_NONE},         /* Ј */
    {0x40e, 0x423, MARK_BREVE},       /* Ў */
    {0x410, 0x41, MARK_NONE},         /* А */
    {0x412, 0x42, MARK_NONE},         /* В */
    {0x413, 0x393, MARK_NONE},        /* Г */
    {0x415, 0x45, MARK_NONE},         /* Е */
    {0x419, 0x418, MARK_BREVE},       /* Й */
    {0x41a, 0x4b, MARK_NONE},         /* К */
    {0x41c, 0x4d, MARK_NONE},         /* М */
    {0x41d, 0x48, MARK_NONE},         /* Н */
    {0x41e, 0x4f, MARK_NONE},         /* О */
    {0x41f, 0x3a0, MARK_NONE},        /* П */
    {0x420, 0x50, MARK_NONE},         /* Р */
    {0x421, 0x43, MARK_NONE},         /* С */
    {0x422, 0x54, MARK_NONE},         /* Т */
    {0x424, 0x3a6, MARK_NONE},        /* Ф */
    {0x425, 0x58, MARK_NONE},         /* Х */
    {0x430, 0x61, MARK_NONE},         /* а */
    {0x435, 0x65, MARK_NONE},         /* е */
    {0x439, 0x438, MARK_BREVE},       /* й */
    {0x43a, 0x3ba, MARK_NONE},        /* к */
    {0x43e, 0x6f, MARK_NONE},         /* о */
    {0x440, 0x70, MARK_NONE},         /* р */
    {0x441, 0x63, MARK_NONE},         /* с */
    {0x443, 0x79, MARK_NONE},         /* у */
    {0x444, 0x3c6, MARK_NONE},        /* ф */
    {0x445, 0x78, MARK_NONE},         /* х */
    {0x451, 0x65, MARK_DIAERESIS},    /* ё */
    {0x455, 0x73, MARK_NONE},         /* ѕ */
    {0x456, 0x69, MARK_NONE},         /* і */
    {0x457, 0x131, MARK_DIAERESIS},   /* ї */
    {0x458, 0x6a, MARK_NONE},         /* ј */
    {0x45e, 0x79, MARK_BREVE},        /* ў */
};
const int font_composed_count = (int)(sizeof font_composed / sizeof font_composed[0]);
