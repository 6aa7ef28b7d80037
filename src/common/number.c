/* SPDX-License-Identifier: MIT */
#include "common/number.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int is_same(const char *text, double x)
{
    const double back = strtod(text, NULL);
    return !(back < x || back > x);
}

void ibl_number_text(double x, char text[IBL_NUMBER_BYTES])
{
    int decimals = 0;

    /* Most need 16 or 17 digits: then the fewer are not all tried. */
    snprintf(text, IBL_NUMBER_BYTES, "%.14e", x);
    if (!is_same(text, x))
        decimals = 15;
    for (; decimals <= 16; decimals++) {
        snprintf(text, IBL_NUMBER_BYTES, "%.*e", decimals, x);
        if (is_same(text, x))
            break;
    }
    const int exponent = atoi(strchr(text, 'e') + 1);
    if (exponent >= -5 && exponent < 9)
        snprintf(text, IBL_NUMBER_BYTES, "%.*f",
                 decimals > exponent ? decimals - exponent : 0, x);
}
