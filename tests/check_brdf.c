/* SPDX-License-Identifier: MIT */
/* BRDFs and their samples against closed forms, differences and truth.c. */
#include <math.h>

#include "brdf/hammersley.h"
#include "brdf/lobe.h"
#include "test.h"
#include "truth.h"

TEST(hammersley)
{
    /* n a power of two: each coordinate hits each of n intervals once. */
    unsigned char seen[256] = {0};

    for (uint32_t i = 0; i < 256; i++) {
        double u1, u2;
        ibl_hammersley(i, 256, &u1, &u2);
        CHECK(u1 == ((double)i + 0.5) / 256);
        CHECK(u2 >= 0.0 && u2 < 1.0);
        seen[(int)(u2 * 256)]++;
    }
    for (int i = 0; i < 256; i++)
        CHECK(seen[i] == 1);
    double u1, u2;
    ibl_hammersley(0, 1, &u1, &u2);
    CHECK(u1 == 0.5 && u2 == 0.0);
}

/* D against the sampled density: the share of half vectors within an angle is
 * the integral of D cos up to it, tan^2 / (tan^2 + alpha^2). The cosine is
 * exact towards the horizon, the sine towards the normal. */
TEST(ggx_sampling)
{
    const double alphas[] = {1e-200, 1e-8, 1e-3, 0.2, 0.7, 1.0};
    double s, c;

    for (size_t k = 0; k < sizeof alphas / sizeof alphas[0]; k++) {
        const double a = alphas[k];
        for (int i = 0; i <= 200; i++) {
            const double u = i / 200.0;
            ibl_ggx_sample_half(u, a, &s, &c);
            CHECK_NEAR(s * s + c * c, 1.0, 1e-15);
            CHECK_NEAR(s * s, u * (s * s + a * a * c * c), 1e-14 * s * s);
        }
        for (double near = 0x1p-40; near < 1 && k; near *= 2) {
            ibl_ggx_sample_half(1 - near, a, &s, &c);
            CHECK_NEAR(c / s * a * sqrt((1 - near) / near), 1, 1e-14);
            ibl_ggx_sample_half(near, a, &s, &c);
            CHECK_NEAR(s / c / a * sqrt((1 - near) / near), 1, 1e-14);
        }
    }
    ibl_ggx_sample_half(0.5, 0.0, &s, &c);
    CHECK(s == 0.0 && c == 1.0);
}

TEST(visibility)
{
    test_random rnd = {2};

    for (int i = 0; i < 1000; i++) {
        double l = 0.001 + 0.999 * test_random_unit(&rnd);
        double v = 0.001 + 0.999 * test_random_unit(&rnd);
        double a = test_random_unit(&rnd);
        CHECK_NEAR(ibl_smith_visibility(l, v, a) * 4 * l * v,
                   truth_shadowing(IBL_GEOMETRY_SMITH, a, l, v), 1e-12);
        CHECK_NEAR(ibl_schlick_visibility(l, v, a) * 4 * l * v,
                   truth_shadowing(IBL_GEOMETRY_SCHLICK_IBL, a, l, v), 1e-12);
    }
    CHECK(isfinite(ibl_smith_visibility(0.0, 1.0, 0.1)));
    CHECK(isfinite(ibl_schlick_visibility(0.0, 0.0, 0.1)));
    CHECK_NEAR(ibl_smith_visibility(0.5, 0.25, 0.0), 2.0, 1e-15);
}

/* Against differences of D. */
TEST(lobe_slopes)
{
    for (int k = 0; k < 27; k++) {
        const ibl_lobe_shape s =
            ibl_lobe_shape_of((ibl_lobe)(k / 9), 0.1 + 0.1 * (k % 9));
        for (double q = 0.05; q < 0.47; q += 0.05) {
            const double h = 1e-5 * (0.5 - q), c = 1 - 2 * q;
            const double more = ibl_lobe_d(&s, q + h, c - 2 * h);
            const double less = ibl_lobe_d(&s, q - h, c + 2 * h);
            const double want = (more - less) / (2 * h) / ibl_lobe_d(&s, q, c);
            CHECK_NEAR(ibl_lobe_slope(&s, q, c), want, 1e-5 * fabs(want));
        }
    }
}

/* The pdf of a draw is what u passes over in solid angle, and D but for a
 * factor; ibl_lobe_peak is its largest. */
TEST(lobe_draws)
{
    static const double alphas[] = {1e-8, 1e-3, 0.1, 0.5, 0.9, 1};

    for (int k = 0; k < 18; k++) {
        const ibl_lobe lobe = (ibl_lobe)(k / 6);
        const ibl_lobe_shape s = ibl_lobe_shape_of(lobe, alphas[k % 6]);
        const double top = ibl_lobe_draw(&s, 1e-9).pdf / ibl_lobe_peak(&s);
        double ratio = 0;
        CHECK_MSG(top >= 0.5 && top <= 2, "%s, alpha %g: peak %g",
                  ibl_lobe_name(lobe), s.alpha, top);
        for (double u = 0.05; u < 1; u += 0.1) {
            const double h = 1e-4;
            const ibl_lobe_sample a = ibl_lobe_draw(&s, u - h);
            const ibl_lobe_sample b = ibl_lobe_draw(&s, u);
            const ibl_lobe_sample c = ibl_lobe_draw(&s, u + h);
            /* dO = 4 pi dq = -2 pi dcos; each has its digits at one end. */
            const double solid =
                lobe == IBL_LOBE_CHARLIE
                    ? 2 * IBL_PI * (c.cosine - a.cosine)
                    : 4 * IBL_PI * (c.sin_h * c.sin_h - a.sin_h * a.sin_h);
            const double d = ibl_lobe_d(&s, b.sin_h * b.sin_h, b.cosine);
            CHECK_NEAR(b.pdf * solid / (2 * h), 1, 1e-4);
            CHECK_NEAR(b.cosine, (b.cos_h - b.sin_h) * (b.cos_h + b.sin_h),
                       1e-15);
            if (ratio > 0)
                CHECK_NEAR(d / b.pdf / ratio, 1, 1e-7);
            ratio = d / b.pdf;
        }
    }
}

/* ---- over a disc light, against sums over the disc -------------------------
 */

#define DEGREE (M_PI / 180)

static const double up[3] = {0, 1, 0};

/* The direction at an angle from z, turned about it. */
static void offset(const double z[3], double angle, double turn, double out[3])
{
    const double flat = hypot(z[0], z[1]), c = cos(turn), s = sin(turn);
    const double x[3] = {z[1] / flat, -z[0] / flat, 0};
    for (int k = 0; k < 3; k++) {
        const double y =
            z[(k + 1) % 3] * x[(k + 2) % 3] - z[(k + 2) % 3] * x[(k + 1) % 3];
        out[k] = cos(angle) * z[k] + sin(angle) * (c * x[k] + s * y);
    }
}

static double surface(double alpha, double f0, const double v[3],
                      const double l[3])
{
    double fc;
    const double f = truth_ggx(IBL_GEOMETRY_SMITH, alpha, up, v, l, &fc);
    return f * (f0 + (1 - f0) * fc);
}

/* The mean over 10,000 points of a disc, on a sunflower's spiral. */
static double mean_of(double alpha, double f0, double radius, const double v[3],
                      const double l[3])
{
    enum {
        POINTS = TEST_SANITIZED ? 4000 : 10000
    };
    double sum = 0, to[3];

    for (int k = 0; k < POINTS; k++) {
        const double away = radius * sqrt((k + 0.5) / POINTS);
        offset(l, away, 2.39996323 * k, to);
        sum += surface(alpha, f0, v, to);
    }
    return sum / POINTS;
}

/* The largest deviation, relative to the largest value. Lights from the mirror
 * direction to beyond the lobe and the disc. */
static double worst(double alpha, double f0, double radius, double n_v)
{
    const double v[3] = {sqrt(1 - n_v * n_v), n_v, 0};
    const double r[3] = {-v[0], n_v, 0};
    double most = 0, far = 0, l[3];

    for (int k = 0; k < 12; k++) {
        const double away = (2 * alpha + radius) * k / 8;
        offset(r, away, 2.4 * k, l);
        const double want = mean_of(alpha, f0, radius, v, l);
        const double got =
            ibl_disc_brdf(IBL_GEOMETRY_SMITH, alpha, f0, radius, up, v, l);
        far = fmax(far, fabs(got - want));
        most = fmax(most, want);
    }
    return far / most;
}

/* Lobes narrower and wider than the disc. Bounds: a linear footprint is wrong
 * by the square of the radius over N.V, and the mean of a product is not the
 * product of means. */
TEST_SLOW(discs_against_sums)
{
    for (int i = 0; i < 12; i++) {
        const double alpha = (const double[]){0.0025, 0.01, 0.09, 0.5}[i % 4];
        const double radius = (const double[]){1e-4, 1, 2.5}[i / 4] * DEGREE;
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
