/* SPDX-License-Identifier: MIT */
#include "io/mend.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
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

/* Whether a row may have values that are not finite or negative. After
 * mend_signs: whether it has values that are not finite. Its largest component
 * otherwise. */
static bool is_dirty(uint32_t most)
{
    return most >= IBL_INFINITE_BITS;
}

static bool is_finite(float f)
{
    return (ibl_bits_of(f) & IBL_INFINITE_BITS) != IBL_INFINITE_BITS;
}

/* A set of rows that jobs go through. */
typedef struct batch {
    ibl_mender *m;
    float *rgb;
    int first, count; /* rows of the map */
    atomic_size_t nonfinite, negative, outside, clamped;
} batch;

/* ---- signs ------------------------------------------------------------- */

/* Sets negative values of a row to 0; counts negative and non-finite pixels.
 * Returns the bits of the largest value, or infinity's if one is not finite. */
static uint32_t mend_signs(batch *b, float *p, double *removed)
{
    size_t nonfinite = 0, negative = 0;
    float peak = 0, below = 0;

    for (int i = 0; i < b->m->rows->width; i++, p += 3) {
        bool is_negative = false, is_nonfinite = false;
        for (int c = 0; c < 3; c++) {
            if (!is_finite(p[c])) {
                is_nonfinite = true;
            } else if (p[c] <= 0) { /* -0 too */
                is_negative |= p[c] < 0;
                below -= p[c];
                p[c] = 0;
            } else if (p[c] > peak) {
                peak = p[c];
            }
        }
        negative += is_negative;
        nonfinite += is_nonfinite;
    }
    *removed = (double)below;
    b->negative += negative;
    b->nonfinite += nonfinite;
    return nonfinite ? IBL_INFINITE_BITS : ibl_bits_of(peak);
}

static void signs_job(void *arg, int job, int worker)
{
    batch *b = arg;
    const int width = b->m->rows->width, step = width / SAMPLES + 1;
    ibl_max_finite_fn *look = ibl_max_finite(ibl_ctx_isa(b->m->rows->ctx));

    (void)worker;
    for (int y = job * ROWS; y < b->count && y < (job + 1) * ROWS; y++) {
        float *p = b->rgb + 3 * (size_t)width * (size_t)y;
        uint32_t *most = &b->m->most[b->first + y];
        *most = look(p, 3 * (size_t)width);
        ibl_row_sums *sums = &b->m->sums[b->first + y];
        if (is_dirty(*most))
            *most = mend_signs(b, p, &sums->removed);
        for (int x = 0; x < width; x += step)
            for (int c = 0; c < 3; c++)
                sums->left +=
                    is_finite(p[3 * x + c]) ? (double)p[3 * x + c] * step : 0;
        if (!is_dirty(*most)) /* a sun between the samples counts once */
            sums->left = fmax(sums->left, (double)ibl_float_of(*most));
    }
}

/* Reads the map's next count rows. Sets negative values to 0; keeps those that
 * are not finite. */
static ibl_status read_new(ibl_mender *m, int count, float *rgb)
{
    ibl_rows *rows = m->rows;
    batch b = {.m = m, .rgb = rgb, .first = rows->row, .count = count};

    if (!count)
        return IBL_OK;
    ibl_status status = ibl_rows_read(rows, count, rgb);
    if (!status)
        status =
            ibl_run(rows->ctx, NULL, (count + ROWS - 1) / ROWS, signs_job, &b);
    for (int y = 0; y < count && !status; y++)
        if (!is_dirty(m->most[b.first + y]))
            rows->report.peak =
                fmaxf(rows->report.peak, ibl_float_of(m->most[b.first + y]));
    rows->report.nonfinite += b.nonfinite;
    rows->report.negative += b.negative;
    return status;
}

/* ---- values that are not finite ---------------------------------------- */

/* The largest finite value of component c around column x in three rows (NULL
 * beyond a pole); columns wrap. */
static float best_neighbour(const float *const rows[3], int width, int x, int c,
                            float otherwise)
{
    float best = otherwise;
    bool found = false;
    for (int r = 0; r < 3; r++) {
        if (!rows[r])
            continue;
        for (int dx = -1; dx <= 1; dx++) {
            const int column = (x + dx + width) % width;
            const float f = rows[r][3 * column + c];
            if ((r == 1 && column == x) || !is_finite(f) ||
                (found && f <= best))
                continue;
            best = f;
            found = true;
        }
    }
    return best;
}

/* Mends values that are not finite, in the rows after m->above, from their
 * neighbours before any repair. */
static void mend_nonfinite(ibl_mender *m, const uint32_t *most, int count,
                           float *rgb)
{
    const int width = m->rows->width;
    const size_t floats = 3 * (size_t)width;
    float *peak = &m->rows->report.peak;

    for (int y = 0; y < count; y++) {
        float *row = rgb + floats * (size_t)y, *before = m->before[m->turn];
        const float *below = y + 1 < count  ? row + floats
                             : m->has_ahead ? m->ahead
                                            : NULL;
        if (!is_dirty(most[y]) && y + 1 < count) {
            m->above = row;
            continue;
        }
        memcpy(before, row, floats * sizeof *before);
        const float *const rows[3] = {m->above, before, below};
        for (int i = 0; i < 3 * width && is_dirty(most[y]); i++) {
            if (!is_finite(row[i])) {
                const bool inf = ibl_bits_of(row[i]) == IBL_INFINITE_BITS;
                row[i] = best_neighbour(rows, width, i / 3, i % 3,
                                        inf ? IBL_HALF_MAX : 0);
            }
            *peak = fmaxf(*peak, row[i]);
        }
        m->above = before;
        m->turn = !m->turn;
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

static void colours_job(void *arg, int job, int worker)
{
    batch *b = arg;
    const ibl_mender *m = b->m;
    const double *k = m->matrix;
    const int width = m->rows->width;
    const bool clamps = m->clamp < INFINITY;
    size_t outside = 0, clamped = 0;

    (void)worker;
    for (int y = job * ROWS; y < b->count && y < (job + 1) * ROWS; y++) {
        float *rgb = b->rgb + 3 * (size_t)width * (size_t)y;
        ibl_row_sums *sums = &m->sums[b->first + y];
        for (int x = 0; x < width; x++, rgb += 3) {
            const double r = rgb[0], g = rgb[1], blue = rgb[2];
            double p[3];
            for (int i = 0; i < 3; i++)
                p[i] = k[3 * i] * r + k[3 * i + 1] * g + k[3 * i + 2] * blue;
            if (m->converts)
                outside += bring_inside(m, p);
            const double most = largest(p);
            const double kept = most > m->clamp ? m->clamp / most : 1;
            if (clamps) {
                sums->light += luminance(m, p);
                sums->clamped += (1 - kept) * luminance(m, p);
                clamped += kept < 1;
            }
            for (int i = 0; i < 3; i++)
                rgb[i] = (float)fmin(kept * p[i], FLT_MAX);
        }
    }
    b->outside += outside;
    b->clamped += clamped;
}

/* ---- alpha -------------------------------------------------------------- */

/* Mends alpha. Multiplies straight colours by it; other colours become black
 * where it is 0. */
static void mend_alpha(const ibl_mender *m, int first, int count, float *rgb)
{
    const size_t width = (size_t)m->rows->width;
    float *alpha = m->rows->alpha + width * (size_t)first;
    ibl_read_report *r = &m->rows->report;

    if (!first)
        r->alpha_most = 0;
    for (size_t i = 0; i < width * (size_t)count; i++, rgb += 3) {
        const bool known = is_finite(alpha[i]);
        const float a = known && alpha[i] > 0 ? fminf(alpha[i], 1) : 0;
        const float factor = m->straight || a <= 0 ? a : 1;

        r->alpha_nonfinite += !known;
        r->alpha_beyond += known && fabsf(alpha[i] - a) > alpha_rounding;
        r->alpha_least = fminf(r->alpha_least, a);
        r->alpha_most = fmaxf(r->alpha_most, a);
        r->alpha_hidden +=
            !m->straight && a <= 0 && known && rgb[0] + rgb[1] + rgb[2] > 0;
        alpha[i] = a;
        for (int k = 0; k < 3; k++)
            rgb[k] *= factor;
    }
}

/* ---- rows in order ------------------------------------------------------ */

static bool same_space(const double a[8], const double b[8])
{
    const char *names[2] = {ibl_colour_space_name(a), ibl_colour_space_name(b)};
    return names[0] && names[0] == names[1];
}

static ibl_status init_colours(ibl_mender *m, const ibl_input *in,
                               const ibl_read_options *opts)
{
    ibl_rows *rows = m->rows;
    ibl_read_report *r = &rows->report;
    const double *rec709 = ibl_primaries_xy(IBL_PRIMARIES_REC709);
    const bool known = rows->has_primaries || rows->primaries[7] > 0;
    const double *xy = known ? rows->primaries : rec709;
    const char *name = ibl_colour_space_name(xy);
    const double gain = exp2(opts->exposure);
    double unused[9];
    float luma[3];

    *m->matrix = m->matrix[4] = m->matrix[8] = 1;
    m->primaries = opts->primaries;
    m->clamp = opts->clamp > 0 ? opts->clamp : INFINITY;
    r->has_primaries = rows->has_primaries;
    memcpy(r->primaries, xy, sizeof r->primaries);
    snprintf(r->primaries_name, sizeof r->primaries_name, "%s",
             name ? name : "");
    if (!ibl_colour_space(xy, unused, luma))
        ibl_colour_space(rec709, unused, luma);
    if (opts->primaries != IBL_PRIMARIES_KEEP) {
        const double *to = ibl_primaries_xy(opts->primaries);
        m->converts = !same_space(xy, to);
        if (m->converts && !ibl_colour_matrix(xy, to, m->matrix, luma))
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

ibl_status ibl_mender_init(ibl_mender *m, const ibl_input *in, ibl_rows *rows,
                           const ibl_read_options *opts)
{
    const size_t row_bytes = 3 * sizeof(float) * (size_t)rows->width;

    *m = (ibl_mender){.rows = rows, .name = in->name, .strict = opts->strict};
    m->straight = rows->straight || opts->alpha == IBL_ALPHA_STRAIGHT;
    rows->report.has_alpha = rows->alpha != NULL;
    rows->report.alpha_least = rows->report.alpha_most = 1;
    m->most = ibl_alloc_array((size_t)rows->height, sizeof *m->most);
    m->sums = ibl_alloc_zeroed((size_t)rows->height, sizeof *m->sums);
    m->before[0] = ibl_alloc_array(1, row_bytes);
    m->before[1] = ibl_alloc_array(1, row_bytes);
    m->ahead = ibl_alloc_array(1, row_bytes);
    if (!m->most || !m->sums || !m->before[0] || !m->before[1] || !m->ahead)
        return ibl_no_memory(rows->ctx, "rows of an image");
    return init_colours(m, in, opts);
}

static void warn_of_colours(const ibl_mender *m)
{
    const ibl_read_report *r = &m->rows->report;
    const double *xy = r->primaries;
    ibl_ctx *ctx = m->rows->ctx;

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
}

/* After the last row: warns of mended values or, if strict, refuses them. */
static ibl_status report(ibl_mender *m)
{
    ibl_read_report *r = &m->rows->report;
    ibl_ctx *ctx = m->rows->ctx;
    const int height = m->rows->height;
    const bool map = r->layout == IBL_INPUT_EQUIRECT;
    ibl_row_sums all = {0};

    for (int y = 0; y < height; y++) {
        /* the solid angle of a row, but for a factor */
        const double size =
            map ? cos(IBL_PI * y / height) - cos(IBL_PI * (y + 1) / height) : 1;
        all.left += m->sums[y].left;
        all.removed += m->sums[y].removed;
        all.light += size * m->sums[y].light;
        all.clamped += size * m->sums[y].clamped;
    }
    r->clamp_removed = all.light > 0 ? all.clamped / all.light : 0;
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
                 "%s: %zu pixels were not finite; each became its brightest "
                 "neighbour that is, or black if NaN and 65504 if infinite",
                 m->name, r->nonfinite);
    if (r->negative)
        (all.removed > notable * all.left ? ibl_warn : ibl_info)(
            ctx,
            "%s: %zu pixels were negative and became 0: %.2g %% of the map's "
            "light",
            m->name, r->negative, 100 * fmin(all.removed / all.left, 1));
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
    warn_of_colours(m);
    return IBL_OK;
}

ibl_status ibl_mender_read(ibl_mender *m, int count, float *rgb)
{
    ibl_rows *rows = m->rows;
    const size_t floats = 3 * (size_t)rows->width;
    const int old = m->has_ahead, first = rows->row - old;
    const uint32_t *most = m->most + first;
    batch b = {.m = m, .rgb = rgb, .first = first, .count = count};

    if (old)
        memcpy(rgb, m->ahead, floats * sizeof *rgb);
    ibl_status status = read_new(m, count - old, rgb + (old ? floats : 0));
    if (status)
        return status;
    m->has_ahead = is_dirty(most[count - 1]) && first + count < rows->height;
    if (m->has_ahead)
        status = read_new(m, 1, m->ahead);
    if (status)
        return status;
    mend_nonfinite(m, most, count, rgb);
    if (m->changes)
        status = ibl_run(rows->ctx, NULL, (count + ROWS - 1) / ROWS,
                         colours_job, &b);
    rows->report.outside += b.outside;
    rows->report.clamped += b.clamped;
    if (!status && rows->alpha)
        mend_alpha(m, first, count, rgb);
    return status || first + count < rows->height ? status : report(m);
}

void ibl_mender_free(ibl_mender *m)
{
    ibl_free(m->ahead);
    ibl_free(m->before[1]);
    ibl_free(m->before[0]);
    ibl_free(m->sums);
    ibl_free(m->most);
    *m = (ibl_mender){0};
}
