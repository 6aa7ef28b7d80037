/* SPDX-License-Identifier: MIT */
/* The reference's spherical harmonics against closed forms. */
#include <math.h>
#include <string.h>

#include "reference.h"
#include "truth.h"

/* Y_lm sampled on the map gives 1 at (l, m) and little elsewhere. */
TEST(orthonormal)
{
    subject *it = subject_make(2, 256, 128, 0, -70);

    for (int k = 0; k < 16; k += TEST_SANITIZED ? 5 : 1) {
        const int l = (int)sqrt(k);
        double a[3 * 36];
        for (int j = 0; j < 128; j++) {
            for (int i = 0; i < 256; i++) {
                double d[3];
                polar_direction(
                    M_PI * (j + 0.5) / 128,
                    2 * M_PI * ((i + 0.5) / 256 - 0.5) + 70 * M_PI / 180, d);
                map_pixel(&it->env, i, j)[1] =
                    (float)truth_sh(l, k - l * l - l, d);
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
        SUB = 32,
        DEGREE = 12,
        COUNT = (DEGREE + 1) * (DEGREE + 1)
    };
    const int at[][2] = {{0, 0}, {17, 9}, {36, 18}, {5, 13}};
    double a[3 * COUNT];

    for (int k = 0; k < 4; k++) {
        const int i = at[k][0], j = at[k][1];
        subject *it = subject_make(2, 37, 19, 0, 15);
        const double flux = 1000 * (double)row_angle(37, 19, j);
        double want[COUNT] = {0};
        map_pixel(&it->env, i, j)[2] = 1000;
        for (int n = 0; n < SUB * SUB; n++) {
            const int y = j * SUB + n / SUB, x = i * SUB + n % SUB;
            double d[3];
            polar_direction(
                M_PI * (y + 0.5) / (19 * SUB),
                2 * M_PI * ((x + 0.5) / (37 * SUB) - 0.5) - 15 * M_PI / 180, d);
            for (int l = 0; l <= DEGREE; l++)
                for (int m = -l; m <= l; m++)
                    want[l * l + l + m] +=
                        1000 * (double)row_angle(37 * SUB, 19 * SUB, y) *
                        truth_sh(l, m, d);
        }
        CHECK(!ibl_reference_sh(subject_ref(it), DEGREE, a));
        /* The midpoints leave (l / 37 / 32)^2 / 2 of it. */
        for (int m = 0; m < COUNT; m++)
            CHECK_NEAR(a[3 * m + 2], want[m], 4e-4 * flux);
    }
}

/* Pixels in four parts, which take other points of Gauss' rules. */
TEST_SLOW(in_four)
{
    subject *one = subject_make(2, 60, 30, 7, 15);
    subject *all = subject_make(2, 120, 60, 0, 15);
    double a[3 * 400], b[3 * 400];

    for (int i = 0; i < 120 * 60; i++)
        memcpy(map_pixel(&all->env, i % 120, i / 120),
               map_pixel(&one->env, i % 120 / 2, i / 240), 3 * sizeof(float));
    for (int degree = 1; degree < 20; degree += 6) {
        CHECK(!ibl_reference_sh(subject_ref(one), degree, a));
        CHECK(!ibl_reference_sh(subject_ref(all), degree, b));
        for (int k = 0; k < 3 * (degree + 1) * (degree + 1); k++)
            CHECK_NEAR(a[k], b[k], 3e-8 * a[k % 3]);
    }
}
