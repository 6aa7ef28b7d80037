/* SPDX-License-Identifier: MIT */
/* How a file was baked, from its keys or from iblbake's NAME.json. */
#include "view/set_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common/names.h"
#include "common/path.h"
#include "common/sidecar.h"
#include "engine/set.h"
#include "view/message.h"

const char *const view_content_names[VIEW_CONTENTS + 1] = {
    "specular", "irradiance",       "brdf_lut",     "skybox",
    "lobe_lut", "charlie_specular", "charlie_table"};

/* ---- how a file was baked ------------------------------------------------ */

static bool check_words(const ibl_about *a, const ibl_texture *tex,
                        const char *path, const char *sidecar)
{
    char text[128];

    for (int i = 0; i < IBL_ABOUT_WORDS; i++) {
        const struct ibl_about_word *of = &ibl_about_words[i];
        if (a->value[i] >= 0)
            continue;
        ibl_names_text(of->names, text, sizeof text);
        return view_fail("%s: has the %s \"%.40s\", which is none of %s: bake "
                         "it again with the iblbake of this version",
                         ibl_texture_get(tex, of->key) ? path : sidecar,
                         of->what, a->word[i], text);
    }
    return true;
}

static bool check_numbers(const ibl_about *a, const char *where)
{
    double last = 0;

    if (!isfinite(a->lod_scale) || !isfinite(a->lod_offset) || a->lod_scale < 0)
        return view_fail("%s: has lod_scale %g and lod_offset %g, which no "
                         "shader can use: bake it again",
                         where, a->lod_scale, a->lod_offset);
    if (a->levels < 0)
        return view_fail("%s: the list of the roughness of its levels is "
                         "damaged: bake it again",
                         where);
    for (int l = 0; l < a->levels; last = a->roughness[l++])
        if (a->roughness[l] < last)
            return view_fail("%s: has roughness %g at level %d, which has to "
                             "be %g to 1: bake it again",
                             where, a->roughness[l], l, last);
    return true;
}

/* The string of a member, or NULL. */
static const char *text_of(const json_t *object, const char *name)
{
    return json_string_value(json_object_get(object, name));
}

static bool damaged(const char *path, const char *what)
{
    return view_fail("%s: %s: bake the set again, or take the file away", path,
                     what);
}

/* Checks edge and levels of a chain; flat ones are as high as the cube that
 * they are shown by. A sidecar with another size than its file belongs to
 * another bake. */
static bool check_shape(const json_t *entry, const char *sidecar,
                        const ibl_texture *tex, const char *path)
{
    const json_t *edge = json_object_get(entry, "height");
    const json_t *chain = json_object_get(entry, "levels");
    const json_int_t height = json_integer_value(edge);
    const size_t levels = json_array_size(chain);

    if (!json_is_integer(edge) || !json_is_array(chain) ||
        (height == tex->height && levels == (size_t)tex->levels))
        return true;
    return view_fail("%s: has %d levels from %d texels, but %s tells of %zu "
                     "from %lld: bake the set again, or take that file away",
                     path, tex->levels, tex->height, sidecar, levels,
                     (long long)height);
}

/* ---- the sidecar ------------------------------------------------------- */

bool view_sidecar_open(const char *path, json_t **root)
{
    ibl_json_why why;
    struct stat st;

    *root = NULL;
    if (stat(path, &st) || !S_ISREG(st.st_mode))
        return true;
    json_t *read = ibl_sidecar_load(path, &why);
    if (!read)
        return view_fail("%s%s", why.line,
                         why.status == IBL_ERR_FORMAT
                             ? ": bake the set again, or take the file away"
                             : "");
    const char *writer = text_of(json_object_get(read, "generator"), "name");
    if (writer && !strcmp(writer, "iblbake")) {
        *root = read;
        return true;
    }
    view_note("%s: was not written by iblbake and is left out", path);
    json_decref(read);
    return true;
}

const char *view_sidecar_file(const json_t *root, view_content content)
{
    const char *word = view_content_names[content];
    const json_t *entry = ibl_sidecar_output(root, "content", word);
    const char *file = text_of(entry, "file"), *table = text_of(entry, "table");

    if (table) {
        view_note("%s: a table of kind %.40s: not used", file ? file : word,
                  table);
        return NULL;
    }
    return file && *file && !strchr(file, '/') ? file : NULL;
}

static bool take_sh(ibl_ctx *ctx, const json_t *root, ibl_axes axes,
                    baked_set *set)
{
    const json_t *sh = json_object_get(root, "sh");
    const json_t *radiance = json_object_get(sh, "radiance");
    const json_t *degree = json_object_get(sh, "degree");
    double values[3 * VIEW_SH_COUNT];

    if (!sh)
        return true;
    const json_int_t most = json_integer_value(degree);
    const int used = most < VIEW_SH_DEGREE ? (int)most : VIEW_SH_DEGREE;
    if (!json_is_integer(degree) || most < 0 ||
        json_array_size(radiance) < (size_t)((used + 1) * (used + 1)))
        return damaged(set->path[VIEW_SIDECAR],
                       "its harmonics are not as many as their degree says");
    for (int i = 0; i < 3 * (used + 1) * (used + 1); i += 3)
        if (!ibl_json_numbers(json_array_get(radiance, (size_t)i / 3),
                              values + i, 3))
            return damaged(set->path[VIEW_SIDECAR],
                           "its harmonics are not all numbers");
    if (ibl_sh_turn_axes(ctx, used, axes, 1, values))
        return false;
    view_set_harmonics(set, used, values);
    return true;
}

static bool take_lights(const json_t *root, ibl_axes axes, baked_set *set)
{
    set->light_count = ibl_sidecar_lights(root, set->light);
    for (int i = 0; i < set->light_count; i++)
        ibl_axes_turn(axes, 1, set->light[i].direction,
                      set->light[i].direction);
    return set->light_count >= 0 ||
           damaged(set->path[VIEW_SIDECAR], "its lights are not such");
}

/* As iblbake found it, AUTO if that is not known. */
static ibl_input_layout source_layout(const json_t *source)
{
    const char *name = text_of(source, "layout");
    const int i = name ? ibl_names_find(ibl_input_names, name) : -1;

    return i < 0 ? IBL_INPUT_AUTO : (ibl_input_layout)i;
}

/* Where it was for iblbake, or beside the sidecar; six files only where they
 * were. */
static bool take_source(const json_t *root, baked_set *set)
{
    const char *side = set->path[VIEW_SIDECAR];
    const json_t *source = json_object_get(root, "source");
    const char *path = text_of(source, "path");
    const char *hash = text_of(source, "xxh3_128");

    set->source_peak = json_number_value(json_object_get(source, "peak"));
    snprintf(set->source_hash, sizeof set->source_hash, "%s", hash ? hash : "");
    set->source_yaw = json_number_value(
        json_object_get(json_object_get(root, "orientation"), "yaw_deg"));
    set->source_read = ibl_read_options_default();
    set->source_read.env = ibl_env_decode;
    ibl_sidecar_colour(root, &set->source_read);
    set->source_read.layout = source_layout(source);
    const char *order = text_of(source, "face_order");
    if (order && !ibl_face_order_parse(order, set->source_read.face_order))
        memset(set->source_read.face_order, 0, IBL_FACES);
    if (path && set->source_read.layout == IBL_INPUT_FACES) {
        set->source = strdup(path);
        return set->source || view_file_no_memory(path);
    }
    return !path || (view_file_take(strdup(path), path, &set->source) &&
                     (set->source ||
                      view_file_take(ibl_path_beside(side, ibl_path_name(path)),
                                     path, &set->source)));
}

bool view_sidecar_read(ibl_ctx *ctx, const json_t *root, ibl_axes axes,
                       baked_set *set)
{
    set->sh_degree = -1;
    return take_sh(ctx, root, axes, set) && take_lights(root, axes, set) &&
           take_source(root, set);
}

bool view_about_read(const baked_set *set, view_content content,
                     const json_t *sidecar, ibl_about *a)
{
    const ibl_texture *tex = &set->texture[content];
    const char *path = set->path[content], *side = set->path[VIEW_SIDECAR];
    const json_t *entry =
        ibl_sidecar_output(sidecar, "file", ibl_path_name(path));

    ibl_about_read(tex, sidecar, entry, a);
    if (!check_words(a, tex, path, side) ||
        !check_numbers(a, tex->key_count ? path : side))
        return false;
    if (a->differ)
        view_note("%s: does not say what %s says of it: taken as the file says",
                  path, side);
    return content != VIEW_SPECULAR || check_shape(entry, side, tex, path);
}
