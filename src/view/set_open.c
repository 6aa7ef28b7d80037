/* SPDX-License-Identifier: MIT */
/* Reading the files of a set, and what they say together. */
#include "view/baked_set.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common/names.h"
#include "view/message.h"
#include "view/set_find.h"

/* ---- the other files -------------------------------------------------- */

/* A set in the making. */
typedef struct opener {
    ibl_ctx *ctx;
    baked_set *set;
    view_sidecar *sidecar;
    char *directory; /* with its slash, or "" */
    char *extension; /* of the specular file */
    bool told;       /* that nothing is known of how the set was baked */
} opener;

static bool is_file(const char *path)
{
    struct stat st;
    return !stat(path, &st) && S_ISREG(st.st_mode);
}

/* DIRECTORY/NAME_content.EXTENSION; the table has no NAME but a stem by its
 * geometry. */
static char *usual_path(const opener *o, view_content content, int geometry,
                        const char *extension)
{
    if (content == VIEW_LUT)
        return view_file_print("%s%s.%s", o->directory, ibl_lut_stems[geometry],
                               extension);
    return view_file_print("%s%s_%s.%s", o->directory, o->set->name,
                           view_content_name(content), extension);
}

/* Takes path over. False: no memory for it. */
static bool try_path(const opener *o, char *path, char **out)
{
    if (!path)
        return view_file_no_memory(o->set->name);
    if (is_file(path))
        *out = path;
    else
        free(path);
    return true;
}

/* Where a content's file is: as the sidecar says, as iblbake names it beside
 * the specular file, then with other extensions. *out NULL: nowhere. */
static bool find_beside(const opener *o, view_content content, char **out)
{
    const char *told = view_sidecar_file(o->sidecar, content);
    const int stems = content == VIEW_LUT ? 2 : 1;

    *out = NULL;
    if (told && !try_path(o, view_file_print("%s%s", o->directory, told), out))
        return false;
    for (int s = 0; s < stems; s++)
        for (int i = -1; i < IBL_CONTAINER_COUNT && !*out; i++) {
            const char *extension =
                i < 0 ? o->extension : ibl_container_name((ibl_container)i);
            if (!try_path(o, usual_path(o, content, s, extension), out))
                return false;
        }
    return true;
}

/* ---- what fits -------------------------------------------------------- */

/* What to do about a file that is not what it was taken for. */
static const char *remedy(view_content wanted)
{
    static const char *const words[] = {
        "name the NAME_specular file, and others with --irradiance and --lut",
        "name the NAME_irradiance file, or leave --irradiance out",
        "name the brdf_lut file, or leave --lut out",
        "name the NAME_skybox file or another cube, or leave --sky out"};
    return words[wanted];
}

static bool check_shape(const ibl_texture *tex, const char *path,
                        view_content wanted)
{
    const char *pixel = ibl_pixel_name(tex->pixel);
    const bool lut = wanted == VIEW_LUT;

    if ((tex->faces == 1) != lut)
        return view_fail("%s: is a %s (%dx%d, %s), where %s is wanted: %s",
                         path, lut ? "cube" : "flat texture", tex->width,
                         tex->height, pixel, view_content_words(wanted),
                         remedy(wanted));
    if ((ibl_pixel_channels(tex->pixel) == 2) != lut)
        return view_fail("%s: has %s texels, where %s has %s: %s", path, pixel,
                         view_content_words(wanted),
                         lut ? "two channels, rg16f or rg32f" : "colour",
                         remedy(wanted));
    if (tex->layers > 1)
        return view_fail(
            "%s: is an array of %d layers, of a probe set perhaps, "
            "where a single texture is wanted: %s",
            path, tex->layers, remedy(wanted));
    if (lut && tex->width != tex->height)
        return view_fail("%s: is %dx%d, where a BRDF table is square: %s", path,
                         tex->width, tex->height, remedy(wanted));
    if (tex->width > IBL_MAX_CUBE_SIZE)
        return view_fail("%s: is %dx%d, more than %d: bake it smaller", path,
                         tex->width, tex->height, IBL_MAX_CUBE_SIZE);
    return true;
}

/* By its keys, the sidecar or, last, the name. Any cube does for a sky. */
static bool check_content(const opener *o, const char *path,
                          view_content wanted, const view_about *keys)
{
    view_content found = view_sidecar_content(o->sidecar, view_file_name(path));

    if (keys->known & VIEW_KNOWS_CONTENT) {
        found = keys->content;
    } else if (found == VIEW_CONTENTS) {
        char *stem = view_set_stem(path);
        size_t length;
        if (!stem)
            return view_file_no_memory(path);
        found = view_file_content(stem, &length);
        free(stem);
    }
    if (found == VIEW_CONTENTS || found == wanted || wanted == VIEW_SKY)
        return true;
    return view_fail("%s: holds %s, where %s is wanted: %s", path,
                     view_content_words(found), view_content_words(wanted),
                     remedy(wanted));
}

/* Reads a file as that content, and what is known of it. Takes path over. */
static bool load(opener *o, view_content content, char *path, view_about *about)
{
    ibl_texture *tex = &o->set->texture[content];
    view_about said = {0};
    const char *words;

    o->set->path[content] = path;
    const view_file_kind kind = view_file_look(path, &words);
    if (kind == VIEW_FILE_MISSING)
        return view_fail("%s: cannot be opened: %s", path, strerror(errno));
    if (kind != VIEW_FILE_TEXTURE && kind != VIEW_FILE_PIPE)
        return view_fail("%s: is %s, where %s (KTX2, KTX or DDS) is wanted: %s",
                         path, words, view_content_words(content),
                         remedy(content));
    view_stamp_read(o->set, content);
    if (ibl_texture_read(o->ctx, path, tex, NULL))
        return false;
    if (!check_shape(tex, path, content) ||
        !view_about_keys(tex, path, about) ||
        !check_content(o, path, content, about))
        return false;
    const char *listed = view_sidecar_file(o->sidecar, content);
    if (!listed || strcmp(listed, view_file_name(path)) != 0)
        return true;
    if (!view_sidecar_about(o->sidecar, content, &said))
        return false;
    if (view_about_differ(about, &said))
        view_note("%s: does not say what %s says of it: taken as the file says",
                  path, o->set->sidecar);
    view_about_add(about, &said);
    return true;
}

/* ---- the specular chain ----------------------------------------------- */

/* A sidecar beside a file of other size tells of another bake. */
static bool check_sidecar_shape(const opener *o)
{
    const ibl_texture *tex = &o->set->texture[VIEW_SPECULAR];
    const char *path = o->set->path[VIEW_SPECULAR];
    const char *listed = view_sidecar_file(o->sidecar, VIEW_SPECULAR);
    int width, levels;

    if (!listed || strcmp(listed, view_file_name(path)) != 0 ||
        !view_sidecar_shape(o->sidecar, VIEW_SPECULAR, &width, &levels) ||
        (width == tex->width && levels == tex->levels))
        return true;
    return view_fail("%s: has %d levels from %d texels, but %s tells of %d "
                     "from %d: bake the set again, or take that file away",
                     path, tex->levels, tex->width, o->set->sidecar, levels,
                     width);
}

/* Says once that a file does not tell how it was baked. */
static void note_defaults(opener *o, bool cmgen)
{
    if (!o->told)
        view_note("%s: does not say how it was baked: taken as GGX, %s "
                  "mapping%s, roughness 0 to 1",
                  o->set->path[VIEW_SPECULAR],
                  ibl_roughness_map_name(o->set->mapping),
                  cmgen ? " as cmgen has it" : "");
    o->told = true;
}

/* What the spheres cannot make up for. */
static void note_misfits(const baked_set *set)
{
    if (set->lobe != IBL_LOBE_GGX)
        view_note("%s: its levels are of the lobe %s: spheres, which are "
                  "shaded by GGX, are only similar",
                  set->path[VIEW_SPECULAR], ibl_lobe_name(set->lobe));
    if (set->roughness[0] > 0)
        view_note("%s: its level 0 is of roughness %.3g: the reference and a "
                  "sky without a skybox are as blurred",
                  set->path[VIEW_SPECULAR], set->roughness[0]);
}

static bool take_specular(opener *o, const view_about *a)
{
    baked_set *set = o->set;
    const ibl_texture *tex = &set->texture[VIEW_SPECULAR];
    const bool cmgen = !a->known && ibl_texture_get(tex, "sh");

    set->mapping = a->known & VIEW_KNOWS_MAPPING ? a->mapping
                   : cmgen                       ? IBL_ROUGHNESS_FILAMENT
                                                 : IBL_ROUGHNESS_LINEAR;
    set->lobe = a->known & VIEW_KNOWS_LOBE ? a->lobe : IBL_LOBE_GGX;
    set->lod_scale = tex->levels - 1;
    set->lod_offset = 0;
    for (int l = 0; l < tex->levels; l++)
        set->roughness[l] = ibl_level_roughness(set->mapping, l, tex->levels);
    if (!(a->known & VIEW_KNOWS_MAPPING))
        note_defaults(o, cmgen);
    if (a->known & VIEW_KNOWS_LOD) {
        set->lod_scale = a->lod_scale;
        set->lod_offset = a->lod_offset;
    }
    if (a->known & VIEW_KNOWS_ROUGHNESS && a->levels != tex->levels)
        return view_fail("%s: says the roughness of %d levels and has %d: "
                         "bake it again",
                         set->path[VIEW_SPECULAR], a->levels, tex->levels);
    if (a->known & VIEW_KNOWS_ROUGHNESS)
        memcpy(set->roughness, a->roughness, sizeof set->roughness);
    note_misfits(set);
    return true;
}

/* Directory, name, extension and sidecar of a specular file. */
static bool name_parts(opener *o, const char *path)
{
    const char *name = view_file_name(path), *dot = strrchr(name, '.');
    baked_set *set = o->set;

    o->directory = strndup(path, (size_t)(name - path));
    o->extension = strdup(dot ? dot + 1 : "ktx2");
    set->name = view_set_stem(path);
    if (!o->directory || !o->extension || !set->name)
        return view_file_no_memory(path);
    size_t length;
    view_file_content(set->name, &length);
    if (length)
        set->name[length] = '\0';
    set->sidecar = view_file_print("%s%s.json", o->directory, set->name);
    if (!set->sidecar)
        return view_file_no_memory(path);
    view_stamp_read(set, VIEW_CONTENTS);
    if (!view_sidecar_open(set->sidecar, &o->sidecar))
        return false;
    if (!o->sidecar) {
        free(set->sidecar);
        set->sidecar = NULL;
    }
    return true;
}

static bool open_specular(opener *o, const char *path)
{
    char *found = view_file_specular(path);
    view_about about;

    if (!found)
        return false;
    if (!name_parts(o, found)) {
        free(found);
        return false;
    }
    return load(o, VIEW_SPECULAR, found, &about) && check_sidecar_shape(o) &&
           take_specular(o, &about);
}

/* ---- all of it -------------------------------------------------------- */

/* One that is named, or lies beside; nothing is no failure. */
static bool open_other(opener *o, view_content content, const char *named)
{
    baked_set *set = o->set;
    view_about about;
    char *path;

    if (named) {
        if (!(path = strdup(named)))
            return view_file_no_memory(named);
    } else if (!find_beside(o, content, &path)) {
        return false;
    }
    if (!path)
        return true;
    if (!load(o, content, path, &about))
        return false;
    if (content == VIEW_LUT) {
        set->geometry =
            about.known & VIEW_KNOWS_GEOMETRY ? about.geometry : set->geometry;
        if (!(about.known & VIEW_KNOWS_GEOMETRY))
            view_note("%s: does not say its geometry: taken as %s", path,
                      ibl_geometry_name(set->geometry));
    }
    if (content == VIEW_IRRADIANCE) {
        if (about.known & VIEW_KNOWS_SCALE)
            set->irradiance_scale = about.irradiance_scale;
        else
            view_note("%s: does not say its scale: taken as irradiance / pi",
                      path);
    }
    return true;
}

bool view_set_open(ibl_ctx *ctx, const view_request *what, baked_set *set)
{
    opener o = {.ctx = ctx, .set = set};

    *set = (baked_set){.sh_degree = -1, .irradiance_scale = 1};
    const bool ok = open_specular(&o, what->path) &&
                    open_other(&o, VIEW_IRRADIANCE, what->irradiance) &&
                    open_other(&o, VIEW_LUT, what->lut) &&
                    open_other(&o, VIEW_SKY, what->sky) &&
                    view_sidecar_sh(o.sidecar, set);
    if (ok && !set->texture[VIEW_LUT].data)
        view_note("%s: has no BRDF table: made with the geometry %s", set->name,
                  ibl_geometry_name(IBL_GEOMETRY_SMITH));
    if (ok)
        set->peak = view_set_peak(set);
    const bool filled = ok && view_set_fill(ctx, set);
    view_sidecar_free(o.sidecar);
    free(o.directory);
    free(o.extension);
    if (!filled)
        view_set_free(set);
    return filled;
}

void view_set_free(baked_set *set)
{
    for (int i = 0; i < VIEW_CONTENTS; i++) {
        ibl_texture_free(&set->texture[i]);
        free(set->path[i]);
    }
    free(set->name);
    free(set->sidecar);
    free(set->map);
    *set = (baked_set){0};
}

double view_set_lod(const baked_set *set, double roughness)
{
    const double r = roughness;
    const double x = set->mapping == IBL_ROUGHNESS_LINEAR ? r : r * (2 - r);
    const double lod = x * set->lod_scale + set->lod_offset;
    const double last = set->texture[VIEW_SPECULAR].levels - 1;
    return lod < 0 ? 0 : lod < last ? lod : last;
}
