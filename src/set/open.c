/* SPDX-License-Identifier: MIT */
/* Finds the files of a set, reads them, and what they and a sidecar say. */
#include <dirent.h>
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
#include "ibl/probes.h"
#include "set/account.h"

enum {
    PATH_BYTES = 4096,
    NAME_BYTES = 256 /* of a directory's entry */
};

typedef struct opener {
    ibl_ctx *ctx;
    ibl_set_options o;
    ibl_set_facts asked; /* zeroed: none */
    ibl_set *set;
    const char *path;        /* as given, for messages; NULL: only files */
    char folder[PATH_BYTES]; /* of the set, with a slash, or "" */
    bool named;              /* path is a texture */
    int content;             /* of it; -1: its name does not say */
    json_t *sidecar;         /* or NULL */
    ibl_probe_index index;   /* of probes; zeroed: none */
    ibl_account all;         /* of the environment */
} opener;

static const struct {
    const char *wanted;   /* for messages */
    const char *stems[5]; /* of files; behind the name if they begin with _ */
} contents[IBL_CONTENTS] = {
    [IBL_CONTENT_SKYBOX] = {"a skybox, a cube or a flat map", {"_skybox"}},
    [IBL_CONTENT_SPECULAR] = {"a specular chain, a cube or a flat map",
                              {"_specular"}},
    [IBL_CONTENT_IRRADIANCE] = {"an irradiance map, a cube or a flat map",
                                {"_irradiance"}},
    [IBL_CONTENT_LUT] = {"a BRDF table, flat and square",
                         {"brdf_lut", "brdf_lut_schlick-ibl",
                          "brdf_lut_multiscatter", "brdf_lut_charlie"}},
    [IBL_CONTENT_LOBE_TABLE] = {"a lobe table, flat, square, of 2 or 4 layers "
                                "of rgba16f or rgba32f",
                                {"_lobe_lut", "lobe_lut"}},
};

static const ibl_set_options defaults = {.struct_size = sizeof defaults,
                                         .layer = -1};

void ibl_set_options_init(ibl_set_options *opts, size_t struct_size)
{
    ibl_give_options(opts, struct_size, &defaults, sizeof defaults);
}

void ibl_set_free(ibl_set *set)
{
    for (int c = 0; set && c < IBL_CONTENTS; c++) {
        ibl_texture_free(&set->file[c].texture);
        ibl_free(set->file[c].path);
    }
    if (!set)
        return;
    ibl_free(set->name);
    ibl_free(set->sidecar);
    ibl_free(set->source);
    *set = (ibl_set){0};
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

/* Whether a file of that name is a map of a set, and not its sheen. */
static bool is_map(const char *name, size_t *length)
{
    static const char sheen[] = "_charlie";
    const char *dot = strrchr(name, '.');
    const int content = content_of(name, length);

    return *name != '.' && dot && content >= 0 && content < IBL_CONTENT_LUT &&
           (ibl_engine_of_name(name) ||
            ibl_names_find(ibl_array_container_names, dot + 1) >= 0) &&
           (*length < strlen(sheen) ||
            memcmp(name + *length - strlen(sheen), sheen, strlen(sheen)) != 0);
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
    DIR *directory = opendir(o->path);
    char first[NAME_BYTES] = "", last[NAME_BYTES] = "", name[NAME_BYTES];
    const struct dirent *entry;
    size_t length;

    while (directory && (entry = readdir(directory))) {
        if (!is_map(entry->d_name, &length))
            continue;
        snprintf(name, sizeof name, "%.*s", (int)length, entry->d_name);
        if (!*first || strcmp(name, first) < 0)
            strcpy(first, name);
        if (strcmp(name, last) > 0)
            strcpy(last, name);
    }
    if (!directory)
        return ibl_fail(o->ctx, IBL_ERR_IO, "%s: cannot be read: %s", o->path,
                        strerror(errno));
    closedir(directory);
    if (!*first)
        return no_set(o);
    if (strcmp(first, last) != 0)
        return ibl_fail(o->ctx, IBL_ERR_IO,
                        "%s: holds several sets, from %s to %s: name one of "
                        "their files",
                        o->path, first, last);
    return keep(o, first, strlen(first), &o->set->name);
}

/* Reads NAME.json, or an index of probes. It is no error that another program
 * wrote what was not asked for. */
static ibl_status read_sidecar(opener *o, const char *path, bool asked)
{
    ibl_json_why why;
    const char *writer;

    if (!asked && !is_there(path))
        return IBL_OK;
    if (o->o.reading)
        o->o.reading(o->o.cookie, IBL_CONTENTS, path);
    json_t *root = ibl_sidecar_load(path, &why);
    if (!root)
        return ibl_fail(o->ctx, why.status, "%s%s", why.line,
                        why.status == IBL_ERR_FORMAT
                            ? ": bake the set again, or take the file away"
                            : "");
    if (!json_unpack(root, "{s:{s:s},s:o}", "generator", "name", &writer,
                     "outputs", &o->sidecar) &&
        !strcmp(writer, "iblbake")) {
        o->sidecar = root;
        return keep(o, path, strlen(path), &o->set->sidecar);
    }
    o->sidecar = NULL;
    json_decref(root);
    if (asked)
        return ibl_probe_index_read(o->ctx, path, &o->index);
    ibl_warn(o->ctx, "%s: was not written by iblbake and is left out", path);
    return IBL_OK;
}

/* Finds folder, name and sidecar of a set. */
static ibl_status locate(opener *o)
{
    const char *path = o->path, *name = ibl_path_name(path);
    const char *dot = strrchr(name, '.');
    char side[PATH_BYTES];
    ibl_status status = IBL_OK;
    size_t length = strlen(path);
    struct stat st;

    if (length > PATH_BYTES - 2 || stat(path, &st))
        return ibl_fail(o->ctx, IBL_ERR_IO,
                        "%s: cannot be opened: %s: name a directory, a sidecar "
                        "or a texture of a set",
                        path, strerror(errno));
    if (S_ISDIR(st.st_mode)) {
        snprintf(o->folder, PATH_BYTES, "%s%s", path, *name ? "/" : "");
        if (!o->o.name && beside(o, side, "index.json"))
            return read_sidecar(o, side, true);
        status = o->o.name
                     ? keep(o, o->o.name, strlen(o->o.name), &o->set->name)
                     : find_name(o);
    } else {
        snprintf(o->folder, PATH_BYTES, "%.*s", (int)(name - path), path);
        if (dot && !strcmp(dot, ".json")) {
            status = keep(o, name, (size_t)(dot - name), &o->set->name);
            return status ? status : read_sidecar(o, path, true);
        }
        o->named = true;
        o->content = content_of(name, &length);
        if (length)
            status = keep(o, name, length, &o->set->name);
    }
    return status || !o->set->name || !beside(o, side, "%s.json", o->set->name)
               ? status
               : read_sidecar(o, side, false);
}

/* Takes a file that is there as the only one. */
static ibl_status take(const opener *o, const char *path, char **found)
{
    return *found ? ibl_fail(o->ctx, IBL_ERR_IO,
                             "%s: %s is there, too: name the one to open", path,
                             *found)
                  : keep(o, path, strlen(path), found);
}

/* Finds the file that has a usual name of the content, first of the container
 * of the texture that was named. */
static ibl_status find_usual(const opener *o, int content, char **found)
{
    const char *dot = o->named ? strrchr(o->path, '.') : NULL;
    char path[PATH_BYTES];
    ibl_status status = IBL_OK;

    for (const char *const *stem = contents[content].stems;
         *stem && !*found && !status; stem++) {
        const char *name = **stem == '_' ? o->set->name : "";
        if (name && dot && beside(o, path, "%s%s%s", name, *stem, dot))
            return take(o, path, found);
        for (int i = 0; name && ibl_array_container_names[i] && !status; i++)
            if (beside(o, path, "%s%s.%s", name, *stem,
                       ibl_array_container_names[i]))
                status = take(o, path, found);
    }
    for (int e = IBL_ENGINE_ENV;
         content == IBL_CONTENT_SPECULAR && o->set->name &&
         e <= IBL_ENGINE_PLAYCANVAS && !status;
         e++)
        if (beside(o, path, "%s%s", o->set->name,
                   ibl_engine_suffix((ibl_engine)e)))
            status = take(o, path, found);
    return status;
}

/* Finds the file of a content: as it was named, as the sidecar or an index has
 * it, or by its usual names. Without a path: there is none. */
static ibl_status find(const opener *o, int content)
{
    const char *const indexed[IBL_CONTENTS] = {
        [IBL_CONTENT_SPECULAR] = o->index.specular.name,
        [IBL_CONTENT_IRRADIANCE] = o->index.irradiance.name,
        [IBL_CONTENT_LUT] = o->index.lut};
    ibl_set_file *f = &o->set->file[content];
    const char *named = o->o.file[content], *listed = indexed[content];
    char path[PATH_BYTES];

    if (!named && o->named && o->content == content)
        named = o->path;
    if (named)
        return keep(o, named, strlen(named), &f->path);
    if (!o->path || o->o.leave >> content & 1)
        return IBL_OK;
    if (o->sidecar)
        listed = json_string_value(json_object_get(
            ibl_sidecar_entry(o->sidecar, "content",
                              ibl_content_name((ibl_content)content)),
            "file"));
    if (listed && *listed && !strchr(listed, '/')) {
        if (beside(o, path, "%s", listed))
            return keep(o, path, strlen(path), &f->path);
        f->missing = 1;
    }
    const ibl_status status = find_usual(o, content, &f->path);
    if (status || !f->missing || f->path)
        f->missing = 0;
    else
        return keep(o, path, strlen(path), &f->path);
    return status;
}

/* ---- reading ----------------------------------------------------------- */

/* The content of a texture whose name does not say it. */
static int content_by_shape(const ibl_texture *tex)
{
    const char *word = ibl_texture_get(tex, "iblbake.content");

    for (int c = 0; c < IBL_CONTENTS && word; c++)
        if (!strcmp(word, ibl_content_name((ibl_content)c)))
            return c;
    if (tex->faces == 1 && tex->layers > 1)
        return IBL_CONTENT_LOBE_TABLE;
    return ibl_pixel_channels(tex->pixel) == 2 ? IBL_CONTENT_LUT
                                               : IBL_CONTENT_SPECULAR;
}

static bool fits(const ibl_texture *t, int content, ibl_lut_kind kind)
{
    const bool square = t->width == t->height;

    if (content == IBL_CONTENT_LUT)
        return t->faces == 1 && square && t->layers == 1 &&
               ibl_pixel_block(t->pixel) == 1 &&
               ibl_pixel_channels(t->pixel) == ibl_lut_channels(kind);
    if (content == IBL_CONTENT_LOBE_TABLE)
        return t->faces == 1 && square && t->pixel <= IBL_PIXEL_RGBA32F &&
               (t->layers == IBL_LOBE_LAYERS ||
                2 * t->layers == IBL_LOBE_LAYERS);
    return ibl_pixel_channels(t->pixel) == 3 &&
           (t->faces == IBL_FACES || square || t->width == 2 * t->height);
}

/* Checks the shape of a texture, that it is what it was taken for, and that the
 * sidecar tells of its levels and not of another bake's. */
static ibl_status check(const opener *o, int content, const json_t *entry)
{
    const ibl_set_file *f = &o->set->file[content];
    const ibl_texture *t = &f->texture;
    const bool map = content < IBL_CONTENT_LUT;
    const json_t *height = json_object_get(entry, "height");
    const json_t *levels = json_object_get(entry, "levels");

    if (!o->o.file[content] && f->holds >= 0 && f->holds != content)
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: holds %s, where %s is wanted: name another file, "
                        "or take it away",
                        f->path, contents[f->holds].wanted,
                        contents[content].wanted);
    if (!fits(t, content, f->facts.table))
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: is a %s of %dx%d texels of %s, %d layer%s, where "
                        "%s%s is wanted: name another file",
                        f->path, t->faces == 1 ? "flat texture" : "cube",
                        t->width, t->height, ibl_pixel_name(t->pixel),
                        t->layers, t->layers > 1 ? "s" : "",
                        contents[content].wanted,
                        content != IBL_CONTENT_LUT             ? ""
                        : ibl_lut_channels(f->facts.table) > 2 ? " of colour"
                                                               : " of two "
                                                                 "channels");
    if (map && t->layers > 1)
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: an array of %d layers: choose one by its number",
                        f->path, t->layers);
    if (map && t->width > IBL_MAX_CUBE_SIZE)
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: is %dx%d, more than %d: bake it smaller", f->path,
                        t->width, t->height, IBL_MAX_CUBE_SIZE);
    if (map && json_is_integer(height) && json_is_array(levels) &&
        !(o->asked.known & IBL_KNOWN_ROUGHNESS) &&
        (json_integer_value(height) != t->height ||
         json_array_size(levels) != (size_t)t->levels))
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: has %d levels from %d texels, but %s tells of %zu "
                        "from %lld: bake the set again, or take that file away",
                        f->path, t->levels, t->height, o->set->sidecar,
                        json_array_size(levels),
                        (long long)json_integer_value(height));
    return IBL_OK;
}

/* Turns the texels of a map to the world's axes. */
static ibl_status turn(const opener *o, ibl_set_file *f)
{
    const int *axes = f->facts.axes;
    ibl_texture *t = &f->texture;
    const size_t bytes = ibl_pixel_bytes(t->pixel);
    const ibl_level_shape one =
        ibl_level_shape_of(ibl_texture_projection(t), 1);

    if (axes[0] == 1 && axes[1] == 2 && axes[2] == 3)
        return IBL_OK;
    if (t->faces == 1 && abs(axes[1]) != 2)
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: a flat texture, whose Y is the world's Y or -Y: "
                        "give other axes, or a cube",
                        f->path);
    unsigned char *turned = ibl_alloc_array(t->bytes, 1);
    if (!turned)
        return ibl_no_memory(o->ctx, f->path);
    for (int l = 0; l < t->levels; l++) {
        const ibl_level_shape s = ibl_level_shape_of(
            one.projection, ibl_cube_edge(t->width / one.width, l));
        const size_t start = ibl_texture_offset(t, l, 0);
        for (int i = 0; i < s.faces * s.width * s.height; i++) {
            double theirs[3], ours[3];
            int at[3];
            ibl_level_direction(&s, i / s.width / s.height, i % s.width,
                                i / s.width % s.height, theirs);
            for (int k = 0; k < 3; k++)
                ours[abs(axes[k]) - 1] = axes[k] < 0 ? -theirs[k] : theirs[k];
            ibl_level_texel(&s, ours, at);
            const size_t to =
                ((size_t)at[0] * s.height + at[2]) * s.width + at[1];
            memcpy(turned + start + to * bytes,
                   t->data + start + (size_t)i * bytes, bytes);
        }
    }
    ibl_free(t->data);
    t->data = turned;
    return IBL_OK;
}

/* Finds out what is not said of levels, and can be told from what is. */
static ibl_status complete(const opener *o, ibl_set_file *f, const char *who)
{
    ibl_set_facts *a = &f->facts;
    const int levels = f->texture.levels;
    const bool formula = a->mapping <= IBL_ROUGHNESS_BABYLON;
    ibl_specular_layout layout;

    if (a->known & IBL_KNOWN_ROUGHNESS && a->levels != levels)
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: has %d levels, but %s says the roughness of %d: "
                        "bake it again, or say what it is",
                        f->path, levels, who, a->levels);
    if (!(a->known & (IBL_KNOWN_MAPPING | IBL_KNOWN_ROUGHNESS)) &&
        ibl_texture_get(&f->texture, "sh")) /* cmgen */
        a->mapping = IBL_ROUGHNESS_FILAMENT;
    a->levels = levels;
    for (int l = 0; l < levels && !(a->known & IBL_KNOWN_ROUGHNESS); l++)
        a->roughness[l] = ibl_level_roughness(a->mapping, l, levels);
    if (a->known & IBL_KNOWN_LOD && formula)
        return IBL_OK;
    a->lod_scale = a->lod_offset = 0;
    const bool babylon = a->mapping == IBL_ROUGHNESS_BABYLON;
    const ibl_specular_options chain = {
        .struct_size = sizeof chain,
        .size = babylon ? f->texture.width : IBL_MAX_CUBE_SIZE,
        .levels = levels,
        .mapping = a->mapping,
        .roughness_min = babylon ? 0 : a->roughness[0],
        .roughness_max = babylon ? 1 : a->roughness[levels - 1]};
    if (formula &&
        (a->known & IBL_KNOWN_MAPPING || !(a->known & IBL_KNOWN_ROUGHNESS)) &&
        !ibl_specular_layout_of(&chain, &layout)) {
        a->lod_scale = layout.lod_scale;
        a->lod_offset = layout.lod_offset;
    }
    return IBL_OK;
}

/* What the sidecar or an index says of a file. */
static ibl_account account_of_side(const opener *o, int content,
                                   const json_t *entry)
{
    const bool taken = entry && content != IBL_CONTENT_SKYBOX;
    ibl_account a = ibl_account_of_sidecar(entry ? o->sidecar : NULL, entry,
                                           o->set->sidecar);
    const struct {
        bool here;
        int fact;
        double value;
    } more[] = {
        {taken && o->set->light_count >= 0, IBL_FACT_LIGHTS,
         o->set->light_count},
        {o->index.probe, IBL_FACT_MAPPING, o->index.mapping},
        {o->index.probe, IBL_FACT_LOD_SCALE, o->index.lod_scale},
        {o->index.probe, IBL_FACT_LOD_OFFSET, o->index.lod_offset},
        {o->index.probe, IBL_FACT_SCALE, o->index.irradiance_scale < 1}};

    for (size_t i = 0; i < sizeof more / sizeof *more; i++)
        if (more[i].here) {
            a.said |= 1u << more[i].fact;
            a.value[more[i].fact] = more[i].value;
        }
    return a;
}

/* Finds out what keys and sidecar say of a texture. */
static ibl_status learn(opener *o, int content, const json_t *entry)
{
    ibl_set_file *f = &o->set->file[content];
    const ibl_account keys = ibl_account_of_keys(&f->texture, f->path);
    const ibl_account side = account_of_side(o, content, entry);
    ibl_set_facts asked = o->asked;
    int ignored = 0;
    size_t length;

    if (content != IBL_CONTENT_SPECULAR)
        asked.known &= ~(IBL_KNOWN_MAPPING | IBL_KNOWN_ROUGHNESS);
    ibl_account known = {.skip = ibl_account_skip(&asked)};
    ibl_status status = ibl_account_add(o->ctx, &known, &keys, &ignored);
    if (!status)
        status = ibl_account_add(o->ctx, &known, &side, &f->differs);
    if (!status)
        status = ibl_account_add(o->ctx, &o->all, &known, &ignored);
    if (status)
        return status;
    f->facts = ibl_account_facts(&known, &asked);
    f->holds = known.said >> IBL_FACT_CONTENT & 1
                   ? (int)known.value[IBL_FACT_CONTENT]
                   : content_of(ibl_path_name(f->path), &length);
    for (int l = 0; l < IBL_MAX_LEVELS; l++) {
        const json_t *level =
            json_array_get(json_object_get(entry, "levels"), (size_t)l);
        const json_t *nrmse =
            json_object_get(json_object_get(level, "pixel_error"), "nrmse");
        f->pixel_error[l] =
            json_is_number(nrmse) ? json_number_value(nrmse) : NAN;
    }
    return IBL_OK;
}

/* Leaves out a lobe table for other levels: several bakes in one directory
 * share its name. */
static ibl_status check_lobes(const opener *o)
{
    ibl_set_file *f = &o->set->file[IBL_CONTENT_LOBE_TABLE];
    const ibl_set_facts *a = &f->facts;
    const ibl_set_facts *of = &o->set->file[IBL_CONTENT_SPECULAR].facts;
    bool same = a->levels == of->levels;

    for (int l = 0; l < a->levels && same; l++)
        same = fabs(a->roughness[l] - of->roughness[l]) < 1e-6;
    if (same || !a->levels || !of->levels)
        return IBL_OK;
    if (o->o.file[IBL_CONTENT_LOBE_TABLE])
        return ibl_fail(o->ctx, IBL_ERR_FORMAT,
                        "%s: for levels of other roughness than the specular "
                        "ones: name another file",
                        f->path);
    ibl_warn(o->ctx, "%s: left out: for levels of other roughness than %s",
             f->path, o->set->file[IBL_CONTENT_SPECULAR].path);
    ibl_texture_free(&f->texture);
    ibl_free(f->path);
    *f = (ibl_set_file){0};
    return IBL_OK;
}

static ibl_status read_texture(const opener *o, int content, const char *path,
                               ibl_texture *tex)
{
    if (o->o.reading)
        o->o.reading(o->o.cookie, content, path);
    return ibl_engine_read(
        o->ctx, path, content == IBL_CONTENT_SKYBOX ? -1 : o->o.layer, tex);
}

static ibl_status read_file(opener *o, int content)
{
    ibl_set_file *f = &o->set->file[content];
    const size_t folder = strlen(o->folder);
    const json_t *entry =
        !strncmp(f->path, o->folder, folder)
            ? ibl_sidecar_entry(o->sidecar, "file", f->path + folder)
            : NULL;
    ibl_status status = f->texture.data
                            ? IBL_OK
                            : read_texture(o, content, f->path, &f->texture);

    if (!status)
        status = learn(o, content, entry);
    if (!status)
        status = check(o, content, entry);
    if (status)
        return status;
    f->pixel = f->texture.pixel;
    if (content == IBL_CONTENT_LOBE_TABLE)
        return check_lobes(o);
    if (content == IBL_CONTENT_LUT)
        return f->facts.known & IBL_KNOWN_TABLE
                   ? ibl_texture_set(o->ctx, &f->texture, "iblbake.table",
                                     ibl_lut_name(f->facts.table))
                   : IBL_OK;
    status = ibl_texture_unblock(o->ctx, &f->texture);
    if (!status && content == IBL_CONTENT_SPECULAR)
        status = complete(o, f, f->path);
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
    set->sh_degree = most < IBL_SET_DEGREE ? (int)most : IBL_SET_DEGREE;
    const int count = (set->sh_degree + 1) * (set->sh_degree + 1);
    if (!json_is_integer(degree) || most < 0 ||
        json_array_size(radiance) < (size_t)count)
        return damaged(o, "harmonics are not as many as their degree says");
    for (int i = 0; i < count; i++)
        if (!ibl_json_numbers(json_array_get(radiance, (size_t)i),
                              set->sh + 3 * i, 3))
            return damaged(o, "harmonics are not all numbers");
    return ibl_sh_turn_axes(o->ctx, set->sh_degree, axes, 1, set->sh);
}

/* Reads the lights that were taken out of the map. */
static ibl_status read_lights(const opener *o, ibl_axes axes)
{
    const json_t *list = json_object_get(o->sidecar, "lights"), *entry;
    size_t i;

    if (o->asked.known & IBL_KNOWN_LIGHTS || !o->sidecar)
        return IBL_OK;
    if (json_array_size(list) > IBL_MAX_LIGHTS)
        return damaged(o, "lights are damaged");
    json_array_foreach((json_t *)list, i, entry)
    {
        ibl_light *l = &o->set->light[i];
        const json_t *radius = json_object_get(entry, "radius_rad");
        if (!json_is_number(radius) ||
            !ibl_json_numbers(json_object_get(entry, "direction"), l->direction,
                              3) ||
            !ibl_json_numbers(json_object_get(entry, "irradiance"),
                              l->irradiance, 3) ||
            !ibl_json_numbers(json_object_get(entry, "radiance"), l->radiance,
                              3))
            return damaged(o, "lights are damaged");
        l->radius = json_number_value(radius);
        ibl_axes_turn(axes, 1, l->direction, l->direction);
    }
    o->set->light_count = (int)json_array_size(list);
    return IBL_OK;
}

/* Finds the map: where it was for iblbake, or beside the sidecar; six files
 * only where they were. */
static ibl_status find_source(const opener *o)
{
    const json_t *source = json_object_get(o->sidecar, "source");
    const char *layout = json_string_value(json_object_get(source, "layout"));
    const char *order =
        json_string_value(json_object_get(source, "face_order"));
    const char *hash = json_string_value(json_object_get(source, "xxh3_128"));
    const char *path = json_string_value(json_object_get(source, "path"));
    const int known = layout ? ibl_names_find(ibl_input_names, layout) : -1;
    char near[PATH_BYTES];
    ibl_set *set = o->set;

    set->source_peak = json_number_value(json_object_get(source, "peak"));
    snprintf(set->source_hash, sizeof set->source_hash, "%s", hash ? hash : "");
    set->read.layout = known > 0 ? (ibl_input_layout)known : IBL_INPUT_AUTO;
    if (order && !ibl_face_order_parse(order, set->read.face_order))
        memset(set->read.face_order, 0, IBL_FACES);
    if (path && set->read.layout != IBL_INPUT_FACES && !is_there(path))
        path = beside(o, near, "%s", ibl_path_name(path)) ? near : NULL;
    return path ? keep(o, path, strlen(path), &set->source) : IBL_OK;
}

/* What the sidecar says of the environment. */
static ibl_status read_environment(opener *o)
{
    const ibl_account side =
        ibl_account_of_sidecar(o->sidecar, NULL, o->set->sidecar);
    ibl_account known = {.skip = ibl_account_skip(&o->asked)};
    int ignored;

    ibl_status status = ibl_account_add(o->ctx, &known, &side, &ignored);
    const ibl_axes axes = {(ibl_mirror)known.value[IBL_FACT_MIRROR],
                           (ibl_up)known.value[IBL_FACT_UP]};
    if (!status)
        status = read_harmonics(o, axes);
    if (!status)
        status = read_lights(o, axes);
    return status ? status : find_source(o);
}

/* Sets what all files and the sidecar say, the files first. */
static ibl_status settle(opener *o)
{
    const ibl_account side =
        ibl_account_of_sidecar(o->sidecar, NULL, o->set->sidecar);
    ibl_read_options *read = &o->set->read;
    const double *v = o->all.value;
    int ignored;

    const ibl_status status = ibl_account_add(o->ctx, &o->all, &side, &ignored);
    read->primaries = (ibl_primaries)v[IBL_FACT_PRIMARIES];
    read->transfer = (ibl_transfer)v[IBL_FACT_TRANSFER];
    read->exposure = v[IBL_FACT_EXPOSURE];
    read->clamp = v[IBL_FACT_CLAMP];
    o->set->yaw_deg = v[IBL_FACT_YAW];
    return status;
}

/* ---- the whole --------------------------------------------------------- */

static ibl_status open_set(opener *o)
{
    ibl_set_file *file = o->set->file;
    ibl_texture tex = {0};
    int found = 0;
    ibl_status status = o->path ? locate(o) : IBL_OK;

    if (!status && o->named && o->content < 0) {
        status = read_texture(o, IBL_CONTENT_SPECULAR, o->path, &tex);
        if (!status) {
            o->content = content_by_shape(&tex);
            file[o->content].texture = tex;
        }
    }
    if (!status)
        status = read_environment(o);
    for (int c = 0; c < IBL_CONTENTS && !status; c++) {
        status = find(o, c);
        found += file[c].path && c < IBL_CONTENT_LUT;
    }
    if (!status && !found && o->path && !o->named)
        status = no_set(o);
    for (int c = 0; c < IBL_CONTENTS && !status; c++)
        if (file[c].path && !file[c].missing)
            status = read_file(o, c);
    return status ? status : settle(o);
}

ibl_status ibl_set_open(ibl_ctx *ctx, const char *path,
                        const ibl_set_options *opts, ibl_set *set)
{
    opener o = {.ctx = ctx, .o = defaults, .set = set, .path = path};

    if (!ctx || !set)
        return ibl_missing(ctx, "ibl_set_open: set");
    *set = (ibl_set){
        .read = ibl_read_options_default(), .sh_degree = -1, .light_count = -1};
    set->read.env = ibl_env_decode;
    ibl_status status = ibl_take_options(ctx, opts, &o.o, sizeof o.o);
    if (!status && o.o.facts)
        o.asked = *o.o.facts;
    if (!status)
        status = open_set(&o);
    ibl_probe_index_free(&o.index);
    json_decref(o.sidecar);
    if (status)
        ibl_set_free(set);
    return status;
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
