/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* vasprintf */
#include "json/json_text.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "json/json_load.h"
#include "json/text.h"

/* ---- text ------------------------------------------------------------ */

char *ibl_format(const char *fmt, ...)
{
    char *text;
    va_list ap;

    va_start(ap, fmt);
    const int length = vasprintf(&text, fmt, ap);
    va_end(ap);
    return length < 0 ? NULL : text;
}

void ibl_names_text(const char *const *names, char *text, size_t size)
{
    *text = '\0';
    for (int i = 0; names[i]; i++) {
        const size_t used = strlen(text);
        const char *between = i == 0 ? "" : names[i + 1] ? ", " : " or ";
        snprintf(text + used, size - used, "%s%s", between, names[i]);
    }
}

int ibl_names_find(const char *const *names, const char *word)
{
    for (int i = 0; names[i]; i++)
        if (!strcmp(names[i], word))
            return i;
    return -1;
}

/* ---- JSON as text ---------------------------------------------------- */

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

/* ---- JSON for people and programs --------------------------------------- */

/* Joins the lines between `from` and `to`; returns the new end. */
static char *join_lines(char *from, const char *to)
{
    char *end = from;

    for (const char *at = from; at < to; at++) {
        if (*at == '\n') {
            while (at[1] == ' ')
                at++;
            if (end > from && at[1] != ']')
                *end++ = ' ';
        } else {
            *end++ = *at;
        }
    }
    return end;
}

char *ibl_json_text(const json_t *root)
{
    const size_t how = JSON_INDENT(2) | JSON_REAL_PRECISION(15);
    const size_t size = json_dumpb(root, NULL, 0, how);
    char *text = size ? malloc(size + 2) : NULL;
    char *to = text, *inner = NULL; /* in an array, so far of plain values */
    bool quoted = false;

    if (!text || json_dumpb(root, text, size, how) != size) {
        free(text);
        return NULL;
    }
    for (const char *at = text; at < text + size; at++) {
        const char c = *to++ = *at;
        if (c == '\\')
            *to++ = *++at;
        else if (c == '"')
            quoted = !quoted;
        if (quoted || (c != '[' && c != '{' && c != ']'))
            continue;
        if (c == ']' && inner)
            to = join_lines(inner, to);
        inner = c == '[' ? to : NULL;
    }
    *to++ = '\n';
    *to = '\0';
    return text;
}

static json_t *triple_of(const double v[3])
{
    return json_pack("[fff]", v[0], v[1], v[2]);
}

static json_t *volume_of(const ibl_volume *v)
{
    if (v->shape == IBL_SHAPE_BOX)
        return json_pack("{s{so so}}", "box", "centre", triple_of(v->centre),
                         "half", triple_of(v->half));
    return json_pack("{s{so sf}}", "sphere", "centre", triple_of(v->centre),
                     "radius", v->half[0]);
}

json_t *ibl_json_probe_of(const ibl_probe *p)
{
    json_t *j = json_pack("{si so so sf}", "priority", p->priority, "position",
                          triple_of(p->position), "influence",
                          volume_of(&p->influence), "blend", p->blend);

    if (p->has_proxy)
        put(&j, "proxy", volume_of(&p->proxy));
    return j;
}
