/* SPDX-License-Identifier: MIT */
/* The reference of level 0 against points of texels, written out here from the
 * conventions in ibl/ibl.h. */
#include <math.h>
#include <string.h>

#include "reference.h"

static const double pi = 3.14159265358979323846;

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
        sum += weight *
               ((1 - f) * (double)map_pixel(env, (left + 2 * w) % w, row)[0] +
                f * (double)map_pixel(env, (left + 1 + 2 * w) % w, row)[0]);
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
    subject *it = subject_make(2, w, h, 77, yaw_deg);

    for (int face = 0; face < 6; face++) {
        const ibl_texel t[3] = {
            {face, n / 2, n / 2}, {face, 0, n - 1}, {face, n / 3, n / 4}};
        double rgb[9];
        CHECK(!ibl_reference_texels(it->ref, n, t, 3, rgb));
        for (int k = 0; k < 3; k++) {
            const double want =
                texel_points(&it->env, n, t[k], yaw_deg / 180 * pi, sub);
            CHECK_MSG(fabs(rgb[3 * k] - want) <= tol,
                      "%dx%d to %d, face %d (%d, %d): %.9g, not %.9g", w, h, n,
                      face, t[k].x, t[k].y, rgb[3 * k], want);
        }
    }
    subject_free(it);
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

    for (int k = 0; k < 8; k++) {
        const int n = sizes[k][2];
        subject *it = subject_make(2, sizes[k][0], sizes[k][1], 31, 12.5);
        double sum[3] = {0}, mean[3];
        for (int j = 0; j < 6 * n * n; j++) {
            const ibl_texel t = {j / (n * n), j % n, j / n % n};
            double rgb[3];
            CHECK(!ibl_reference_texels(it->ref, n, &t, 1, rgb));
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
        CHECK(!ibl_reference_mean(it->ref, mean));
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(sum[c], mean[c], 1e-9);
        subject_free(it);
    }
}

static const test tests[] = {TEST(texels), TEST(texels_energy)};
TEST_MAIN(tests)
