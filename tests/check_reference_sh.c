/* SPDX-License-Identifier: MIT */
/* The reference's spherical harmonics against closed forms. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reference.h"

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

TEST(orthonormal)
{
    subject *it = subject_make(2, 256, 128, 0, -70);

    for (int k = 0; k < 16; k += TEST_SANITIZED ? 5 : 1) {
        double a[3 * 36];
        for (int j = 0; j < 128; j++) {
            for (int i = 0; i < 256; i++) {
                double d[3];
                polar_direction(
                    M_PI * (j + 0.5) / 128,
                    2 * M_PI * ((i + 0.5) / 256 - 0.5) + 70 * M_PI / 180, d);
                map_pixel(&it->env, i, j)[1] = (float)harmonic(k, d);
            }
        }
        CHECK(!ibl_reference_sh(subject_ref(it), 5, a));
        for (int m = 0; m < 36; m++) {
            CHECK_NEAR(a[3 * m + 1], m == k, 1e-3);
            CHECK(a[3 * m] == 0);
        }
    }
}

/* A pixel's coefficients are L times Y's integral, by points in its patch. */
TEST(one_patch)
{
    enum {
        SUB = 64
    };
    const int at[][2] = {{0, 0}, {17, 9}, {36, 18}, {5, 13}};
    double *a = malloc(3 * 16 * sizeof *a);

    NEED(a);
    for (int k = 0; k < 4; k++) {
        const int i = at[k][0], j = at[k][1];
        subject *it = subject_make(2, 37, 19, 0, 15);
        const double flux = 1000 * (double)row_angle(37, 19, j);
        double want[16] = {0};
        map_pixel(&it->env, i, j)[2] = 1000;
        for (int n = 0; n < SUB * SUB; n++) {
            const int y = j * SUB + n / SUB, x = i * SUB + n % SUB;
            double d[3];
            polar_direction(
                M_PI * (y + 0.5) / (19 * SUB),
                2 * M_PI * ((x + 0.5) / (37 * SUB) - 0.5) - 15 * M_PI / 180, d);
            for (int m = 0; m < 16; m++)
                want[m] += 1000 * (double)row_angle(37 * SUB, 19 * SUB, y) *
                           harmonic(m, d);
        }
        CHECK(!ibl_reference_sh(subject_ref(it), 3, a));
        /* The midpoints leave (l / 37 / 64)^2 / 2. */
        for (int m = 0; m < 16; m++)
            CHECK_NEAR(a[3 * m + 2], want[m], 1e-4 * flux);
    }
    free(a);
}

/* Pixels split into equal parts change nothing, also beyond a batch of rows. */
TEST(divided)
{
    enum {
        PARTS = 4096
    };
    subject *one = subject_make(2, 4, 65, 7, 15);
    subject *all = subject_make(2, 4 * PARTS, 65, 0, 15);
    double a[3 * 9], b[3 * 9];

    for (int k = 0; k < 4 * PARTS * 65; k++)
        memcpy(all->env.data + 3 * (size_t)k,
               one->env.data + 3 * (size_t)(k / PARTS),
               3 * sizeof *one->env.data);
    CHECK(!ibl_reference_sh(subject_ref(one), 2, a));
    CHECK(!ibl_reference_sh(subject_ref(all), 2, b));
    for (int k = 0; k < 3 * 9; k++)
        CHECK_NEAR(a[k], b[k], 3e-8 * a[k % 3]);
}

/* The same in four parts, which take other points of Gauss' rules. */
TEST_SLOW(in_four)
{
    subject *one = subject_make(2, 60, 30, 7, 15);
    subject *all = subject_make(2, 120, 60, 0, 15);
    double a[3 * 400], b[3 * 400];

    for (int i = 0; i < 120 * 60; i++)
        memcpy(map_pixel(&all->env, i % 120, i / 120),
               map_pixel(&one->env, i % 120 / 2, i / 240), 3 * sizeof(float));
    for (int degree = 0; degree < 20; degree++) {
        CHECK(!ibl_reference_sh(subject_ref(one), degree, a));
        CHECK(!ibl_reference_sh(subject_ref(all), degree, b));
        for (int k = 0; k < 3 * (degree + 1) * (degree + 1); k++)
            CHECK_NEAR(a[k], b[k], 3e-8 * a[k % 3]);
    }
}
