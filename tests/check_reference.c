/* SPDX-License-Identifier: MIT */
/*
 * The reference against closed forms and against sums in long double that are
 * written out here from the conventions in ibl/ibl.h; never against a bake.
 */
#include "ibl/reference.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "test.h"

static const double pi = 3.14159265358979323846;
static const long double pi_l = 3.14159265358979323846264338327950288L;

/* ---- maps ------------------------------------------------------------- */

static ibl_image make_map(ibl_ctx *ctx, int w, int h, float value)
{
    ibl_image env = {0};

    if (ibl_image_alloc(ctx, w, h, &env))
        exit(1);
    for (size_t k = 0; k < 3 * (size_t)w * (size_t)h; k++)
        env.data[k] = value;
    return env;
}

static ibl_image make_random(ibl_ctx *ctx, int w, int h, uint64_t seed)
{
    ibl_image env = make_map(ctx, w, h, 0);
    test_random rnd = {seed};

    for (size_t k = 0; k < 3 * (size_t)w * (size_t)h; k++)
        env.data[k] = (float)pow(test_random_unit(&rnd), 6.0);
    return env;
}

static float *pixel(const ibl_image *env, int i, int j)
{
    return env->data + 3 * ((size_t)j * (size_t)env->width + (size_t)i);
}

static ibl_reference *make(ibl_ctx *ctx, const ibl_image *env, double yaw)
{
    ibl_reference *ref = NULL;

    if (ibl_reference_create(ctx, env, yaw, &ref))
        exit(1);
    return ref;
}

static void direction(double theta, double phi, double d[3])
{
    d[0] = sin(theta) * cos(phi);
    d[1] = cos(theta);
    d[2] = sin(theta) * sin(phi);
}

static void random_direction(test_random *rnd, double d[3])
{
    direction(acos(2 * test_random_unit(rnd) - 1),
              2 * pi * test_random_unit(rnd), d);
}

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

static long double row_angle(int w, int h, int j)
{
    return 2 * pi_l / w * 2 * sinl(pi_l * (j + 0.5L) / h) * sinl(pi_l / 2 / h);
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
    const long double p = fmaxl(pi_l / h, 2 * pi_l / w);
    long double sum[4] = {0};

    for (int j = 0; j < h; j++) {
        for (int i = 0; i < w; i++) {
            const long double t_c = pi_l * (j + 0.5L) / h;
            const long double p_c = 2 * pi_l * ((i + 0.5L) / w - 0.5L);
            const long double a = sinl((t_c - l.theta) / 2);
            const long double b = sinl((p_c - l.phi) / 2);
            const long double q = a * a + sinl(t_c) * sinl(l.theta) * b * b;
            const long double t = q + l.a2 * (1 - q);
            /* 2 sqrt(t) from 8 p down to 4 p, in t. */
            const long double s =
                fminl(1, fmaxl(0, (16 * p * p - t) / (12 * p * p)));
            const long double mix = s * s * (3 - 2 * s);
            long double weight =
                (1 - mix) * lobe_at(&l, t_c, p_c) * row_angle(w, h, j);
            if (mix > 0)
                weight += mix * patch_weight(&l, w, h, i, j, sub);
            for (int c = 0; c < 3; c++)
                sum[c] += weight * pixel(env, i, j)[c];
            sum[3] += weight;
        }
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = (double)(sum[c] / sum[3]);
}

/* The change that halving the points' step still makes, four times the error
 * that is left, is the tolerance. */
static void compare_specular(int w, int h, double roughness, double theta,
                             double phi, int sub)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = make_random(ctx, w, h, 5);
    ibl_reference *ref = make(ctx, &env, 0);
    double d[3], rgb[3], coarse[3], fine[3];

    direction(theta, phi, d);
    CHECK(!ibl_reference_specular(ref, roughness, d, 1, rgb));
    expect(&env, roughness, theta, phi, sub / 2, coarse);
    expect(&env, roughness, theta, phi, sub, fine);
    for (int c = 0; c < 3; c++) {
        const double tol = 1e-7 * fine[c] + fabs(fine[c] - coarse[c]);
        CHECK_MSG(fabs(rgb[c] - fine[c]) <= tol,
                  "%dx%d r %g at (%g, %g): %.12g, not %.12g +- %.2g", w, h,
                  roughness, theta, phi, rgb[c], fine[c], tol);
    }
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static void specular_wide(void)
{
    const double r[] = {1, 0.7, 0.5};

    for (int k = 0; k < 3; k++) {
        compare_specular(128, 64, r[k], 1.234, 0.567, 0);
        compare_specular(101, 67, r[k], 0, 0, 0);
        compare_specular(128, 64, r[k], pi, 2, 0);
        compare_specular(113, 64, r[k], 0.01, -3.1415, 0);
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
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const double r[] = {0.4, 0.3, 0.2, 0.1, 0.01, 1e-4, 1e-9};
    /* One row of many: patches throughout, for p is half the circle. */
    const int h = 64, lit = 3;
    ibl_image env = make_map(ctx, 3, h, 0);
    ibl_reference *ref = make(ctx, &env, 77);
    const double up[3] = {0, 1, 0};

    for (int j = 0; j < lit; j++) {
        for (int i = 0; i < 3; i++)
            pixel(&env, i, j)[1] = 1;
    }
    const long double s = sinl(pi_l / 2 * lit / h);
    for (int k = 0; k < 7; k++) {
        const long double a2 = powl(r[k], 4);
        const long double want = within(a2, s * s) / within(a2, 0.5L);
        double rgb[3];
        CHECK(!ibl_reference_specular(ref, r[k], up, 1, rgb));
        CHECK_NEAR(rgb[1], (double)want, 1e-8);
        /* What is outside, to its own digits. */
        for (int i = 0; i < 3 * h; i++)
            env.data[3 * i] = 1 - env.data[3 * i + 1];
        CHECK(!ibl_reference_specular(ref, r[k], up, 1, rgb));
        const long double rest =
            (within(a2, 0.5L) - within(a2, s * s)) / within(a2, 0.5L);
        if (r[k] >= 0.01)
            CHECK_NEAR(rgb[0], (double)rest, 1e-6 * (double)rest);
    }
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

/* A narrow lobe's direction between four pixels, at their corner, gets a
 * quarter of each if they are alike: at the equator by symmetry. */
static void four_pixels(void)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_image env = make_map(ctx, 64, 32, 0);
    ibl_reference *ref = make(ctx, &env, 0);
    const double front[3] = {1, 0, 0};
    double rgb[3];

    pixel(&env, 32, 16)[0] = 1e6f;
    CHECK(!ibl_reference_specular(ref, 1e-3, front, 1, rgb));
    CHECK_NEAR(rgb[0], 0.25e6, 1);
    for (double r = 0.02; r > 1e-20; r *= 1e-3) {
        pixel(&env, 31, 15)[1] = pixel(&env, 32, 15)[1] = 1;
        pixel(&env, 31, 16)[1] = pixel(&env, 32, 16)[1] = 1;
        CHECK(!ibl_reference_specular(ref, r, front, 1, rgb));
        CHECK_NEAR(rgb[1], 1, 1e-4);
    }
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

/* A pixel of light against its weight over that of all, the sum itself. The
 * lobe is wide: weight at the centre, and all of it near the integral over the
 * sphere, 4 pi within(1/2). */
static void one_pixel(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = make_map(ctx, 512, 256, 0);
    ibl_reference *ref = make(ctx, &env, 0);
    const double r[] = {0.4, 0.6, 0.8};
    const int at[][2] = {{0, 0}, {511, 128}, {200, 70}, {300, 255}};

    for (int k = 0; k < 12; k++) {
        const int i = at[k / 3][0], j = at[k / 3][1];
        const lobe l = {1.1L, -0.8L, powl(r[k % 3], 4)};
        double d[3], rgb[3];
        direction(1.1, -0.8, d);
        pixel(&env, i, j)[2] = 1e6f;
        const long double weight =
            lobe_at(&l, pi_l * (j + 0.5L) / 256,
                    2 * pi_l * ((i + 0.5L) / 512 - 0.5L)) *
            row_angle(512, 256, j);
        const double want =
            (double)(1e6L * weight /
                     (4 * pi_l * l.a2 * l.a2 * within(l.a2, 0.5L)));
        CHECK(!ibl_reference_specular(ref, r[k % 3], d, 1, rgb));
        CHECK_NEAR(rgb[2], want, 1e-4 * want);
        pixel(&env, i, j)[2] = 0;
    }
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static void constant_map(void)
{
    const int sizes[][2] = {{1, 1}, {2, 1}, {1, 3}, {3, 2}, {31, 17}, {64, 32}};
    const double r[] = {0, 1e-30, 1e-4, 0.03, 0.3, 0.9, 1};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {9};

    for (int k = 0; k < 6; k++) {
        ibl_image env = make_map(ctx, sizes[k][0], sizes[k][1], 0.7f);
        ibl_reference *ref = make(ctx, &env, 33);
        const double want = (double)0.7f;
        double d[9] = {0, 1, 0, 0, -1, 0}, rgb[9], mean[3];
        random_direction(&rnd, d + 6);
        for (int m = 0; m < 8; m++) {
            if (m < 7)
                CHECK(!ibl_reference_specular(ref, r[m], d, 3, rgb));
            else
                CHECK(!ibl_reference_irradiance(ref, d, 3, rgb));
            for (int c = 0; c < 9; c++)
                CHECK_NEAR(rgb[c], want, 1e-14);
        }
        CHECK(!ibl_reference_mean(ref, mean));
        CHECK_NEAR(mean[0], want, 1e-15);
        for (int n = 1; n <= 19; n += 6) {
            const ibl_texel t[3] = {
                {2, n / 2, n / 2}, {0, 0, n - 1}, {3, n - 1, 0}};
            CHECK(!ibl_reference_texels(ref, n, t, 3, rgb));
            for (int c = 0; c < 9; c++)
                CHECK_NEAR(rgb[c], want, 1e-14);
        }
        ibl_reference_free(ref);
        ibl_image_free(&env);
    }
    ibl_ctx_free(ctx);
}

/* Roughness 0 is the pixel; the end of 1e-4 is the middle of the same. */
static void mirror(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = make_random(ctx, 40, 20, 3);
    ibl_reference *ref = make(ctx, &env, 90);

    for (int j = 0; j < 20; j++) {
        for (int i = 0; i < 40; i++) {
            const float *p = pixel(&env, i, j);
            double d[3], rgb[3];
            /* The map's azimuth is the world's and a quarter turn. */
            direction(pi * (j + 0.3) / 20, 2 * pi * ((i + 0.6) / 40 - 0.75), d);
            CHECK(!ibl_reference_specular(ref, 0, d, 1, rgb));
            CHECK(rgb[0] == (double)p[0] && rgb[1] == (double)p[1] &&
                  rgb[2] == (double)p[2]);
            if (i % 7)
                continue;
            CHECK(!ibl_reference_specular(ref, 1e-5, d, 1, rgb));
            CHECK_NEAR(rgb[0], (double)p[0], 1e-7);
            CHECK(!ibl_reference_specular(ref, 1e-36, d, 1, rgb));
            CHECK_NEAR(rgb[0], (double)p[0], 1e-15);
        }
    }
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

/* No step anywhere as r passes where pixels begin to be patches. */
static void continuous(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = make_random(ctx, 64, 32, 8);
    ibl_reference *ref = make(ctx, &env, 0);
    double d[3], before[3], rgb[3], largest = 0;

    direction(0.9, 1.9, d);
    CHECK(!ibl_reference_specular(ref, 0.3, d, 1, before));
    for (int k = 1; k <= 400; k++) {
        CHECK(!ibl_reference_specular(ref, 0.3 + 0.001 * k, d, 1, rgb));
        largest = fmax(largest, fabs(rgb[0] - before[0]) / before[0]);
        memcpy(before, rgb, sizeof rgb);
    }
    CHECK_MSG(largest < 0.01, "a step of %g", largest);
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

/* ---- irradiance ------------------------------------------------------- */

/* L = 1 + d.a: its mean under the cosine lobe is 1 + 2/3 N.a; and under that
 * of a2, 1 + N.a times the lobe's mean cosine. */
static void linear_light(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = make_map(ctx, 512, 256, 0);
    ibl_reference *ref = make(ctx, &env, 25);
    const double a[3] = {0.3, -0.5, 0.4};
    test_random rnd = {4};

    for (int j = 0; j < 256; j++) {
        for (int i = 0; i < 512; i++) {
            double d[3];
            direction(pi * (j + 0.5) / 256,
                      2 * pi * ((i + 0.5) / 512 - 0.5) - 25 * pi / 180, d);
            for (int c = 0; c < 3; c++)
                pixel(&env, i, j)[c] =
                    (float)(1 + d[0] * a[0] + d[1] * a[1] + d[2] * a[2]);
        }
    }
    for (int k = 0; k < 20; k++) {
        double d[3], rgb[3], one[3];
        random_direction(&rnd, d);
        const double na = d[0] * a[0] + d[1] * a[1] + d[2] * a[2];
        CHECK(!ibl_reference_irradiance(ref, d, 1, rgb));
        CHECK_NEAR(rgb[0], 1 + na * 2 / 3, 2e-5);
        CHECK(!ibl_reference_specular(ref, 1, d, 1, one));
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
        CHECK(!ibl_reference_specular(ref, 0.6, d, 1, rgb));
        CHECK_NEAR(rgb[1], 1 + na * top / bottom, 2e-5);
    }
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static void irradiance_sums(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const int sizes[][2] = {{1, 1}, {2, 1}, {3, 2}, {33, 17}, {64, 32}};
    test_random rnd = {11};

    for (int k = 0; k < 25; k++) {
        const int w = sizes[k / 5][0], h = sizes[k / 5][1];
        ibl_image env = make_random(ctx, w, h, 20 + (uint64_t)k);
        ibl_reference *ref = make(ctx, &env, 0);
        double d[3], rgb[3];
        long double sum[4] = {0}, mean[3] = {0};
        random_direction(&rnd, d);
        for (int j = 0; j < h; j++) {
            for (int i = 0; i < w; i++) {
                const long double theta = pi_l * (j + 0.5L) / h;
                const long double phi = 2 * pi_l * ((i + 0.5L) / w - 0.5L);
                const long double c = d[0] * sinl(theta) * cosl(phi) +
                                      d[1] * cosl(theta) +
                                      d[2] * sinl(theta) * sinl(phi);
                const long double o = row_angle(w, h, j);
                for (int n = 0; n < 3; n++) {
                    sum[n] += fmaxl(c, 0) * o * pixel(&env, i, j)[n];
                    mean[n] += o * pixel(&env, i, j)[n] / (4 * pi_l);
                }
                sum[3] += fmaxl(c, 0) * o;
            }
        }
        CHECK(!ibl_reference_irradiance(ref, d, 1, rgb));
        for (int n = 0; n < 3; n++) {
            const double want =
                (double)(sum[3] > 0 ? sum[n] / sum[3] : mean[n]);
            CHECK_NEAR(rgb[n], want, 1e-12);
        }
        CHECK(!ibl_reference_mean(ref, rgb));
        CHECK_NEAR(rgb[0], (double)mean[0], 1e-15);
        ibl_reference_free(ref);
        ibl_image_free(&env);
    }
    ibl_ctx_free(ctx);
}

/* ---- level 0 ---------------------------------------------------------- */

/* The cube rule. */
static void cube_point(int face, double u, double v, double d[3])
{
    const double rule[6][3] = {{1, -v, -u}, {-1, -v, u}, {u, 1, v},
                               {u, -1, -v}, {u, -v, 1},  {-u, -v, -1}};
    memcpy(d, rule[face], sizeof rule[face]);
}

/* b by midpoints, between rows j and j + 1 of h; kept until another is asked
 * for. */
static double bend(int h, int j)
{
    static int of[64];
    static double value[64];
    double missing = 0, room = 0;

    if (of[j] == h)
        return value[j];
    for (int k = 0; k < 4000; k++) {
        const double t = (k + 0.5) / 4000, s = sin(pi * (j + 0.5 + t) / h);
        missing += ((t > 0.5) - t) * s;
        room += t * (1 - t) * s;
    }
    of[j] = h;
    return value[j] = missing / room;
}

static double map_value(const ibl_image *env, double theta, double phi,
                        bool linear_x, bool linear_y)
{
    const int w = env->width, h = env->height;
    const double y = theta / pi * h - (linear_y ? 0.5 : 0), j = floor(y);
    const bool inside = linear_y && j >= 0 && j < h - 1;
    const double t = y - j;
    const double lower = t + (inside ? bend(h, (int)j) * t * (1 - t) : 0);
    double sum = 0;

    for (int k = 0; k < (linear_y ? 2 : 1); k++) {
        int row = (int)j + k;
        const bool beyond = row < 0 || row >= h;
        const double weight = linear_y ? (k ? lower : 1 - lower) : 1;
        const double x = (phi / (2 * pi) + 0.5 + (beyond ? 0.5 : 0)) * w -
                         (linear_x ? 0.5 : 0);
        const int left = (int)floor(x);
        const double f = linear_x ? x - floor(x) : 0;
        row = row < 0 ? 0 : row >= h ? h - 1 : row;
        sum +=
            weight * ((1 - f) * (double)pixel(env, (left + 2 * w) % w, row)[0] +
                      f * (double)pixel(env, (left + 1 + 2 * w) % w, row)[0]);
    }
    return sum;
}

/* The mean over a texel by sub x sub points of (u, v), each with its solid
 * angle's density. */
static double texel_points(const ibl_image *env, int n, ibl_texel t, double yaw,
                           int sub)
{
    double sum = 0, weights = 0;

    for (int b = 0; b < sub; b++) {
        for (int a = 0; a < sub; a++) {
            double d[3];
            const double u = 2 * (t.x + (a + 0.5) / sub) / n - 1;
            const double v = 2 * (t.y + (b + 0.5) / sub) / n - 1;
            const double density = pow(1 + u * u + v * v, -1.5);
            cube_point(t.face, u, v, d);
            const double phi = remainder(atan2(d[2], d[0]) + yaw, 2 * pi);
            sum += density * map_value(env, atan2(hypot(d[0], d[2]), d[1]), phi,
                                       env->width < 4 * n, env->height < 2 * n);
            weights += density;
        }
    }
    return sum / weights;
}

static void compare_texels(int w, int h, int n, double yaw_deg, int sub,
                           double tol)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = make_random(ctx, w, h, 77);
    ibl_reference *ref = make(ctx, &env, yaw_deg);

    for (int face = 0; face < 6; face++) {
        const ibl_texel t[3] = {
            {face, n / 2, n / 2}, {face, 0, n - 1}, {face, n / 3, n / 4}};
        double rgb[9];
        CHECK(!ibl_reference_texels(ref, n, t, 3, rgb));
        for (int k = 0; k < 3; k++) {
            const double want =
                texel_points(&env, n, t[k], yaw_deg / 180 * pi, sub);
            CHECK_MSG(fabs(rgb[3 * k] - want) <= tol,
                      "%dx%d to %d, face %d (%d, %d): %.9g, not %.9g", w, h, n,
                      face, t[k].x, t[k].y, rgb[3 * k], want);
        }
    }
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

/* Points see the boundaries of patches to a point's share of a texel; smooth
 * values to the square of their spacing. */
static void texels(void)
{
    compare_texels(32, 16, 1, 0, 400, 1e-3);
    compare_texels(64, 32, 8, 20, 300, 1e-3);
    compare_texels(67, 35, 5, -50, 300, 1e-3);
    compare_texels(16, 8, 16, 0, 100, 2e-5);
    compare_texels(5, 3, 7, 130, 100, 2e-5);
    compare_texels(1, 1, 3, 0, 40, 1e-6);
    compare_texels(2, 1, 4, 10, 100, 2e-5);
    compare_texels(40, 64, 12, 10, 300, 1e-3);
    compare_texels(64, 8, 8, 10, 300, 1e-3);
}

/* All texels, by their solid angles, make the mean of the source. */
static void texels_energy(void)
{
    const int sizes[][3] = {{37, 19, 9}, {64, 32, 16}, {33, 70, 7},
                            {16, 8, 16}, {5, 3, 7},    {1, 2, 5},
                            {6, 1, 4},   {9, 40, 12}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int k = 0; k < 8; k++) {
        const int n = sizes[k][2];
        ibl_image env = make_random(ctx, sizes[k][0], sizes[k][1], 31);
        ibl_reference *ref = make(ctx, &env, 12.5);
        double sum[3] = {0}, mean[3];
        for (int j = 0; j < 6 * n * n; j++) {
            const ibl_texel t = {j / (n * n), j % n, j / n % n};
            double rgb[3];
            CHECK(!ibl_reference_texels(ref, n, &t, 1, rgb));
            /* Corners' asin(uv / ...) in the form of an atan. */
            const double u[2] = {2.0 * t.x / n - 1, 2.0 * (t.x + 1) / n - 1};
            const double v[2] = {2.0 * t.y / n - 1, 2.0 * (t.y + 1) / n - 1};
            double angle = 0;
            for (int c = 0; c < 4; c++) {
                const double a = u[c % 2], b = v[c / 2];
                angle += (c == 0 || c == 3 ? 1 : -1) *
                         atan2(a * b, sqrt(1 + a * a + b * b));
            }
            for (int c = 0; c < 3; c++)
                sum[c] += rgb[c] * angle / (4 * pi);
        }
        CHECK(!ibl_reference_mean(ref, mean));
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(sum[c], mean[c], 1e-9);
        ibl_reference_free(ref);
        ibl_image_free(&env);
    }
    ibl_ctx_free(ctx);
}

/* ---- spherical harmonics ---------------------------------------------- */

/* Y_lm sampled on the map gives 1 at (l, m) and little elsewhere; l <= 3 from
 * the Cartesian polynomials. */
static double harmonic(int k, const double d[3])
{
    const double x = d[0], y = d[1], z = d[2];
    const double s[16] = {0.28209479177387814,
                          0.48860251190291992 * y,
                          0.48860251190291992 * z,
                          0.48860251190291992 * x,
                          1.0925484305920792 * x * y,
                          1.0925484305920792 * y * z,
                          0.31539156525252005 * (3 * z * z - 1),
                          1.0925484305920792 * x * z,
                          0.54627421529603959 * (x * x - y * y),
                          0.59004358992664352 * y * (3 * x * x - y * y),
                          2.8906114426405538 * x * y * z,
                          0.45704579946446572 * y * (5 * z * z - 1),
                          0.3731763325901154 * z * (5 * z * z - 3),
                          0.45704579946446572 * x * (5 * z * z - 1),
                          1.4453057213202769 * z * (x * x - y * y),
                          0.59004358992664352 * x * (x * x - 3 * y * y)};

    return s[k];
}

static void orthonormal(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = make_map(ctx, 256, 128, 0);
    ibl_reference *ref = make(ctx, &env, -70);

    for (int k = 0; k < 16; k++) {
        double a[3 * 36];
        for (int j = 0; j < 128; j++) {
            for (int i = 0; i < 256; i++) {
                double d[3];
                direction(pi * (j + 0.5) / 128,
                          2 * pi * ((i + 0.5) / 256 - 0.5) + 70 * pi / 180, d);
                pixel(&env, i, j)[1] = (float)harmonic(k, d);
            }
        }
        CHECK(!ibl_reference_sh(ref, 5, a));
        for (int m = 0; m < 36; m++) {
            CHECK_NEAR(a[3 * m + 1], m == k, 1e-3);
            CHECK(a[3 * m] == 0);
        }
    }
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

/* One pixel's coefficients are L dO Y, and by the addition theorem the sum of
 * the squares of a degree is (2l + 1) / 4 pi (L dO)^2. */
static void addition_theorem(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const int at[][2] = {{0, 0}, {17, 9}, {36, 18}, {5, 13}};
    double *a = malloc(3 * 65 * 65 * sizeof *a);

    NEED(a);
    for (int k = 0; k < 4; k++) {
        const int i = at[k][0], j = at[k][1];
        ibl_image env = make_map(ctx, 37, 19, 0);
        ibl_reference *ref = make(ctx, &env, 15);
        const double flux = 1000 * (double)row_angle(37, 19, j);
        double d[3];
        pixel(&env, i, j)[2] = 1000;
        direction(pi * (j + 0.5) / 19,
                  2 * pi * ((i + 0.5) / 37 - 0.5) - 15 * pi / 180, d);
        CHECK(!ibl_reference_sh(ref, 64, a));
        for (int m = 0; m < 16; m++)
            CHECK_NEAR(a[3 * m + 2], flux * harmonic(m, d), 1e-11);
        for (int l = 0; l <= 64; l++) {
            double sum = 0;
            for (int m = l * l; m < (l + 1) * (l + 1); m++)
                sum += a[3 * m + 2] * a[3 * m + 2];
            CHECK_NEAR(sum / (flux * flux) * 4 * pi / (2 * l + 1), 1, 1e-11);
        }
        ibl_reference_free(ref);
        ibl_image_free(&env);
    }
    free(a);
    ibl_ctx_free(ctx);
}

/* ---- the table -------------------------------------------------------- */

static void lut(ibl_ctx *ctx, double nv, double r, ibl_geometry g,
                double out[2])
{
    out[0] = out[1] = NAN;
    CHECK(!ibl_reference_lut(ctx, nv, r, g, out));
}

static void lut_mirror(void)
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
    ibl_ctx_free(ctx);
}

/*
 * N.V = 1: V.H = N.H = c with N.L = 2 c^2 - 1 and dL = 4 c dH, so that both
 * integrals are ones over c alone, taken here by many midpoints in long
 * double. At alpha = 1 Smith's G / (N.L N.V) is 2 / (N.L + 1) = 1 / c^2, and
 * R + G is the integral from sqrt(1/2) to 1 of 4c - 2/c, 1 - ln 2.
 */
static void lut_straight(void)
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
    ibl_ctx_free(ctx);
}

/* alpha = 1: D = 1/pi, Smith's vis 1 / (2 (N.L + N.V)), so
 *     R + G = integral of 2 x / (2 (x + nv)) dx = 1 - nv ln((1 + nv) / nv),
 * and Schlick's, k = 1/2, 1 / ((x + 1) (nv + 1)):
 *     integral of 2 x / ((x + 1) (nv + 1)) dx = 2 (1 - ln 2) / (nv + 1). */
static void lut_rough(void)
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
    ibl_ctx_free(ctx);
}

/* Any point, by midpoints over the hemisphere of L. */
static void lut_hemisphere(void)
{
    const double points[][2] = {{0.9, 0.9}, {0.5, 0.7}, {0.2, 0.8}, {0.05, 1}};
    const int n = 800;
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);

    for (int k = 0; k < 4; k++) {
        const double nv = points[k][0], r = points[k][1];
        const double a2 = pow(r, 4), sv = sqrt(1 - nv * nv);
        double sum[2] = {0}, out[2];
        for (int j = 0; j < n; j++) {
            const double x = (j + 0.5) / n, nl = x * x; /* dense at 0 */
            const double sl = sqrt(1 - nl * nl);
            for (int i = 0; i < n / 2; i++) {
                const double phi = pi * (i + 0.5) / (n / 2);
                const double vl = nv * nl + sv * sl * cos(phi);
                const double vh = sqrt(0.5 * (1 + vl)), nh = (nl + nv) / 2 / vh;
                const double t = nh * nh * (a2 - 1) + 1;
                const double vis = 0.5 / (nl * sqrt(nv * nv * (1 - a2) + a2) +
                                          nv * sqrt(nl * nl * (1 - a2) + a2));
                const double f =
                    a2 / (pi * t * t) * vis * nl * 2 * x / n * 2 * pi / (n / 2);
                sum[0] += f * (1 - pow(1 - vh, 5));
                sum[1] += f * pow(1 - vh, 5);
            }
        }
        lut(ctx, nv, r, IBL_GEOMETRY_SMITH, out);
        CHECK_NEAR(out[0], sum[0], 2e-5);
        CHECK_NEAR(out[1], sum[1], 2e-5);
    }
    ibl_ctx_free(ctx);
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
        ibl_ctx *ctx = test_ctx(counts[k], IBL_ISA_AUTO);
        ibl_image env = make_random(ctx, 300, 151, 2);
        ibl_reference *ref = make(ctx, &env, 5);
        double rgb[4][60], a[3 * 81];
        ibl_texel t[20];
        for (int m = 0; m < 20; m++)
            t[m] = (ibl_texel){m % 6, m, 19 - m};
        CHECK(!ibl_reference_specular(ref, 0.5, dirs, 20, rgb[0]));
        CHECK(!ibl_reference_specular(ref, 0.1, dirs, 20, rgb[1]));
        CHECK(!ibl_reference_irradiance(ref, dirs, 20, rgb[2]));
        CHECK(!ibl_reference_texels(ref, 20, t, 20, rgb[3]));
        CHECK(!ibl_reference_sh(ref, 8, a));
        if (k == 0) {
            memcpy(first, rgb, sizeof rgb);
            memcpy(sh, a, sizeof a);
        }
        CHECK(same(first[0], rgb[0], 4 * 60));
        CHECK(same(sh, a, 3 * 81));
        ibl_reference_free(ref);
        ibl_image_free(&env);
        ibl_ctx_free(ctx);
    }
}

/* One direction alone or among others. */
static void alone(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = make_random(ctx, 90, 45, 2);
    ibl_reference *ref = make(ctx, &env, 5);
    double dirs[60], rgb[60], one[3];
    test_random rnd = {6};

    for (int k = 0; k < 20; k++)
        random_direction(&rnd, dirs + 3 * k);
    CHECK(!ibl_reference_specular(ref, 0.3, dirs, 20, rgb));
    for (int k = 0; k < 20; k++) {
        CHECK(!ibl_reference_specular(ref, 0.3, dirs + 3 * k, 1, one));
        CHECK(same(one, rgb + 3 * k, 3));
    }
    CHECK(!ibl_reference_specular(ref, 0.3, dirs, 0, NULL));
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
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
    ibl_image env = make_map(ctx, 8, 4, 1), none = {0};
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
        CHECK(ibl_reference_texels(ref, 4, &bad[k], 1, rgb) ==
              IBL_ERR_ARGUMENT);
    CHECK(ibl_reference_texels(ref, 0, bad, 0, rgb) == IBL_ERR_ARGUMENT);
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
    ibl_image env = make_map(ctx, 64, 32, 1);
    ibl_reference *ref = make(ctx, &env, 0);
    const double up[3] = {0, 1, 0};
    const ibl_texel t = {0, 0, 0};
    double out[27];

    ibl_ctx_cancel(ctx);
    for (int k = 0; k < 3; k++)
        CHECK(ibl_reference_specular(ref, 0.05 * k, up, 1, out) ==
              IBL_ERR_CANCELLED);
    CHECK(ibl_reference_irradiance(ref, up, 1, out) == IBL_ERR_CANCELLED);
    CHECK(ibl_reference_texels(ref, 4, &t, 1, out) == IBL_ERR_CANCELLED);
    CHECK(ibl_reference_sh(ref, 2, out) == IBL_ERR_CANCELLED);
    CHECK(ibl_reference_mean(ref, out) == IBL_ERR_CANCELLED);
    CHECK(ibl_reference_lut(ctx, 1, 1, IBL_GEOMETRY_SMITH, out) ==
          IBL_ERR_CANCELLED);
    ibl_reference_free(ref);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static const test tests[] = {
    TEST(specular_wide),  TEST(specular_narrow), TEST(edge_on_horizon),
    TEST(one_cap),        TEST(four_pixels),     TEST(one_pixel),
    TEST(constant_map),   TEST(mirror),          TEST(continuous),
    TEST(linear_light),   TEST(irradiance_sums), TEST(texels),
    TEST(texels_energy),  TEST(orthonormal),     TEST(addition_theorem),
    TEST(lut_mirror),     TEST(lut_straight),    TEST(lut_rough),
    TEST(lut_hemisphere), TEST(threads),         TEST(alone),
    TEST(bad_arguments),  TEST(cancel)};

TEST_MAIN(tests)
