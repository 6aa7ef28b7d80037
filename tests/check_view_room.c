/* SPDX-License-Identifier: MIT */
/* The room against rays that are cast in double into its boxes and spheres. */
#include "maps.h"
#include "room.h"
#include "view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/ibl.h"
#include "view/capture.h"

/* ---- what is before what ------------------------------------------------ */

/* Of a pixel, the other way round than view_camera_matrix. */
static float *read_depths(const view_camera *c)
{
    const int w = lit.target.width, h = lit.target.height;
    float *depth = test_alloc((size_t)w * h, sizeof *depth);
    const double a = (c->far + c->near) / (c->far - c->near);
    const double b = -2 * c->far * c->near / (c->far - c->near);

    gl.ReadPixels(0, 0, w, h, GL_DEPTH_COMPONENT, GL_FLOAT, depth);
    for (int i = 0; i < w * h; i++)
        depth[i] = (float)(b / (2 * (double)depth[i] - 1 - a));
    return depth;
}

/* Whether a ray near the pixel's centre sees that colour at that depth. Edges
 * of spheres are those of triangles. */
static bool is_seen(const view_camera *c, const view_room_draw *d, int x, int y,
                    const float *pixel, double depth, double near_by)
{
    for (int i = 0; i < 9; i++) {
        double direction[3];
        view_camera_ray(c, lit.target.width, lit.target.height,
                        x + near_by * ((i + 1) % 3 - 1),
                        y + near_by * ((i + 4) / 3 % 3 - 1), direction);
        const room_hit h = room_cast(d, c->eye, direction);
        const double away = h.distance * test_dot(direction, c->forward);
        const bool round = h.what >= VIEW_ROOM_BOXES;
        if (lit_has_colour(pixel, &h, 1e-4) &&
            (h.what < 0 ? depth > 39
                        : fabs(away - depth) < (round ? .06 : .004)))
            return true;
    }
    return false;
}

TEST(depth_order)
{
    static const struct {
        double eye[3], at[3], seconds;
    } views[] = {
        {{3.4, 2.3, 4.6}, {-0.8, 1.2, -1}, 0},
        {{-4.5, 1.3, -0.3}, {3, 1, 0.4}, 1.7},
        {{0.2, 3.8, 0.3}, {0.3, 0, 0.1}, 3.1},
        {{-9, 3, 8}, {0, 1, 0}, 4.4}, /* from outside */
        {{0, 9, 7}, {0, 1, 0}, 5},
    };

    lit_begin(160, 96);
    for (size_t v = 0; v < sizeof views / sizeof views[0]; v++) {
        const view_camera c =
            room_camera(views[v].eye, views[v].at, 70, 160, 96);
        view_room_draw d = lit_draw(&c);
        d.seconds = views[v].seconds;
        d.environment.turn = 40 * (double)v;
        float *picture = lit_render(&d), *depths = read_depths(&c);
        int bad = 0;
        for (int i = 0; i < 160 * 96; i++) {
            const int x = i % 160, y = i / 160;
            bad += !is_seen(&c, &d, x, y, picture + 4 * i,
                            (double)depths[160 * (95 - y) + x], 0.06);
        }
        CHECK_MSG(bad == 0, "view %zu: %d of %d pixels", v, bad, 160 * 96);
    }
}

/* ---- light ---------------------------------------------------------------*/

/* A box without walls that says where on its inside one looks. */
static void inside_of_room(const double from[3], const double d[3],
                           double at[3])
{
    double t = INFINITY;

    for (int k = 0; k < 3; k++) {
        const double wall =
            view_room_centre[k] + copysign(view_room_half[k], d[k]);
        if (d[k] != 0)
            t = fmin(t, (wall - from[k]) / d[k]);
    }
    for (int k = 0; k < 3; k++)
        at[k] = from[k] + t * d[k];
}

static void place_texel(void *cookie, const double direction[3], float rgba[4])
{
    double at[3];

    inside_of_room(cookie, direction, at);
    for (int k = 0; k < 3; k++)
        rgba[k] = (float)at[k];
    rgba[3] = 1;
}

/* For all of the room. */
static ibl_probe room_probe(const double position[3])
{
    ibl_probe p = {.influence = {.half = {6, 6, 6}}, .has_proxy = 1};

    for (int k = 0; k < 3; k++) {
        p.position[k] = position[k];
        p.influence.centre[k] = p.proxy.centre[k] = view_room_centre[k];
        p.proxy.half[k] = view_room_half[k];
    }
    return p;
}

enum {
    CUBE = 64
};

/* How far apart what is seen at a pixel and what a mirror there reflects are,
 * in texels where it is. */
static double reflection_error(const room_hit *h, const double from[3],
                               const double eye_ray[3], const float *pixel)
{
    double d[3], at[3], apart = 0, away = 0, seen[3], flat = 0;
    const double cosine = test_dot(eye_ray, h->normal);

    for (int k = 0; k < 3; k++)
        d[k] = eye_ray[k] - 2 * cosine * h->normal[k];
    inside_of_room(h->point, d, at);
    for (int k = 0; k < 3; k++) {
        seen[k] = (double)pixel[k] / (double)h->material->f0[k];
        apart += (seen[k] - at[k]) * (seen[k] - at[k]);
        away += (at[k] - from[k]) * (at[k] - from[k]);
        if (fabs(fabs(at[k] - view_room_centre[k]) - view_room_half[k]) < 1e-9)
            flat = fabs(at[k] - from[k]);
    }
    /* A texel is 2 / CUBE at a distance of 1 along its face's axis. */
    const double texel = 2.0 / CUBE * away / flat;
    return sqrt(apart) / texel;
}

static void count_errors(const view_camera *c, const view_room_draw *d,
                         const double from[3], int what, int *all, int *wrong)
{
    const int w = lit.target.width, h = lit.target.height;
    float *picture = lit_render(d);

    *all = *wrong = 0;
    for (int i = 0; i < w * h; i++) {
        double ray[3];
        view_camera_ray(c, w, h, i % w, i / w, ray);
        const room_hit at = room_cast(d, c->eye, ray);
        const bool wanted =
            what ? at.what == VIEW_ROOM_BOXES : room_is_floor(&at);
        if (!wanted || test_dot(ray, at.normal) > -0.1)
            continue;
        *all += 1;
        *wrong += !(reflection_error(&at, from, ray, picture + 4 * i) <= 1);
    }
}

/* what: 0 the floor, 1 the mirror */
static void reflects(int what, bool local)
{
    double from[3] = {1.1, 1.7, -0.9};
    const double eye[3] = {1.7, 1.9, 1.9}, at[3] = {-0.3, 0.6, -0.2};
    int all, wrong;

    const view_camera c = room_camera(eye, at, 60, 96, 96);
    view_room_draw d = lit_draw(&c);
    ibl_probe probe = room_probe(from);
    d.moving = false;
    *(local ? &d.locals : &d.dynamic) =
        (view_probe_maps){.count = 1,
                          .probe = &probe,
                          .specular = room_layer(CUBE, place_texel, from),
                          .irradiance = lit.black_layer};
    count_errors(&c, &d, from, what, &all, &wrong);
    CHECK(all > 500);
    CHECK_MSG(wrong * 100 <= all, "with: %d of %d", wrong, all);
    d.parallax = false;
    count_errors(&c, &d, from, what, &all, &wrong);
    CHECK_MSG(wrong * 100 > 95 * all, "without: %d of %d", wrong, all);
    d.parallax = true;
    probe.has_proxy = 0;
    count_errors(&c, &d, from, what, &all, &wrong);
    CHECK_MSG(wrong * 100 > 95 * all, "no proxy: %d of %d", wrong, all);
}

TEST(reflections)
{
    lit_begin(96, 96);
    for (int i = 0; i < 4; i++)
        reflects(i / 2, i % 2);
}

/* ---- shares of probes ---------------------------------------------------- */

/* What the floor below the eye reflects: of red and green (probes) and the
 * environment's blue. */
static void shares(view_room_draw *d, double share[3])
{
    float *picture = lit_render(d);

    for (int k = 0; k < 3; k++)
        share[k] = (double)picture[4 * 5 + k] / 0.06;
}

static view_room_draw above_floor(double x, double z)
{
    const double eye[3] = {x, 1.5, z}, at[3] = {x, 0, z};
    const view_camera c = room_camera(eye, at, 0.1, 4, 4);
    view_room_draw d = lit_draw(&c);

    d.moving = false;
    d.environment.specular = d.environment.sky;
    d.environment.irradiance = lit.black;
    return d;
}

/* Red fades into green, of which a part was seen: one is local, the other
 * dynamic. Which is first is not said by that. */
static void blends(bool red_is_local)
{
    const float part = 0.25f; /* colours are multiplied by it */
    const float red[4] = {1, 0, 0, 1}, green[4] = {0, part, 0, part};
    const float *local = red_is_local ? red : green;
    const float *other = red_is_local ? green : red;
    const double origin[3] = {0, 1, 0};

    lit.sky = room_cube_of(0, 0, 1, 1);
    const GLuint cubes = room_cubes_of(1, (const float(*)[4])local);
    const GLuint cube = room_cubes_of(1, (const float(*)[4])other);
    ibl_probe small = room_probe(origin);
    const ibl_probe large = small;
    small.influence.centre[0] = 0;
    small.influence.half[0] = 2;
    small.blend = 1;
    for (int i = -1; i <= 10; i++) {
        const double x = 1 + 0.1 * i, t = fmin(fmax(i / 10.0, 0), 1);
        const double w = 1 - t * t * (3 - 2 * t);
        view_room_draw d = above_floor(x, 0.5);
        double share[3];
        d.dynamic = (view_probe_maps){.count = 1,
                                      .probe = red_is_local ? &large : &small,
                                      .specular = cube,
                                      .irradiance = lit.black_layer};
        d.locals = (view_probe_maps){.count = 1,
                                     .probe = red_is_local ? &small : &large,
                                     .specular = cubes,
                                     .irradiance = lit.black_layer};
        shares(&d, share);
        CHECK_NEAR(share[0], w, 1e-3);
        CHECK_NEAR(share[1], fmin(0.25, 1 - w), 1e-3);
        CHECK_NEAR(share[2], 1 - w - fmin(0.25, 1 - w), 1e-3);
    }
}

TEST(blending)
{
    lit_begin(4, 4);
    blends(true);
    blends(false);
}

/* Each local probe has its layer: specular red, scaled irradiance green. */
TEST(layers_of_probes)
{
    enum {
        COUNT = 9
    };
    float specular[COUNT][4], light[COUNT][4];
    ibl_probe probes[COUNT];

    lit_begin(4, 4);
    for (int i = 0; i < COUNT; i++) {
        const double at[3] = {i - 4, 1, 1.2}; /* beside the mirror */
        const int layer = (i + 4) % COUNT;
        probes[i] = room_probe(at);
        probes[i].layer = layer;
        probes[i].influence.centre[0] = at[0];
        probes[i].influence.half[0] = 0.5;
        memcpy(specular[layer], (float[4]){0.1f * (float)(i + 1), 0, 0, 1},
               sizeof specular[0]);
        memcpy(light[layer], (float[4]){0, 0.05f * (float)(i + 1), 0, 1},
               sizeof light[0]);
    }
    const GLuint cubes = room_cubes_of(COUNT, (const float(*)[4])specular);
    const GLuint lights = room_cubes_of(COUNT, (const float(*)[4])light);
    for (int i = 0; i < COUNT; i++) {
        view_room_draw d = above_floor(i - 3.9, 1.2);
        d.locals = (view_probe_maps){.count = COUNT,
                                     .probe = probes,
                                     .specular = cubes,
                                     .irradiance = lights,
                                     .irradiance_scale = 2};
        float *picture = lit_render(&d);
        const room_hit h = room_cast(&d, d.eye, (const double[3]){0, -1, 0});
        const double albedo = 0.94 * (double)h.material->albedo[1];
        CHECK_NEAR((double)picture[0], 0.06 * 0.1 * (i + 1), 1e-5);
        CHECK_NEAR((double)picture[1], albedo * 0.1 * (i + 1), 1e-5);
        CHECK_NEAR((double)picture[2], 0, 1e-6);
    }
}

/* Cubes of two levels, black then red: the floor's red shows its level. */
static GLuint black_and_red(void)
{
    const GLuint cubes = room_cubes_of(1, &(const float[4]){0, 0, 0, 1});
    const GLenum array = GL_TEXTURE_CUBE_MAP_ARRAY;
    float texels[2][IBL_FACES * 4][4];

    for (int i = 0; i < IBL_FACES * 4; i++) {
        memcpy(texels[0][i], (float[4]){0, 0, 0, 1}, sizeof texels[0][i]);
        memcpy(texels[1][i], (float[4]){1, 0, 0, 1}, sizeof texels[1][i]);
    }
    gl.BindTexture(array, cubes);
    for (int level = 0; level < 2; level++)
        gl.TexImage3D(array, level, GL_RGBA32F, 2 >> level, 2 >> level,
                      IBL_FACES, 0, GL_RGBA, GL_FLOAT, texels[level]);
    gl.TexParameteri(array, GL_TEXTURE_MAX_LEVEL, 1);
    gl.TexParameteri(array, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    return cubes;
}

TEST(levels_of_roughness)
{
    static const double origin[3] = {0, 1, 0};
    ibl_probe probe = room_probe(origin);

    lit_begin(4, 4);
    const GLuint cubes = black_and_red();
    for (int filament = 0; filament < 2; filament++) {
        view_room_draw d = above_floor(1.5, 0.5);
        double share[3];
        d.locals = (view_probe_maps){.count = 1,
                                     .probe = &probe,
                                     .specular = cubes,
                                     .irradiance = lit.black_layer,
                                     .filament = filament,
                                     .lod_scale = 4,
                                     .lod_offset = 0.125f,
                                     .last_level = 1};
        const room_hit h = room_cast(&d, d.eye, (const double[3]){0, -1, 0});
        const double r = (double)h.material->roughness;
        shares(&d, share);
        CHECK_NEAR(share[0], 0.125 + 4 * (filament ? r * (2 - r) : r), 6e-3);
    }
}

/* ---- captures ------------------------------------------------------------ */

/* Whether a texel sees that, or what is up to so many texels away; or it is
 * between two things, and may be a mix of them. */
static bool texel_sees(const view_room_draw *d, const double from[3],
                       const ibl_cube *cube, int face, int x, int y,
                       double around)
{
    enum {
        FINE = 64
    };
    const view_room_material *first = NULL;
    const float *texel =
        ibl_cube_face(cube, 0, face) + 3 * ((size_t)y * cube->size + x);

    for (int i = 0; i < 9; i++) {
        double direction[3];
        ibl_cube_direction(
            cube->size * FINE, face,
            x * FINE + FINE / 2 + (int)(around * FINE) * ((i + 1) % 3 - 1),
            y * FINE + FINE / 2 + (int)(around * FINE) * ((i + 4) / 3 % 3 - 1),
            direction);
        const room_hit h = room_cast(d, from, direction);
        if (lit_has_colour(texel, &h, 2e-3) || (i && h.material != first))
            return true;
        first = h.material;
    }
    return false;
}

/* Captures of the room see what is there, whichever way they are made. */
static void captured(view_probe_capture kind, const double from[3],
                     double around, int most)
{
    enum {
        SIZE = 64
    };
    const ibl_cube cube = cube_alloc(view_test_ctx(1), SIZE, 1);
    int bad = 0;

    room_capture *c = room_capture_begin(kind, SIZE, from);
    room_capture_update(c);
    room_cube_read(c->cubes.specular, &cube);
    for (int i = 0; i < IBL_FACES * SIZE * SIZE; i++)
        bad += !texel_sees(&c->shot.draw, from, &cube, i / (SIZE * SIZE),
                           i % SIZE, i / SIZE % SIZE, around);
    CHECK_MSG(bad <= most, "%d of %d texels", bad, IBL_FACES * SIZE * SIZE);
}

/* Edges of triangles are straight in paraboloids, so that some are further
 * away. The mirror is not in the way of what is captured within it. */
TEST(captures)
{
    double places[2][3] = {{1.11, 2.07, 0.83}}, radius;

    lit_begin(4, 4);
    view_room_sphere(0, 0, places[1], &radius);
    for (int i = 0; i < 2; i++) {
        captured(VIEW_PROBE_FACES, places[i], 0.1, 0);
        captured(VIEW_PROBE_PARABOLOIDS, places[i], 1.5, i ? 48 : 24);
    }
}

/* ---- movement ----------------------------------------------------------- */

TEST(movement)
{
    for (int i = 0; i < VIEW_ROOM_SPHERES; i++) {
        double was[3], is[3], radius;
        view_room_sphere(i, 2, was, &radius);
        view_room_sphere(i, 4.9, is, &radius);
        CHECK((memcmp(was, is, sizeof was) != 0) == view_room_sphere_moves(i));
    }
}
