/* SPDX-License-Identifier: MIT */
/* Opens sets for the viewer, and detects changes of their files. */
#include "view/set_parts.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "engine/engine.h"
#include "ibl/set.h"
#include "view/message.h"

const char *const view_content_names[VIEW_CONTENTS + 1] = {
    "specular", "irradiance",       "brdf_lut",     "skybox",
    "lobe_lut", "charlie_specular", "charlie_table"};

/* ---- files by content and by name -------------------------------------- */

enum {
    MAGIC = 12
};

/* The viewer waits this many times longer for a file that is gone: it may
 * reappear. */
static const double GONE = 12;

bool view_is_model(const char *path)
{
    const char *dot = strrchr(path, '.');

    return dot && (!strcasecmp(dot, ".glb") ||
                   (!strcasecmp(dot, ".gltf") && !ibl_gltf_is_light(path)));
}

/* Whether a file is a texture or JSON; -1: it cannot be read. */
static int is_of_set(const char *path)
{
    char head[MAGIC + 1] = "";
    FILE *file = fopen(path, "rb");
    const size_t got = file ? fread(head, 1, MAGIC, file) : 0;
    const bool failed = !file || ferror(file);

    if (file)
        fclose(file);
    if (failed)
        return -1;
    return (got && ibl_engine_of_name(path)) ||
           head[strspn(head, " \t\r\n")] == '{' ||
           !memcmp(head, "\xABKTX 20\xBB\r\n\x1A\n", MAGIC) ||
           !memcmp(head, "\xABKTX 11\xBB\r\n\x1A\n", MAGIC) ||
           !memcmp(head, "DDS ", 4);
}

bool view_is_map(const char *path, ibl_input_layout layout)
{
    struct stat st;

    if (layout || !strcmp(path, "-"))
        return true;
    if (stat(path, &st))
        return errno == ENOENT && (strstr(path, "%f") || strchr(path, ','));
    if (!S_ISREG(st.st_mode))
        return !S_ISDIR(st.st_mode);
    /* A read that failed once must not turn a map into a set. */
    const int of_set = is_of_set(path);
    return !(of_set < 0 ? is_of_set(path) : of_set);
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

/* ---- what the viewer can show ------------------------------------------- */

static const int views[IBL_CONTENTS + 1] = {
    [IBL_CONTENT_SKYBOX] = VIEW_SKY,
    [IBL_CONTENT_SPECULAR] = VIEW_SPECULAR,
    [IBL_CONTENT_IRRADIANCE] = VIEW_IRRADIANCE,
    [IBL_CONTENT_LUT] = VIEW_LUT,
    [IBL_CONTENT_LOBE_TABLE] = VIEW_LOBES,
    [IBL_CONTENTS] = VIEW_SIDECAR};

static void copy(const char *text, char **to)
{
    free(*to);
    *to = text ? ibl_need(strdup(text)) : NULL;
}

/* Files are seen just before they are read. */
static void see(void *set_of, int content, const char *path)
{
    baked_set *set = set_of;
    set->seen[views[content]] = view_file_stamp_of(path, NULL);
}

/* Turns a flat map, equirectangular or octahedral, into a cube of twice its
 * size, which looks the same. */
static bool make_cube(ibl_ctx *ctx, const char *path, ibl_texture *tex)
{
    const ibl_texel_options as = {.pixel = tex->pixel};
    ibl_cube flat = {0}, cube = {0};
    ibl_texture made = {0};

    const bool ok = !ibl_texture_to_cube(ctx, tex, &flat) &&
                    !ibl_cube_from_flat(ctx, &flat, &cube) &&
                    !ibl_texture_from_cube(ctx, &cube, &as, &made, NULL);
    if (ok) {
        view_note("%s: %dx%d texels, shown by way of a cube of %d", path,
                  tex->width, tex->height, made.width);
        ibl_texture_free(tex);
        *tex = made;
    }
    ibl_cube_free(&flat);
    ibl_cube_free(&cube);
    return ok;
}

/* Takes a texture of a set over, and its path. */
static bool take_file(ibl_ctx *ctx, ibl_set_file *f, view_content content,
                      baked_set *set)
{
    ibl_texture *tex = &set->texture[content];

    if (!f->texture.data)
        return true;
    *tex = f->texture;
    f->texture = (ibl_texture){0};
    set->pixel[content] = f->pixel;
    copy(f->path, &set->path[content]);
    return tex->faces == IBL_FACES || content == VIEW_LUT ||
           content == VIEW_LOBES || make_cube(ctx, f->path, tex);
}

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

/* Says what was not told, and takes what was. */
static bool take_facts(const ibl_set *from, baked_set *set)
{
    const ibl_set_file *f = &from->file[IBL_CONTENT_SPECULAR];
    const ibl_set_file *matte = &from->file[IBL_CONTENT_IRRADIANCE];
    const ibl_set_file *table = &from->file[IBL_CONTENT_LUT];

    set->mapping = f->facts.mapping;
    set->lobe = f->facts.lobe;
    set->lod_scale =
        f->facts.lod_scale > 0 ? f->facts.lod_scale : f->facts.levels - 1;
    set->lod_offset = f->facts.lod_offset;
    memcpy(set->roughness, f->facts.roughness, sizeof set->roughness);
    if (!(f->facts.known & IBL_KNOWN_MAPPING))
        view_note("%s: does not say how it was baked: taken as GGX, %s "
                  "mapping%s, roughness 0 to 1",
                  f->path, ibl_roughness_map_name(set->mapping),
                  set->mapping ? " as cmgen has it" : "");
    set->irradiance_scale =
        set->texture[VIEW_IRRADIANCE].data ? matte->facts.irradiance_scale : 1;
    if (set->texture[VIEW_IRRADIANCE].data &&
        !(matte->facts.known & IBL_KNOWN_SCALE))
        view_note("%s: does not say its scale: taken as irradiance / pi",
                  matte->path);
    set->geometry = table->facts.geometry;
    if (set->texture[VIEW_LUT].data &&
        !(table->facts.known & IBL_KNOWN_GEOMETRY))
        view_note("%s: does not say its geometry: taken as %s", table->path,
                  ibl_geometry_name(set->geometry));
    set->light_count = from->light_count > 0 ? from->light_count : 0;
    memcpy(set->light, from->light, sizeof set->light);
    if (from->sh_degree >= 0)
        view_set_harmonics(set,
                           from->sh_degree < VIEW_SH_DEGREE ? from->sh_degree
                                                            : VIEW_SH_DEGREE,
                           from->sh);
    set->source_read = from->read;
    set->source_yaw = from->yaw_deg;
    set->source_peak = from->source_peak;
    memcpy(set->source_hash, from->source_hash, sizeof set->source_hash);
    copy(from->source, &set->source);
    return true;
}

static bool take_set(ibl_ctx *ctx, const view_request *what, ibl_set *from,
                     baked_set *set)
{
    ibl_set_file *f = from->file, *table = &f[IBL_CONTENT_LUT];
    const ibl_set_file *matte = &f[IBL_CONTENT_IRRADIANCE];

    if (!f[IBL_CONTENT_SPECULAR].texture.data)
        return view_fail("%s: has no specular levels: bake the set again, or "
                         "name its NAME_specular file",
                         what->path);
    /* Any cube is a sky. */
    if (what->irradiance && matte->holds >= 0 &&
        matte->holds != IBL_CONTENT_IRRADIANCE)
        return view_fail("%s: holds %s, where an irradiance map is wanted: "
                         "name another file, or leave --irradiance out",
                         matte->path,
                         ibl_content_name((ibl_content)matte->holds));
    if (table->facts.table && what->lut)
        return view_fail("%s: is a table of kind %s, not the split one: name "
                         "the brdf_lut file, or leave --lut out",
                         table->path, ibl_lut_name(table->facts.table));
    if (table->facts.table) {
        view_note("%s: a table of kind %s: not used", table->path,
                  ibl_lut_name(table->facts.table));
        ibl_texture_free(&table->texture);
    }
    bool ok = true;
    copy(from->name ? from->name : what->path, &set->name);
    copy(from->sidecar, &set->path[VIEW_SIDECAR]);
    for (int c = 0; c < IBL_CONTENTS && ok; c++)
        ok = take_file(ctx, &f[c], (view_content)views[c], set);
    return ok && take_facts(from, set);
}

/* Takes the map that is named, whatever it is, in place of the sidecar's. */
static void name_map(baked_set *set, const char *map)
{
    if (!map)
        return;
    set->source_peak = 0;
    *set->source_hash = '\0';
    copy(map, &set->source);
}

/* Opens the chain of sheen beside the specular one, which is a bake of its own;
 * it is no error if there is none. */
static bool open_sheen(ibl_ctx *ctx, baked_set *set)
{
    ibl_set_options o = ibl_set_options_default();
    ibl_set sheen = {0};
    ibl_set_file *f = &sheen.file[IBL_CONTENT_SPECULAR];
    bool ok = true;

    o.leave = ~(1u << IBL_CONTENT_SPECULAR);
    for (int i = 0; ibl_array_container_names[i] && ok && !f->path; i++) {
        char name[1024];
        snprintf(name, sizeof name, "%.900s_charlie_specular.%s", set->name,
                 ibl_array_container_names[i]);
        char *path = ibl_need(ibl_path_beside(set->path[VIEW_SPECULAR], name));
        set->seen[VIEW_SHEEN] = view_file_stamp_of(path, NULL);
        ok = set->seen[VIEW_SHEEN].size < 0 ||
             !ibl_set_open(ctx, path, &o, &sheen);
        free(path);
    }
    if (ok && f->path)
        ok = (f->facts.lobe == IBL_LOBE_CHARLIE &&
              f->facts.known & IBL_KNOWN_ROUGHNESS)
                 ? take_file(ctx, f, VIEW_SHEEN, set) &&
                       view_set_fill_sheen(ctx, f->facts.roughness,
                                           f->facts.levels, set)
                 : view_fail("%s: does not say the roughness of its levels, or "
                             "is not of the lobe charlie: bake it again",
                             f->path);
    ibl_set_free(&sheen);
    return ok;
}

bool view_set_open(ibl_ctx *ctx, const view_request *what, baked_set *set)
{
    ibl_set_options o = ibl_set_options_default();
    ibl_set from = {0};

    *set = (baked_set){.sh_degree = -1,
                       .irradiance_scale = 1,
                       .own_sky = what->sky,
                       .layer = what->layer};
    o.file[IBL_CONTENT_IRRADIANCE] = what->irradiance;
    o.file[IBL_CONTENT_LUT] = what->lut;
    o.file[IBL_CONTENT_SKYBOX] = what->sky;
    o.layer = what->layer;
    o.reading = see;
    o.cookie = set;
    const bool ok = !ibl_set_open(ctx, what->path, &o, &from) &&
                    take_set(ctx, what, &from, set) && open_sheen(ctx, set);
    name_map(set, what->map);
    ibl_set_free(&from);
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
