/* SPDX-License-Identifier: MIT */
/*
 * The split-sum table (Karis 2013, "Real Shading in Unreal Engine 4").
 *
 * Over half vectors, dL = 4 V.H dH, and D N.H dH is the measure du dphi / 2pi
 * of ibl_ggx_sample_half, so both integrals are
 *     integral of 4 vis N.L V.H / N.H (1 - Fc or Fc) du dphi / 2pi
 * with vis = G / (4 N.L N.V). With t the tangent of the half vector's angle,
 * N.L = 2 V.H N.H - N.V is above the horizon where
 *     cos(phi) > c0(t) = N.V (t^2 - 1) / (2 sin_v t),
 * which is everywhere for t <= t1 = tan((90 degrees - view angle) / 2) and
 * nowhere for t >= 1 / t1. The sums end on these limits and never cross them:
 * an inner part over full rings, an outer part over arcs |phi| < acos(c0).
 *
 * The radius is t = alpha sinh(y), so u = tanh(y)^2: of unit scale at the
 * peak of the lobe and logarithmic along its tail, which makes the integrand
 * smooth on the scale of y for every alpha and view. Gauss-Legendre points in
 * y and on the arcs, equal steps on the rings.
 *
 * The table is smooth in ln(N.V) and ln(roughness + constant), so it is
 * integrated at Chebyshev points of these and interpolated by their
 * polynomial. Errors against an adaptive double integral, all sizes: 2e-5 at
 * most (tests/check_lut.c); a half float near 1 rounds off 2.4e-4.
 */
#include <math.h>
#include <string.h>

#include "brdf/ggx.h"
#include "brdf/hammersley.h"
#include "core/alloc.h"
#include "core/context.h"

enum {
    MAX_SIZE = 4096,
    MAX_SAMPLES = 1048576,
    RADII = 20, /* of the outer part */
    INNER_RADII = 14,
    ANGLES = 10, /* on half a ring or arc */
    JOB_EVALUATIONS = 1 << 20
};

/* The tail beyond y holds e^-2y of the lobe: 3e-7 in the inner part, where the
 * integrand is bounded; in the outer it may grow like 1 / N.H. */
static const double inner_end = 7.5, outer_end = 30.0;

/* Points and weights on [0, 1]. */
typedef struct rule {
    double at[RADII], weight[RADII];
} rule;

/* Interpolation from Chebyshev points in ln(x + shift). */
typedef struct grid {
    int points;
    double *at;    /* their x */
    double *basis; /* size rows: the weight of each point */
} grid;

struct bake {
    ibl_geometry geometry;
    int size, samples;
    rule inner, outer, arc;
    double ring[ANGLES]; /* cos(phi) on rings */
    grid view, rough;
    double *nodes;     /* the table at the points of rough and view */
    double *columns;   /* of each worker: a row of it, interpolated */
    double *turn;      /* cos(phi) of each sample */
    int chunk, chunks; /* texels of a job, jobs of a row */
    float *out;
};

typedef struct view {
    double sine, cosine, alpha;
    ibl_geometry geometry;
} view;

/* ---- the integrand -------------------------------------------------- */

/* Adds weight times the integrand (scale and bias) at a half vector. */
static void add(const view *v, double sin_h, double cos_h, double cos_phi,
                double weight, double sum[2])
{
    double v_dot_h = v->sine * sin_h * cos_phi + v->cosine * cos_h;
    const double n_dot_l = 2.0 * v_dot_h * cos_h - v->cosine;

    if (!(n_dot_l > 0.0))
        return;
    if (v_dot_h > 1.0)
        v_dot_h = 1.0;
    const double vis =
        v->geometry == IBL_GEOMETRY_SCHLICK_IBL
            ? ibl_schlick_visibility(n_dot_l, v->cosine, v->alpha)
            : ibl_smith_visibility(n_dot_l, v->cosine, v->alpha);
    const double g = weight * 4.0 * vis * n_dot_l * v_dot_h / cos_h;
    const double f = ibl_fresnel_weight(v_dot_h);
    sum[0] += g * (1.0 - f);
    sum[1] += g * f;
}

static view make_view(const struct bake *b, double n_dot_v, double roughness)
{
    return (view){sqrt((1.0 - n_dot_v) * (1.0 + n_dot_v)), n_dot_v,
                  roughness * roughness, b->geometry};
}

/* ---- quadrature ----------------------------------------------------- */

/* Gauss-Legendre on [0, 1]: Newton's method on the Legendre polynomial. */
static void make_rule(int n, rule *r)
{
    for (int i = 0; i < n; i++) {
        double x = cos(IBL_PI * (i + 0.75) / (n + 0.5)), slope = 1.0;
        for (int step = 0; step < 8; step++) {
            double p = 1.0, before = 0.0;
            for (int k = 1; k <= n; k++) {
                const double next =
                    ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k;
                before = p;
                p = next;
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        r->at[i] = 0.5 * (1.0 - x);
        r->weight[i] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
}

/* cos(a) for 0 <= a <= pi as 1 - 2 sin^2(a / 2), the sine by its series to
 * the eleventh power: within 1.2e-7, in a few multiplications. */
static double cosine(double a)
{
    const double x = 0.5 * a, q = x * x;
    const double s =
        x * (1.0 -
             q / 6.0 *
                 (1.0 -
                  q / 20.0 *
                      (1.0 - q / 42.0 * (1.0 - q / 72.0 * (1.0 - q / 110.0)))));

    return 1.0 - 2.0 * s * s;
}

/* The half vector's angle at y, and du / dy. */
static double radius(double alpha, double y, double *sin_h, double *cos_h)
{
    const double e = exp(-2.0 * y), tanh_y = (1.0 - e) / (1.0 + e);
    const double t = alpha * sinh(y);

    *cos_h = 1.0 / sqrt(1.0 + t * t);
    *sin_h = t * *cos_h;
    /* 2 tanh / cosh^2 */
    return 8.0 * tanh_y * e / ((1.0 + e) * (1.0 + e));
}

static void integrate(const struct bake *b, const view *v, double sum[2])
{
    const double t1 = v->cosine / (1.0 + v->sine);
    const double y1 = fmin(asinh(t1 / v->alpha), inner_end);
    const double y2 = fmin(asinh(1.0 / (t1 * v->alpha)), outer_end);
    double sin_h, cos_h;

    sum[0] = sum[1] = 0.0;
    for (int i = 0; i < INNER_RADII; i++) {
        const double w = y1 * b->inner.weight[i] / ANGLES *
                         radius(v->alpha, y1 * b->inner.at[i], &sin_h, &cos_h);
        for (int k = 0; k < ANGLES; k++)
            add(v, sin_h, cos_h, b->ring[k], w, sum);
    }
    for (int i = 0; i < RADII && y2 > y1; i++) {
        const double y = y1 + (y2 - y1) * b->outer.at[i];
        const double du = radius(v->alpha, y, &sin_h, &cos_h);
        const double t = sin_h / cos_h;
        const double c0 = v->cosine * (t * t - 1.0) / (2.0 * v->sine * t);
        const double half = acos(fmax(-1.0, fmin(c0, 1.0)));
        const double w = (y2 - y1) * b->outer.weight[i] * du * half / IBL_PI;
        for (int k = 0; k < ANGLES; k++)
            add(v, sin_h, cos_h, cosine(half * b->arc.at[k]),
                w * b->arc.weight[k], sum);
    }
}

/* ---- interpolation -------------------------------------------------- */

/* Barycentric weights of Chebyshev points of the first kind (Berrut and
 * Trefethen 2004, section 5) for every texel centre of the table's edge. */
static void fill_grid(grid *g, int size, double shift)
{
    const int n = g->points;
    const double from = log(0.5 / size + shift);
    const double half = 0.5 * (log(1.0 - 0.5 / size + shift) - from);

    for (int k = 0; k < n; k++)
        g->at[k] =
            exp(from + half * (1.0 + cos(IBL_PI * (k + 0.5) / n))) - shift;
    for (int i = 0; i < size; i++) {
        const double x = (log((i + 0.5) / size + shift) - from) / half - 1.0;
        double *row = g->basis + (size_t)i * (size_t)n, sum = 0.0;
        for (int k = 0; k < n; k++) {
            const double angle = IBL_PI * (k + 0.5) / n;
            double gap = x - cos(angle);
            /* On a point its weight outgrows the others to the last bit. */
            if (fabs(gap) < 1e-200)
                gap = 1e-200;
            row[k] = (k % 2 ? -sin(angle) : sin(angle)) / gap;
            sum += row[k];
        }
        for (int k = 0; k < n; k++)
            row[k] /= sum;
    }
}

static void node_job(void *arg, int job, int worker)
{
    const struct bake *b = arg;
    double *to = b->nodes + 2 * (size_t)job * (size_t)b->view.points;
    (void)worker;

    for (int k = 0; k < b->view.points; k++, to += 2) {
        const view v = make_view(b, b->view.at[k], b->rough.at[job]);
        integrate(b, &v, to);
    }
}

static void row_job(void *arg, int job, int worker)
{
    const struct bake *b = arg;
    const size_t n = (size_t)b->view.points;
    const double *down = b->rough.basis + (size_t)job * (size_t)b->rough.points;
    double *column = b->columns + (size_t)worker * 2 * n;
    float *out = b->out + 2 * (size_t)job * (size_t)b->size;

    memset(column, 0, 2 * n * sizeof *column);
    for (int j = 0; j < b->rough.points; j++) {
        const double *node = b->nodes + 2 * n * (size_t)j;
        for (size_t k = 0; k < 2 * n; k++)
            column[k] += down[j] * node[k];
    }
    for (int i = 0; i < b->size; i++) {
        const double *across = b->view.basis + (size_t)i * n;
        double sum[4] = {0.0};
        /* Two points at a time: four sums that do not wait for each other. */
        for (size_t k = 0; k < n; k += 2) {
            sum[0] += across[k] * column[2 * k];
            sum[1] += across[k] * column[2 * k + 1];
            sum[2] += across[k + 1] * column[2 * k + 2];
            sum[3] += across[k + 1] * column[2 * k + 3];
        }
        out[2 * i] = (float)fmax(sum[0] + sum[2], 0.0);
        out[2 * i + 1] = (float)fmax(sum[1] + sum[3], 0.0);
    }
}

/* Small tables: every texel is integrated. */
static void direct_job(void *arg, int job, int worker)
{
    const struct bake *b = arg;
    (void)worker;

    for (int i = 0; i < b->size; i++) {
        const view v = make_view(b, (i + 0.5) / b->size, (job + 0.5) / b->size);
        float *out = b->out + 2 * ((size_t)job * (size_t)b->size + (size_t)i);
        double sum[2];
        integrate(b, &v, sum);
        out[0] = (float)sum[0];
        out[1] = (float)sum[1];
    }
}

static bool alloc_grid(grid *g, int points, int size)
{
    g->points = points;
    g->at = ibl_alloc_array((size_t)points, sizeof *g->at);
    g->basis = ibl_alloc_array((size_t)points * (size_t)size, sizeof *g->basis);
    return g->at && g->basis;
}

static ibl_status interpolate(ibl_ctx *ctx, struct bake *b)
{
    const size_t nodes = (size_t)b->view.points * (size_t)b->rough.points;
    ibl_status status;

    b->nodes = ibl_alloc_array(nodes, 2 * sizeof *b->nodes);
    b->columns = ibl_alloc_array((size_t)ibl_ctx_threads(ctx),
                                 2 * sizeof(double) * (size_t)b->view.points);
    if (alloc_grid(&b->view, b->view.points, b->size) &&
        alloc_grid(&b->rough, b->rough.points, b->size) && b->nodes &&
        b->columns) {
        fill_grid(&b->view, b->size, 0.0);
        /* About half the roughness that is as wide as the most grazing view:
         * below it the table is flat. */
        fill_grid(&b->rough, b->size, 0.45 * sqrt(0.5 / b->size));
        status = ibl_run(ctx, NULL, b->rough.points, node_job, b);
        if (!status)
            status = ibl_run(ctx, "lut", b->size, row_job, b);
    } else {
        status = ibl_no_memory(ctx, "the BRDF table");
    }
    ibl_free(b->view.at);
    ibl_free(b->view.basis);
    ibl_free(b->rough.at);
    ibl_free(b->rough.basis);
    ibl_free(b->nodes);
    ibl_free(b->columns);
    return status;
}

static ibl_status quadrature(ibl_ctx *ctx, struct bake *b)
{
    const double octaves = log2(b->size);

    make_rule(INNER_RADII, &b->inner);
    make_rule(RADII, &b->outer);
    make_rule(ANGLES, &b->arc);
    for (int k = 0; k < ANGLES; k++)
        b->ring[k] = cos(IBL_PI * (k + 0.5) / ANGLES);
    b->view.points = 8 + 2 * (int)ceil(1.25 * octaves); /* even */
    b->rough.points = 24 + (int)ceil(2.0 * octaves);
    if (b->size * b->size <= b->view.points * b->rough.points)
        return ibl_run(ctx, "lut", b->size, direct_job, b);
    return interpolate(ctx, b);
}

/* ---- samples -------------------------------------------------------- */

static void sample_job(void *arg, int job, int worker)
{
    const struct bake *b = arg;
    const int row = job / b->chunks, first = job % b->chunks * b->chunk;
    const double n = b->samples;
    (void)worker;

    for (int i = first; i < first + b->chunk && i < b->size; i++) {
        const view v = make_view(b, (i + 0.5) / b->size, (row + 0.5) / b->size);
        float *out = b->out + 2 * ((size_t)row * (size_t)b->size + (size_t)i);
        double sum[2] = {0.0, 0.0};
        for (int k = 0; k < b->samples; k++) {
            double sin_h, cos_h;
            ibl_ggx_sample_half((k + 0.5) / n, v.alpha, &sin_h, &cos_h);
            add(&v, sin_h, cos_h, b->turn[k], 1.0, sum);
        }
        out[0] = (float)(sum[0] / n);
        out[1] = (float)(sum[1] / n);
    }
}

static ibl_status sample(ibl_ctx *ctx, struct bake *b)
{
    ibl_status status;

    b->turn = ibl_alloc_array((size_t)b->samples, sizeof *b->turn);
    if (!b->turn)
        return ibl_no_memory(ctx, "the BRDF table's samples");
    for (int k = 0; k < b->samples; k++)
        b->turn[k] = cos(2.0 * IBL_PI * ibl_radical_inverse((uint32_t)k));
    b->chunk = JOB_EVALUATIONS / b->samples;
    if (b->chunk > b->size)
        b->chunk = b->size;
    b->chunks = (b->size + b->chunk - 1) / b->chunk;
    status = ibl_run(ctx, "lut", b->size * b->chunks, sample_job, b);
    ibl_free(b->turn);
    return status;
}

/* ---- the call ------------------------------------------------------- */

const char *ibl_geometry_name(ibl_geometry geometry)
{
    return geometry == IBL_GEOMETRY_SCHLICK_IBL ? "schlick-ibl" : "smith";
}

ibl_lut_options ibl_lut_options_default(void)
{
    return (ibl_lut_options){.size = 256, .geometry = IBL_GEOMETRY_SMITH};
}

void ibl_lut_free(ibl_lut *lut)
{
    if (!lut)
        return;
    ibl_free(lut->data);
    *lut = (ibl_lut){0};
}

ibl_status ibl_bake_lut(ibl_ctx *ctx, const ibl_lut_options *opts, ibl_lut *out)
{
    const ibl_lut_options defaults = ibl_lut_options_default();
    ibl_status status;

    if (!opts)
        opts = &defaults;
    if (opts->size < 1 || opts->size > MAX_SIZE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a BRDF table of size %d: must be 1 to %d", opts->size,
                        MAX_SIZE);
    if (opts->samples < 0 || opts->samples > MAX_SAMPLES)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a BRDF table of %d samples: must be 0 to %d",
                        opts->samples, MAX_SAMPLES);
    if (opts->geometry != IBL_GEOMETRY_SMITH &&
        opts->geometry != IBL_GEOMETRY_SCHLICK_IBL)
        return ibl_fail(
            ctx, IBL_ERR_ARGUMENT, "unknown BRDF geometry %d: must be %s or %s",
            (int)opts->geometry, ibl_geometry_name(IBL_GEOMETRY_SMITH),
            ibl_geometry_name(IBL_GEOMETRY_SCHLICK_IBL));
    const size_t size = (size_t)opts->size;
    struct bake b = {.geometry = opts->geometry,
                     .size = opts->size,
                     .samples = opts->samples};
    b.out = ibl_alloc_array(size * size, 2 * sizeof *b.out);
    if (!b.out)
        return ibl_no_memory(ctx, "the BRDF table");
    status = b.samples ? sample(ctx, &b) : quadrature(ctx, &b);
    if (status) {
        ibl_free(b.out);
        return status;
    }
    *out = (ibl_lut){opts->size, b.out};
    return IBL_OK;
}
