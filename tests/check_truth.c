/* SPDX-License-Identifier: MIT */
/*
 * The truth itself, against closed forms and against plainer sums, long
 * double where precision could matter; the library is not called.
 */
#include "test.h"
#include "truth.h"

#include <math.h>
#include <stdlib.h>

static const long double pil = 3.14159265358979323846264338327950288L;

static ibl_image map_new(int w, int h)
{
    ibl_image env = {w, h,
                     test_alloc((size_t)w * (size_t)h, 3 * sizeof(float))};
    return env;
}

static float *texel(const ibl_image *env, int i, int j)
{
    return env->data + 3 * ((size_t)j * (size_t)env->width + (size_t)i);
}

/* A map of c0 + c1 max(d.axis, floor): floor 0 clamps, -1 does not. */
static ibl_image map_cosine(int w, int h, double c0, double c1,
                            const double axis[3], double floor_at)
{
    const ibl_image env = map_new(w, h);
    for (int j = 0; j < h; j++) {
        for (int i = 0; i < w; i++) {
            double d[3];
            truth_latlong_direction(w, h, i, j, d);
            const double c = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
            for (int k = 0; k < 3; k++)
                texel(&env, i, j)[k] = (float)(c0 + c1 * fmax(c, floor_at));
        }
    }
    return env;
}

static ibl_image map_noise(int w, int h, uint64_t seed)
{
    const ibl_image env = map_new(w, h);
    test_random r = {seed};
    for (size_t i = 0; i < 3 * (size_t)w * (size_t)h; i++)
        env.data[i] = (float)pow(test_random_unit(&r), 8.0);
    *texel(&env, w / 3, h / 4) = 1e5f;
    return env;
}

static void random_direction(test_random *r, double d[3])
{
    const double y = 2.0 * test_random_unit(r) - 1.0;
    const double phi = 2.0 * M_PI * test_random_unit(r);
    d[0] = sqrt(1.0 - y * y) * cos(phi);
    d[1] = y;
    d[2] = sqrt(1.0 - y * y) * sin(phi);
}

/* ---- directions ------------------------------------------------------ */

TEST(solid_angles)
{
    static const int sizes[][2] = {
        {1, 1}, {2, 1}, {3, 2}, {17, 31}, {512, 256}};
    for (int n = 0; n < 5; n++) {
        const int w = sizes[n][0], h = sizes[n][1];
        double sum = 0.0;
        for (int j = 0; j < h; j++) {
            const double exact =
                2.0 * M_PI / w * (cos(M_PI * j / h) - cos(M_PI * (j + 1) / h));
            CHECK_NEAR(truth_latlong_solid_angle(w, h, j), exact, 1e-14);
            sum += w * truth_latlong_solid_angle(w, h, j);
        }
        CHECK_NEAR(sum, 4.0 * M_PI, 1e-13);
    }
}

/* The centre column looks along +X, u grows towards +Z, row 0 is the zenith. */
TEST(latlong_directions)
{
    double d[3];
    truth_latlong_direction(2001, 1001, 1000, 500, d);
    CHECK_NEAR(d[0], 1.0, 1e-12);
    truth_latlong_direction(2002, 1001, 1501, 500, d);
    CHECK_NEAR(d[2], 1.0, 1e-5);
    truth_latlong_direction(2001, 1001, 7, 0, d);
    CHECK_NEAR(d[1], 1.0, 1e-5);
    for (int j = 0; j < 7; j++) {
        for (int i = 0; i < 13; i++) {
            int x, y;
            truth_latlong_direction(13, 7, i, j, d);
            truth_latlong_pixel(13, 7, d, &x, &y);
            CHECK_MSG(x == i && y == j, "(%d, %d) came back as (%d, %d)", i, j,
                      x, y);
        }
    }
}

/* OpenGL 4.6, table 8.19: major axis, sc and tc of each face; s = (sc / |ma|
 * + 1) / 2 from the left, t from the top row. */
TEST(cube_directions)
{
    for (int face = 0; face < 6; face++) {
        for (int k = 0; k < 25; k++) {
            double d[3];
            truth_cube_direction(5, face, k % 5, k / 5, d);
            const double sc[6] = {-d[2], d[2], d[0], d[0], d[0], -d[0]};
            const double tc[6] = {-d[1], -d[1], d[2], -d[2], -d[1], -d[1]};
            const double ma = (face % 2 ? -1.0 : 1.0) * d[face / 2];
            CHECK(ma > 0.5);
            CHECK_NEAR((sc[face] / ma + 1.0) / 2.0, (k % 5 + 0.5) / 5, 1e-14);
            CHECK_NEAR((tc[face] / ma + 1.0) / 2.0, (k / 5 + 0.5) / 5, 1e-14);
            CHECK_NEAR(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], 1.0, 1e-14);
        }
    }
}

/* ---- sums over a map ------------------------------------------------- */

TEST(constant_map)
{
    static const float colour[3] = {0.7f, 3e4f, 1e-5f};
    const ibl_image env = map_new(37, 19);
    test_random r = {1};
    for (int i = 0; i < 37 * 19 * 3; i++)
        env.data[i] = colour[i % 3];
    for (int n = 0; n < 20; n++) {
        double d[3], s[3], e[3], m[3], t[3];
        random_direction(&r, d);
        truth_specular(&env, d, 0.05 + 0.95 * n / 19, s);
        truth_irradiance(&env, d, e);
        truth_mean(&env, m);
        truth_texel(&env, 3, n % 6, n % 3, n / 7, 9, t);
        for (int k = 0; k < 3; k++) {
            const double c = (double)colour[k], tol = 1e-14 * c;
            CHECK_NEAR(s[k], c, tol);
            CHECK_NEAR(e[k], c, tol);
            CHECK_NEAR(m[k], c, tol);
            CHECK_NEAR(t[k], c, tol);
        }
    }
}

enum {
    FINE = 120 /* midpoints across a pixel, below */
};

/* The convention's integral over patches, by midpoints in long double. */
static void plain_specular(const ibl_image *env, const double n[3], double r,
                           double rgb[3])
{
    const int w = env->width * FINE, h = env->height * FINE;
    const long double a2 = powl(r, 4), step = pil / h;
    long double sum[4] = {0};
    for (int j = 0; j < h; j++) {
        const long double theta = step * (j + 0.5L);
        const long double s = sinl(theta), c = cosl(theta);
        for (int i = 0; i < w; i++) {
            const long double phi = 2 * pil * (i + 0.5L) / w - pil;
            const long double l[3] = {s * cosl(phi), c, s * sinl(phi)};
            long double nl = 0, h2 = 0, nh = 0;
            for (int k = 0; k < 3; k++) {
                nl += n[k] * l[k];
                h2 += (n[k] + l[k]) * (n[k] + l[k]);
                nh += n[k] * (n[k] + l[k]);
            }
            if (nl <= 0)
                continue;
            nh /= sqrtl(h2);
            const long double t = nh * nh * (a2 - 1) + 1;
            const long double weight = a2 / (pil * t * t) * nl * s;
            const float *p = texel(env, i / FINE, j / FINE);
            for (int k = 0; k < 3; k++)
                sum[k] += weight * (long double)p[k];
            sum[3] += weight;
        }
    }
    for (int k = 0; k < 3; k++)
        rgb[k] = (double)(sum[k] / sum[3]);
}

/* Of those midpoints, which are 1 / (24 alpha^2) of their squared step off,
 * and 1e-5 for where the horizon cuts them. */
static double midpoint_error(int h, double r)
{
    return pow(M_PI / (h * FINE) / (r * r), 2.0) / 24.0 + 1e-5;
}

TEST_SLOW(specular_in_long_double)
{
    static const double roughness[] = {0.25, 0.4, 0.6, 0.8, 1.0, 0.3};
    const ibl_image env = map_noise(20, 11, 2);
    test_random r = {3};
    for (int n = 0; n < 8; n++) {
        const double at = roughness[n % 6];
        double d[3] = {0, n % 2 ? -1 : 1, 0}, fast[3], plain[3];
        if (n < 5) /* the poles' rows, the seam, a pixel's centre */
            truth_latlong_direction(20, 11, 4 * n, 10 * n / 4, d);
        if (n == 5)
            random_direction(&r, d);
        truth_specular(&env, d, at, fast);
        plain_specular(&env, d, at, plain);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(fast[k], plain[k], midpoint_error(11, at) * plain[k]);
    }
}

/* A pixel as 2x2 of the same colour is the same light, in every lobe. */
TEST(pixels_in_four)
{
    static const double roughness[3][3] = {
        {0.05, 0.3, 1.0}, {0.4, 0.7, 1.0}, {0.4, 0.7, 1.0}};
    const ibl_image env = map_noise(30, 17, 5), fine = map_new(60, 34);
    test_random r = {12};
    for (int j = 0; j < 34; j++)
        for (int i = 0; i < 60; i++)
            for (int k = 0; k < 3; k++)
                texel(&fine, i, j)[k] = texel(&env, i / 2, j / 2)[k];
    for (int n = 0; n < 18; n++) {
        const double at = roughness[n % 3][n / 3 % 3];
        double d[3], a[3], b[3];
        random_direction(&r, d);
        truth_lobe(&env, d, (ibl_lobe)(n % 3), at, a);
        truth_lobe(&fine, d, (ibl_lobe)(n % 3), at, b);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(a[k], b[k], 1e-5 * b[k]);
    }
}

/* Over a pixel above the horizon the integral of L is in closed form: cos(phi)
 * and sin(phi) by sin^2(theta), cos(theta) by sin(theta). */
TEST(irradiance_of_a_pixel)
{
    const int w = 12, h = 8, x = 7, y = 2;
    const ibl_image env = map_new(w, h);
    const double a = M_PI * y / h, b = M_PI * (y + 1) / h;
    const double c = 2 * M_PI * x / w - M_PI, d = 2 * M_PI * (x + 1) / w - M_PI;
    const double squares = (b - a - (sin(2 * b) - sin(2 * a)) / 2) / 2;
    const double flux[3] = {squares * (sin(d) - sin(c)),
                            (sin(b) * sin(b) - sin(a) * sin(a)) / 2 * (d - c),
                            squares * (cos(c) - cos(d))};
    test_random r = {13};
    texel(&env, x, y)[1] = 3.0f;
    for (int n = 0; n < 20; n++) {
        double centre[3], normal[3], rgb[3], dot = 0, want = 0;
        truth_latlong_direction(w, h, x, y, centre);
        random_direction(&r, normal);
        for (int k = 0; k < 3; k++) {
            dot += centre[k] * normal[k];
            want += 3.0 * flux[k] * normal[k] / M_PI;
        }
        if (fabs(dot) < 0.45) /* the horizon cuts it */
            continue;
        truth_irradiance(&env, normal, rgb);
        CHECK_NEAR(rgb[1], fmax(want, 0.0), 1e-6 * fabs(want));
    }
}

TEST(roughest_is_irradiance)
{
    const ibl_image env = map_noise(128, 64, 5);
    test_random r = {6};
    for (int n = 0; n < 20; n++) {
        double d[3], s[3], e[3];
        random_direction(&r, d);
        truth_specular(&env, d, 1.0, s);
        truth_irradiance(&env, d, e);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(s[k], e[k], 1e-12 * e[k]);
    }
}

/*
 * Two clamped cosines g apart integrate to 2/3 (sin g + (pi - g) cos g);
 * an unclamped one comes out of irradiance / pi with factor 2/3.
 */
TEST(irradiance_of_cosines)
{
    static const double axis[3] = {0.48, -0.6, 0.64};
    const ibl_image lobe = map_cosine(512, 256, 0.0, 1.0, axis, 0.0);
    const ibl_image ramp = map_cosine(512, 256, 1.0, 1.0, axis, -1.0);
    test_random r = {7};
    double mean[3];
    for (int n = 0; n < 10; n++) {
        double d[3], e[3];
        random_direction(&r, d);
        const double c = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
        const double g = acos(c);
        truth_irradiance(&lobe, d, e);
        CHECK_NEAR(e[1], 2.0 / (3.0 * M_PI) * (sin(g) + (M_PI - g) * c), 2e-5);
        truth_irradiance(&ramp, d, e);
        CHECK_NEAR(e[2], 1.0 + 2.0 / 3.0 * c, 2e-5);
    }
    truth_mean(&lobe, mean);
    CHECK_NEAR(mean[0], 0.25, 1e-5);
    truth_mean(&ramp, mean);
    CHECK_NEAR(mean[0], 1.0, 1e-6);
}

/* integral of D N.L over the hemisphere, from dO = 4 pi dq of truth.c. */
static double lobe_integral(double r)
{
    const double a2 = pow(r, 4.0), b = 1.0 - a2;
    if (r >= 1.0)
        return 1.0;
    return 4.0 * a2 / (b * b) *
           ((1.0 + a2) / a2 - 2.0 - 2.0 * log((1.0 + a2) / (2.0 * a2)));
}

/* One pixel, by 64x64 midpoints of the lobe's shape; its norm is the integral,
 * by which truth_pixel_weight divides to the same. */
TEST(one_pixel_sun)
{
    enum {
        N = 64
    };
    const int w = 512, h = 256, x = 400, y = 70;
    const double sun = 1e6;
    const ibl_image env = map_new(w, h);
    double mean[3];
    test_random rnd = {8};
    texel(&env, x, y)[0] = (float)sun;
    const double power = sun * truth_latlong_solid_angle(w, h, y);
    const double cut = 1e-6 * power / M_PI; /* where the horizon cuts it */
    for (int n = 0; n < 12; n++) {
        const double r = 0.25 + 0.25 * (n % 4), a2 = pow(r, 4.0);
        double d[3], rgb[3], expected = 0.0;
        random_direction(&rnd, d);
        for (int k = 0; k < N * N; k++) {
            const int row = N * y + k / N;
            double s[3];
            truth_latlong_direction(N * w, N * h, N * x + k % N, row, s);
            const double nl = d[0] * s[0] + d[1] * s[1] + d[2] * s[2];
            const double t = (1.0 + nl) / 2.0 * (a2 - 1.0) + 1.0;
            if (nl > 0.0)
                expected += a2 / (M_PI * t * t) * nl * sun / lobe_integral(r) *
                            truth_latlong_solid_angle(N * w, N * h, row);
        }
        truth_specular(&env, d, r, rgb);
        CHECK_NEAR(rgb[0], expected, 2e-5 * expected + cut);
        CHECK(rgb[1] == 0.0 && rgb[2] == 0.0);
        CHECK_NEAR(sun * truth_pixel_weight(w, h, x, y, d, IBL_LOBE_GGX, r) /
                       truth_lobe_integral(IBL_LOBE_GGX, r * r),
                   expected, 2e-5 * expected + cut);
    }
    truth_mean(&env, mean);
    CHECK_NEAR(mean[0], power / (4.0 * M_PI), 1e-12 * power);
}

/* On the one texel of face +X, d.x averages to 2 acos(1/3) / sqrt(2) (the
 * face's edges by Lambert's formula) over 4 pi / 6. */
/* Of 1 + c, c the cosine to an axis: with its angle alone a lobe makes
 * 1 + k c of it, k the mean of N.L under it: (n + 2) / (n + 3) of a power
 * n + 1, 2 / (b + 3) of q^b (1 - 2 q), b = 1 / (2 alpha). */
TEST(lobes_of_a_cosine)
{
    static const double axis[3] = {0.48, -0.6, 0.64};
    static const double roughness[] = {0.5, 0.7, 1.0};
    ibl_image env = map_cosine(256, 128, 1, 1, axis, -1);
    test_random r = {5};

    for (int k = 0; k < 3; k++) {
        const double alpha = roughness[k] * roughness[k];
        const double n = 0.5 * (1 / (alpha * alpha) - 1);
        double d[3], got[3];
        random_direction(&r, d);
        const double c = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
        truth_lobe(&env, d, IBL_LOBE_PHONG, roughness[k], got);
        CHECK_NEAR(got[0], 1 + c * (n + 2) / (n + 3), 2e-4);
        truth_lobe(&env, d, IBL_LOBE_CHARLIE, roughness[k], got);
        CHECK_NEAR(got[0], 1 + c * 2 / (0.5 / alpha + 3), 2e-4);
    }
}

/* Midpoints over q. */
TEST(lobe_integrals)
{
    static const double alphas[] = {0.05, 0.3, 0.9, 1};

    for (int lobe = 0; lobe < 3; lobe++)
        for (int k = 0; k < 4; k++) {
            const int n = 200000;
            double sum = 0;
            for (int i = 0; i < n; i++)
                sum += truth_lobe_weight((ibl_lobe)lobe, alphas[k],
                                         0.5 * (i + 0.5) / n);
            CHECK_NEAR(truth_lobe_integral((ibl_lobe)lobe, alphas[k]) /
                           (4 * M_PI * sum * 0.5 / n),
                       1, 1e-6);
        }
}

TEST(texel_average)
{
    static const double axis[3] = {1, 0, 0};
    const ibl_image env = map_cosine(1024, 512, 1.0, 1.0, axis, -1.0);
    const double mean = sqrt(2.0) * acos(1.0 / 3.0) / (4.0 * M_PI / 6.0);
    double rgb[3], d[3];
    int i, j;
    truth_texel(&env, 1, 0, 0, 0, 1200, rgb);
    CHECK_NEAR(rgb[0], 1.0 + mean, 1e-5);
    truth_texel(&env, 1, 1, 0, 0, 1200, rgb);
    CHECK_NEAR(rgb[0], 1.0 - mean, 1e-5);
    truth_texel(&env, 1, 4, 0, 0, 1200, rgb);
    CHECK_NEAR(rgb[0], 1.0, 1e-5);
    truth_texel(&env, 64, 3, 9, 50, 1, rgb);
    truth_cube_direction(64, 3, 9, 50, d);
    truth_latlong_pixel(1024, 512, d, &i, &j);
    CHECK_NEAR(rgb[0], (double)texel(&env, i, j)[0], 1e-14);
}

/* ---- spherical harmonics --------------------------------------------- */

TEST(sh_polynomials)
{
    test_random r = {9};
    for (int n = 0; n < 20; n++) {
        double d[3];
        random_direction(&r, d);
        const double x = d[0], y = d[1], z = d[2];
        /* Ramamoorthi and Hanrahan 2001, eq. 3. */
        CHECK_NEAR(truth_sh(0, 0, d), 0.282095, 1e-6);
        CHECK_NEAR(truth_sh(1, -1, d), 0.488603 * y, 1e-6);
        CHECK_NEAR(truth_sh(1, 0, d), 0.488603 * z, 1e-6);
        CHECK_NEAR(truth_sh(1, 1, d), 0.488603 * x, 1e-6);
        CHECK_NEAR(truth_sh(2, -2, d), 1.092548 * x * y, 1e-6);
        CHECK_NEAR(truth_sh(2, -1, d), 1.092548 * y * z, 1e-6);
        CHECK_NEAR(truth_sh(2, 0, d), 0.315392 * (3 * z * z - 1), 1e-6);
        CHECK_NEAR(truth_sh(2, 1, d), 1.092548 * x * z, 1e-6);
        CHECK_NEAR(truth_sh(2, 2, d), 0.546274 * (x * x - y * y), 1e-6);
    }
}

/* Positive near +Z where phi is small (no Condon-Shortley phase), and the
 * phase about +Z that of cos(m phi), sin(|m| phi). */
TEST(sh_phases)
{
    for (int l = 0; l <= 4; l++) {
        for (int m = -l; m <= l; m++) {
            const int k = abs(m);
            const double t = 0.01, phi = 0.3;
            const double d[3] = {sin(t) * cos(phi), sin(t) * sin(phi), cos(t)};
            const double e[3] = {sin(t), 0.0, cos(t)};
            const double factor = m < 0 ? sin(k * phi) : cos(k * phi);
            CHECK(truth_sh(l, k, e) > 0.0);
            CHECK_NEAR(truth_sh(l, m, d) / truth_sh(l, k, e), factor, 1e-12);
        }
    }
}

TEST(sh_orthonormal)
{
    enum {
        W = 128,
        H = 1024
    };
    static double gram[25][25];
    for (int j = 0; j < H; j++) {
        const double weight = truth_latlong_solid_angle(W, H, j);
        for (int i = 0; i < W; i++) {
            double d[3], y[25];
            truth_latlong_direction(W, H, i, j, d);
            for (int k = 0, l = 0; l <= 4; l++)
                for (int m = -l; m <= l; m++)
                    y[k++] = truth_sh(l, m, d);
            for (int a = 0; a < 25; a++)
                for (int b = 0; b < 25; b++)
                    gram[a][b] += weight * y[a] * y[b];
        }
    }
    for (int a = 0; a < 25; a++)
        for (int b = 0; b < 25; b++)
            CHECK_NEAR(gram[a][b], a == b ? 1.0 : 0.0, 2e-5);
}
