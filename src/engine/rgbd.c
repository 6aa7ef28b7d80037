/* SPDX-License-Identifier: MIT */
#include "engine/rgbd.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/half.h"

/* A byte's light, and where bytes begin. A float in 0..1 is known by its upper
 * bits: of the floats that share them, at most one begins a byte. */
#define GAMMA 2.2
#define DARKEST 0x1p-20f /* less than half the first byte */

enum {
    SHIFT = 16, /* bits of a float that are left out */
    DARKEST_BITS = 107 << (23 - SHIFT),
    BUCKETS = (20 << (23 - SHIFT)) + 1
};

static struct {
    double light[256];
    float from[257];
    unsigned char byte[BUCKETS];
} tables;

static void fill_tables(void)
{
    int byte = 0;

    for (int i = 0; i < 256; i++) {
        tables.light[i] = pow(i / 255.0, GAMMA);
        tables.from[i] = i ? (float)pow((i - 0.5) / 255, GAMMA) : 0;
    }
    tables.from[256] = 2;
    for (int i = 0; i < BUCKETS; i++) {
        const uint32_t bits = (uint32_t)(DARKEST_BITS + i) << SHIFT;
        while (tables.from[byte + 1] <= ibl_float_of(bits))
            byte++;
        tables.byte[i] = (unsigned char)byte;
    }
}

static void prepare(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;

    pthread_once(&once, fill_tables);
}

/* (x^(1 / 2.2)) * 255, rounded. */
static unsigned char byte_of(float x)
{
    const float least = x > DARKEST ? x : DARKEST; /* of NaN too */
    const float light = least < 1 ? least : 1;
    const unsigned bucket = (ibl_bits_of(light) >> SHIFT) - DARKEST_BITS;
    const unsigned char byte = tables.byte[bucket];

    return (unsigned char)(byte + (light >= tables.from[byte + 1]));
}

void ibl_rgbd_encode(const float *texels, size_t count, unsigned char *rgbd)
{
    prepare();
    for (; count; count--, texels += 4, rgbd += 4) {
        const float rg = texels[0] > texels[1] ? texels[0] : texels[1];
        const float most = rg > texels[2] ? rg : texels[2];
        const int whole =
            most > 1 && most < IBL_RGBD_MAX ? (int)(IBL_RGBD_MAX / most) : 1;
        const int d = most > 1 ? whole : (int)IBL_RGBD_MAX;
        for (int c = 0; c < 3; c++)
            rgbd[c] = byte_of(texels[c] * (float)d / 255);
        rgbd[3] = (unsigned char)d;
    }
}

void ibl_rgbd_decode(const unsigned char *rgbd, size_t count, float *texels)
{
    prepare();
    for (; count; count--, texels += 4, rgbd += 4) {
        const double d = rgbd[3] ? rgbd[3] / 255.0 : 1 / 255.0;
        for (int c = 0; c < 3; c++)
            texels[c] = (float)(tables.light[rgbd[c]] / d);
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
        if (!ibl_png_encode(rgbd, n, n, NULL, &w->out[job]))
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
    tex->bytes = ibl_texture_offset(tex, levels, 0);
    tex->data = ibl_alloc_array(tex->bytes, 1);
    status = tex->data ? ibl_run(ctx, NULL, IBL_FACES * levels, face_job, &w)
                       : ibl_no_memory(ctx, "a texture");
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
