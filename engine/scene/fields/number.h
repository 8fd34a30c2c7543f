/* A decimal number in text: [+-] digits [. digits] [e [+-] digits], with digits on at least one side of the point. No
 * hexadecimal, inf or nan; the point is a point in every locale. Rounded correctly; overflow gives infinity. */
#ifndef DAFT_NUMBER_H
#define DAFT_NUMBER_H

#include "base/base.h"

enum { DAFT_LONGEST_NUMBER = 127 }; /* characters */

/* False: these `length` characters are no number, or more than the longest. */
bool daft_number_parse(const char *text, size_t length, double *out);

#endif
