/* SPDX-License-Identifier: MIT */
/*
 * The reference of every lobe against closed forms and against sums in long
 * double that are written out here from the conventions in ibl/ibl.h; never
 * against a bake.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reference.h"

enum {
    LOBES = 3
};

static bool same(const double *a, const double *b, size_t n)
{
    return !memcmp(a, b, n * sizeof *a);
}

/* ---- the sums, in long double ----------------------------------------- */

typedef struct aim {
    ibl_lobe lobe;
    long double alpha, theta, phi;
} aim;

/* The lobe's N.L D, without its constant. */
static long double weight_at(const aim *a, long double theta, long double phi)
{
    const long double polar = sinl((theta - a->theta) / 2);
    const long double across = sinl((phi - a->phi) / 2);
    const long double q =
        polar * polar + sinl(theta) * sinl(a->theta) * across * across;
    const long double c = 1 - 2 * q, a2 = a->alpha * a->alpha;
    if (c <= 0)
        return 0;
    if (a->lobe == IBL_LOBE_CHARLIE)
        return powl(sqrtl(2 * q), 1 / a->alpha) * c;
    if (a->lobe == IBL_LOBE_PHONG)
        return powl(c, (1 / a2 - 1) / 2 + 1);
    return c * powl(a2 / (q + a2 * (1 - q)), 2);
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

/* What ibl/reference.h defines, patches by sub x sub points. */
static void expect(const ibl_image *env, const aim *a, int sub, double rgb[3])
{
    const int w = env->width, h = env->height;
    long double sum[4] = {0};
    for (int k = 0; k < w * h; k++) {
        const long double weight = patch_weight(a, w, h, k % w, k / w, sub);
        for (int c = 0; c < 3; c++)
            sum[c] += weight * env->data[3 * k + c];
        sum[3] += weight;
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = (double)(sum[c] / sum[3]);
}

/* The change that halving the points' step still makes, more than the error
 * that is left but where the horizon crosses pixels, is the tolerance. */
static void compare(int w, int h, double r, double theta, double phi, int sub)
{
    subject *it = subject_make(2, w, h, 5, 0);

    for (int k = 0; k < LOBES; k++) {
        const aim a = {(ibl_lobe)k, (long double)r * r, theta, phi};
        double d[3], rgb[3], coarse[3], fine[3];
        polar_direction(theta, phi, d);
        CHECK(!ibl_reference_lobe(subject_ref(it), a.lobe, r, d, 1, rgb));
        expect(&it->env, &a, sub / 2, coarse);
        expect(&it->env, &a, sub, fine);
        for (int c = 0; c < 3; c++) {
            const double tol =
                (k ? 3e-6 : 1e-6) * fine[c] + 8 * fabs(fine[c] - coarse[c]);
            CHECK_MSG(fabs(rgb[c] - fine[c]) <= tol,
                      "%s %dx%d r %g at (%g, %g): %.12g, not %.12g +- %.2g",
                      ibl_lobe_name(a.lobe), w, h, r, theta, phi, rgb[c],
                      fine[c], tol);
        }
    }
}

TEST_SLOW(wide)
{
    static const double r[] = {1, 0.7, 0.5};
    for (int k = 0; k < 3; k++) {
        compare(64, 32, r[k], 1.234, 0.567, 8);
        compare(51, 37, r[k], 0, 0, 8);
        compare(64, 32, r[k], M_PI, 2, 8);
        compare(57, 32, r[k], 0.01, -3.1415, 8);
    }
    /* Most pixels by two points along an axis. */
    compare(128, 64, 1, 1.234, 0.567, 4);
}

TEST_SLOW(narrow)
{
    compare(32, 16, 0.3, 1.234, 3.1, 16);
    compare(24, 13, 0.3, 0.05, -1, 32);
    compare(16, 8, 0.2, M_PI, 0, 32);
    compare(12, 6, 1, 1.8, 2.7, 32);
    compare(7, 3, 0.8, 0.9, -2.7, 64);
    compare(2, 1, 0.6, 0.9, 1.5, 128);
    compare(1, 5, 0.9, 2.2, 0.5, 64);
}

/* Edges of pixels on the horizon: what rounding leaves of them above it has no
 * digits to settle by, and halving it for them would not end. */
TEST(edge_on_horizon)
{
    for (int k = -1; k < 3; k++) {
        compare(13, 7, 1, M_PI / 2, k * M_PI / 2, 32);
        compare(13, 7, 0.4, M_PI / 2, k * M_PI / 2, 32);
    }
    compare(4, 2, 1, M_PI / 2, M_PI / 2, 64);
    compare(4, 2, 1, 0, 0, 64);
}

/* ---- closed forms ----------------------------------------------------- */

/* The integral of a lobe inside a cone, v = 1 - cos(psi) = 2 q there, in parts
 * of the whole. GGX: with t = a2 + b q, b = 1 - a2, that of (1 - 2q) / t^2 dq
 * is (1 + 2 a2 / b) (1/a2 - 1/t) / b - 2/b^2 ln(t / a2). */
static double within(ibl_lobe lobe, long double alpha, long double v)
{
    const long double s = 0.5L / alpha, a2 = alpha * alpha, b = 1 - a2;
    long double part[2];
    if (lobe == IBL_LOBE_CHARLIE)
        return (double)(expl((s + 1) * logl(v)) * (1 + (s + 1) * (1 - v)));
    if (lobe == IBL_LOBE_PHONG)
        return (double)-expm1l((0.5L * (1 / a2 - 1) + 2) * log1pl(-v));
    for (int k = 0; k < 2; k++) {
        const long double q = k ? 0.5L : v / 2;
        part[k] = (1 + 2 * a2 / b) * (q / (a2 * (a2 + b * q))) -
                  2 / (b * b) * log1pl(b * q / a2);
    }
    return (double)(part[0] / part[1]);
}

/* Straight up, of few columns: patches throughout. Red is inside the cone,
 * green outside, to its own digits where the lobe has them. */
TEST(caps)
{
    static const double r[] = {0.9, 0.6, 0.4, 0.3, 0.2, 0.1};
    static const int lit[] = {1, 3, 20, 31, 32};
    static const double up[3] = {0, 1, 0};
    enum {
        H = 64
    };
    subject *it = subject_make(1, 3, H, 0, 77);

    for (int k = 0; k < 6 * 5 * LOBES; k++) {
        const ibl_lobe lobe = (ibl_lobe)(k % LOBES);
        const double roughness = r[k / 15], alpha = roughness * roughness;
        const int rows = lit[k / LOBES % 5];
        const long double s = sinl(pi_l / 2 * rows / H);
        const double want =
            rows == H / 2
                ? 1
                : within(lobe,
                         lobe == IBL_LOBE_CHARLIE ? fmax(alpha, 1e-3) : alpha,
                         2 * s * s);
        double rgb[3];
        for (int i = 0; i < 3 * H; i++) {
            it->env.data[3 * i] = i < 3 * rows;
            it->env.data[3 * i + 1] = i >= 3 * rows;
        }
        CHECK(
            !ibl_reference_lobe(subject_ref(it), lobe, roughness, up, 1, rgb));
        CHECK_MSG(fabs(rgb[0] - want) < 2e-6,
                  "%s r %g, %d rows: %.12g, not %.12g", ibl_lobe_name(lobe),
                  roughness, rows, rgb[0], want);
        if (lobe == IBL_LOBE_GGX && rows < H / 2 && roughness >= 0.01)
            CHECK_NEAR(rgb[1], 1 - want, 1e-5 * (1 - want) + 1e-12);
    }
}

/* Ahead, on the equator: by symmetry half of the lobe is above it and half to
 * the left, however thin the ring or the needle. The upper left is 1. */
TEST(quarters)
{
    static const int sizes[][2] = {{64, 32}, {8, 4}, {4, 64}, {100, 2}};
    static const double ahead[3] = {1, 0, 0};
    for (int k = 0; k < (TEST_RACES ? 3 : 12); k++) {
        const int w = sizes[k / 3][0], h = sizes[k / 3][1];
        subject *it = subject_make(1, w, h, 0, 0);

        for (int i = 0; i < w * h; i++) {
            it->env.data[3 * i] = i / w < h / 2;
            it->env.data[3 * i + 1] = i % w < w / 2;
            it->env.data[3 * i + 2] = i / w < h / 2 && i % w < w / 2;
        }
        for (double r = 1; r > (k % 3 == 1 ? 0.1 : 1e-3); r *= 0.3) {
            double rgb[3];
            CHECK(!ibl_reference_lobe(subject_ref(it), (ibl_lobe)(k % 3), r,
                                      ahead, 1, rgb));
            CHECK_NEAR(rgb[0], 0.5, 1e-5);
            CHECK_NEAR(rgb[1], 0.5, 1e-5);
            CHECK_NEAR(rgb[2], 0.25, 1e-5);
        }
    }
}

TEST(constants)
{
    static const int sizes[][2] = {{1, 1}, {2, 1},   {1, 3},
                                   {3, 2}, {31, 17}, {64, 32}};
    static const double r[] = {0, 1e-30, 1e-4, 0.03, 0.1, 0.3, 0.9, 1};
    const double want = (double)0.7f;

    for (int k = 0; k < 6 * LOBES; k++) {
        subject *it = subject_make(2, sizes[k / 3][0], sizes[k / 3][1], 0, 33);
        double d[9] = {0, 1, 0, 0, -1, 0}, rgb[9], mean[3];
        polar_direction(1.1, k, d + 6);
        for (size_t i = 0; i < map_floats(&it->env); i++)
            it->env.data[i] = 0.7f;
        for (int m = 0; m < 8; m++) {
            CHECK(!ibl_reference_lobe(subject_ref(it), (ibl_lobe)(k % 3), r[m],
                                      d, 3, rgb));
            for (int c = 0; c < 9; c++)
                CHECK_NEAR(rgb[c], want, 1e-7);
        }
        CHECK(!ibl_reference_mean(subject_ref(it), mean));
        CHECK_NEAR(mean[0], want, 2e-7);
        for (int n = 1; n <= 19; n += 6) {
            const ibl_texel t[3] = {
                {2, n / 2, n / 2}, {0, 0, n - 1}, {3, n - 1, 0}};
            CHECK(!ibl_reference_texels(subject_ref(it), IBL_PROJECTION_CUBE, n,
                                        n, t, 3, rgb));
            for (int c = 0; c < 9; c++)
                CHECK_NEAR(rgb[c], want, 1e-7);
        }
    }
}

/* At roughness 1 Phong and GGX are the cosine; roughness 0 is the pixel, the
 * end of 1e-4 the middle of the same; GGX is what it is by its own name. */
TEST(ends)
{
    subject *it = subject_make(2, 40, 20, 3, 90);

    for (int k = 0; k < 400; k++) {
        const int i = k % 40, j = k / 40 * 2 + k % 2;
        const float *p = map_pixel(&it->env, i, j);
        double d[3], rgb[3], want[3];
        /* The map's azimuth is the world's and a quarter turn. */
        polar_direction(M_PI * (j + 0.3) / 20,
                        2 * M_PI * ((i + 0.6) / 40 - 0.75), d);
        for (int l = 0; l < LOBES; l++) {
            CHECK(!ibl_reference_lobe(subject_ref(it), (ibl_lobe)l, 0, d, 1,
                                      rgb));
            CHECK(rgb[0] == (double)p[0] && rgb[1] == (double)p[1] &&
                  rgb[2] == (double)p[2]);
        }
        CHECK(!ibl_reference_lobe(subject_ref(it), IBL_LOBE_GGX, 1e-5, d, 1,
                                  rgb));
        CHECK_NEAR(rgb[0], (double)p[0], 1e-7);
        CHECK(!ibl_reference_lobe(subject_ref(it), IBL_LOBE_GGX, 1e-36, d, 1,
                                  rgb));
        CHECK_NEAR(rgb[0], (double)p[0], 1e-15);
        if (k % 21)
            continue;
        CHECK(!ibl_reference_irradiance(subject_ref(it), d, 1, want));
        CHECK(!ibl_reference_lobe(subject_ref(it), IBL_LOBE_GGX, 1, d, 1, rgb));
        CHECK(same(rgb, want, 3));
        CHECK(
            !ibl_reference_lobe(subject_ref(it), IBL_LOBE_PHONG, 1, d, 1, rgb));
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(rgb[c], want[c], 1e-13);
        CHECK(!ibl_reference_lobe(subject_ref(it), IBL_LOBE_GGX, 0.3, d, 1,
                                  want));
        CHECK(
            !ibl_reference_lobe(subject_ref(it), IBL_LOBE_GGX, 0.3, d, 1, rgb));
        CHECK(same(rgb, want, 3));
    }
}

/* No step anywhere as r passes where pixels begin to be patches. */
TEST(continuous)
{
    subject *it = subject_make(2, 64, 32, 8, 0);
    double d[3], before = 0, rgb[3];

    polar_direction(0.9, 1.9, d);
    for (int k = 0; k < LOBES; k++) {
        double largest = 0;
        for (int i = 0; i <= 150; i++) {
            CHECK(!ibl_reference_lobe(subject_ref(it), (ibl_lobe)k,
                                      0.2 + 0.003 * i, d, 1, rgb));
            if (i)
                largest = fmax(largest, fabs(rgb[0] - before) / before);
            before = rgb[0];
        }
        CHECK_MSG(largest < 0.03, "%s: a step of %g",
                  ibl_lobe_name((ibl_lobe)k), largest);
    }
}

/* L = 1 + d.a has the mean 1 + 2/3 N.a under the cosine lobe, else 1. */
TEST(linear_light)
{
    subject *it = subject_make(2, 512, 256, 0, 25);
    const double a[3] = {0.3, -0.5, 0.4};
    test_random rnd = {4};
    double rgb[3];

    for (int k = 0; k < 512 * 256; k++) {
        double d[3];
        polar_direction(
            M_PI * (k / 512 + 0.5) / 256,
            2 * M_PI * ((k % 512 + 0.5) / 512 - 0.5) - 25 * M_PI / 180, d);
        for (int c = 0; c < 3; c++)
            it->env.data[3 * k + c] =
                (float)(1 + d[0] * a[0] + d[1] * a[1] + d[2] * a[2]);
    }
    for (int k = 0; k < 20; k++) {
        double d[3];
        random_direction(&rnd, d);
        const double na = d[0] * a[0] + d[1] * a[1] + d[2] * a[2];
        CHECK(!ibl_reference_irradiance(subject_ref(it), d, 1, rgb));
        CHECK_NEAR(rgb[0], 1 + na * 2 / 3, 2e-5);
    }
    CHECK(!ibl_reference_mean(subject_ref(it), rgb));
    CHECK_NEAR(rgb[1], 1, 1e-6);
}

/* The mean, by its sum in long double. */
TEST(means)
{
    static const int sizes[][2] = {{1, 1}, {2, 1}, {3, 2}, {33, 17}, {64, 32}};

    for (int k = 0; k < 5; k++) {
        const int w = sizes[k][0], h = sizes[k][1];
        subject *it = subject_make(2, w, h, 20 + (uint64_t)k, 0);
        long double mean = 0;
        double rgb[3];
        for (int i = 0; i < w * h; i++)
            mean += row_angle(w, h, i / w) * it->env.data[3 * i] / (4 * pi_l);
        CHECK(!ibl_reference_mean(subject_ref(it), rgb));
        CHECK_NEAR(rgb[0], (double)mean, 1e-8);
    }
}

/* ---- the rules of every call ------------------------------------------ */

TEST(threads)
{
    const int counts[] = {1, 2, 3, 7};
    double first[4][60], sh[3 * 81], dirs[60];
    test_random rnd = {6};

    for (int k = 0; k < 20; k++)
        random_direction(&rnd, dirs + 3 * k);
    for (int k = 0; k < 4; k += TEST_SANITIZED ? 2 : 1) {
        subject *it = subject_make(counts[k], 300, 151, 2, 5);
        double rgb[4][60], a[3 * 81];
        ibl_texel t[20];
        for (int m = 0; m < 20; m++)
            t[m] = (ibl_texel){m % 6, m, 19 - m};
        CHECK(!ibl_reference_lobe(subject_ref(it), IBL_LOBE_GGX, 0.5, dirs, 20,
                                  rgb[0]));
        CHECK(!ibl_reference_lobe(subject_ref(it), IBL_LOBE_GGX, 0.1, dirs, 20,
                                  rgb[1]));
        CHECK(!ibl_reference_irradiance(subject_ref(it), dirs, 20, rgb[2]));
        CHECK(!ibl_reference_texels(subject_ref(it), IBL_PROJECTION_CUBE, 20,
                                    20, t, 20, rgb[3]));
        CHECK(!ibl_reference_sh(subject_ref(it), 8, a));
        if (k == 0) {
            memcpy(first, rgb, sizeof rgb);
            memcpy(sh, a, sizeof a);
        }
        CHECK(same(first[0], rgb[0], 4 * 60));
        CHECK(same(sh, a, 3 * 81));
    }
}

/* One direction alone or among others. */
TEST(alone)
{
    subject *it = subject_make(2, 90, 45, 2, 5);
    double dirs[60], rgb[60], one[3];
    test_random rnd = {6};

    for (int k = 0; k < 20; k++)
        random_direction(&rnd, dirs + 3 * k);
    CHECK(
        !ibl_reference_lobe(subject_ref(it), IBL_LOBE_GGX, 0.3, dirs, 20, rgb));
    for (int k = 0; k < 20; k++) {
        CHECK(!ibl_reference_lobe(subject_ref(it), IBL_LOBE_GGX, 0.3,
                                  dirs + 3 * k, 1, one));
        CHECK(same(one, rgb + 3 * k, 3));
    }
    CHECK(
        !ibl_reference_lobe(subject_ref(it), IBL_LOBE_GGX, 0.3, dirs, 0, NULL));
}

/* Pixels in four parts are what they were: within 1e-7 of a pixel's weight
 * where that is by a few points, and all digits but some near the aim. */
TEST(in_four)
{
    static const int widths[] = {16, 48, 120};
    static const double roughness[] = {0.05, 0.2, 0.4, 0.6, 0.8, 1};
    test_random rnd = {12};

    for (int k = 0; k < 3; k++) {
        const int w = widths[k], h = w / 2;
        subject *one = subject_make(2, w, h, 7, 15);
        subject *all = subject_make(2, 2 * w, 2 * h, 0, 15);
        for (int i = 0; i < 4 * w * h; i++)
            memcpy(map_pixel(&all->env, i % (2 * w), i / (2 * w)),
                   map_pixel(&one->env, i % (2 * w) / 2, i / (4 * w)),
                   3 * sizeof(float));
        for (int m = 0; m < 6; m++) {
            double d[15], a[15], b[15];
            for (int i = 0; i < 5; i++)
                random_direction(&rnd, d + 3 * i);
            CHECK(!ibl_reference_lobe(subject_ref(one), IBL_LOBE_GGX,
                                      roughness[m], d, 5, a));
            CHECK(!ibl_reference_lobe(subject_ref(all), IBL_LOBE_GGX,
                                      roughness[m], d, 5, b));
            for (int i = 0; i < 15; i++)
                CHECK_NEAR(a[i], b[i], 1e-5 * a[i]);
        }
    }
}

/* By the definition, and what is nothing has finite errors. */
TEST(relative_errors)
{
    const double rgb[3] = {3, 4, 0}, far[3] = {6, 8, 0}, none[3] = {0};
    const double mean[3] = {0, 0, 5};

    CHECK_NEAR(ibl_relative_error(rgb, far, mean), 0.5, 1e-15);
    CHECK_NEAR(ibl_relative_error(rgb, none, mean), 1 / IBL_RELATIVE_FLOOR,
               1e-9);
    CHECK(ibl_relative_error(none, none, none) == 0);
    CHECK(isfinite(ibl_relative_error(rgb, none, none)));
}

TEST(bad_arguments)
{
    ibl_ctx *ctx = test_ctx_of(NULL);
    ibl_image env = map_constant(ctx, 8, 4, 1), none = {0};
    ibl_reference *ref = NULL;
    const double up[3] = {0, 1, 0}, zero[3] = {0}, nan3[3] = {NAN, 0, 1};
    double rgb[3] = {7, 7, 7}, a[3];
    const ibl_texel bad[4] = {{6, 0, 0}, {0, 4, 0}, {0, 0, -1}, {-1, 0, 0}};

    CHECK(ibl_reference_create(ctx, &none, 0, &ref) == IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_create(ctx, &env, INFINITY, &ref) == IBL_ERR_ARGUMENT);
    CHECK(!ref);
    NEED(!ibl_reference_create(ctx, &env, -1000, &ref));
    CHECK(ibl_reference_lobe(ref, IBL_LOBE_GGX, -0.1, up, 1, rgb) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_lobe(ref, IBL_LOBE_GGX, 1.1, up, 1, rgb) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_lobe(ref, IBL_LOBE_GGX, NAN, up, 1, rgb) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_lobe(ref, (ibl_lobe)3, 0.5, up, 1, rgb) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_lobe(ref, (ibl_lobe)-1, 0.5, up, 1, rgb) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_lobe(ref, IBL_LOBE_GGX, 0.5, zero, 1, rgb) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_irradiance(ref, nan3, 1, rgb) == IBL_ERR_ARGUMENT);
    for (int k = 0; k < 4; k++)
        CHECK(ibl_reference_texels(ref, IBL_PROJECTION_CUBE, 4, 4, &bad[k], 1,
                                   rgb) == IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_texels(ref, IBL_PROJECTION_CUBE, 1, 0, bad, 0, rgb) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_sh(ref, -1, a) == IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_sh(ref, 65, a) == IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_lut(ctx, 1.1, 0.5, IBL_GEOMETRY_SMITH, a) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_lut(ctx, 1, NAN, IBL_GEOMETRY_SMITH, a) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_lut(ctx, 1, 1, (ibl_geometry)9, a) == IBL_ERR_ARGUMENT);
    CHECK(rgb[0] == 7 && rgb[1] == 7 && rgb[2] == 7);
    ibl_reference_free(ref);
    ibl_reference_free(NULL);
}

TEST(cancel)
{
    ibl_ctx *ctx = test_ctx_of(NULL);
    ibl_image env = map_constant(ctx, 64, 32, 1);
    ibl_reference *ref = reference_of(ctx, &env, 0);
    const double up[3] = {0, 1, 0};
    const ibl_texel t = {0, 0, 0};
    double out[27];

    ibl_ctx_cancel(ctx);
    for (int k = 0; k < 3; k++)
        CHECK(ibl_reference_lobe(ref, IBL_LOBE_GGX, 0.05 * k, up, 1, out) ==
              IBL_ERR_CANCELLED);
    CHECK(ibl_reference_irradiance(ref, up, 1, out) == IBL_ERR_CANCELLED);
    CHECK(ibl_reference_texels(ref, IBL_PROJECTION_CUBE, 4, 4, &t, 1, out) ==
          IBL_ERR_CANCELLED);
    CHECK(ibl_reference_sh(ref, 2, out) == IBL_ERR_CANCELLED);
    CHECK(ibl_reference_lut(ctx, 1, 1, IBL_GEOMETRY_SMITH, out) ==
          IBL_ERR_CANCELLED);
}
