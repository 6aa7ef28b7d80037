/* SPDX-License-Identifier: MIT */
/*
 * Sample sets of filtered levels. Points cover the GGX half vectors whose
 * reflection is above the horizon (Walter et al. 2007, eq. 35, 36); each turns
 * by the golden angle from the one before. Each looks up the environment,
 * blurred by the solid angle that the point stands for (Krivanek and Colbert
 * 2008).
 *
 * A filtered texel is then the cube under a known kernel: blurs b_i (Gaussians,
 * see capture_blur.frag) around directions s_i, times weights w_i. The weights
 * minimise the mean square, over the sphere, of the difference to the lobe k =
 * D N.L. In Legendre series, with sqrt(2 l + 1) in the coefficients, the
 * addition theorem gives
 *   <b_i, b_j> = sum over l of b_il b_jl P_l(s_i . s_j),
 *   <b_i, k>   = sum over l of b_il k_l P_l(s_i . axis),
 * so sum_j <b_i, b_j> w_j = <b_i, k>, with the sum of weights 1. Some weights
 * at the rim are below 0: they compensate for the width that blurs add.
 */
#include "view/capture.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "common/signals.h"
#include "ibl/ibl.h"
#include "view/message.h"

/* Turn from one point to the next: the golden ratio - 1. */
static const double golden = 0.6180339887498949;

enum {
    BANDS = 200, /* maximum number of coefficients */
    MOST = VIEW_CAPTURE_MOST_SAMPLES
};

typedef struct lobe {
    double alpha;
    int count;
    double texel; /* mean solid angle of a texel of level 0, in sr */
    int last;     /* last level of the lookups */
    int bands;
    double kernel[BANDS]; /* Legendre series of the lobe */
} lobe;

typedef struct point {
    double x, y, z, lod;
    double series[BANDS]; /* Legendre series of its blur */
} point;

/* ---- series ------------------------------------------------------------ */

/* Fills p with P_l(c). */
static void legendre(double c, int bands, double p[BANDS])
{
    p[0] = 1;
    p[1] = c;
    for (int l = 1; l + 1 < bands; l++)
        p[l + 1] = ((2 * l + 1) * c * p[l] - l * p[l - 1]) / (l + 1);
}

/* The sum of a_l b_l P_l(c). */
static double product(const double *a, const double *b, int bands, double c)
{
    double p[BANDS], sum = 0;

    legendre(c, bands, p);
    for (int l = 0; l < bands; l++)
        sum += a[l] * b[l] * p[l];
    return sum;
}

/* Expands k. Steps of theta grow linearly, since the peak is narrow and the
 * tail long. */
static void expand_lobe(lobe *b)
{
    const int steps = 2000;
    const double a2 = b->alpha * b->alpha;
    double p[BANDS];

    b->bands = (int)fmin(6 / b->alpha + 20, BANDS);
    for (int i = 0; i < steps; i++) {
        const double t = (i + 0.5) / steps, theta = 0.5 * M_PI * t * t;
        const double c = cos(theta), h2 = 0.5 + 0.5 * c;
        const double d = h2 * (a2 - 1) + 1;
        const double weight = c / (d * d) * sin(theta) * t;
        legendre(c, b->bands, p);
        for (int l = 0; l < b->bands; l++)
            b->kernel[l] += weight * p[l];
    }
    const double all = b->kernel[0];
    for (int l = 0; l < b->bands; l++)
        b->kernel[l] *= sqrt(2 * l + 1) / all;
}

/* Variance along an axis of a lookup in a level, in sr. Level 0: 1/6 of a texel
 * by interpolation, less the 1/12 of a texel of one colour. */
static double variance(const lobe *b, int level)
{
    return b->texel * (level ? VIEW_CAPTURE_BLUR * pow(4, level) : 1.0 / 12);
}

static void expand_blur(const lobe *b, point *p)
{
    const int level = (int)p->lod;
    const double part = p->lod - level;
    const double near = variance(b, level), far = variance(b, level + 1);

    for (int l = 0; l < b->bands; l++) {
        const double half = -0.5 * l * (l + 1);
        p->series[l] = sqrt(2 * l + 1) *
                       ((1 - part) * exp(half * near) + part * exp(half * far));
    }
}

/* ---- points ------------------------------------------------------------ */

/* Mixes levels only from 1/6 to 5/6, so one lookup in three needs one level and
 * half the work. */
static double snap_level(double lod)
{
    const double level = floor(lod);

    return level + fmin(fmax(1.5 * (lod - level) - 0.25, 0), 1);
}

static point place(const lobe *b, int i)
{
    const double a2 = b->alpha * b->alpha, part = 1 / (1 + a2);
    const double u = (i + 0.5) / b->count * part;
    const double s2 = a2 * u, c2 = 1 - u;
    const double sin_h = sqrt(s2 / (s2 + c2)), cos_h = sqrt(c2 / (s2 + c2));
    const double t = sin_h * sin_h + a2 * cos_h * cos_h;
    const double pdf = a2 / (M_PI * t * t) / (4 * part);
    /* The blur's variance is the point's solid angle: less would show single
     * points, more would increase weights and the errors of lookups. */
    const double lod =
        0.5 * log2(1 / (b->count * pdf * VIEW_CAPTURE_BLUR * b->texel));
    /* Lookups in level 0 show its texels. Level 1 must do where it is narrow
     * enough for the lobe. */
    const double least = variance(b, 1) < a2;
    const double angle = 2 * atan2(sin_h, cos_h);
    const double phi = 2 * M_PI * fmod(i * golden, 1);
    point p = {.x = sin(angle) * cos(phi),
               .y = sin(angle) * sin(phi),
               .z = cos(angle),
               .lod = snap_level(fmin(fmax(lod, least), b->last))};

    expand_blur(b, &p);
    return p;
}

/* ---- weights ----------------------------------------------------------- */

/* Cholesky decomposition of a, n x n, symmetric and positive definite. The
 * factor replaces the lower triangle. */
static void cholesky(double *a, int n)
{
    for (int j = 0; j < n; j++)
        for (int i = j; i < n; i++) {
            double sum = a[(size_t)i * n + j];
            for (int k = 0; k < j; k++)
                sum -= a[(size_t)i * n + k] * a[(size_t)j * n + k];
            a[(size_t)i * n + j] =
                i == j ? sqrt(sum) : sum / a[(size_t)j * n + j];
        }
}

static void solve(const double *a, int n, double *x)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++)
            x[i] -= a[(size_t)i * n + k] * x[k];
        x[i] /= a[(size_t)i * n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            x[i] -= a[(size_t)k * n + i] * x[k];
        x[i] /= a[(size_t)i * n + i];
    }
}

/* Reused for each lobe. */
typedef struct workspace {
    point point[MOST];
    double matrix[MOST * MOST], weight[MOST], one[MOST];
} workspace;

/* Solves for the weights of the points. */
static void find_weights(const lobe *b, workspace *w)
{
    const point *p = w->point;
    double *matrix = w->matrix, *x = w->weight, *y = w->one;
    /* Assumed relative error of a lookup; keeps weights small. */
    const double relative_error = 0.03;
    const int n = b->count;
    double sum_x = 0, sum_y = 0;

    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            const double c =
                p[i].x * p[j].x + p[i].y * p[j].y + p[i].z * p[j].z;
            matrix[(size_t)i * n + j] =
                product(p[i].series, p[j].series, b->bands, c);
        }
        matrix[(size_t)i * n + i] *= 1 + relative_error * relative_error;
        x[i] = product(p[i].series, b->kernel, b->bands, p[i].z);
        y[i] = 1;
    }
    cholesky(matrix, n);
    solve(matrix, n, x);
    solve(matrix, n, y);
    for (int i = 0; i < n; i++) {
        sum_x += x[i];
        sum_y += y[i];
    }
    for (int i = 0; i < n; i++)
        x[i] += y[i] * (1 - sum_x) / sum_y;
}

/* Fills samples with x, y, weight and level of each point. */
static void make_samples(lobe *b, workspace *w, float *samples)
{
    expand_lobe(b);
    for (int i = 0; i < b->count; i++)
        w->point[i] = place(b, i);
    find_weights(b, w);
    for (int i = 0; i < b->count; i++) {
        *samples++ = (float)w->point[i].x;
        *samples++ = (float)w->point[i].y;
        *samples++ = (float)w->weight[i];
        *samples++ = (float)w->point[i].lod;
    }
}

/* ---- sample sets ------------------------------------------------------- */

int view_capture_lookups(int size)
{
    int levels = 1;

    while (size >> levels >= 4)
        levels++;
    return levels;
}

float *view_capture_samples(int size, int levels)
{
    const size_t row = (size_t)4 * MOST;
    float *all = ibl_need(calloc((size_t)levels, row * sizeof *all));
    workspace *w = ibl_need(malloc(sizeof *w));

    for (int l = 1; l <= levels; l++) {
        const bool diffuse = l == levels;
        const double r =
            diffuse ? 1 : ibl_level_roughness(IBL_ROUGHNESS_LINEAR, l, levels);
        lobe b = {.alpha = r * r,
                  .count = diffuse ? MOST : VIEW_CAPTURE_SAMPLES,
                  .texel = 4 * M_PI / (6.0 * size * size),
                  .last = view_capture_lookups(size) - 1};
        make_samples(&b, w, all + row * (size_t)(l - 1));
    }
    free(w);
    return all;
}
