/* SPDX-License-Identifier: MIT */
/*
 * A target is the lobe of a surface: of a roughness, a view and F0. It is
 * looked up between two levels, in the direction of ibl/ibl.glsl's
 * ibl_lobe_fit, and mixed with irradiance, at the weights of least error
 * (bake/lobe_fit.h). Which two levels these are is known before the ladder:
 * those around the knot whose lobe alone comes nearest. So the sum of errors is
 * one of segments of the ladder.
 */
#include "bake/ladder.h"

#include <math.h>
#include <stdbool.h>

#include "bake/lobe_bands.h"
#include "bake/lobe_fit.h"
#include "bake/lobe_kernels.h"
#include "bake/spectral/lobe_coefficients.h"
#include "core/alloc.h"
#include "core/context.h"
#include "kern/brdf_quadrature.h"

enum {
    STEPS = 60, /* at least, of r (2 - r) */
    MOST = STEPS + IBL_MAX_LEVELS,
    DEGREES = IBL_LOBE_DEGREE + 1,
    VIEWS = 3, /* Gauss-Legendre points of N.V */
    ROUGHNESSES = 12,
    JOBS = VIEWS * ROUGHNESSES,
    TARGETS = 2 * JOBS,
    ROUNDS = 3
};

static const double roughnesses[ROUGHNESSES] = {
    0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.75, 1};

/* Knots are roughnesses in equal steps of r (2 - r), from 0 to 1; `fine` steps
 * are one of Filament's. */
struct fit {
    ibl_specular_layout *layout;
    int count, fine;
    int ladder[IBL_MAX_LEVELS]; /* the levels' knots */
    double knot[MOST];
    double lobe[MOST][DEGREES]; /* of knots */
    double cosine[DEGREES];
    double blur[IBL_MAX_LEVELS][DEGREES]; /* of levels */
    double weight[DEGREES];               /* C_l */
    ibl_lobe_bands all;                   /* of lobes of any roughness */
    ibl_bands_rule rule;
    double view[VIEWS], view_weight[VIEWS];
    /* Of a level at one knot, with itself, and with the next level at another
     * knot. */
    double same[IBL_MAX_LEVELS][MOST];
    double next[IBL_MAX_LEVELS][MOST][MOST];
    /* Of targets. The first are those of F0 = 1. */
    struct target {
        int knot;                    /* the nearest */
        double share;                /* in the errors of its roughness */
        double power, both, diffuse; /* |T|^2, |cosine|^2, <cosine, T> */
        double with[IBL_MAX_LEVELS][MOST], even[IBL_MAX_LEVELS][MOST];
    } target[TARGETS];
    double slope[TARGETS]; /* of the sum of errors, by a target's square */
};

/* ---- products ----------------------------------------------------------- */

/* Of what is given at the degrees of the bands with a lobe. */
static double sum_of(const ibl_lobe_bands *b, const double *a,
                     const double *lobe)
{
    double sum = 0;
    for (int i = 0; i < b->count; i++)
        sum += a[i] * lobe[b->degree[i]];
    return sum;
}

/* Of knot i, for all levels. */
static void knot_job(void *arg, int i, int worker)
{
    struct fit *f = arg;
    const ibl_lobe_bands *b = &f->all;
    double a[IBL_BANDS_MOST], next[IBL_BANDS_MOST];
    (void)worker;
    for (int m = 0; m < f->layout->levels; m++) {
        const bool last = m + 1 == f->layout->levels;
        for (int k = 0; k < b->count; k++) {
            const int l = b->degree[k];
            a[k] = b->share[k] * f->lobe[i][l] * f->blur[m][l];
            next[k] = last ? 0 : a[k] * f->blur[m + 1][l];
            a[k] *= f->blur[m][l];
        }
        f->same[m][i] = sum_of(b, a, f->lobe[i]);
        for (int j = i + 1; j < f->count && !last; j++)
            f->next[m][i][j] = sum_of(b, next, f->lobe[j]);
    }
}

/* The least squared error of a target between knot a, of level m, and b, of
 * level n: the next or, with the same knot, the same. */
static double error_of(const struct fit *f, const struct target *t, int m,
                       int a, int n, int b)
{
    const ibl_lobe_products p = {
        .h = {t->with[m][a], t->with[n][b]},
        .same = {f->same[m][a], f->same[n][b]},
        .next = {m == n ? f->same[m][a] : f->next[m][a][b]},
        .cosine = {t->even[m][a], t->even[n][b]},
        .both = t->both,
        .diffuse = t->diffuse};
    double at[2];
    return fmax(t->power + ibl_lobe_least(&p, 0, at), 0);
}

/* The knot with the least error alone. */
static int nearest(const struct fit *f, const struct target *t)
{
    double least = HUGE_VAL;
    int best = 0;
    for (int i = 0; i < f->count; i++) {
        const double error = error_of(f, t, 1, i, 1, i);
        if (error < least)
            least = error, best = i;
    }
    return best;
}

/* P_l(c) at the degrees of the bands. */
static void legendre(const ibl_lobe_bands *b, double c, double *p)
{
    double here = 1, before = 0;
    for (int i = 0, l = 0; i < b->count; i++) {
        for (; l < b->degree[i]; l++) {
            const double next = ((2 * l + 1) * c * here - l * before) / (l + 1);
            before = here;
            here = next;
        }
        p[i] = here;
    }
}

/* ---- targets ------------------------------------------------------------ */

/* seen: what the lobe sees of each degree, per share. */
static void multiply(const struct fit *f, const ibl_lobe_bands *b,
                     const double *seen, const double *p, struct target *t)
{
    double with[IBL_BANDS_MOST], even[IBL_BANDS_MOST];
    for (int m = 0; m < f->layout->levels; m++) {
        for (int k = 0; k < b->count; k++) {
            const int l = b->degree[k];
            with[k] = f->blur[m][l] * seen[k];
            even[k] = f->blur[m][l] * b->share[k] * f->cosine[l] * p[k];
        }
        for (int i = 0; i < f->count; i++) {
            t->with[m][i] = sum_of(b, with, f->lobe[i]);
            t->even[m][i] = sum_of(b, even, f->lobe[i]);
        }
    }
}

static void fill_target(const struct fit *f, const ibl_lobe_bands *b, int which,
                        struct target *t)
{
    double p[IBL_BANDS_MOST], seen[IBL_BANDS_MOST];
    legendre(b, cos(b->angle[1 + which]), p);
    for (int k = 0; k < b->count; k++) {
        const double cosine = f->cosine[b->degree[k]];
        const double c = 4 * IBL_PI / (2 * b->degree[k] + 1) * b->share[k];
        seen[k] = c * b->toward[which][1 + which][k];
        t->power += c * b->power[which][k];
        t->diffuse += c * cosine * b->toward[which][0][k];
        t->both += b->share[k] * cosine * cosine;
    }
    multiply(f, b, seen, p, t);
    t->knot = nearest(f, t);
}

static void target_job(void *arg, int job, int worker)
{
    struct fit *f = arg;
    const double r = roughnesses[job / VIEWS], n_v = f->view[job % VIEWS];
    const double sine = sqrt((1 - n_v) * (1 + n_v));
    ibl_lobe_bands b = {.directions = 3};
    (void)worker;
    for (int i = 0; i < 2; i++) {
        const double bend = (i ? 1.4 : 3.3) * r * r * r * (1 - r) * (1 - n_v);
        b.angle[1 + i] = atan2((1 - bend) * sine, (1 - bend) * n_v + bend);
    }
    ibl_bands_degrees(f->weight, r, &b);
    ibl_lobe_bands_make(&f->rule, n_v, r * r, &b);
    for (int i = 0; i < 2; i++) {
        struct target *t = &f->target[i * JOBS + job];
        t->share =
            f->view_weight[job % VIEWS] * 2 * n_v * b.energy[i] * b.energy[i];
        fill_target(f, &b, i, t);
    }
}

/* ---- the best ladder ---------------------------------------------------- */

/* Whether the levels at knots a and b are those around a target. */
static bool is_between(const struct fit *f, const struct target *t, int a,
                       int b)
{
    return t->knot >= a && t->knot < b + (b + 1 == f->count);
}

static double target_error(const struct fit *f, const struct target *t)
{
    for (int m = 1; m < f->layout->levels; m++)
        if (is_between(f, t, f->ladder[m - 1], f->ladder[m]))
            return error_of(f, t, m - 1, f->ladder[m - 1], m, f->ladder[m]);
    return 0;
}

/* The nRMSE of a roughness is the root of a sum over views. A root lies below
 * its tangent: a ladder whose sum by tangents is less than the present one's
 * has a smaller sum of roots. */
static void set_slopes(struct fit *f)
{
    for (int group = 0; group < TARGETS; group += VIEWS) {
        double error = 0, power = 0;
        for (int i = group; i < group + VIEWS; i++) {
            error += f->target[i].share * target_error(f, &f->target[i]);
            power += f->target[i].share * f->target[i].power;
        }
        const double root = sqrt(fmax(error, 1e-12 * power) * power);
        for (int i = group; i < group + VIEWS; i++)
            f->slope[i] = root > 0 ? f->target[i].share / root : 0;
    }
}

static double segment(const struct fit *f, int m, int a, int b)
{
    double sum = 0;
    for (int i = 0; i < TARGETS; i++)
        if (is_between(f, &f->target[i], a, b))
            sum += f->slope[i] * error_of(f, &f->target[i], m, a, m + 1, b);
    return sum;
}

static void choose(struct fit *f)
{
    const int levels = f->layout->levels, last = f->count - 1;
    double sum[IBL_MAX_LEVELS][MOST];
    int from[IBL_MAX_LEVELS][MOST] = {{0}};
    for (int m = 1; m < levels; m++) {
        const int first = m == 1 ? 0 : m - 2 + f->fine;
        for (int b = m + 1 < levels ? m - 1 + f->fine : last;
             b < last + (m + 1 == levels); b++) {
            sum[m][b] = HUGE_VAL;
            for (int a = first; a < (m == 1 ? 1 : b); a++) {
                const double all =
                    (m == 1 ? 0 : sum[m - 1][a]) + segment(f, m - 1, a, b);
                if (all < sum[m][b])
                    sum[m][b] = all, from[m][b] = a;
            }
        }
    }
    for (int m = levels - 1, b = last; m >= 1; b = from[m--][b])
        f->ladder[m] = b;
}

/* ---- the call ----------------------------------------------------------- */

static void place_knots(struct fit *f)
{
    const int n = f->layout->levels - 1;
    f->fine = (STEPS + n - 1) / n;
    f->count = n * f->fine + 1;
    for (int i = 0; i < f->count; i++)
        f->knot[i] = 1 - sqrt(1 - (double)i / (n * f->fine));
    for (int m = 0; m <= n; m++)
        f->ladder[m] = m * f->fine;
}

static ibl_status fit(ibl_ctx *ctx, struct fit *f)
{
    ibl_status status = ibl_lobe_ggx(ctx, 1, f->cosine);
    place_knots(f);
    for (int i = 0; i < f->count && !status; i++)
        status = ibl_lobe_ggx(ctx, f->knot[i], f->lobe[i]);
    for (int m = 0; m < f->layout->levels; m++)
        ibl_lobe_blur(f->layout, m, f->blur[m]);
    ibl_bands_degrees(f->weight, f->knot[1], &f->all);
    ibl_bands_rule_init(&f->rule, ibl_ctx_isa(ctx));
    ibl_gauss_points(VIEWS, f->view, f->view_weight);
    if (!status)
        status = ibl_run(ctx, NULL, f->count, knot_job, f);
    if (!status)
        status = ibl_run(ctx, NULL, JOBS, target_job, f);
    for (int i = 0; i < ROUNDS && !status; i++) {
        set_slopes(f);
        choose(f);
    }
    for (int m = 1; m < f->layout->levels && !status; m++)
        f->layout->roughness[m] = f->knot[f->ladder[m]];
    return status;
}

ibl_status ibl_ladder_fit(ibl_ctx *ctx, const double *power, int degree,
                          ibl_specular_layout *layout)
{
    if (layout->levels <= 2)
        return IBL_OK;
    struct fit *f = ibl_alloc_zeroed(1, sizeof *f);
    if (!f)
        return ibl_no_memory(ctx, "the fit of the levels' roughnesses");
    f->layout = layout;
    ibl_lobe_power(power, degree, f->weight);
    const ibl_status status = fit(ctx, f);
    ibl_free(f);
    return status;
}
