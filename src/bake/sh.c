/* SPDX-License-Identifier: MIT */
/*
 * Spherical harmonics of a map. The rows of a map are rings around the y
 * axis, so the sums are done in the frame x' = z, y' = x, z' = y whose pole
 * is y: Fourier sums along each ring, then sums over rings with Legendre
 * functions; sh_rotate.c turns the result to the pole z of the convention.
 *
 *     F_m(j)  = sum over columns of L exp(i m phi)
 *     b_lm    = sum over rows of dO P_lm(cos t) F_m
 *
 * A column and its mirror image about phi = 0 share cos(m phi) and, but for
 * the sign, sin(m phi); so do a row and its mirror image about the equator
 * P_lm, by the parity of l + m.
 */
#include <math.h>
#include <string.h>

#include "bake/sh_rotate.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"

static const double pi = IBL_PI;

enum {
    ROWS = 4,          /* that go through a Fourier sum together */
    LANES = 3 * ROWS,  /* R, G, B of each */
    PAIRS = 4,         /* of rows that go through Legendre sums together */
    SLOTS = 2 * PAIRS, /* the rows of these: 4 northern, their 4 mirrors */
    COEFFS = 6         /* R, G, B with cos, R, G, B with sin */
};

/* Bytes of Fourier sums kept at a time, and products per Fourier job. */
static const size_t ring_bytes = 8 << 20;
static const int job_products = 1 << 22;

struct analysis {
    const ibl_image *env;
    int degree;
    double yaw_deg;
    double *table;      /* cos, sin of pi k / width, k < 2 width */
    double *folded;     /* of each worker, 2 LANES per folded column */
    double *recurrence; /* of each worker, 2 per degree */
    double *ring;       /* [m][slot][COEFFS]: F times dO */
    double *sums;       /* b: of each m COEFFS for l = m..degree */
    double *start;      /* K_mm (2m - 1)!!, by m */
    double *work;       /* of each worker, for the rotation */
    double *coeffs;
    int slots;      /* rows of ring, a multiple of SLOTS */
    int first_pair; /* of the rows in ring */
    int m_chunk, m_chunks;
};

/* The map's row in a slot, or -1: a northern row is found in the slots 0..3
 * of its 8, its mirror image 4 further. */
static int slot_row(const struct analysis *a, int slot)
{
    const int height = a->env->height;
    const int pair = a->first_pair + slot / SLOTS * PAIRS + slot % PAIRS;

    if (slot % SLOTS < PAIRS)
        return pair < (height + 1) / 2 ? pair : -1;
    return pair < height / 2 ? height - 1 - pair : -1;
}

static double ring_angle(const struct analysis *a, int row)
{
    const double h = a->env->height, w = a->env->width;

    return 4.0 * pi / w * sin(pi * (row + 0.5) / h) * sin(0.5 * pi / h);
}

/* ---- along the rings ------------------------------------------------ */

/* L(i) + L(-i) and L(i) - L(-i) of one row, into its lanes. */
static void fold_row(const float *px, int width, double *to)
{
    for (int i = 0; i < (width + 1) / 2; i++, to += 2 * LANES) {
        const int mirror = width - 1 - i;
        for (int k = 0; k < 3; k++) {
            const double a = px[3 * i + k];
            const double b = mirror == i ? 0.0 : px[3 * mirror + k];
            to[k] = a + b;
            to[LANES + k] = mirror == i ? 0.0 : a - b;
        }
    }
}

static void fold_rows(const struct analysis *a, int slot, double *folded)
{
    const size_t w = (size_t)a->env->width;

    for (int r = 0; r < ROWS; r++) {
        const int row = slot_row(a, slot + r);
        if (row >= 0) {
            fold_row(a->env->data + 3 * w * (size_t)row, (int)w,
                     folded + 3 * r);
            continue;
        }
        for (size_t i = 0; i < (w + 1) / 2; i++) {
            double *to = folded + i * 2 * LANES + 3 * r;
            to[0] = to[1] = to[2] = 0.0;
            to[LANES] = to[LANES + 1] = to[LANES + 2] = 0.0;
        }
    }
}

/* phi = pi (2i + 1) / width - pi; the sign (-1)^m of the last is the
 * caller's. */
static void fourier(const double *folded, int width, int m, const double *table,
                    double sum[2 * LANES])
{
    const int period = 2 * width, step = 2 * m % period;
    int at = m % period;

    memset(sum, 0, 2 * LANES * sizeof *sum);
    for (int i = 0; i < (width + 1) / 2; i++, folded += 2 * LANES) {
        const double c = table[2 * (size_t)at], s = table[2 * (size_t)at + 1];
        for (int k = 0; k < LANES; k++) {
            sum[k] += c * folded[k];
            sum[LANES + k] += s * folded[LANES + k];
        }
        at += step;
        at -= at >= period ? period : 0;
    }
}

static void fourier_job(void *arg, int job, int worker)
{
    const struct analysis *a = arg;
    const int w = a->env->width;
    const int slot = job / a->m_chunks * ROWS;
    const int first = job % a->m_chunks * a->m_chunk;
    double *folded =
        a->folded + (size_t)worker * (size_t)((w + 1) / 2) * 2 * LANES;
    double sum[2 * LANES];

    fold_rows(a, slot, folded);
    for (int m = first; m < first + a->m_chunk && m <= a->degree; m++) {
        double *to = a->ring + ((size_t)m * a->slots + slot) * COEFFS;
        fourier(folded, w, m, a->table, sum);
        for (int r = 0; r < ROWS; r++, to += COEFFS) {
            const int row = slot_row(a, slot + r);
            const double scale =
                row < 0 ? 0.0 : (m % 2 ? -1.0 : 1.0) * ring_angle(a, row);
            for (int k = 0; k < 3; k++) {
                to[k] = scale * sum[3 * r + k];
                to[3 + k] = scale * sum[LANES + 3 * r + k];
            }
        }
    }
}

/* ---- over the rings ------------------------------------------------- */

/*
 * P_l = a (x P_l-1 - b P_l-2) for the orthonormal functions of order m:
 * a = sqrt((4l^2 - 1) / (l^2 - m^2)), b = 1 / (the a before).
 */
static void make_recurrence(int m, int degree, double *ab)
{
    double before = 0.0;

    for (int l = m + 1; l <= degree; l++) {
        const double l2 = (double)l * l, m2 = (double)m * m;
        ab[2 * (l - m)] = sqrt((4.0 * l2 - 1.0) / (l2 - m2));
        ab[2 * (l - m) + 1] = before;
        before = 1.0 / ab[2 * (l - m)];
    }
}

/*
 * Adds 4 pairs of rows to the sums of order m.
 *   x, p    cos(t) of the northern rows, and their P_mm
 *   f       for l + m even and odd, the COEFFS of the four pairs
 */
static void legendre(int count, const double *ab, const double x[PAIRS],
                     double p[PAIRS], const double f[2][PAIRS][COEFFS],
                     double *sums)
{
    double last[PAIRS] = {0.0};

    for (int l = 0; l < count; l++, sums += COEFFS) {
        if (l) {
            for (int q = 0; q < PAIRS; q++) {
                const double next =
                    ab[2 * l] * (x[q] * p[q] - ab[2 * l + 1] * last[q]);
                last[q] = p[q];
                p[q] = next;
            }
        }
        for (int k = 0; k < COEFFS; k++)
            sums[k] += (p[0] * f[l % 2][0][k] + p[1] * f[l % 2][1][k]) +
                       (p[2] * f[l % 2][2][k] + p[3] * f[l % 2][3][k]);
    }
}

/* Offset of order m in sums, in multiples of COEFFS. */
static size_t order_offset(int degree, int m)
{
    return (size_t)m * (size_t)(2 * degree + 3 - m) / 2;
}

static void legendre_job(void *arg, int m, int worker)
{
    const struct analysis *a = arg;
    const double step = pi / a->env->height;
    double *ab = a->recurrence + (size_t)worker * 2 * (size_t)(a->degree + 1);
    double *sums = a->sums + order_offset(a->degree, m) * COEFFS;

    make_recurrence(m, a->degree, ab);
    for (int slot = 0; slot < a->slots; slot += SLOTS) {
        const double *north = a->ring + ((size_t)m * a->slots + slot) * COEFFS;
        const double *south = north + PAIRS * COEFFS;
        double x[PAIRS], p[PAIRS], f[2][PAIRS][COEFFS], any = 0.0;
        for (int q = 0; q < PAIRS; q++) {
            const int row = slot_row(a, slot + q);
            const double theta = step * (row + 0.5);
            x[q] = cos(theta);
            /* Where sin^m underflows, P_lm is nothing for all l <= 1000. */
            p[q] = row < 0 ? 0.0 : a->start[m] * pow(sin(theta), m);
            any += p[q];
            for (int k = 0; k < COEFFS; k++) {
                f[0][q][k] = north[COEFFS * q + k] + south[COEFFS * q + k];
                f[1][q][k] = north[COEFFS * q + k] - south[COEFFS * q + k];
            }
        }
        if (any > 0.0)
            legendre(a->degree - m + 1, ab, x, p, f, sums);
    }
}

/* ---- to the world's frame ------------------------------------------- */

/* The azimuth about y, from z towards x, is 90 degrees + yaw - phi. */
static void turn_order(const struct analysis *a, int m, const double *b,
                       double *to)
{
    const double g = m ? sqrt(2.0) : 1.0;
    const double angle = fmod(m * (90.0 + a->yaw_deg), 360.0) / 180.0 * pi;
    const double c = g * cos(angle), s = g * sin(angle);

    for (int k = 0; k < 3; k++) {
        to[k] = c * b[k] + s * b[3 + k];
        to[3 + k] = s * b[k] - c * b[3 + k];
    }
}

static size_t work_size(int degree)
{
    return COEFFS * ((size_t)degree + 1) + ibl_sh_rotate_work(degree);
}

static void rotate_job(void *arg, int l, int worker)
{
    const struct analysis *a = arg;
    double *ring = a->work + (size_t)worker * work_size(a->degree);

    for (int m = 0; m <= l; m++)
        turn_order(a, m,
                   a->sums +
                       (order_offset(a->degree, m) + (size_t)(l - m)) * COEFFS,
                   ring + COEFFS * (size_t)m);
    ibl_sh_rotate(l, ring, a->coeffs + 3 * (size_t)l * (size_t)l,
                  ring + COEFFS * ((size_t)a->degree + 1));
}

/* ---- the call ------------------------------------------------------- */

static ibl_status analyse(ibl_ctx *ctx, struct analysis *a)
{
    const int pairs = (a->env->height + 1) / 2;
    ibl_status status;

    for (int pair = 0; pair < pairs; pair += a->slots / 2) {
        a->first_pair = pair;
        ibl_progress(ctx, "sh", (double)pair / pairs);
        status =
            ibl_run(ctx, NULL, a->slots / ROWS * a->m_chunks, fourier_job, a);
        if (!status)
            status = ibl_run(ctx, NULL, a->degree + 1, legendre_job, a);
        if (status)
            return status;
    }
    status = ibl_run(ctx, NULL, a->degree + 1, rotate_job, a);
    if (!status)
        ibl_progress(ctx, "sh", 1.0);
    return status;
}

static void plan(struct analysis *a)
{
    const int pairs = (a->env->height + 1) / 2;
    const int rounded = (pairs + PAIRS - 1) / PAIRS * SLOTS;
    const size_t row = ((size_t)a->degree + 1) * COEFFS * sizeof *a->ring;
    const size_t fit = ring_bytes / row / SLOTS * SLOTS;

    a->slots = fit < SLOTS ? SLOTS : fit < (size_t)rounded ? (int)fit : rounded;
    a->m_chunk = job_products / a->env->width;
    if (a->m_chunk > a->degree + 1)
        a->m_chunk = a->degree + 1;
    a->m_chunks = (a->degree + a->m_chunk) / a->m_chunk;
}

static bool allocate(struct analysis *a, int threads)
{
    const size_t w = (size_t)a->env->width, n = (size_t)a->degree + 1;
    const size_t t = (size_t)threads;

    a->table = ibl_alloc_array(2 * w, 2 * sizeof *a->table);
    a->folded = ibl_alloc_array(t * ((w + 1) / 2), 2 * LANES * sizeof(double));
    a->recurrence = ibl_alloc_array(t * n, 2 * sizeof *a->recurrence);
    a->ring = ibl_alloc_array((size_t)a->slots * n, COEFFS * sizeof(double));
    a->sums = ibl_alloc_zeroed(n * (n + 1) / 2, COEFFS * sizeof *a->sums);
    a->start = ibl_alloc_array(n, sizeof *a->start);
    a->work = ibl_alloc_array(t, work_size(a->degree) * sizeof *a->work);
    return a->table && a->folded && a->recurrence && a->ring && a->sums &&
           a->start && a->work;
}

static void fill_tables(struct analysis *a)
{
    const int w = a->env->width;

    for (int k = 0; k < 2 * w; k++) {
        a->table[2 * (size_t)k] = cos(pi * k / w);
        a->table[2 * (size_t)k + 1] = sin(pi * k / w);
    }
    a->start[0] = sqrt(0.25 / pi);
    for (int m = 1; m <= a->degree; m++)
        a->start[m] = a->start[m - 1] * sqrt((2.0 * m + 1.0) / (2.0 * m));
}

ibl_status ibl_bake_sh(ibl_ctx *ctx, const ibl_image *env, int degree,
                       double yaw_deg, double *coeffs)
{
    struct analysis a = {.env = env, .degree = degree, .coeffs = coeffs};
    ibl_status status;

    if (degree < 0 || degree > IBL_MAX_SH_DEGREE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "spherical harmonics of degree %d: must be 0 to %d",
                        degree, IBL_MAX_SH_DEGREE);
    if (!isfinite(yaw_deg))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "the yaw must be finite");
    a.yaw_deg = fmod(yaw_deg, 360.0);
    plan(&a);
    if (allocate(&a, ibl_ctx_threads(ctx))) {
        fill_tables(&a);
        status = analyse(ctx, &a);
    } else {
        status = ibl_no_memory(ctx, "the spherical harmonics");
    }
    ibl_free(a.table);
    ibl_free(a.folded);
    ibl_free(a.recurrence);
    ibl_free(a.ring);
    ibl_free(a.sums);
    ibl_free(a.start);
    ibl_free(a.work);
    return status;
}

/* Ramamoorthi and Hanrahan 2001, eq. 8: 0 for odd l > 1, for even l
 *     2 (-1)^(l/2 - 1) / ((l + 2) (l - 1)) * l! / (2^l (l/2)!^2). */
double ibl_sh_cosine(int l)
{
    double central = 1.0;

    if (l == 1)
        return 2.0 / 3.0;
    if (l < 0 || l % 2)
        return 0.0;
    for (int k = 1; k <= l / 2; k++)
        central *= (2.0 * k - 1.0) / (2.0 * k);
    const double value = 2.0 * central / ((l + 2.0) * (l - 1.0));
    return l / 2 % 2 ? value : -value;
}
