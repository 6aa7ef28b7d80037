/* SPDX-License-Identifier: MIT */
/*
 * The split-sum integrals and the albedos of sheen at one point.
 *
 * With half vectors H = (tan(theta), phi) and tan(theta) = alpha rho, D N.H dH
 * is 2 rho drho / (1 + rho^2)^2 dphi / 2 pi for every alpha (Walter et al.
 * 2007, eqs. 33 and 35). With s = ln(rho) and dL = 4 V.H dH the integrals are
 *     1/pi integral over phi in 0..pi, s of
 *         G / N.V  V.H / N.H  {1 - Fc, Fc}  2 rho^2 / (1 + rho^2)^2.
 * The integrand changes at tan(theta) = alpha, at tan(theta) = 1 and where L
 * meets the horizon, each time over about 1 in s.
 *
 * L is above the horizon for all phi if theta < pi/4 - theta_V/2, for no phi if
 * theta > pi/4 + theta_V/2, otherwise for phi < phi_m.
 *
 * Those of sheen are
 *     integral over phi in 0..pi, s of
 *         4 V.H V N.L D 2 sin^2(theta) cos(theta)
 * with alpha = 1 in tan(theta). D falls off where 1 / tan(theta) is about
 * roughness.
 *
 * Both integrals use the double exponential rule (Takahasi and Mori 1974),
 * which singularities at the ends do not slow down.
 */

#include <stdbool.h>

#include <math.h>

#include "bake/reference_check.h"
#include "core/context.h"

static const double pi = 3.14159265358979323846;

enum {
    STEPS = 16,                  /* per unit of t */
    POINTS = 1 + 33 * STEPS / 10 /* up to t = 3.3 */
};

/* Limits of s. Beyond them rho^2 and 1 / rho are negligible: the integrand is
 * below 8 rho^2 (1 + rho) and below 8 (1 + rho) / rho^2. */
static const double lowest = -16, highest = 32;

struct pair {
    double v[2];
};

/* The arguments are the distances from both ends of the interval: near an end
 * the coordinate itself loses its digits. */
typedef struct pair integrand(void *arg, double from_begin, double from_end);

/* Points of the rule on an interval of length 1, in its upper half, at
 * t = k / STEPS: x = tanh(pi/2 sinh(t)) has 1 - |x| = 2 / (1 + exp(pi sinh|t|))
 * and dx/dt = pi/2 cosh(t) / cosh^2(pi/2 sinh(t)). */
struct rule {
    double close[POINTS]; /* distance from the end */
    double weight[POINTS];
};

static void fill_rule(struct rule *r)
{
    for (int k = 0; k < POINTS; k++) {
        const double t = (double)k / STEPS, e = exp(pi * sinh(t));
        r->close[k] = 1 / (1 + e);
        r->weight[k] = pi * cosh(t) * e / ((1 + e) * (1 + e)) / STEPS;
    }
}

static struct pair integrate(integrand *f, void *arg, const struct rule *r,
                             double length)
{
    struct pair sum = {{0, 0}};

    for (int k = 0; k < POINTS; k++) {
        const double close = length * r->close[k], far = length - close;
        const struct pair a = f(arg, far, close);
        const struct pair b = k ? f(arg, close, far) : (struct pair){{0, 0}};
        for (int c = 0; c < 2; c++)
            sum.v[c] += length * r->weight[k] * (a.v[c] + b.v[c]);
    }
    return sum;
}

/* ---- over phi --------------------------------------------------------- */

struct point {
    const struct rule *rule;
    ibl_geometry geometry;
    double alpha, nv, sv;
    double sheen;        /* alpha of Charlie's D; 0: GGX. alpha is 1 then */
    double lambda_v;     /* of Charlie's V */
    double theta_low;    /* pi/4 - theta_V/2 */
    double from, length; /* the interval of s */
    /* set by at_s */
    double w;      /* tan(theta) */
    double nh;     /* cos(theta) */
    double across; /* sin(theta_V) sin(2 theta) */
    double nl_pi;  /* N.L at phi = pi; below 0: L is under the horizon */
    bool whole;    /* L is above the horizon for all phi */
    double phi_m;
};

static double g_over_nv(const struct point *p, double nl)
{
    const double a2 = p->alpha * p->alpha, k = 0.5 * p->alpha;

    if (p->geometry == IBL_GEOMETRY_SCHLICK_IBL)
        return nl / ((nl + k * (1 - nl)) * (p->nv + k * (1 - p->nv)));
    /* Heitz 2014, eq. 99. */
    const double of_v = sqrt(a2 + (1 - a2) * p->nv * p->nv);
    const double of_l = sqrt(a2 + (1 - a2) * nl * nl);
    return 2 * nl / (nl * of_v + p->nv * of_l);
}

/* Estevez and Kulla 2017, equation 3 and table 1. */
static double lambda_of(double x, double alpha)
{
    static const double fit[2][5] = {
        {25.3245, 3.32435, 0.16801, -1.27393, -4.85967},
        {21.5473, 3.82987, 0.19823, -1.97760, -4.32054}};
    const double rough = 1 - (1 - alpha) * (1 - alpha);
    double k[5], l[2];

    for (int i = 0; i < 5; i++)
        k[i] = (1 - rough) * fit[0][i] + rough * fit[1][i];
    for (int i = 0; i < 2; i++) {
        const double at = i ? 0.5 : fmin(x, 1 - x);
        l[i] = k[0] / (1 + k[1] * pow(at, k[2])) + k[3] * at + k[4];
    }
    return exp(x < 0.5 ? l[0] : 2 * l[1] - l[0]);
}

static struct pair sheen_at_phi(const struct point *p, double nl, double vh)
{
    const double lambda_l = lambda_of(fmin(nl, 1), p->sheen);

    return (struct pair){{vh * nl / (nl + p->nv - nl * p->nv),
                          vh / (p->nv * (1 + p->lambda_v + lambda_l))}};
}

static struct pair at_phi(void *arg, double phi, double left)
{
    const struct point *p = arg;
    const double half = sin(0.5 * left);
    const double nl = p->whole
                          ? p->nl_pi + 2 * p->across * half * half
                          : 2 * p->across * half * sin(0.5 * (p->phi_m + phi));
    struct pair y = {{0, 0}};

    if (!(nl > 0))
        return y;
    const double vh_nh = p->nv + p->sv * p->w * cos(phi);
    const double vh = fmin(vh_nh * p->nh, 1);
    if (p->sheen > 0)
        return sheen_at_phi(p, nl, vh);
    const double miss = 1 - fmax(vh, 0),
                 fc = miss * miss * (miss * miss) * miss;
    const double f = g_over_nv(p, nl) * fmax(vh_nh, 0);
    y.v[0] = f * (1 - fc);
    y.v[1] = f * fc;
    return y;
}

/* ---- over s ----------------------------------------------------------- */

static struct pair at_s(void *arg, double from_begin, double from_end)
{
    struct point *p = arg;
    const double s = from_begin < from_end ? p->from + from_begin
                                           : p->from + p->length - from_end;
    const double rho = exp(s), w = p->alpha * rho, theta = atan(w);
    const double below = sin(2 * (p->theta_low - theta));
    /* nv cos(2 theta) + sv sin(2 theta); both terms are >= 0 for w < 1. */
    const double above =
        w < 1 ? (p->nv * (1 - w * w) + p->sv * 2 * w) / (1 + w * w)
              : sin(2 * (atan(1 / w) - p->theta_low));
    const double density = rho / (1 + rho * rho);
    double weight = 2 * density * density / pi;

    if (p->sheen > 0) /* sin^2 = 1 / (1 + 1 / w^2) */
        weight = (2 + 1 / p->sheen) / pi *
                 exp(-(1 + 0.5 / p->sheen) * log1p(1 / (w * w))) /
                 sqrt(1 + w * w);
    p->w = w;
    p->nh = 1 / sqrt(1 + w * w);
    p->across = p->sv * 2 * (w * p->nh) * p->nh;
    p->nl_pi = below;
    p->whole = below >= 0;
    if (!p->whole && above <= 0)
        return (struct pair){{0, 0}};
    /* cos(phi_m) = -nv cos(2 theta) / across, from its half angle. */
    p->phi_m = p->whole ? pi : 2 * atan2(sqrt(above), sqrt(-below));
    struct pair y = integrate(at_phi, p, p->rule, p->phi_m);
    for (int c = 0; c < 2; c++)
        y.v[c] *= weight;
    return y;
}

static void insert(double *at, int count, double x)
{
    for (; count && at[count - 1] > x; count--)
        at[count] = at[count - 1];
    at[count] = x;
}

static struct pair integrate_point(struct point *p)
{
    const double low = p->nv / (1 + p->sv), high = (1 + p->sv) / p->nv;
    const double peak = p->sheen > 0 ? -0.5 * log(p->sheen) : -log(p->alpha);
    const double knot[] = {lowest, 0, peak, log(low / p->alpha),
                           log(high / p->alpha)};
    const int knots = (int)(sizeof knot / sizeof *knot);
    double at[sizeof knot / sizeof *knot];
    struct pair total = {{0, 0}};

    p->theta_low = atan(low);
    for (int k = 0; k < knots; k++)
        insert(at, k, fmin(fmax(knot[k], lowest), highest));
    for (int k = 0; k + 1 < knots; k++) {
        p->from = at[k];
        p->length = at[k + 1] - at[k];
        const struct pair part = integrate(at_s, p, p->rule, p->length);
        total.v[0] += part.v[0];
        total.v[1] += part.v[1];
    }
    return total;
}

ibl_status ibl_reference_check_geometry(ibl_ctx *ctx, ibl_geometry geometry)
{
    if (geometry == IBL_GEOMETRY_SMITH || geometry == IBL_GEOMETRY_SCHLICK_IBL)
        return IBL_OK;
    return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                    "geometry %d: must be smith (%d) or schlick-ibl (%d)",
                    (int)geometry, IBL_GEOMETRY_SMITH,
                    IBL_GEOMETRY_SCHLICK_IBL);
}

static ibl_status check(ibl_ctx *ctx, double n_dot_v, double roughness,
                        ibl_geometry geometry)
{
    if (!(n_dot_v >= 0 && n_dot_v <= 1))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "an N.V of %g: must be 0 to 1",
                        n_dot_v);
    if (!(roughness >= 0 && roughness <= 1))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a roughness of %g: must be 0 to 1", roughness);
    const ibl_status status = ibl_reference_check_geometry(ctx, geometry);
    return !status && ibl_cancelled(ctx) ? IBL_ERR_CANCELLED : status;
}

ibl_status ibl_reference_lut(ibl_ctx *ctx, double n_dot_v, double roughness,
                             ibl_geometry geometry, double scale_bias[2])
{
    if (!ctx || !scale_bias)
        return ibl_missing(ctx, "ibl_reference_lut: scale_bias");
    const ibl_status status = check(ctx, n_dot_v, roughness, geometry);
    if (status)
        return status;
    if (roughness == 0) {
        scale_bias[1] = pow(1 - n_dot_v, 5);
        scale_bias[0] = 1 - scale_bias[1];
        return IBL_OK;
    }
    struct rule rule;
    /* At this size the results no longer depend on alpha. */
    struct point p = {.rule = &rule,
                      .geometry = geometry,
                      .alpha = fmax(roughness * roughness, 1e-100),
                      .nv = n_dot_v,
                      .sv = sqrt((1 - n_dot_v) * (1 + n_dot_v))};
    fill_rule(&rule);
    const struct pair total = integrate_point(&p);
    scale_bias[0] = total.v[0];
    scale_bias[1] = total.v[1];
    return IBL_OK;
}

ibl_status ibl_reference_sheen(ibl_ctx *ctx, double n_dot_v, double roughness,
                               double albedo[2])
{
    if (!ctx || !albedo)
        return ibl_missing(ctx, "ibl_reference_sheen: albedo");
    const ibl_status status =
        check(ctx, n_dot_v, roughness, IBL_GEOMETRY_SMITH);
    if (status)
        return status;
    if (!(n_dot_v > 0 && roughness > 0))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an N.V of %g and a roughness of %g: sheen needs "
                        "more than 0",
                        n_dot_v, roughness);
    struct rule rule;
    struct point p = {.rule = &rule,
                      .alpha = 1,
                      .sheen = fmax(roughness * roughness, 1e-100),
                      .nv = n_dot_v,
                      .sv = sqrt((1 - n_dot_v) * (1 + n_dot_v))};
    p.lambda_v = lambda_of(n_dot_v, p.sheen);
    fill_rule(&rule);
    const struct pair total = integrate_point(&p);
    albedo[0] = total.v[0];
    albedo[1] = total.v[1];
    return IBL_OK;
}
