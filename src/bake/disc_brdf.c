/* SPDX-License-Identifier: MIT */
/*
 * GGX's slopes have the density alpha^2 / (pi (x^2 + alpha^2)^2), which is the
 * form factor of the plane of slopes seen from a height alpha above it. A disc
 * light is an ellipse there, and the lobe's share in it is the form factor of
 * an ellipse. With the cone of the ellipse as a quadratic form of eigenvalues
 * e1, e2 > 0 > e3, that is |e3| / sqrt((e1 - e3) (e2 - e3)) along the cone's
 * axis (Heitz and Hill 2017, "Linear-Light Shading with Linearly Transformed
 * Cosines"), times the cosine of the axis. Written by the characteristic
 * polynomial and with nu = -1 / e3, both need only the root nu of a cubic.
 */
#include <math.h>

#include "brdf/ggx.h"
#include "core/vector.h"
#include "ibl/ibl.h"

/* a + b, normalised. */
static void add_unit(const double a[3], const double b[3], double h[3])
{
    for (int c = 0; c < 3; c++)
        h[c] = a[c] + b[c];
    const double length = fmax(sqrt(dot3(h, h)), 1e-9);
    for (int c = 0; c < 3; c++)
        h[c] /= length;
}

/* A view and a light over a surface, and the half vector. */
typedef struct angles {
    double n_l, n_v, n_h, v_h;
} angles;

static angles angles_of(const double n[3], const double v[3], const double l[3])
{
    double h[3];

    add_unit(v, l, h);
    return (angles){dot3(n, l), fmax(dot3(n, v), 1e-4), fmax(dot3(n, h), 0.05),
                    fmax(dot3(v, h), 1e-3)};
}

/* The positive root of nu^3 = m nu^2 + n nu + k, k >= 0, at most `most`. */
static double cubic_root(double m, double n, double k, double most)
{
    const double p = fmax((m * m + 3 * n) / 9, 0), s = sqrt(p);
    const double c = (2 * m * m * m + 9 * m * n + 27 * k) / (54 * p * s);
    double nu = m / 3 + 2 * s * cos(acos(fmin(fmax(c, -1), 1)) / 3);

    nu = fmin(fmax(nu, 1), most);
    for (int i = 0; i < 2; i++)
        nu -= (((nu - m) * nu - n) * nu - k) / ((3 * nu - 2 * m) * nu - n);
    return fmin(fmax(nu, 1), most);
}

/* Square of the shorter half axis of a disc in slopes, over alpha^2; the other
 * is longer by 1 / V.H. */
static double short_axis2(double alpha, double radius, const angles *s)
{
    return radius * radius / (4 * pow(s->n_h, 3) * alpha * alpha);
}

/* GGX's D, averaged over a disc. */
static double disc_d(double alpha, double radius, const angles *s)
{
    const double a2 = alpha * alpha, h2 = s->n_h * s->n_h;
    const double t2 = fmax(1 - h2, 0) / (h2 * a2);
    const double along = s->n_l - s->n_v;
    const double x2 = fmin(
        along * along / (4 * fmax(1 - s->v_h * s->v_h, 1e-6) * h2 * a2), t2);
    const double a = short_axis2(alpha, radius, s);
    const double b = a / (s->v_h * s->v_h), k = a * b;
    const double m = 1 + t2 - a - b, n = a + b + b * x2 + a * (t2 - x2) - k;
    const double nu = cubic_root(m, n, k, 1 + t2);

    return sqrt((nu + a) * (nu + b)) / ((nu * nu + n) * nu + 2 * k) /
           (IBL_PI * a2 * h2 * h2);
}

/* N.L of a disc of which a part may be below the horizon. */
static double clipped(double n_l, double radius)
{
    const double edge = sin(radius);

    if (fabs(n_l) >= edge)
        return fmax(n_l, 0);
    return (n_l + edge) * (n_l + edge) / (4 * edge);
}

double ibl_disc_brdf(ibl_geometry geometry, double alpha, double f0,
                     double radius, const double normal[3],
                     const double view[3], const double light[3])
{
    const double width = fmax(alpha, 1e-4);
    const angles middle = angles_of(normal, view, light);
    const double a = short_axis2(width, radius, &middle), share = a / (1 + a);
    double mirror[3], to[3];

    /* From the middle towards the mirror direction, as far as the disc goes and
     * as far as the lobe is narrower than the disc. */
    for (int c = 0; c < 3; c++)
        mirror[c] = 2 * dot3(normal, view) * normal[c] - view[c] - light[c];
    const double step =
        share * fmin(1, radius / fmax(sqrt(dot3(mirror, mirror)), 1e-9));
    for (int c = 0; c < 3; c++)
        mirror[c] *= step;
    add_unit(light, mirror, to);
    const angles at = angles_of(normal, view, to);
    const double n_l = clipped(at.n_l, radius * (1 - share));
    if (n_l <= 0)
        return 0;
    const double fresnel = f0 + (1 - f0) * ibl_fresnel_weight(at.v_h);
    const double visibility = geometry == IBL_GEOMETRY_SCHLICK_IBL
                                  ? ibl_schlick_visibility(n_l, at.n_v, width)
                                  : ibl_smith_visibility(n_l, at.n_v, width);
    return disc_d(width, radius, &middle) * (at.v_h / at.n_h) /
           (middle.v_h / middle.n_h) * fresnel * visibility * n_l;
}
