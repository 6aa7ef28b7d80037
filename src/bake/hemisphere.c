/* SPDX-License-Identifier: MIT */
#include "bake/hemisphere.h"

#include "bake/filter.h"
#include "bake/samples.h"
#include "image/pyramid.h"

enum {
    MAX_EDGE = 1024 /* texels far smaller than any sensible step */
};

/* Edge of the cube to look up: texels like the source's pixels. */
static int lookup_edge(const ibl_image *env)
{
    const int across = env->width / 4, down = env->height / 2;
    const int edge = across > down ? across : down;
    if (edge < 1)
        return 1;
    return edge < MAX_EDGE ? edge : MAX_EDGE;
}

ibl_status ibl_irradiance_grid(ibl_ctx *ctx, const ibl_image *env,
                               const ibl_irradiance_options *opts,
                               ibl_cube *out)
{
    ibl_pyramid pyramid = {0};
    ibl_samples samples = {0};
    ibl_cube cube = {0};
    ibl_status status = ibl_cube_alloc(ctx, lookup_edge(env), 1, &cube);
    if (!status)
        status = ibl_cube_from_latlong(ctx, env, opts->yaw_deg, &cube);
    if (!status)
        status = ibl_pyramid_create(ctx, &cube, 1, &pyramid);
    ibl_cube_free(&cube);
    if (!status)
        status = ibl_samples_hemisphere(ctx, opts->step, &samples);
    if (!status)
        status = ibl_filter_level(ctx, "irradiance", &pyramid, &samples, false,
                                  out, 0);
    ibl_samples_free(&samples);
    ibl_pyramid_free(&pyramid);
    return status;
}
