/* SPDX-License-Identifier: MIT */
/* The BRDF over a disc light, against sums over the disc. */
#include <math.h>

#include "test.h"

#define DEGREE (M_PI / 180)

static void unit(double v[3])
{
    const double length = sqrt(test_dot(v, v));
    for (int c = 0; c < 3; c++)
        v[c] /= length;
}

static void frame(const double z[3], double x[3], double y[3])
{
    const double up[3] = {fabs(z[0]) < 0.5, fabs(z[0]) >= 0.5, 0};
    for (int c = 0; c < 3; c++)
        x[c] = up[c] - test_dot(up, z) * z[c];
    unit(x);
    for (int c = 0; c < 3; c++)
        y[c] =
            z[(c + 1) % 3] * x[(c + 2) % 3] - z[(c + 2) % 3] * x[(c + 1) % 3];
}

/* The direction (x, y) from z, both in radians. */
static void offset(const double z[3], double x, double y, double out[3])
{
    double ex[3], ey[3];
    const double angle = hypot(x, y), s = angle > 0 ? sin(angle) / angle : 1;

    frame(z, ex, ey);
    for (int c = 0; c < 3; c++)
        out[c] = cos(angle) * z[c] + s * (x * ex[c] + y * ey[c]);
}

/* Heitz 2014, with N = +Y; nothing is shared with what is tested. */
static double brdf(double alpha, double f0, const double v[3],
                   const double l[3])
{
    const double a2 = alpha * alpha;
    double h[3] = {v[0] + l[0], v[1] + l[1], v[2] + l[2]};

    unit(h);
    if (l[1] <= 0)
        return 0;
    const double d = a2 / (M_PI * pow(h[1] * h[1] * (a2 - 1) + 1, 2));
    const double tan_v = (1 - v[1] * v[1]) / (v[1] * v[1]);
    const double tan_l = (1 - l[1] * l[1]) / (l[1] * l[1]);
    const double lambda = (sqrt(1 + a2 * tan_v) + sqrt(1 + a2 * tan_l)) / 2 - 1;
    const double f = f0 + (1 - f0) * pow(1 - test_dot(v, h), 5);
    return d * f / (1 + lambda) / (4 * v[1]);
}

/* The mean over 40,000 points of a disc, on a sunflower's spiral. */
static double truth(double alpha, double f0, double radius, const double v[3],
                    const double l[3])
{
    enum {
        POINTS = TEST_SANITIZED ? 4000 : 40000
    };
    double sum = 0, to[3];

    for (int k = 0; k < POINTS; k++) {
        const double away = radius * sqrt((k + 0.5) / POINTS);
        offset(l, away * cos(2.39996323 * k), away * sin(2.39996323 * k), to);
        sum += brdf(alpha, f0, v, to);
    }
    return sum / POINTS;
}

/* The largest deviation, relative to the largest value. Lights from the mirror
 * direction to beyond the lobe and the disc. */
static double worst(double alpha, double f0, double radius, double n_v)
{
    static const double n[3] = {0, 1, 0};
    const double v[3] = {sqrt(1 - n_v * n_v), n_v, 0};
    const double r[3] = {-v[0], n_v, 0};
    double most = 0, far = 0, l[3];

    for (int k = 0; k < 12; k++) {
        const double away = (2 * alpha + radius) * k / 8;
        offset(r, away * cos(2.4 * k), away * sin(2.4 * k), l);
        const double want = truth(alpha, f0, radius, v, l);
        const double got =
            ibl_disc_brdf(IBL_GEOMETRY_SMITH, alpha, f0, radius, n, v, l);
        far = fmax(far, fabs(got - want));
        most = fmax(most, want);
    }
    return far / most;
}

/* Lobes narrower and wider than the disc. Bounds: a linear footprint is wrong
 * by the square of the radius over N.V, and the mean of a product is not the
 * product of means. */
TEST_SLOW(against_sums)
{
    for (int i = 0; i < 12; i++) {
        const double alpha = (const double[]){0.0025, 0.01, 0.09, 0.5}[i % 4];
        const double radius = (const double[]){0.25, 1, 2.5}[i / 4] * DEGREE;
        for (int k = 0; k < 3; k++) {
            const double n_v = (const double[]){0.2, 0.5, 0.9}[k];
            const double off = worst(alpha, k == 1 ? 0.04 : 1, radius, n_v);
            CHECK_MSG(off < 0.004 + 0.35 * radius / n_v,
                      "alpha %g, radius %g, N.V %g: %g", alpha, radius / DEGREE,
                      n_v, off);
            test_measured("share of the bound", off,
                          0.004 + 0.35 * radius / n_v);
        }
    }
}

/* A disc of no size is a point. */
TEST(point)
{
    static const double n[3] = {0, 1, 0};
    test_random r = {4};

    for (int k = 0; k < 200; k++) {
        double v[3], l[3];
        for (int c = 0; c < 3; c++) {
            v[c] = test_random_between(&r, -1, 1);
            l[c] = test_random_between(&r, -1, 1);
        }
        v[1] = fabs(v[1]) + 0.1;
        l[1] = fabs(l[1]) + 0.1;
        unit(v);
        unit(l);
        const double alpha = test_random_between(&r, 0.01, 1);
        const double want = brdf(alpha, 0.04, v, l);
        CHECK_NEAR(ibl_disc_brdf(IBL_GEOMETRY_SMITH, alpha, 0.04, 0, n, v, l),
                   want, 1e-6 * want);
    }
}

/* Smooth where its parts change: at the horizon, which hides a disc little by
 * little, and towards a view along the light. */
TEST(continuous)
{
    static const double n[3] = {0, 1, 0}, v[3] = {0.6, 0.8, 0};
    double before = -1;

    for (int k = 0; k <= 4000; k++) {
        const double angle = -0.2 + (M_PI / 2 + 0.4) * k / 4000;
        const double l[3] = {cos(angle), sin(angle), 0};
        const double f =
            ibl_disc_brdf(IBL_GEOMETRY_SMITH, 0.3, 1, 2 * DEGREE, n, v, l);
        CHECK(isfinite(f));
        if (fabs(angle + 2 * DEGREE) > 0.1 * DEGREE)
            CHECK(angle > -2 * DEGREE ? f > 0 : f >= 0 && f <= 0);
        CHECK(before < 0 || fabs(f - before) < 2e-3);
        before = f;
    }
}
