/* SPDX-License-Identifier: MIT */
#include "json/json_load.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "json/json_build.h"
#include "json/text.h"

static bool write_value(const json_t *value, int depth, FILE *to);

static void break_line(int depth, FILE *to)
{
    fprintf(to, "\n%*s", 2 * depth, "");
}

static bool write_key(const char *key, FILE *to)
{
    json_t *text = json_string(key);
    const bool ok = text && !json_dumpf(text, to, JSON_ENCODE_ANY);

    json_decref(text);
    fputs(": ", to);
    return ok;
}

static bool write_object(json_t *object, int depth, FILE *to)
{
    const char *key, *between = "";
    json_t *value;
    bool ok = true;

    fputc('{', to);
    json_object_foreach(object, key, value)
    {
        fputs(between, to);
        between = ",";
        break_line(depth + 1, to);
        ok = ok && write_key(key, to) && write_value(value, depth + 1, to);
    }
    if (json_object_size(object))
        break_line(depth, to);
    fputc('}', to);
    return ok;
}

static bool write_array(const json_t *array, int depth, FILE *to)
{
    const json_t *value;
    bool plain = true, ok = true;
    size_t i;

    json_array_foreach(array, i, value)
    {
        plain &= !json_is_array(value) && !json_is_object(value);
    }
    fputc('[', to);
    json_array_foreach(array, i, value)
    {
        fputs(i == 0 ? "" : plain ? ", " : ",", to);
        if (!plain)
            break_line(depth + 1, to);
        ok &= write_value(value, depth + 1, to);
    }
    if (!plain)
        break_line(depth, to);
    fputc(']', to);
    return ok;
}

/* False: no memory, or value is NULL. */
static bool write_value(const json_t *value, int depth, FILE *to)
{
    char text[IBL_NUMBER_BYTES];

    if (json_is_object(value))
        return write_object((json_t *)value, depth, to);
    if (json_is_array(value))
        return write_array(value, depth, to);
    if (!json_is_real(value))
        return !json_dumpf(value, to, JSON_ENCODE_ANY);
    ibl_number_text(json_real_value(value), text);
    /* Keeps a real a real for readers that distinguish 1 and 1.0. */
    fprintf(to, "%s%s", text, strpbrk(text, ".e") ? "" : ".0");
    return true;
}

char *ibl_json_text(const json_t *root)
{
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);
    const bool ok = to && write_value(root, 0, to) && fputc('\n', to) != EOF;
    char *text = ibl_memory_close(to, &file);

    if (ok)
        return text;
    free(text);
    return NULL;
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
