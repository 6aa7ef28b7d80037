/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "test.h"
#include "view.h"
#include "view/frame.h"
#include "view/sphere_grid.h"

static const double degree = 3.14159265358979323846 / 180;

/* ---- the grid ---------------------------------------------------------- */

TEST(grid)
{
    view_settings s = view_settings_default();
    view_sphere p[VIEW_MAX_GRID * VIEW_MAX_GRID];

    s.rows = 3;
    s.columns = 5;
    s.roughness[0] = 0.2;
    CHECK(view_grid(&s, p) == 15);
    CHECK(p[0].centre[0] == -2 && p[0].centre[1] == -1 && p[0].centre[2] == 0);
    CHECK(p[14].centre[0] == 2 && p[14].centre[1] == 1);
    CHECK(p[0].metallic == 0 && p[5].metallic == 0.5 && p[14].metallic == 1);
    CHECK_NEAR(p[0].roughness, 0.2, 0);
    CHECK_NEAR(p[7].roughness, 0.6, 1e-15);
    CHECK_NEAR(p[14].roughness, 1, 1e-15);
    for (int k = 0; k < 3; k++) {
        const view_material *m = &view_materials[s.material];
        CHECK_NEAR(p[0].f0[k], m->dielectric_f0, 0);
        CHECK_NEAR(p[5].f0[k], (m->dielectric_f0 + m->metal[k]) / 2, 1e-15);
        CHECK_NEAR(p[14].f0[k], m->metal[k], 1e-15);
        CHECK_NEAR(p[0].albedo[k], m->diffuse * m->metal[k], 0);
        CHECK_NEAR(p[5].albedo[k], m->diffuse * m->metal[k] / 2, 1e-15);
        CHECK_NEAR(p[14].albedo[k], 0, 0);
    }
    s.rows = s.columns = 1;
    CHECK(view_grid(&s, p) == 1);
    CHECK(p[0].centre[0] == 0 && p[0].centre[1] == 0);
    CHECK(p[0].metallic == 0 && p[0].roughness == 0.2);
    s.rows = s.columns = VIEW_MAX_GRID;
    CHECK(view_grid(&s, p) == VIEW_MAX_GRID * VIEW_MAX_GRID);
}

/* ---- the camera -------------------------------------------------------- */

static void project(const view_camera *c, const double p[3], double ndc[3])
{
    double m[16], clip[4];

    view_camera_matrix(c, m);
    for (int i = 0; i < 4; i++)
        clip[i] = m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i];
    for (int k = 0; k < 3; k++)
        ndc[k] = clip[k] / clip[3];
}

TEST(axes)
{
    view_settings s = view_settings_default();
    double ray[3];

    s.distance = 10;
    view_camera c = view_camera_of(&s, 200, 100);
    CHECK_NEAR(c.eye[2], 10, 1e-12);
    CHECK_NEAR(c.forward[2], -1, 1e-12);
    CHECK_NEAR(c.up[1], tan(15 * degree), 1e-12);
    CHECK_NEAR(c.right[0], 2 * tan(15 * degree), 1e-12);
    view_test_ray(&c, 200, 100, 199.5, -0.5, ray);
    CHECK(ray[0] > 0 && ray[1] > 0);
    CHECK_NEAR(ray[1] / -ray[2], tan(15 * degree), 1e-12);
    CHECK_NEAR(ray[0] / -ray[2], 2 * tan(15 * degree), 1e-12);
    /* Counter-clockwise seen from above is from +Z to +X. */
    s.yaw = 90;
    c = view_camera_of(&s, 100, 100);
    CHECK_NEAR(c.eye[0], 10, 1e-12);
    s.pitch = 30;
    c = view_camera_of(&s, 100, 100);
    CHECK_NEAR(c.eye[1], 5, 1e-12);
    CHECK(c.up[1] > 0);
}

/* A point of a pixel's ray is projected to that pixel. */
TEST(rays_and_matrix)
{
    test_random r = {7};

    for (int i = 0; i < 1000; i++) {
        view_settings s = view_settings_default();
        s.yaw = 720 * test_random_unit(&r) - 360;
        s.pitch = 178 * test_random_unit(&r) - 89;
        s.fov = 5 + 100 * test_random_unit(&r);
        s.distance = i % 2 ? 0 : 1 + 20 * test_random_unit(&r);
        const int w = 1 + (int)(500 * test_random_unit(&r));
        const int h = 1 + (int)(500 * test_random_unit(&r));
        const view_camera c = view_camera_of(&s, w, h);
        const double x = w * test_random_unit(&r) - 0.5;
        const double y = h * test_random_unit(&r) - 0.5;
        const double far = 0.5 + 30 * test_random_unit(&r);
        double ray[3], p[3], ndc[3];
        view_test_ray(&c, w, h, x, y, ray);
        CHECK_NEAR(test_dot(ray, ray), 1, 1e-12);
        for (int k = 0; k < 3; k++)
            p[k] = c.eye[k] + far * ray[k];
        project(&c, p, ndc);
        CHECK_NEAR((ndc[0] + 1) / 2 * w - 0.5, x, 1e-7);
        CHECK_NEAR((1 - ndc[1]) / 2 * h - 0.5, y, 1e-7);
        CHECK(ndc[2] > -1 && ndc[2] < 1);
    }
}

/* The whole grid is in the picture from wherever it is looked at, and fills it
 * when that is in front. */
TEST(grid_fits)
{
    static const int sizes[][2] = {{100, 100}, {1280, 720}, {300, 900}};
    static const int grids[][2] = {{7, 7}, {1, 1}, {1, 16}, {16, 2}};

    for (int i = 0; i < 48; i++) {
        view_settings s = view_settings_default();
        view_sphere p[VIEW_MAX_GRID * VIEW_MAX_GRID];
        double most = 0;
        s.rows = grids[i % 4][0];
        s.columns = grids[i % 4][1];
        s.fov = i % 2 ? 30 : i < 24 ? 60 : 120;
        s.yaw = i / 12 * 70;
        s.pitch = i / 12 * 29;
        const view_camera c =
            view_camera_of(&s, sizes[i / 4 % 3][0], sizes[i / 4 % 3][1]);
        const int count = view_grid(&s, p);
        for (int j = 0; j < count; j++) {
            for (int k = 0; k < 400; k++) {
                const double t = k / 20 * 9 * degree, f = k % 20 * 18 * degree;
                const double at[3] = {
                    p[j].centre[0] + p[j].radius * sin(t) * cos(f),
                    p[j].centre[1] + p[j].radius * sin(t) * sin(f),
                    p[j].centre[2] + p[j].radius * cos(t)};
                double ndc[3];
                project(&c, at, ndc);
                most = fmax(most, fmax(fabs(ndc[0]), fabs(ndc[1])));
                CHECK(ndc[2] > -1 && ndc[2] < 1);
            }
        }
        CHECK_MSG(most < 0.99 && (most > 0.7 || i >= 12), "%d: to %g", i, most);
    }
}

/* ---- hits -------------------------------------------------------------- */

TEST(hits)
{
    test_random r = {3};
    int seen = 0;

    for (int i = 0; i < 2000; i++) {
        view_settings s = view_settings_default();
        view_sphere p[VIEW_MAX_GRID * VIEW_MAX_GRID];
        double ray[3], normal[3], nearest = INFINITY;
        s.yaw = 360 * test_random_unit(&r);
        s.pitch = 120 * test_random_unit(&r) - 60;
        const view_camera c = view_camera_of(&s, 100, 100);
        const int count = view_grid(&s, p);
        view_test_ray(&c, 100, 100, 100 * test_random_unit(&r),
                      100 * test_random_unit(&r), ray);
        int expected = -1;
        for (int j = 0; j < count; j++) {
            double to[3];
            for (int k = 0; k < 3; k++)
                to[k] = p[j].centre[k] - c.eye[k];
            const double along = test_dot(to, ray);
            const double t = along - sqrt(p[j].radius * p[j].radius +
                                          along * along - test_dot(to, to));
            if (t < nearest) { /* not NaN: it misses */
                nearest = t;
                expected = j;
            }
        }
        const int hit = view_test_hit(p, count, c.eye, ray, normal);
        CHECK(hit == expected);
        if (hit < 0 || hit != expected)
            continue;
        seen++;
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(p[hit].centre[k] + p[hit].radius * normal[k],
                       c.eye[k] + nearest * ray[k], 1e-6);
    }
    CHECK(seen > 500);
    const view_settings s = view_settings_default();
    view_sphere p[VIEW_MAX_GRID * VIEW_MAX_GRID];
    const int count = view_grid(&s, p);
    CHECK(view_test_hit(p, count, (double[3]){0, 0, 3}, (double[3]){0, 0, 1},
                        NULL) == -1);
    CHECK(view_test_hit(p, count, p[24].centre, (double[3]){0, 0, 1}, NULL) ==
          -1);
}

/* ---- turns ------------------------------------------------------------- */

/* Counter-clockwise from above: by 90 degrees +Z is seen at +X. */
TEST(turns)
{
    const double d[3] = {0.6, 0.48, 0.64};
    double e[3], back[3];

    view_turn(90, (const double[3]){1, 0, 0}, e);
    CHECK_NEAR(e[0], 0, 1e-15);
    CHECK_NEAR(e[2], 1, 1e-15);
    for (double a = -400; a < 400; a += 37) {
        view_turn(a, d, e);
        view_turn(-a, e, back);
        CHECK_NEAR(test_dot(d, e),
                   d[1] * d[1] + (1 - d[1] * d[1]) * cos(a * degree), 1e-12);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(back[k], d[k], 1e-12);
    }
}

/* Frames are compared by their bytes. */
TEST(frame)
{
    static view_frame f[2];
    view_settings s = view_settings_default();
    baked_set set = {.sh_degree = 1};

    set.baked.file[IBL_CONTENT_SPECULAR].facts.lod_scale = 5;
    set.baked.file[IBL_CONTENT_SPECULAR].texture = (ibl_texture){
        .width = 64, .height = 64, .levels = 6, .layers = 1, .faces = 6};
    s.light_count = 1;
    for (int i = 0; i < 2; i++) {
        memset(&f[i], 255 * i, sizeof f[i]);
        view_frame_fill(&f[i], &s, &set, 320, 200);
    }
    CHECK(!memcmp(&f[0], &f[1], sizeof f[0]));
}
