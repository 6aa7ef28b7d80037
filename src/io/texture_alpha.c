/* SPDX-License-Identifier: MIT */
/* The fourth channel of a cube's texels. */
#include <stdint.h>
#include <string.h>

#include "core/half.h"
#include "image/cube.h"
#include "io/container.h"

static ibl_status check_shape(ibl_ctx *ctx, const ibl_texture *tex,
                              const ibl_cube *alpha)
{
    ibl_status status = ibl_texture_check(ctx, tex);

    if (!status)
        status = ibl_check_cube(ctx, alpha);
    if (status)
        return status;
    if (!ibl_pixel_has_alpha(tex->pixel))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "alpha of %s texels: rgba16f and rgba32f alone have it",
                        ibl_pixel_name(tex->pixel));
    if (tex->faces != IBL_FACES || tex->layers != 1 ||
        tex->width != alpha->size || tex->levels != alpha->levels)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "alpha of size %d with %d levels for a texture of size "
                        "%d with %d levels, %d layers and %d faces: a cube of "
                        "one layer and the same shape is needed",
                        alpha->size, alpha->levels, tex->width, tex->levels,
                        tex->layers, tex->faces);
    return IBL_OK;
}

static float clamp(float a)
{
    if (!(a > 0)) /* NaN, too */
        return 0;
    return a < 1 ? a : 1;
}

ibl_status ibl_texture_set_alpha(ibl_ctx *ctx, ibl_texture *tex,
                                 const ibl_cube *alpha)
{
    const ibl_status status = check_shape(ctx, tex, alpha);

    if (status)
        return status;
    const size_t texels = ibl_cube_texels(alpha->size, alpha->levels);
    const size_t bytes = ibl_pixel_bytes(tex->pixel);
    for (size_t i = 0; i < texels; i++) {
        const float a = clamp(alpha->data[3 * i]);
        unsigned char *texel = tex->data + bytes * i;
        if (tex->pixel == IBL_PIXEL_RGBA16F) {
            const uint16_t half = ibl_half_from_float(a);
            memcpy(texel + 6, &half, sizeof half);
        } else {
            memcpy(texel + 12, &a, sizeof a);
        }
    }
    tex->premultiplied = 1;
    return IBL_OK;
}

ibl_status ibl_texture_get_alpha(ibl_ctx *ctx, const ibl_texture *tex,
                                 ibl_cube *alpha)
{
    if (!alpha)
        return ibl_missing(ctx, "ibl_texture_get_alpha: alpha");
    ibl_cube cube = {0};
    const ibl_status status = ibl_texture_to_cube(ctx, tex, &cube);

    if (status)
        return status;
    const size_t texels = ibl_cube_texels(cube.size, cube.levels);
    const size_t bytes = ibl_pixel_bytes(tex->pixel);
    for (size_t i = 0; i < texels; i++) {
        const unsigned char *texel = tex->data + bytes * i;
        float a = 1;
        uint16_t half;
        if (tex->pixel == IBL_PIXEL_RGBA16F) {
            memcpy(&half, texel + 6, sizeof half);
            a = ibl_half_to_float(half);
        } else if (tex->pixel == IBL_PIXEL_RGBA32F) {
            memcpy(&a, texel + 12, sizeof a);
        }
        for (int k = 0; k < 3; k++)
            cube.data[3 * i + k] = a;
    }
    *alpha = cube;
    return IBL_OK;
}
