/* SPDX-License-Identifier: MIT */
#include "io/repair.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/half.h"
#include "kern/max_finite.h"
#include "kern/pixel.h"

enum {
    ROWS = 16,    /* in a job */
    SAMPLES = 128 /* of the light of a row */
};

/* Renderers and filters round 0 and 1; such values are not errors. */
static const float rounding = 1e-3f;

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

/* A set of rows whose signs are mended together. */
typedef struct batch {
    float *rgb;
    int width, count;
    uint32_t *most; /* for each row */
    float *below;   /* the sum of what was below 0 */
    atomic_size_t nonfinite, negative;
    atomic_uint peak; /* bits of a float */
} batch;

/* Sets negative values of a row to 0; counts negative and non-finite pixels.
 * Returns the bits of the largest value, or infinity's if one is not finite. */
static uint32_t mend_signs(batch *b, float *p, float *below)
{
    size_t nonfinite = 0, negative = 0;
    float peak = 0;

    for (int i = 0; i < b->width; i++, p += 3) {
        bool is_negative = false, is_nonfinite = false;
        for (int c = 0; c < 3; c++) {
            if (!is_finite(p[c])) {
                is_nonfinite = true;
            } else if (p[c] <= 0) { /* -0 too */
                is_negative |= p[c] < 0;
                *below -= p[c];
                p[c] = 0;
            } else if (p[c] > peak) {
                peak = p[c];
            }
        }
        negative += is_negative;
        nonfinite += is_nonfinite;
    }
    b->negative += negative;
    b->nonfinite += nonfinite;
    /* The bits of positive floats sort like the floats. */
    for (unsigned old = b->peak; old < ibl_bits_of(peak);)
        if (atomic_compare_exchange_weak(&b->peak, &old, ibl_bits_of(peak)))
            break;
    return nonfinite ? IBL_INFINITE_BITS : ibl_bits_of(peak);
}

static void signs_job(void *arg, int job, int worker)
{
    batch *b = arg;
    const size_t floats = 3 * (size_t)b->width;

    (void)worker;
    for (int y = job * ROWS; y < b->count && y < (job + 1) * ROWS; y++) {
        if (is_dirty(b->most[y]))
            b->most[y] =
                mend_signs(b, b->rgb + floats * (size_t)y, &b->below[y]);
    }
}

/* Sets negative values to 0 in rows that need it; keeps non-finite ones. */
static ibl_status mend_batch(ibl_mender *m, batch *b)
{
    ibl_read_report *report = &m->rows->report;
    const int step = b->width / SAMPLES + 1;
    const int jobs = (b->count + ROWS - 1) / ROWS;
    ibl_status status = IBL_OK;
    bool needed = false;

    b->peak = ibl_bits_of(report->peak);
    for (int y = 0; y < b->count; y++) {
        if (is_dirty(b->most[y]))
            needed = true;
        else if (b->most[y] > b->peak)
            b->peak = b->most[y];
    }
    if (needed)
        status = ibl_run(m->rows->ctx, NULL, jobs, signs_job, b);
    for (int y = 0; y < b->count; y++) {
        const float *p = b->rgb + 3 * (size_t)b->width * (size_t)y;
        double light = 0; /* a sun between the samples counts once */
        for (int x = 0; x < b->width; x += step)
            for (int c = 0; c < 3; c++)
                light +=
                    is_finite(p[3 * x + c]) ? (double)p[3 * x + c] * step : 0;
        m->light += is_dirty(b->most[y])
                        ? light
                        : fmax(light, (double)ibl_float_of(b->most[y]));
        m->removed += (double)b->below[y];
    }
    report->peak = ibl_float_of(b->peak);
    report->nonfinite += b->nonfinite;
    report->negative += b->negative;
    return status;
}

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

static void mend_row(float *row, const float *const rows[3], int width,
                     float *peak)
{
    for (int x = 0; x < width; x++) {
        for (int c = 0; c < 3; c++) {
            float *f = &row[3 * x + c];
            if (is_finite(*f))
                continue;
            *f = best_neighbour(
                rows, width, x, c,
                ibl_bits_of(*f) == IBL_INFINITE_BITS ? IBL_HALF_MAX : 0);
            if (*f > *peak)
                *peak = *f;
        }
    }
}

/* Mends values that are not finite, in the rows after m->above, from their
 * neighbours before any repair. */
static void mend_nonfinite(ibl_mender *m, const uint32_t *most, int count,
                           float *rgb)
{
    const size_t floats = 3 * (size_t)m->rows->width;

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
        if (is_dirty(most[y]))
            mend_row(row, (const float *const[3]){m->above, before, below},
                     m->rows->width, &m->rows->report.peak);
        m->above = before;
        m->turn = !m->turn;
    }
}

/* ---- rows in order -------------------------------------------------- */

ibl_status ibl_mender_init(ibl_mender *m, ibl_rows *rows)
{
    const size_t bytes = 3 * sizeof(float) * (size_t)rows->width;

    *m = (ibl_mender){.rows = rows};
    m->most = ibl_alloc_array((size_t)rows->height, sizeof *m->most);
    m->below = ibl_alloc_zeroed((size_t)rows->height, sizeof *m->below);
    m->before[0] = ibl_alloc_array(1, bytes);
    m->before[1] = ibl_alloc_array(1, bytes);
    m->ahead = ibl_alloc_array(1, bytes);
    if (!m->most || !m->below || !m->before[0] || !m->before[1] || !m->ahead)
        return ibl_no_memory(rows->ctx, "rows of an image");
    return IBL_OK;
}

/* Reads the map's next count rows and mends their signs. */
static ibl_status read_new(ibl_mender *m, int count, float *rgb)
{
    ibl_rows *rows = m->rows;
    batch b = {.rgb = rgb,
               .width = rows->width,
               .count = count,
               .most = m->most + rows->row,
               .below = m->below + rows->row};
    if (!count)
        return IBL_OK;
    const ibl_status status = ibl_rows_read(rows, count, rgb, b.most);
    return status ? status : mend_batch(m, &b);
}

ibl_status ibl_mender_read(ibl_mender *m, int count, float *rgb)
{
    const size_t floats = 3 * (size_t)m->rows->width;
    const int old = m->has_ahead, first = m->rows->row - old;
    const uint32_t *most = m->most + first;

    if (old)
        memcpy(rgb, m->ahead, floats * sizeof *rgb);
    ibl_status status = read_new(m, count - old, rgb + (old ? floats : 0));
    if (status)
        return status;
    m->has_ahead = is_dirty(most[count - 1]) && first + count < m->rows->height;
    if (m->has_ahead)
        status = read_new(m, 1, m->ahead);
    if (!status)
        mend_nonfinite(m, most, count, rgb);
    return status;
}

void ibl_mender_free(ibl_mender *m)
{
    ibl_free(m->ahead);
    ibl_free(m->before[1]);
    ibl_free(m->before[0]);
    ibl_free(m->below);
    ibl_free(m->most);
    *m = (ibl_mender){0};
}

/* ---- alpha ---------------------------------------------------------- */

static float mend_alpha(float a, ibl_alpha_range *range,
                        ibl_read_report *report)
{
    if (!is_finite(a)) {
        report->alpha_nonfinite++;
        return 0;
    }
    range->lowest = fminf(range->lowest, a);
    range->highest = fmaxf(range->highest, a);
    report->alpha_beyond += a < -rounding || a > 1 + rounding;
    return a > 0 ? fminf(a, 1) : 0;
}

void ibl_alpha_mend(float *alpha, float *rgb, size_t pixels, bool straight,
                    ibl_alpha_range *range, ibl_read_report *report)
{
    for (size_t i = 0; i < pixels; i++, rgb += 3) {
        const bool known = is_finite(alpha[i]);
        const float a = mend_alpha(alpha[i], range, report);
        const float factor = straight || a <= 0 ? a : 1;

        alpha[i] = a;
        report->alpha_least = fminf(report->alpha_least, a);
        report->alpha_most = fmaxf(report->alpha_most, a);
        report->alpha_hidden +=
            !straight && a <= 0 && known && rgb[0] + rgb[1] + rgb[2] > 0;
        for (int k = 0; k < 3; k++)
            rgb[k] *= factor;
    }
}
