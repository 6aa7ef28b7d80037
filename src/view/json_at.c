/* SPDX-License-Identifier: MIT */
#include "view/json_at.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "view/message.h"

json_t *view_json_open(const char *file)
{
    struct stat st;
    json_error_t why;
    json_t *root;

    if (stat(file, &st)) {
        view_fail("%s: cannot be read: %s", file, strerror(errno));
        return NULL;
    }
    /* Neither a pipe that nobody writes, nor a device without an end. */
    if (!S_ISREG(st.st_mode)) {
        view_fail("%s: is no file: a JSON file was expected", file);
        return NULL;
    }
    root = json_load_file(file, JSON_REJECT_DUPLICATES, &why);
    if (!root && why.line > 0)
        view_fail("%s:%d:%d: is no JSON, or not all of it: %s", file, why.line,
                  why.column, why.text);
    else if (!root)
        view_fail("%s: cannot be read: %s", file, why.text);
    return root;
}

view_json_at view_json_root(const char *file, const json_t *root)
{
    return (view_json_at){.file = file, .value = root};
}

view_json_at view_json_member(const view_json_at *at, const char *key)
{
    return (view_json_at){.file = at->file,
                          .value = json_object_get(at->value, key),
                          .above = at,
                          .key = key};
}

view_json_at view_json_element(const view_json_at *at, size_t index)
{
    return (view_json_at){.file = at->file,
                          .value = json_array_get(at->value, index),
                          .above = at,
                          .index = index};
}

static void path_of(const view_json_at *at, char *text, size_t size)
{
    size_t used;

    if (!at->above) {
        *text = '\0';
        return;
    }
    path_of(at->above, text, size);
    used = strlen(text);
    if (at->key)
        snprintf(text + used, size - used, "%s%s", used ? "." : "", at->key);
    else
        snprintf(text + used, size - used, "[%zu]", at->index);
}

static void describe(const json_t *value, char *text, size_t size)
{
    switch (value ? json_typeof(value) : JSON_NULL) {
    case JSON_OBJECT:
        snprintf(text, size, "an object");
        break;
    case JSON_ARRAY:
        snprintf(text, size, "an array of %zu", json_array_size(value));
        break;
    case JSON_STRING:
        snprintf(text, size, "\"%.60s\"", json_string_value(value));
        break;
    case JSON_INTEGER:
        snprintf(text, size, "%" JSON_INTEGER_FORMAT,
                 json_integer_value(value));
        break;
    case JSON_REAL:
        snprintf(text, size, "%.10g", json_real_value(value));
        break;
    case JSON_TRUE:
        snprintf(text, size, "true");
        break;
    case JSON_FALSE:
        snprintf(text, size, "false");
        break;
    case JSON_NULL:
        snprintf(text, size, value ? "null" : "nothing");
        break;
    }
}

bool view_json_wrong(const view_json_at *at, const char *expected, ...)
{
    char path[512], text[1024], found[256];
    va_list ap;

    va_start(ap, expected);
    vsnprintf(text, sizeof text, expected, ap);
    va_end(ap);
    path_of(at, path, sizeof path);
    describe(at->value, found, sizeof found);
    return view_fail("%s: %s%sexpected %s, found %s", at->file, path,
                     *path ? ": " : "", text, found);
}

bool view_json_array(const view_json_at *at, size_t least, size_t most)
{
    const size_t count = json_array_size(at->value);

    if (json_is_array(at->value) && count >= least && count <= most)
        return true;
    if (least == most)
        return view_json_wrong(at, "an array of %zu", least);
    return view_json_wrong(at, "an array of %zu to %zu", least, most);
}

bool view_json_text(const view_json_at *at, const char **text)
{
    *text = json_string_value(at->value);
    return (*text && **text &&
            strlen(*text) == json_string_length(at->value)) ||
           view_json_wrong(at, "a string that is not empty");
}

bool view_json_real(const view_json_at *at, double low, double high, bool open,
                    double *value)
{
    const double x = json_number_value(at->value);

    if (!json_is_number(at->value) || !(x >= low && x <= high) ||
        (open && x <= low))
        return view_json_wrong(at,
                               open ? "a number above %.10g, up to %.10g"
                                    : "a number from %.10g to %.10g",
                               low, high);
    *value = x;
    return true;
}

bool view_json_int(const view_json_at *at, int low, int high, int *value)
{
    const json_int_t n = json_integer_value(at->value);

    if (!json_is_integer(at->value) || n < low || n > high)
        return low == high ? view_json_wrong(at, "%d", low)
                           : view_json_wrong(at, "a whole number from %d to %d",
                                             low, high);
    *value = (int)n;
    return true;
}

bool view_json_choice(const view_json_at *at, const char *const *names,
                      int *value)
{
    const char *word = json_string_value(at->value);
    char text[256] = "";

    for (int i = 0; names[i]; i++) {
        const size_t used = strlen(text);
        if (word && !strcmp(word, names[i])) {
            *value = i;
            return true;
        }
        snprintf(text + used, sizeof text - used, "%s\"%s\"",
                 i == 0         ? ""
                 : names[i + 1] ? ", "
                                : " or ",
                 names[i]);
    }
    return view_json_wrong(at, "%s", text);
}

bool view_json_triple(const view_json_at *at, double low, double high,
                      bool open, double value[3])
{
    if (!view_json_array(at, 3, 3))
        return false;
    for (size_t k = 0; k < 3; k++) {
        const view_json_at element = view_json_element(at, k);
        if (!view_json_real(&element, low, high, open, &value[k]))
            return false;
    }
    return true;
}
