/* SPDX-License-Identifier: MIT */
/* The reference's BRDF table against closed forms and sums written out here. */
#include <math.h>

#include "ibl/reference.h"
#include "test.h"

static void lut(ibl_ctx *ctx, double nv, double r, ibl_geometry g,
                double out[2])
{
    out[0] = out[1] = NAN;
    CHECK(!ibl_reference_lut(ctx, nv, r, g, out));
}

TEST(lut_mirror)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);

    for (int g = 0; g < 2; g++) {
        for (int k = 0; k <= 10; k++) {
            const double nv = 0.1 * k, fc = pow(1 - nv, 5);
            double out[2];
            lut(ctx, nv, 0, (ibl_geometry)g, out);
            CHECK_NEAR(out[0], 1 - fc, 1e-15);
            CHECK_NEAR(out[1], fc, 1e-15);
            if (!k)
                continue;
            lut(ctx, nv, 1e-5, (ibl_geometry)g, out);
            CHECK_NEAR(out[0], 1 - fc, 1e-8);
            CHECK_NEAR(out[1], fc, 1e-8);
        }
        double out[2];
        lut(ctx, 0, 1e-6, IBL_GEOMETRY_SMITH, out);
        CHECK_NEAR(out[0], 0, 1e-9);
        CHECK_NEAR(out[1], 1, 1e-9);
    }
}

/*
 * N.V = 1: V.H = N.H = c with N.L = 2 c^2 - 1 and dL = 4 c dH, so that both
 * integrals are ones over c alone, taken here by many midpoints in long
 * double. At alpha = 1 Smith's G / (N.L N.V) is 2 / (N.L + 1) = 1 / c^2, and
 * R + G is the integral from sqrt(1/2) to 1 of 4c - 2/c, 1 - ln 2.
 */
TEST(lut_straight)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    double out[2];

    lut(ctx, 1, 1, IBL_GEOMETRY_SMITH, out);
    CHECK_NEAR(out[0] + out[1], 1 - log(2.0), 1e-9);
    for (int k = 0; k < 8; k++) {
        const int g = k % 2;
        const long double r = 1 - 0.25L * (k / 2), a2 = r * r * r * r;
        const long double half = r * r / 2, from = sqrtl(0.5L);
        long double sum[2] = {0};
        const int steps = 40000;
        for (int n = 0; n < steps; n++) {
            /* Dense at c = 1. */
            const long double x = (n + 0.5L) / steps;
            const long double c = 1 - (1 - from) * x * x * x;
            const long double nl = 2 * c * c - 1;
            const long double t = c * c * (a2 - 1) + 1, m = 1 - c;
            const long double fc = m * m * m * m * m;
            const long double vis =
                g ? 1 / (4 * (nl * (1 - half) + half))
                  : 0.5L / (sqrtl(nl * nl * (1 - a2) + a2) + nl);
            const long double f = a2 / (t * t) * vis * nl * 4 * c * 2 *
                                  (1 - from) * 3 * x * x / steps;
            sum[0] += f * (1 - fc);
            sum[1] += f * fc;
        }
        lut(ctx, 1, (double)r, (ibl_geometry)g, out);
        CHECK_NEAR(out[0], (double)sum[0], 1e-9);
        CHECK_NEAR(out[1], (double)sum[1], 1e-9);
    }
}

/* alpha = 1: D = 1/pi, Smith's vis 1 / (2 (N.L + N.V)), so
 *     R + G = integral of 2 x / (2 (x + nv)) dx = 1 - nv ln((1 + nv) / nv),
 * and Schlick's, k = 1/2, 1 / ((x + 1) (nv + 1)):
 *     integral of 2 x / ((x + 1) (nv + 1)) dx = 2 (1 - ln 2) / (nv + 1). */
TEST(lut_rough)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);

    for (int k = 0; k <= 12; k++) {
        const double nv = k < 8 ? k / 8.0 : pow(10, 4 - k);
        double out[2];
        lut(ctx, nv, 1, IBL_GEOMETRY_SMITH, out);
        CHECK_NEAR(out[0] + out[1], nv > 0 ? 1 - nv * log((1 + nv) / nv) : 1,
                   1e-9);
        lut(ctx, nv, 1, IBL_GEOMETRY_SCHLICK_IBL, out);
        CHECK_NEAR(out[0] + out[1], 2 * (1 - log(2.0)) / (nv + 1), 1e-9);
    }
}

/* G2 of both geometry terms, Smith by its Lambda (Heitz 2014, eq. 72, 99). */
static long double shadowing(ibl_geometry g, long double a, long double nv,
                             long double nl)
{
    if (g == IBL_GEOMETRY_SMITH) {
        const long double tv = (1 - nv * nv) / (nv * nv),
                          tl = (1 - nl * nl) / (nl * nl);
        return 2 / (sqrtl(1 + a * a * tv) + sqrtl(1 + a * a * tl));
    }
    const long double k = a / 2;
    return nv / (nv * (1 - k) + k) * nl / (nl * (1 - k) + k);
}

/*
 * Over the slopes (a x, a y) of the microfacets, D N.H dH = dx dy /
 * (pi (1 + x^2 + y^2)^2), x = sinh(s), y = sinh(t) on a grid that reaches the
 * largest slope that reflects upwards, (1 + sin(theta_V)) / N.V; for narrow
 * lobes and grazing views. Both geometry terms at once.
 */
static void lut_over_slopes(double nv, double r, double out[2][2])
{
    enum {
        N = 1000
    };
    const double a = r * r, sv = sqrt(1 - nv * nv);
    const double edge = asinh((1 + sv) / (nv * a)), step = edge / N;
    double sum[2][2] = {{0}};
    for (int i = -N; i < N; i++) {
        const double x = sinh((i + 0.5) * step);
        for (int j = 0; j < N; j++) {
            const double y = sinh((j + 0.5) * step);
            const double q = 1 + x * x + y * y, s2 = 1 + a * a * (q - 1);
            const double nh = 1 / sqrt(s2), vh = (a * x * sv + nv) * nh;
            const double nl = 2 * vh * nh - nv;
            if (nl <= 0)
                continue;
            const double f = 2 * step * step * sqrt((1 + x * x) * (1 + y * y)) /
                             (M_PI * q * q) * vh / (nv * nh);
            const double fc = pow(1 - vh, 5);
            for (int g = 0; g < 2; g++) {
                const double fg =
                    f * (double)shadowing((ibl_geometry)g, a, nv, nl);
                sum[g][0] += fg * (1 - fc);
                sum[g][1] += fg * fc;
            }
        }
    }
    for (int g = 0; g < 4; g++)
        out[g / 2][g % 2] = (double)sum[g / 2][g % 2];
}

TEST_SLOW(lut_slopes)
{
    static const double points[][2] = {{1e-3, 1.0 / 512},
                                       {1.0 / 512, 1.0 / 512},
                                       {1e-3, 0.02},
                                       {1.0 / 512, 0.1},
                                       {511.0 / 512, 1.0 / 512},
                                       {0.03, 0.15},
                                       {0.25, 0.3},
                                       {0.5, 0.7}};
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    for (int n = 0; n < 8; n++) {
        double grid[2][2];
        lut_over_slopes(points[n][0], points[n][1], grid);
        for (int g = 0; g < 2; g++) {
            double fast[2];
            lut(ctx, points[n][0], points[n][1], (ibl_geometry)g, fast);
            CHECK_NEAR(fast[0], grid[g][0], 2e-5);
            CHECK_NEAR(fast[1], grid[g][1], 2e-5);
        }
    }
}
