/* SPDX-License-Identifier: MIT */
#include "bake/lobe_kernels.h"

#include <math.h>
#include <string.h>

#include "bake/spectral/lobe_coefficients.h"
#include "core/alloc.h"
#include "core/context.h"

enum {
    ROWS = IBL_LOBE_ROWS,
    SLOTS = IBL_LOBE_SLOTS,
    DIFFUSE = IBL_LOBE_DIFFUSE,
    DEGREE = IBL_LOBE_DEGREE,
    PRODUCTS = 4, /* of a lobe: point, same, next, diffuse */
    AT_ONCE = 4,  /* rows */
    ROWS_IN_JOB = 32
};

/* The products of a lobe or numbers of the rows at once, in vectors on most
 * CPUs. */
typedef float four __attribute__((vector_size(16)));
typedef double four_doubles __attribute__((vector_size(32)));

_Static_assert(ROWS_IN_JOB % AT_ONCE == 0, "whole steps");

/* Coefficients below this have no effect. */
static const double nothing = 2e-5;

struct making {
    ibl_lobe_kernels *out;
    int lobes;                  /* levels and, last, the cosine */
    four (*terms)[DEGREE + 1];  /* of each lobe: its products */
    int end[SLOTS];             /* of each lobe: degrees that have terms */
    int degrees;                /* the most of these */
    double inverse[DEGREE + 1]; /* 1 / (l + 1) */
};

/* ---- the spectrum ------------------------------------------------------ */

/* Continues a spectrum beyond its degree as it fell in the last octave. */
static double beyond(const double *power, int degree, int l)
{
    double last = 0, before = 0;
    for (int i = degree / 2 + 1; i <= degree; i++)
        last += power[i] / (degree - degree / 2);
    for (int i = degree / 4 + 1; i <= degree / 2; i++)
        before += power[i] / (degree / 2 - degree / 4);
    const double fall = before > last && last > 0 ? log2(before / last) : 0;
    return last * pow((l + 0.5) / (0.75 * degree), -fmin(fall, 4));
}

void ibl_lobe_power(const double *power, int degree, double *out)
{
    double sum = 0;
    for (int l = 1; l <= DEGREE && power; l++) {
        out[l] = l <= degree ? power[l] : beyond(power, degree, l);
        sum += (2 * l + 1) * out[l];
    }
    if (!(sum > 1e-20 * (power ? power[0] : 1))) {
        sum = 0;
        for (int l = 1; l <= DEGREE; l++) {
            out[l] = pow(l, -1.2);
            sum += (2 * l + 1) * out[l];
        }
        out[0] = 1;
    } else {
        out[0] = power[0];
    }
    for (int l = 0; l <= DEGREE; l++)
        out[l] *= 4 * IBL_PI / sum;
}

/* ---- lobes ------------------------------------------------------------- */

double ibl_lobe_blur_at(const ibl_specular_layout *layout, int level,
                        int degree)
{
    const int edge = layout->size >> level > 1 ? layout->size >> level : 1;
    const double area = 4 * IBL_PI / (6.0 * edge * edge);
    const double variance =
        area * (layout->roughness[level] > 0 ? 1 / 6.0 : 1 / 4.0);
    return exp(-0.5 * variance * degree * (degree + 1));
}

void ibl_lobe_blur(const ibl_specular_layout *layout, int level, double *k)
{
    for (int l = 0; l <= DEGREE; l++)
        k[l] = ibl_lobe_blur_at(layout, level, l);
}

/* GGX falls as e^(-2 alpha l), and at the end as a cosine, as l^(-5/2): the
 * degree beyond which the lobe of a roughness is below 1e-5. */
static int degree_of(double r)
{
    return (int)fmin(DEGREE, 8 / (r * r) + 100);
}

ibl_status ibl_lobe_ggx(ibl_ctx *ctx, double roughness, double *k)
{
    const ibl_lobe_shape shape =
        ibl_lobe_shape_of(IBL_LOBE_GGX, roughness * roughness);

    for (int l = 0; l <= DEGREE; l++)
        k[l] = 1;
    return roughness > 0 ? ibl_lobe_coefficients(ctx, &shape, DEGREE, k)
                         : IBL_OK;
}

static ibl_status fill_lobes(ibl_ctx *ctx, const ibl_lobe_kernels *out)
{
    const ibl_specular_layout *layout = &out->layout;
    double blur[DEGREE + 1];
    for (int a = 0; a <= layout->levels; a++) {
        double *k = out->lobe + (size_t)a * (DEGREE + 1);
        const double r = a < layout->levels ? layout->roughness[a] : 1;
        const ibl_lobe_shape shape = ibl_lobe_shape_of(IBL_LOBE_GGX, r * r);
        ibl_status status = IBL_OK;
        const int end = r > 0 ? degree_of(r) : 0;
        if (r > 0)
            status = ibl_lobe_coefficients(ctx, &shape, end, k);
        for (int l = r > 0 ? end + 1 : 0; l <= DEGREE; l++)
            k[l] = r > 0 ? 0 : 1;
        if (status)
            return status;
        memcpy(out->sharp + (k - out->lobe), k, (DEGREE + 1) * sizeof *k);
        if (a == layout->levels)
            break;
        ibl_lobe_blur(layout, a, blur);
        for (int l = 0; l <= DEGREE; l++)
            k[l] *= blur[l];
    }
    return IBL_OK;
}

static void fill_terms(struct making *m)
{
    const double *cosine = ibl_lobe_of(m->out, m->lobes - 1);
    for (int l = 0; l <= DEGREE; l++) {
        m->inverse[l] = 1.0 / (l + 1);
        const double c = l ? (2 * l + 1) / (4 * IBL_PI) * m->out->power[l] : 0;
        for (int a = 0; a < m->lobes; a++) {
            const double *k = ibl_lobe_of(m->out, a);
            const double next = a + 2 < m->lobes ? k[DEGREE + 1 + l] : 0;
            m->terms[a][l] =
                (four){(float)(c * k[l]), (float)(c * k[l] * k[l]),
                       (float)(c * k[l] * next), (float)(c * k[l] * cosine[l])};
            if (fabs(k[l]) > nothing)
                m->end[a] = l + 1;
            if (m->end[a] > m->degrees)
                m->degrees = m->end[a];
        }
    }
}

/* ---- tables ------------------------------------------------------------ */

/* P_l(1 - y) of the rows from the first on, with the recurrence of
 * kern/legendre_sums.h. */
static void find_legendre(const struct making *m, int first, four *legendre)
{
    four_doubles y, p = {1, 1, 1, 1}, e = {0};
    for (int i = 0; i < AT_ONCE; i++)
        y[i] = 2 * fmin((double)ibl_lobe_row_at(first + i), 1);
    for (int l = 0; l < m->degrees; l++) {
        legendre[l] = __builtin_convertvector(p, four);
        e -= (2 * l + 1) * y * p;
        p += e * m->inverse[l];
    }
}

/* The sums of a lobe over l. */
static void sum_rows(const struct making *m, const four *legendre, int lobe,
                     four sum[AT_ONCE])
{
    four s[AT_ONCE] = {{0}};
    for (int l = 0; l < m->end[lobe]; l++)
#pragma GCC unroll 4
        for (int i = 0; i < AT_ONCE; i++)
            s[i] += m->terms[lobe][l] * legendre[l][i];
    memcpy(sum, s, sizeof s);
}

static void put(const struct making *m, int lobe, four sum, int row)
{
    ibl_lobe_kernels *out = m->out;
    const int slot = lobe + 1 < m->lobes ? lobe : DIFFUSE;
    const size_t at = (size_t)row * SLOTS + (size_t)slot;
    out->point[at] = sum[0];
    out->same[at] = sum[1];
    out->next[at] = sum[2];
    out->diffuse[at] = sum[3];
}

static void make_rows(const struct making *m, int first)
{
    four legendre[DEGREE + 1], sum[AT_ONCE];
    find_legendre(m, first, legendre);
    for (int a = 0; a < m->lobes; a++) {
        sum_rows(m, legendre, a, sum);
        for (int i = 0; i < AT_ONCE && first + i < ROWS; i++)
            put(m, a, sum[i], first + i);
    }
}

static void rows_job(void *arg, int job, int worker)
{
    (void)worker;
    for (int row = ROWS_IN_JOB * job;
         row < ROWS_IN_JOB * (job + 1) && row < ROWS; row += AT_ONCE)
        make_rows(arg, row);
}

void ibl_lobe_kernels_free(ibl_lobe_kernels *k)
{
    ibl_free(k->point);
    ibl_free(k->power);
    ibl_free(k->lobe);
    *k = (ibl_lobe_kernels){0};
}

ibl_status ibl_lobe_kernels_make(ibl_ctx *ctx,
                                 const ibl_specular_layout *layout,
                                 const double *power, int degree,
                                 ibl_lobe_kernels *out)
{
    *out = (ibl_lobe_kernels){.layout = *layout};
    if (out->layout.levels == 1) {
        out->layout.levels = 2;
        out->layout.roughness[1] = out->layout.roughness[0];
    }
    const size_t lobes = (size_t)out->layout.levels + 1;
    out->power = ibl_alloc_array(DEGREE + 1, sizeof *out->power);
    out->lobe = ibl_alloc_array(2 * lobes, (DEGREE + 1) * sizeof *out->lobe);
    if (!out->power || !out->lobe) {
        ibl_lobe_kernels_free(out);
        return ibl_no_memory(ctx, "the lobes of the levels");
    }
    out->sharp = out->lobe + lobes * (DEGREE + 1);
    ibl_lobe_power(power, degree, out->power);
    out->mean = out->power[0] / (4 * IBL_PI);
    const ibl_status status = fill_lobes(ctx, out);
    if (status)
        ibl_lobe_kernels_free(out);
    return status;
}

ibl_status ibl_lobe_kernels_tables(ibl_ctx *ctx, ibl_lobe_kernels *k)
{
    const size_t table = ROWS * SLOTS;
    struct making m = {.out = k, .lobes = k->layout.levels + 1};
    k->point = ibl_alloc_zeroed(PRODUCTS * table, sizeof *k->point);
    m.terms = ibl_alloc_array((size_t)m.lobes, sizeof *m.terms);
    if (!k->point || !m.terms) {
        ibl_free(m.terms);
        return ibl_no_memory(ctx, "the lobes of the levels");
    }
    k->same = k->point + table;
    k->next = k->same + table;
    k->diffuse = k->next + table;
    fill_terms(&m);
    const ibl_status status = ibl_run(
        ctx, NULL, (ROWS + ROWS_IN_JOB - 1) / ROWS_IN_JOB, rows_job, &m);
    ibl_free(m.terms);
    return status;
}
