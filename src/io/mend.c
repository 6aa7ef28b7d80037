/* SPDX-License-Identifier: MIT */
#include "io/mend.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/half.h"
#include "core/pi.h"
#include "io/colour_space.h"
#include "kern/max_finite.h"
#include "kern/pixel.h"

enum {
    ROWS = 16,    /* in a job */
    SAMPLES = 128 /* of the light of a row */
};

/* A component this much below 0, of the largest, is only rounding. */
static const double rounding = 1e-6;
/* Renderers and filters round alpha; such values are not errors. */
static const float alpha_rounding = 1e-3f;
/* The share of a map's light that is worth a word. */
static const double notable = 1e-4;

static bool is_finite(float f)
{
    return (ibl_bits_of(f) & IBL_INFINITE_BITS) != IBL_INFINITE_BITS;
}

/* Mends a row with values that are not finite or below 0; -0 becomes 0. */
static void mend_values(float *p, int width, ibl_row_facts *f)
{
    float first[3], left[3];

    memcpy(first, p, sizeof first);
    memcpy(left, p + 3 * (width - 1), sizeof left);
    for (int x = 0; x < width; x++, p += 3) {
        const float *right = x + 1 < width ? p + 3 : first;
        bool nonfinite = false, negative = false;
        for (int c = 0; c < 3; c++) {
            const float was = p[c];
            if (!is_finite(was)) {
                const float best =
                    fmaxf(is_finite(left[c]) ? left[c] : -INFINITY,
                          is_finite(right[c]) ? right[c] : -INFINITY);
                nonfinite = true;
                p[c] = best > -INFINITY                        ? best
                       : ibl_bits_of(was) == IBL_INFINITE_BITS ? IBL_HALF_MAX
                                                               : 0;
            } else if (was < 0) {
                negative = true;
                f->removed -= (double)was;
            }
            p[c] = p[c] > 0 ? p[c] : 0;
            f->peak = fmaxf(f->peak, p[c]);
            left[c] = was;
        }
        f->nonfinite += nonfinite;
        f->negative += negative;
    }
}

/* ---- colours ------------------------------------------------------------ */

static double largest(const double p[3])
{
    return fmax(fmax(p[0], p[1]), p[2]);
}

static double luminance(const ibl_mender *m, const double p[3])
{
    return m->luma[0] * p[0] + m->luma[1] * p[1] + m->luma[2] * p[2];
}

/* Mixes in the grey of its luminance until no component is negative. Returns
 * whether any was. */
static bool bring_inside(const ibl_mender *m, double p[3])
{
    const double least = fmin(fmin(p[0], p[1]), p[2]), y = luminance(m, p);
    const bool outside = least < -rounding * largest(p);

    if (least >= 0)
        return false;
    for (int i = 0; i < 3; i++)
        p[i] = y > 0 ? fmax(y + y / (y - least) * (p[i] - y), 0) : 0;
    return outside;
}

static void change_colours(const ibl_mender *m, float *rgb, ibl_row_facts *f)
{
    const double *k = m->matrix;

    for (int x = 0; x < m->rows->width; x++, rgb += 3) {
        const double r = rgb[0], g = rgb[1], blue = rgb[2];
        double p[3];
        for (int i = 0; i < 3; i++)
            p[i] = k[3 * i] * r + k[3 * i + 1] * g + k[3 * i + 2] * blue;
        if (m->converts)
            f->outside += bring_inside(m, p);
        const double most = largest(p);
        const double kept = most > m->clamp ? m->clamp / most : 1;
        if (m->clamp < INFINITY) {
            f->light += luminance(m, p);
            f->clamped_light += (1 - kept) * luminance(m, p);
            f->clamped += kept < 1;
        }
        for (int i = 0; i < 3; i++)
            rgb[i] = (float)fmin(kept * p[i], FLT_MAX);
    }
}

/* ---- alpha -------------------------------------------------------------- */

/* Mends alpha. Multiplies straight colours by it; other colours become black
 * where it is 0. */
static void mend_alpha(const ibl_mender *m, float *alpha, float *rgb,
                       ibl_row_facts *f)
{
    for (int x = 0; x < m->rows->width; x++, alpha++, rgb += 3) {
        const bool known = is_finite(*alpha);
        const float a = known && *alpha > 0 ? fminf(*alpha, 1) : 0;
        const float factor = m->straight || a <= 0 ? a : 1;

        f->alpha_nonfinite += !known;
        f->alpha_beyond += known && fabsf(*alpha - a) > alpha_rounding;
        f->alpha_least = fminf(f->alpha_least, a);
        f->alpha_most = fmaxf(f->alpha_most, a);
        f->alpha_hidden +=
            !m->straight && a <= 0 && known && rgb[0] + rgb[1] + rgb[2] > 0;
        *alpha = a;
        for (int k = 0; k < 3; k++)
            rgb[k] *= factor;
    }
}

/* ---- rows --------------------------------------------------------------- */

typedef struct batch {
    const ibl_mender *m;
    float *rgb;
    int first, count; /* rows of the map */
} batch;

static void rows_job(void *arg, int job, int worker)
{
    const batch *b = arg;
    const ibl_mender *m = b->m;
    const int width = m->rows->width, step = width / SAMPLES + 1;
    ibl_max_finite_dsp dsp;

    (void)worker;
    ibl_max_finite_dsp_init(&dsp, ibl_ctx_isa(m->rows->ctx));
    for (int y = job * ROWS; y < b->count && y < (job + 1) * ROWS; y++) {
        float *rgb = b->rgb + 3 * (size_t)width * (size_t)y;
        const size_t row = (size_t)(b->first + y);
        ibl_row_facts *f = &m->facts[row];
        const uint32_t most = dsp.look(rgb, 3 * (size_t)width);
        *f = (ibl_row_facts){.alpha_least = 1};
        if (most < IBL_INFINITE_BITS)
            f->peak = ibl_float_of(most);
        else
            mend_values(rgb, width, f);
        for (int x = 0; x < width; x += step)
            for (int c = 0; c < 3; c++)
                f->left += (double)rgb[3 * x + c] * step;
        /* a sun between the samples counts once */
        f->left = fmax(f->left, (double)f->peak);
        if (m->changes)
            change_colours(m, rgb, f);
        if (m->rows->alpha)
            mend_alpha(m, m->rows->alpha + (size_t)width * row, rgb, f);
    }
}

/* ---- the whole map ------------------------------------------------------ */

ibl_status ibl_mender_init(ibl_mender *m, const ibl_input *in, ibl_rows *rows,
                           const ibl_read_options *opts)
{
    const double *rec709 = ibl_primaries_xy(IBL_PRIMARIES_REC709);
    const double gain = exp2(opts->exposure);
    ibl_read_report *r = &rows->report;
    double unused[9];
    float luma[3];

    *m = (ibl_mender){
        .rows = rows,
        .name = in->name,
        .strict = opts->strict,
        .straight = rows->straight || opts->alpha == IBL_ALPHA_STRAIGHT,
        .primaries = opts->primaries,
        .matrix = {1, 0, 0, 0, 1, 0, 0, 0, 1},
        .clamp = opts->clamp > 0 ? opts->clamp : INFINITY,
    };
    m->facts = ibl_alloc_array((size_t)rows->height, sizeof *m->facts);
    if (!m->facts)
        return ibl_no_memory(rows->ctx, "rows of an image");
    r->has_alpha = rows->alpha != NULL;
    r->alpha_least = 1;
    r->alpha_most = !rows->alpha;
    if (!r->has_primaries)
        memcpy(r->primaries, rec709, sizeof r->primaries);
    const char *name = ibl_colour_space_name(r->primaries);
    snprintf(r->primaries_name, sizeof r->primaries_name, "%s",
             name ? name : "");
    if (!ibl_colour_space(r->primaries, unused, luma))
        ibl_colour_space(rec709, unused, luma);
    if (opts->primaries != IBL_PRIMARIES_KEEP) {
        const double *to = ibl_primaries_xy(opts->primaries);
        m->converts = !name || strcmp(name, ibl_colour_space_name(to));
        if (m->converts &&
            !ibl_colour_matrix(r->primaries, to, m->matrix, luma))
            return ibl_bad_file(
                in,
                "its primaries are no triangle with a white, so that they "
                "cannot be converted to %s",
                ibl_primaries_name(opts->primaries));
    }
    for (int i = 0; i < 9; i++)
        m->matrix[i] *= gain;
    for (int i = 0; i < 3; i++)
        r->luma[i] = m->luma[i] = (double)luma[i];
    m->changes = m->converts || gain != 1 || opts->clamp > 0;
    return IBL_OK;
}

/* After the last row: warns of mended values or, if strict, refuses them. */
static ibl_status report(ibl_mender *m)
{
    ibl_read_report *r = &m->rows->report;
    const double *xy = r->primaries;
    ibl_ctx *ctx = m->rows->ctx;
    const int height = m->rows->height;
    const bool map = r->layout == IBL_INPUT_EQUIRECT;
    double left = 0, removed = 0, light = 0, clamped = 0;

    for (int y = 0; y < height; y++) {
        const ibl_row_facts *f = &m->facts[y];
        /* the solid angle of a row, but for a factor */
        const double size =
            map ? cos(IBL_PI * y / height) - cos(IBL_PI * (y + 1) / height) : 1;
        left += f->left;
        removed += f->removed;
        light += size * f->light;
        clamped += size * f->clamped_light;
        r->nonfinite += f->nonfinite;
        r->negative += f->negative;
        r->outside += f->outside;
        r->clamped += f->clamped;
        r->alpha_nonfinite += f->alpha_nonfinite;
        r->alpha_beyond += f->alpha_beyond;
        r->alpha_hidden += f->alpha_hidden;
        r->peak = fmaxf(r->peak, f->peak);
        r->alpha_least = fminf(r->alpha_least, f->alpha_least);
        r->alpha_most = fmaxf(r->alpha_most, f->alpha_most);
    }
    r->clamp_removed = light > 0 ? clamped / light : 0;
    if (m->strict &&
        (r->nonfinite || r->negative || r->alpha_nonfinite || r->alpha_beyond))
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: %zu pixels are not finite and %zu negative, and "
                        "alpha is not finite in %zu and not from 0 to 1 in "
                        "%zu, which strict reading refuses and any other mends",
                        m->name, r->nonfinite, r->negative, r->alpha_nonfinite,
                        r->alpha_beyond);
    if (r->nonfinite)
        ibl_warn(ctx,
                 "%s: %zu pixels were not finite; each became the brighter of "
                 "its neighbours in the row that are, or black if NaN and "
                 "65504 if infinite",
                 m->name, r->nonfinite);
    if (r->negative)
        (removed > notable * left ? ibl_warn : ibl_info)(
            ctx,
            "%s: %zu pixels were negative and became 0: %.2g %% of the map's "
            "light",
            m->name, r->negative, 100 * fmin(removed / left, 1));
    if (!(r->peak > 0) && !m->rows->alpha) /* what alpha hides is black */
        ibl_warn(ctx, "%s: is black everywhere", m->name);
    if (r->low_range)
        ibl_warn(ctx,
                 "%s: low dynamic range (integers, taken for %s): lamps and "
                 "the sun are clipped, so it cannot light well",
                 m->name, r->low_range == 1 ? "sRGB" : "linear");
    if (r->alpha_nonfinite + r->alpha_beyond)
        ibl_warn(ctx,
                 "%s: alpha was not finite in %zu pixels, which count as not "
                 "seen, and not from 0 to 1 in %zu, where it became 0 or 1",
                 m->name, r->alpha_nonfinite, r->alpha_beyond);
    if (r->alpha_hidden)
        ibl_warn(ctx,
                 "%s: %zu pixels had a colour but alpha 0, and became black: "
                 "colours are taken as multiplied by alpha unless they are "
                 "said to be straight",
                 m->name, r->alpha_hidden);
    if (r->has_primaries && m->primaries == IBL_PRIMARIES_KEEP &&
        strcmp(r->primaries_name, "Rec.709"))
        ibl_warn(ctx,
                 *r->primaries_name
                     ? "%s: its primaries are %s, not Rec.709: its colours are "
                       "kept as they are"
                     : "%s: its primaries are %s(%.4g %.4g, %.4g %.4g, %.4g "
                       "%.4g, white %.4g %.4g), not Rec.709: its colours are "
                       "kept as they are",
                 m->name, r->primaries_name, xy[0], xy[1], xy[2], xy[3], xy[4],
                 xy[5], xy[6], xy[7]);
    if (r->outside)
        ibl_warn(ctx,
                 "%s: %zu pixels were outside the gamut of %s, and became "
                 "greyer of the same luminance",
                 m->name, r->outside, ibl_primaries_name(m->primaries));
    if (r->clamped)
        ibl_warn(ctx,
                 "%s: %zu pixels were above %g and were clamped, which took "
                 "%.3g %% of the map's luminance",
                 m->name, r->clamped, m->clamp, 100 * r->clamp_removed);
    return IBL_OK;
}

ibl_status ibl_mender_read(ibl_mender *m, int count, float *rgb)
{
    ibl_rows *rows = m->rows;
    batch b = {.m = m, .rgb = rgb, .first = rows->row, .count = count};
    ibl_status status = ibl_rows_read(rows, count, rgb);

    if (!status)
        status =
            ibl_run(rows->ctx, NULL, (count + ROWS - 1) / ROWS, rows_job, &b);
    return status || rows->row < rows->height ? status : report(m);
}

void ibl_mender_free(ibl_mender *m)
{
    ibl_free(m->facts);
    *m = (ibl_mender){0};
}
