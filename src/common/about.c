/* SPDX-License-Identifier: MIT */
#include "common/about.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "common/names.h"
#include "common/option.h"

static const char *const scale_names[] = {"E/pi", "E", NULL};

const struct ibl_about_word ibl_about_words[IBL_ABOUT_WORDS] = {
    {"iblbake.content", "content", "content", NULL},
    {"iblbake.mapping", "mapping", "roughness mapping", ibl_mapping_names},
    {"iblbake.lobe", "lobe", "lobe", ibl_lobe_names},
    {"iblbake.geometry", "geometry", "geometry", ibl_geometry_names},
    {"iblbake.irradiance_scale", "scale", "irradiance scale", scale_names},
    {"iblbake.table", "table", "kind", ibl_lut_names},
    {"iblbake.mirror", "mirror", "mirror", ibl_mirror_names},
    {"iblbake.up", "up", "axis that points up", ibl_up_names},
};

/* Keys have nine digits. */
static bool is_other(double x, double y)
{
    return fabs(x - y) > 1e-6 * (1 + fabs(x));
}

static void learn_word(ibl_about *a, int i, const char *word)
{
    const char *const *names = ibl_about_words[i].names;

    if (a->word[i])
        a->differ |=
            word && i != IBL_ABOUT_CONTENT && strcmp(a->word[i], word) != 0;
    else if ((a->word[i] = word))
        a->value[i] = names ? ibl_names_find(names, word) : 0;
}

static void learn_lod(ibl_about *a, double scale, double offset)
{
    if (a->has_lod) {
        a->differ |=
            is_other(scale, a->lod_scale) || is_other(offset, a->lod_offset);
        return;
    }
    a->has_lod = true;
    a->lod_scale = scale;
    a->lod_offset = offset;
}

/* levels as in ibl_about. */
static void learn_levels(ibl_about *a, const double *roughness, int levels)
{
    if (a->levels) {
        a->differ |= levels != a->levels;
        for (int l = 0; l < levels && l < a->levels; l++)
            a->differ |= is_other(roughness[l], a->roughness[l]);
        return;
    }
    a->levels = levels;
    for (int l = 0; l < levels; l++)
        a->roughness[l] = roughness[l];
}

/* The number that text consists of; NAN if there is more or none. */
static double number(const char *text)
{
    double x;
    return ibl_number_list(text, ',', -DBL_MAX, DBL_MAX, &x, 1) ? x : NAN;
}

static void read_keys(const ibl_texture *tex, ibl_about *a)
{
    const char *scale = ibl_texture_get(tex, "iblbake.lod_scale");
    const char *offset = ibl_texture_get(tex, "iblbake.lod_offset");
    const char *list = ibl_texture_get(tex, "iblbake.roughness");
    double roughness[IBL_MAX_LEVELS];

    for (int i = 0; i < IBL_ABOUT_WORDS; i++)
        learn_word(a, i, ibl_texture_get(tex, ibl_about_words[i].key));
    if (scale && offset)
        learn_lod(a, number(scale), number(offset));
    if (list) {
        const int levels =
            ibl_number_list(list, ',', 0, 1, roughness, IBL_MAX_LEVELS);
        learn_levels(a, roughness, levels ? levels : -1);
    }
}

/* Chains of other maps have levels without roughness. */
static void read_levels(const json_t *levels, ibl_about *a)
{
    double list[IBL_MAX_LEVELS];
    const json_t *level;
    int count = (int)json_array_size(levels);
    size_t l;

    if (!json_object_get(json_array_get(levels, 0), "roughness"))
        return;
    json_array_foreach(levels, l, level)
    {
        const json_t *r = json_object_get(level, "roughness");
        const double x = json_number_value(r);
        if (l == IBL_MAX_LEVELS || !json_is_number(r) || x < 0 || x > 1) {
            count = -1;
            break;
        }
        list[l] = x;
    }
    learn_levels(a, list, count);
}

static void read_entry(const json_t *sidecar, const json_t *entry, ibl_about *a)
{
    const json_t *turned = json_object_get(sidecar, "orientation");
    const json_t *scale = json_object_get(entry, "lod_scale");
    const json_t *offset = json_object_get(entry, "lod_offset");

    for (int i = 0; i < IBL_ABOUT_WORDS; i++)
        learn_word(a, i,
                   json_string_value(
                       json_object_get(i < IBL_ABOUT_MIRROR ? entry : turned,
                                       ibl_about_words[i].member)));
    if (json_is_number(scale) && json_is_number(offset))
        learn_lod(a, json_number_value(scale), json_number_value(offset));
    read_levels(json_object_get(entry, "levels"), a);
}

void ibl_about_read(const ibl_texture *tex, const json_t *sidecar,
                    const json_t *entry, ibl_about *a)
{
    *a = (ibl_about){0};
    read_keys(tex, a);
    if (entry)
        read_entry(sidecar, entry, a);
}

bool ibl_about_fits(const ibl_about *a, const double *roughness, int levels)
{
    bool same = a->levels == levels;

    for (int l = 0; l < levels && same; l++)
        same = fabs(a->roughness[l] - roughness[l]) < 1e-6;
    return same || !a->levels;
}

ibl_axes ibl_about_axes(const ibl_about *a)
{
    return (ibl_axes){(ibl_mirror)a->value[IBL_ABOUT_MIRROR],
                      (ibl_up)a->value[IBL_ABOUT_UP]};
}
