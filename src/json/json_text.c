/* SPDX-License-Identifier: MIT */
#include "json/json_text.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "json/text.h"

/* Bytes of the UTF-8 character (The Unicode Standard, table 3-7: shortest form,
 * no surrogates) that a text begins with; 0: it begins with none. */
static size_t character(const char *text)
{
    const unsigned char *p = (const unsigned char *)text;
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    const size_t length = !p[0]               ? 0
                          : p[0] < 0x80       ? 1
                          : p[0] >> 5 == 0x06 ? 2
                          : p[0] >> 4 == 0x0E ? 3
                          : p[0] >> 3 == 0x1E ? 4
                                              : 0;
    if (length < 2)
        return length;
    uint32_t code = p[0] & (0x7Fu >> length);
    for (size_t i = 1; i < length; i++) {
        if (p[i] >> 6 != 2)
            return 0;
        code = code << 6 | (p[i] & 0x3F);
    }
    const bool surrogate = code >> 11 == 0xD800 >> 11;
    return code < least[length] || code > 0x10FFFF || surrogate ? 0 : length;
}

bool ibl_json_is_text(const char *bytes)
{
    size_t n;

    while ((n = character(bytes)) > 0)
        bytes += n;
    return !*bytes;
}

json_t *ibl_json_string(const char *bytes)
{
    char *text = malloc(3 * strlen(bytes) + 1), *to = text;

    for (size_t i = 0; text && bytes[i];) {
        const size_t n = character(bytes + i);
        memcpy(to, n ? bytes + i : "\xEF\xBF\xBD", n ? n : 3);
        to += n ? n : 3;
        i += n ? n : 1;
    }
    json_t *string = text ? json_stringn(text, (size_t)(to - text)) : NULL;
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
