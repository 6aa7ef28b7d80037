/* SPDX-License-Identifier: MIT */
/* Mip chains, the pyramid for lookups, and what a level stands for. */
#include <math.h>
#include <string.h>

#include "ibl/ibl.h"
#include "image/cube.h"
#include "image/pyramid.h"
#include "maps.h"

static int all_levels(int size)
{
    int levels = 1;
    while (size >> levels)
        levels++;
    return levels;
}

/* Level 0 random over six decades; the rest NaN, to be overwritten. */
static ibl_cube random_cube(ibl_ctx *ctx, int size)
{
    test_random r = {(uint64_t)size};
    ibl_cube cube = cube_alloc(ctx, size, all_levels(size));
    for (size_t i = 0; i < cube_floats(&cube); i++)
        cube.data[i] = i < 18 * (size_t)size * (size_t)size
                           ? (float)pow(10, 6 * test_random_unit(&r) - 3)
                           : NAN;
    return cube;
}

static double level_energy(const ibl_cube *cube, int level, int channel)
{
    const int n = ibl_cube_edge(cube->size, level);
    double sum = 0;
    for (int f = 0; f < IBL_FACES; f++) {
        const float *p = ibl_cube_face(cube, level, f);
        for (int i = 0; i < n * n; i++)
            sum += (double)p[3 * i + channel] *
                   ibl_cube_solid_angle(n, i % n, i / n);
    }
    return sum;
}

/* Texel (x, y) of m from n by many small cells, none of them split. */
static double by_cells(const float *above, int n, int m, int x, int y)
{
    const int cells = 8 * n * m, span = cells / m, child = cells / n;
    double sum = 0, weights = 0;
    for (int j = y * span; j < (y + 1) * span; j++) {
        for (int i = x * span; i < (x + 1) * span; i++) {
            const double u = 2 * (i + .5) / cells - 1;
            const double v = 2 * (j + .5) / cells - 1;
            const double w = pow(1 + u * u + v * v, -1.5);
            sum += w * (double)above[3 * (j / child * n + i / child)];
            weights += w;
        }
    }
    return sum / weights;
}

/* Level 0's mean for each channel, what is constant to the last bit, and of
 * level 1 each texel. */
TEST(mips)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    for (int n = 1; n < 102; n += n < 16 ? 1 : 17) {
        ibl_cube cube = random_cube(ctx, n);
        CHECK(!ibl_cube_build_mips(ctx, &cube));
        for (int i = 3; i < 3 * cube.levels; i++) {
            const double want = level_energy(&cube, 0, i % 3);
            const double got = level_energy(&cube, i / 3, i % 3);
            CHECK_MSG(fabs(got - want) <= 1e-6 * want,
                      "size %d level %d channel %d: %.9g, not %.9g", n, i / 3,
                      i % 3, got, want);
        }
        const int m = n / 2;
        for (int i = 0; n < 10 && i < IBL_FACES * m * m; i++) {
            const int face = i / (m * m), x = i % m, y = i / m % m;
            const double want =
                by_cells(ibl_cube_face(&cube, 0, face), n, m, x, y);
            const double got =
                (double)ibl_cube_face(&cube, 1, face)[3 * (y * m + x)];
            CHECK_NEAR(got, want, 2e-3 * want);
        }
        bool same = true;
        for (size_t i = 0; i < cube_floats(&cube); i++)
            cube.data[i] = i < 18 * (size_t)(n * n) ? 0.3f : NAN;
        CHECK(!ibl_cube_build_mips(ctx, &cube));
        for (size_t i = 0; i < cube_floats(&cube); i++)
            same = same && cube.data[i] == 0.3f;
        CHECK_MSG(same, "size %d", n);
    }
}

/* ---- pyramid ---------------------------------------------------------- */

static const float *texel(const ibl_pyramid *p, int level, int face, int x,
                          int y)
{
    const int row = (p->size >> level) + 2;
    return p->texels[level] + 4 * ((face * row + y + 1) * row + x + 1);
}

/* What lies beyond a corner of a face is the mean of the three that meet; each
 * level has level 0's energy, and the least of each channel wherever it is. */
TEST(pyramids)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_cube cube = random_cube(ctx, 64);
    ibl_pyramid p;
    for (int k = 0; k < 5; k++) {
        const int i = 3 * (k * 4915 + 64 * 64 - 1) + k % 3;
        const float was = cube.data[i];
        cube.data[i] = 1e-5f;
        NEED(!ibl_pyramid_create(ctx, &cube, 7, &p));
        CHECK_MSG(p.floor[k % 3] == cube.data[i], "%d: %g", i,
                  (double)p.floor[k % 3]);
        const double whole = level_energy(&cube, 0, 1);
        for (int l = 0; l < 7; l++) {
            const int n = 64 >> l;
            double angle = 0, energy = 0;
            for (int t = 0; t < IBL_FACES * n * n; t++) {
                const float *at = texel(&p, l, t / (n * n), t % n, t / n % n);
                angle += (double)at[3];
                energy += (double)at[3] * ((double)at[1] + (double)p.floor[1]);
            }
            CHECK_NEAR(angle, 4 * M_PI, 4e-6 * M_PI);
            CHECK_NEAR(energy, whole, 1e-6 * whole);
            for (int t = 0; t < IBL_FACES * 4; t++) {
                const int face = t / 4, c = t % 4;
                const double mean = ((double)texel(&p, l, face, 0, 0)[c] +
                                     (double)texel(&p, l, face, -1, 0)[c] +
                                     (double)texel(&p, l, face, 0, -1)[c]) /
                                    3;
                CHECK_NEAR(texel(&p, l, face, -1, -1)[c], mean, 1e-6 * mean);
            }
        }
        cube.data[i] = was;
        ibl_pyramid_free(&p);
    }
}

/* ---- levels ----------------------------------------------------------- */

/* Cubes of any size down to one texel, images of any two edges, no others. */
TEST(shapes)
{
    test_messages kept;
    ibl_ctx *quiet = test_keeping_ctx(1, &kept);
    ibl_cube cube = {0};
    ibl_image img = {0};
    for (int i = 0; i < 70 * 9; i++) {
        const int size = i / 9, levels = i % 9;
        const bool is = size && levels && levels <= ilogb(size) + 1;
        CHECK_MSG(!ibl_cube_alloc(quiet, size, levels, &cube) == is,
                  "size %d, %d levels", size, levels);
        ibl_cube_free(&cube);
    }
    CHECK(ibl_cube_alloc(quiet, IBL_MAX_CUBE_SIZE + 1, 1, &cube) ==
          IBL_ERR_ARGUMENT);
    for (int i = 0; i < 8; i++) {
        const int edges[] = {0, 1, IBL_MAX_EDGE, IBL_MAX_EDGE + 1};
        const int w = i % 2 ? 1 : edges[i / 2], h = i % 2 ? edges[i / 2] : 1;
        CHECK_MSG(!ibl_image_alloc(quiet, w, h, &img) ==
                      (i / 2 == 1 || i / 2 == 2),
                  "%dx%d", w, h);
        ibl_image_free(&img);
    }
}

/* getLodFromAlphaG of Babylon.js, at its default scale, finds each level. */
TEST(roughness_of_babylon)
{
    for (int size = 1; size <= 300; size = 2 * size + (size == 8)) {
        ibl_specular_options o = ibl_specular_options_default();
        ibl_specular_layout l;
        o.mapping = IBL_ROUGHNESS_BABYLON;
        o.size = size;
        NEED(!ibl_specular_layout_of(&o, &l));
        CHECK(l.size == size && l.levels == (int)log2(size) + 1);
        CHECK(l.roughness[0] == 0);
        for (int i = 1; i < l.levels; i++) {
            const double alpha = l.roughness[i] * l.roughness[i];
            CHECK(alpha <= 1 && l.roughness[i] >= l.roughness[i - 1]);
            if (alpha < 1)
                CHECK_NEAR(0.8 * log2(size * alpha), i, 1e-12);
            CHECK_NEAR(ibl_lod_of_roughness(&l, l.roughness[i]),
                       fmin(i, 0.8 * log2(size)), 1e-12);
            if (size == 1 << (l.levels - 1))
                CHECK_NEAR(ibl_level_roughness(o.mapping, i, l.levels),
                           l.roughness[i], 1e-15);
        }
        CHECK_NEAR(ibl_lod_of_roughness(&l, 0.5),
                   fmax(0.8 * log2(0.25 * size), 0), 1e-12);
        CHECK(ibl_lod_of_roughness(&l, 0) == 0);
        const double second = l.roughness[1];
        o.levels = l.levels < 3 ? l.levels : 3;
        NEED(!ibl_specular_layout_of(&o, &l));
        CHECK(l.levels == o.levels && l.roughness[1] == second);
        o.roughness_min = 0.1;
        CHECK(ibl_specular_layout_of(&o, &l) == IBL_ERR_ARGUMENT);
    }
}

static ibl_specular_layout layout_of(int size, int levels, double low,
                                     double high, ibl_roughness_map map)
{
    ibl_specular_options o = ibl_specular_options_default();
    ibl_specular_layout l = {0};
    o.method = IBL_METHOD_SAMPLED;
    o.size = size;
    o.levels = levels;
    o.mapping = map;
    o.roughness_min = low;
    o.roughness_max = high;
    CHECK(!ibl_specular_layout_of(&o, &l));
    return l;
}

/* The whole range is the chain of a size, by the mapping's formula. */
TEST(whole_range_is_the_chain)
{
    static const int known[][2] = {{256, 6}, {128, 5}, {8, 1}, {15, 1}, {16, 2},
                                   {7, 3},   {4, 3},   {2, 2}, {1, 1}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        CHECK_MSG(ibl_default_levels(known[i][0]) == known[i][1],
                  "size %d: %d levels", known[i][0],
                  ibl_default_levels(known[i][0]));
    for (int i = 0; i < 2 * 600; i++) {
        const ibl_roughness_map map = (ibl_roughness_map)(i % 2);
        const int size = 1 + i / 2;
        const ibl_specular_layout l = layout_of(size, 0, 0, 1, map);
        CHECK(l.size == size && l.levels == ibl_default_levels(size));
        for (int k = 0; k < l.levels; k++) {
            const double r = ibl_level_roughness(map, k, l.levels);
            CHECK(l.roughness[k] == r);
            CHECK_NEAR(map == IBL_ROUGHNESS_LINEAR ? r : r * (2 - r),
                       l.levels > 1 ? (double)k / (l.levels - 1) : 0, 1e-15);
        }
    }
}

TEST(layouts_follow_their_lod)
{
    test_random random = {8};
    for (int i = 0; i < 3000; i++) {
        const int map = i % 2, size = 1 << (4 + i % 9);
        double a = test_random_unit(&random), b = test_random_unit(&random);
        if (a > b || i % 5 == 0) {
            const double c = b;
            b = a;
            a = i % 5 ? c : 0;
        }
        const ibl_specular_layout l =
            layout_of(size, 0, a, b, (ibl_roughness_map)map);
        const int last = ibl_cube_edge(l.size, l.levels - 1);
        const double need = 5 * 3.14159265358979 / 2;
        CHECK(l.size <= size && l.size >= 1 << (l.levels - 1));
        CHECK(a > 0 ? l.size <= need / (a * a) + (1 << (l.levels - 1))
                    : l.size == size);
        CHECK(l.levels == 2 || last >= 0.7 * need / (b * b) - 1 ||
              last >= 0.7 * size *
                              exp2(-(map ? b * (2 - b) : b) *
                                   (ibl_default_levels(size) - 1)) -
                          1);
        /* Half an octave up or down, and a texel of rounding. */
        CHECK(last <=
              1 + sqrt(2) * fmin(need / (b * b),
                                 size * exp2(-(map ? b * (2 - b) : b) *
                                             (ibl_default_levels(size) - 1))));
        CHECK(l.lod_offset <= 0 && (a > 0 || !signbit(l.lod_offset)));
        CHECK_NEAR(l.roughness[0], a, 1e-12);
        CHECK_NEAR(l.roughness[l.levels - 1], b, 1e-12);
        for (int k = 0; k < l.levels; k++) {
            const double r = l.roughness[k], x = map ? r * (2 - r) : r;
            CHECK_NEAR(x * l.lod_scale + l.lod_offset, k, 1e-6);
            CHECK_NEAR(ibl_lod_of_roughness(&l, r), k, 1e-6);
        }
        if (a > 0)
            CHECK(l.size % (1 << (l.levels - 1)) == 0 || l.size == size);
    }
    /* What the whole chain has for these roughnesses. */
    const ibl_specular_layout l = layout_of(256, 0, 0.2, 1, 0);
    CHECK(l.size == 128 && l.levels == 5);
    const ibl_specular_layout m = layout_of(4096, 0, 0.5, 1, 0);
    CHECK(m.size == 32 && m.levels == 3);
    const ibl_specular_layout one = layout_of(256, 0, 0.5, 0.5, 0);
    CHECK(one.levels == 1 && one.roughness[0] == 0.5 && one.lod_scale == 0);
}
