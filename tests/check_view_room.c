/* SPDX-License-Identifier: MIT */
/*
 * The room against rays that are cast in double into its boxes and spheres, and
 * light of probes that are weighed and looked up by ibl/probes.h; captures of
 * it, and their levels against the library's of the same cube.
 */
#include "maps.h"
#include "room.h"
#include "truth.h"
#include "view.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "ibl/ibl.h"

enum {
    MOST = IBL_MAX_PROBES + 1,
    WIDTH = 150, /* no whole tiles */
    HEIGHT = 100
};

/* ---- the room in white light ------------------------------------------- */

/* By the table of a surface that loses nothing, each material has one colour,
 * times the light of the probes. The sky says what direction it is in. */
static struct {
    view_room *room;
    view_image image;
    view_room_draw draw; /* without probes, by a camera to set */
    GLuint black;        /* a cube */
    bool directions; /* colours of the one probe are those of the sky, else */
    float colour[IBL_MAX_PROBES + 1][4]; /* times alpha; the dynamic one's
                                            follows those of the locals */
} lit;

static void sky_texel(void *cookie, const double direction[3], float rgba[4])
{
    (void)cookie;
    for (int k = 0; k < 3; k++)
        rgba[k] = (float)(0.5 + 0.5 * direction[k]);
    rgba[3] = 1;
}

static void lit_end(void *unused)
{
    (void)unused;
    CHECK(view_gl_check("drawing the room"));
    view_room_free(lit.room);
}

/* Opens a screen of that size, too, for the running test. */
static void lit_begin(int width, int height)
{
    view_test_begin(width, height);
    test_defer(lit_end, NULL);
    memset(&lit, 0, sizeof lit);
    lit.room = view_room_create();
    room_image_make(&lit.image, width, height);
    lit.black = room_cube_of(0, 0, 0, 1);
    const GLuint white = room_cube_of(1, 1, 1, 1);
    lit.draw = (view_room_draw){
        .settings = view_settings_default(),
        .camera = {.near = 0.05, .far = 40},
        .moving = true,
        .mirror = true,
        .table = room_table_of(1, 0),
        .environment = {.specular = white,
                        .irradiance = white,
                        .sky = room_cube(64, sky_texel, NULL),
                        .frame = {.diffuse = {1}, .turn = {1}}}};
    lit.draw.settings.reflection = VIEW_SPLIT_SUM;
    NEED(lit.room);
}

/* Layers of a cube array. */
static GLuint layers(int first, int count)
{
    const GLuint array = room_texture(GL_TEXTURE_CUBE_MAP_ARRAY);
    const int size = lit.directions ? 64 : 1, one = IBL_FACES * size * size;
    float *texels = test_alloc((size_t)one * count, 4 * sizeof *texels);

    for (int i = 0; i < one * count && !lit.directions; i++)
        memcpy(texels + 4 * (size_t)i, lit.colour[first + i / one],
               sizeof lit.colour[0]);
    gl.TexImage3D(GL_TEXTURE_CUBE_MAP_ARRAY, 0, GL_RGBA32F, size, size,
                  IBL_FACES * count, 0, GL_RGBA, GL_FLOAT,
                  lit.directions ? room_faces(size, sky_texel, NULL) : texels);
    return array;
}

/* Lights the draw by count probes, of which the last may be the dynamic one;
 * they are kept until the next call. */
static void lit_probes(const ibl_probe *probes, int count, bool dynamic)
{
    const int locals = dynamic ? count - 1 : count;
    view_probe_maps *to[2] = {&lit.draw.locals, &lit.draw.dynamic};

    for (int i = 0; i < 2; i++) {
        *to[i] = (view_probe_maps){.count = i ? count - locals : locals,
                                   .probe = probes + (i ? locals : 0),
                                   .irradiance_scale = 1};
        if (to[i]->count)
            to[i]->specular = to[i]->irradiance =
                layers(i ? locals : 0, to[i]->count);
    }
}

static float *lit_render(void)
{
    NEED(view_room_render(lit.room, &lit.draw, &lit.image));
    return room_image_read(&lit.image);
}

/* In the colours of weights: hues by the golden ratio. */
static double hue(int probe, int k)
{
    static const double shift[3] = {0, 2.0 / 3, 1.0 / 3};
    const double turn = fmod((sqrt(5) - 1) / 2 * probe + shift[k], 1);

    return probe == lit.draw.locals.count
               ? 1
               : fmin(fmax(fabs(6 * turn - 3) - 1, 0), 1);
}

/* What a surface reflects of a probe: its specular and its matte light. */
static void colours_of(int i, const room_hit *h, const double ray[3],
                       double specular[3], double matte[3])
{
    const view_room_draw *d = &lit.draw;
    const double cosine = test_dot(ray, h->normal);
    ibl_probe p = i < d->locals.count ? d->locals.probe[i] : *d->dynamic.probe;
    double mirrored[3], lookup[3];

    for (int k = 0; k < 3; k++)
        mirrored[k] = ray[k] - 2 * cosine * h->normal[k];
    if (d->settings.parallax == VIEW_PARALLAX_NONE)
        p.has_proxy = 0;
    if (d->settings.parallax == VIEW_PARALLAX_SPHERE) {
        p.proxy.half[0] = sqrt(test_dot(p.proxy.half, p.proxy.half));
        p.proxy.shape = IBL_SHAPE_SPHERE;
    }
    ibl_probe_parallax(&p, h->point, mirrored, lookup);
    for (int k = 0; k < 3; k++) {
        const float *c = lit.colour[i];
        specular[k] = matte[k] = (double)c[k] / (double)c[3];
        if (lit.directions) {
            specular[k] = 0.5 + 0.5 * lookup[k];
            matte[k] = 0.5 + 0.5 * h->normal[k];
        }
        if (d->settings.weights)
            matte[k] = hue(i, k);
    }
}

static void shade(const room_hit *h, const double ray[3], double rgb[3])
{
    const view_room_draw *d = &lit.draw;
    const float *turn = d->environment.frame.turn;
    const double c = (double)turn[0], s = (double)turn[1];
    const double sky[3] = {c * ray[0] - s * ray[2], ray[1],
                           s * ray[0] + c * ray[2]};
    const int all = d->locals.count + d->dynamic.count;
    double alpha[MOST] = {0}, w[MOST + 1], seen[3], light[3];

    for (int i = 0; i < all; i++)
        alpha[i] = lit.directions ? 1 : (double)lit.colour[i][3];
    room_weights(d, h->point, alpha, w);
    for (int k = 0; k < 3; k++) {
        seen[k] = w[d->locals.count + 1];
        light[k] = seen[k] * (d->settings.weights ? 0.2 : 1);
    }
    for (int i = 0; i < all; i++) {
        double specular[3], matte[3];
        if (w[i] <= 0)
            continue;
        colours_of(i, h, ray, specular, matte);
        for (int k = 0; k < 3; k++) {
            seen[k] += w[i] * specular[k];
            light[k] += w[i] * matte[k];
        }
    }
    for (int k = 0; k < 3; k++)
        rgb[k] = h->what < 0 ? 0.5 + 0.5 * sky[k]
                 : d->settings.weights
                     ? light[k]
                     : h->f0[k] * seen[k] +
                           (1 - h->f0[k]) * h->albedo[k] * light[k] +
                           h->emission[k];
}

/* Whether a pixel at (x, y), or of a captured face of that size, has the colour
 * of what is up to so many pixels around it. Between two things it may be a mix
 * of them. size 0: of the picture. */
static bool lit_shows(const float *rgb, int size, int face, double x, double y,
                      double around, double tolerance)
{
    const view_camera *c = &lit.draw.camera;
    int first = -2;

    for (int i = 0; i < 9; i++) {
        const double at_x = x + around * ((i + 1) % 3 - 1);
        const double at_y = y + around * ((i + 4) / 3 % 3 - 1);
        double ray[3], truth[3], worst = 0;
        if (size)
            truth_cube_direction(size, face, at_x, at_y, ray);
        else
            view_test_ray(c, lit.image.width, lit.image.height, at_x, at_y,
                          ray);
        const room_hit h = room_cast(&lit.draw, c->eye, ray);
        /* The sky is a filtered texture, spheres are of triangles. */
        const double exact = h.what < 0                  ? 1e-3
                             : h.what >= VIEW_ROOM_BOXES ? 5 * tolerance
                                                         : tolerance;
        shade(&h, ray, truth);
        for (int k = 0; k < 3; k++)
            worst =
                fmax(worst, fabs((double)rgb[k] - truth[k]) / (1 + truth[k]));
        if (worst < fmax(exact, tolerance) || (i && h.what != first))
            return true;
        first = h.what;
    }
    return false;
}

/* ---- pictures ------------------------------------------------------------ */

static const struct {
    double eye[3], at[3], seconds;
} views[] = {
    {{3.4, 2.3, 4.6}, {-0.8, 1.2, -1}, 0},
    {{-4.5, 1.3, -0.3}, {3, 1, 0.4}, 1.7},
    {{0.2, 3.8, 0.3}, {0.3, 0, 0.1}, 3.1},
    {{-9, 3, 8}, {0, 1, 0}, 4.4}, /* from outside */
    {{1.7, 1.9, 1.9}, {-0.3, 0.6, -0.2}, 0},
};

/* A probe for all of the room, or small boxes all over it, of two priorities
 * around the dynamic one's, which is about the mirror and the last. */
static ibl_probe probes[MOST];

static void make_probes(int count, bool dynamic)
{
    test_random r = {7};

    for (int i = 0; i < count; i++) {
        ibl_probe *p = &probes[i];
        *p = (ibl_probe){.influence = {.half = {6, 6, 6}},
                         .position = {1.1, 1.7, -0.9},
                         .blend = 0.2,
                         .has_proxy = 1,
                         .proxy = view_room_inside,
                         .priority = i < 40 ? 2 : 0,
                         .layer = i};
        for (int k = 0; k < 3 && count > 2; k++) {
            p->position[k] =
                view_room_inside.centre[k] +
                view_room_inside.half[k] * test_random_between(&r, -1, 1);
            p->influence.centre[k] = p->position[k];
            p->influence.half[k] = 0.4 + 1e-3 * i;
        }
    }
    if (dynamic) {
        ibl_probe *p = &probes[count - 1];
        p->layer = 0;
        p->priority = 1;
        if (count > 1) {
            p->influence = (ibl_volume){.half = {1.7, 2.3, 1.5}};
            p->blend = 0.7;
            p->position[0] = p->position[2] = 0;
        }
    }
}

/* Alone, weights are shares of a reflection, as colours those of light, and
 * directions the places on a cube that are looked up. */
TEST(pictures_are_those_of_rays)
{
    static const struct {
        int view, count;
        bool dynamic, directions, weights, mirrored;
        double alpha; /* the least */
        view_parallax parallax;
        view_probe_choice choice;
        int nearest, priority; /* the latter of the dynamic one, 0: 1 */
    } states[] = {
        {.view = 0},
        {.view = 1},
        {.view = 2, .mirrored = true},
        {.view = 3},
        {4, 1, false, true, .parallax = VIEW_PARALLAX_BOX},
        {4, 1, true, true, .parallax = VIEW_PARALLAX_BOX},
        {4, 1, false, true, .parallax = VIEW_PARALLAX_SPHERE},
        {4, 1, true, true, .parallax = VIEW_PARALLAX_NONE},
        {0, MOST, true, .alpha = 0.6},
        {1, 60, true, .alpha = 0.6, .mirrored = true},
        {2, MOST - 1, false, .alpha = 0.6},
        {0, MOST, true, .alpha = 1, .weights = true},
        {1, 50, true, .alpha = 1, .weights = true, .priority = 3},
        {0, 50, true, .alpha = 1, .choice = VIEW_PROBES_NEAREST},
        {2, 50, false, .alpha = 0.6, .choice = VIEW_PROBES_NEAREST_K,
         .nearest = 4},
        {1, 50, true, .alpha = 0.6, .choice = VIEW_PROBES_NEAREST_K,
         .nearest = 3, .priority = 3},
        {0, 3, true, .alpha = 1, .choice = VIEW_PROBES_NEAREST_K, .nearest = 5,
         .weights = true, .priority = 3},
    };
    test_random r = {3};

    lit_begin(WIDTH, HEIGHT);
    for (size_t n = 0; n < sizeof states / sizeof *states; n++) {
        const int view = states[n].view, count = states[n].count;
        view_settings *s = &lit.draw.settings;
        view_camera *c = &lit.draw.camera;
        int bad = 0, all = 0;
        *c = room_camera(views[view].eye, views[view].at, 70, WIDTH, HEIGHT);
        for (int k = 0; k < 3 && states[n].mirrored; k++)
            c->right[k] *= -1;
        s->seconds = views[view].seconds;
        s->parallax = states[n].parallax;
        s->probe_choice = states[n].choice;
        s->nearest = states[n].nearest;
        s->weights = states[n].weights;
        lit.draw.environment.frame.turn[0] = (float)cos(0.7 * (double)n);
        lit.draw.environment.frame.turn[1] = (float)sin(0.7 * (double)n);
        lit.directions = states[n].directions;
        for (int i = 0; i < count; i++) {
            const double a = test_random_between(&r, states[n].alpha, 1);
            for (int k = 0; k < 4; k++)
                lit.colour[i][k] =
                    (float)(a * (k < 3 ? test_random_between(&r, 0, 2) : 1));
        }
        make_probes(count, states[n].dynamic);
        if (states[n].priority)
            probes[count - 1].priority = states[n].priority;
        lit_probes(probes, count, states[n].dynamic);
        const float *picture = lit_render();
        for (int i = 0; i<WIDTH * HEIGHT; i += count> 60 ? 5 : 1) {
            all++;
            bad += !lit_shows(picture + 4 * i, 0, 0, i % WIDTH, i / WIDTH, 0.06,
                              1e-3);
        }
        /* Where outlines of triangles are not those of spheres. */
        CHECK_MSG(bad * 200 <= all, "state %zu: %d of %d pixels", n, bad, all);
    }
}

/* Specular cubes of two levels, black then red, whose mix is the level that is
 * looked up; irradiance is scaled. */
TEST(levels_of_roughness)
{
    static const double eye[3] = {1.5, 1.5, 0.5}, at[3] = {1.5, 0, 0.5};
    const GLenum array = GL_TEXTURE_CUBE_MAP_ARRAY;
    float texels[2][IBL_FACES * 4][4];

    lit_begin(4, 4);
    lit.draw.camera = room_camera(eye, at, 0.1, 4, 4);
    lit.draw.environment.irradiance = lit.black;
    make_probes(1, false);
    memcpy(lit.colour[0], (float[4]){0, 0.25F, 0, 1}, sizeof lit.colour[0]);
    lit_probes(probes, 1, false);
    lit.draw.locals.specular = room_texture(array);
    view_gl_filter(array, GL_LINEAR, 2);
    for (int level = 0; level < 2; level++) {
        for (int i = 0; i < IBL_FACES * 4; i++)
            memcpy(texels[level][i], (float[4]){(float)level, 0, 0, 1},
                   sizeof texels[level][i]);
        gl.TexImage3D(array, level, GL_RGBA32F, 2 >> level, 2 >> level,
                      IBL_FACES, 0, GL_RGBA, GL_FLOAT, texels[level]);
    }
    const room_hit h = room_cast(&lit.draw, eye, (const double[3]){0, -1, 0});
    for (int mapping = 0; mapping < 2; mapping++) {
        const float lod[4] = {4, 0.125f, 1, (float)mapping};
        const double r = h.roughness;
        memcpy(lit.draw.locals.lod, lod, sizeof lod);
        lit.draw.locals.irradiance_scale = 2;
        const float *picture = lit_render();
        CHECK_NEAR((double)picture[0] / h.f0[0],
                   0.125 + 4 * (mapping ? r * (2 - r) : r), 6e-3);
        CHECK_NEAR((double)picture[1], 0.5 * (1 - h.f0[1]) * h.albedo[1], 1e-5);
    }
}

/* ---- captures ---------------------------------------------------------- */

/* Of the lit room into one cube, for the running test. */
typedef struct room_capture {
    view_capture *capture;
    view_probe_maps cubes;
} room_capture;

static void free_capture(void *capture)
{
    room_capture *c = capture;

    view_probe_maps_free(&c->cubes);
    view_capture_free(c->capture);
}

static room_capture *capture_from(view_probe_capture kind, int size,
                                  const double eye[3])
{
    room_capture *c = test_alloc(1, sizeof *c);

    c->capture = view_capture_create(kind, size);
    test_defer(free_capture, c);
    NEED(c->capture && view_probe_maps_make(&c->cubes, size, 1));
    memcpy(lit.draw.camera.eye, eye, sizeof lit.draw.camera.eye);
    return c;
}

static void update(room_capture *c)
{
    view_capture_update(c->capture, lit.room, &lit.draw, &c->cubes, 0);
}

/* Captures of the room see what is there, whichever way they are made, up to
 * the rims of paraboloids. Edges of triangles are straight in these, so that
 * some are further away. The mirror is not in the way of what is captured
 * within it. */
TEST(captures)
{
    enum {
        SIZE = 64
    };
    static const double places[2][3] = {{1.11, 2.07, 0.83}, {0, 0.9, 0}};

    lit_begin(4, 4);
    for (int i = 0; i < 4; i++) {
        const view_probe_capture kind = (view_probe_capture)(i / 2);
        const int most = kind == VIEW_PROBE_FACES ? 0 : i % 2 ? 48 : 24;
        int bad = 0;
        room_capture *c = capture_from(kind, SIZE, places[i % 2]);
        update(c);
        const float *rgba = room_cubes_read(c->cubes.specular, 1, 0, SIZE);
        for (int t = 0; t < IBL_FACES * SIZE * SIZE; t++) {
            CHECK_NEAR((double)rgba[4 * t + 3], 1, 0);
            bad += !lit_shows(rgba + 4 * t, SIZE, t / (SIZE * SIZE), t % SIZE,
                              t / SIZE % SIZE, i / 2 ? 1.5 : 0.1, 2e-3);
        }
        CHECK_MSG(bad <= most, "%d: %d of %d texels", i, bad,
                  IBL_FACES * SIZE * SIZE);
    }
}

/* ---- levels of captures -------------------------------------------------- */

static const double eye[3] = {1.11, 2.07, 0.83};

static struct {
    ibl_ctx *ctx;
    room_capture *on;
    ibl_cube cube, irradiance; /* as read */
} rig;

static void begin(int size)
{
    memset(&rig, 0, sizeof rig);
    lit_begin(32, 32);
    rig.ctx = view_test_ctx(0);
    rig.cube = cube_alloc(rig.ctx, size, ibl_default_levels(size));
    rig.irradiance = cube_alloc(rig.ctx, VIEW_CAPTURE_IRRADIANCE, 1);
    rig.on = capture_from(VIEW_PROBE_FACES, size, eye);
}

/* The only one of these cubes, without alpha. */
static void read_cube(GLuint cubes, const ibl_cube *cube)
{
    for (int l = 0; l < cube->levels; l++) {
        const int n = ibl_cube_edge(cube->size, l);
        const float *rgba = room_cubes_read(cubes, 1, l, n);
        for (int i = 0; i < IBL_FACES * n * n; i++)
            memcpy(ibl_cube_face(cube, l, 0) + (size_t)3 * i, rgba + 4 * i,
                   3 * sizeof *rgba);
    }
}

static void read_back(void)
{
    read_cube(rig.on->cubes.specular, &rig.cube);
    read_cube(rig.on->cubes.irradiance, &rig.irradiance);
}

/* What the library makes of the captured level 0. */
static ibl_bake_result library(void)
{
    const int n = rig.cube.size;
    ibl_bake_options o = ibl_bake_options_default();
    ibl_image map = map_constant(rig.ctx, 8 * n, 4 * n, 0);

    NEED(!ibl_latlong_from_cube(rig.ctx, &rig.cube, &map));
    o.specular_options.mapping = IBL_ROUGHNESS_LINEAR;
    o.specular_options.size = n;
    o.specular_options.levels = rig.cube.levels;
    o.irradiance_options.size = VIEW_CAPTURE_IRRADIANCE;
    return map_bake(rig.ctx, &map, &o);
}

/* ---- filtering --------------------------------------------------------- */

/* As far as half floats hold it. */
TEST(a_constant_stays)
{
    static const float skies[][2] = {
        {0.7F, 0.7F},      {123.4F, 123.4F}, {1e-3F, 1e-3F}, {NAN, 0},
        {INFINITY, 65504}, {1e6F, 65504},    {-1, 0}};
    const int states = sizeof skies / sizeof *skies;

    begin(16);
    for (int i = 0; i < states * VIEW_PROBE_CAPTURES; i++) {
        const float sky = skies[i % states][0], kept = skies[i % states][1];
        if (isinf(sky) && i >= states)
            continue; /* a picture is filtered, with weights of 0 */
        rig.on = capture_from((view_probe_capture)(i / states), 16, eye);
        const GLuint cube = room_cube_of(sky, sky, sky, 1);
        gl.TexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_MIN_FILTER,
                         GL_NEAREST);
        gl.TexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_MAG_FILTER,
                         GL_NEAREST);
        lit.draw.camera.eye[1] = 1000; /* the room is too far to be seen */
        lit.draw.environment.sky = cube;
        update(rig.on);
        read_back();
        for (size_t k = 0; k < cube_floats(&rig.cube); k++)
            CHECK_NEAR(rig.cube.data[k], kept, 0x1p-11 * kept);
        for (size_t k = 0; k < cube_floats(&rig.irradiance); k++)
            CHECK_NEAR(rig.irradiance.data[k], kept, 0x1p-11 * kept);
    }
}

/* Of the room, whose lamp is far brighter than its walls: near it, and in a
 * corner. */
TEST(levels_are_the_librarys)
{
    static const double corner[3] = {-3.1, 0.7, 2.3};

    begin(64);
    for (int i = 0; i < 2; i++) {
        update(rig.on);
        read_back();
        const ibl_bake_result truth = library();
        for (int l = 1; l < rig.cube.levels; l++) {
            const double e = cube_nrmse(&rig.cube, &truth.specular, l);
            CHECK_MSG(e < (l == 1 ? 0.04 : 0.015), "%d, level %d: %g", i, l, e);
        }
        const double e = cube_nrmse(&rig.irradiance, &truth.irradiance, 0);
        CHECK_MSG(e < 0.01, "%d, irradiance: %g", i, e);
        memcpy(lit.draw.camera.eye, corner, sizeof corner);
    }
}

/* ---- where local probes are ---------------------------------------------- */

/* How far a point is from all that stands in the room. */
static double clear_of(const double p[3])
{
    const view_room_sphere mirror = view_room_sphere_at(0, 0);
    double off[3], least;

    for (int k = 0; k < 3; k++)
        off[k] = p[k] - mirror.centre[k];
    least = sqrt(test_dot(off, off)) - mirror.radius;
    for (int i = 0; i < VIEW_ROOM_BOXES; i++) {
        const view_room_box b = view_room_box_at(i);
        double out = -INFINITY;
        for (int k = 0; k < 3; k++)
            out = fmax(out, fmax(b.low[k] - p[k], p[k] - b.high[k]));
        least = fmin(least, out);
    }
    return least;
}

/* Free, in order, and of all influences there is 1 at least everywhere in the
 * room, walls and all. */
TEST(placed)
{
    int order[VIEW_MAX_LOCALS];
    test_random r = {5};

    for (int count = 1; count <= VIEW_MAX_LOCALS; count++) {
        view_scene_place(probes, count);
        ibl_probes_order(probes, count, order);
        for (int i = 0; i < count; i++) {
            const ibl_probe *p = &probes[i];
            CHECK(order[i] == i && p->layer == i && p->has_proxy &&
                  p->blend > 0.3);
            CHECK_MSG(clear_of(p->position) > 0.1, "%d of %d: %g %g", i, count,
                      p->position[0], p->position[2]);
            CHECK_MSG(ibl_probe_influence(p, p->position) > 0, "%d of %d", i,
                      count);
        }
        for (int i = 0; i < 500; i++) {
            double p[3], sum = 0;
            for (int k = 0; k < 3; k++)
                p[k] =
                    view_room_inside.centre[k] +
                    view_room_inside.half[k] *
                        fmin(fmax(test_random_between(&r, -1.1, 1.1), -1), 1);
            for (int n = 0; n < count; n++)
                sum += ibl_probe_influence(&probes[n], p);
            CHECK_MSG(sum > 1 - 1e-9, "%d: %g", count, sum);
        }
    }
}
