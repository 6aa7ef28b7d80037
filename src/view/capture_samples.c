/* SPDX-License-Identifier: MIT */
/*
 * The sample sets of filtered levels. Points cover the part of GGX's half
 * vectors that is above the horizon (Walter et al. 2007, eq. 35, 36), with
 * turns about the axis by the golden angle. Each looks up the environment,
 * blurred as much as the solid angle that the point stands for (Krivanek and
 * Colbert 2008).
 *
 * A texel's sum is then the cube under a known kernel: blurs b_i (Gaussians,
 * see capture_blur.frag) around directions s_i, times weights w_i. The weights
 * are those that bring it nearest to the lobe, k = D N.L, in the mean of
 * squares over the sphere. In Legendre series, with sqrt(2 l + 1) in the
 * coefficients, the addition theorem gives
 *   <b_i, b_j> = sum over l of b_il b_jl P_l(s_i . s_j),
 *   <b_i, k>   = sum over l of b_il k_l P_l(s_i . axis),
 * so that sum_j <b_i, b_j> w_j = <b_i, k>, with the sum of weights 1. Some
 * weights at the rim are below 0: they undo the width that blurs add.
 */
#include "view/capture_samples.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "ibl/ibl.h"
#include "view/message.h"

/* Of a turn: the golden ratio's fraction. */
static const double golden = 0.6180339887498949;

enum {
    BANDS = 200, /* most of a series */
    MOST = VIEW_CAPTURE_MOST_SAMPLES
};

typedef struct lobe {
    double alpha;
    int count;
    double texel; /* mean solid angle of one of level 0 */
    int last;     /* level of the lookups */
    int bands;
    double kernel[BANDS]; /* the lobe's series */
} lobe;

typedef struct point {
    double x, y, z, lod;
    double series[BANDS]; /* of its blur */
} point;

/* ---- series ------------------------------------------------------------ */

/* P_l(c). */
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

/* Of k, whose tail is long and whose peak narrow: theta goes by squares. */
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

/* Variance along an axis of a lookup in a level. In level 0 it is 1/6 of a
 * texel between texels, less the 1/12 that a texel of one colour has itself. */
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

/* Levels are only mixed from a sixth to five sixths: one lookup in three needs
 * one level, half the work. */
static double snapped(double lod)
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
    /* The variance is the solid angle: less shows the points, more makes
     * weights and the errors of lookups grow. */
    const double lod =
        0.5 * log2(1 / (b->count * pdf * VIEW_CAPTURE_BLUR * b->texel));
    /* Level 0 is as coarse as texels are: not where level 1 will do. */
    const double least = variance(b, 1) < a2;
    const double angle = 2 * atan2(sin_h, cos_h);
    const double phi = 2 * M_PI * fmod(i * golden, 1);
    point p = {.x = sin(angle) * cos(phi),
               .y = sin(angle) * sin(phi),
               .z = cos(angle),
               .lod = snapped(fmin(fmax(lod, least), b->last))};

    expand_blur(b, &p);
    return p;
}

/* ---- weights ----------------------------------------------------------- */

/* Cholesky: a, n x n, symmetric and positive; its root into the lower
 * triangle. */
static void root(double *a, int n)
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

/* Of one lobe at a time. */
typedef struct workspace {
    point point[MOST];
    double matrix[MOST * MOST], weight[MOST], one[MOST];
} workspace;

/* The weights of the points. */
static void weigh(const lobe *b, workspace *w)
{
    const point *p = w->point;
    double *matrix = w->matrix, *x = w->weight, *y = w->one;
    /* Lookups are off by about this much of themselves. */
    const double off = 0.03;
    const int n = b->count;
    double sum_x = 0, sum_y = 0;

    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            const double c =
                p[i].x * p[j].x + p[i].y * p[j].y + p[i].z * p[j].z;
            matrix[(size_t)i * n + j] =
                product(p[i].series, p[j].series, b->bands, c);
        }
        matrix[(size_t)i * n + i] *= 1 + off * off;
        x[i] = product(p[i].series, b->kernel, b->bands, p[i].z);
        y[i] = 1;
    }
    root(matrix, n);
    solve(matrix, n, x);
    solve(matrix, n, y);
    for (int i = 0; i < n; i++) {
        sum_x += x[i];
        sum_y += y[i];
    }
    for (int i = 0; i < n; i++)
        x[i] += y[i] * (1 - sum_x) / sum_y;
}

/* samples: x, y, weight and level of each. */
static void draw(lobe *b, workspace *w, float *samples)
{
    expand_lobe(b);
    for (int i = 0; i < b->count; i++)
        w->point[i] = place(b, i);
    weigh(b, w);
    for (int i = 0; i < b->count; i++) {
        *samples++ = (float)w->point[i].x;
        *samples++ = (float)w->point[i].y;
        *samples++ = (float)w->weight[i];
        *samples++ = (float)w->point[i].lod;
    }
}

/* ---- all of it --------------------------------------------------------- */

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
    float *all = calloc((size_t)levels, row * sizeof *all);
    workspace *w = malloc(sizeof *w);

    if (!all || !w) {
        view_fail("no memory for the samples of a capture");
        free(all);
        all = NULL;
    }
    for (int l = 1; l <= levels && all; l++) {
        const bool diffuse = l == levels;
        const double r =
            diffuse ? 1 : ibl_level_roughness(IBL_ROUGHNESS_LINEAR, l, levels);
        lobe b = {.alpha = r * r,
                  .count = diffuse ? MOST : VIEW_CAPTURE_SAMPLES,
                  .texel = 4 * M_PI / (6.0 * size * size),
                  .last = view_capture_lookups(size) - 1};
        draw(&b, w, all + row * (size_t)(l - 1));
    }
    free(w);
    return all;
}
