/* SPDX-License-Identifier: MIT */
/*
 * Luminance and chroma of EXR files: RY = (R - Y) / Y, BY = (B - Y) / Y, with
 * Y the luminance by the file's chromaticities, and RY and BY at every second
 * pixel of every second line.
 *
 * Interpolation and its taps are OpenEXR's (ImfRgbaYca.cpp): a half-band
 * filter of 27 taps, every second of them 0, that leaves the samples
 * themselves alone; beyond the edges the last sample repeats.
 */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/exr_chroma.h"
#include "io/exr_file.h"

enum {
    TAPS = 7, /* on each side */
    ROWS = 16 /* of a job */
};

static const float taps[TAPS] = {0.627123f, -0.186077f, 0.087929f, -0.043159f,
                                 0.019597f, -0.007540f, 0.002128f};

/* The middle row of the matrix from RGB to XYZ, whose columns are the
 * primaries scaled so that R = G = B = 1 is the white point. */
bool ibl_exr_luma(const exr_attr_chromaticities_t *c, float luma[3])
{
    const double rx = c->red_x, ry = c->red_y, gx = c->green_x, gy = c->green_y,
                 bx = c->blue_x, by = c->blue_y;
    const double rz = 1 - rx - ry, gz = 1 - gx - gy, bz = 1 - bx - by;
    const double wx = (double)c->white_x / c->white_y;
    const double wz =
        (1 - (double)c->white_x - (double)c->white_y) / c->white_y;
    /* Cramer's rule for [r g b] s = (wx, 1, wz). */
    const double det = rx * (gy * bz - by * gz) - gx * (ry * bz - by * rz) +
                       bx * (ry * gz - gy * rz);
    const double sr =
        wx * (gy * bz - by * gz) - gx * (bz - by * wz) + bx * (gz - gy * wz);
    const double sg =
        rx * (bz - by * wz) - wx * (ry * bz - by * rz) + bx * (ry * wz - rz);
    const double sb =
        rx * (gy * wz - gz) - gx * (ry * wz - rz) + wx * (ry * gz - gy * rz);
    const double y[3] = {ry * sr / det, gy * sg / det, by * sb / det};
    const double sum = y[0] + y[1] + y[2];

    for (int i = 0; i < 3; i++)
        luma[i] = (float)(y[i] / sum);
    return isfinite(luma[0]) && isfinite(luma[1]) && isfinite(luma[2]) &&
           fabsf(luma[1]) > 1e-6f;
}

static void pixel_to_rgb(float p[3], float y, float ry, float by,
                         const float luma[3])
{
    if (ry == 0 && by == 0) { /* grey stays exact */
        p[0] = p[1] = p[2] = y;
        return;
    }
    p[0] = (ry + 1) * y;
    p[2] = (by + 1) * y;
    p[1] = (y - p[0] * luma[0] - p[2] * luma[2]) / luma[1];
}

static int clamp(int i, int n)
{
    return i < 0 ? 0 : i < n ? i : n - 1;
}

typedef struct job_data {
    const ibl_exr_pick *pick;
    const ibl_exr_chroma *chroma;
    ibl_image *img;
    float *scratch; /* per worker: a row of each plane, at half width */
} job_data;

/* Chroma of image line y at half width; odd lines lie between two. */
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

/* Chroma of pixel x of a line of w half-width samples. */
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

void ibl_exr_line_to_rgb(const float luma[3], float *p, int count)
{
    for (; count > 0; count--, p += 3)
        pixel_to_rgb(p, p[0], p[1], p[2], luma);
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
            float *p = row + 3 * j;
            if (x >= 0 && x < data->width)
                pixel_to_rgb(p, p[0], blend_columns(chroma[0], w, x),
                             blend_columns(chroma[1], w, x), d->pick->luma);
        }
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
