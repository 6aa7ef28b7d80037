/* SPDX-License-Identifier: MIT */
/* Bakes sets, and makes the textures that a set lacks from those it has. */
#include "view/set_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/path.h"
#include "common/signals.h"
#include "view/message.h"

enum {
    SH_EDGE = 16,     /* of an irradiance map made from harmonics */
    MOST_EDGE = 1024, /* of the reference's environment */
    LAST_EDGE = 8     /* smaller levels are too coarse for irradiance */
};

/* Highest roughness of a level 0 that is summed: alpha 0.04 widens the cosine's
 * lobe by less than a texel. */
#define SMOOTH 0.2

static const ibl_texel_options floats = {.pixel = IBL_PIXEL_RGBA32F,
                                         .overflow = IBL_OVERFLOW_CLIP};

/* Decodes a level of the chain into level 0 of a cube; negative and non-finite
 * values become 0. Returns the largest component. */
static float decode_level(const baked_set *set, int level, const ibl_cube *cube)
{
    const ibl_texture *tex = &set->texture[VIEW_SPECULAR];
    const size_t texels = (size_t)IBL_FACES * cube->size * cube->size;
    float *dst = cube->data, peak = 0;

    ibl_pixel_decode(tex->pixel, tex->data + ibl_texture_offset(tex, level, 0),
                     texels, dst);
    for (size_t i = 0; i < 3 * texels; i++) {
        if (!isfinite(dst[i]) || dst[i] < 0)
            dst[i] = 0;
        peak = fmaxf(peak, dst[i]);
    }
    return peak;
}

/* ---- irradiance ------------------------------------------------------ */

static ibl_status irradiance_of_level0(ibl_ctx *ctx, const ibl_cube *level0,
                                       ibl_cube *out)
{
    const ibl_irradiance_options opts = ibl_irradiance_options_default();
    const int width = ibl_latlong_width(level0->size);
    ibl_image map = {0};

    ibl_status status = ibl_image_alloc(ctx, width, width / 2, &map);
    if (!status)
        status = ibl_latlong_from_cube(ctx, level0, &map);
    if (!status)
        status = ibl_bake_irradiance(ctx, &map, &opts, out);
    ibl_image_free(&map);
    return status;
}

void view_set_harmonics(baked_set *set, int degree, const double *radiance)
{
    set->sh_degree = degree;
    for (int l = 0, i = 0; l <= degree; l++)
        for (int n = 0; n < 3 * (2 * l + 1); n++, i++)
            set->sh[i] = radiance[i] * ibl_sh_cosine(l);
}

static ibl_status irradiance_of_sh(ibl_ctx *ctx, const baked_set *set,
                                   ibl_cube *out)
{
    const int count = (set->sh_degree + 1) * (set->sh_degree + 1);
    const ibl_status status = ibl_cube_alloc(ctx, SH_EDGE, 1, out);

    if (!status)
        view_harmonics_cube(set->sh, count, 3, SH_EDGE, out->data);
    return status;
}

/* At roughness 1 GGX and Phong equal the cosine lobe. */
static bool last_is_irradiance(const baked_set *set)
{
    const ibl_texture *tex = &set->texture[VIEW_SPECULAR];
    return tex->levels > 1 && set->lobe != IBL_LOBE_CHARLIE &&
           set->roughness[tex->levels - 1] > 1 - 1e-6 &&
           ibl_cube_edge(tex->width, tex->levels - 1) >= LAST_EDGE;
}

static ibl_status irradiance_of_last(ibl_ctx *ctx, const baked_set *set,
                                     ibl_cube *out)
{
    const ibl_texture *tex = &set->texture[VIEW_SPECULAR];
    const int edge = ibl_cube_edge(tex->width, tex->levels - 1);
    const ibl_status status = ibl_cube_alloc(ctx, edge, 1, out);

    if (!status)
        decode_level(set, tex->levels - 1, out);
    return status;
}

/* *from names the source, for a note. */
static ibl_status make_irradiance(ibl_ctx *ctx, const baked_set *set,
                                  ibl_cube *level0, ibl_cube *out,
                                  const char **from)
{
    const float most = ibl_pixel_max(set->pixel[VIEW_SPECULAR]);
    /* Level 0 is neither blurred nor clipped by its pixel format. */
    const bool whole =
        decode_level(set, 0, level0) < most && set->roughness[0] <= SMOOTH;

    if (!whole && last_is_irradiance(set)) {
        *from = "the last specular level, of roughness 1";
        return irradiance_of_last(ctx, set, out);
    }
    if (!whole && set->sh_degree >= 2) {
        *from = "the spherical harmonics";
        return irradiance_of_sh(ctx, set, out);
    }
    *from = whole ? "the sum over level 0"
                  : "the sum over level 0, as blurred or clipped as it is";
    return irradiance_of_level0(ctx, level0, out);
}

static bool fill_irradiance(ibl_ctx *ctx, baked_set *set)
{
    const int size = set->texture[VIEW_SPECULAR].width;
    ibl_cube level0 = {0}, cube = {0};
    const char *from = "";

    ibl_status status = ibl_cube_alloc(ctx, size, 1, &level0);
    if (!status)
        status = make_irradiance(ctx, set, &level0, &cube, &from);
    ibl_cube_free(&level0);
    if (!status)
        status = ibl_texture_from_cube(ctx, &cube, &floats,
                                       &set->texture[VIEW_IRRADIANCE], NULL);
    ibl_cube_free(&cube);
    set->irradiance_scale = 1;
    if (status == IBL_ERR_MEMORY)
        return view_fail("%s: no memory to make its irradiance", set->name);
    if (!status)
        view_note("%s: has no irradiance map: taken from %s", set->name, from);
    return !status;
}

/* ---- the table -------------------------------------------------------- */

static bool fill_lut(ibl_ctx *ctx, baked_set *set)
{
    ibl_lut_options opts = ibl_lut_options_default();
    ibl_lut lut = {0};

    ibl_status status = ibl_bake_lut(ctx, &opts, &lut);
    if (!status)
        status = ibl_texture_from_lut(ctx, &lut, IBL_PIXEL_RG16F,
                                      &set->texture[VIEW_LUT], NULL);
    ibl_lut_free(&lut);
    set->geometry = opts.geometry;
    return !status;
}

bool view_set_fill(ibl_ctx *ctx, baked_set *set)
{
    if (!set->texture[VIEW_LUT].data && !fill_lut(ctx, set))
        return false;
    return set->texture[VIEW_IRRADIANCE].data || fill_irradiance(ctx, set);
}

double view_level_at(const double *roughness, int levels, double r)
{
    int i = 0;

    while (i + 2 < levels && r > roughness[i + 1])
        i++;
    const double step = roughness[levels > 1 ? i + 1 : i] - roughness[i];
    return step > 0 ? i + fmin(fmax((r - roughness[i]) / step, 0), 1) : i;
}

bool view_set_fill_sheen(ibl_ctx *ctx, const double *roughness, int levels,
                         baked_set *set)
{
    const ibl_lut_options opts = {.size = 32, .kind = IBL_LUT_CHARLIE};
    ibl_lut lut = {0};
    ibl_status status = ibl_bake_lut(ctx, &opts, &lut);

    for (int i = 0; !status && i < opts.size * opts.size; i++)
        lut.data[2 * i + 1] = (float)view_level_at(
            roughness, levels, (i / opts.size + 0.5) / opts.size);
    if (!status)
        status = ibl_texture_from_lut(ctx, &lut, IBL_PIXEL_RG32F,
                                      &set->texture[VIEW_SHEEN_TABLE], NULL);
    ibl_lut_free(&lut);
    return !status;
}

static bool fill_lobes(ibl_ctx *ctx, const ibl_specular_layout *layout,
                       baked_set *set)
{
    ibl_lobe_table_options opts = ibl_lobe_table_options_default();
    ibl_lobe_table table = {0};

    opts.layout = *layout;
    ibl_status status = ibl_bake_lobe_table(ctx, &opts, &table);
    if (!status)
        status =
            ibl_texture_from_lobe_table(ctx, &table, &set->texture[VIEW_LOBES]);
    ibl_lobe_table_free(&table);
    return !status;
}

/* ---- baking ----------------------------------------------------------- */

static bool take(ibl_ctx *ctx, const ibl_bake_result *result,
                 const ibl_specular_options *opts, baked_set *set)
{
    const ibl_specular_layout *layout = &result->report.layout;
    ibl_overflow_report beyond = {0};

    if (ibl_texture_from_cube(ctx, &result->specular, NULL,
                              &set->texture[VIEW_SPECULAR], &beyond) ||
        ibl_texture_from_cube(ctx, &result->irradiance, NULL,
                              &set->texture[VIEW_IRRADIANCE], NULL))
        return false;
    if (beyond.values)
        view_note("%s: %zu components of its levels are beyond %g, the most "
                  "that is shown: that light is spread over texels around them",
                  set->name, beyond.values,
                  (double)ibl_pixel_max(IBL_PIXEL_RGBA16F));
    set->mapping = opts->mapping;
    set->lobe = opts->lobe;
    set->lod_scale = layout->lod_scale;
    set->lod_offset = layout->lod_offset;
    memcpy(set->roughness, layout->roughness, sizeof set->roughness);
    set->irradiance_scale = 1;
    view_set_harmonics(set, VIEW_SH_DEGREE, result->sh);
    return view_set_fill(ctx, set);
}

bool view_set_bake_environment(ibl_ctx *ctx, const ibl_environment *env,
                               const ibl_specular_options *specular,
                               baked_set *set)
{
    ibl_bake_options opts = ibl_bake_options_default();
    ibl_bake_result result = {0};

    if (specular)
        opts.specular_options = *specular;
    opts.yaw_deg = opts.specular_options.yaw_deg;
    opts.sh_degree = VIEW_SH_DEGREE;
    const bool ok = !ibl_bake_environment(ctx, env, &opts, &result) &&
                    take(ctx, &result, &opts.specular_options, set) &&
                    (specular || fill_lobes(ctx, &result.report.layout, set));
    ibl_bake_result_free(&result);
    return ok;
}

static bool bake_source(ibl_ctx *ctx, const char *path, baked_set *set)
{
    ibl_source *source;

    if (ibl_source_open(ctx, path, &set->source_read, &source))
        return false;
    const ibl_environment env = ibl_source_environment(source);
    const bool ok = view_set_bake_environment(ctx, &env, NULL, set);
    ibl_source_close(source);
    return ok;
}

bool view_set_bake(ibl_ctx *ctx, const view_request *what, baked_set *set)
{
    const char *path = what->path;
    const char *name = ibl_path_name(path), *dot = strrchr(name, '.');
    const size_t stem = dot && dot > name ? (size_t)(dot - name) : strlen(name);
    const bool six =
        strcmp(path, "-") != 0 && view_file_stamp_of(path, NULL).size < 0;

    *set = (baked_set){.name = ibl_need(strndup(name, stem)),
                       .source_read = ibl_read_options_default()};
    set->source_read.layout = what->layout;
    set->source_read.transfer = what->transfer;
    memcpy(set->source_read.face_order, what->face_order,
           sizeof what->face_order);
    set->path[VIEW_MAP] = ibl_need(strdup(path));
    view_files_see(&set->path[VIEW_MAP], 1, &set->seen[VIEW_MAP]);
    const bool is_again = set->seen[VIEW_MAP].size >= 0 || six;
    if (is_again)
        set->source = ibl_need(strdup(path));
    if (bake_source(ctx, path, set))
        return true;
    view_set_free(set);
    return false;
}

/* ---- the reference's environment ---------------------------------------- */

static ibl_ctx *reader(void)
{
    ibl_ctx_options o = ibl_ctx_options_default();
    ibl_ctx *ctx;

    o.bridge = ibl_bridge_beside();
    return ibl_ctx_create(&o, &ctx) ? NULL : ctx;
}

bool view_set_map(const baked_set *set, ibl_image *map)
{
    ibl_ctx *ctx = set->source ? reader() : NULL;
    ibl_read_options read = set->source_read;
    ibl_read_report report;

    *map = (ibl_image){0};
    if (!set->source)
        return false;
    read.hash = *set->source_hash != '\0';
    const ibl_status status =
        ctx ? ibl_image_read(ctx, set->source, &read, map, &report)
            : IBL_ERR_MEMORY;
    bool ok = !status;
    /* Otherwise another map, or another layer of it. */
    ok = ok &&
         (set->source_peak <= 0 || (float)set->source_peak == report.peak) &&
         (!read.hash || !strcmp(set->source_hash, report.hash));
    if (!ok) {
        ibl_image_free(map);
        view_note("%s: %s, for the backdrop and the reference", set->source,
                  status == IBL_ERR_MEMORY
                      ? "no memory or threads to read it again"
                      : "cannot be read again as it was baked");
    }
    ibl_ctx_free(ctx);
    return ok;
}

/* As fine as the map and as level 0. */
static ibl_status cube_of_map(ibl_ctx *ctx, const baked_set *set,
                              const ibl_image *map, ibl_texture *env)
{
    const int fine = map->width / 4 < MOST_EDGE ? map->width / 4 : MOST_EDGE;
    const int least = set->texture[VIEW_SPECULAR].width;
    ibl_cube cube = {0};

    ibl_status status =
        ibl_cube_alloc(ctx, fine > least ? fine : least, 1, &cube);
    if (!status)
        status = ibl_cube_from_latlong(ctx, map, set->source_yaw, &cube);
    if (!status)
        status = ibl_texture_from_cube(ctx, &cube, &floats, env, NULL);
    ibl_cube_free(&cube);
    return status;
}

/* Level 0 or the skybox; NULL: its format clips it. */
static const char *name_of_cube(const baked_set *set)
{
    const ibl_texture *tex = &set->texture[VIEW_SPECULAR];
    ibl_cube level0 = {0};

    if (set->roughness[0] > 0 && set->texture[VIEW_SKY].data)
        return "the skybox";
    ibl_ctx *ctx = reader();
    const bool clipped = ctx && !ibl_cube_alloc(ctx, tex->width, 1, &level0) &&
                         decode_level(set, 0, &level0) >=
                             ibl_pixel_max(set->pixel[VIEW_SPECULAR]);
    ibl_cube_free(&level0);
    ibl_ctx_free(ctx);
    return clipped ? NULL : "level 0";
}

bool view_set_environment(const baked_set *set, ibl_texture *env,
                          const char **what)
{
    ibl_image map;

    *env = (ibl_texture){0};
    *what = set->source;
    if (view_set_map(set, &map)) {
        ibl_ctx *ctx = reader();
        const bool ok = ctx && !cube_of_map(ctx, set, &map, env);
        ibl_ctx_free(ctx);
        ibl_image_free(&map);
        return ok || view_fail("no memory for the reference");
    }
    *what = name_of_cube(set);
    return *what ||
           view_fail("%s: there is no reference: level 0 is clipped by %s, and "
                     "its map is not at hand: name it with --map",
                     set->name, ibl_pixel_name(set->pixel[VIEW_SPECULAR]));
}
