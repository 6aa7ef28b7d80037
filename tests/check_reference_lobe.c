/* SPDX-License-Identifier: MIT */
/*
 * The reference of Charlie and Phong against closed forms and against sums in
 * long double that are written out here; check_reference.c has what they share
 * with GGX.
 */
#include <math.h>
#include <string.h>

#include "reference.h"

static const double pi = 3.14159265358979323846;
static const ibl_lobe lobes[] = {IBL_LOBE_CHARLIE, IBL_LOBE_PHONG};

/* ---- the sums, in long double ----------------------------------------- */

typedef struct aim {
    ibl_lobe lobe;
    long double alpha, theta, phi;
} aim;

static long double weight_at(const aim *a, long double theta, long double phi)
{
    const long double polar = sinl((theta - a->theta) / 2);
    const long double across = sinl((phi - a->phi) / 2);
    const long double q =
        polar * polar + sinl(theta) * sinl(a->theta) * across * across;
    const long double c = 1 - 2 * q;
    if (c <= 0)
        return 0;
    return a->lobe == IBL_LOBE_CHARLIE
               ? powl(sqrtl(2 * q), 1 / a->alpha) * c
               : powl(c, (1 / (a->alpha * a->alpha) - 1) / 2 + 1);
}

/* By sub x sub midpoints with exact solid angles. */
static long double patch_weight(const aim *a, int w, int h, int i, int j,
                                int sub)
{
    long double sum = 0;
    for (int y = 0; y < sub; y++) {
        const long double theta = pi_l * (j * sub + y + 0.5L) / (h * sub);
        long double line = 0;
        for (int x = 0; x < sub; x++)
            line += weight_at(
                a, theta, 2 * pi_l * ((i * sub + x + 0.5L) / (w * sub) - 0.5L));
        sum += line * row_angle(w * sub, h * sub, j * sub + y);
    }
    return sum;
}

/* What ibl/reference.h defines. */
static void expect(const ibl_image *env, const aim *a, int sub, double rgb[3])
{
    const int w = env->width, h = env->height;
    long double sum[4] = {0};
    for (int k = 0; k < w * h; k++) {
        const int i = k % w, j = k / w;
        const long double weight = patch_weight(a, w, h, i, j, sub);
        for (int c = 0; c < 3; c++)
            sum[c] += weight * env->data[3 * k + c];
        sum[3] += weight;
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = (double)(sum[c] / sum[3]);
}

/* The change that halving the points' step still makes is the tolerance. */
static void compare(int w, int h, double r, double theta, double phi, int sub)
{
    subject *it = subject_make(2, w, h, 5, 0);

    for (int k = 0; k < 2; k++) {
        const aim a = {lobes[k], (long double)r * r, theta, phi};
        double d[3], rgb[3], coarse[3], fine[3];
        polar_direction(theta, phi, d);
        CHECK(!ibl_reference_lobe(it->ref, lobes[k], r, d, 1, rgb));
        expect(&it->env, &a, sub / 2, coarse);
        expect(&it->env, &a, sub, fine);
        for (int c = 0; c < 3; c++) {
            const double tol = 3e-6 * fine[c] + 8 * fabs(fine[c] - coarse[c]);
            CHECK_MSG(fabs(rgb[c] - fine[c]) <= tol,
                      "%s %dx%d r %g at (%g, %g): %.12g, not %.12g +- %.2g",
                      ibl_lobe_name(lobes[k]), w, h, r, theta, phi, rgb[c],
                      fine[c], tol);
        }
    }
    subject_free(it);
}

static void wide(void)
{
    static const double r[] = {1, 0.7, 0.5};
    for (int k = 0; k < 3; k++) {
        compare(64, 32, r[k], 1.234, 0.567, 8);
        compare(51, 37, r[k], 0, 0, 8);
        compare(64, 32, r[k], pi, 2, 8);
        compare(57, 32, r[k], 0.01, -3.1415, 8);
    }
}

static void narrow(void)
{
    compare(32, 16, 0.5, 1.234, 0.567, 16);
    compare(32, 16, 0.3, 1.234, 3.1, 32);
    compare(24, 13, 0.3, 0.05, -1, 32);
    compare(16, 8, 0.2, pi, 0, 64);
    compare(12, 6, 1, 1.8, 2.7, 32);
    compare(7, 3, 0.8, 0.9, -2.7, 64);
    compare(2, 1, 0.6, 0.9, 1.5, 128);
    compare(1, 5, 0.9, 2.2, 0.5, 64);
}

/* ---- closed forms ----------------------------------------------------- */

/* The share of a lobe inside a cone, v = 1 - cos(psi) there. */
static double within(ibl_lobe lobe, double alpha, double v)
{
    const double s = 0.5 / alpha, n = 0.5 * (1 / alpha - 1) * (1 / alpha + 1);
    if (lobe == IBL_LOBE_CHARLIE)
        return exp((s + 1) * log(v)) * (1 + (s + 1) * (1 - v));
    return -expm1((n + 2) * log1p(-v));
}

/* Straight up, of few columns: patches throughout. */
static void caps(void)
{
    static const double r[] = {0.9, 0.6, 0.4, 0.3, 0.2, 0.1, 0.01, 1e-4, 1e-9};
    static const int lit[] = {1, 3, 20, 31, 32};
    static const double up[3] = {0, 1, 0};
    enum {
        H = 64
    };
    subject *it = subject_make(1, 3, H, 0, 77);

    for (int k = 0; k < 9 * 5 * 2; k++) {
        const double roughness = r[k / 10];
        const int rows = lit[k / 2 % 5];
        const double s = sin(pi / 2 * rows / H);
        const double alpha = roughness * roughness;
        const double want =
            rows == H / 2
                ? 1
                : within(lobes[k % 2], k % 2 ? alpha : fmax(alpha, 1e-9),
                         2 * s * s);
        double rgb[3];
        for (int i = 0; i < 3 * H; i++)
            it->env.data[3 * i] = i < 3 * rows;
        CHECK(
            !ibl_reference_lobe(it->ref, lobes[k % 2], roughness, up, 1, rgb));
        CHECK_MSG(fabs(rgb[0] - want) < 1e-8,
                  "%s r %g, %d rows: %.12g, not %.12g",
                  ibl_lobe_name(lobes[k % 2]), roughness, rows, rgb[0], want);
    }
    subject_free(it);
}

/* Ahead, on the equator: by symmetry half of the lobe is above it and half to
 * the left, however thin the ring or the needle. The upper left is 1. */
static void quarters(void)
{
    static const int sizes[][2] = {{64, 32}, {8, 4}, {4, 64}, {100, 2}};
    for (int k = 0; k < (TEST_RACES ? 2 : 8); k++) {
        static const double ahead[3] = {1, 0, 0};
        const int w = sizes[k / 2][0], h = sizes[k / 2][1];
        subject *it = subject_make(1, w, h, 0, 0);

        for (int i = 0; i < w * h; i++) {
            it->env.data[3 * i] = i / w < h / 2;
            it->env.data[3 * i + 1] = i % w < w / 2;
            it->env.data[3 * i + 2] = i / w < h / 2 && i % w < w / 2;
        }
        for (double r = 1; r > 1e-20; r *= TEST_SANITIZED ? 1e-4 : 0.05) {
            double rgb[3];
            CHECK(!ibl_reference_lobe(it->ref, lobes[k % 2], r, ahead, 1, rgb));
            CHECK_NEAR(rgb[0], 0.5, 1e-7);
            CHECK_NEAR(rgb[1], 0.5, 1e-7);
            CHECK_NEAR(rgb[2], 0.25, 1e-7);
        }
        subject_free(it);
    }
}

/* A thin ring about a leaning direction: of the rows of a map it has the arc
 * of a great circle that is in them. Up to theta that is
 * 1/2 - asin(cos(theta) / sin(lean)) / pi, lean from +Y. */
static void rings(void)
{
    enum {
        H = 24
    };
    subject *it = subject_make(1, 2 * H, H, 0, 10);

    for (int k = 0; k < 12; k++) {
        const double lean = 0.3 + 0.2 * k;
        double d[3], rgb[3];
        polar_direction(lean, 1 + k, d);
        for (int rows = 1; rows < H; rows += 5) {
            const double c = cos(pi * rows / H) / sin(lean);
            const double want = 0.5 - asin(fmax(-1, fmin(1, c))) / pi;
            for (int i = 0; i < 2 * H * H; i++)
                it->env.data[3 * i] = i / (2 * H) < rows;
            CHECK(!ibl_reference_lobe(it->ref, IBL_LOBE_CHARLIE, 1e-4, d, 1,
                                      rgb));
            /* A ring of 1e-8 that grazes a border is in it along its root. */
            CHECK_MSG(
                fabs(rgb[0] - want) < (fabs(fabs(c) - 1) < 0.01 ? 2e-3 : 2e-6),
                "lean %g, %d rows: %.9g, not %.9g", lean, rows, rgb[0], want);
        }
    }
    subject_free(it);
}

/* ---- everything else --------------------------------------------------- */

static void constants(void)
{
    static const int sizes[][2] = {{1, 1}, {2, 1},   {1, 3},
                                   {3, 2}, {31, 17}, {64, 32}};
    static const double r[] = {0, 1e-30, 1e-4, 0.03, 0.1, 0.3, 0.9, 1};
    for (int k = 0; k < 12; k++) {
        subject *it = subject_make(2, sizes[k / 2][0], sizes[k / 2][1], 0, 33);
        double d[9] = {0, 1, 0, 0, -1, 0}, rgb[9];
        polar_direction(1.1, k, d + 6);
        for (int i = 0; i < 3 * it->env.width * it->env.height; i++)
            it->env.data[i] = 0.7f;
        for (int m = 0; m < 8; m++) {
            CHECK(!ibl_reference_lobe(it->ref, lobes[k % 2], r[m], d, 3, rgb));
            for (int c = 0; c < 9; c++)
                CHECK_NEAR(rgb[c], (double)0.7f, 1e-14);
        }
        subject_free(it);
    }
}

/* At roughness 1 Phong is the cosine, where both take centres; roughness 0 is
 * the pixel; GGX is what it is by its own name. */
static void ends(void)
{
    subject *it = subject_make(2, 40, 20, 3, 90);

    for (int k = 0; k < 20; k++) {
        double d[3], rgb[3], want[3];
        polar_direction(0.1 + 0.14 * k, 2.0 * k, d);
        CHECK(!ibl_reference_lobe(it->ref, IBL_LOBE_PHONG, 1, d, 1, rgb));
        CHECK(!ibl_reference_irradiance(it->ref, d, 1, want));
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(rgb[c], want[c], 1e-13);
        CHECK(!ibl_reference_specular(it->ref, 0, d, 1, want));
        for (int l = 0; l < 3; l++) {
            CHECK(!ibl_reference_lobe(it->ref, (ibl_lobe)l, 0, d, 1, rgb));
            CHECK(!memcmp(rgb, want, sizeof rgb));
        }
        CHECK(!ibl_reference_specular(it->ref, 0.3, d, 1, want));
        CHECK(!ibl_reference_lobe(it->ref, IBL_LOBE_GGX, 0.3, d, 1, rgb));
        CHECK(!memcmp(rgb, want, sizeof rgb));
    }
    subject_free(it);
}

/* No step as r passes where pixels begin to be patches. */
static void continuous(void)
{
    subject *it = subject_make(2, 64, 32, 8, 0);
    double d[3];
    polar_direction(0.9, 1.9, d);
    for (int k = 0; k < 2; k++) {
        double before[3], rgb[3], largest = 0;
        CHECK(!ibl_reference_lobe(it->ref, lobes[k], 0.2, d, 1, before));
        for (int i = 1; i <= 150; i++) {
            CHECK(!ibl_reference_lobe(it->ref, lobes[k], 0.2 + 0.002 * i, d, 1,
                                      rgb));
            largest = fmax(largest, fabs(rgb[0] - before[0]) / before[0]);
            memcpy(before, rgb, sizeof rgb);
        }
        CHECK_MSG(largest < 0.02, "%s: a step of %g", ibl_lobe_name(lobes[k]),
                  largest);
    }
    subject_free(it);
}

static void refusals(void)
{
    const ibl_ctx_options o = ibl_ctx_options_default();
    const double up[3] = {0, 1, 0};
    double rgb[3] = {7, 7, 7};
    ibl_ctx *ctx = NULL;
    NEED(!ibl_ctx_create(&o, &ctx));
    ibl_image env = map_constant(ctx, 4, 2, 0);
    ibl_reference *ref = NULL;
    NEED(!ibl_reference_create(ctx, &env, 0, &ref));
    CHECK(ibl_reference_lobe(ref, (ibl_lobe)3, 0.5, up, 1, rgb) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_lobe(ref, (ibl_lobe)-1, 0.5, up, 1, rgb) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_lobe(ref, IBL_LOBE_PHONG, NAN, up, 1, rgb) ==
          IBL_ERR_ARGUMENT);
    CHECK(rgb[0] == 7);
    ibl_ctx_cancel(ctx);
    CHECK(ibl_reference_lobe(ref, IBL_LOBE_PHONG, 0.5, up, 1, rgb) ==
          IBL_ERR_CANCELLED);
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static const test tests[] = {TEST(wide),     TEST(narrow),     TEST(caps),
                             TEST(quarters), TEST(rings),      TEST(constants),
                             TEST(ends),     TEST(continuous), TEST(refusals)};
TEST_MAIN(tests)
