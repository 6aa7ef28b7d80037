/* SPDX-License-Identifier: MIT */
/*
 * The integrals of ibl/reference.h against those of truth.c, closed forms and
 * sums of points that are written out here; never against a bake.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reference.h"
#include "truth.h"

enum {
    SUMS = IBL_REFERENCE_BRDF,
    LOBES = 3
};

/* ---- lobes -------------------------------------------------------------- */

/* Maps, roughnesses and aims, as polar angles. */
static const struct aim {
    int width, height;
    double roughness, theta, phi;
} aims[] = {
    {64, 32, 1, 1.234, 0.567},
    {51, 37, 0.7, 0, 0},
    {64, 32, 0.5, M_PI, 2},
    {57, 32, 0.5, 0.01, -3.1415},
    {128, 64, 1, 1.234, 0.567}, /* most pixels by two points along an axis */
    {32, 16, 0.3, 1.234, 3.1},
    {24, 13, 0.3, 0.05, -1},
    {16, 8, 0.2, M_PI, 0},
    {64, 32, 0.2, 1.1, 1},
    {100, 2, 0.2, M_PI / 2, 0}, /* needles */
    {4, 64, 0.2, 1.2, 2.6},
    {1, 5, 0.9, 2.2, 0.5},
    {2, 1, 0.6, 0.9, 1.5},
    {1, 1, 0.2, 1, -1},
    /* Edges of pixels on the horizon: what rounding leaves of them above it
     * has no digits to settle by, and halving it for them would not end. */
    {13, 7, 1, M_PI / 2, -M_PI / 2},
    {13, 7, 0.4, M_PI / 2, M_PI},
    {4, 2, 1, M_PI / 2, M_PI / 2},
    {4, 2, 1, 0, 0},
};

/* Green is constant. */
static void check_aim(const struct aim *a, ibl_lobe lobe)
{
    const subject *it = subject_make(2, a->width, a->height, 5, 30);
    double world[3], d[3], rgb[3], sum[4] = {0};
    for (int k = 0; k < a->width * a->height; k++)
        it->env.data[3 * k + 1] = 0.7f;
    polar_direction(a->theta, a->phi, d);
    polar_direction(a->theta, a->phi - M_PI / 6, world);
    for (int k = 0; k < a->width * a->height; k++) {
        const double weight =
            truth_pixel_weight(a->width, a->height, k % a->width, k / a->width,
                               d, lobe, a->roughness);
        for (int c = 0; c < 3; c++)
            sum[c] += weight * (double)it->env.data[3 * k + c];
        sum[3] += weight;
    }
    const ibl_reference *ref = subject_ref(it);
    CHECK(!ibl_reference_lobe(ref, lobe, a->roughness, world, 1, rgb));
    CHECK_NEAR(rgb[1], (double)0.7f, 1e-7);
    for (int c = 0; c < 3; c++) {
        const double want = sum[c] / sum[3];
        CHECK_MSG(fabs(rgb[c] - want) <= 2e-5 * want,
                  "%s %dx%d r %g at (%g, %g): %.9g, not %.9g",
                  ibl_lobe_name(lobe), a->width, a->height, a->roughness,
                  a->theta, a->phi, rgb[c], want);
        test_measured(ibl_lobe_name(lobe), fabs(rgb[c] - want), 2e-5 * want);
    }
    /* At roughness 1 Phong and GGX are the cosine. */
    if (a->roughness < 1 || lobe == IBL_LOBE_CHARLIE)
        return;
    CHECK(!ibl_reference_irradiance(ref, world, 1, sum));
    for (int c = 0; c < 3; c++)
        CHECK_NEAR(sum[c], rgb[c], 1e-5 * rgb[c]);
}

TEST_OF(lobes, "lobes", TEST_RACES)
{
    for (size_t k = 0; k < LOBES * sizeof aims / sizeof *aims; k++)
        check_aim(&aims[k / LOBES], (ibl_lobe)(k % LOBES));
}

/* Roughness 0 is the pixel, the end of 1e-4 the middle of the same; the mean is
 * that by solid angles; errors are by the definition, and those of nothing
 * finite. */
TEST_OF(ends, "ends", TEST_RACES)
{
    static const double none[3] = {0}, some[3] = {3, 4, 0}, far[3] = {6, 8, 0};
    const subject *it = subject_make(2, 40, 20, 3, 90);
    const ibl_reference *ref = subject_ref(it);
    double mean[3], sum = 0, d[3], rgb[3];
    for (int k = 0; k < 40 * 20; k++) {
        const float *p = map_pixel(&it->env, k % 40, k / 40);
        sum += truth_latlong_solid_angle(40, 20, k / 40) * (double)p[2];
        /* The map's azimuth is the world's and a quarter turn. */
        truth_latlong_direction(40, 20, k % 40 + 0.1 - 10, k / 40 - 0.2, d);
        for (int l = 0; l < LOBES; l++) {
            CHECK(!ibl_reference_lobe(ref, (ibl_lobe)l, 0, d, 1, rgb));
            CHECK(rgb[0] == (double)p[0] && rgb[1] == (double)p[1]);
        }
        CHECK(!ibl_reference_lobe(ref, IBL_LOBE_GGX, 1e-5, d, 1, rgb));
        CHECK_NEAR(rgb[2], (double)p[2], 1e-7);
    }
    CHECK(!ibl_reference_mean(ref, mean));
    CHECK_NEAR(mean[2], sum / (4 * M_PI), 1e-8);
    CHECK_NEAR(ibl_relative_error(some, far, mean), 0.5, 0.5 * mean[2]);
    CHECK_NEAR(ibl_relative_error(some, none, far), 0.5 / IBL_RELATIVE_FLOOR,
               1e-9);
    CHECK(ibl_relative_error(none, none, none) == 0);
    CHECK(isfinite(ibl_relative_error(some, none, none)));
}

/* L = 1 + x / 2 has the mean 1 + N.x / 3 under the cosine lobe: of many pixels,
 * by blocks. */
TEST_SLOW(linear_light)
{
    const subject *it = subject_make(2, 512, 256, 0, 0);
    test_random rnd = {4};
    double d[3], rgb[3];
    for (int k = 0; k < 512 * 256; k++) {
        truth_latlong_direction(512, 256, k % 512, k / 512, d);
        it->env.data[3 * k] = (float)(1 + d[0] / 2);
    }
    const ibl_reference *ref = subject_ref(it);
    for (int k = 0; k < 20; k++) {
        random_direction(&rnd, d);
        CHECK(!ibl_reference_irradiance(ref, d, 1, rgb));
        CHECK_NEAR(rgb[0], 1 + d[0] / 3, 2e-5);
    }
}

/* ---- what surfaces reflect ---------------------------------------------- */

/* Adds a pixel in sub x sub parts. */
static void add_pixel(const subject *it, ibl_geometry g, double r,
                      const double n[3], const double v[3], int sub, int pixel,
                      double out[SUMS])
{
    const int w = it->env.width, h = it->env.height;
    const double turn = it->yaw_deg / 360 * w * sub;
    const float *p = it->env.data + 3 * pixel;
    for (int k = 0; k < sub * sub; k++) {
        const int i = pixel % w * sub + k % sub, j = pixel / w * sub + k / sub;
        double l[3], fc;
        truth_latlong_direction(w * sub, h * sub, i - turn, j, l);
        const double f = truth_latlong_solid_angle(w * sub, h * sub, j) *
                         truth_ggx(g, r * r, n, v, l, &fc);
        for (int c = 0; c < 4; c++) {
            const double light = c < 3 ? (double)p[c] : 1;
            out[c] += f * (1 - fc) * light;
            out[4 + c] += f * fc * light;
        }
    }
}

/* Parts half as large as the widest that see the lobe are off by less than the
 * promise. */
static void check_surface(const subject *it, double r, const double n[3],
                          const double v[3], int sub)
{
    const int w = it->env.width, h = it->env.height;
    for (int g = 0; g < 2; g++) {
        double want[SUMS] = {0}, got[SUMS];
        CHECK(!ibl_reference_brdf(subject_ref(it), (ibl_geometry)g, &r, 1, n, v,
                                  1, got));
        for (int i = 0; i < w * h; i++)
            add_pixel(it, (ibl_geometry)g, r, n, v, sub, i, want);
        for (int c = 0; c < SUMS; c++)
            CHECK_MSG(fabs(got[c] - want[c]) <=
                          1e-3 * (want[c] + want[c % 4]) + 2e-8,
                      "%dx%d r %g N.V %g geometry %d: sum %d is %.9g, not %.9g",
                      w, h, r, test_dot(n, v), g, c, got[c], want[c]);
    }
}

TEST_SLOW(surfaces)
{
    static const struct {
        int width, height;
        double yaw, r, n_v;
        int sub;
    } rows[] = {{32, 16, 0, 0.3, 0.8, 32},   {32, 16, 30, 0.5, 0.4, 16},
                {32, 16, -100, 0.7, 0.1, 8}, {32, 16, 0, 1, 0.6, 24},
                {5, 3, 0, 0.6, 0.5, 64},     {1, 1, 0, 0.8, 0.3, 200},
                {70, 3, 0, 0.8, 0.9, 24}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const int w = rows[k].width, h = rows[k].height;
        const subject *it = subject_make(2, w, h, 7, rows[k].yaw);
        test_random rnd = {k};
        double n[3], v[3];
        map_set(&it->env, w / 3, h / 3, 900, 500, 100);
        random_direction(&rnd, n);
        random_view(&rnd, n, rows[k].n_v, v);
        check_surface(it, rows[k].r, n, v, rows[k].sub);
    }
}

/* A light on the horizon, of which a part is below. */
TEST(pixel_on_the_horizon)
{
    static const double above[] = {-0.02, -0.005, 0.001, 0.01, 0.03, 0.08};
    const subject *it = subject_make(1, 128, 64, 0, 0);
    const double r = 1, phi = 2 * M_PI * (40.5 / 128 - 0.5);
    map_set(&it->env, 40, 20, 8, 4, 2);
    for (int k = 0; k < 6; k++) {
        double want[SUMS] = {0}, got[SUMS], n[3], v[3];
        polar_direction(M_PI * (20.5 / 64 + 0.5) - above[k], phi, n);
        polar_direction(M_PI * (20.5 / 64 + 0.5) - 0.5, phi + 0.3, v);
        add_pixel(it, IBL_GEOMETRY_SMITH, r, n, v, 128, 20 * 128 + 40, want);
        CHECK(!ibl_reference_brdf(subject_ref(it), IBL_GEOMETRY_SMITH, &r, 1, n,
                                  v, 1, got));
        CHECK_NEAR(got[0], want[0], 2e-3 * want[0] + 2e-8);
        CHECK_NEAR(got[4], want[4], 2e-3 * want[4] + 2e-8);
    }
}

/* Radiance 1 reflects what the table says, and any constant its multiple; a
 * mirror the pixel there. */
TEST_OF(surfaces_of_constants_and_mirrors, "surfaces_of_constants_and_mirrors",
        TEST_RACES)
{
    static const double roughness[] = {0, 1e-4, 0.02, 0.1, 0.35, 0.7, 1};
    static const int sizes[][2] = {{1, 1}, {7, 40}, {64, 32}, {200, 100}};
    static const double n_v[] = {1, 0.9, 0.7, 0.4, 0.15, 0.04};
    test_random rnd = {9};
    for (int k = 0; k < 4 * 6; k++) {
        const subject *it =
            subject_make(2, sizes[k / 6][0], sizes[k / 6][1], 4, 65);
        const ibl_geometry g = (ibl_geometry)(k / 6 % 2);
        double got[7 * SUMS], n[3], v[3], at[3], rgb[3];
        for (size_t i = 0; i < map_floats(&it->env); i += 3)
            it->env.data[i] = 0.75f;
        random_direction(&rnd, n);
        random_view(&rnd, n, n_v[k % 6], v);
        for (int c = 0; c < 3; c++)
            at[c] = 2 * n_v[k % 6] * n[c] - v[c];
        const ibl_reference *ref = subject_ref(it);
        CHECK(!ibl_reference_brdf(ref, g, roughness, 7, n, v, 1, got));
        CHECK(!ibl_reference_lobe(ref, IBL_LOBE_GGX, 0, at, 1, rgb));
        for (int r = 0; r < 7; r++) {
            const double *of = got + SUMS * r;
            double lut[2];
            CHECK(
                !ibl_reference_lut(it->ctx, n_v[k % 6], roughness[r], g, lut));
            for (int s = 0; s < 2; s++) {
                CHECK_NEAR(of[3 + 4 * s], lut[s], 5e-4);
                CHECK_NEAR(of[4 * s], 0.75 * of[3 + 4 * s], 1e-7);
                for (int c = 1; c < 3 && r < 2; c++)
                    CHECK_NEAR(of[4 * s + c], rgb[c] * of[3 + 4 * s], 1e-12);
            }
        }
    }
}

/* Under a sun and not: surfaces, and lobes. */
TEST_SLOW(coarse)
{
    static const double roughness[] = {0.05, 0.1, 0.3, 0.6, 1};
    test_random rnd = {3};
    double worst = 0, mean = 0;
    for (int k = 0; k < 10; k++) {
        const subject *it = subject_make(2, 512, 256, 6, 20);
        double n[3], v[3], out[2][5 * SUMS], lobes[2][15];
        map_set(&it->env, 100, 80, 5, k % 2 ? 20000 : 5, 5);
        random_direction(&rnd, n);
        random_view(&rnd, n, 1 - 0.1 * k, v);
        ibl_reference *ref = subject_ref(it);
        for (int i = 0; i < 2; i++) {
            CHECK(!ibl_reference_brdf(ref, IBL_GEOMETRY_SMITH, roughness, 5, n,
                                      v, 1, out[i]));
            for (int r = 0; r < 5; r++)
                CHECK(!ibl_reference_lobe(ref, IBL_LOBE_GGX, roughness[r], n, 1,
                                          lobes[i] + 3 * r));
            ibl_reference_coarsen(ref);
        }
        for (int i = 0; i < 30; i++) {
            const int at = i % 15 / 3 * SUMS + i % 3;
            const double off = i < 15 ? (out[1][at] + out[1][at + 4]) /
                                                (out[0][at] + out[0][at + 4]) -
                                            1
                                      : lobes[1][i - 15] / lobes[0][i - 15] - 1;
            worst = fmax(worst, fabs(off));
            mean += fabs(off) / 300;
        }
    }
    CHECK(worst > 1e-6 && worst < 1e-3);
    CHECK(mean < 1e-4);
}

/* ---- harmonics ---------------------------------------------------------- */

/* Few pixels, which are wide for the degree, and all coefficients: each pixel
 * by 2 x 2 or 3 x 3 panels of 5 x 5 points of Gauss. */
TEST_SLOW(harmonics)
{
    enum {
        DEGREE = 13,
        COUNT = (DEGREE + 1) * (DEGREE + 1),
        N = 5
    };
    static const int sizes[][2] = {{60, 30}, {14, 40}, {24, 13}};
    long double node[N], mass[N];
    truth_gauss(N, node, mass);
    for (int k = 0; k < 3; k++) {
        const int w = sizes[k][0], h = sizes[k][1], panels = k < 1 ? 2 : 3;
        const subject *it = subject_make(2, w, h, 0, 15);
        double want[3 * COUNT] = {0}, got[3 * COUNT];
        for (int p = 0; p < w * h; p += w * h / 3 + 1) {
            float *rgb = it->env.data + 3 * p;
            rgb[0] = 1 + (float)p;
            rgb[2] = 100;
            for (int n = 0; n < panels * panels * N * N; n++) {
                const int x = n % (panels * N), z = n / (panels * N);
                double d[3];
                const double i =
                    p % w + (x / N + (double)(node[x % N] + 1) / 2) / panels;
                const double j =
                    p / w + (z / N + (double)(node[z % N] + 1) / 2) / panels;
                const double weight = (double)(mass[x % N] * mass[z % N] / 4) *
                                      2 * M_PI / w * M_PI / h *
                                      sin(M_PI * j / h) / (panels * panels);
                truth_latlong_direction(w, h, i - 0.5 - w * 15 / 360.0, j - 0.5,
                                        d);
                for (int l = 0, a = 0; l <= DEGREE; l++)
                    for (int m = -l; m <= l; m++, a += 3) {
                        const double y = weight * truth_sh(l, m, d);
                        want[a] += y * (double)rgb[0];
                        want[a + 2] += y * 100;
                    }
            }
        }
        for (int degree = 1; degree <= DEGREE; degree += 12) {
            CHECK(!ibl_reference_sh(subject_ref(it), degree, got));
            for (int a = 0; a < 3 * (degree + 1) * (degree + 1); a++)
                CHECK_MSG(fabs(got[a] - want[a]) <= 1e-7 * want[a % 3],
                          "%dx%d, degree %d, %d: %.9g, not %.9g", w, h, degree,
                          a, got[a], want[a]);
        }
    }
}

/* ---- level 0 --------------------------------------------------------------
 */

/* The finer pixels of ibl_cube_from_latlong for a cube of n. */
typedef struct finer {
    const ibl_image *env;
    int x, y; /* for each of the source */
    double bend[64];
} finer;

static finer finer_of(const ibl_image *env, int n)
{
    finer f = {.env = env, .x = 1, .y = 1};
    const int w = env->width, h = env->height;

    if (w >= 4 * n && h >= 2 * n)
        return f;
    while (w * f.x < 4 * n || w * f.x < 512 || w * f.x % 2)
        f.x++;
    while (h * f.y < 2 * n)
        f.y++;
    for (int j = 0; j + 1 < h; j++) {
        double above = 0, part = 0, room = 0;
        for (int k = 0; k < 2 * f.y; k++) {
            const double t = (k + 0.5) / f.y - 0.5;
            const int row = j * f.y + k;
            const double zone =
                cos(M_PI * row / (h * f.y)) - cos(M_PI * (row + 1) / (h * f.y));
            if (t < 0 || t >= 1)
                continue;
            /* What is above the border, and what the upper row has with
             * weights 1 - t - b t (1 - t). */
            above += t < 0.5 ? zone : 0;
            part += (1 - t) * zone;
            room += t * (1 - t) * zone;
        }
        f.bend[j] = room > 0 ? (part - above) / room : 0;
    }
    return f;
}

/* The value of finer pixel (i, j). */
static double finer_value(const finer *f, int i, int j)
{
    const int w = f->env->width, h = f->env->height;
    const double y = (j + 0.5) / f->y - 0.5, t = y - floor(y);
    const int above = (int)floor(y);
    const double b = above >= 0 && above < h - 1 ? f->bend[above] : 0;
    const double lower = t + b * t * (1 - t);
    double sum = 0;

    for (int k = 0; k < 2; k++) {
        const bool beyond = above + k < 0 || above + k >= h;
        const int row = beyond ? (k ? h - 1 : 0) : above + k;
        const double x = (i + 0.5) / f->x - 0.5 + (beyond ? 0.5 * w : 0);
        const int left = (int)floor(x);
        const double part = x - left;
        sum += (k ? lower : 1 - lower) *
               ((1 - part) * (double)map_pixel(f->env, (left + w) % w, row)[0] +
                part * (double)map_pixel(f->env, (left + 1 + w) % w, row)[0]);
    }
    return sum;
}

static double map_value(const finer *f, double theta, double phi)
{
    const int columns = f->env->width * f->x, rows = f->env->height * f->y;
    const int i = (int)((phi / (2 * M_PI) + 0.5) * columns);
    const int j = (int)(theta / M_PI * rows);
    return finer_value(f, i < columns ? i : 0, j < rows ? j : rows - 1);
}

/* A texel's mean: sub x sub points of (u, v), weighted by solid angle. */
static double texel_points(const finer *f, int n, ibl_texel t, double yaw,
                           int sub)
{
    double sum = 0, weights = 0;

    for (int b = 0; b < sub; b++) {
        for (int a = 0; a < sub; a++) {
            double d[3];
            const double u = 2 * (t.x + (a + 0.5) / sub) / n - 1;
            const double v = 2 * (t.y + (b + 0.5) / sub) / n - 1;
            const double density = pow(1 + u * u + v * v, -1.5);
            truth_cube_direction(n, t.face, t.x + (a + 0.5) / sub - 0.5,
                                 t.y + (b + 0.5) / sub - 0.5, d);
            const double phi = remainder(atan2(d[2], d[0]) + yaw, 2 * M_PI);
            sum += density * map_value(f, atan2(hypot(d[0], d[2]), d[1]), phi);
            weights += density;
        }
    }
    return sum / weights;
}

static void compare_texels(int w, int h, int base, int n, double yaw_deg,
                           int sub, double tol)
{
    subject *it = subject_make(2, w, h, 77, yaw_deg);
    const finer f = finer_of(&it->env, base);

    for (int face = 0; face < 6; face++) {
        const ibl_texel t[3] = {
            {face, n / 2, n / 2}, {face, 0, n - 1}, {face, n / 3, n / 4}};
        double rgb[9];
        CHECK(!ibl_reference_texels(subject_ref(it), IBL_PROJECTION_CUBE, base,
                                    n, t, 3, rgb));
        for (int k = 0; k < 3; k++) {
            const double want =
                texel_points(&f, n, t[k], yaw_deg / 180 * M_PI, sub);
            CHECK_MSG(fabs(rgb[3 * k] - want) <= tol,
                      "%dx%d to %d of %d, face %d (%d, %d): %.9g, not %.9g", w,
                      h, n, base, face, t[k].x, t[k].y, rgb[3 * k], want);
        }
    }
}

/* Points see the boundaries of patches to a point's share of a texel. */
TEST_OF(texels, "texels", TEST_RACES)
{
    compare_texels(64, 32, 8, 8, 20, 300, 1e-3);
    compare_texels(67, 35, 5, 5, -50, 300, 1e-3);
    compare_texels(5, 3, 7, 7, 130, 150, 5e-4);
    compare_texels(1, 1, 3, 3, 0, 40, 1e-6);
    compare_texels(2, 1, 4, 4, 10, 150, 5e-4);
    compare_texels(40, 64, 12, 12, 10, 150, 1e-3);
    compare_texels(64, 8, 8, 8, 10, 150, 1e-3);
    compare_texels(12, 6, 150, 150, 70, 60, 5e-4);
    /* Mips of what is larger. */
    compare_texels(64, 32, 16, 4, 20, 300, 1e-3);
    compare_texels(9, 7, 64, 8, 0, 300, 1e-3);
}

/* ---- tables ---------------------------------------------------------------
 */

/* Mirrors: 1 - Fc and Fc. alpha = 1: D = 1/pi, Smith's vis 1 / (2 (N.L + N.V)),
 * so R + G = integral of 2 x / (2 (x + nv)) dx = 1 - nv ln((1 + nv) / nv), and
 * Schlick's, k = 1/2, 1 / ((x + 1) (nv + 1)):
 *     integral of 2 x / ((x + 1) (nv + 1)) dx = 2 (1 - ln 2) / (nv + 1). */
TEST(lut_ends)
{
    for (int k = 0; k < 26; k++) {
        const ibl_geometry g = (ibl_geometry)(k % 2);
        const double nv = k < 18 ? k / 2 / 8.0 : pow(10, 6 - k / 2);
        const double fc = pow(1 - nv, 5);
        double out[2];
        reference_lut(nv, 0, g, out);
        CHECK_NEAR(out[0], 1 - fc, 1e-15);
        CHECK_NEAR(out[1], fc, 1e-15);
        if (nv >= 0.1 || g == IBL_GEOMETRY_SMITH) {
            reference_lut(nv, nv >= 0.1 ? 1e-5 : 1e-6, g, out);
            CHECK_NEAR(out[0], 1 - fc, nv >= 0.1 || nv == 0 ? 1e-8 : 1e-3);
        }
        reference_lut(nv, 1, g, out);
        CHECK_NEAR(out[0] + out[1],
                   g        ? 2 * (1 - log(2.0)) / (nv + 1)
                   : nv > 0 ? 1 - nv * log((1 + nv) / nv)
                            : 1,
                   1e-9);
    }
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
                    f * truth_shadowing((ibl_geometry)g, a, nl, nv);
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
    for (int n = 0; n < 8; n++) {
        double grid[2][2], fast[2];
        lut_over_slopes(points[n][0], points[n][1], grid);
        for (int g = 0; g < 2; g++) {
            reference_lut(points[n][0], points[n][1], (ibl_geometry)g, fast);
            CHECK_NEAR(fast[0], grid[g][0], 2e-5);
            CHECK_NEAR(fast[1], grid[g][1], 2e-5);
        }
    }
}

/* Smith's Lambda of Charlie's D, Estevez and Kulla's figures by hand. */
static double lambda(double x, double a)
{
    const double s = (1 - a) * (1 - a), t = 1 - s;
    const double p[5] = {25.3245 * s + 21.5473 * t, 3.32435 * s + 3.82987 * t,
                         0.16801 * s + 0.19823 * t, -1.27393 * s - 1.97760 * t,
                         -4.85967 * s - 4.32054 * t};
    const double y = x < 0.5 ? x : 1 - x;
    const double l = p[0] / (1 + p[1] * pow(y, p[2])) + p[3] * y + p[4];
    const double middle =
        p[0] / (1 + p[1] * pow(0.5, p[2])) + p[3] * 0.5 + p[4];

    return exp(x < 0.5 ? l : 2 * middle - l);
}

/* E by equal steps over directions L: N.L = m^2, which is denser at the
 * horizon, and phi. */
static void sheen_by_light(double nv, double r, double e[2])
{
    enum {
        N = 700
    };
    const double a = r * r, sv = sqrt(1 - nv * nv), pi = acos(-1);

    e[0] = e[1] = 0;
    for (int i = 0; i < N; i++) {
        const double m = (i + 0.5) / N, nl = m * m, sl = sqrt(1 - nl * nl);
        const double both = 1 + lambda(nv, a) + lambda(nl, a);
        for (int k = 0; k < N; k++) {
            const double vl = nv * nl + sv * sl * cos(pi * (k + 0.5) / N);
            const double nh2 = (nv + nl) * (nv + nl) / (2 + 2 * vl);
            const double d = (2 + 1 / a) / (2 * pi) *
                             pow(fmax(1 - nh2, 0), 0.5 / a) * nl * 2 * m / N *
                             2 * pi / N;
            e[0] += d / (4 * (nl + nv - nl * nv));
            e[1] += d / (4 * nl * nv * both);
        }
    }
}

static const double points[][2] = {{0.03, 0.1}, {0.2, 0.25}, {0.5, 0.6},
                                   {0.77, 0.9}, {0.1, 1},    {0.95, 0.5}};

/* The reference itself, and its closed form at N.V = 1, alpha = 1: with
 * Ashikhmin's V, D = 3 sin(theta_h) / 2pi and x = sin(theta_h)
 *     E = 3 integral of x^2 (1 - 2 x^2) dx over 0..sqrt(1/2) = sqrt(1/2) / 5 */
TEST_SLOW(sheen)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    double e[2], want[2];

    NEED(!ibl_reference_sheen(ctx, 1, 1, e));
    CHECK_NEAR(e[0], sqrt(0.5) / 5, 1e-9);
    for (size_t k = 0; k < sizeof points / sizeof *points; k++) {
        NEED(!ibl_reference_sheen(ctx, points[k][0], points[k][1], e));
        sheen_by_light(points[k][0], points[k][1], want);
        CHECK_NEAR(e[0], want[0], 2e-4);
        CHECK_NEAR(e[1], want[1], 2e-4);
    }
}

/* ---- the rules of every call ----------------------------------------------
 */

enum {
    OUT = 27
};

/* The calls for one direction. */
static ibl_status call(int k, ibl_ctx *ctx, const ibl_reference *ref,
                       const double d[3], double out[OUT])
{
    static const double r[3] = {0.5, 0.1, 1};
    static const ibl_texel texel = {2, 5, 3};
    memset(out, 0, OUT * sizeof *out);
    switch (k) {
    case 0:
        return ibl_reference_lobe(ref, IBL_LOBE_GGX, 0.5, d, 1, out);
    case 1:
        return ibl_reference_lobe(ref, IBL_LOBE_CHARLIE, 0.1, d, 1, out);
    case 2:
        return ibl_reference_irradiance(ref, d, 1, out);
    case 3:
        return ibl_reference_texels(ref, IBL_PROJECTION_CUBE, 20, 20, &texel, 1,
                                    out);
    case 4:
        return ibl_reference_sh(ref, 2, out);
    case 5:
        return ibl_reference_brdf(ref, IBL_GEOMETRY_SMITH, r, 3, d, d, 1, out);
    default:
        return ibl_reference_lut(ctx, 0.5, 0.5, IBL_GEOMETRY_SMITH, out);
    }
}

enum {
    CALLS = 7
};

/* Any number of threads and directions at once gives the same bytes, plain C
 * nearly the same. A call that is cancelled says so. */
TEST(threads_and_cancel)
{
    static const int counts[] = {1, 2, 7};
    double first[CALLS][OUT], out[OUT], dirs[60], rgb[60];
    test_random rnd = {6};
    for (int k = 0; k < 20; k++)
        random_direction(&rnd, dirs + 3 * k);
    for (int k = 0; k < 4; k++) {
        const subject *it = subject_make(1, 100, 51, 2, 5);
        ibl_ctx *ctx =
            k < 3 ? test_ctx(counts[k], IBL_ISA_AUTO) : test_ctx(2, IBL_ISA_C);
        const ibl_reference *ref = reference_of(ctx, &it->env, 5);
        CHECK(!ibl_reference_lobe(ref, IBL_LOBE_GGX, 0.5, dirs, 20, rgb));
        for (int i = 0; i < CALLS; i++) {
            CHECK(!call(i, ctx, ref, dirs + 57, out));
            if (k == 0)
                memcpy(first[i], out, sizeof out);
            CHECK_MSG(k == 3 || !memcmp(first[i], out, sizeof out),
                      "call %d: other bytes from %d threads", i, counts[k % 3]);
            for (int c = 0; c < OUT; c++)
                CHECK_NEAR(out[c], first[i][c], 1e-11 * fabs(out[c]) + 1e-14);
        }
        CHECK(!memcmp(rgb + 57, first[0], 3 * sizeof *rgb) || k == 3);
        ibl_ctx_cancel(ctx);
        for (int i = 0; i < CALLS; i++)
            CHECK(call(i, ctx, ref, dirs, out) == IBL_ERR_CANCELLED);
    }
}

/* Each is refused with words, and writes nothing. */
TEST(refuses)
{
    test_messages kept = {0};
    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    const ibl_image env = map_constant(ctx, 8, 4, 1), no_map = {0};
    const ibl_reference *ref = reference_of(ctx, &env, -1000);
    ibl_reference *made = NULL;
    const double up[3] = {0, 1, 0}, down[3] = {0.1, -1, 0}, none[3] = {0};
    const double nan3[3] = {NAN, 0, 1}, r[2] = {0.5, 1.5};
    const ibl_texel bad[4] = {{6, 0, 0}, {0, 4, 0}, {0, 0, -1}, {-1, 0, 0}};
    double out[2 * SUMS] = {7, 7, 7};
#define REFUSED(words, call)                                                   \
    CHECK((call) == IBL_ERR_ARGUMENT && test_said(&kept, words))
#define SURFACE(...) ibl_reference_brdf(ref, __VA_ARGS__, 1, out)
    REFUSED("", ibl_reference_create(ctx, &no_map, 0, &made));
    REFUSED("", ibl_reference_create(ctx, &env, INFINITY, &made));
    REFUSED("", ibl_reference_lobe(ref, IBL_LOBE_GGX, -0.1, up, 1, out));
    REFUSED("", ibl_reference_lobe(ref, IBL_LOBE_GGX, 1.1, up, 1, out));
    REFUSED("", ibl_reference_lobe(ref, IBL_LOBE_GGX, NAN, up, 1, out));
    REFUSED("", ibl_reference_lobe(ref, (ibl_lobe)3, 0.5, up, 1, out));
    REFUSED("", ibl_reference_lobe(ref, (ibl_lobe)-1, 0.5, up, 1, out));
    REFUSED("", ibl_reference_lobe(ref, IBL_LOBE_GGX, 0.5, none, 1, out));
    REFUSED("", ibl_reference_irradiance(ref, nan3, 1, out));
    for (int k = 0; k < 4; k++)
        REFUSED("", ibl_reference_texels(ref, IBL_PROJECTION_CUBE, 4, 4,
                                         &bad[k], 1, out));
    REFUSED("",
            ibl_reference_texels(ref, IBL_PROJECTION_CUBE, 1, 0, bad, 0, out));
    REFUSED("", ibl_reference_sh(ref, -1, out));
    REFUSED("", ibl_reference_sh(ref, 65, out));
    REFUSED("", ibl_reference_lut(ctx, 1.1, 0.5, IBL_GEOMETRY_SMITH, out));
    REFUSED("", ibl_reference_lut(ctx, 1, NAN, IBL_GEOMETRY_SMITH, out));
    REFUSED("", ibl_reference_lut(ctx, 1, 1, (ibl_geometry)9, out));
    REFUSED("", ibl_reference_sheen(ctx, 0, 1, out));
    REFUSED("", ibl_reference_sheen(ctx, 1, 0, out));
    REFUSED("roughness of 1.5", SURFACE(IBL_GEOMETRY_SMITH, r, 2, up, up));
    REFUSED("0 roughnesses", SURFACE(IBL_GEOMETRY_SMITH, r, 0, up, up));
    REFUSED("geometry 7", SURFACE((ibl_geometry)7, r, 1, up, up));
    REFUSED("below the surface", SURFACE(IBL_GEOMETRY_SMITH, r, 1, up, down));
    REFUSED("must be a unit", SURFACE(IBL_GEOMETRY_SMITH, r, 1, none, up));
    REFUSED("must be a unit", SURFACE(IBL_GEOMETRY_SMITH, r, 1, up, none));
    CHECK(!made && out[0] == 7 && out[1] == 7 && out[2] == 7);
    CHECK(!ibl_reference_lobe(ref, IBL_LOBE_GGX, 0.3, NULL, 0, NULL));
}
