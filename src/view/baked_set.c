/* SPDX-License-Identifier: MIT */
/* Sets: their missing textures, reading, baking, and the map that they are of.
 */
#include "view/baked_set.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common/path.h"
#include "common/signals.h"
#include "engine/engine.h"
#include "view/message.h"

enum {
    MOST_COLUMNS = 8192, /* of a map: 400 MB */
    CUBE_COLUMNS = 512   /* of that of a cube */
};

/* ---- harmonics ----------------------------------------------------------- */

void view_harmonics_sum(const double *coefficients, int count, int channels,
                        const double d[3], double *sum)
{
    double y[VIEW_SH_COUNT];

    ibl_sh_at(VIEW_SH_DEGREE, d, y);
    for (int k = 0; k < channels; k++) {
        sum[k] = 0;
        for (int i = 0; i < count; i++)
            sum[k] += coefficients[channels * i + k] * y[i];
    }
}

void view_set_harmonics(baked_set *set, int degree, const double *radiance)
{
    set->sh_degree = degree = degree < VIEW_SH_DEGREE ? degree : VIEW_SH_DEGREE;
    for (int l = 0, i = 0; l <= degree; l++)
        for (int n = 0; n < 3 * (2 * l + 1); n++, i++)
            set->sh[i] = radiance[i] * ibl_sh_cosine(l);
}

/* ---- missing textures ---------------------------------------------------- */

static bool fill_table(ibl_ctx *ctx, ibl_set_file *table)
{
    const ibl_lut_options opts = ibl_lut_options_default();
    ibl_lut lut = {0};

    free(table->path);
    *table = (ibl_set_file){.facts.geometry = opts.geometry};
    const bool ok = !ibl_bake_lut(ctx, &opts, &lut) &&
                    !ibl_texture_from_lut(ctx, &lut, IBL_PIXEL_RG16F,
                                          &table->texture, NULL);

    ibl_lut_free(&lut);
    return ok;
}

/* ---- reading ------------------------------------------------------------- */

/* Turns a flat map, equirectangular or octahedral, into a cube of twice its
 * size, which looks the same; cubes stay. */
static bool make_cube(ibl_ctx *ctx, const char *path, ibl_texture *tex)
{
    const ibl_texel_options as = {.pixel = tex->pixel};
    ibl_cube flat = {0}, cube = {0};
    ibl_texture made = {0};

    if (!tex->data || tex->faces == IBL_FACES)
        return true;
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

/* Checks the files that were named in place of the set's. */
static bool check_kinds(const view_request *what, ibl_set_file *f)
{
    const ibl_set_file *matte = &f[IBL_CONTENT_IRRADIANCE];
    ibl_set_file *table = &f[IBL_CONTENT_LUT];

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
    if (!table->facts.table)
        return true;
    if (what->lut)
        return view_fail("%s: is a table of kind %s, not the split one: name "
                         "the brdf_lut file, or leave --lut out",
                         table->path, ibl_lut_name(table->facts.table));
    view_note("%s: a table of kind %s: not used", table->path,
              ibl_lut_name(table->facts.table));
    ibl_texture_free(&table->texture);
    return true;
}

const char *view_set_lacks(const baked_set *set, view_diffuse by)
{
    return by == VIEW_DIFFUSE_MAP &&
                   !set->baked.file[IBL_CONTENT_IRRADIANCE].texture.data
               ? "is no irradiance map"
           : by == VIEW_DIFFUSE_SH && set->sh_degree < 0
               ? "are no spherical harmonics: the sidecar has them"
               : NULL;
}

static void note_unknown(const ibl_set_file *f, unsigned fact, const char *as)
{
    if (f->path && !f->missing && !(f->facts.known & fact))
        view_note("%s: does not say how it was baked: taken as %s", f->path,
                  as);
}

/* Notes what files and sidecar do not say, and what makes spheres inexact. */
static void note_facts(const ibl_set_file *file)
{
    const ibl_set_file *f = &file[IBL_CONTENT_SPECULAR];
    const ibl_set_file *table = &file[IBL_CONTENT_LUT];

    note_unknown(f, IBL_KNOWN_MAPPING,
                 f->facts.mapping ? "GGX, filament mapping as cmgen has it"
                                  : "GGX, linear mapping, roughness 0 to 1");
    if (f->facts.lobe != IBL_LOBE_GGX)
        view_note("%s: its levels are of the lobe %s: spheres, which are "
                  "shaded by GGX, are only similar",
                  f->path, ibl_lobe_name(f->facts.lobe));
    note_unknown(&file[IBL_CONTENT_IRRADIANCE], IBL_KNOWN_SCALE,
                 "irradiance / pi");
    note_unknown(table, IBL_KNOWN_GEOMETRY,
                 ibl_geometry_name(table->facts.geometry));
}

static void add_defaults(const view_request *what, baked_set *set)
{
    ibl_set *b = &set->baked;
    ibl_set_facts *chain = &b->file[IBL_CONTENT_SPECULAR].facts;

    if (!b->name)
        b->name = ibl_need(strdup(what->path));
    if (chain->lod_scale <= 0)
        chain->lod_scale = chain->levels - 1;
    if (b->light_count < 0)
        b->light_count = 0;
    view_set_harmonics(set, b->sh_degree, b->sh);
    set->diffuse = b->file[IBL_CONTENT_IRRADIANCE].texture.data
                       ? VIEW_DIFFUSE_MAP
                   : set->sh_degree >= 2 && strcmp(b->target, "three") != 0 &&
                           strcmp(b->target, "filament") != 0
                       ? VIEW_DIFFUSE_SH
                       : VIEW_DIFFUSE_LAST;
    /* The map that is named is taken whatever it is. */
    if (what->map) {
        free(b->source);
        b->source = ibl_need(strdup(what->map));
        *b->source_hash = '\0';
    }
}

bool view_set_open(ibl_ctx *ctx, const view_request *what, baked_set *set)
{
    static const ibl_content cubes[] = {
        IBL_CONTENT_SPECULAR, IBL_CONTENT_IRRADIANCE, IBL_CONTENT_SKYBOX};
    ibl_set_options o = ibl_set_options_default();
    ibl_set_file *file = set->baked.file;
    const ibl_set_file *chain = &file[IBL_CONTENT_SPECULAR];

    *set = (baked_set){.own_sky = what->sky, .layer = what->layer};
    o.file[IBL_CONTENT_IRRADIANCE] = what->irradiance;
    o.file[IBL_CONTENT_LUT] = what->lut;
    o.file[IBL_CONTENT_SKYBOX] = what->sky;
    o.layer = what->layer;
    bool ok = !ibl_set_open(ctx, what->path, &o, &set->baked) &&
              check_kinds(what, file);
    for (int i = 0; i < 3 && ok; i++)
        ok = make_cube(ctx, file[cubes[i]].path, &file[cubes[i]].texture);
    const bool has_table = ok && file[IBL_CONTENT_LUT].texture.data;
    if (!ok || (!has_table && !fill_table(ctx, &file[IBL_CONTENT_LUT]))) {
        view_set_free(set);
        return false;
    }
    add_defaults(what, set);
    note_facts(file);
    if (chain->facts.roughness[0] > 0 && !set->baked.source &&
        !file[IBL_CONTENT_SKYBOX].texture.data)
        view_note(
            "%s: its level 0 is of roughness %.3g: without the map, which "
            "--map names, reference and sky are as blurred",
            chain->path, chain->facts.roughness[0]);
    if (!has_table)
        view_note("%s: has no BRDF table: made with the geometry %s",
                  set->baked.name,
                  ibl_geometry_name(file[IBL_CONTENT_LUT].facts.geometry));
    return true;
}

void view_set_free(baked_set *set)
{
    ibl_set_free(&set->baked);
    ibl_image_free(&set->map);
    *set = (baked_set){0};
}

/* ---- baking ----------------------------------------------------------- */

bool view_set_bake_environment(ibl_ctx *ctx, const ibl_environment *env,
                               const ibl_specular_options *specular,
                               baked_set *set)
{
    ibl_bake_options opts = ibl_bake_options_default();
    ibl_lobe_table_options lobes = ibl_lobe_table_options_default();
    ibl_bake_result result = {0};
    ibl_overflow_report beyond = {0};
    ibl_lobe_table table = {0};
    ibl_set_file *file = set->baked.file;

    if (specular)
        opts.specular_options = *specular;
    opts.yaw_deg = opts.specular_options.yaw_deg;
    opts.sh_degree = VIEW_SH_DEGREE;
    bool ok =
        !ibl_bake_environment(ctx, env, &opts, &result) &&
        !ibl_texture_from_cube(ctx, &result.specular, NULL,
                               &file[IBL_CONTENT_SPECULAR].texture, &beyond) &&
        !ibl_texture_from_cube(ctx, &result.irradiance, NULL,
                               &file[IBL_CONTENT_IRRADIANCE].texture, NULL) &&
        fill_table(ctx, &file[IBL_CONTENT_LUT]);
    if (beyond.values)
        view_note("%s: %zu components of its levels are beyond %g, the most "
                  "that is shown: that light is spread over texels around them",
                  set->baked.name, beyond.values,
                  (double)ibl_pixel_max(IBL_PIXEL_RGBA16F));
    if (ok) {
        ibl_set_facts *chain = &file[IBL_CONTENT_SPECULAR].facts;
        lobes.layout = result.report.layout;
        *chain = (ibl_set_facts){.lobe = opts.specular_options.lobe,
                                 .mapping = opts.specular_options.mapping,
                                 .levels = lobes.layout.levels,
                                 .lod_scale = lobes.layout.lod_scale,
                                 .lod_offset = lobes.layout.lod_offset};
        memcpy(chain->roughness, lobes.layout.roughness,
               sizeof chain->roughness);
        file[IBL_CONTENT_IRRADIANCE].facts.irradiance_scale = 1;
        view_set_harmonics(set, VIEW_SH_DEGREE, result.sh);
        ok = specular ||
             (!ibl_bake_lobe_table(ctx, &lobes, &table) &&
              !ibl_texture_from_lobe_table(
                  ctx, &table, &file[IBL_CONTENT_LOBE_TABLE].texture));
    }
    ibl_lobe_table_free(&table);
    ibl_bake_result_free(&result);
    return ok;
}

bool view_set_bake(ibl_ctx *ctx, const view_request *what, baked_set *set)
{
    const char *path = what->path;
    const char *name = ibl_path_name(path), *dot = strrchr(name, '.');
    const size_t stem = dot && dot > name ? (size_t)(dot - name) : strlen(name);
    ibl_source *source;
    struct stat st;

    *set = (baked_set){.baked = {.name = ibl_need(strndup(name, stem)),
                                 .read = ibl_read_options_default()}};
    /* Streams are gone by now; six faces are no file. */
    if (strcmp(path, "-") != 0 && (stat(path, &st) || S_ISREG(st.st_mode)))
        set->baked.source = ibl_need(strdup(path));
    bool ok = !ibl_source_open(ctx, path, &set->baked.read, &source);
    if (ok) {
        const ibl_environment env = ibl_source_environment(source);
        ok = view_set_bake_environment(ctx, &env, NULL, set);
        ibl_source_close(source);
    }
    if (!ok)
        view_set_free(set);
    return ok;
}

/* ---- the map ------------------------------------------------------------ */

static ibl_ctx *reader(void)
{
    ibl_ctx_options o = ibl_ctx_options_default();
    ibl_ctx *ctx;

    o.bridge = ibl_bridge_beside();
    return ibl_need(ibl_ctx_create(&o, &ctx) ? NULL : ctx);
}

/* Makes a map of at most MOST_COLUMNS. False: no memory. */
static bool fit(ibl_ctx *ctx, const char *path, ibl_image *map)
{
    ibl_cube cube = {0};
    ibl_image small = {0};

    if (map->width <= MOST_COLUMNS)
        return true;
    const bool ok =
        !ibl_cube_alloc(ctx, MOST_COLUMNS / 4, 1, &cube) &&
        !ibl_cube_from_latlong(ctx, map, 0, &cube) &&
        !ibl_image_alloc(ctx, MOST_COLUMNS, MOST_COLUMNS / 2, &small) &&
        !ibl_latlong_from_cube(ctx, &cube, &small);
    view_note("%s: %dx%d pixels, shown by %dx%d", path, map->width, map->height,
              MOST_COLUMNS, MOST_COLUMNS / 2);
    ibl_cube_free(&cube);
    ibl_image_free(map);
    *map = small;
    return ok;
}

const ibl_image *view_set_source(const baked_set *set)
{
    baked_set *own = (baked_set *)set;
    const char *path = set->baked.source;
    ibl_read_options read = set->baked.read;
    ibl_read_report report;

    if (set->map.data || set->map_tried || !path)
        return set->map.data ? &set->map : NULL;
    own->map_tried = true;
    read.hash = *set->baked.source_hash != '\0';
    ibl_ctx *ctx = reader();
    const bool ok =
        !ibl_image_read(ctx, path, &read, &own->map, &report) &&
        (!read.hash || !strcmp(set->baked.source_hash, report.hash)) &&
        fit(ctx, path, &own->map);
    ibl_ctx_free(ctx);
    if (ok)
        return &set->map;
    ibl_image_free(&own->map);
    view_note("%s: cannot be read again as it was baked, for the backdrop and "
              "the reference",
              path);
    return NULL;
}

view_environment view_set_lit_by(const baked_set *set)
{
    return set->map.data ? VIEW_BY_MAP
           : set->baked.file[IBL_CONTENT_SPECULAR].facts.roughness[0] > 0 &&
                   set->baked.file[IBL_CONTENT_SKYBOX].texture.data
               ? VIEW_BY_SKY
               : VIEW_BY_LEVEL0;
}

bool view_set_environment(const baked_set *set, ibl_image *map,
                          const char **what)
{
    const bool at_hand = view_set_source(set);
    const bool sky = view_set_lit_by(set) == VIEW_BY_SKY;
    const ibl_set_file *file =
        &set->baked.file[sky ? IBL_CONTENT_SKYBOX : IBL_CONTENT_SPECULAR];
    ibl_cube cube = {0};
    bool clipped = false;

    *what = at_hand ? set->baked.source : sky ? "the skybox" : "level 0";
    *map = set->map;
    if (at_hand)
        return true;
    ibl_ctx *ctx = reader();
    const bool ok =
        !ibl_texture_to_cube(ctx, &file->texture, &cube) &&
        !ibl_image_alloc(ctx, CUBE_COLUMNS, CUBE_COLUMNS / 2, map) &&
        !ibl_latlong_from_cube(ctx, &cube, map);
    for (int i = 0; ok && !sky && i < 3 * IBL_FACES * cube.size * cube.size;
         i++)
        clipped |= cube.data[i] >= ibl_pixel_max(file->pixel);
    ibl_cube_free(&cube);
    ibl_ctx_free(ctx);
    if (ok && !clipped)
        return true;
    ibl_image_free(map);
    return ok ? view_fail("%s: there is no reference: level 0 is clipped by "
                          "%s, and its map is not at hand: name it with --map",
                          set->baked.name, ibl_pixel_name(file->pixel))
              : view_fail("no memory for the reference");
}

/* ---- a bake beside the window ------------------------------------------- */

/* Bakes on a thread with its own context while the window keeps drawing. */
struct view_baker {
    view_request what;
    ibl_ctx *ctx;
    pthread_t thread;
    baked_set set;         /* belongs to the thread until it is joined */
    bool ok;               /* the same */
    _Atomic(double) whole; /* the finished share */
    atomic_bool ended;
};

static void on_progress(void *cookie, const char *stage, double done,
                        double whole)
{
    view_baker *b = cookie;

    (void)stage;
    (void)done;
    b->whole = fmax(b->whole, whole);
}

bool view_baker_poll(view_baker *baker, double *done)
{
    *done = baker->ended ? 1 : baker->whole;
    return baker->ended;
}

static void *run(void *cookie)
{
    view_baker *b = cookie;

    b->ok = view_set_bake(b->ctx, &b->what, &b->set);
    b->ended = true;
    return NULL;
}

view_baker *view_baker_start(const view_request *what)
{
    ibl_ctx_options opts = ibl_ctx_options_default();
    view_baker *b = ibl_need(calloc(1, sizeof *b));

    opts.log = view_log;
    opts.memory = ibl_memory_allowed() / 4 * 3;
    opts.progress = on_progress;
    opts.progress_cookie = b;
    opts.bridge = ibl_bridge_beside();
    b->what = *what;
    if (!ibl_ctx_create(&opts, &b->ctx) &&
        !pthread_create(&b->thread, NULL, run, b))
        return b;
    view_fail("%s: no memory or no threads to bake it", what->path);
    ibl_ctx_free(b->ctx);
    free(b);
    return NULL;
}

bool view_baker_finish(view_baker *baker, baked_set *set)
{
    if (!set)
        ibl_ctx_cancel(baker->ctx);
    pthread_join(baker->thread, NULL);
    const bool ok = set && baker->ok;
    if (set)
        *set = baker->set;
    else
        view_set_free(&baker->set);
    ibl_ctx_free(baker->ctx);
    free(baker);
    return ok;
}
