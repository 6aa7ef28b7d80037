/* SPDX-License-Identifier: MIT */
#include "engine/rgbd.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "core/context.h"
#include "io/container.h"

#define GAMMA 2.2F

void ibl_rgbd_encode(const float *texels, size_t count, unsigned char *rgbd)
{
    for (; count; count--, texels += 4, rgbd += 4) {
        const float rg = texels[0] > texels[1] ? texels[0] : texels[1];
        const float most = rg > texels[2] ? rg : texels[2];
        const int whole =
            most > 1 && most < IBL_RGBD_MAX ? (int)(IBL_RGBD_MAX / most) : 1;
        const int d = most > 1 ? whole : (int)IBL_RGBD_MAX;
        for (int c = 0; c < 3; c++) {
            const float light = texels[c] * (float)d / 255;
            const float g = light < 1 ? powf(light, 1 / GAMMA) : 1;
            rgbd[c] = (unsigned char)(light > 0 ? 255 * g + 0.5F : 0);
        }
        rgbd[3] = (unsigned char)d;
    }
}

void ibl_rgbd_decode(const unsigned char *rgbd, size_t count, float *texels)
{
    float light[256];

    for (int i = 0; i < 256; i++)
        light[i] = powf((float)i / 255, GAMMA);
    for (; count; count--, texels += 4, rgbd += 4) {
        const float d = rgbd[3] ? (float)rgbd[3] / 255 : 1.0F / 255;
        for (int c = 0; c < 3; c++)
            texels[c] = light[rgbd[c]] / d;
        texels[3] = 1;
    }
}

/* Puts the last row first. */
static void turn(unsigned char *rgba, int n)
{
    const size_t bytes = 4 * (size_t)n;

    for (size_t y = 0; y < (size_t)n / 2; y++) {
        unsigned char *a = rgba + y * bytes;
        unsigned char *b = rgba + ((size_t)n - 1 - y) * bytes;
        for (size_t i = 0; i < bytes; i++) {
            const unsigned char t = a[i];
            a[i] = b[i];
            b[i] = t;
        }
    }
}

/* Faces to files, or back; failed: 1 no memory, 2 a damaged file. */
typedef struct work {
    ibl_texture *tex;
    bool encode;
    ibl_blob *out;
    const ibl_blob *in;
    atomic_int failed;
} work;

static void face_job(void *arg, int job, int worker)
{
    work *w = arg;
    const int level = job / IBL_FACES, n = ibl_cube_edge(w->tex->width, level);
    const size_t count = (size_t)n * (size_t)n;
    float *texels =
        (float *)(void *)(w->tex->data +
                          ibl_texture_offset(w->tex, level, job % IBL_FACES));
    unsigned char *rgbd = malloc(4 * count);
    (void)worker;

    if (!rgbd) {
        w->failed = 1;
    } else if (w->encode) {
        ibl_rgbd_encode(texels, count, rgbd);
        ibl_rgbd_decode(rgbd, count, texels);
        turn(rgbd, n);
        if (!ibl_png_encode(rgbd, 4, n, n, NULL, &w->out[job]))
            w->failed = 1;
    } else if (ibl_png_decode(w->in[job].bytes, w->in[job].size, n, n, rgbd)) {
        turn(rgbd, n);
        ibl_rgbd_decode(rgbd, count, texels);
    } else {
        w->failed = 2;
    }
    free(rgbd);
}

ibl_status ibl_rgbd_faces(ibl_ctx *ctx, ibl_texture *tex, ibl_blob *faces)
{
    work w = {.tex = tex, .encode = true, .out = faces};
    const ibl_status status =
        ibl_run(ctx, NULL, IBL_FACES * tex->levels, face_job, &w);

    return w.failed ? ibl_no_memory(ctx, "PNG files") : status;
}

static ibl_status check_faces(ibl_ctx *ctx, const char *name, int size,
                              int levels, const ibl_blob *faces)
{
    for (int i = 0; i < IBL_FACES * levels; i++) {
        const int n = ibl_cube_edge(size, i / IBL_FACES);
        if (!ibl_png_fits(faces[i].bytes, faces[i].size, n, n))
            return ibl_fail(ctx, IBL_ERR_FORMAT,
                            "%s: damaged: face %d of level %d is no PNG of "
                            "%dx%d texels of 3 or 4 channels",
                            name, i % IBL_FACES, i / IBL_FACES, n, n);
    }
    return IBL_OK;
}

ibl_status ibl_rgbd_cube(ibl_ctx *ctx, const char *name, int size, int levels,
                         const ibl_blob *faces, ibl_texture *tex)
{
    work w = {.tex = tex, .in = faces};
    ibl_status status = check_faces(ctx, name, size, levels, faces);

    if (status)
        return status;
    *tex = (ibl_texture){.pixel = IBL_PIXEL_RGBA32F,
                         .width = size,
                         .height = size,
                         .levels = levels,
                         .layers = 1,
                         .faces = IBL_FACES};
    status = ibl_texture_room(ctx, tex);
    if (!status)
        status = ibl_run(ctx, NULL, IBL_FACES * levels, face_job, &w);
    if (!status && w.failed)
        status = w.failed == 1 ? ibl_no_memory(ctx, "PNG files")
                               : ibl_fail(ctx, IBL_ERR_FORMAT,
                                          "%s: damaged: one of its PNG images "
                                          "cannot be decoded",
                                          name);
    if (status)
        ibl_texture_free(tex);
    return status;
}
