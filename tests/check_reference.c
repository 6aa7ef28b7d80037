/* SPDX-License-Identifier: MIT */
/*
 * The reference against closed forms and against sums in long double that are
 * written out here from the conventions in ibl/ibl.h; never against a bake.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/reference_sums.h"
#include "reference.h"

static const double pi = 3.14159265358979323846;

static bool same(const double *a, const double *b, size_t n)
{
    return !memcmp(a, b, n * sizeof *a);
}

/* ---- the sums, in long double ----------------------------------------- */

typedef struct lobe {
    long double theta, phi, a2;
} lobe;

/* The lobe's N.L D, without its constant. */
static long double lobe_at(const lobe *l, long double theta, long double phi)
{
    const long double polar = sinl((theta - l->theta) / 2);
    const long double across = sinl((phi - l->phi) / 2);
    const long double q =
        polar * polar + sinl(theta) * sinl(l->theta) * across * across;
    const long double t = q + l->a2 * (1 - q);

    return q < 0.5L ? (1 - 2 * q) * (l->a2 / t) * (l->a2 / t) : 0;
}

/* By sub x sub midpoints with exact solid angles. */
static long double patch_weight(const lobe *l, int w, int h, int i, int j,
                                int sub)
{
    long double sum = 0;

    for (int y = 0; y < sub; y++) {
        const long double theta = pi_l * (j * sub + y + 0.5L) / (h * sub);
        long double line = 0;
        for (int x = 0; x < sub; x++) {
            const long double phi =
                2 * pi_l * ((i * sub + x + 0.5L) / (w * sub) - 0.5L);
            line += lobe_at(l, theta, phi);
        }
        sum += line * row_angle(w * sub, h * sub, j * sub + y);
    }
    return sum;
}

/* What ibl/reference.h defines, patches by sub x sub points. */
static void expect(const ibl_image *env, double roughness, double theta,
                   double phi, int sub, double rgb[3])
{
    const int w = env->width, h = env->height;
    const lobe l = {theta, phi, powl(roughness, 4)};
    long double sum[4] = {0};

    for (int j = 0; j < h; j++) {
        for (int i = 0; i < w; i++) {
            const long double weight = patch_weight(&l, w, h, i, j, sub);
            for (int c = 0; c < 3; c++)
                sum[c] += weight * map_pixel(env, i, j)[c];
            sum[3] += weight;
        }
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = (double)(sum[c] / sum[3]);
}

/* The change that halving the points' step still makes, more than the error
 * that is left but where the horizon crosses pixels, is the tolerance. */
static void compare_specular(int w, int h, double roughness, double theta,
                             double phi, int sub)
{
    subject *it = subject_make(2, w, h, 5, 0);
    double d[3], rgb[3], coarse[3], fine[3];

    polar_direction(theta, phi, d);
    CHECK(!ibl_reference_specular(it->ref, roughness, d, 1, rgb));
    expect(&it->env, roughness, theta, phi, sub / 2, coarse);
    expect(&it->env, roughness, theta, phi, sub, fine);
    for (int c = 0; c < 3; c++) {
        const double tol = 1e-6 * fine[c] + 3 * fabs(fine[c] - coarse[c]);
        CHECK_MSG(fabs(rgb[c] - fine[c]) <= tol,
                  "%dx%d r %g at (%g, %g): %.12g, not %.12g +- %.2g", w, h,
                  roughness, theta, phi, rgb[c], fine[c], tol);
    }
    subject_free(it);
}

static void specular_wide(void)
{
    const double r[] = {1, 0.7, 0.5};

    for (int k = 0; k < 3; k++) {
        compare_specular(128, 64, r[k], 1.234, 0.567, 8);
        compare_specular(101, 67, r[k], 0, 0, 8);
        compare_specular(128, 64, r[k], pi, 2, 8);
        compare_specular(113, 64, r[k], 0.01, -3.1415, 8);
    }
}

static void specular_narrow(void)
{
    compare_specular(32, 16, 0.5, 1.234, 0.567, 16);
    compare_specular(32, 16, 0.3, 1.234, 3.1, 32);
    compare_specular(24, 13, 0.3, 0.05, -1, 32);
    compare_specular(16, 8, 0.2, pi, 0, 64);
    compare_specular(12, 6, 1, 1.8, 2.7, 32);
    compare_specular(7, 3, 0.8, 0.9, -2.7, 64);
    compare_specular(2, 1, 0.6, 0.9, 1.5, 128);
    compare_specular(1, 5, 0.9, 2.2, 0.5, 64);
}

/* Edges of pixels on the horizon: what rounding leaves of them above it has no
 * digits to settle by, and halving it for them would not end. */
static void edge_on_horizon(void)
{
    for (int k = -1; k < 3; k++) {
        compare_specular(13, 7, 1, pi / 2, k * pi / 2, 64);
        compare_specular(13, 7, 0.4, pi / 2, k * pi / 2, 64);
    }
    compare_specular(4, 2, 1, pi / 2, pi / 2, 64);
    compare_specular(4, 2, 1, 0, 0, 64);
}

/* The whole lobe in one quarter of the map: its share by the closed form of
 * the lobe inside a cone is what a cap around the pole gets.
 * Inside q0 = sin^2(psi0 / 2), with dO = 4 pi dq and t = a2 + b q,
 * b = 1 - a2, the integral of (1 - 2q) / t^2 dq is
 *     (1 + 2 a2 / b) (1/a2 - 1/t0) / b - 2/b^2 ln(t0 / a2). */
static long double within(long double a2, long double q)
{
    const long double b = 1 - a2, t = a2 + b * q;

    return (1 + 2 * a2 / b) * (q / (a2 * t)) - 2 / (b * b) * log1pl(b * q / a2);
}

static void one_cap(void)
{
    const double r[] = {0.4, 0.3, 0.2, 0.1, 0.01, 1e-4, 1e-9};
    /* One row of many: patches throughout, for p is half the circle. */
    const int h = 64, lit = 3;
    subject *it = subject_make(1, 3, h, 0, 77);
    const double up[3] = {0, 1, 0};

    for (int j = 0; j < lit; j++) {
        for (int i = 0; i < 3; i++)
            map_pixel(&it->env, i, j)[1] = 1;
    }
    const long double s = sinl(pi_l / 2 * lit / h);
    for (int k = 0; k < 7; k++) {
        const long double a2 = powl(r[k], 4);
        const long double want = within(a2, s * s) / within(a2, 0.5L);
        double rgb[3];
        CHECK(!ibl_reference_specular(it->ref, r[k], up, 1, rgb));
        CHECK_NEAR(rgb[1], (double)want, 1e-8);
        /* What is outside, to its own digits. */
        for (int i = 0; i < 3 * h; i++)
            it->env.data[3 * i] = 1 - it->env.data[3 * i + 1];
        CHECK(!ibl_reference_specular(it->ref, r[k], up, 1, rgb));
        const long double rest =
            (within(a2, 0.5L) - within(a2, s * s)) / within(a2, 0.5L);
        if (r[k] >= 0.01)
            CHECK_NEAR(rgb[0], (double)rest, 1e-6 * (double)rest);
    }
    subject_free(it);
}

/* A narrow lobe's direction between four pixels, at their corner, gets a
 * quarter of each if they are alike: at the equator by symmetry. */
static void four_pixels(void)
{
    subject *it = subject_make(1, 64, 32, 0, 0);
    const double front[3] = {1, 0, 0};
    double rgb[3];

    map_pixel(&it->env, 32, 16)[0] = 1e6f;
    CHECK(!ibl_reference_specular(it->ref, 1e-3, front, 1, rgb));
    CHECK_NEAR(rgb[0], 0.25e6, 1);
    for (double r = 0.02; r > 1e-20; r *= 1e-3) {
        map_pixel(&it->env, 31, 15)[1] = map_pixel(&it->env, 32, 15)[1] = 1;
        map_pixel(&it->env, 31, 16)[1] = map_pixel(&it->env, 32, 16)[1] = 1;
        CHECK(!ibl_reference_specular(it->ref, r, front, 1, rgb));
        CHECK_NEAR(rgb[1], 1, 1e-4);
    }
    subject_free(it);
}

/* A pixel of light against its weight over that of the sphere, 4 pi
 * within(1/2). */
static void one_pixel(void)
{
    subject *it = subject_make(2, 512, 256, 0, 0);
    const double r[] = {0.4, 0.6, 0.8};
    const int at[][2] = {{0, 0}, {511, 128}, {200, 70}, {300, 255}};

    for (int k = 0; k < 12; k++) {
        const int i = at[k / 3][0], j = at[k / 3][1];
        const lobe l = {1.1L, -0.8L, powl(r[k % 3], 4)};
        double d[3], rgb[3];
        polar_direction(1.1, -0.8, d);
        map_pixel(&it->env, i, j)[2] = 1e6f;
        const long double weight = patch_weight(&l, 512, 256, i, j, 64);
        const double want =
            (double)(1e6L * weight /
                     (4 * pi_l * l.a2 * l.a2 * within(l.a2, 0.5L)));
        CHECK(!ibl_reference_specular(it->ref, r[k % 3], d, 1, rgb));
        CHECK_NEAR(rgb[2], want, 1e-4 * want);
        map_pixel(&it->env, i, j)[2] = 0;
    }
    subject_free(it);
}

static void constant_map(void)
{
    const int sizes[][2] = {{1, 1}, {2, 1}, {1, 3}, {3, 2}, {31, 17}, {64, 32}};
    const double r[] = {0, 1e-30, 1e-4, 0.03, 0.3, 0.9, 1};
    test_random rnd = {9};

    for (int k = 0; k < 6; k++) {
        subject *it = subject_make(2, sizes[k][0], sizes[k][1], 0, 33);
        const double want = (double)0.7f;
        double d[9] = {0, 1, 0, 0, -1, 0}, rgb[9], mean[3];
        for (size_t i = 0; i < map_floats(&it->env); i++)
            it->env.data[i] = 0.7f;
        random_direction(&rnd, d + 6);
        for (int m = 0; m < 8; m++) {
            if (m < 7)
                CHECK(!ibl_reference_specular(it->ref, r[m], d, 3, rgb));
            else
                CHECK(!ibl_reference_irradiance(it->ref, d, 3, rgb));
            for (int c = 0; c < 9; c++)
                CHECK_NEAR(rgb[c], want, 1e-14);
        }
        CHECK(!ibl_reference_mean(it->ref, mean));
        CHECK_NEAR(mean[0], want, 1e-15);
        for (int n = 1; n <= 19; n += 6) {
            const ibl_texel t[3] = {
                {2, n / 2, n / 2}, {0, 0, n - 1}, {3, n - 1, 0}};
            CHECK(!ibl_reference_texels(it->ref, n, n, t, 3, rgb));
            for (int c = 0; c < 9; c++)
                CHECK_NEAR(rgb[c], want, 1e-14);
        }
        subject_free(it);
    }
}

/* Roughness 0 is the pixel; the end of 1e-4 is the middle of the same. */
static void mirror(void)
{
    subject *it = subject_make(2, 40, 20, 3, 90);

    for (int j = 0; j < 20; j++) {
        for (int i = 0; i < 40; i++) {
            const float *p = map_pixel(&it->env, i, j);
            double d[3], rgb[3];
            /* The map's azimuth is the world's and a quarter turn. */
            polar_direction(pi * (j + 0.3) / 20,
                            2 * pi * ((i + 0.6) / 40 - 0.75), d);
            CHECK(!ibl_reference_specular(it->ref, 0, d, 1, rgb));
            CHECK(rgb[0] == (double)p[0] && rgb[1] == (double)p[1] &&
                  rgb[2] == (double)p[2]);
            if (i % 7)
                continue;
            CHECK(!ibl_reference_specular(it->ref, 1e-5, d, 1, rgb));
            CHECK_NEAR(rgb[0], (double)p[0], 1e-7);
            CHECK(!ibl_reference_specular(it->ref, 1e-36, d, 1, rgb));
            CHECK_NEAR(rgb[0], (double)p[0], 1e-15);
        }
    }
    subject_free(it);
}

/* No step anywhere as r passes where pixels begin to be patches. */
static void continuous(void)
{
    subject *it = subject_make(2, 64, 32, 8, 0);
    double d[3], before[3], rgb[3], largest = 0;

    polar_direction(0.9, 1.9, d);
    CHECK(!ibl_reference_specular(it->ref, 0.3, d, 1, before));
    for (int k = 1; k <= 400; k++) {
        CHECK(!ibl_reference_specular(it->ref, 0.3 + 0.001 * k, d, 1, rgb));
        largest = fmax(largest, fabs(rgb[0] - before[0]) / before[0]);
        memcpy(before, rgb, sizeof rgb);
    }
    CHECK_MSG(largest < 0.01, "a step of %g", largest);
    subject_free(it);
}

/* ---- irradiance ------------------------------------------------------- */

/* L = 1 + d.a: its mean under the cosine lobe is 1 + 2/3 N.a; and under that
 * of a2, 1 + N.a times the lobe's mean cosine. */
static void linear_light(void)
{
    subject *it = subject_make(2, 512, 256, 0, 25);
    const double a[3] = {0.3, -0.5, 0.4};
    test_random rnd = {4};

    for (int j = 0; j < 256; j++) {
        for (int i = 0; i < 512; i++) {
            double d[3];
            polar_direction(pi * (j + 0.5) / 256,
                            2 * pi * ((i + 0.5) / 512 - 0.5) - 25 * pi / 180,
                            d);
            for (int c = 0; c < 3; c++)
                map_pixel(&it->env, i, j)[c] =
                    (float)(1 + d[0] * a[0] + d[1] * a[1] + d[2] * a[2]);
        }
    }
    for (int k = 0; k < 20; k++) {
        double d[3], rgb[3], one[3];
        random_direction(&rnd, d);
        const double na = d[0] * a[0] + d[1] * a[1] + d[2] * a[2];
        CHECK(!ibl_reference_irradiance(it->ref, d, 1, rgb));
        CHECK_NEAR(rgb[0], 1 + na * 2 / 3, 2e-5);
        CHECK(!ibl_reference_specular(it->ref, 1, d, 1, one));
        CHECK(same(rgb, one, 3));
        /* The mean of 1 - 2q, by 20,000 midpoints over q in 0..1/2. */
        double top = 0, bottom = 0;
        const double a2 = pow(0.6, 4);
        for (int m = 0; m < 20000; m++) {
            const double q = (m + 0.5) / 40000, t = q + a2 * (1 - q);
            const double w = (1 - 2 * q) / (t * t);
            top += w * (1 - 2 * q);
            bottom += w;
        }
        CHECK(!ibl_reference_specular(it->ref, 0.6, d, 1, rgb));
        CHECK_NEAR(rgb[1], 1 + na * top / bottom, 2e-5);
    }
    subject_free(it);
}

static void irradiance_sums(void)
{
    const int sizes[][2] = {{1, 1}, {2, 1}, {3, 2}, {33, 17}, {64, 32}};
    test_random rnd = {11};

    for (int k = 0; k < 15; k++) {
        const int w = sizes[k / 3][0], h = sizes[k / 3][1];
        const int sub = w < 4 ? 256 : 16;
        subject *it = subject_make(2, w, h, 20 + (uint64_t)k, 0);
        double d[3], rgb[3], coarse[3], fine[3];
        random_direction(&rnd, d);
        const double theta = atan2(hypot(d[0], d[2]), d[1]);
        const double phi = atan2(d[2], d[0]);
        expect(&it->env, 1, theta, phi, sub / 2, coarse);
        expect(&it->env, 1, theta, phi, sub, fine);
        CHECK(!ibl_reference_irradiance(it->ref, d, 1, rgb));
        for (int n = 0; n < 3; n++)
            CHECK_NEAR(rgb[n], fine[n],
                       1e-7 * fine[n] + 2 * fabs(fine[n] - coarse[n]));
        long double mean = 0;
        for (int i = 0; i < w * h; i++)
            mean += row_angle(w, h, i / w) *
                    map_pixel(&it->env, i % w, i / w)[0] / (4 * pi_l);
        CHECK(!ibl_reference_mean(it->ref, rgb));
        CHECK_NEAR(rgb[0], (double)mean, 1e-15);
        subject_free(it);
    }
}

/* ---- the rules of every call ------------------------------------------ */

static void threads(void)
{
    const int counts[] = {1, 2, 3, 7};
    double first[4][60], sh[3 * 81], dirs[60];
    test_random rnd = {6};

    for (int k = 0; k < 20; k++)
        random_direction(&rnd, dirs + 3 * k);
    for (int k = 0; k < 4; k++) {
        subject *it = subject_make(counts[k], 300, 151, 2, 5);
        double rgb[4][60], a[3 * 81];
        ibl_texel t[20];
        for (int m = 0; m < 20; m++)
            t[m] = (ibl_texel){m % 6, m, 19 - m};
        CHECK(!ibl_reference_specular(it->ref, 0.5, dirs, 20, rgb[0]));
        CHECK(!ibl_reference_specular(it->ref, 0.1, dirs, 20, rgb[1]));
        CHECK(!ibl_reference_irradiance(it->ref, dirs, 20, rgb[2]));
        CHECK(!ibl_reference_texels(it->ref, 20, 20, t, 20, rgb[3]));
        CHECK(!ibl_reference_sh(it->ref, 8, a));
        if (k == 0) {
            memcpy(first, rgb, sizeof rgb);
            memcpy(sh, a, sizeof a);
        }
        CHECK(same(first[0], rgb[0], 4 * 60));
        CHECK(same(sh, a, 3 * 81));
        subject_free(it);
    }
}

/* One direction alone or among others. */
static void alone(void)
{
    subject *it = subject_make(2, 90, 45, 2, 5);
    double dirs[60], rgb[60], one[3];
    test_random rnd = {6};

    for (int k = 0; k < 20; k++)
        random_direction(&rnd, dirs + 3 * k);
    CHECK(!ibl_reference_specular(it->ref, 0.3, dirs, 20, rgb));
    for (int k = 0; k < 20; k++) {
        CHECK(!ibl_reference_specular(it->ref, 0.3, dirs + 3 * k, 1, one));
        CHECK(same(one, rgb + 3 * k, 3));
    }
    CHECK(!ibl_reference_specular(it->ref, 0.3, dirs, 0, NULL));
    subject_free(it);
}

/* More directions than are summed at once. */
static void many(void)
{
    enum {
        MANY = 16384 + 9,
        SOME = 20
    };
    subject *it = subject_make(2, 8, 4, 2, 5);
    double *dirs = malloc(2 * 3 * MANY * sizeof *dirs);
    double *rgb = dirs + 3 * MANY;
    test_random rnd = {6};

    NEED(dirs);
    for (int k = 0; k < MANY; k++)
        if (k < SOME)
            random_direction(&rnd, dirs + 3 * k);
        else
            memcpy(dirs + 3 * k, dirs + 3 * (k % SOME), 3 * sizeof *dirs);
    CHECK(!ibl_reference_specular(it->ref, 0.01, dirs, MANY, rgb));
    for (int k = SOME; k < MANY; k++)
        CHECK(same(rgb + 3 * k, rgb + 3 * (k % SOME), 3));
    free(dirs);
    subject_free(it);
}

/* Pixels in four parts are what they were: within 1e-7 of a pixel's weight
 * where that is by a few points, and all digits but some near the aim. */
static void in_four(void)
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
            CHECK(!ibl_reference_specular(one->ref, roughness[m], d, 5, a));
            CHECK(!ibl_reference_specular(all->ref, roughness[m], d, 5, b));
            for (int i = 0; i < 15; i++)
                CHECK_NEAR(a[i], b[i], (m ? 1e-7 : 3e-10) * a[i]);
        }
        subject_free(one);
        subject_free(all);
    }
}

/* A sum of what rounds away. */
static void exact_sums(void)
{
    static const double terms[] = {1, 1e100, 1, -1e100};
    for (int k = 0; k < 4; k++) {
        ibl_exact sum = {0, 0};
        for (int i = 0; i < 4; i++)
            ibl_exact_add(&sum, terms[(i + k) % 4]);
        CHECK(ibl_exact_total(&sum) == 2);
    }
}

/* By the definition, and what is nothing has finite errors. */
static void relative_errors(void)
{
    const double rgb[3] = {3, 4, 0}, far[3] = {6, 8, 0}, none[3] = {0};
    const double mean[3] = {0, 0, 5};

    CHECK_NEAR(ibl_relative_error(rgb, far, mean), 0.5, 1e-15);
    CHECK_NEAR(ibl_relative_error(rgb, none, mean), 1 / IBL_RELATIVE_FLOOR,
               1e-9);
    CHECK(ibl_relative_error(none, none, none) == 0);
    CHECK(isfinite(ibl_relative_error(rgb, none, none)));
}

static ibl_ctx *quiet(void)
{
    ibl_ctx *ctx = NULL;

    if (ibl_ctx_create(NULL, &ctx))
        exit(1);
    return ctx;
}

static void bad_arguments(void)
{
    ibl_ctx *ctx = quiet();
    ibl_image env = map_constant(ctx, 8, 4, 1), none = {0};
    ibl_reference *ref = NULL;
    const double up[3] = {0, 1, 0}, zero[3] = {0}, nan3[3] = {NAN, 0, 1};
    double rgb[3] = {7, 7, 7}, a[3];
    const ibl_texel bad[4] = {{6, 0, 0}, {0, 4, 0}, {0, 0, -1}, {-1, 0, 0}};

    CHECK(ibl_reference_create(ctx, &none, 0, &ref) == IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_create(ctx, &env, INFINITY, &ref) == IBL_ERR_ARGUMENT);
    CHECK(!ref);
    NEED(!ibl_reference_create(ctx, &env, -1000, &ref));
    CHECK(ibl_reference_specular(ref, -0.1, up, 1, rgb) == IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_specular(ref, 1.1, up, 1, rgb) == IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_specular(ref, NAN, up, 1, rgb) == IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_specular(ref, 0.5, zero, 1, rgb) == IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_irradiance(ref, nan3, 1, rgb) == IBL_ERR_ARGUMENT);
    for (int k = 0; k < 4; k++)
        CHECK(ibl_reference_texels(ref, 4, 4, &bad[k], 1, rgb) ==
              IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_texels(ref, 1, 0, bad, 0, rgb) == IBL_ERR_ARGUMENT);
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
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static void cancel(void)
{
    ibl_ctx *ctx = quiet();
    ibl_image env = map_constant(ctx, 64, 32, 1);
    ibl_reference *ref = NULL;
    const double up[3] = {0, 1, 0};
    const ibl_texel t = {0, 0, 0};
    double out[27];

    NEED(!ibl_reference_create(ctx, &env, 0, &ref));
    ibl_ctx_cancel(ctx);
    for (int k = 0; k < 3; k++)
        CHECK(ibl_reference_specular(ref, 0.05 * k, up, 1, out) ==
              IBL_ERR_CANCELLED);
    CHECK(ibl_reference_irradiance(ref, up, 1, out) == IBL_ERR_CANCELLED);
    CHECK(ibl_reference_texels(ref, 4, 4, &t, 1, out) == IBL_ERR_CANCELLED);
    CHECK(ibl_reference_sh(ref, 2, out) == IBL_ERR_CANCELLED);
    CHECK(ibl_reference_mean(ref, out) == IBL_ERR_CANCELLED);
    CHECK(ibl_reference_lut(ctx, 1, 1, IBL_GEOMETRY_SMITH, out) ==
          IBL_ERR_CANCELLED);
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static const test tests[] = {TEST(specular_wide),   TEST(specular_narrow),
                             TEST(edge_on_horizon), TEST(one_cap),
                             TEST(four_pixels),     TEST(one_pixel),
                             TEST(constant_map),    TEST(mirror),
                             TEST(continuous),      TEST(linear_light),
                             TEST(irradiance_sums), TEST(threads),
                             TEST(alone),           TEST(many),
                             TEST(exact_sums),      TEST(in_four),
                             TEST(relative_errors), TEST(bad_arguments),
                             TEST(cancel)};

TEST_MAIN(tests)
