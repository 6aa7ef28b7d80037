/* SPDX-License-Identifier: MIT */
/* Finds the files of a set, reads them, and what they and a sidecar say. */
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common/names.h"
#include "common/path.h"
#include "core/alloc.h"
#include "core/context.h"
#include "engine/engine.h"
#include "engine/set.h"
#include "image/axes.h"
#include "set/about.h"
#include "json/json_text.h"

enum {
    PATH_BYTES = 4096
};

typedef struct opener {
    ibl_ctx *ctx;
    ibl_set_options o;
    ibl_about asked, all; /* of the program; of the environment */
    ibl_set *set;
    const char *path;        /* as given; NULL: only files of the options */
    char folder[PATH_BYTES]; /* of the set, with a slash, or "" */
    int named;               /* the content of the texture that path is; -1 */
    json_t *sidecar;         /* or index of probes; NULL: none */
    const json_t *entry[IBL_CONTENTS]; /* what it says of a file; NULL: nothing
                                        */
} opener;

static const struct {
    const char *what;     /* for messages */
    const char *stems[5]; /* of files; behind the name if they begin with _ */
} contents[IBL_CONTENTS] = {
    [IBL_CONTENT_SKYBOX] = {"a skybox (a cube or a flat map, one layer)",
                            {"_skybox"}},
    [IBL_CONTENT_SPECULAR] = {"a specular chain (a cube or a flat map, one "
                              "layer)",
                              {"_specular"}},
    [IBL_CONTENT_IRRADIANCE] = {"an irradiance map (a cube or a flat map, one "
                                "layer)",
                                {"_irradiance"}},
    [IBL_CONTENT_LUT] = {"a BRDF table (flat, square, two channels, of "
                         "multiscatter three)",
                         {"brdf_lut", "brdf_lut_schlick-ibl",
                          "brdf_lut_multiscatter", "brdf_lut_charlie"}},
    [IBL_CONTENT_LOBE_TABLE] = {"a lobe table (flat, square, two or four "
                                "layers of rgba16f or rgba32f)",
                                {"_lobe_lut", "lobe_lut"}},
};

ibl_set_options ibl_set_options_default(void)
{
    return (ibl_set_options){.layer = -1};
}

/* Copies the first bytes of a text. */
static ibl_status keep(const opener *o, const char *text, size_t length,
                       char **to)
{
    ibl_free(*to);
    *to = ibl_alloc_zeroed(length + 1, 1);
    if (!*to)
        return ibl_no_memory(o->ctx, "names of a set");
    memcpy(*to, text, length);
    return IBL_OK;
}

/* ---- finding ----------------------------------------------------------- */

static bool is_there(const char *path)
{
    struct stat st;
    return !stat(path, &st) && !S_ISDIR(st.st_mode);
}

/* Prints the path of a file in the folder. Whether it is there. */
static bool beside(const opener *o, char path[PATH_BYTES], const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
static bool beside(const opener *o, char path[PATH_BYTES], const char *fmt, ...)
{
    const size_t used = strlen(o->folder);
    va_list ap;

    va_start(ap, fmt);
    memcpy(path, o->folder, used + 1);
    const int more = vsnprintf(path + used, PATH_BYTES - used, fmt, ap);
    va_end(ap);
    return more >= 0 && (size_t)more < PATH_BYTES - used && is_there(path);
}

/* The content that a file's name says, and the bytes of the set's name in it;
 * -1: it says none, and all before the extension is its name. */
static int content_of(const char *name, size_t *length)
{
    const char *dot = strrchr(name, '.');
    const size_t all = dot && dot > name ? (size_t)(dot - name) : strlen(name);
    const ibl_engine engine = ibl_engine_of_name(name);

    for (int c = 0; c < IBL_CONTENTS && !engine; c++)
        for (const char *const *stem = contents[c].stems; *stem; stem++) {
            const size_t n = strlen(*stem);
            if ((**stem == '_' ? all > n : all == n) &&
                !memcmp(name + all - n, *stem, n)) {
                *length = all - n;
                return c;
            }
        }
    *length = engine ? strlen(name) - strlen(ibl_engine_suffix(engine)) : all;
    return engine ? IBL_CONTENT_SPECULAR : -1;
}

/* Whether a file is a map of a set, and not its sheen. */
static bool is_map(const char *name)
{
    static const char sheen[] = "_charlie";
    const char *dot = strrchr(name, '.');
    size_t n;
    const int content = content_of(name, &n);

    return *name != '.' && dot && content >= 0 && content < IBL_CONTENT_LUT &&
           (ibl_engine_of_name(name) ||
            ibl_names_find(ibl_array_container_names, dot + 1) >= 0) &&
           (n < strlen(sheen) ||
            memcmp(name + n - strlen(sheen), sheen, strlen(sheen)) != 0);
}

static ibl_status no_set(const opener *o)
{
    const char *name = o->set->name ? o->set->name : "NAME";

    return ibl_fail(
        o->ctx, IBL_ERR_IO,
        "%s: has no %s_specular, _irradiance or _skybox (.ktx2, "
        ".ktx, .dds), nor an engine's file (.env, .gltf, "
        "_envatlas.png): bake a map into it (iblbake MAP -o %s), or "
        "give another name or directory",
        o->path, name, o->path);
}

/* Finds the name of the only set in a directory. */
static ibl_status find_name(const opener *o)
{
    char **list;
    const int count = ibl_path_list(o->path, is_map, &list);
    size_t first = 0, last = 0;
    ibl_status status;

    if (count > 0) {
        content_of(list[0], &first);
        content_of(list[count - 1], &last);
    }
    if (count < 0)
        status = ibl_fail(o->ctx, IBL_ERR_IO, "%s: cannot be read: %s", o->path,
                          strerror(errno));
    else if (!count)
        status = no_set(o);
    else if (first != last || memcmp(list[0], list[count - 1], first) != 0)
        status =
            ibl_fail(o->ctx, IBL_ERR_IO,
                     "%s: holds several sets, from %.*s to %.*s: name one "
                     "of their files",
                     o->path, (int)first, list[0], (int)last, list[count - 1]);
    else
        status = keep(o, list[0], first, &o->set->name);
    for (int i = 0; i < count; i++)
        free(list[i]);
    free(list);
    return status;
}

/* Reads a sidecar, or an index of probes. */
static ibl_status read_sidecar(opener *o, const char *path)
{
    ibl_json_why why;
    const char *writer;

    json_t *root = ibl_json_load(path, 0, &why);
    if (!root)
        return ibl_fail(o->ctx, why.status, "%s%s", why.line,
                        why.status == IBL_ERR_FORMAT
                            ? ": bake the set again, or take the file away"
                            : "");
    if (!json_unpack(root, "{s:{s:s}}", "generator", "name", &writer) &&
        !strcmp(writer, "iblbake")) {
        o->sidecar = root;
        return keep(o, path, strlen(path), &o->set->sidecar);
    }
    json_decref(root);
    ibl_warn(o->ctx, "%s: was not written by iblbake and is left out", path);
    return IBL_OK;
}

/* Finds folder, name and sidecar of a set. */
static ibl_status locate(opener *o)
{
    const char *path = o->path, *file = ibl_path_name(path);
    const char *dot = strrchr(file, '.'), *name = o->o.name;
    char side[PATH_BYTES];
    ibl_status status = IBL_OK;
    size_t length = strlen(path);
    struct stat st;

    if (length > PATH_BYTES - 2 || stat(path, &st))
        return ibl_fail(o->ctx, IBL_ERR_IO,
                        "%s: cannot be opened: %s: name a directory, a sidecar "
                        "or a texture of a set",
                        path, strerror(errno));
    const bool directory = S_ISDIR(st.st_mode);
    snprintf(o->folder, PATH_BYTES, "%.*s%s",
             (int)(directory ? length : (size_t)(file - path)), path,
             directory && *file ? "/" : "");
    if (directory) {
        if (!name && beside(o, side, "index.json"))
            name = "index";
        status =
            name ? keep(o, name, strlen(name), &o->set->name) : find_name(o);
    } else {
        const int content = content_of(file, &length);
        if (!dot || strcmp(dot, ".json") != 0)
            o->named = content < 0 ? IBL_CONTENT_SPECULAR : content;
        if (length)
            status = keep(o, file, length, &o->set->name);
    }
    return status || !o->set->name || !beside(o, side, "%s.json", o->set->name)
               ? status
               : read_sidecar(o, side);
}

/* Finds the file that has a usual name of the content, first of the container
 * of the texture that was named. */
static ibl_status find_usual(const opener *o, int content, char **to)
{
    const char *dot = o->named >= 0 ? strrchr(o->path, '.') : NULL;
    char path[PATH_BYTES];
    bool found = false;

    for (const char *const *stem = contents[content].stems; *stem && !found;
         stem++) {
        const char *name = **stem == '_' ? o->set->name : "";
        found = name && dot && beside(o, path, "%s%s%s", name, *stem, dot);
        for (int i = 0; name && ibl_array_container_names[i] && !found; i++)
            found = beside(o, path, "%s%s.%s", name, *stem,
                           ibl_array_container_names[i]);
    }
    for (int e = IBL_ENGINE_ENV;
         content == IBL_CONTENT_SPECULAR && o->set->name &&
         e <= IBL_ENGINE_PLAYCANVAS && !found;
         e++)
        found = beside(o, path, "%s%s", o->set->name,
                       ibl_engine_suffix((ibl_engine)e));
    return found ? keep(o, path, strlen(path), to) : IBL_OK;
}

/* Finds the file of a content: as it was named, as the sidecar or an index has
 * it, or by its usual names. */
static ibl_status find(opener *o, int content)
{
    const char *word = ibl_content_name((ibl_content)content);
    const char *named = o->o.file[content]    ? o->o.file[content]
                        : content == o->named ? o->path
                                              : NULL;
    const json_t *entry = ibl_sidecar_entry(o->sidecar, "content", word);
    const json_t *indexed =
        json_object_get(json_object_get(o->sidecar, "files"), word);
    const char *listed =
        json_string_value(json_object_get(entry ? entry : indexed, "file"));
    ibl_set_file *f = &o->set->file[content];
    char path[PATH_BYTES] = "";

    if (!named && (!o->path || o->o.leave >> content & 1))
        return IBL_OK;
    const char *name = listed;
    /* Folders of a tree share their tables. */
    while (name && content >= IBL_CONTENT_LUT && !strncmp(name, "../", 3))
        name += 3;
    const bool here =
        name && !strchr(name, '/') && beside(o, path, "%s", listed);
    ibl_status status = named || here
                            ? keep(o, named ? named : path,
                                   strlen(named ? named : path), &f->path)
                            : find_usual(o, content, &f->path);
    if (!status && !f->path && *path) {
        f->missing = 1;
        status = keep(o, path, strlen(path), &f->path);
    }
    if (!status && f->path && !strcmp(f->path, path))
        o->entry[content] = entry ? entry : json_object_get(o->sidecar, word);
    return status;
}

/* ---- reading ----------------------------------------------------------- */

static bool fits(const ibl_texture *t, int content, ibl_lut_kind kind)
{
    const bool square = t->width == t->height;
    const int channels = ibl_pixel_channels(t->pixel);
    const ibl_level_shape one =
        ibl_level_shape_of(ibl_texture_projection(t), 1);
    const int n = t->width / one.width;

    if (content == IBL_CONTENT_LUT)
        return t->faces == 1 && square && t->layers == 1 &&
               ibl_pixel_block(t->pixel) == 1 &&
               channels == ibl_lut_channels(kind);
    if (content == IBL_CONTENT_LOBE_TABLE)
        return t->faces == 1 && square && t->pixel <= IBL_PIXEL_RGBA32F &&
               (t->layers == IBL_LOBE_LAYERS ||
                2 * t->layers == IBL_LOBE_LAYERS);
    return channels == 3 && t->layers == 1 && n <= IBL_MAX_CUBE_SIZE &&
           n >> (t->levels - 1) && t->width == n * one.width &&
           t->height == n * one.height;
}

/* Checks that a texture is what it was taken for. Warns if it is not the file
 * that the sidecar tells of. */
static ibl_status check(const opener *o, int content)
{
    const ibl_set_file *f = &o->set->file[content];
    const ibl_texture *t = &f->texture;

    if (!o->o.file[content] && f->holds >= 0 && f->holds != content)
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: holds %s, where %s is wanted: name another file, "
                        "or take it away",
                        f->path, contents[f->holds].what,
                        contents[content].what);
    if (!fits(t, content, f->facts.table))
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: is a %s of %dx%d texels of %s, %d layer%s, where "
                        "%s is wanted: name another file%s",
                        f->path, t->faces == 1 ? "flat texture" : "cube",
                        t->width, t->height, ibl_pixel_name(t->pixel),
                        t->layers, t->layers > 1 ? "s" : "",
                        contents[content].what,
                        t->layers > 1 ? ", or a layer" : "");
    const char *hash =
        json_string_value(json_object_get(o->entry[content], "xxh3_128"));
    char now[IBL_FILE_HASH];
    if (hash && !ibl_hash_file(f->path, now) && strcmp(hash, now) != 0)
        ibl_warn(o->ctx,
                 "%s: is not the file that %s tells of: they are of two bakes, "
                 "or it was changed: bake the set again",
                 f->path, o->set->sidecar);
    return IBL_OK;
}

/* Turns the texels of a map to the world's axes. */
static ibl_status turn(const opener *o, ibl_set_file *f)
{
    const ibl_axes axes = f->facts.axes;
    ibl_texture *t = &f->texture;
    const ibl_projection projection = ibl_texture_projection(t);
    const int n = t->width / ibl_level_shape_of(projection, 1).width;
    ibl_status status = IBL_OK;

    if (!axes.mirror && !axes.up)
        return IBL_OK;
    if (t->faces == 1 && axes.up)
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: is flat, and only cubes have +Z up: give other "
                        "axes, or a cube",
                        f->path);
    unsigned char *turned = ibl_alloc_array(t->bytes, 1);
    if (!turned)
        return ibl_no_memory(o->ctx, f->path);
    for (int l = 0; l < t->levels && !status; l++) {
        const size_t at = ibl_texture_offset(t, l, 0);
        status = ibl_level_turn_axes(
            o->ctx, ibl_level_shape_of(projection, ibl_cube_edge(n, l)),
            (int)ibl_pixel_bytes(t->pixel) / 4, axes, 1, t->data + at,
            turned + at);
    }
    ibl_free(t->data);
    t->data = turned;
    return status;
}

/* Finds out what is not said of levels, from what is. */
static ibl_status complete(const opener *o, ibl_set_file *f)
{
    ibl_set_facts *a = &f->facts;
    const int levels = f->texture.levels;
    const unsigned said = a->known & (IBL_KNOWN_MAPPING | IBL_KNOWN_ROUGHNESS);

    if (a->levels && a->levels != levels)
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: has %d levels, and the roughness of %d: bake it "
                        "again, or say what it is",
                        f->path, levels, a->levels);
    if (!said && ibl_texture_get(&f->texture, "sh")) /* cmgen */
        a->mapping = IBL_ROUGHNESS_FILAMENT;
    for (int l = 0; l < levels && !a->levels; l++)
        a->roughness[l] = ibl_level_roughness(a->mapping, l, levels);
    a->levels = levels;
    const bool babylon = a->mapping == IBL_ROUGHNESS_BABYLON;
    const ibl_specular_options chain = {
        .size = babylon ? f->texture.width : IBL_MAX_CUBE_SIZE,
        .levels = levels,
        .mapping = a->mapping,
        .roughness_min = babylon ? 0 : a->roughness[0],
        .roughness_max = babylon ? 1 : a->roughness[levels - 1]};
    ibl_specular_layout layout;
    if (!(a->known & IBL_KNOWN_LOD) && said != IBL_KNOWN_ROUGHNESS &&
        !ibl_specular_layout_of(&chain, &layout)) {
        a->lod_scale = layout.lod_scale;
        a->lod_offset = layout.lod_offset;
    }
    return IBL_OK;
}

/* Finds out what keys and sidecar say of a texture. */
static ibl_status learn(opener *o, int content)
{
    ibl_set_file *f = &o->set->file[content];
    const json_t *entry = o->entry[content];
    const ibl_about keys = ibl_about_keys(&f->texture, f->path);
    const ibl_about side =
        ibl_about_sidecar(entry ? o->sidecar : NULL, entry, o->set->sidecar);
    ibl_about known = o->asked;
    size_t length;

    if (content == IBL_CONTENT_LOBE_TABLE)
        known = (ibl_about){0};
    ibl_status status = ibl_about_add(o->ctx, &known, &keys);
    if (!status)
        status = ibl_about_add(o->ctx, &known, &side);
    if (!status)
        status = ibl_about_add(o->ctx, &o->all, &known);
    if (status)
        return status;
    f->facts = ibl_about_facts(&known);
    f->holds = known.said >> IBL_FACT_CONTENT & 1
                   ? (int)known.value[IBL_FACT_CONTENT]
                   : content_of(ibl_path_name(f->path), &length);
    return IBL_OK;
}

/* Leaves out a lobe table for other levels: several bakes in one directory
 * share its name. */
static ibl_status check_lobes(const opener *o, ibl_set_file *f)
{
    const ibl_set_facts *a = &f->facts;
    const ibl_set_facts *of = &o->set->file[IBL_CONTENT_SPECULAR].facts;
    bool same = a->levels == of->levels || !a->levels || !of->levels;

    for (int l = 0; l < a->levels && l < of->levels && same; l++)
        same = fabs(a->roughness[l] - of->roughness[l]) < 1e-6;
    if (same)
        return IBL_OK;
    if (o->o.file[IBL_CONTENT_LOBE_TABLE])
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: for levels of other roughness than the specular "
                        "ones: name another file",
                        f->path);
    ibl_warn(o->ctx,
             "%s: left out: for levels of other roughness than the specular "
             "ones",
             f->path);
    ibl_texture_free(&f->texture);
    ibl_free(f->path);
    *f = (ibl_set_file){0};
    return IBL_OK;
}

/* Reads a file, and what it and the sidecar say. */
static ibl_status read_file(opener *o, int content)
{
    static const char *const pictures[] = {"exr", "hdr", "png", NULL};
    ibl_set_file *f = &o->set->file[content];

    if (ibl_names_find(pictures, text_of(o->entry[content], "container")) >= 0)
        return ibl_fail(o->ctx, IBL_ERR_UNSUPPORTED,
                        "%s: is a picture, and such a set cannot be read back: "
                        "bake it as KTX2, KTX or DDS, by --format",
                        f->path);
    ibl_status status = ibl_engine_read(
        o->ctx, f->path, content == IBL_CONTENT_SKYBOX ? -1 : o->o.layer,
        &f->texture);
    if (!status)
        status = learn(o, content);
    if (!status)
        status = check(o, content);
    f->pixel = f->texture.pixel;
    if (status)
        return status;
    if (content == IBL_CONTENT_LOBE_TABLE)
        return check_lobes(o, f);
    if (content == IBL_CONTENT_LUT)
        return f->facts.known & IBL_KNOWN_TABLE
                   ? ibl_texture_set(o->ctx, &f->texture, "iblbake.table",
                                     ibl_lut_name(f->facts.table))
                   : IBL_OK;
    status = ibl_texture_unblock(o->ctx, &f->texture);
    if (!status && content == IBL_CONTENT_SPECULAR)
        status = complete(o, f);
    return status ? status : turn(o, f);
}

/* ---- the environment --------------------------------------------------- */

static ibl_status damaged(const opener *o, const char *what)
{
    return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                    "%s: its %s: bake the set again, or take the file away",
                    o->set->sidecar, what);
}

static ibl_status read_harmonics(const opener *o, ibl_axes axes)
{
    const json_t *sh = json_object_get(o->sidecar, "sh");
    const json_t *radiance = json_object_get(sh, "radiance");
    const json_t *degree = json_object_get(sh, "degree");
    const json_int_t most = json_integer_value(degree);
    ibl_set *set = o->set;

    if (!sh)
        return IBL_OK;
    const int used = most < IBL_SET_DEGREE ? (int)most : IBL_SET_DEGREE;
    const int count = most < 0 ? 0 : (used + 1) * (used + 1);
    if (!json_is_integer(degree) || !count ||
        json_array_size(radiance) < (size_t)count)
        return damaged(o, "harmonics are not as many as their degree says");
    for (int i = 0; i < count; i++)
        if (!ibl_json_numbers(json_array_get(radiance, (size_t)i),
                              set->sh + 3 * i, 3))
            return damaged(o, "harmonics are not all numbers");
    set->sh_degree = used;
    return ibl_sh_turn_axes(o->ctx, used, axes, 1, set->sh);
}

/* Reads the lights that were taken out of the map, unless it was said how many
 * they are. */
static ibl_status read_lights(const opener *o, ibl_axes axes)
{
    const json_t *list = json_object_get(o->sidecar, "lights");
    json_t *entry;
    size_t i;

    if (o->asked.said >> IBL_FACT_LIGHTS & 1 || !o->sidecar)
        return IBL_OK;
    json_array_foreach(list, i, entry)
    {
        ibl_light *l = &o->set->light[i];
        double *d = l->direction, *e = l->irradiance, *r = l->radiance;
        if (i == IBL_MAX_LIGHTS ||
            json_unpack(entry, "{s:F s:[FFF] s:[FFF] s:[FFF]}", "radius_rad",
                        &l->radius, "direction", &d[0], &d[1], &d[2],
                        "irradiance", &e[0], &e[1], &e[2], "radiance", &r[0],
                        &r[1], &r[2]))
            return damaged(o, "lights are damaged");
        ibl_axes_turn(axes, 1, d, d);
    }
    o->set->light_count = (int)json_array_size(list);
    return IBL_OK;
}

/* Finds the map: where it was for iblbake, or beside the sidecar; six files
 * only where they were. */
static ibl_status find_source(const opener *o)
{
    const char *path = NULL, *layout = "", *order = "", *hash = "";
    const char *target = text_of(o->sidecar, "target");
    char near[PATH_BYTES];
    ibl_set *set = o->set;

    json_unpack(o->sidecar, "{s:{s?s s?F s?s s?s s?s}}", "source", "path",
                &path, "peak", &set->source_peak, "layout", &layout,
                "face_order", &order, "xxh3_128", &hash);
    snprintf(set->source_hash, sizeof set->source_hash, "%s", hash);
    snprintf(set->target, sizeof set->target, "%s", target);
    const int known = ibl_names_find(ibl_input_names, layout);
    set->read.layout = known > 0 ? (ibl_input_layout)known : IBL_INPUT_AUTO;
    if (*order && !ibl_face_order_parse(order, set->read.face_order))
        memset(set->read.face_order, 0, IBL_FACES);
    if (path && set->read.layout != IBL_INPUT_FACES && !is_there(path))
        path = beside(o, near, "%s", ibl_path_name(path)) ? near : NULL;
    return path ? keep(o, path, strlen(path), &set->source) : IBL_OK;
}

/* What the files and the sidecar say of the environment, the files first. */
static ibl_status read_environment(opener *o)
{
    const ibl_about side = ibl_about_sidecar(o->sidecar, NULL, o->set->sidecar);
    ibl_read_options *read = &o->set->read;
    const double *v = o->all.value;

    ibl_status status = ibl_about_add(o->ctx, &o->all, &side);
    if (status)
        return status;
    const ibl_axes axes = {(ibl_mirror)v[IBL_FACT_MIRROR],
                           (ibl_up)v[IBL_FACT_UP]};
    read->primaries = (ibl_primaries)v[IBL_FACT_PRIMARIES];
    read->transfer = (ibl_transfer)v[IBL_FACT_TRANSFER];
    read->exposure = v[IBL_FACT_EXPOSURE];
    read->clamp = v[IBL_FACT_CLAMP];
    o->set->yaw_deg = v[IBL_FACT_YAW];
    status = read_harmonics(o, axes);
    if (!status)
        status = read_lights(o, axes);
    return status ? status : find_source(o);
}

/* ---- the whole --------------------------------------------------------- */

/* The texture that was named comes first. */
static ibl_status open_set(opener *o)
{
    bool found = false;
    ibl_status status = o->path ? locate(o) : IBL_OK;

    for (int i = -1; i < IBL_CONTENTS && !status; i++) {
        const int c = i < 0 ? o->named : i;
        if (c < 0 || o->set->file[c].path)
            continue;
        status = find(o, c);
        if (!status && o->set->file[c].path && !o->set->file[c].missing)
            status = read_file(o, c);
        found |=
            o->set->file[c].path && (c < IBL_CONTENT_LUT || i < 0 || !o->path);
    }
    if (!status && !found)
        status = o->path ? no_set(o)
                         : ibl_missing(o->ctx, "ibl_set_open: path or files");
    return status ? status : read_environment(o);
}

ibl_status ibl_set_open(ibl_ctx *ctx, const char *path,
                        const ibl_set_options *opts, ibl_set *set)
{
    opener o = {.ctx = ctx,
                .o = opts ? *opts : ibl_set_options_default(),
                .set = set,
                .path = path,
                .named = -1};

    if (!ctx || !set)
        return ibl_missing(ctx, "ibl_set_open: set");
    *set = (ibl_set){
        .read = ibl_read_options_default(), .sh_degree = -1, .light_count = -1};
    set->read.env = ibl_env_decode;
    if (o.o.facts)
        o.asked = ibl_about_asked(o.o.facts);
    const ibl_status status = open_set(&o);
    json_decref(o.sidecar);
    if (status)
        ibl_set_free(set);
    return status;
}

void ibl_set_free(ibl_set *set)
{
    if (!set)
        return;
    for (int c = 0; c < IBL_CONTENTS; c++) {
        ibl_texture_free(&set->file[c].texture);
        ibl_free(set->file[c].path);
    }
    ibl_free(set->name);
    ibl_free(set->sidecar);
    ibl_free(set->source);
    *set = (ibl_set){0};
}

double ibl_set_lod(const ibl_set_facts *facts, double roughness)
{
    const double *r = facts->roughness;
    ibl_specular_layout layout = {.levels = facts->levels,
                                  .mapping = facts->mapping,
                                  .lod_scale = facts->lod_scale,
                                  .lod_offset = facts->lod_offset};
    int l = 0;

    if (facts->lod_scale > 0)
        return ibl_lod_of_roughness(&layout, roughness);
    while (l + 2 < facts->levels && roughness > r[l + 1])
        l++;
    const double step = facts->levels > 1 ? r[l + 1] - r[l] : 0;
    return step > 0 ? l + fmin(fmax((roughness - r[l]) / step, 0), 1) : l;
}
