/* SPDX-License-Identifier: MIT */
/* Sets that are baked here rather than read. */
#include <stdlib.h>
#include <string.h>

#include "view/message.h"
#include "view/set_about.h"

/* Textures of what was baked; out is not needed afterwards. */
static bool take(ibl_ctx *ctx, const ibl_bake_result *result,
                 const ibl_specular_options *opts, baked_set *set)
{
    const ibl_specular_layout *layout = &result->report.layout;
    ibl_overflow_report beyond = {0};

    if (ibl_texture_from_cube(ctx, &result->specular, IBL_PIXEL_RGBA16F,
                              IBL_OVERFLOW_SPREAD, &set->texture[VIEW_SPECULAR],
                              &beyond) ||
        ibl_texture_from_cube(ctx, &result->irradiance, IBL_PIXEL_RGBA16F,
                              IBL_OVERFLOW_SPREAD,
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
    set->sh_degree = VIEW_SH_DEGREE;
    for (int l = 0, i = 0; l <= VIEW_SH_DEGREE; l++)
        for (int n = 0; n < 3 * (2 * l + 1); n++, i++)
            set->sh[i] = result->sh[i] * ibl_sh_cosine(l);
    set->peak = view_set_peak(set);
    return view_set_fill(ctx, set);
}

/* Into a set that has its name, or has not for want of memory. */
static bool bake(ibl_ctx *ctx, const ibl_environment *env,
                 const ibl_specular_options *specular, baked_set *set)
{
    ibl_bake_options opts = ibl_bake_options_default();
    ibl_bake_result result = {0};

    if (!set->name)
        return view_fail("no memory to bake");
    if (specular)
        opts.specular_options = *specular;
    opts.yaw_deg = opts.specular_options.yaw_deg;
    opts.sh_degree = VIEW_SH_DEGREE;
    const bool ok = !ibl_bake_environment(ctx, env, &opts, &result) &&
                    take(ctx, &result, &opts.specular_options, set);
    ibl_bake_result_free(&result);
    return ok;
}

bool view_set_bake_image(ibl_ctx *ctx, const char *name, const ibl_image *map,
                         const ibl_specular_options *opts, baked_set *set)
{
    const ibl_environment env = {.image = map};

    *set = (baked_set){.name = strdup(name)};
    if (bake(ctx, &env, opts, set))
        return true;
    view_set_free(set);
    return false;
}

static ibl_status read_rows(void *cookie, int rows, float *rgb)
{
    return ibl_source_read(cookie, rows, rgb);
}

static bool bake_source(ibl_ctx *ctx, const char *path, baked_set *set)
{
    ibl_source *source;

    if (ibl_source_open(ctx, path, NULL, &source))
        return false;
    const ibl_environment env = {.width = ibl_source_width(source),
                                 .height = ibl_source_height(source),
                                 .read = read_rows,
                                 .cookie = source};
    const bool ok = bake(ctx, &env, NULL, set);
    ibl_source_close(source);
    return ok;
}

bool view_set_bake(ibl_ctx *ctx, const char *path, baked_set *set)
{
    *set = (baked_set){.name = view_set_stem(path), .map = strdup(path)};
    if (!set->map) {
        view_fail("%s: no memory to bake it", path);
        goto fail;
    }
    view_stamp_read(set, VIEW_CONTENTS + 1);
    if (bake_source(ctx, path, set))
        return true;
fail:
    view_set_free(set);
    return false;
}
