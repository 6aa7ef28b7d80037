/* SPDX-License-Identifier: MIT */
/* Finds the files of a set by content and by name, reads them and detects
 * changes. */
#include "view/set_parts.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "common/names.h"
#include "common/path.h"
#include "engine/engine.h"
#include "view/message.h"

/* ---- files by content and by name -------------------------------------- */

enum {
    MAGIC = 12
};

/* The viewer waits this many times longer for a file that is gone: it may
 * reappear. */
static const double GONE = 12;

static bool is_texture(const char *head)
{
    return !memcmp(head, "\xABKTX 20\xBB\r\n\x1A\n", MAGIC) ||
           !memcmp(head, "\xABKTX 11\xBB\r\n\x1A\n", MAGIC) ||
           !memcmp(head, "DDS ", 4);
}

view_file_kind view_file_look(const char *path)
{
    char head[MAGIC + 1] = "";
    struct stat st;
    FILE *file;

    if (stat(path, &st))
        return VIEW_FILE_MISSING;
    if (S_ISDIR(st.st_mode))
        return VIEW_FILE_DIRECTORY;
    if (!S_ISREG(st.st_mode))
        return VIEW_FILE_PIPE;
    file = fopen(path, "rb");
    if (!file)
        return VIEW_FILE_MISSING;
    const size_t got = fread(head, 1, MAGIC, file);
    const int error = ferror(file) ? errno : 0;
    fclose(file);
    errno = error;
    if (error)
        return VIEW_FILE_MISSING;
    if (got && ibl_engine_of_name(path))
        return VIEW_FILE_TEXTURE;
    if (head[strspn(head, " \t\r\n")] == '{')
        return VIEW_FILE_JSON;
    return is_texture(head) ? VIEW_FILE_TEXTURE : VIEW_FILE_OTHER;
}

bool view_is_model(const char *path)
{
    const char *dot = strrchr(path, '.');

    return dot && (!strcasecmp(dot, ".glb") ||
                   (!strcasecmp(dot, ".gltf") && !ibl_gltf_is_light(path)));
}

bool view_is_map(const char *path, ibl_input_layout layout)
{
    if (layout || !strcmp(path, "-"))
        return true;
    view_file_kind kind = view_file_look(path);
    /* A read that failed once must not turn a map into a set. */
    if (kind == VIEW_FILE_MISSING && errno != ENOENT)
        kind = view_file_look(path);
    if (kind == VIEW_FILE_MISSING)
        return strstr(path, "%f") || strchr(path, ',');
    return kind == VIEW_FILE_OTHER || kind == VIEW_FILE_PIPE;
}

static size_t stem_length(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot && dot > name ? (size_t)(dot - name) : strlen(name);
}

char *view_file_stem(const char *path)
{
    const char *name = ibl_path_name(path);
    return strndup(name, stem_length(name));
}

bool view_file_no_memory(const char *path)
{
    return view_fail("%s: no memory to open it", path);
}

/* The content whose name is the end of the file's stem: "brdf_lut" itself or
 * after a "_"; VIEW_CONTENTS: none. *length: bytes before the "_", or of the
 * whole stem. */
static view_content content_of(const char *path, size_t *length)
{
    const char *name = ibl_path_name(path);
    const size_t all = stem_length(name);

    *length = all;
    /* charlie_specular before specular */
    for (int i = VIEW_CONTENTS - 1; i >= 0; i--) {
        const char *word = view_content_names[i];
        const size_t size = strlen(word), before = all - size;
        if (all < size || memcmp(name + before, word, size) != 0)
            continue;
        if (before == 0 && i == VIEW_LUT)
            return VIEW_LUT;
        if (before < 2 || name[before - 1] != '_')
            continue;
        *length = before - 1;
        return (view_content)i;
    }
    return VIEW_CONTENTS;
}

static int choose_specular(const struct dirent *entry)
{
    const char *name = entry->d_name, *dot = strrchr(name, '.');
    size_t length;

    if (*name != '.' && ibl_engine_of_name(name))
        return true;
    return *name != '.' && dot &&
           ibl_names_find(ibl_array_container_names, dot + 1) >= 0 &&
           content_of(name, &length) == VIEW_SPECULAR;
}

/* The specular file of a directory; the caller must free it. */
static char *find_in_directory(const char *path)
{
    struct dirent **names = NULL;
    char *found = NULL;
    const int count = scandir(path, &names, choose_specular, alphasort);

    if (count < 0)
        view_fail("%s: cannot be read: %s", path, strerror(errno));
    else if (count == 0)
        view_fail("%s: has no NAME_specular.ktx2, .ktx or .dds: bake a map "
                  "into it (iblbake MAP -o %s), or name another directory, a "
                  "specular file or a map",
                  path, path);
    else if (count > 1)
        view_fail("%s: holds %d sets, from %s to %s: name one of its files",
                  path, count, names[0]->d_name, names[count - 1]->d_name);
    else if (!(found = ibl_path_join(path, names[0]->d_name)))
        view_file_no_memory(path);
    for (int i = 0; i < count; i++)
        free(names[i]);
    free(names);
    return found;
}

/* The specular file of a directory, or path itself; the caller must free it.
 * NULL, with a message. */
static char *find_specular(const char *path)
{
    const view_file_kind kind = view_file_look(path);
    char *found = NULL;

    if (kind == VIEW_FILE_DIRECTORY)
        return find_in_directory(path);
    if (kind == VIEW_FILE_JSON)
        view_fail("%s: is JSON, no texture: name the NAME_specular file beside "
                  "it, or the directory",
                  path);
    else if (!(found = strdup(path)))
        view_file_no_memory(path);
    return found;
}

void view_set_see(baked_set *set, int i)
{
    view_files_see(&set->path[i], 1, &set->seen[i]);
}

void view_set_seen(baked_set *set)
{
    view_files_see(set->path, VIEW_FILES, set->seen);
}

bool view_set_changed(const baked_set *set, double settle)
{
    return view_files_changed(set->path, VIEW_FILES, set->seen, settle,
                              GONE * settle);
}

/* A set that is being opened. */
typedef struct opener {
    ibl_ctx *ctx;
    baked_set *set;
    json_t *sidecar; /* or NULL */
    ibl_axes axes;   /* of the specular file */
} opener;

/* ---- the other files -------------------------------------------------- */

bool view_file_take(char *path, const char *of, char **out)
{
    struct stat st;

    if (!path)
        return view_file_no_memory(of);
    if (!stat(path, &st) && S_ISREG(st.st_mode))
        *out = path;
    else
        free(path);
    return true;
}

/* Sets *out to the path of a file beside the specular one, if it exists. False:
 * no memory. */
static bool try_name(const opener *o, const char *name, char **out)
{
    return view_file_take(ibl_path_beside(o->set->path[VIEW_SPECULAR], name),
                          o->set->name, out);
}

/* Finds the file of a content: first the one that the sidecar names, then the
 * one that iblbake would write beside the specular file, then other extensions.
 * The stems of tables are without a name. *out NULL: not found. */
static bool find_beside(const opener *o, view_content content, char **out)
{
    const char *listed = view_sidecar_file(o->sidecar, content);
    const char *dot = strrchr(ibl_path_name(o->set->path[VIEW_SPECULAR]), '.');
    char own[1024], name[1024];
    const char *const own_stems[] = {own, NULL};
    const char *const lobe_stems[] = {own, "lobe_lut", NULL};

    *out = NULL;
    if (listed && !try_name(o, listed, out))
        return false;
    snprintf(own, sizeof own, "%s_%s", o->set->name,
             view_content_names[content]);
    for (const char *const *stem = content == VIEW_LUT     ? ibl_lut_stems
                                   : content == VIEW_LOBES ? lobe_stems
                                                           : own_stems;
         *stem; stem++)
        for (int i = -1; i < IBL_CONTAINER_COUNT && !*out; i++) {
            snprintf(name, sizeof name, "%.1000s.%s", *stem,
                     i >= 0 ? ibl_container_extension((ibl_container)i)
                     : dot  ? dot + 1
                            : "ktx2");
            if (!try_name(o, name, out))
                return false;
        }
    return true;
}

/* ---- what fits -------------------------------------------------------- */

/* Names of the contents in messages, and the advice about a file of the wrong
 * kind. */
static const struct {
    const char *words, *remedy;
} contents[VIEW_CONTENTS] = {
    {"a specular chain",
     "name the NAME_specular file, and others with --irradiance and --lut"},
    {"an irradiance map",
     "name the NAME_irradiance file, or leave --irradiance out"},
    {"a BRDF table", "name the brdf_lut file, or leave --lut out"},
    {"a skybox",
     "name the NAME_skybox file or another cube, or leave --sky out"},
    {"a table of lobes", "bake the set again, or take that file away"},
    {"a chain of sheen", "bake the set again, or take that file away"},
    {"a table of sheen", ""},
};

/* Reports what a file is instead of a content. */
static bool wrong(const char *path, view_content wanted, const char *fmt, ...)
{
    char is[128];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(is, sizeof is, fmt, ap);
    va_end(ap);
    return view_fail("%s: %s, where %s is wanted: %s", path, is,
                     contents[wanted].words, contents[wanted].remedy);
}

static bool check_shape(const ibl_texture *tex, const char *path,
                        view_content wanted)
{
    const char *pixel = ibl_pixel_name(tex->pixel);
    const bool lut = wanted == VIEW_LUT, lobes = wanted == VIEW_LOBES;
    const char *table = lut ? ibl_texture_get(tex, "iblbake.table") : NULL;
    const int layers = lobes ? IBL_LOBE_LAYERS : 1;

    if (table)
        return wrong(path, wanted,
                     "is a table of kind %.40s, not the split one", table);
    if (tex->faces == 1 && !lut && !lobes &&
        ibl_pixel_channels(tex->pixel) == 3)
        return true; /* flat maps: see make_cube */
    if ((tex->faces == 1) != (lut || lobes))
        return wrong(path, wanted, "is a %s (%dx%d, %s)",
                     lut || lobes ? "cube" : "flat texture", tex->width,
                     tex->height, pixel);
    if ((ibl_pixel_channels(tex->pixel) == 2) != lut)
        return wrong(path, wanted, "has %s texels, not %s", pixel,
                     lut ? "two channels, rg16f or rg32f" : "colour");
    if (tex->layers != layers && !(lobes && 2 * tex->layers == layers))
        return wrong(path, wanted, "has %d layers, not %d", tex->layers,
                     layers);
    if ((lut || lobes) && tex->width != tex->height)
        return wrong(path, wanted, "is %dx%d and not square", tex->width,
                     tex->height);
    return tex->width <= IBL_MAX_CUBE_SIZE ||
           view_fail("%s: is %dx%d, more than %d: bake it smaller", path,
                     tex->width, tex->height, IBL_MAX_CUBE_SIZE);
}

/* Checks the content by keys, sidecar or, last, file name. Any cube can be a
 * sky. */
static bool check_content(const char *path, view_content wanted,
                          const ibl_about *about)
{
    const char *word = about->word[IBL_ABOUT_CONTENT];
    size_t length;
    const int found = word ? ibl_names_find(view_content_names, word)
                           : (int)content_of(path, &length);

    if (found < 0)
        return wrong(path, wanted, "holds %.40s", word);
    return found == VIEW_CONTENTS || found == (int)wanted ||
           wanted == VIEW_SKY || wanted == VIEW_SHEEN ||
           wrong(path, wanted, "holds %s", contents[found].words);
}

/* Turns a cube to the axes of the world. */
static bool turn_back(const opener *o, ibl_texture *tex, const ibl_about *about)
{
    const ibl_axes axes = ibl_about_axes(about);

    return tex->faces == 1 || (!axes.mirror && !axes.up) ||
           !ibl_texture_turn_axes(o->ctx, tex, axes, 1);
}

/* Turns a flat map, equirectangular or octahedral, into a cube of twice its
 * size, which looks the same. Keeps the keys. */
static bool make_cube(const opener *o, const char *path, ibl_texture *tex)
{
    const ibl_texel_options as = {.struct_size = sizeof as,
                                  .pixel = tex->pixel};
    ibl_cube flat = {0}, cube = {0};
    ibl_texture made = {0};

    if (tex->layers != 1)
        return view_fail("%s: has %d layers, where a map has 1", path,
                         tex->layers);
    const bool ok = !ibl_texture_to_cube(o->ctx, tex, &flat) &&
                    !ibl_cube_from_flat(o->ctx, &flat, &cube) &&
                    !ibl_texture_from_cube(o->ctx, &cube, &as, &made, NULL);
    if (ok) {
        view_note("%s: %dx%d texels, shown by way of a cube of %d", path,
                  tex->width, tex->height, made.width);
        made.keys = tex->keys;
        made.key_count = tex->key_count;
        tex->keys = NULL;
        tex->key_count = 0;
        ibl_texture_free(tex);
        *tex = made;
    }
    ibl_cube_free(&flat);
    ibl_cube_free(&cube);
    return ok;
}

/* Reads the file of a content and how it was baked. */
static bool load(opener *o, view_content content, ibl_about *about)
{
    ibl_texture *tex = &o->set->texture[content];
    const char *path = o->set->path[content];
    const view_file_kind kind = view_file_look(path);

    if (kind == VIEW_FILE_MISSING)
        return view_fail("%s: cannot be opened: %s", path, strerror(errno));
    if (kind != VIEW_FILE_TEXTURE && kind != VIEW_FILE_PIPE)
        return wrong(path, content, "is no KTX2, KTX or DDS");
    view_set_see(o->set, content);
    if (ibl_engine_read(o->ctx, path,
                        content <= VIEW_IRRADIANCE ? o->set->layer : -1, tex) ||
        !check_shape(tex, path, content))
        return false;
    o->set->pixel[content] = tex->pixel;
    const bool flat =
        tex->faces == 1 && content != VIEW_LUT && content != VIEW_LOBES;
    return !ibl_texture_unblock(o->ctx, tex) &&
           (!flat || make_cube(o, path, tex)) &&
           view_about_read(o->set, content, o->sidecar, about) &&
           check_content(path, content, about) && turn_back(o, tex, about);
}

/* ---- the specular chain ----------------------------------------------- */

/* Reports properties that make the spheres inexact. */
static void note_misfits(const baked_set *set)
{
    if (set->lobe != IBL_LOBE_GGX)
        view_note("%s: its levels are of the lobe %s: spheres, which are "
                  "shaded by GGX, are only similar",
                  set->path[VIEW_SPECULAR], ibl_lobe_name(set->lobe));
    if (set->roughness[0] > 0 && !set->source && !set->texture[VIEW_SKY].data)
        view_note(
            "%s: its level 0 is of roughness %.3g: without the map, which "
            "--map names, reference and sky are as blurred",
            set->path[VIEW_SPECULAR], set->roughness[0]);
}

static bool take_specular(baked_set *set, const ibl_about *a)
{
    const char *path = set->path[VIEW_SPECULAR];
    const ibl_texture *tex = &set->texture[VIEW_SPECULAR];
    const char *mapping = a->word[IBL_ABOUT_MAPPING];
    const int levels = tex->levels, told = a->levels;
    const bool cmgen = !mapping && ibl_texture_get(tex, "sh");

    set->mapping = cmgen ? IBL_ROUGHNESS_FILAMENT
                         : (ibl_roughness_map)a->value[IBL_ABOUT_MAPPING];
    set->lobe = (ibl_lobe)a->value[IBL_ABOUT_LOBE];
    if (!mapping)
        view_note("%s: does not say how it was baked: taken as GGX, %s "
                  "mapping%s, roughness 0 to 1",
                  path, ibl_roughness_map_name(set->mapping),
                  cmgen ? " as cmgen has it" : "");
    set->lod_scale = a->has_lod ? a->lod_scale : levels - 1;
    set->lod_offset = a->lod_offset;
    if (told && told != levels)
        return view_fail("%s: says the roughness of %d levels and has %d: "
                         "bake it again",
                         path, told, levels);
    for (int l = 0; l < levels; l++)
        set->roughness[l] = told ? a->roughness[l]
                                 : ibl_level_roughness(set->mapping, l, levels);
    return true;
}

/* Sets the name and reads the sidecar of a specular file. */
static bool open_sidecar(opener *o, const char *path)
{
    baked_set *set = o->set;
    size_t length;

    content_of(path, &length);
    set->name = strndup(ibl_path_name(path), length);
    if (!set->name)
        return view_file_no_memory(path);
    char name[1024];
    snprintf(name, sizeof name, "%s.json", set->name);
    set->path[VIEW_SIDECAR] = ibl_path_beside(path, name);
    if (!set->path[VIEW_SIDECAR])
        return view_file_no_memory(path);
    view_set_see(set, VIEW_SIDECAR);
    if (!view_sidecar_open(set->path[VIEW_SIDECAR], &o->sidecar))
        return false;
    if (!o->sidecar) {
        free(set->path[VIEW_SIDECAR]);
        set->path[VIEW_SIDECAR] = NULL;
    }
    return true;
}

static bool open_specular(opener *o, const char *path)
{
    char *found = o->set->path[VIEW_SPECULAR] = find_specular(path);
    ibl_about about;

    if (!found || !open_sidecar(o, found) || !load(o, VIEW_SPECULAR, &about))
        return false;
    o->axes = ibl_about_axes(&about);
    return take_specular(o->set, &about);
}

/* Leaves out a table of lobes for other levels: several bakes in one directory
 * share its name. */
static void check_chain(baked_set *set, const ibl_about *a)
{
    if (ibl_about_fits(a, set->roughness, set->texture[VIEW_SPECULAR].levels))
        return;
    view_note("%s: left out: for levels of other roughness than those of %s",
              set->path[VIEW_LOBES], set->path[VIEW_SPECULAR]);
    ibl_texture_free(&set->texture[VIEW_LOBES]);
}

/* Opens the named file, or the one beside; it is no error if there is none. */
static bool open_other(opener *o, view_content content, const char *named)
{
    baked_set *set = o->set;
    char **path = &set->path[content];
    ibl_about about;

    if (named && !(*path = strdup(named)))
        return view_file_no_memory(named);
    if (!named && !find_beside(o, content, path))
        return false;
    if (!*path)
        return true;
    if (!load(o, content, &about))
        return false;
    if (content == VIEW_LOBES)
        check_chain(set, &about);
    if (content == VIEW_LUT) {
        set->geometry = (ibl_geometry)about.value[IBL_ABOUT_GEOMETRY];
        if (!about.word[IBL_ABOUT_GEOMETRY])
            view_note("%s: does not say its geometry: taken as %s", *path,
                      ibl_geometry_name(set->geometry));
    }
    if (content == VIEW_IRRADIANCE) {
        set->irradiance_scale = about.value[IBL_ABOUT_SCALE] > 0 ? 1 / M_PI : 1;
        if (!about.word[IBL_ABOUT_SCALE])
            view_note("%s: does not say its scale: taken as irradiance / pi",
                      *path);
    }
    return true;
}

/* Takes the map that is named, whatever it is, in place of the sidecar's. */
static bool name_map(baked_set *set, const char *map)
{
    if (!map)
        return true;
    free(set->source);
    set->source = strdup(map);
    set->source_peak = 0;
    *set->source_hash = '\0';
    return set->source || view_file_no_memory(map);
}

/* Opens the chain of sheen beside the specular one, which is a bake of its own;
 * it is no error if there is none. */
static bool open_sheen(const opener *o)
{
    baked_set *set = o->set;
    opener of = {.ctx = o->ctx, .set = set};
    char name[1024], *side;
    ibl_about about;

    if (!find_beside(o, VIEW_SHEEN, &set->path[VIEW_SHEEN]))
        return false;
    if (!set->path[VIEW_SHEEN])
        return true;
    snprintf(name, sizeof name, "%.1000s_charlie.json", set->name);
    side = ibl_path_beside(set->path[VIEW_SHEEN], name);
    const bool ok = side && view_sidecar_open(side, &of.sidecar) &&
                    load(&of, VIEW_SHEEN, &about);
    free(side);
    json_decref(of.sidecar);
    if (!ok || about.value[IBL_ABOUT_LOBE] != IBL_LOBE_CHARLIE)
        return ok && view_fail("%s: is not of the lobe charlie: bake it again",
                               set->path[VIEW_SHEEN]);
    const int levels = set->texture[VIEW_SHEEN].levels;
    if (about.levels != levels)
        return view_fail("%s: does not say the roughness of its levels: bake "
                         "it again",
                         set->path[VIEW_SHEEN]);
    return view_set_fill_sheen(o->ctx, about.roughness, levels, set);
}

bool view_set_open(ibl_ctx *ctx, const view_request *what, baked_set *set)
{
    opener o = {.ctx = ctx, .set = set};

    *set = (baked_set){.sh_degree = -1,
                       .irradiance_scale = 1,
                       .own_sky = what->sky,
                       .layer = what->layer};
    const bool ok = open_specular(&o, what->path) &&
                    open_other(&o, VIEW_IRRADIANCE, what->irradiance) &&
                    open_other(&o, VIEW_LUT, what->lut) &&
                    open_other(&o, VIEW_SKY, what->sky) &&
                    open_other(&o, VIEW_LOBES, NULL) && open_sheen(&o) &&
                    view_sidecar_read(ctx, o.sidecar, o.axes, set) &&
                    name_map(set, what->map);
    json_decref(o.sidecar);
    if (ok && !set->texture[VIEW_LUT].data)
        view_note("%s: has no BRDF table: made with the geometry %s", set->name,
                  ibl_geometry_name(IBL_GEOMETRY_SMITH));
    if (ok)
        note_misfits(set);
    if (ok && view_set_fill(ctx, set))
        return true;
    view_set_free(set);
    return false;
}

void view_set_free(baked_set *set)
{
    for (int i = 0; i < VIEW_CONTENTS; i++)
        ibl_texture_free(&set->texture[i]);
    for (int i = 0; i < VIEW_FILES; i++)
        free(set->path[i]);
    free(set->source);
    free(set->name);
    *set = (baked_set){0};
}
