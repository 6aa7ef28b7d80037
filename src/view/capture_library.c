/* SPDX-License-Identifier: MIT */
/*
 * A captured cube through the library's bake, which takes equirectangular
 * maps: one of 4n x 2n pixels, the cube's mean over each pixel between texels.
 */
#include "view/capture_parts.h"

#include <math.h>
#include <stdlib.h>

#include "view/message.h"

/* ---- out of OpenGL ---------------------------------------------------- */

/* 4 floats a pixel; free() it. */
static float *read_equirect(const view_capture *c, GLuint cube, int width,
                            int height)
{
    float *rgba = malloc((size_t)width * height * 4 * sizeof *rgba);
    GLuint map = 0;

    if (!rgba) {
        view_fail("no memory for a capture's map of %d x %d pixels", width,
                  height);
        return NULL;
    }
    gl.GenTextures(1, &map);
    view_gl_bind(VIEW_CAPTURE_UNIT_MORE, GL_TEXTURE_2D, map);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width, height, 0, GL_RGBA,
                  GL_FLOAT, NULL);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->target);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                            map, 0);
    gl.Viewport(0, 0, width, height);
    gl.UseProgram(c->equirect.program);
    gl.Uniform1f(c->equirect.edge, (float)height);
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, cube);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, rgba);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                            0, 0);
    gl.DeleteTextures(1, &map);
    return rgba;
}

/* The colours (alpha false) or alpha as a map of greys. */
static void take(const float *rgba, bool alpha, ibl_image *map)
{
    for (size_t i = 0; i < (size_t)map->width * map->height; i++)
        for (int k = 0; k < 3; k++)
            map->data[3 * i + k] = rgba[4 * i + (alpha ? 3 : k)];
}

static bool whole(const float *rgba, size_t pixels)
{
    for (size_t i = 0; i < pixels; i++)
        if (rgba[4 * i + 3] < 0.999F) /* more than rounding */
            return false;
    return true;
}

/* ---- into it ---------------------------------------------------------- */

/* alpha without texels: 1. */
static bool upload(const ibl_cube *rgb, const ibl_cube *alpha, int first,
                   GLuint cube)
{
    const size_t most = (size_t)rgb->size * rgb->size;
    float *rgba = malloc(4 * most * sizeof *rgba);

    if (!rgba)
        return view_fail("no memory for a level of a capture");
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, cube);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    for (int l = first; l < rgb->levels; l++)
        for (int f = 0; f < IBL_FACES; f++) {
            const int n = ibl_cube_edge(rgb->size, l);
            const float *from = ibl_cube_face(rgb, l, f);
            const float *a = alpha->data ? ibl_cube_face(alpha, l, f) : NULL;
            for (int i = 0; i < n * n; i++) {
                for (int k = 0; k < 3; k++)
                    rgba[4 * i + k] = fminf(from[3 * i + k], 65504);
                rgba[4 * i + 3] = a ? fminf(a[3 * i], 1) : 1;
            }
            gl.TexImage2D(GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)f, l,
                          GL_RGBA16F, n, n, 0, GL_RGBA, GL_FLOAT, rgba);
        }
    free(rgba);
    return true;
}

static ibl_status bake(const view_capture *c, ibl_ctx *ctx,
                       const ibl_image *map, ibl_bake_result *result)
{
    const ibl_environment env = {.image = map};
    ibl_bake_options opts = ibl_bake_options_default();

    opts.specular_options.size = c->options.size;
    opts.specular_options.levels = c->options.levels;
    opts.irradiance_options.size = VIEW_CAPTURE_IRRADIANCE;
    opts.sh_degree = -1;
    return ibl_bake_environment(ctx, &env, &opts, result);
}

bool view_capture_by_library(view_capture *c, ibl_ctx *ctx,
                             const view_capture_set *set)
{
    const int width = 4 * c->options.size, height = 2 * c->options.size;
    ibl_bake_result rgb = {0}, alpha = {0};
    ibl_image map = {0};
    bool ok = false;

    float *rgba = read_equirect(c, set->specular, width, height);
    if (!rgba || ibl_image_alloc(ctx, width, height, &map))
        goto fail;
    take(rgba, false, &map);
    if (bake(c, ctx, &map, &rgb))
        goto fail;
    if (!whole(rgba, (size_t)width * height)) {
        take(rgba, true, &map);
        if (bake(c, ctx, &map, &alpha))
            goto fail;
    }
    ok = upload(&rgb.specular, &alpha.specular, 1, set->specular) &&
         upload(&rgb.irradiance, &alpha.irradiance, 0, set->irradiance);
fail:
    ibl_bake_result_free(&alpha);
    ibl_bake_result_free(&rgb);
    ibl_image_free(&map);
    free(rgba);
    return ok;
}
