/* SPDX-License-Identifier: MIT */
#include "json/json_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "json/text.h"

bool ibl_json_is_text(const char *bytes)
{
    json_t *string = json_string(bytes);

    json_decref(string);
    return string;
}

json_t *ibl_json_string(const char *bytes)
{
    json_t *string = json_string(bytes);
    char *text = string ? NULL : malloc(3 * strlen(bytes) + 1), *to = text;

    if (!text)
        return string;
    for (; *bytes; bytes++)
        if ((unsigned char)*bytes < 0x80)
            *to++ = *bytes;
        else
            to = (char *)memcpy(to, "\xEF\xBF\xBD", 3) + 3;
    string = json_stringn(text, (size_t)(to - text));
    free(text);
    return string;
}

json_t *ibl_json_generator(ibl_isa isa, const char *revision)
{
    json_t *j = json_object();

    put(&j, "name", json_string("iblbake"));
    put(&j, "version", json_string(IBL_VERSION));
    if (revision && *revision)
        put(&j, "revision", ibl_json_string(revision));
    put(&j, "arithmetic", json_string(ibl_isa_arithmetic(isa)));
    return j;
}

json_t *ibl_json_overflow(const ibl_overflow_level *level)
{
    return json_pack("{s:I,s:f,s:f}", "texels", (json_int_t)level->texels,
                     "moved", ibl_json_digits(level->moved), "lost",
                     ibl_json_digits(level->lost));
}

json_t *ibl_json_pixel_error(const ibl_pixel_error *error)
{
    return json_pack("{s:f,s:f}", "nrmse", ibl_json_digits(error->nrmse),
                     "relative", ibl_json_digits(error->relative));
}

json_t *ibl_json_harmonics(const double *sh, int degree, bool cosine)
{
    json_t *j = json_array();

    for (int l = 0; l <= degree; l++) {
        const double k = cosine ? ibl_sh_cosine(l) : 1;
        for (int m = -l; m <= l; m++, sh += 3)
            append(&j, json_pack("[fff]", k * sh[0] + 0.0, k * sh[1] + 0.0,
                                 k * sh[2] + 0.0));
    }
    return j;
}

double ibl_json_digits(double x)
{
    char text[32];

    snprintf(text, sizeof text, "%.3e", x);
    return strtod(text, NULL);
}
