/* SPDX-License-Identifier: MIT */
#include "io/input.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

bool ibl_take_number(char **t, double *value)
{
    uint64_t digits = 0;
    int exponent = 0;
    bool seen = false, point = false;

    while (**t == ' ' || **t == '\t')
        ++*t;
    const bool negative = **t == '-';
    *t += negative || **t == '+';
    for (; is_digit(**t) || (**t == '.' && !point); ++*t) {
        if (**t == '.') {
            point = true;
            continue;
        }
        seen = true;
        if (digits < UINT64_MAX / 10 - 1) {
            digits = digits * 10 + (uint64_t)(**t - '0');
            exponent -= point;
        } else {
            exponent += !point;
        }
    }
    if (!seen)
        return false;

    char *e = *t + 1;
    if ((**t == 'e' || **t == 'E') && is_digit(e[*e == '-' || *e == '+'])) {
        const long n = strtol(e, t, 10);
        exponent += n < -9999 ? -9999 : n > 9999 ? 9999 : (int)n;
    }
    if (!digits)
        exponent = 0; /* 0e9999 is 0, not 0 * Inf */
    *value = exponent < 0 ? (double)digits / pow(10, -exponent)
                          : (double)digits * pow(10, exponent);
    if (negative)
        *value = -*value;
    return true;
}
