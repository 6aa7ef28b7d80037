/* SPDX-License-Identifier: MIT */
#include "bake/true_lobe.h"

#include <math.h>

#include "kern/brdf_quadrature.h"

enum {
    LEAST = IBL_TRUE_LOBE_LEAST,
    MOST = IBL_TRUE_LOBE_MOST,
    RADII = IBL_TRUE_LOBE_RADII,
    ANGLES = IBL_TRUE_LOBE_ANGLES
};

/* The tail of the lobe beyond e^-2y has no effect. */
static const double end = 12;

void ibl_true_lobe_rule_init(ibl_true_lobe_rule *rule)
{
    for (int n = LEAST; n <= MOST; n++)
        ibl_gauss_points(n, rule->at[n], rule->weight[n]);
    for (int k = 0; k < ANGLES; k++) {
        rule->cosine[k] = cos(IBL_PI * rule->at[ANGLES][k]);
        rule->sine[k] = sin(IBL_PI * rule->at[ANGLES][k]);
    }
}

/* Adds the point of a half vector; mass is the measure du dphi / pi of
 * brdf/split.h. */
static void add(const ibl_split_view *v, double sin_h, double cos_h,
                double cos_phi, double sin_phi, double mass,
                ibl_true_lobe *lobe)
{
    const double v_dot_h = v->sine * sin_h * cos_phi + v->cosine * cos_h;
    const double n_dot_l = 2 * v_dot_h * cos_h - v->cosine;
    const double visible =
        n_dot_l > 0 ? ibl_smith_visibility(n_dot_l, v->cosine, v->alpha) : 0;
    const double g = mass * visible * n_dot_l * v_dot_h / cos_h;
    const double fresnel = ibl_fresnel_weight(fmin(v_dot_h, 1));
    const int i = lobe->count++;

    lobe->x[i] = (float)(v->sine - 2 * v_dot_h * sin_h * cos_phi);
    lobe->y[i] = (float)(2 * v_dot_h * sin_h * sin_phi);
    lobe->z[i] = (float)n_dot_l;
    lobe->share[0][i] = (float)g;
    lobe->share[1][i] =
        (float)(g * (IBL_DIELECTRIC_F0 + (1 - IBL_DIELECTRIC_F0) * fresnel));
}

/* Adds the half vectors at t = alpha sinh(y), |phi| < arc; length is dy. */
static void add_radius(const ibl_true_lobe_rule *rule, const ibl_split_view *v,
                       double y, double length, double arc, ibl_true_lobe *lobe)
{
    const double e = exp(-2 * y), tanh_y = (1 - e) / (1 + e);
    const double t = v->alpha * sinh(y), cos_h = 1 / sqrt(1 + t * t);
    const double mass = length * arc * 8 * tanh_y * e / ((1 + e) * (1 + e));
    for (int k = 0; k < ANGLES; k++) {
        double c = rule->cosine[k], s = rule->sine[k];
        if (arc < IBL_PI) {
            c = cos(arc * rule->at[ANGLES][k]);
            s = sin(arc * rule->at[ANGLES][k]);
        }
        add(v, t * cos_h, cos_h, c, s, mass * rule->weight[ANGLES][k], lobe);
    }
}

/* Half the arc that is above the horizon. */
static double arc_of(const ibl_split_view *v, double y)
{
    const double t = v->alpha * sinh(y);
    const double c = v->cosine * (t * t - 1) / (2 * v->sine * t);
    return acos(fmax(-1, fmin(c, 1)));
}

static int rings_of(double inner, double outer)
{
    const int n = (int)lround(RADII * inner / (inner + fmax(outer, 0)));
    return n < LEAST ? LEAST : n > MOST ? MOST : n;
}

static void normalise(float *share, int count)
{
    double sum = 0;
    for (int i = 0; i < count; i++)
        sum += (double)share[i];
    for (int i = 0; i < count; i++)
        share[i] /= (float)sum;
}

void ibl_true_lobe_make(const ibl_true_lobe_rule *rule, double n_dot_v,
                        double alpha, ibl_true_lobe *lobe)
{
    const ibl_split_view v =
        ibl_split_view_of(n_dot_v, alpha, IBL_GEOMETRY_SMITH);
    const ibl_brdf_limits y = ibl_brdf_limits_of(&v);
    const double length = fmin(y.outer, end) - y.inner;

    const int rings = rings_of(y.inner, length);

    lobe->count = 0;
    for (int i = 0; i < rings; i++)
        add_radius(rule, &v, y.inner * rule->at[rings][i],
                   y.inner * rule->weight[rings][i], IBL_PI, lobe);
    for (int i = 0; i < RADII - rings && length > 0; i++) {
        const double at = y.inner + length * rule->at[RADII - rings][i];
        add_radius(rule, &v, at, length * rule->weight[RADII - rings][i],
                   arc_of(&v, at), lobe);
    }
    normalise(lobe->share[0], lobe->count);
    normalise(lobe->share[1], lobe->count);
}
