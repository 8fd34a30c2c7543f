/* The sRGB transfer curve (IEC 61966-2-1), with our own powers so that the bits do not depend on libm. */
#include "image/color.h"

#include "math/trig.h"

static double decode(double encoded)
{
    return encoded <= 0.04045 ? encoded / 12.92 : daft_pow((encoded + 0.055) / 1.055, 2.4);
}

float daft_srgb_to_linear(float encoded) { return encoded > 0 ? (float)decode((double)encoded) : 0; }

float daft_linear_to_srgb(float linear)
{
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 1;
    double light = (double)linear;
    return (float)(light <= 0.0031308 ? light * 12.92 : 1.055 * daft_pow(light, 1 / 2.4) - 0.055);
}

void daft_srgb_table_make(daft_srgb_table *table)
{
    for (int i = 0; i < 256; i++) {
        table->linear[i] = (float)decode(i / 255.0);
        table->threshold[i] = i ? (float)decode((i - 0.5) / 255.0) : 0;
    }
    table->threshold[256] = INFINITY;
    unsigned byte = 0;
    for (int i = 0; i <= 4096; i++) {
        while (byte < 255 && (float)i / 4096 >= table->threshold[byte + 1]) byte++;
        table->guess[i] = (uint8_t)byte;
    }
}
