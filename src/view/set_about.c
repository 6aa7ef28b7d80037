/* SPDX-License-Identifier: MIT */
#include "view/set_about.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/names.h"
#include "view/message.h"

static const char *const content_names[] = {"specular", "irradiance",
                                            "brdf_lut", "skybox", NULL};

const char *view_content_name(view_content content)
{
    return content_names[content];
}

const char *view_content_words(view_content content)
{
    static const char *const words[] = {"a specular chain", "an irradiance map",
                                        "a BRDF table", "a skybox"};
    return words[content];
}

/* ---- words ----------------------------------------------------------- */

/* *found is the place of a word, if it is not NULL, among the names. */
static bool find_word(view_about *a, unsigned known, const char *where,
                      const char *what, const char *const *names,
                      const char *word, int *found)
{
    char text[128];

    *found = 0;
    if (!word)
        return true;
    *found = ibl_names_find(names, word);
    a->known |= known;
    if (*found >= 0)
        return true;
    ibl_names_text(names, text, sizeof text);
    return view_fail("%s: has the %s \"%.40s\", which is none of %s: bake it "
                     "again with the iblbake of this version",
                     where, what, word, text);
}

bool view_about_words(view_about *a, const char *where, const view_words *w)
{
    static const char *const scales[] = {"E/pi", "E", NULL};
    int content, mapping, lobe, geometry, scale;

    if (!find_word(a, VIEW_KNOWS_CONTENT, where, "content", content_names,
                   w->content, &content) ||
        !find_word(a, VIEW_KNOWS_MAPPING, where, "roughness mapping",
                   ibl_mapping_names, w->mapping, &mapping) ||
        !find_word(a, VIEW_KNOWS_LOBE, where, "lobe", ibl_lobe_names, w->lobe,
                   &lobe) ||
        !find_word(a, VIEW_KNOWS_GEOMETRY, where, "geometry",
                   ibl_geometry_names, w->geometry, &geometry) ||
        !find_word(a, VIEW_KNOWS_SCALE, where, "irradiance scale", scales,
                   w->scale, &scale))
        return false;
    a->content = (view_content)content;
    a->mapping = (ibl_roughness_map)mapping;
    a->lobe = (ibl_lobe)lobe;
    a->geometry = (ibl_geometry)geometry;
    a->irradiance_scale = scale ? 1 / M_PI : 1;
    return true;
}

bool view_about_check(const view_about *a, const char *where)
{
    double last = 0;

    if (a->known & VIEW_KNOWS_LOD &&
        (!isfinite(a->lod_scale) || !isfinite(a->lod_offset) ||
         a->lod_scale < 0))
        return view_fail("%s: has lod_scale %g and lod_offset %g, which no "
                         "shader can use: bake it again",
                         where, a->lod_scale, a->lod_offset);
    for (int l = 0; a->known & VIEW_KNOWS_ROUGHNESS && l < a->levels; l++) {
        const double r = a->roughness[l];
        if (!(r >= last && r <= 1))
            return view_fail("%s: has roughness %g at level %d, which has to "
                             "be %g to 1: bake it again",
                             where, r, l, last);
        last = r;
    }
    return true;
}

/* ---- keys ------------------------------------------------------------ */

static const char *key(const ibl_texture *tex, const char *name)
{
    return ibl_texture_get(tex, name);
}

/* A number that is all of text. */
static double number(const char *text)
{
    char *end;
    const double x = strtod(text, &end);
    return end > text && !*end ? x : NAN;
}

/* "0,0.25,1". */
static bool read_roughness(view_about *a, const char *path, const char *text)
{
    if (!text)
        return true;
    for (a->levels = 0; *text; a->levels++) {
        char *end;
        const double r = strtod(text, &end);
        if (end == text || (*end && *end != ',') || a->levels == IBL_MAX_LEVELS)
            return view_fail("%s: its key iblbake.roughness is damaged at "
                             "\"%.20s\": bake it again",
                             path, text);
        a->roughness[a->levels] = r;
        text = *end ? end + 1 : end;
    }
    a->known |= VIEW_KNOWS_ROUGHNESS;
    return true;
}

bool view_about_keys(const ibl_texture *tex, const char *path, view_about *a)
{
    const char *scale = key(tex, "iblbake.lod_scale");
    const char *offset = key(tex, "iblbake.lod_offset");

    *a = (view_about){0};
    if (scale && offset) {
        a->lod_scale = number(scale);
        a->lod_offset = number(offset);
        a->known |= VIEW_KNOWS_LOD;
    }
    const view_words words = {.content = key(tex, "iblbake.content"),
                              .mapping = key(tex, "iblbake.mapping"),
                              .lobe = key(tex, "iblbake.lobe"),
                              .geometry = key(tex, "iblbake.geometry"),
                              .scale = key(tex, "iblbake.irradiance_scale")};
    return view_about_words(a, path, &words) &&
           read_roughness(a, path, key(tex, "iblbake.roughness")) &&
           view_about_check(a, path);
}

/* ---- two accounts of one file ---------------------------------------- */

void view_about_add(view_about *a, const view_about *from)
{
    const unsigned added = from->known & ~a->known;

    if (added & VIEW_KNOWS_CONTENT)
        a->content = from->content;
    if (added & VIEW_KNOWS_MAPPING)
        a->mapping = from->mapping;
    if (added & VIEW_KNOWS_LOD) {
        a->lod_scale = from->lod_scale;
        a->lod_offset = from->lod_offset;
    }
    if (added & VIEW_KNOWS_ROUGHNESS) {
        memcpy(a->roughness, from->roughness, sizeof a->roughness);
        a->levels = from->levels;
    }
    if (added & VIEW_KNOWS_LOBE)
        a->lobe = from->lobe;
    if (added & VIEW_KNOWS_GEOMETRY)
        a->geometry = from->geometry;
    if (added & VIEW_KNOWS_SCALE)
        a->irradiance_scale = from->irradiance_scale;
    a->known |= added;
}

/* Keys have nine digits. */
static bool apart(double a, double b)
{
    return fabs(a - b) > 1e-6 * (1 + fabs(a));
}

bool view_about_differ(const view_about *a, const view_about *b)
{
    const unsigned both = a->known & b->known;
    bool differ = false;

    if (both & VIEW_KNOWS_MAPPING)
        differ |= a->mapping != b->mapping;
    if (both & VIEW_KNOWS_LOD)
        differ |= apart(a->lod_scale, b->lod_scale) ||
                  apart(a->lod_offset, b->lod_offset);
    if (both & VIEW_KNOWS_ROUGHNESS) {
        differ |= a->levels != b->levels;
        for (int l = 0; l < a->levels && l < b->levels; l++)
            differ |= apart(a->roughness[l], b->roughness[l]);
    }
    if (both & VIEW_KNOWS_LOBE)
        differ |= a->lobe != b->lobe;
    if (both & VIEW_KNOWS_GEOMETRY)
        differ |= a->geometry != b->geometry;
    if (both & VIEW_KNOWS_SCALE)
        differ |= apart(a->irradiance_scale, b->irradiance_scale);
    return differ;
}
