/* SPDX-License-Identifier: MIT */
#include "io/colour.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "io/colour_space.h"

enum {
    ROWS = 16 /* in a job */
};

/* A component this much below 0, of the largest, is only rounding. */
static const double rounding = 1e-6;

const char *ibl_primaries_name(ibl_primaries primaries)
{
    static const char *const names[] = {"keep", "rec709", "acescg", "rec2020"};
    return (unsigned)primaries <= IBL_PRIMARIES_REC2020 ? names[primaries]
                                                        : "unknown";
}

/* ---- a pixel ---------------------------------------------------------- */

static double largest(const double p[3])
{
    return fmax(fmax(p[0], p[1]), p[2]);
}

static double luminance(const ibl_colour *c, const double p[3])
{
    return c->luma[0] * p[0] + c->luma[1] * p[1] + c->luma[2] * p[2];
}

static void convert(const ibl_colour *c, const float *rgb, double p[3])
{
    const double *m = c->matrix, r = rgb[0], g = rgb[1], b = rgb[2];
    for (int i = 0; i < 3; i++)
        p[i] = m[3 * i] * r + m[3 * i + 1] * g + m[3 * i + 2] * b;
}

/* Mixes in the grey of its luminance until no component is negative. Returns
 * whether any was. */
static bool bring_inside(const ibl_colour *c, double p[3])
{
    const double least = fmin(fmin(p[0], p[1]), p[2]), y = luminance(c, p);
    const bool outside = least < -rounding * largest(p);

    if (least >= 0)
        return false;
    for (int i = 0; i < 3; i++)
        p[i] = y > 0 ? fmax(y + y / (y - least) * (p[i] - y), 0) : 0;
    return outside;
}

/* ---- rows ------------------------------------------------------------- */

typedef struct batch {
    const ibl_colour *c;
    float *rgb;
    int first, count;
    atomic_size_t outside, clamped;
} batch;

static void change_row(batch *b, int row)
{
    const ibl_colour *c = b->c;
    const int width = c->rows->width;
    float *rgb = b->rgb + 3 * (size_t)width * (size_t)row;
    size_t outside = 0, clamped = 0;
    double light = 0, removed = 0;

    for (int x = 0; x < width; x++, rgb += 3) {
        double p[3];
        convert(c, rgb, p);
        if (c->converts)
            outside += bring_inside(c, p);
        const double most = largest(p);
        const double kept = most > c->clamp ? c->clamp / most : 1;
        if (c->light) {
            light += luminance(c, p);
            removed += (1 - kept) * luminance(c, p);
            clamped += kept < 1;
        }
        for (int i = 0; i < 3; i++)
            rgb[i] = (float)fmin(kept * p[i], FLT_MAX);
    }
    b->outside += outside;
    b->clamped += clamped;
    if (c->light) {
        c->light[2 * (b->first + row)] = light;
        c->light[2 * (b->first + row) + 1] = removed;
    }
}

static void rows_job(void *arg, int job, int worker)
{
    batch *b = arg;

    (void)worker;
    for (int y = job * ROWS; y < b->count && y < (job + 1) * ROWS; y++)
        change_row(b, y);
}

ibl_status ibl_colour_apply(ibl_colour *c, int first, int count, float *rgb)
{
    batch b = {.c = c, .rgb = rgb, .first = first, .count = count};

    if (!c->changes)
        return IBL_OK;
    const ibl_status status =
        ibl_run(c->rows->ctx, NULL, (count + ROWS - 1) / ROWS, rows_job, &b);
    c->rows->report.outside += b.outside;
    c->rows->report.clamped += b.clamped;
    return status;
}

void ibl_colour_end(const ibl_colour *c)
{
    const int height = c->rows->height;
    const bool map = c->rows->report.layout == IBL_INPUT_EQUIRECT;
    double light = 0, removed = 0;

    for (int y = 0; c->light && y < height; y++) {
        /* the solid angle of a row, but for a factor */
        const double size =
            map ? cos(IBL_PI * y / height) - cos(IBL_PI * (y + 1) / height) : 1;
        light += size * c->light[2 * y];
        removed += size * c->light[2 * y + 1];
    }
    c->rows->report.clamp_removed = light > 0 ? removed / light : 0;
}

/* ---- the options ------------------------------------------------------ */

static void set_report(ibl_colour *c)
{
    ibl_rows *rows = c->rows;
    ibl_read_report *report = &rows->report;
    const bool unknown = !rows->has_primaries && !(rows->primaries[7] > 0);
    const double *xy =
        unknown ? ibl_primaries_xy(IBL_PRIMARIES_REC709) : rows->primaries;
    const char *name = ibl_colour_space_name(xy);

    report->has_primaries = rows->has_primaries;
    memcpy(report->primaries, xy, sizeof report->primaries);
    snprintf(report->primaries_name, sizeof report->primaries_name, "%s",
             name ? name : "");
}

static bool same_space(const double a[8], const double b[8])
{
    const char *names[2] = {ibl_colour_space_name(a), ibl_colour_space_name(b)};
    return names[0] && names[0] == names[1];
}

/* The weights of the file's own primaries; Rec.709's if they have none. */
static void keep_primaries(const double xy[8], float luma[3])
{
    double unused[9];
    if (!ibl_colour_space(xy, unused, luma))
        ibl_colour_space(ibl_primaries_xy(IBL_PRIMARIES_REC709), unused, luma);
}

ibl_status ibl_colour_init(ibl_colour *c, const ibl_input *in, ibl_rows *rows,
                           const ibl_read_options *opts)
{
    const double gain = exp2(opts->exposure);
    double *xy = rows->report.primaries;
    float luma[3];

    *c = (ibl_colour){.rows = rows,
                      .primaries = opts->primaries,
                      .matrix = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                      .clamp = opts->clamp > 0 ? opts->clamp : INFINITY};
    set_report(c);
    keep_primaries(xy, luma);
    if (opts->primaries != IBL_PRIMARIES_KEEP) {
        const double *to = ibl_primaries_xy(opts->primaries);
        c->converts = !same_space(xy, to);
        if (c->converts && !ibl_colour_matrix(xy, to, c->matrix, luma))
            return ibl_bad_file(
                in,
                "its primaries are no triangle with a white, so that they "
                "cannot be converted to %s",
                ibl_primaries_name(opts->primaries));
    }
    for (int i = 0; i < 9; i++)
        c->matrix[i] *= gain;
    for (int i = 0; i < 3; i++)
        rows->report.luma[i] = c->luma[i] = (double)luma[i];
    c->changes = c->converts || gain != 1 || opts->clamp > 0;
    if (opts->clamp > 0) {
        c->light = ibl_alloc_zeroed((size_t)rows->height, 2 * sizeof(double));
        if (!c->light)
            return ibl_no_memory(rows->ctx, "the rows of a map");
    }
    return IBL_OK;
}

void ibl_colour_free(ibl_colour *c)
{
    ibl_free(c->light);
    *c = (ibl_colour){0};
}
