/* SPDX-License-Identifier: MIT */
#include "bake/true_lobe.h"

#include <math.h>

#include "kern/brdf_quadrature.h"

enum {
    RADII = IBL_TRUE_LOBE_RADII,
    ANGLES = IBL_TRUE_LOBE_ANGLES
};

static const double dielectric = 0.04; /* F0 */
/* The tail of the lobe beyond e^-2y has no effect. */
static const double end = 12;

void ibl_true_lobe_rule_init(ibl_true_lobe_rule *rule)
{
    ibl_gauss_points(RADII, rule->at, rule->weight);
    ibl_gauss_points(ANGLES, rule->arc, rule->arc_weight);
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
    lobe->share[1][i] = (float)(g * (dielectric + (1 - dielectric) * fresnel));
}

/* Adds the half vectors at t = alpha sinh(y), |phi| < arc; length is dy. */
static void add_radius(const ibl_true_lobe_rule *rule, const ibl_split_view *v,
                       double y, double length, double arc, ibl_true_lobe *lobe)
{
    const double e = exp(-2 * y), tanh_y = (1 - e) / (1 + e);
    const double t = v->alpha * sinh(y), cos_h = 1 / sqrt(1 + t * t);
    const double mass = length * arc * 8 * tanh_y * e / ((1 + e) * (1 + e));
    for (int k = 0; k < ANGLES; k++) {
        const double phi = arc * rule->arc[k];
        add(v, t * cos_h, cos_h, cos(phi), sin(phi), mass * rule->arc_weight[k],
            lobe);
    }
}

/* Half the arc that is above the horizon. */
static double arc_of(const ibl_split_view *v, double y)
{
    const double t = v->alpha * sinh(y);
    const double c = v->cosine * (t * t - 1) / (2 * v->sine * t);
    return acos(fmax(-1, fmin(c, 1)));
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

    lobe->count = 0;
    for (int i = 0; i < RADII; i++)
        add_radius(rule, &v, y.inner * rule->at[i], y.inner * rule->weight[i],
                   IBL_PI, lobe);
    for (int i = 0; i < RADII && length > 0; i++) {
        const double at = y.inner + length * rule->at[i];
        add_radius(rule, &v, at, length * rule->weight[i], arc_of(&v, at),
                   lobe);
    }
    normalise(lobe->share[0], lobe->count);
    normalise(lobe->share[1], lobe->count);
}
