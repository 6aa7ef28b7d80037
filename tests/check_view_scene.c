/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "test.h"
#include "view.h"
#include "view/sphere_grid.h"

static const double degree = 3.14159265358979323846 / 180;

/* ---- the grid ---------------------------------------------------------- */

/* Columns by roughness, rows by metalness. */
TEST(grid)
{
    view_settings s = view_settings_default();
    view_sphere p[VIEW_MAX_GRID * VIEW_MAX_GRID];
    const view_material *m = &view_materials[s.material];

    s.rows = 3;
    s.columns = 5;
    s.roughness[0] = 0.2;
    CHECK(view_grid(&s, p) == 15);
    for (int i = 0; i < 15; i++) {
        const double metallic = (int)(i / 5) / 2.0;
        const double centre[3] = {i % 5 - 2, (int)(i / 5) - 1, 0};
        CHECK(p[i].metallic == metallic);
        CHECK_NEAR(p[i].roughness, 0.2 * (1 + i % 5), 1e-15);
        for (int k = 0; k < 3; k++) {
            const double f0 = m->dielectric_f0;
            CHECK(p[i].centre[k] == centre[k]);
            CHECK_NEAR(p[i].f0[k], f0 + metallic * (m->metal[k] - f0), 1e-15);
            CHECK_NEAR(p[i].albedo[k],
                       m->diffuse * m->metal[k] * (1 - metallic), 1e-15);
        }
    }
    s.rows = s.columns = 1;
    CHECK(view_grid(&s, p) == 1);
    CHECK(p[0].centre[0] == 0 && p[0].centre[1] == 0);
    CHECK(p[0].metallic == 0 && p[0].roughness == 0.2);
    s.rows = s.columns = VIEW_MAX_GRID;
    const int count = view_grid(&s, p);
    CHECK(count == VIEW_MAX_GRID * VIEW_MAX_GRID);
    /* Those behind are not seen, nor those from within. */
    for (int z = 0; z < 4; z += 3)
        CHECK(view_test_hit(p, count, (double[3]){0.5, 0.5, z},
                            (double[3]){0, 0, 1}, NULL) == -1);
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

/* Counter-clockwise seen from above is from +Z to +X. The field of view is
 * vertical; a point of a pixel's ray is projected to that pixel. */
TEST(camera)
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
        const double level = cos(s.pitch * degree), tall = s.fov / 2 * degree;
        const double away[3] = {level * sin(s.yaw * degree),
                                sin(s.pitch * degree),
                                level * cos(s.yaw * degree)};
        double ray[3], p[3], ndc[3];
        view_test_ray(&c, w, h, w / 2.0 - 0.5, -0.5, ray);
        CHECK_NEAR(test_dot(ray, away), -cos(tall), 1e-12);
        CHECK_NEAR(ray[1], sin(tall) * level - cos(tall) * away[1], 1e-12);
        view_test_ray(&c, w, h, w - 0.5, h / 2.0 - 0.5, ray);
        CHECK(ray[0] * away[2] - ray[2] * away[0] > 0);
        CHECK_NEAR(1 / pow(test_dot(ray, away), 2),
                   1 + pow(tan(tall) * w / h, 2), 1e-9 * w);
        view_test_ray(&c, w, h, x, y, ray);
        CHECK_NEAR(test_dot(ray, ray), 1, 1e-12);
        for (int k = 0; k < 3; k++) {
            CHECK(i % 2 || fabs(c.eye[k] - s.distance * away[k]) < 1e-12);
            p[k] = c.eye[k] + far * ray[k];
        }
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

/* ---- turns ------------------------------------------------------------- */

/* Counter-clockwise from above: by 90 degrees +Z is seen at +X. */
TEST(turns)
{
    const double d[3] = {0.6, 0.48, 0.64};
    double e[3];

    view_turn(90, (const double[3]){1, 0, 0}, e);
    CHECK_NEAR(e[0], 0, 1e-15);
    CHECK_NEAR(e[2], 1, 1e-15);
    for (double a = -400; a < 400; a += 37) {
        view_turn(a, d, e);
        CHECK_NEAR(test_dot(d, e),
                   d[1] * d[1] + (1 - d[1] * d[1]) * cos(a * degree), 1e-12);
    }
}
