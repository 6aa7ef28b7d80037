/* SPDX-License-Identifier: MIT */
/*
 * The coefficients of a map in the layout of ibl_bake_sh, including all that
 * the analysis keeps apart.
 *
 * The cyclic exchange of axes x' = z, y' = x, z' = y is a quarter turn about y'
 * between two quarter turns about the poles. With D[m][n] Wigner's
 * d^l_mn(pi / 2) and complex harmonics,
 *     Y_lm(x, y, z) = (-i)^m sum over n of D[n][m] Y_ln(x', y', z').
 * D[n][-m] = (-1)^(l+n) D[n][m] and D[n][m] = (-1)^(m-n) D[m][n] bring this to
 * n, m >= 0 and to real harmonics without the Condon-Shortley phase: with C and
 * S the functions with cos and sin, g_0 = 1, g_n = sqrt(2),
 *     m even   C_m = +-g_m sum D[m][n] g_n C'_n    l + n even
 *              S_m = +-g_m sum D[m][n] g_n S'_n    l + n odd
 *     m odd    C_m = +-g_m sum D[m][n] g_n S'_n    l + n even
 *              S_m = -+g_m sum D[m][n] g_n C'_n    l + n odd
 * with the upper sign for m = 0, 1 and the lower for m = 2, 3, and so on.
 * Coefficients transform like their functions.
 *
 * Rows of D start at the top, D[l][n] = (-1)^(l-n) 2^-l sqrt((2l)! / ((l+n)!
 * (l-n)!)), and continue downwards by the elements of Jx,
 *     2n D[m] = c+(m) D[m+1] + c-(m) D[m-1],
 * the direction in which D grows where it does not oscillate (Risbo 1996;
 * Trapani and Navaza 2006).
 */
#include <math.h>
#include <string.h>

#include "bake/spectral/engine.h"
#include "core/alloc.h"
#include "core/context.h"

/* ---- from +Y to +Z ------------------------------------------------------ */

/* Orders n in pairs: an even and an odd one. */
static size_t padded(int l)
{
    return ((size_t)l + 2) / 2 * 2;
}

static size_t rotate_work(int l)
{
    return 9 * padded(l);
}

static void top_row(int l, double *row)
{
    double d = ldexp(1.0, -l);

    for (int n = l; n >= 0; n--) {
        row[n] = (l - n) % 2 ? -d : d;
        d *= sqrt((double)(l + n) / (l - n + 1));
    }
}

/* The row below m: next may be the row above m, which it replaces. */
static void next_row(int l, int m, const double *row, const double *above,
                     double *next)
{
    const double scale = 1.0 / sqrt((double)(l + m) * (l - m + 1));
    const double up = scale * sqrt((double)(l - m) * (l + m + 1));

    for (int n = 0; n <= l; n++)
        next[n] = 2.0 * scale * n * row[n] - up * above[n];
}

/* sum[0] over even n, sum[1] over odd n. */
static void dot(const double *row, const double *g, size_t count, double sum[2])
{
    double even = 0.0, odd = 0.0;

    for (size_t n = 0; n < count; n += 2) {
        even += row[n] * g[n];
        odd += row[n + 1] * g[n + 1];
    }
    sum[0] = even;
    sum[1] = odd;
}

/*
 * The inputs of channel k: for even m C' where l + n is even and S' where it
 * is odd, for odd m the other way round.
 */
static void split(int l, int k, const double *ring, double *for_even,
                  double *for_odd)
{
    for (int n = 0; n <= l; n++) {
        const double g = n ? sqrt(2.0) : 1.0;
        const double c = g * ring[6 * n + k], s = g * ring[6 * n + 3 + k];
        for_even[n] = (l + n) % 2 ? s : c;
        for_odd[n] = (l + n) % 2 ? c : s;
    }
}

static void order(int l, int m, const double *row, const double *inputs,
                  double *out)
{
    const size_t count = padded(l);
    const double g = (m ? sqrt(2.0) : 1.0) * (m % 4 >= 2 ? -1.0 : 1.0);

    for (int k = 0; k < 3; k++) {
        double sum[2];
        dot(row, inputs + (size_t)(2 * k + m % 2) * count, count, sum);
        const double even = sum[l % 2], odd = sum[1 - l % 2];
        out[3 * (l + m) + k] = g * even;
        if (m)
            out[3 * (l - m) + k] = m % 2 ? -g * odd : g * odd;
    }
}

/*
 * Turns the polar axis of real spherical harmonics of degree l from y to z.
 *   ring   l + 1 times 6 doubles: for m = 0..l the coefficients (R, G, B) of
 *          the function with cos(m p) and the one with sin(m p), where p is
 *          the azimuth of a frame x' = z, y' = x, z' = y
 *   out    2l + 1 times 3 doubles: R, G, B of the order -l..l in the frame
 *          x, y, z (the basis of ibl_bake_sh)
 *   work   rotate_work(l) doubles of scratch
 * l <= 1000: beyond it 2^-l leaves the range of doubles.
 */
static void rotate(int l, const double *ring, double *out, double *work)
{
    const size_t count = padded(l);
    double *row = work, *other = work + count, *inputs = work + 2 * count;

    memset(work, 0, rotate_work(l) * sizeof *work);
    for (int k = 0; k < 3; k++)
        split(l, k, ring, inputs + 2 * (size_t)k * count,
              inputs + (2 * (size_t)k + 1) * count);
    top_row(l, row);
    for (int m = l; m >= 0; m--) {
        order(l, m, row, inputs, out);
        if (m) {
            double *above = other;
            next_row(l, m, row, above, above);
            other = row;
            row = above;
        }
    }
}

struct conversion {
    const ibl_harmonics *in;
    double *coeffs;
    double *work; /* for each worker */
};

static size_t work_size(int degree)
{
    return 6 * ((size_t)degree + 1) + rotate_work(degree);
}

/*
 * Order m of one degree, for rotate(): the integrals with g P_lm cos(m p)
 * and g P_lm sin(m p), where g = 1 for m = 0, else sqrt(2), and
 * p = 90 degrees - phi is the world's azimuth about y, from z towards
 * x. a is the integral with P_lm e^(-i m phi).
 */
static void to_real(int m, const double *a, double *to)
{
    const double g = m ? sqrt(2.0) : 1.0;
    const double angle = fmod(m * 90.0, 360.0) / 180.0 * IBL_PI;
    const double c = g * cos(angle), s = g * sin(angle);

    for (int k = 0; k < 3; k++) {
        to[k] = c * a[2 * k] - s * a[2 * k + 1];
        to[3 + k] = s * a[2 * k] + c * a[2 * k + 1];
    }
}

static void convert_job(void *arg, int l, int worker)
{
    const struct conversion *c = arg;
    double *ring = c->work + (size_t)worker * work_size(c->in->degree);

    for (int m = 0; m <= l; m++)
        to_real(m, ibl_harmonics_at(c->in, m) + 6 * (size_t)(l - m),
                ring + 6 * (size_t)m);
    rotate(l, ring, c->coeffs + 3 * (size_t)l * (size_t)l,
           ring + 6 * ((size_t)c->in->degree + 1));
}

/* The coefficients of a map about +Y in the layout of ibl_bake_sh: real, with
 * the polar axis +Z. */
static ibl_status convert(ibl_ctx *ctx, const ibl_harmonics *in, double *coeffs)
{
    struct conversion c = {.in = in, .coeffs = coeffs};

    c.work = ibl_alloc_array((size_t)ibl_ctx_threads(ctx),
                             work_size(in->degree) * sizeof *c.work);
    if (!c.work)
        return ibl_no_memory(ctx, "the spherical harmonics");
    const ibl_status status =
        ibl_run(ctx, NULL, in->degree + 1, convert_job, &c);
    ibl_free(c.work);
    return status;
}

/* ---- what was kept apart ------------------------------------------------ */

/* Adds the rows without the lights. From here on nothing is scaled. */
static void add_rows(const ibl_spectral *s, ibl_harmonics *sum)
{
    for (int m = 0; m <= sum->degree; m++) {
        const size_t count = 6 * (size_t)(sum->degree - m + 1);
        const double *from = ibl_harmonics_at(&s->harmonics, m);
        double *to = ibl_harmonics_at(sum, m);
        for (size_t i = 0; i < count; i++)
            to[i] = (to[i] + from[i]) / s->scale;
    }
}

static void add_mean(const ibl_spectral *s, ibl_harmonics *sum)
{
    double *a = ibl_harmonics_at(sum, 0);
    for (int c = 0; c < 3; c++)
        a[2 * c] += (double)s->mean[c] * sqrt(4 * IBL_PI);
}

/* Leaves all rows without lights out of an analysis. */
static void set_rows(const ibl_spectral *s, ibl_ring_spectra *rows)
{
    rows->first = rows->end;
    rows->end = 0;
    for (int i = 0; i < s->light_count; i++) {
        const int j = s->lights[i].row, mirror = s->height - 1 - j;
        const int from_pole = j < mirror ? j : mirror;
        if (from_pole < rows->first)
            rows->first = from_pole;
        if (from_pole >= rows->end)
            rows->end = from_pole + 1;
    }
}

/* Analyses only the lights. */
static ibl_status analyse_lights(const ibl_spectral *s, ibl_harmonics *out)
{
    ibl_ring_spectra rows;
    ibl_status status =
        ibl_ring_spectra_alloc(s->ctx, s->height, out->degree + 1, &rows);
    if (status)
        return status;
    out->single = s->single;
    set_rows(s, &rows);
    memset(rows.data, 0,
           6 * (size_t)rows.orders * rows.stride * sizeof *rows.data);
    status = ibl_spectral_add_lights(s, s->lights, s->light_count, &rows);
    if (!status)
        status = ibl_sht_analyse(s->ctx, NULL, &rows, s->widths, out);
    ibl_ring_spectra_free(&rows);
    return status;
}

/* The harmonics of the map. *sum is empty after an error. */
static ibl_status add_all(const ibl_spectral *s, int degree, ibl_harmonics *sum)
{
    const size_t edge = (size_t)degree + 1;
    ibl_status status = ibl_harmonics_alloc(s->ctx, degree, sum);
    if (status)
        return status;
    if (s->light_count)
        status = analyse_lights(s, sum);
    else
        memset(sum->data, 0, 3 * edge * (edge + 1) * sizeof *sum->data);
    if (status) {
        ibl_harmonics_free(sum);
        return status;
    }
    add_rows(s, sum);
    add_mean(s, sum);
    return IBL_OK;
}

ibl_status ibl_spectral_sh(const ibl_spectral *s, int degree, double *coeffs)
{
    ibl_harmonics sum;
    ibl_status status = add_all(s, degree, &sum);
    if (!status)
        status = convert(s->ctx, &sum, coeffs);
    ibl_harmonics_free(&sum);
    return status;
}

ibl_status ibl_spectral_power(const ibl_spectral *s, int degree, double *power)
{
    ibl_harmonics sum;
    const ibl_status status = add_all(s, degree, &sum);
    if (status)
        return status;
    ibl_sht_power(&sum, power);
    for (int l = 0; l <= degree; l++)
        power[l] /= 2 * l + 1;
    ibl_harmonics_free(&sum);
    return IBL_OK;
}
