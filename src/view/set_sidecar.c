/* SPDX-License-Identifier: MIT */
/* NAME.json, as iblbake writes it. */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common/sidecar_load.h"
#include "view/message.h"
#include "view/set_about.h"

struct view_sidecar {
    char *path;
    json_t *root;
};

/* The string of a member, or NULL. */
static const char *text(const json_t *object, const char *name)
{
    return json_string_value(json_object_get(object, name));
}

static bool damaged(const view_sidecar *s, const char *what)
{
    return view_fail("%s: %s: bake the set again, or take the file away",
                     s->path, what);
}

bool view_sidecar_open(const char *path, view_sidecar **out)
{
    ibl_json_why why;
    struct stat st;
    view_sidecar *s;

    *out = NULL;
    if (stat(path, &st) || !S_ISREG(st.st_mode))
        return true;
    s = calloc(1, sizeof *s);
    if (!s || !(s->path = strdup(path))) {
        free(s);
        return view_fail("%s: no memory to read it", path);
    }
    s->root = ibl_sidecar_load(path, &why);
    if (!s->root) {
        view_fail("%s%s", why.line,
                  why.damaged ? ": bake the set again, or take the file away"
                              : "");
        view_sidecar_free(s);
        return false;
    }
    const char *writer = text(json_object_get(s->root, "generator"), "name");
    if (!writer || strcmp(writer, "iblbake") != 0) {
        view_note("%s: was not written by iblbake and is left out", path);
        view_sidecar_free(s);
        return true;
    }
    *out = s;
    return true;
}

void view_sidecar_free(view_sidecar *s)
{
    if (!s)
        return;
    json_decref(s->root);
    free(s->path);
    free(s);
}

static json_t *find(const view_sidecar *s, const char *member,
                    const char *value)
{
    json_t *outputs = json_object_get(s->root, "outputs"), *output;
    size_t i;

    json_array_foreach(outputs, i, output)
    {
        const char *found = text(output, member);
        if (found && !strcmp(found, value))
            return output;
    }
    return NULL;
}

static json_t *find_content(const view_sidecar *s, view_content content)
{
    return s ? find(s, "content", view_content_name(content)) : NULL;
}

const char *view_sidecar_file(const view_sidecar *s, view_content content)
{
    const char *file = text(find_content(s, content), "file");
    /* A name, never a way to somewhere else. */
    return file && *file && !strchr(file, '/') ? file : NULL;
}

view_content view_sidecar_content(const view_sidecar *s, const char *file)
{
    const char *content = s ? text(find(s, "file", file), "content") : NULL;

    for (int i = 0; content && i < VIEW_CONTENTS; i++)
        if (!strcmp(content, view_content_name((view_content)i)))
            return (view_content)i;
    return VIEW_CONTENTS;
}

bool view_sidecar_shape(const view_sidecar *s, view_content content, int *width,
                        int *levels)
{
    const json_t *output = find_content(s, content);
    const json_t *edge = json_object_get(output, "width");
    const json_t *chain = json_object_get(output, "levels");

    if (!json_is_integer(edge) || !json_is_array(chain))
        return false;
    const json_int_t found = json_integer_value(edge);
    *width = found > 0 && found <= IBL_MAX_CUBE_SIZE ? (int)found : 0;
    *levels = json_array_size(chain) <= 64 ? (int)json_array_size(chain) : 0;
    return true;
}

static bool read_roughness(const view_sidecar *s, const json_t *levels,
                           view_about *a)
{
    const size_t count = json_array_size(levels);

    if (!json_object_get(json_array_get(levels, 0), "roughness"))
        return true;
    if (count > IBL_MAX_LEVELS)
        return damaged(s, "has more levels than a chain can have");
    for (size_t l = 0; l < count; l++) {
        const json_t *r =
            json_object_get(json_array_get(levels, l), "roughness");
        if (!json_is_number(r))
            return damaged(s, "has a level without roughness");
        a->roughness[l] = json_number_value(r);
    }
    a->levels = (int)count;
    a->known |= VIEW_KNOWS_ROUGHNESS;
    return true;
}

bool view_sidecar_about(const view_sidecar *s, view_content content,
                        view_about *a)
{
    const json_t *output = find_content(s, content);

    *a = (view_about){0};
    if (!output)
        return true;
    const json_t *scale = json_object_get(output, "lod_scale");
    const json_t *offset = json_object_get(output, "lod_offset");
    if (json_is_number(scale) && json_is_number(offset)) {
        a->lod_scale = json_number_value(scale);
        a->lod_offset = json_number_value(offset);
        a->known |= VIEW_KNOWS_LOD;
    }
    const view_words words = {.content = text(output, "content"),
                              .mapping = text(output, "mapping"),
                              .lobe = text(output, "lobe"),
                              .geometry = text(output, "geometry"),
                              .scale = text(output, "scale")};
    return view_about_words(a, s->path, &words) &&
           read_roughness(s, json_object_get(output, "levels"), a) &&
           view_about_check(a, s->path);
}

bool view_sidecar_sh(const view_sidecar *s, baked_set *set)
{
    const json_t *sh = s ? json_object_get(s->root, "sh") : NULL;
    const json_t *radiance = json_object_get(sh, "radiance");
    const json_t *degree = json_object_get(sh, "degree");

    set->sh_degree = -1;
    if (!sh)
        return true;
    const json_int_t most = json_integer_value(degree);
    if (!json_is_integer(degree) || most < 0 || most > IBL_MAX_SH_DEGREE ||
        json_array_size(radiance) != (size_t)((most + 1) * (most + 1)))
        return damaged(s, "its harmonics are not as many as their degree says");
    const int used = most < VIEW_SH_DEGREE ? (int)most : VIEW_SH_DEGREE;
    for (int l = 0, i = 0; l <= used; l++) {
        for (int m = -l; m <= l; m++, i++) {
            const json_t *rgb = json_array_get(radiance, (size_t)i);
            for (int c = 0; c < 3; c++) {
                const json_t *x = json_array_get(rgb, (size_t)c);
                if (!json_is_number(x))
                    return damaged(s, "its harmonics are not all numbers");
                set->sh[3 * i + c] = json_number_value(x) * ibl_sh_cosine(l);
            }
        }
    }
    set->sh_degree = used;
    return true;
}
