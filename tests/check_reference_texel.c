/* SPDX-License-Identifier: MIT */
/* Level 0's reference against points of texels, as ibl/ibl.h defines them. */
#include <math.h>

#include "reference.h"
#include "truth.h"

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
TEST_SLOW(texels)
{
    compare_texels(32, 16, 1, 1, 0, 400, 1e-3);
    compare_texels(64, 32, 8, 8, 20, 300, 1e-3);
    compare_texels(67, 35, 5, 5, -50, 300, 1e-3);
    compare_texels(16, 8, 16, 16, 0, 200, 5e-4);
    compare_texels(5, 3, 7, 7, 130, 200, 5e-4);
    compare_texels(1, 1, 3, 3, 0, 40, 1e-6);
    compare_texels(2, 1, 4, 4, 10, 200, 5e-4);
    compare_texels(40, 64, 12, 12, 10, 300, 1e-3);
    compare_texels(64, 8, 8, 8, 10, 300, 1e-3);
    compare_texels(12, 6, 150, 150, 70, 100, 5e-4);
    /* Mips of what is larger. */
    compare_texels(64, 32, 16, 4, 20, 300, 1e-3);
    compare_texels(16, 8, 32, 4, 0, 300, 1e-3);
    compare_texels(9, 7, 64, 8, 0, 300, 1e-3);
}

/* All texels, by their solid angles, make the mean of the source. */
TEST(texels_energy)
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
            CHECK(!ibl_reference_texels(subject_ref(it), IBL_PROJECTION_CUBE, n,
                                        n, &t, 1, rgb));
            for (int c = 0; c < 3; c++)
                sum[c] +=
                    rgb[c] * ibl_cube_solid_angle(n, t.x, t.y) / (4 * M_PI);
        }
        CHECK(!ibl_reference_mean(subject_ref(it), mean));
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(sum[c], mean[c], 3e-8);
    }
}
