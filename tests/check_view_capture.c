/* SPDX-License-Identifier: MIT */
/*
 * Captured cubes: a room against rays through it, filtered levels against the
 * library on the same cube, which comes to it as constant patches here.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "box.h"
#include "test.h"
#include "truth.h"
#include "view.h"
#include "view/capture.h"
#include "view/cube.h"

static const double eye[3] = {0.3, 0.2, -0.4};

/* ---- what tests share -------------------------------------------------- */

typedef struct rig {
    box_scene box;
    ibl_ctx *ctx;
    view_capture_options options;
    view_capture *capture;
    ibl_cube cube, irradiance; /* as read */
} rig;

static void end(rig *r)
{
    view_capture_free(r->capture);
    box_end(&r->box);
    view_test_end();
    ibl_cube_free(&r->irradiance);
    ibl_cube_free(&r->cube);
    ibl_ctx_free(r->ctx);
}

static bool make(rig *r)
{
    view_capture_free(r->capture);
    r->capture = view_capture_create(&r->options);
    return r->capture;
}

/* False: skipped or failed. */
static bool begin(rig *r, int size, double panel, bool open)
{
    *r = (rig){.box = {.panel = panel, .open = open}};
    if (!view_test_begin(32, 32))
        return false;
    r->ctx = test_ctx(0, IBL_ISA_AUTO);
    r->options = view_capture_options_default();
    r->options.size = size;
    if (box_begin(&r->box) && make(r) &&
        !ibl_cube_alloc(r->ctx, size, view_capture_levels(r->capture),
                        &r->cube) &&
        !ibl_cube_alloc(r->ctx, VIEW_CAPTURE_IRRADIANCE, 1, &r->irradiance))
        return true;
    test_check(false, __FILE__, __LINE__, "the room is there");
    end(r);
    return false;
}

static bool update(rig *r)
{
    return view_capture_update(r->capture, eye, box_draw, &r->box) &&
           view_capture_read(r->capture, &r->cube) &&
           view_capture_read_irradiance(r->capture, &r->irradiance);
}

/* sqrt(sum |a - b|^2 / sum |b|^2) over a level. */
static double nrmse(const ibl_cube *a, const ibl_cube *b, int level)
{
    const int n = ibl_cube_edge(a->size, level);
    const float *p = ibl_cube_face(a, level, 0),
                *q = ibl_cube_face(b, level, 0);
    double error = 0, sum = 0;

    for (int i = 0; i < 3 * IBL_FACES * n * n; i++) {
        error += pow((double)p[i] - q[i], 2);
        sum += pow(q[i], 2);
    }
    return sqrt(error / sum);
}

/* Level 0 as constant patches: of each pixel of a map twice as fine as the
 * texels the mean of 4 x 4 points. */
static void patches(const ibl_cube *cube, ibl_image *map)
{
    const int n = cube->size, sub = 4;

    for (int y = 0; y < map->height; y++)
        for (int x = 0; x < map->width; x++) {
            double sum[3] = {0}, weights = 0;
            for (int i = 0; i < sub * sub; i++) {
                double d[3];
                int f, u, v;
                truth_latlong_direction(sub * map->width, sub * map->height,
                                        sub * x + i % sub, sub * y + i / sub,
                                        d);
                const double w = sqrt(fmax(1 - d[1] * d[1], 0));
                view_cube_texel(d, n, &f, &u, &v);
                for (int k = 0; k < 3; k++)
                    sum[k] +=
                        w * ibl_cube_face(cube, 0, f)[3 * (v * n + u) + k];
                weights += w;
            }
            for (int k = 0; k < 3; k++)
                map->data[3 * (y * map->width + x) + k] =
                    (float)(sum[k] / weights);
        }
}

/* What the library makes of the captured level 0. */
static bool library(const rig *r, ibl_method method, ibl_bake_result *result)
{
    const int n = r->cube.size;
    ibl_bake_options o = ibl_bake_options_default();
    ibl_image map;

    if (ibl_image_alloc(r->ctx, 8 * n, 4 * n, &map))
        return false;
    patches(&r->cube, &map);
    const ibl_environment env = {
        .width = map.width, .height = map.height, .image = &map};
    o.specular_options.size = n;
    o.specular_options.levels = r->cube.levels;
    o.specular_options.method = method;
    o.specular_options.samples = r->options.samples;
    o.irradiance_options.size = VIEW_CAPTURE_IRRADIANCE;
    const bool ok = !ibl_bake_environment(r->ctx, &env, &o, result);
    ibl_image_free(&map);
    return ok;
}

/* ---- drawing ----------------------------------------------------------- */

/* What a texel shows; false where that is not the same all over it and a
 * quarter of a texel around. */
static bool traced(const rig *r, int face, int x, int y, double rgba[4])
{
    static const double aside[5][2] = {
        {0, 0}, {-0.75, -0.75}, {0.75, -0.75}, {-0.75, 0.75}, {0.75, 0.75}};
    const int n = r->cube.size;

    for (int i = 0; i < 5; i++) {
        double d[3], other[4];
        truth_cube_direction(n, face, x + aside[i][0], y + aside[i][1], d);
        box_trace(&r->box, eye, d, i ? other : rgba);
        if (i && memcmp(other, rgba, sizeof other) != 0)
            return false;
    }
    return true;
}

/* Of texels of one colour, the largest difference; how many on the face that
 * has the fewest. */
static double difference(const rig *r, int *fewest)
{
    const int n = r->cube.size;
    double worst = 0;

    *fewest = n * n;
    for (int f = 0; f < IBL_FACES; f++) {
        int counted = 0;
        for (int i = 0; i < n * n; i++) {
            double rgba[4];
            if (!traced(r, f, i % n, i / n, rgba))
                continue;
            counted++;
            for (int k = 0; k < 3; k++)
                worst =
                    fmax(worst, fabs(ibl_cube_face(&r->cube, 0, f)[3 * i + k] -
                                     rgba[k]));
        }
        *fewest = counted < *fewest ? counted : *fewest;
    }
    return worst;
}

static void faces_show_what_rays_meet(void)
{
    rig r;
    int fewest;

    if (!begin(&r, 64, 0, false))
        return;
    CHECK(update(&r));
    const double worst = difference(&r, &fewest);
    CHECK_MSG(worst <= 0x1p-11, "worst %g", worst);
    CHECK_MSG(fewest > 64 * 64 / 4, "fewest %d", fewest);
    CHECK(r.box.calls == 6);
    CHECK(view_capture_draws(r.capture) == 6);
    end(&r);
}

static void paraboloids_are_near_faces(void)
{
    rig r;
    int fewest;

    if (!begin(&r, 64, 0, false))
        return;
    CHECK(update(&r));
    const float *all = ibl_cube_face(&r.cube, 0, 0);
    ibl_cube faces = r.cube;
    CHECK(all != NULL);
    r.cube = (ibl_cube){0};
    NEED(!ibl_cube_alloc(r.ctx, 64, faces.levels, &r.cube));
    r.options.kind = VIEW_CAPTURE_PARABOLOIDS;
    r.box.calls = 0;
    CHECK(make(&r) && update(&r));
    CHECK(r.box.calls == 2 && view_capture_draws(r.capture) == 2);
    const double worst = difference(&r, &fewest);
    printf("paraboloids: worst of one colour %g, nRMSE", worst);
    for (int l = 0; l < faces.levels; l++)
        printf(" %.4f", nrmse(&r.cube, &faces, l));
    printf("\n");
    ibl_cube_free(&faces);
    end(&r);
}

/* ---- filtering --------------------------------------------------------- */

static void constant(void *cookie, const double clip[16],
                     const double position[3], int size, int side)
{
    const float *c = cookie;

    (void)clip, (void)position, (void)size, (void)side;
    gl.ClearColor(c[0], c[1], c[2], 1);
    gl.Clear(GL_COLOR_BUFFER_BIT);
}

static double furthest(const ibl_cube *cube, const float rgb[3])
{
    const size_t count = ibl_cube_texels(cube->size, cube->levels);
    double worst = 0;

    for (size_t i = 0; i < 3 * count; i++)
        worst = fmax(worst, fabs(cube->data[i] / rgb[i % 3] - 1));
    return worst;
}

static void a_constant_stays(void)
{
    float rgb[3] = {0.7F, 123.4F, 1e-3F};
    rig r;

    if (!begin(&r, 32, 0, false))
        return;
    for (int kind = 0; kind < 2; kind++) {
        r.options.kind = kind ? VIEW_CAPTURE_PARABOLOIDS : VIEW_CAPTURE_FACES;
        CHECK(make(&r));
        CHECK(view_capture_update(r.capture, eye, constant, rgb));
        CHECK(view_capture_read(r.capture, &r.cube));
        CHECK(view_capture_read_irradiance(r.capture, &r.irradiance));
        CHECK_NEAR(furthest(&r.cube, rgb), 0, 0x1p-11);
        CHECK_NEAR(furthest(&r.irradiance, rgb), 0, 0x1p-11);
    }
    end(&r);
}

static void against_library(double panel, double bound)
{
    ibl_bake_result truth = {0}, sampled = {0};
    rig r;

    if (!begin(&r, 64, panel, false))
        return;
    CHECK(update(&r));
    CHECK(library(&r, IBL_METHOD_AUTO, &truth));
    CHECK(library(&r, IBL_METHOD_SAMPLED, &sampled));
    printf("panel %g: nRMSE of levels (library's samples)", panel);
    for (int l = 1; l < r.cube.levels; l++) {
        const double e = nrmse(&r.cube, &truth.specular, l);
        printf(" %.4f (%.4f)", e, nrmse(&sampled.specular, &truth.specular, l));
        CHECK_MSG(e < bound, "level %d: %g", l, e);
    }
    const double e = nrmse(&r.irradiance, &truth.irradiance, 0);
    printf(", irradiance %.4f\n", e);
    CHECK_MSG(e < bound, "irradiance: %g", e);
    ibl_bake_result_free(&sampled);
    ibl_bake_result_free(&truth);
    end(&r);
}

static void levels_are_the_librarys(void)
{
    against_library(0, 0.01);
}

static void levels_with_a_bright_panel(void)
{
    against_library(50, 0.035);
}

static const test tests[] = {
    TEST(faces_show_what_rays_meet),  TEST(paraboloids_are_near_faces),
    TEST(a_constant_stays),           TEST(levels_are_the_librarys),
    TEST(levels_with_a_bright_panel),
};
TEST_MAIN(tests)
