/* SPDX-License-Identifier: MIT */
#include "json/json_load.h"

#include <stdlib.h>

#include "json/json_build.h"

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
