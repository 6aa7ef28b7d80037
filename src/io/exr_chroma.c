/* SPDX-License-Identifier: MIT */
/*
 * Luminance and chroma of EXR files: RY = (R - Y) / Y, BY = (B - Y) / Y. Y is
 * the luminance by the file's chromaticities. RY and BY are stored at every
 * second pixel of every second line.
 *
 * The interpolation is OpenEXR's (ImfRgbaYca.cpp): a half-band filter of 27
 * taps, every second of them 0, that keeps the samples. Beyond the edges the
 * last sample repeats.
 */
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/colour_space.h"
#include "io/exr_file.h"

enum {
    TAPS = 7, /* on each side */
    ROWS = 16 /* in a job */
};

static const float taps[TAPS] = {0.627123f, -0.186077f, 0.087929f, -0.043159f,
                                 0.019597f, -0.007540f, 0.002128f};

static int clamp(int i, int n)
{
    return i < 0 ? 0 : i < n ? i : n - 1;
}

typedef struct job_data {
    const ibl_exr_pick *pick;
    const ibl_exr_chroma *chroma;
    ibl_image *img;
    float *scratch; /* per worker: a row of both planes */
} job_data;

/* Chroma of image line y at half width; interpolates odd lines. */
static void blend_rows(const ibl_exr_chroma *chroma, int plane, int y,
                       float *out)
{
    const int w = chroma->width, h = chroma->height, k = y / 2;
    const float *src = chroma->plane[plane];

    if (y % 2 == 0) {
        memcpy(out, src + (size_t)k * w, (size_t)w * sizeof *out);
        return;
    }
    memset(out, 0, (size_t)w * sizeof *out);
    for (int t = 0; t < TAPS; t++) {
        const float *above = src + (size_t)clamp(k - t, h) * w;
        const float *below = src + (size_t)clamp(k + 1 + t, h) * w;
        for (int x = 0; x < w; x++)
            out[x] += taps[t] * (above[x] + below[x]);
    }
}

/* Chroma of pixel x; row has w samples at half width. */
static float blend_columns(const float *row, int w, int x)
{
    const int k = x / 2;
    float sum = 0;
    if (x % 2 == 0)
        return row[k];
    for (int t = 0; t < TAPS; t++)
        sum += taps[t] * (row[clamp(k - t, w)] + row[clamp(k + 1 + t, w)]);
    return sum;
}

static void rows_job(void *arg, int job, int worker)
{
    const job_data *d = arg;
    const ibl_exr_window *map = &d->pick->display, *data = &d->pick->data;
    const int w = d->chroma->width;
    float *scratch = d->scratch + (size_t)worker * 2 * (size_t)data->width;
    float *chroma[2] = {scratch, scratch + w};

    for (int i = job * ROWS; i < (job + 1) * ROWS && i < map->height; i++) {
        const int y = map->y0 + i - data->y0;
        float *row = d->img->data + 3 * (size_t)i * (size_t)map->width;
        if (y < 0 || y >= data->height)
            continue;
        for (int k = 0; k < 2; k++)
            blend_rows(d->chroma, k, y, chroma[k]);
        for (int j = 0; j < map->width; j++) {
            const int x = map->x0 + j - data->x0;
            for (int k = 0; k < 2 && x >= 0 && x < data->width; k++)
                row[3 * j + 1 + k] = blend_columns(chroma[k], w, x);
        }
        ibl_luma_to_rgb(d->pick->luma, row, map->width);
    }
}

ibl_status ibl_exr_to_rgb(ibl_ctx *ctx, const ibl_exr_pick *pick,
                          const ibl_exr_chroma *chroma, ibl_image *img)
{
    job_data d = {pick, chroma, img, NULL};
    d.scratch = ibl_alloc_array((size_t)ibl_ctx_threads(ctx) * 2,
                                (size_t)pick->data.width * sizeof *d.scratch);
    if (!d.scratch)
        return ibl_no_memory(ctx, "the chroma of an EXR");
    const ibl_status status =
        ibl_run(ctx, NULL, (img->height + ROWS - 1) / ROWS, rows_job, &d);
    ibl_free(d.scratch);
    return status;
}
