/* SPDX-License-Identifier: MIT */
/*
 * Filtered captures against the library on the same cube, which comes to it as
 * constant patches here. What captures of the room see is in check_view_room.c.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "maps.h"
#include "room.h"
#include "test.h"
#include "truth.h"
#include "view.h"

/* ---- what tests share -------------------------------------------------- */

static const double eye[3] = {1.11, 2.07, 0.83};

static struct {
    ibl_ctx *ctx;
    room_capture *on;
    ibl_cube cube, irradiance; /* as read */
} rig;

static void begin(view_probe_capture kind, int size)
{
    memset(&rig, 0, sizeof rig);
    lit_begin(32, 32);
    rig.ctx = view_test_ctx(0);
    rig.cube = cube_alloc(rig.ctx, size, ibl_default_levels(size));
    rig.irradiance = cube_alloc(rig.ctx, VIEW_CAPTURE_IRRADIANCE, 1);
    rig.on = room_capture_begin(kind, size, eye);
}

static void read_back(void)
{
    room_cube_read(rig.on->cubes.specular, &rig.cube);
    room_cube_read(rig.on->cubes.irradiance, &rig.irradiance);
}

/* Level 0 as constant patches: each texel's light in 8 x 8 parts, in the pixels
 * of a map that have their middles. Light is kept to the last bit so, which it
 * is not where pixels look for their texels: few meet a small one. */
static void patches(const ibl_cube *cube, ibl_image *map)
{
    const int n = cube->size, sub = 8;

    memset(map->data, 0, (size_t)3 * map->width * map->height * sizeof(float));
    for (int t = 0; t < IBL_FACES * n * n * sub * sub; t++) {
        const int part = t % (sub * sub), texel = t / (sub * sub);
        const int face = texel / (n * n), y = texel / n % n, x = texel % n;
        const double u = x + (part % sub + 0.5) / sub;
        const double v = y + (part / sub + 0.5) / sub;
        const double from_x = 2 * u / n - 1, from_y = 2 * v / n - 1;
        const double area = 2.0 / (n * sub) * 2.0 / (n * sub);
        const double w =
            area * pow(1 + from_x * from_x + from_y * from_y, -1.5);
        double d[3];
        int i, j;
        truth_cube_direction(n, face, u - 0.5, v - 0.5, d);
        truth_latlong_pixel(map->width, map->height, d, &i, &j);
        const double to =
            w / truth_latlong_solid_angle(map->width, map->height, j);
        for (int k = 0; k < 3; k++)
            map->data[3 * (j * map->width + i) + k] +=
                (float)(to * cube->data[3 * texel + k]);
    }
}

/* What the library makes of the captured level 0. */
static ibl_bake_result library(void)
{
    const int n = rig.cube.size;
    ibl_bake_options o = ibl_bake_options_default();
    ibl_image map = map_constant(rig.ctx, 8 * n, 4 * n, 0);

    patches(&rig.cube, &map);
    o.specular_options.mapping = IBL_ROUGHNESS_LINEAR;
    o.specular_options.size = n;
    o.specular_options.levels = rig.cube.levels;
    o.irradiance_options.size = VIEW_CAPTURE_IRRADIANCE;
    return map_bake(rig.ctx, &map, &o);
}

/* ---- skies --------------------------------------------------------------- */

/* Squares of a colour for each face and, before them, a square that shines. */
typedef struct bright {
    const char *what;
    double towards[3]; /* its middle */
    double half;       /* half its edge at a distance of 1 */
    float radiance;
    double bound; /* nRMSE */
} bright;

static bool shines(const bright *p, const double d[3])
{
    const double *to = p->towards, flat = hypot(to[0], to[2]);
    const double length = hypot(flat, to[1]);
    const double across[3] = {-to[2] / flat, 0, to[0] / flat};
    const double up[3] = {to[0] * to[1] / (flat * length), -flat / length,
                          to[2] * to[1] / (flat * length)};
    double x = 0, y = 0, z = 0;

    for (int k = 0; k < 3; k++) {
        x += d[k] * across[k];
        y += d[k] * up[k];
        z += d[k] * to[k] / length;
    }
    return z > 0 && fmax(fabs(x), fabs(y)) < p->half * z;
}

static void bright_texel(void *cookie, const double d[3], float rgba[4])
{
    static const float walls[3][3] = {
        {0.9F, 0.1F, 0.1F}, {0.1F, 0.8F, 0.2F}, {0.1F, 0.2F, 0.9F}};
    const double most = fmax(fmax(fabs(d[0]), fabs(d[1])), fabs(d[2]));
    const int axis = fabs(d[0]) >= most ? 0 : fabs(d[1]) >= most ? 1 : 2;
    const bright *p = cookie;
    int odd = d[axis] > 0;

    for (int k = 1; k < 3; k++)
        odd += (int)floor(4 * d[(axis + k) % 3] / most);
    for (int k = 0; k < 3; k++)
        rgba[k] =
            shines(p, d) ? p->radiance : walls[axis][k] * (odd % 2 ? 1 : 0.6F);
    rgba[3] = 1;
}

static void update_bright(const bright *p)
{
    room_capture_sky(rig.on, room_cube(256, bright_texel, (void *)p));
    read_back();
}

/* ---- filtering --------------------------------------------------------- */

static double furthest(const ibl_cube *cube, const float rgb[3])
{
    const size_t count = ibl_cube_texels(cube->size, cube->levels);
    double worst = 0;

    for (size_t i = 0; i < 3 * count; i++)
        worst = fmax(worst, fabs(cube->data[i] / rgb[i % 3] - 1));
    return worst;
}

TEST(a_constant_stays)
{
    const float rgb[3] = {0.7F, 123.4F, 1e-3F};

    begin(VIEW_PROBE_FACES, 32);
    for (int kind = 0; kind < VIEW_PROBE_CAPTURES; kind++) {
        rig.on = room_capture_begin((view_probe_capture)kind, 32, eye);
        room_capture_sky(rig.on, room_cube_of(rgb[0], rgb[1], rgb[2], 1));
        read_back();
        CHECK_NEAR(furthest(&rig.cube, rgb), 0, 0x1p-11);
        CHECK_NEAR(furthest(&rig.irradiance, rgb), 0, 0x1p-11);
    }
}

static void near_library(const bright *p)
{
    update_bright(p);
    const ibl_bake_result truth = library();
    printf("%s: nRMSE of levels", p->what);
    for (int l = 1; l < rig.cube.levels; l++) {
        const double e = cube_nrmse(&rig.cube, &truth.specular, l);
        printf(" %.4f", e);
        CHECK_MSG(e < p->bound, "%s, level %d: %g", p->what, l, e);
    }
    const double e = cube_nrmse(&rig.irradiance, &truth.irradiance, 0);
    printf(", irradiance %.4f\n", e);
    CHECK_MSG(e < p->bound, "%s, irradiance: %g", p->what, e);
}

TEST(levels_are_the_librarys)
{
    begin(VIEW_PROBE_FACES, 64);
    near_library(&(bright){"even", {1, 1, 1}, 0, 0, 0.02});
}

/* In the middle of a face, on an edge, in a corner, and between these. */
TEST_SLOW(levels_with_panels)
{
    static const bright cases[] = {
        {"middling, edge, 50", {1, 1, 0.013}, 0.25, 50, 0.05},
        {"large, middle, 50", {1, 0.02, 0.01}, 0.6, 50, 0.035},
        {"small, corner, 1000", {1, 1, -1}, 0.06, 1000, 0.12},
        {"middling, aside, 1000", {0.2, 1, 0.55}, 0.25, 1000, 0.05},
        {"tiny, middle, 1000", {1, 0.02, 0.01}, 0.02, 1000, 0.13},
    };

    begin(VIEW_PROBE_FACES, 64);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        near_library(&cases[i]);
}

/* What is behind the rim of a paraboloid is drawn as well. */
TEST(paraboloids_have_no_holes)
{
    begin(VIEW_PROBE_PARABOLOIDS, 16);
    room_capture_update(rig.on);
    const float *rgba = room_cubes_read(rig.on->cubes.specular, 1, 0, 16);
    for (int i = 0; i < 6 * 16 * 16; i++)
        CHECK_NEAR(rgba[4 * i + 3], 1, 0);
}

/* ---- what is hostile ----------------------------------------------------- */

TEST(what_no_half_holds_is_cut)
{
    static const float all[4] = {NAN, INFINITY, 1e6F, -1};
    static const float kept[4] = {0, 65504, 65504, 0};

    begin(VIEW_PROBE_FACES, 16);
    for (int i = 0; i < 4; i++) {
        const GLuint sky = room_cube_of(all[i], all[i], all[i], 1);
        gl.TexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_MIN_FILTER,
                         GL_NEAREST);
        gl.TexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_MAG_FILTER,
                         GL_NEAREST);
        room_capture_sky(rig.on, sky);
        read_back();
        const size_t count = ibl_cube_texels(rig.cube.size, rig.cube.levels);
        for (size_t k = 0; k < 3 * count; k++)
            CHECK_NEAR(rig.cube.data[k], kept[i], 0);
    }
}
