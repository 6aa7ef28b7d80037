/* SPDX-License-Identifier: MIT */
#include "json/json_at.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "json/json_load.h"
#include "json/text.h"

bool ibl_json_open(ibl_json_file *file)
{
    ibl_json_why why;

    file->root = ibl_json_load(file->name, JSON_REJECT_DUPLICATES, &why);
    if (!file->root)
        file->fail(file->cookie, why.line);
    return file->root;
}

ibl_json_at ibl_json_root(const ibl_json_file *file)
{
    return (ibl_json_at){.file = file, .value = file->root};
}

/* A member or element of at; fmt makes the end of its path. */
static ibl_json_at below(const ibl_json_at *at, const json_t *value,
                         const char *fmt, ...)
{
    ibl_json_at in = {.file = at->file, .value = value};
    const size_t used = strlen(at->path);
    va_list ap;

    memcpy(in.path, at->path, used);
    va_start(ap, fmt);
    vsnprintf(in.path + used, sizeof in.path - used, fmt, ap);
    va_end(ap);
    return in;
}

ibl_json_at ibl_json_member(const ibl_json_at *at, const char *key)
{
    return below(at, json_object_get(at->value, key), *at->path ? ".%s" : "%s",
                 key);
}

ibl_json_at ibl_json_optional(const ibl_json_at *at, const char *key)
{
    ibl_json_at member = ibl_json_member(at, key);

    member.optional = true;
    return member;
}

ibl_json_at ibl_json_element(const ibl_json_at *at, size_t index)
{
    return below(at, json_array_get(at->value, index), "[%zu]", index);
}

static void describe(const json_t *value, char *text, size_t size)
{
    const char *key = json_object_iter_key(json_object_iter((json_t *)value));

    if (json_is_object(value)) {
        snprintf(text, size, key ? "an object with \"%.40s\"" : "an object%s",
                 key ? key : " without members");
    } else if (json_is_array(value)) {
        snprintf(text, size, "an array of %zu", json_array_size(value));
    } else if (json_is_string(value)) {
        snprintf(text, size, "\"%.60s\"", json_string_value(value));
    } else if (value) {
        const size_t length = json_dumpb(
            value, text, size - 1, JSON_ENCODE_ANY | JSON_REAL_PRECISION(10));
        text[length] = '\0';
    } else {
        snprintf(text, size, "nothing");
    }
}

bool ibl_json_complain(ibl_json_at at, const char *fmt, ...)
{
    char text[2048], line[IBL_LINE_BYTES];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(text, sizeof text, fmt, ap);
    va_end(ap);
    snprintf(line, sizeof line, "%s: %s%s%s", at.file->name, at.path,
             *at.path ? ": " : "", text);
    at.file->fail(at.file->cookie, line);
    return false;
}

bool ibl_json_wrong(ibl_json_at at, const char *expected, ...)
{
    char text[1024], found[256];
    va_list ap;

    if (at.optional && !at.value)
        return true;
    va_start(ap, expected);
    vsnprintf(text, sizeof text, expected, ap);
    va_end(ap);
    describe(at.value, found, sizeof found);
    return ibl_json_complain(at, "expected %s, found %s", text, found);
}

bool ibl_json_object(ibl_json_at at, const char *const *keys)
{
    char names[512];

    ibl_names_text(keys, names, sizeof names);
    if (!json_is_object(at.value))
        return ibl_json_wrong(at, "an object with %s", names);
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)at.value, key, value)
    {
        if (ibl_names_find(keys, key) >= 0)
            continue;
        return ibl_json_complain(
            ibl_json_member(&at, key),
            "expected no such member, but %s; found \"%.60s\"", names, key);
    }
    return true;
}

bool ibl_json_array(ibl_json_at at, size_t least, size_t most)
{
    const size_t count = json_array_size(at.value);

    if (json_is_array(at.value) && count >= least && count <= most)
        return true;
    if (least == most)
        return ibl_json_wrong(at, "an array of %zu", least);
    return ibl_json_wrong(at, "an array of %zu to %zu", least, most);
}

bool ibl_json_text_at(ibl_json_at at, const char **text)
{
    if (!json_is_string(at.value) || !json_string_length(at.value))
        return ibl_json_wrong(at, "a string that is not empty");
    *text = json_string_value(at.value);
    if (strlen(*text) != json_string_length(at.value))
        return ibl_json_wrong(at, "a string without NUL");
    return true;
}

bool ibl_json_real(ibl_json_at at, double low, double high, bool open,
                   double *value)
{
    const double x = json_number_value(at.value);

    if (!json_is_number(at.value) || !(x >= low && x <= high) ||
        (open && x <= low))
        return ibl_json_wrong(at,
                              open ? "a number above %.10g, up to %.10g"
                                   : "a number from %.10g to %.10g",
                              low, high);
    *value = x;
    return true;
}

bool ibl_json_int(ibl_json_at at, int low, int high, int *value)
{
    const double n = json_number_value(at.value); /* 5126.0 is one, too */

    if (!json_is_number(at.value) || !(n >= low && n <= high) || n != (int)n)
        return low == high ? ibl_json_wrong(at, "%d", low)
                           : ibl_json_wrong(at, "a whole number from %d to %d",
                                            low, high);
    *value = (int)n;
    return true;
}

bool ibl_json_choice(ibl_json_at at, const char *const *names, void *value)
{
    const char *word = json_string_value(at.value);
    const int found = word ? ibl_names_find(names, word) : -1;
    char text[256];

    if (found >= 0) {
        memcpy(value, &found, sizeof found);
        return true;
    }
    ibl_names_text(names, text, sizeof text);
    return ibl_json_wrong(at, "%s", text);
}

bool ibl_json_triple(ibl_json_at at, double low, double high, bool open,
                     double value[3])
{
    bool ok = json_array_size(at.value) == 3 ||
              ibl_json_wrong(at, "an array of 3 numbers");

    for (size_t k = 0; k < 3 && ok; k++)
        ok =
            ibl_json_real(ibl_json_element(&at, k), low, high, open, &value[k]);
    return ok;
}

bool ibl_json_place(ibl_json_at at, double place[3])
{
    return ibl_json_triple(at, -IBL_JSON_FARTHEST, IBL_JSON_FARTHEST, false,
                           place);
}

static bool take_shape(ibl_json_at at, ibl_shape shape, ibl_volume *v)
{
    static const char *const keys[][3] = {
        [IBL_SHAPE_BOX] = {"centre", "half", NULL},
        [IBL_SHAPE_SPHERE] = {"centre", "radius", NULL}};
    const ibl_json_at size = ibl_json_member(&at, keys[shape][1]);

    v->shape = shape;
    if (!ibl_json_object(at, keys[shape]) ||
        !ibl_json_place(ibl_json_member(&at, "centre"), v->centre))
        return false;
    if (shape == IBL_SHAPE_BOX)
        return ibl_json_triple(size, 0, IBL_JSON_FARTHEST, true, v->half);
    if (!ibl_json_real(size, 0, IBL_JSON_FARTHEST, true, &v->half[0]))
        return false;
    v->half[1] = v->half[2] = v->half[0];
    return true;
}

bool ibl_json_volume(ibl_json_at at, ibl_volume *volume)
{
    static const char *const keys[] = {"box", "sphere", NULL};
    const ibl_json_at box = ibl_json_member(&at, "box");
    const ibl_json_at sphere = ibl_json_member(&at, "sphere");

    if (!ibl_json_object(at, keys))
        return false;
    if (!box.value == !sphere.value)
        return ibl_json_wrong(at, "one of box and sphere");
    return box.value ? take_shape(box, IBL_SHAPE_BOX, volume)
                     : take_shape(sphere, IBL_SHAPE_SPHERE, volume);
}

bool ibl_json_probe(ibl_json_at at, ibl_probe *probe)
{
    const ibl_json_at proxy = ibl_json_optional(&at, "proxy");

    probe->has_proxy = proxy.value != NULL;
    return ibl_json_place(ibl_json_member(&at, "position"), probe->position) &&
           ibl_json_volume(ibl_json_member(&at, "influence"),
                           &probe->influence) &&
           ibl_json_real(ibl_json_optional(&at, "blend"), 0, IBL_JSON_FARTHEST,
                         false, &probe->blend) &&
           ibl_json_int(ibl_json_optional(&at, "priority"), -IBL_JSON_PRIORITY,
                        IBL_JSON_PRIORITY, &probe->priority) &&
           ibl_json_volume(proxy, &probe->proxy);
}
