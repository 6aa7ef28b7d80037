/* SPDX-License-Identifier: MIT */
/* Outputs in other axes: directions, texels, harmonics. */
#include <math.h>
#include <string.h>

#include <ibl/io.h>

#include "reference.h"
#include "textures.h"
#include "truth.h"

enum {
    AXES = 8
};

static ibl_axes axes_of(int i)
{
    return (ibl_axes){(ibl_mirror)(i / 2), (ibl_up)(i % 2)};
}

/* By the words of <ibl/ibl.h>. */
static void turned(int i, const double from[3], double to[3])
{
    static const int at[4] = {0, 0, 0, 2};
    const double a = from[at[i / 2]], y = from[1], b = from[2 - at[i / 2]];
    const double x = i / 2 == 1 ? -a : a, z = i / 2 == 2 ? -b : b;
    const double up_y[3] = {x, y, z}, up_z[3] = {x, -z, y};
    memcpy(to, i % 2 ? up_z : up_y, sizeof up_y);
}

TEST(directions)
{
    test_random r = {1};
    for (int i = 0; i < 20 * AXES; i++) {
        double d[3], want[3], got[3];
        random_direction(&r, d);
        turned(i % AXES, d, want);
        ibl_axes_turn(axes_of(i % AXES), 0, d, got);
        CHECK(!memcmp(got, want, sizeof got));
        ibl_axes_turn(axes_of(i % AXES), 1, got, got);
        CHECK(!memcmp(got, d, sizeof got));
    }
}

/* ---- cubes ------------------------------------------------------------ */

/* The texel that has a centre. */
static const float *texel_at(const ibl_cube *cube, int level, const double d[3])
{
    const int n = ibl_cube_edge(cube->size, level);
    for (int i = 0; i < IBL_FACES * n * n; i++) {
        double e[3];
        ibl_cube_direction(n, i / (n * n), i % n, i / n % n, e);
        if (test_dot(d, e) > 1 - 1e-14)
            return ibl_cube_face(cube, level, 0) + 3 * (ptrdiff_t)i;
    }
    test_leave();
}

static ibl_cube random_cube(ibl_ctx *ctx, int size, int levels)
{
    ibl_cube cube = cube_alloc(ctx, size, levels);
    test_random r = {7};
    for (size_t i = 0; i < cube_floats(&cube); i++)
        cube.data[i] = (float)test_random_unit(&r);
    return cube;
}

TEST(cubes_by_direction)
{
    static const int sizes[][2] = {{1, 1}, {2, 2}, {3, 2}, {6, 3}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    for (int i = 0; i < 4 * AXES; i++) {
        const int size = sizes[i / AXES][0], levels = sizes[i / AXES][1];
        ibl_cube from = random_cube(ctx, size, levels), to, back;
        NEED(!ibl_cube_turn_axes(ctx, &from, axes_of(i % AXES), 0, &to));
        test_cube(to);
        for (int l = 0; l < levels; l++) {
            const int n = ibl_cube_edge(size, l);
            for (int t = 0; t < IBL_FACES * n * n; t++) {
                double d[3], want[3];
                ibl_cube_direction(n, t / (n * n), t % n, t / n % n, d);
                turned(i % AXES, d, want);
                CHECK(!memcmp(texel_at(&to, l, want),
                              ibl_cube_face(&from, l, 0) + 3 * (ptrdiff_t)t,
                              3 * sizeof(float)));
            }
        }
        NEED(!ibl_cube_turn_axes(ctx, &to, axes_of(i % AXES), 1, &back));
        test_cube(back);
        CHECK(
            !memcmp(back.data, from.data, cube_floats(&from) * sizeof(float)));
    }
}

/* ---- harmonics -------------------------------------------------------- */

/* The function of the third channel. */
static double value_of(const double *c, int degree, const double d[3])
{
    double sum = 0;
    for (int l = 0; l <= degree; l++)
        for (int m = -l; m <= l; m++)
            sum += c[3 * (l * l + l + m) + 2] * truth_sh(l, m, d);
    return sum;
}

static void check_turned(int degree, int i, double tolerance)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const size_t count = 3 * (size_t)(degree + 1) * (size_t)(degree + 1);
    double *c = test_alloc(count, sizeof *c);
    double *to = test_alloc(count, sizeof *to);
    test_random r = {5};

    for (size_t k = 0; k < count; k++)
        to[k] = c[k] = test_random_between(&r, -1, 1);
    NEED(!ibl_sh_turn_axes(ctx, degree, axes_of(i), 0, to));
    for (int k = 0; k < 5; k++) {
        double d[3], e[3];
        random_direction(&r, d);
        turned(i, d, e);
        CHECK_NEAR(value_of(to, degree, e), value_of(c, degree, d), tolerance);
    }
    NEED(!ibl_sh_turn_axes(ctx, degree, axes_of(i), 1, to));
    for (size_t k = 0; k < count; k++)
        CHECK_NEAR(to[k], c[k], tolerance);
}

TEST(harmonics)
{
    for (int i = 0; i < AXES; i++)
        for (int degree = 0; degree < 12; degree += degree < 5 ? 1 : 6)
            check_turned(degree, i, 1e-13);
    check_turned(IBL_MAX_SH_DEGREE, 5, 1e-11);
}

TEST(refused)
{
    test_messages said;
    ibl_ctx *ctx = test_keeping_ctx(1, &said);
    ibl_cube cube = random_cube(ctx, 4, 1), out = {0};
    double sh[3] = {0};
    const ibl_axes bad = {.mirror = (ibl_mirror)9};
    const ibl_axes down = {.up = (ibl_up)-1};

    CHECK(ibl_cube_turn_axes(ctx, &cube, bad, 0, &out) == IBL_ERR_ARGUMENT);
    CHECK(test_said(&said, "mirror 9"));
    CHECK(ibl_sh_turn_axes(ctx, 0, down, 0, sh) == IBL_ERR_ARGUMENT);
    CHECK(test_said(&said, "up -1"));
    CHECK(ibl_sh_turn_axes(ctx, -1, axes_of(0), 0, sh) == IBL_ERR_ARGUMENT);
    CHECK(ibl_sh_turn_axes(ctx, IBL_MAX_SH_DEGREE + 1, axes_of(0), 0, sh) ==
          IBL_ERR_ARGUMENT);
    CHECK(!out.data);
}
