/* SPDX-License-Identifier: MIT */
/* Level 0: from an equirectangular map to a cube. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "test.h"
#include "truth.h"

#define PI 3.14159265358979323846

static ibl_ctx *ctx;

static void fill(ibl_image *img, int w, int h, float value)
{
    if (ibl_image_alloc(ctx, w, h, img))
        exit(1);
    for (size_t i = 0; i < 3 * (size_t)w * (size_t)h; i++)
        img->data[i] = value;
}

static void fill_random(ibl_image *img, int w, int h, uint64_t seed)
{
    test_random r = {seed};
    fill(img, w, h, 0);
    for (size_t i = 0; i < 3 * (size_t)w * (size_t)h; i++)
        img->data[i] = (float)exp(8 * test_random_unit(&r) - 4);
}

static void set(ibl_image *img, int i, int j, float value)
{
    float *p = img->data + 3 * ((size_t)j * (size_t)img->width + (size_t)i);
    p[0] = value;
    p[1] = 0.5f * value;
    p[2] = 0.25f * value;
}

static void bake(const ibl_image *img, double yaw, int n, ibl_cube *cube)
{
    if (ibl_cube_alloc(ctx, n, 1, cube) ||
        ibl_cube_from_latlong(ctx, img, yaw, cube))
        exit(1);
}

/* Mean over the sphere with the texels' exact solid angles. */
static void mean_of(const ibl_cube *cube, double mean[3])
{
    const int n = cube->size;
    mean[0] = mean[1] = mean[2] = 0;
    for (int f = 0; f < 6; f++) {
        const float *p = ibl_cube_face(cube, 0, f);
        for (int i = 0; i < n * n; i++) {
            const double w = ibl_cube_solid_angle(n, i % n, i / n) / (4 * PI);
            for (int c = 0; c < 3; c++)
                mean[c] += w * (double)p[3 * i + c];
        }
    }
}

static const int sizes[][3] = {/* map, faces */
                               {1, 1, 1},     {1, 1, 8},    {2, 1, 4},
                               {3, 2, 5},     {7, 5, 3},    {8, 4, 1},
                               {8, 4, 2},     {17, 9, 16},  {64, 32, 16},
                               {64, 32, 17},  {101, 53, 7}, {256, 128, 64},
                               {200, 37, 24}, {31, 200, 9}, {640, 320, 33}};
enum {
    SIZES = sizeof sizes / sizeof sizes[0]
};

static void constant_map(void)
{
    for (int k = 0; k < SIZES; k++) {
        ibl_image img;
        ibl_cube cube;
        int off = 0;
        fill(&img, sizes[k][0], sizes[k][1], 0.7f);
        bake(&img, 11.5 * k, sizes[k][2], &cube);
        for (size_t i = 0; i < 3 * ibl_cube_texels(cube.size, 1); i++)
            off += cube.data[i] != 0.7f;
        CHECK_MSG(off == 0, "%dx%d to %d: %d components off", sizes[k][0],
                  sizes[k][1], sizes[k][2], off);
        ibl_cube_free(&cube);
        ibl_image_free(&img);
    }
}

/* The texels partition the sphere, so what the map holds the cube holds. Two
 * terms are left: texels divide by the solid angle of their pieces, which are
 * right to fourth order (see check_property: up to 1e-5 in a few texels, of
 * either sign: 1e-7 over the sphere), and floats round (6e-8). */
static void energy(void)
{
    for (int k = 0; k < SIZES; k++) {
        ibl_image img;
        ibl_cube cube;
        double want[3], got[3];
        fill_random(&img, sizes[k][0], sizes[k][1], 7 + (uint64_t)k);
        set(&img, sizes[k][0] / 3, sizes[k][1] / 3, 1e6f);
        truth_mean(&img, want);
        bake(&img, 77 * k, sizes[k][2], &cube);
        mean_of(&cube, got);
        for (int c = 0; c < 3; c++)
            CHECK_MSG(fabs(got[c] / want[c] - 1) < 1e-6,
                      "%dx%d to %d: mean off by %.3g", sizes[k][0], sizes[k][1],
                      sizes[k][2], got[c] / want[c] - 1);
        ibl_cube_free(&cube);
        ibl_image_free(&img);
    }
}

/* One bright pixel on black, at every kind of place, keeps its energy and
 * stays where it is. */
static void sun(void)
{
    enum {
        W = 512,
        H = 256,
        N = 32
    };
    static const int at[][2] = {{0, 0},       {100, 0},    {W - 1, H - 1},
                                {0, 128},     {W - 1, 90}, {W / 2, 128},
                                {W / 8, 128}, {W / 8, 78}, {W / 8, 77},
                                {W / 4, 64},  {333, 201},  {64, 50}};
    for (size_t k = 0; k < sizeof at / sizeof at[0]; k++) {
        ibl_image img;
        ibl_cube cube;
        double want[3], got[3], dir[3];
        double worst = 1;
        fill(&img, W, H, 0);
        set(&img, at[k][0], at[k][1], 1e6f);
        truth_mean(&img, want);
        truth_latlong_direction(W, H, at[k][0], at[k][1], dir);
        bake(&img, 0, N, &cube);
        mean_of(&cube, got);
        CHECK_NEAR(got[0] / want[0], 1, 1e-6);
        for (int f = 0; f < 6; f++) {
            const float *p = ibl_cube_face(&cube, 0, f);
            for (int i = 0; i < N * N; i++) {
                double d[3];
                truth_cube_direction(N, f, i % N, i / N, d);
                const double cosine =
                    d[0] * dir[0] + d[1] * dir[1] + d[2] * dir[2];
                CHECK(p[3 * i] >= 0);
                if (p[3 * i] > 1e-3f && cosine < worst)
                    worst = cosine;
            }
        }
        CHECK_MSG(worst > cos(0.08), "sun %zu: light %.3g rad away", k,
                  acos(worst));
        ibl_cube_free(&cube);
        ibl_image_free(&img);
    }
}

/* Every texel against the average over 96 x 96 points of it. A midpoint sum
 * of a patchwork errs where patches are cut: by less than the points' own
 * patch, 1/96 of a pixel's width, for each cut edge. */
static void texels(void)
{
    static const int maps[][3] = {
        {128, 64, 8}, {64, 32, 16}, {97, 51, 11}, {200, 100, 15}};
    for (size_t k = 0; k < sizeof maps / sizeof maps[0];
         k += TEST_SANITIZED ? 2 : 1) {
        const int n = maps[k][2];
        ibl_image img;
        ibl_cube cube;
        double sum = 0, sum2 = 0, worst = 0;
        fill(&img, maps[k][0], maps[k][1], 0);
        test_random r = {3 + k};
        for (int i = 0; i < 3 * maps[k][0] * maps[k][1]; i++)
            img.data[i] = (float)test_random_unit(&r);
        bake(&img, 0, n, &cube);
        for (int i = 0; i < 6 * n * n; i++) {
            double rgb[3];
            truth_texel(&img, n, i / (n * n), i % n, i / n % n, 96, rgb);
            const double d = (double)ibl_cube_face(
                                 &cube, 0, i / (n * n))[3 * (i % (n * n))] -
                             rgb[0];
            sum += 1;
            sum2 += d * d;
            worst = fabs(d) > worst ? fabs(d) : worst;
        }
        CHECK_MSG(sqrt(sum2 / sum) < 1e-3 && worst < 5e-3,
                  "%dx%d to %d: rms %.3g, worst %.3g", maps[k][0], maps[k][1],
                  n, sqrt(sum2 / sum), worst);
        ibl_cube_free(&cube);
        ibl_image_free(&img);
    }
}

/* A checkerboard of single pixels, 16 and more to a texel's edge, averages to
 * gray: exactly half as the pixels in a texel go to infinity, and within one
 * boundary's worth of pixels, 4 edges / 16^2 / 2, in every texel. */
static void checkerboard(void)
{
    enum {
        W = 1024,
        H = 512,
        N = 16
    };
    ibl_image img;
    ibl_cube cube;
    double worst = 0;
    fill(&img, W, H, 0);
    for (int j = 0; j < H; j++) {
        for (int i = 0; i < W; i++)
            set(&img, i, j, (float)((i + j) & 1));
    }
    bake(&img, 0, N, &cube);
    for (size_t i = 0; i < ibl_cube_texels(N, 1); i++) {
        const double d = fabs((double)cube.data[3 * i] - 0.5);
        worst = d > worst ? d : worst;
    }
    CHECK_MSG(worst < 4.0 / 256 / 2, "worst %.3g", worst);
    ibl_cube_free(&cube);
    ibl_image_free(&img);
}

/* Turning the map by 90 degrees moves the four sides round. +Y yaw takes +X
 * to -Z, so face -Z of the turned map is face +X of the other. */
static void quarter_turn(void)
{
    enum {
        W = 64,
        H = 32,
        N = 16
    };
    static const int from[4][2] = {{5, 0}, {1, 5}, {4, 1}, {0, 4}};
    ibl_image img;
    ibl_cube a, b;
    fill_random(&img, W, H, 5);
    bake(&img, 0, N, &a);
    bake(&img, 90, N, &b);
    for (int k = 0; k < 4; k++) {
        const float *p = ibl_cube_face(&b, 0, from[k][0]);
        const float *q = ibl_cube_face(&a, 0, from[k][1]);
        for (int i = 0; i < 3 * N * N; i++)
            CHECK_NEAR((double)p[i], (double)q[i], 2e-6 * (double)q[i]);
    }
    ibl_cube_free(&a);
    ibl_cube_free(&b);
    ibl_image_free(&img);
}

/* A yaw of whole columns is the same as rolling the map; 360 is none. */
static void yaw_is_a_roll(void)
{
    enum {
        W = 96,
        H = 48,
        N = 12
    };
    ibl_image img, rolled;
    ibl_cube a, b;
    fill_random(&img, W, H, 6);
    fill(&rolled, W, H, 0);
    for (int roll = 0; roll < W; roll++) {
        for (int j = 0; j < H; j++) {
            for (int i = 0; i < W; i++)
                memcpy(rolled.data + 3 * (j * W + i),
                       img.data + 3 * (j * W + (i + roll) % W), 12);
        }
        bake(&img, 360.0 * roll / W - 720 * (roll % 3 - 1), N, &a);
        bake(&rolled, 0, N, &b);
        CHECK_MSG(
            !memcmp(a.data, b.data, 3 * ibl_cube_texels(N, 1) * sizeof *a.data),
            "%d columns", roll);
        ibl_cube_free(&a);
        ibl_cube_free(&b);
    }
    ibl_image_free(&img);
    ibl_image_free(&rolled);
}

/* Magnified, the cube shows the bilinear interpolation of the map: at a
 * texel's centre no more than the texel's own variation away from it. */
static void magnified(void)
{
    enum {
        W = 32,
        H = 16,
        N = 128
    };
    ibl_image img;
    ibl_cube cube;
    fill(&img, W, H, 0);
    for (int j = 0; j < H; j++) {
        for (int i = 0; i < W; i++) {
            double d[3];
            truth_latlong_direction(W, H, i, j, d);
            set(&img, i, j, (float)(2 + d[0] + 0.5 * d[1] - 0.7 * d[2]));
        }
    }
    bake(&img, 0, N, &cube);
    for (int f = 0; f < 6; f++) {
        const float *p = ibl_cube_face(&cube, 0, f);
        double step = 0, worst = 0;
        for (int i = 0; i < N * N; i++) {
            double d[3];
            truth_cube_direction(N, f, i % N, i / N, d);
            const double want = 2 + d[0] + 0.5 * d[1] - 0.7 * d[2];
            worst = fmax(worst, fabs((double)p[3 * i] - want));
            if (i % N)
                step = fmax(step, fabs((double)(p[3 * i] - p[3 * i - 3])));
        }
        /* Linear interpolation of a function with second derivative up to
         * |(1, .5, -.7)| errs by h^2 / 8 of it along each axis; near a pole
         * the columns are h apart in phi still. */
        CHECK_MSG(worst < 1.32 * 2 * (PI / H) * (PI / H) / 8 + 0.005,
                  "face %d: %.3g off", f, worst);
        CHECK_MSG(step < 0.06, "face %d: a step of %.3g", f, step);
    }
    ibl_cube_free(&cube);
    ibl_image_free(&img);
}

static void any_thread_count(void)
{
    ibl_image img;
    ibl_cube a, b;
    const int threads[] = {2, 3, 7};
    fill_random(&img, 300, 150, 9);
    bake(&img, 33, 50, &a);
    for (int k = 0; k < 3; k++) {
        ibl_ctx *other = test_ctx(threads[k], IBL_ISA_AUTO);
        NEED(!ibl_cube_alloc(other, 50, 1, &b));
        NEED(!ibl_cube_from_latlong(other, &img, 33, &b));
        CHECK(!memcmp(a.data, b.data, 12 * ibl_cube_texels(50, 1)));
        ibl_cube_free(&b);
        ibl_ctx_free(other);
    }
    ibl_cube_free(&a);
    ibl_image_free(&img);
}

/* The texels' solid angles cover the sphere, and the conventions' directions
 * are what the library says. */
static void cube_geometry(void)
{
    for (int n = 1; n < 40; n += 3) {
        double sum = 0;
        for (int i = 0; i < n * n; i++)
            sum += 6 * ibl_cube_solid_angle(n, i % n, i / n);
        CHECK_NEAR(sum, 4 * PI, 1e-12);
        for (int i = 0; i < 6 * n * n; i++) {
            double a[3], b[3];
            ibl_cube_direction(n, i / (n * n), i % n, i / n % n, a);
            truth_cube_direction(n, i / (n * n), i % n, i / n % n, b);
            CHECK_NEAR(hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]), 0,
                       1e-14);
        }
    }
}

/* ---- progress ---------------------------------------------------------- */

typedef struct told {
    char stage[32];
    double done;
    int calls;
} told;

static void keep_progress(void *cookie, const char *stage, double done)
{
    told *t = cookie;
    const bool same = !strcmp(t->stage, stage);
    CHECK_MSG(done >= (same ? t->done : 0) && done <= 1, "%s: %g after %g",
              stage, done, t->done);
    snprintf(t->stage, sizeof t->stage, "%s", stage);
    t->done = done;
    t->calls++;
}

/* Each call's progress ends with 1. */
static void progress(void)
{
    ibl_ctx_options options = ibl_ctx_options_default();
    told last = {.stage = ""};
    ibl_ctx *other;
    ibl_image img, back;
    ibl_cube cube;
    options.progress = keep_progress;
    options.progress_cookie = &last;
    NEED(!ibl_ctx_create(&options, &other));
    fill(&img, 64, 32, 1);
    fill(&back, 64, 32, 0);
    NEED(!ibl_cube_alloc(other, 16, 5, &cube));
    CHECK(!ibl_cube_from_latlong(other, &img, 0, &cube));
    CHECK(!strcmp(last.stage, "level 0") && last.done == 1 && last.calls > 9);
    CHECK(!ibl_cube_build_mips(other, &cube));
    CHECK(!strcmp(last.stage, "mips") && last.done == 1);
    CHECK(!ibl_latlong_from_cube(other, &cube, &back));
    CHECK(!strcmp(last.stage, "map") && last.done == 1);
    ibl_cube_free(&cube);
    ibl_image_free(&img);
    ibl_image_free(&back);
    ibl_ctx_free(other);
}

static const test tests[] = {TEST(cube_geometry), TEST(constant_map),
                             TEST(energy),        TEST(sun),
                             TEST(texels),        TEST(checkerboard),
                             TEST(quarter_turn),  TEST(yaw_is_a_roll),
                             TEST(magnified),     TEST(any_thread_count),
                             TEST(progress)};

int main(int argc, char **argv)
{
    ctx = test_ctx(1, IBL_ISA_AUTO);
    const int status =
        test_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
    ibl_ctx_free(ctx);
    return status;
}
