/* SPDX-License-Identifier: MIT */
#include "brdf/hammersley.h"
#include "brdf/lobe.h"
#include "test.h"

static uint32_t reverse_bit_by_bit(uint32_t i)
{
    uint32_t r = 0;

    for (int bit = 0; bit < 32; bit++) {
        if (i >> bit & 1)
            r |= 1u << (31 - bit);
    }
    return r;
}

TEST(radical_inverse)
{
    test_random rnd = {1};
    int wrong = 0;

    for (uint32_t i = 0; i < 70000; i++) {
        wrong += ibl_reverse_bits(i) != reverse_bit_by_bit(i);
        uint32_t any = (uint32_t)test_random_u64(&rnd);
        wrong += ibl_reverse_bits(any) != reverse_bit_by_bit(any);
    }
    for (int bit = 0; bit < 32; bit++)
        wrong += ibl_reverse_bits(1u << bit) != 1u << (31 - bit);
    CHECK(wrong == 0);
    CHECK(ibl_radical_inverse(0) == 0.0);
    CHECK(ibl_radical_inverse(1) == 0.5);
    CHECK(ibl_radical_inverse(6) == 0.375);
    CHECK(ibl_radical_inverse(0xffffffffu) == 1.0 - 0x1p-32);
}

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

static double d_of(double sin_h, double cos_h, double alpha)
{
    const double c = alpha * cos_h;
    return ibl_ggx_d(sin_h * sin_h + c * c, alpha);
}

/* 2pi integral of D cos sin over the hemisphere is 1 for every width; midpoint
 * in log(tan), which follows the peak. */
TEST(ggx_normalised)
{
    const double alphas[] = {1e-4, 1e-3, 0.01, 0.1, 0.3, 0.5, 0.9, 1.0};

    for (size_t k = 0; k < sizeof alphas / sizeof alphas[0]; k++) {
        double sum = 0.0, h = 0.01;
        for (double x = -30.0; x < 30.0; x += h) {
            double tan_h = alphas[k] * exp(x);
            double c = 1.0 / sqrt(1.0 + tan_h * tan_h), s = tan_h * c;
            double w = 2 * IBL_PI * c * s * (h * tan_h * c * c);
            sum += d_of(s, c, alphas[k]) * w;
        }
        CHECK_NEAR(sum, 1.0, 1e-12);
    }
}

TEST(ggx_values)
{
    /* alpha = 1 is uniform: 1/pi; the peak is 1 / (pi alpha^2). */
    CHECK_NEAR(d_of(0.6, 0.8, 1), 1 / IBL_PI, 1e-15);
    CHECK_NEAR(d_of(0, 1, 0.1), 100 / IBL_PI, 1e-12);
    CHECK_NEAR(d_of(0.8, 0.6, 0.5),
               0.25 / (IBL_PI * pow(0.36 * -0.75 + 1.0, 2)), 1e-15);
    CHECK(isfinite(d_of(0, 1, 1e-150)));
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

/*
 * The weak white furnace (Heitz 2014, section 5.3): with masking alone, the
 * integral of D G1(V) max(V.H, 0) over half vectors is N.V for every view.
 * Lambda(N) = 0, so at N.L = 1 the visibility gives G1. D cos dH is du, and
 * u = 1 - t^2 takes the 1/cos of the horizon out of the sum.
 */
TEST(weak_white_furnace)
{
    const double views[] = {0.02, 0.1, 0.5, 0.9, 1.0};
    const int n = 400;

    for (size_t k = 0; k < sizeof views / sizeof views[0]; k++) {
        for (double a = 0.1; a <= 1.0; a += 0.3) {
            double v = views[k], sv = sqrt(1 - v * v), sum = 0.0;
            double g1 = ibl_smith_visibility(1.0, v, a) * 4 * v;
            for (int i = 0; i < n; i++) {
                double t = (i + 0.5) / n, s, c;
                ibl_ggx_sample_half(1 - t * t, a, &s, &c);
                for (int j = 0; j < n; j++) {
                    double x = s * cos(2 * IBL_PI * (j + 0.5) / n);
                    double vh = sv * x + v * c;
                    sum += vh > 0.0 ? vh / (c * v) * 2 * t : 0.0;
                }
            }
            CHECK_NEAR(sum * g1 / n / n, 1.0, 1e-4);
        }
    }
}

TEST(fresnel)
{
    CHECK(ibl_fresnel_weight(1.0) == 0.0);
    CHECK(ibl_fresnel_weight(0.0) == 1.0);
    CHECK_NEAR(ibl_fresnel_weight(0.5), 1 / 32.0, 1e-16);
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
