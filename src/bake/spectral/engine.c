/* SPDX-License-Identifier: MIT */
#include "bake/spectral/engine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"

enum {
    GROUP = IBL_SPECTRAL_GROUP
};

/* A light stays one if it has this much of the map's energy. */
static const double least_share = 1e-4;

/* ---- create ------------------------------------------------------------ */

static size_t patched_floats(const ibl_spectral *s)
{
    return (3 * (size_t)s->width * GROUP + 15) / 16 * 16;
}

static ibl_status allocate(ibl_spectral *s)
{
    const size_t groups = (size_t)s->groups, rows = (size_t)s->height;
    const size_t threads = (size_t)ibl_ctx_threads(s->ctx);
    const size_t scratch = ibl_row_fft_scratch(s->azimuth);

    s->weight = ibl_alloc_array(rows, sizeof *s->weight);
    s->widths = ibl_alloc_array((size_t)s->degree + 1, sizeof *s->widths);
    s->power = ibl_alloc_array((size_t)s->degree + 1, sizeof *s->power);
    s->range = ibl_alloc_array(groups, sizeof *s->range);
    s->squares = ibl_alloc_array(groups, sizeof *s->squares);
    s->found = ibl_alloc_zeroed(groups, sizeof *s->found);
    s->taken = ibl_alloc_sparse(groups, IBL_LIGHTS_GROUP * sizeof *s->taken);
    s->worker_floats = (scratch + 15) / 16 * 16 + patched_floats(s);
    s->scratch = ibl_alloc_array(threads * s->worker_floats, sizeof(float));
    if (!s->weight || !s->widths || !s->power || !s->range || !s->squares ||
        !s->found || !s->taken || !s->scratch)
        return ibl_no_memory(s->ctx, "the analysis");
    return ibl_ring_spectra_alloc(s->ctx, s->height, s->degree + 1, &s->rows);
}

/* Solid angles of a row's pixels, as a product that cancels nothing, and the
 * integrals of e^(-i m phi) over a pixel's width around its centre. */
static void fill_weights(const ibl_spectral *s)
{
    for (int j = 0; j < s->height; j++)
        s->weight[j] = 4 * IBL_PI / s->width *
                       sin(IBL_PI * (j + 0.5) / s->height) *
                       sin(0.5 * IBL_PI / s->height);
    s->widths[0] = 2 * IBL_PI / s->width;
    for (int m = 1; m <= s->degree; m++)
        s->widths[m] =
            2 / (double)m * sin(IBL_PI * (m % (2 * s->width)) / s->width);
}

ibl_status ibl_spectral_create(ibl_ctx *ctx, int width, int height,
                               double yaw_deg, int degree, bool halved,
                               ibl_spectral **out)
{
    ibl_spectral *s = ibl_alloc_zeroed(1, sizeof *s);
    *out = NULL;
    if (!s)
        return ibl_no_memory(ctx, "the analysis");
    s->ctx = ctx;
    s->halved = halved;
    s->width = halved ? width / 2 : width;
    s->height = halved ? height / 2 : height;
    s->degree = degree;
    s->groups = (s->height + GROUP - 1) / GROUP;
    s->scale = 1;
    s->yaw = (yaw_deg - 360 * floor(yaw_deg / 360)) / 180 * IBL_PI;
    ibl_status status =
        ibl_row_fft_create(ctx, s->width, degree + 1, s->yaw, &s->azimuth);
    if (!status)
        status = allocate(s);
    if (status) {
        ibl_spectral_free(s);
        return status;
    }
    fill_weights(s);
    *out = s;
    return IBL_OK;
}

static void free_reading(ibl_spectral *s)
{
    ibl_row_fft_free(s->azimuth);
    ibl_ring_spectra_free(&s->rows);
    ibl_free(s->scratch);
    ibl_free(s->found);
    ibl_free(s->taken);
    ibl_free(s->range);
    ibl_free(s->squares);
    s->squares = NULL;
    s->azimuth = NULL;
    s->scratch = NULL;
    s->found = NULL;
    s->taken = NULL;
    s->range = NULL;
}

void ibl_spectral_free(ibl_spectral *s)
{
    if (!s)
        return;
    free_reading(s);
    ibl_free(s->weight);
    ibl_free(s->widths);
    ibl_free(s->power);
    ibl_free(s->lights);
    ibl_harmonics_free(&s->harmonics);
    ibl_spectral_work_free(&s->work);
    ibl_free(s);
}

/* ---- rows -------------------------------------------------------------- */

/* Two rows of the map as one, of half as many pixels; `lower` is the second
 * one's share of both. What is constant stays that. */
static void halve(const float *rgb, int width, float lower, float *out)
{
    const float *below = rgb + 6 * (size_t)width;
    for (int i = 0; i < width; i++)
        for (int c = 0; c < 3; c++) {
            const int k = 6 * i + c;
            const float a = rgb[k] + 0.5f * (rgb[k + 3] - rgb[k]);
            const float b = below[k] + 0.5f * (below[k + 3] - below[k]);
            out[3 * i + c] = a + lower * (b - a);
        }
}

/* The rows of a job; own: room for them. */
static ibl_row_fft_rows group_of(const ibl_spectral *s, int job, float *own)
{
    const ibl_spectral_batch *b = &s->batch;
    const size_t row = 3 * (size_t)s->width;
    const int first = job * GROUP, left = b->rows - first;
    ibl_row_fft_rows in = {.rgb = b->rgb + row * (size_t)first,
                           .stride = row,
                           .count = left < GROUP ? left : GROUP};

    if (!s->halved)
        return in;
    for (int j = 0; j < in.count; j++) {
        const double at = IBL_PI * (b->first + first + j + 0.5) / s->height;
        const double step = IBL_PI / s->height / 4;
        const double upper = sin(at - step), lower = sin(at + step);
        halve(b->rgb + 4 * row * (size_t)(first + j), s->width,
              (float)(lower / (upper + lower)), own + row * (size_t)j);
    }
    in.rgb = own;
    return in;
}

/* Takes the lights out of a copy, that becomes the group's rows. */
static void take_lights(ibl_spectral *s, ibl_row_fft_rows *in, int group,
                        float *copy, double *squares)
{
    ibl_pixel_light *lights = s->taken + (size_t)group * IBL_LIGHTS_GROUP;
    ibl_row_range rest;

    if (in->rgb != copy)
        memcpy(copy, in->rgb, in->stride * (size_t)in->count * sizeof *copy);
    in->rgb = copy;
    s->found[group] = ibl_lights_take(copy, s->width, in->count, group * GROUP,
                                      &s->range[group], lights);
    for (int i = 0; i < s->found[group]; i++) {
        ibl_pixel_light *l = &lights[i];
        for (int c = 0; c < 3; c++)
            l->rgb[c] *= (float)s->scale;
        l->energy = s->weight[l->row] *
                    ((double)l->rgb[0] + (double)l->rgb[1] + (double)l->rgb[2]);
    }
    if (s->found[group])
        ibl_row_range_of(copy, s->width, in->count, s->base, &rest, squares);
}

static void group_job(void *arg, int job, int worker)
{
    ibl_spectral *s = arg;
    const int first = s->batch.first + job * GROUP, group = first / GROUP;
    float *scratch = s->scratch + (size_t)worker * s->worker_floats;
    float *own = scratch + s->worker_floats - patched_floats(s);
    ibl_row_fft_rows in = group_of(s, job, own);
    double squares[GROUP];

    ibl_row_range_of(in.rgb, s->width, in.count, s->base, &s->range[group],
                     squares);
    in.change.scale = (float)s->scale;
    memcpy(in.change.subtract, s->base, sizeof in.change.subtract);
    if (ibl_lights_any(&s->range[group], (size_t)s->width * (size_t)in.count))
        take_lights(s, &in, group, own, squares);
    s->squares[group] = 0;
    for (int j = 0; j < in.count; j++)
        s->squares[group] += squares[j] * s->weight[first + j];
    ibl_row_fft_forward(s->azimuth, &in, scratch, &s->rows, first);
}

/*
 * A constant that is taken from every pixel and added to every texel: the
 * least of the first row. A constant map is that alone and stays what it is,
 * to the last bit.
 */
static void choose_base(ibl_spectral *s, const float *rgb)
{
    for (int c = 0; c < 3; c++) {
        s->base[c] = rgb[c];
        for (int i = 1; i < s->width; i++)
            s->base[c] = fminf(s->base[c], rgb[3 * i + c]);
    }
}

/* What the rows before the batch were scaled by becomes factor times that. */
static void rescale(ibl_spectral *s, float factor)
{
    const size_t parts = 6 * (size_t)s->rows.orders;
    const int before = s->batch.first;
    for (size_t part = 0; part < parts; part++) {
        float *f = s->rows.data + part * s->rows.stride;
        for (int j = 0; j < before; j++)
            f[j] *= factor;
    }
    for (int g = 0; g < before / GROUP; g++)
        for (int i = 0; i < s->found[g]; i++) {
            ibl_pixel_light *l =
                &s->taken[(size_t)g * IBL_LIGHTS_GROUP + (size_t)i];
            for (int c = 0; c < 3; c++)
                l->rgb[c] *= factor;
            l->energy *= (double)factor;
        }
}

/*
 * Sums of the largest floats should stay floats, and those of denormal ones
 * keep their digits: where the peak until now is beyond 2^64 or below 2^-64
 * everything is scaled by the other.
 */
static double choose_scale(float peak)
{
    return peak > 0x1p64f ? 0x1p-64 : peak > 0 && peak < 0x1p-64f ? 0x1p64 : 1;
}

static int batch_groups(const ibl_spectral *s)
{
    return (s->batch.rows + GROUP - 1) / GROUP;
}

/* The jobs of the batch have ended: looks at what they found. */
static ibl_status settle(ibl_spectral *s)
{
    const int first = s->batch.first / GROUP, groups = batch_groups(s);
    for (int g = first; g < first + groups; g++)
        for (int c = 0; c < 3; c++)
            s->peak = fmaxf(s->peak, s->range[g].high[c]);
    const double scale = choose_scale(s->peak);
    if (!(scale < s->scale || scale > s->scale))
        return IBL_OK;
    /* What no photograph has: once more, on another scale. */
    memset(s->found + first, 0, (size_t)groups * sizeof *s->found);
    rescale(s, (float)(scale / s->scale));
    s->scale = scale;
    return ibl_run(s->ctx, NULL, groups, group_job, s);
}

ibl_status ibl_spectral_add(ibl_spectral *s, int rows, const float *rgb)
{
    if (!s->added)
        choose_base(s, rgb);
    const ibl_status status = settle(s);
    if (status)
        return status;
    if (s->halved)
        rows /= 2;
    s->batch = (ibl_spectral_batch){rgb, s->added, rows};
    s->added += rows;
    ibl_run_begin(s->ctx, "analysis", (double)s->batch.first / s->height,
                  batch_groups(s), group_job, s);
    return IBL_OK;
}

/* ---- lights ------------------------------------------------------------ */

/* Radiance of all channels over the sphere, without the lights. */
static double energy_of_rows(const ibl_spectral *s)
{
    double sum = 0;
    for (int j = 0; j < s->height; j++)
        for (int c = 0; c < 3; c++)
            sum += s->weight[j] *
                   ((double)ibl_ring_spectra_at(&s->rows, 0, 2 * c)[j] +
                    (double)s->base[c] * s->scale * s->width);
    return sum;
}

/* By energy; else as they come in the map. */
static int stronger_first(const void *a, const void *b)
{
    const ibl_pixel_light *x = a, *y = b;
    if (x->energy < y->energy || x->energy > y->energy)
        return x->energy < y->energy ? 1 : -1;
    if (x->row != y->row)
        return x->row > y->row ? 1 : -1;
    return x->column > y->column ? 1 : -1;
}

static ibl_status gather_lights(ibl_spectral *s, int *count)
{
    int n = 0;
    for (int g = 0; g < s->groups; g++)
        n += s->found[g];
    s->lights = ibl_alloc_array((size_t)n, sizeof *s->lights);
    if (!s->lights)
        return ibl_no_memory(s->ctx, "the lights");
    n = 0;
    for (int g = 0; g < s->groups; g++)
        for (int i = 0; i < s->found[g]; i++)
            s->lights[n++] = s->taken[(size_t)g * IBL_LIGHTS_GROUP + (size_t)i];
    qsort(s->lights, (size_t)n, sizeof *s->lights, stronger_first);
    *count = n;
    return IBL_OK;
}

struct add_lights {
    const ibl_spectral *s;
    const ibl_pixel_light *lights;
    int count;
    ibl_ring_spectra *to;
};

double ibl_spectral_azimuth(const ibl_spectral *s, const ibl_pixel_light *l)
{
    return 2 * IBL_PI * ((l->column + 0.5) / s->width - 0.5) - s->yaw;
}

static void add_lights_job(void *arg, int m, int worker)
{
    const struct add_lights *a = arg;
    const ibl_spectral *s = a->s;
    (void)worker;
    for (int i = 0; i < a->count; i++) {
        const ibl_pixel_light *l = &a->lights[i];
        const double angle = m * ibl_spectral_azimuth(s, l);
        const float re = (float)cos(angle), im = (float)-sin(angle);
        for (int c = 0; c < 3; c++) {
            ibl_ring_spectra_at(a->to, m, 2 * c)[l->row] += re * l->rgb[c];
            ibl_ring_spectra_at(a->to, m, 2 * c + 1)[l->row] += im * l->rgb[c];
        }
    }
}

ibl_status ibl_spectral_add_lights(const ibl_spectral *s,
                                   const ibl_pixel_light *lights, int count,
                                   ibl_ring_spectra *to)
{
    struct add_lights a = {s, lights, count, to};
    return count ? ibl_run(s->ctx, NULL, to->orders, add_lights_job, &a)
                 : IBL_OK;
}

/* Squares of lights that go back to their rows: what a pixel was besides is
 * nothing to what outshines it. */
static void return_squares(const ibl_spectral *s, int count)
{
    for (int i = s->light_count; i < count; i++) {
        const ibl_pixel_light *l = &s->lights[i];
        for (int c = 0; c < 3; c++) {
            const double v = (double)l->rgb[c] / s->scale;
            s->squares[l->row / GROUP] += v * v * s->weight[l->row];
        }
    }
}

/* Of the lights that were taken out, the ones to be added to texels; the
 * others go back to their rows. */
static ibl_status choose_lights(ibl_spectral *s)
{
    double total = energy_of_rows(s);
    int count = 0;
    ibl_status status = gather_lights(s, &count);
    if (status)
        return status;
    for (int i = 0; i < count; i++)
        total += s->lights[i].energy;
    while (s->light_count < count && s->light_count < IBL_LIGHTS_MOST &&
           s->lights[s->light_count].energy > least_share * total)
        s->light_count++;
    return_squares(s, count);
    status = ibl_spectral_add_lights(s, s->lights + s->light_count,
                                     count - s->light_count, &s->rows);
    return status;
}

/* ---- finish ------------------------------------------------------------ */

/* Takes the mean out of the harmonics: it is the same in every texel. */
static void take_mean(ibl_spectral *s)
{
    double *a = ibl_harmonics_at(&s->harmonics, 0);
    for (int c = 0; c < 3; c++) {
        const double rest = a[2 * c] / sqrt(4 * IBL_PI) / s->scale;
        s->mean[c] = (float)((double)s->base[c] + rest);
        a[2 * c] -= ((double)s->mean[c] - (double)s->base[c]) * s->scale *
                    sqrt(4 * IBL_PI);
    }
}

/* What the harmonics do not hold of the mean square, unscaled (Parseval). */
static void find_unresolved(ibl_spectral *s)
{
    double sum = 0, held = 0;
    ibl_sht_power(&s->harmonics, s->power);
    for (int g = 0; g < s->groups; g++)
        sum += s->squares[g];
    for (int l = 0; l <= s->degree; l++)
        held += s->power[l];
    s->unresolved = fmax(sum - held / s->scale / s->scale, 0) / (4 * IBL_PI);
}

static void merge_ranges(ibl_spectral *s)
{
    for (int c = 0; c < 3; c++) {
        s->low[c] = s->range[0].low[c];
        s->high[c] = s->range[0].high[c];
        for (int g = 1; g < s->groups; g++) {
            s->low[c] = fminf(s->low[c], s->range[g].low[c]);
            s->high[c] = fmaxf(s->high[c], s->range[g].high[c]);
        }
    }
}

ibl_status ibl_spectral_finish(ibl_spectral *s)
{
    ibl_progress(s->ctx, "analysis", 1);
    ibl_status status = settle(s);
    if (status)
        return status;
    merge_ranges(s);
    status = choose_lights(s);
    if (!status)
        status = ibl_harmonics_alloc(s->ctx, s->degree, &s->harmonics);
    if (!status)
        status = ibl_sht_analyse(s->ctx, "analysis", &s->rows, s->widths,
                                 &s->harmonics);
    if (status)
        return status;
    find_unresolved(s);
    take_mean(s);
    ibl_sht_power(&s->harmonics, s->power);
    free_reading(s);
    return IBL_OK;
}
