/* SPDX-License-Identifier: MIT */
#include "io/input.h"

#include <locale.h>
#include <math.h>
#include <stdlib.h>

bool ibl_take_number(char **t, double *value)
{
    const locale_t plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
    const locale_t was = uselocale(plain);
    char *end;

    *value = strtod(*t, &end);
    uselocale(was);
    if (plain)
        freelocale(plain);
    if (end == *t || isnan(*value))
        return false;
    *t = end;
    return true;
}
