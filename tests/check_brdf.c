/* SPDX-License-Identifier: MIT */
#include "brdf/hammersley.h"
#include "brdf/lobe.h"
#include "test.h"

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
 * the integral of D cos up to it, tan^2 / (tan^2 + alpha^2). */
TEST(ggx_sampling)
{
    const double alphas[] = {1e-8, 1e-3, 0.1, 0.7, 1.0};

    for (size_t k = 0; k < sizeof alphas / sizeof alphas[0]; k++) {
        double a = alphas[k], last = -1.0;
        for (int i = 0; i <= 1000; i++) {
            double u = i / 1000.0, s, c;
            ibl_ggx_sample_half(u, a, &s, &c);
            CHECK_NEAR(s * s + c * c, 1.0, 1e-15);
            CHECK(s > last);
            last = s;
            CHECK_NEAR(s * s / (s * s + a * a * c * c), u, 1e-14);
        }
    }
}

TEST(ggx_sampling_limits)
{
    for (int i = 0; i <= 4; i++) {
        double s, c;
        ibl_ggx_sample_half(i / 4.0, 0.0, &s, &c);
        CHECK(s == 0.0 && c == 1.0);
        ibl_ggx_sample_half(i / 4.0, 1e-200, &s, &c);
        CHECK(isfinite(s) && isfinite(c));
    }
    double s, c;
    ibl_ggx_sample_half(1.0, 0.2, &s, &c);
    CHECK(s == 1.0 && c == 0.0);
    ibl_ggx_sample_half(0.0, 0.2, &s, &c);
    CHECK(s == 0.0 && c == 1.0);
    /* The cosine is exact towards the horizon, the sine towards the normal. */
    for (double near = 0x1p-40; near < 1; near *= 2) {
        ibl_ggx_sample_half(1 - near, 0.2, &s, &c);
        CHECK_NEAR(c / s * 0.2 * sqrt((1 - near) / near), 1, 1e-14);
        ibl_ggx_sample_half(near, 0.2, &s, &c);
        CHECK_NEAR(s / c / 0.2 * sqrt((1 - near) / near), 1, 1e-14);
    }
}

static double lambda(double c, double alpha)
{
    double t2 = 1.0 / (c * c) - 1.0;

    return 0.5 * (sqrt(1.0 + alpha * alpha * t2) - 1.0);
}

TEST(visibility)
{
    test_random rnd = {2};

    for (int i = 0; i < 1000; i++) {
        double l = 0.001 + 0.999 * test_random_unit(&rnd);
        double v = 0.001 + 0.999 * test_random_unit(&rnd);
        double a = test_random_unit(&rnd), k = a / 2;
        double g = 1.0 / (1.0 + lambda(l, a) + lambda(v, a));
        double smith = ibl_smith_visibility(l, v, a);
        CHECK_NEAR(smith * 4 * l * v, g, 1e-12);
        CHECK(smith == ibl_smith_visibility(v, l, a));
        g = l / (l * (1 - k) + k) * (v / (v * (1 - k) + k));
        CHECK_NEAR(ibl_schlick_visibility(l, v, a) * 4 * l * v, g, 1e-12);
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
