/* SPDX-License-Identifier: MIT */
/*
 * The truth itself, against closed forms and against plainer sums, long
 * double where precision could matter; the library is not called.
 */
#include "reference.h"
#include "truth.h"

#include <math.h>
#include <stdlib.h>

/* ---- directions ------------------------------------------------------ */

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

/* The addition theorem: the sum over m of products is (2l + 1) / 4pi P_l. */
TEST(sh_products)
{
    test_random r = {3};
    for (int n = 0; n < 20; n++) {
        double a[3], b[3], p = 1, before = 0;
        random_direction(&r, a);
        random_direction(&r, b);
        for (int l = 0; l <= 64; l++) {
            const double x = test_dot(a, b);
            const double next = ((2 * l + 1) * x * p - l * before) / (l + 1);
            double sum = 0;
            for (int m = -l; m <= l; m++)
                sum += truth_sh(l, m, a) * truth_sh(l, m, b);
            CHECK_NEAR(sum * 4 * M_PI / (2 * l + 1), p, 1e-11);
            before = p;
            p = next;
        }
    }
}

/* All pixels together are the whole, from a pole and on the seam, too. */
TEST(pixels_make_the_integral)
{
    static const double d[][3] = {
        {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0.48, 0.6, -0.64}};
    for (int k = 0; k < 48; k++) {
        const ibl_lobe lobe = (ibl_lobe)(k / 16);
        const double r = 1 - 0.25 * (k / 4 % 4);
        double sum = 0;
        for (int i = 0; i < 21 * 10; i++)
            sum +=
                truth_pixel_weight(21, 10, i % 21, i / 21, d[k % 4], lobe, r);
        CHECK_NEAR(sum / truth_lobe_integral(lobe, r * r), 1, 2e-6);
    }
}
