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

/* ---- lobes ------------------------------------------------------------- */

/* Factors of k_l for the texels of a level. Bilinear lookups blur by t (1 - t)
 * of a texel's square on average, and the texels of the environment are means
 * of a square. */
static double blur(const ibl_specular_layout *layout, int level, int degree)
{
    const int edge = layout->size >> level > 1 ? layout->size >> level : 1;
    const double area = 4 * IBL_PI / (6.0 * edge * edge);
    const double variance =
        area * (layout->roughness[level] > 0 ? 1 / 6.0 : 1 / 4.0);
    return exp(-0.5 * variance * degree * (degree + 1));
}

/* GGX falls as e^(-2 alpha l), and at the end as a cosine, as l^(-5/2): the
 * degree beyond which the lobe of a roughness is below 1e-5. */
static int degree_of(double r)
{
    return (int)fmin(DEGREE, 8 / (r * r) + 100);
}

static ibl_status fill_lobes(ibl_ctx *ctx, const ibl_lobe_kernels *out)
{
    const ibl_specular_layout *layout = &out->layout;
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
        for (int l = 0; l <= DEGREE && a < layout->levels; l++)
            k[l] *= blur(layout, a, l);
    }
    return IBL_OK;
}

/* The mean power of photographs is C_l = l^-1.5, here scaled so that a point
 * has the power 1. */
static void fill_terms(struct making *m)
{
    const double *cosine = ibl_lobe_of(m->out, m->lobes - 1);
    double power[DEGREE + 1] = {0}, sum = 0;
    for (int l = 1; l <= DEGREE; l++) {
        power[l] = (2 * l + 1) * pow(l, -1.5);
        sum += power[l];
    }
    for (int l = 0; l <= DEGREE; l++) {
        m->inverse[l] = 1.0 / (l + 1);
        const double c = power[l] / sum;
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
    ibl_free(k->lobe);
    *k = (ibl_lobe_kernels){0};
}

ibl_status ibl_lobe_kernels_make(ibl_ctx *ctx,
                                 const ibl_specular_layout *layout,
                                 ibl_lobe_kernels *k)
{
    *k = (ibl_lobe_kernels){.layout = *layout};
    if (k->layout.levels == 1) {
        k->layout.levels = 2;
        k->layout.roughness[1] = k->layout.roughness[0];
    }
    const size_t table = ROWS * SLOTS;
    struct making m = {.out = k, .lobes = k->layout.levels + 1};
    k->lobe = ibl_alloc_array((size_t)m.lobes, (DEGREE + 1) * sizeof *k->lobe);
    k->point = ibl_alloc_zeroed(PRODUCTS * table, sizeof *k->point);
    m.terms = ibl_alloc_array((size_t)m.lobes, sizeof *m.terms);
    ibl_status status = k->lobe && k->point && m.terms
                            ? fill_lobes(ctx, k)
                            : ibl_no_memory(ctx, "the lobes of the levels");
    k->same = k->point + table;
    k->next = k->same + table;
    k->diffuse = k->next + table;
    if (!status) {
        fill_terms(&m);
        status = ibl_run(ctx, NULL, (ROWS + ROWS_IN_JOB - 1) / ROWS_IN_JOB,
                         rows_job, &m);
    }
    ibl_free(m.terms);
    return status;
}
