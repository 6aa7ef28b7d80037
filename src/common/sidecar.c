/* SPDX-License-Identifier: MIT */
#include "common/sidecar.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common/names.h"
#include "json/json_text.h"

/* The inverse of ibl_json_encoded, in place. */
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

/* False: no memory. */
static bool decode_member(json_t *object, const char *key)
{
    json_t *value = json_object_get(object, key);
    if (!json_is_string(value))
        return true;
    char *name = strdup(json_string_value(value));

    if (name)
        decode(name);
    const bool ok = name && !json_string_set_nocheck(value, name);
    free(name);
    return ok;
}

enum {
    LARGE = 1 << 20, /* bytes of a file */
    TRIPLES = 121    /* kept of a list */
};

/* Loads a large file without the harmonics of high degrees, which nobody reads
 * again: of lists with a triple on each line, as ibl_json_text has them, the
 * first ones and the last. NULL: it is not large, or not read. */
static json_t *load_short(const char *path, ibl_json_why *why)
{
    FILE *from = NULL;
    ibl_memory_file memory;
    char *line = NULL;
    size_t room = 0;
    int count = 0;
    struct stat st;
    json_t *root = NULL;

    if (stat(path, &st) || !S_ISREG(st.st_mode) || st.st_size < LARGE ||
        st.st_size > IBL_JSON_BYTES || !(from = fopen(path, "rb")))
        return NULL;
    FILE *to = ibl_memory_open(&memory);
    while (to && getline(&line, &room, from) > 0) {
        count = strncmp(line, "      [", 7) ? 0 : count + 1;
        if (count <= TRIPLES || !strstr(line, "],\n"))
            fputs(line, to);
    }
    char *text = to ? ibl_memory_close(to, &memory) : NULL;
    if (text && !ferror(from))
        root = ibl_json_parse(path, text, strlen(text), 0, why);
    fclose(from);
    free(line);
    free(text);
    return root;
}

json_t *ibl_sidecar_load(const char *path, ibl_json_why *why)
{
    json_t *root = load_short(path, why), *output;

    if (!root)
        root = ibl_json_load(path, 0, why);
    const char *names = json_string_value(json_object_get(root, "names"));
    size_t i;

    if (!names || strcmp(names, IBL_NAMES_ENCODED) != 0)
        return root;
    bool ok = decode_member(json_object_get(root, "source"), "path");
    json_array_foreach(json_object_get(root, "outputs"), i, output)
    {
        ok = decode_member(output, "file") && ok;
    }
    if (ok)
        return root;
    json_decref(root);
    why->status = IBL_ERR_MEMORY;
    snprintf(why->line, sizeof why->line, "%s: no memory to read it", path);
    return NULL;
}

json_t *ibl_sidecar_output(const json_t *sidecar, const char *member,
                           const char *value)
{
    json_t *output;
    size_t i;

    json_array_foreach(json_object_get(sidecar, "outputs"), i, output)
    {
        const char *found = json_string_value(json_object_get(output, member));
        if (found && !strcmp(found, value))
            return output;
    }
    return NULL;
}

int ibl_sidecar_lights(const json_t *sidecar, ibl_light light[IBL_MAX_LIGHTS])
{
    const json_t *list = json_object_get(sidecar, "lights"), *entry;
    size_t i;

    if (json_array_size(list) > IBL_MAX_LIGHTS)
        return -1;
    json_array_foreach(list, i, entry)
    {
        const json_t *radius = json_object_get(entry, "radius_rad");
        const bool ok = json_is_number(radius) &&
                        ibl_json_numbers(json_object_get(entry, "direction"),
                                         light[i].direction, 3) &&
                        ibl_json_numbers(json_object_get(entry, "irradiance"),
                                         light[i].irradiance, 3) &&
                        ibl_json_numbers(json_object_get(entry, "radiance"),
                                         light[i].radiance, 3);
        if (!ok)
            return -1;
        light[i].radius = json_number_value(radius);
    }
    return (int)json_array_size(list);
}

void ibl_sidecar_colour(const json_t *sidecar, ibl_read_options *read)
{
    const json_t *colour = json_object_get(sidecar, "colour");
    const json_t *primaries = json_object_get(colour, "primaries");
    const double exposure =
        json_number_value(json_object_get(colour, "exposure_ev"));
    const double clamp = json_number_value(json_object_get(colour, "clamp"));
    const json_t *transfer = json_object_get(colour, "transfer");
    const int curve =
        json_is_string(transfer)
            ? ibl_names_find(ibl_transfer_names, json_string_value(transfer))
            : -1;
    const int found =
        json_is_string(primaries)
            ? ibl_names_find(ibl_primaries_names, json_string_value(primaries))
            : -1;

    if (curve > 0)
        read->transfer = (ibl_transfer)curve;
    if (found > 0)
        read->primaries = (ibl_primaries)found;
    if (fabs(exposure) > 0 && fabs(exposure) <= IBL_MAX_EXPOSURE)
        read->exposure = exposure;
    if (clamp > 0)
        read->clamp = clamp;
}
