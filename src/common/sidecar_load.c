/* SPDX-License-Identifier: MIT */
#include "common/sidecar_load.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* The name's inverse of ibl_json_encoded, in place. */
static void decode(char *name)
{
    char *to = name;

    for (const char *from = name; *from; to++) {
        char hex[3] = "";
        if (*from == '%')
            strncpy(hex, from + 1, 2);
        const bool is_code =
            isxdigit((unsigned char)hex[0]) && isxdigit((unsigned char)hex[1]);
        *to = is_code ? (char)strtol(hex, NULL, 16) : *from;
        from += is_code ? 3 : 1;
    }
    *to = '\0';
}

static void decode_member(json_t *object, const char *key)
{
    json_t *value = json_object_get(object, key);
    char *name =
        json_is_string(value) ? strdup(json_string_value(value)) : NULL;

    if (name) {
        decode(name);
        json_string_set_nocheck(value, name);
    }
    free(name);
}

json_t *ibl_sidecar_load(const char *path, ibl_json_why *why)
{
    json_t *root = ibl_json_load(path, 0, why), *output;
    const char *names = json_string_value(json_object_get(root, "names"));
    size_t i;

    if (!names || strcmp(names, IBL_NAMES_ENCODED) != 0)
        return root;
    decode_member(json_object_get(root, "source"), "path");
    json_array_foreach(json_object_get(root, "outputs"), i, output)
    {
        decode_member(output, "file");
    }
    return root;
}
