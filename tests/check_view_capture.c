/* SPDX-License-Identifier: MIT */
/*
 * Captured cubes of the room: filtered levels against the library on the same
 * cube, which comes to it as constant patches here. check_view_room compares
 * level 0 with rays.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "maps.h"
#include "room.h"
#include "test.h"
#include "truth.h"
#include "view.h"
#include "view/capture.h"
#include "view/cube.h"
#include "view/program.h"

static const double eye[3] = {1.11, 2.07, 0.83};

/* ---- what tests share -------------------------------------------------- */

static struct {
    view_room_draw room;
    ibl_ctx *ctx;
    view_capture_options options;
    view_capture *capture;
    ibl_cube cube, irradiance; /* as read */
} rig;

static void end(void *unused)
{
    (void)unused;
    view_capture_free(rig.capture);
}

static bool make(void)
{
    view_capture_free(rig.capture);
    rig.capture = view_capture_create(&rig.options);
    return rig.capture;
}

static void begin(int size)
{
    const view_camera any = {.near = 1, .far = 2};

    memset(&rig, 0, sizeof rig);
    lit_begin(4, 4);
    rig.room = lit_draw(&any);
    rig.ctx = view_test_ctx(0);
    rig.options = view_capture_options_default();
    rig.options.size = size;
    test_defer(end, NULL);
    NEED(make());
    rig.cube = cube_alloc(rig.ctx, size, view_capture_levels(rig.capture));
    rig.irradiance = cube_alloc(rig.ctx, VIEW_CAPTURE_IRRADIANCE, 1);
}

static bool read_back(void)
{
    return view_capture_read(rig.capture, &rig.cube) &&
           view_capture_read_irradiance(rig.capture, &rig.irradiance);
}

static bool update(void)
{
    return view_capture_update(rig.capture, eye, lit_capture, &rig.room) &&
           read_back();
}

/* Level 0 as constant patches: each texel's light in 8 x 8 parts, in the pixels
 * of a map that have their middles. Light is kept to the last bit so, which it
 * is not where pixels look for their texels: few meet a small one. */
static void patches(const ibl_cube *cube, ibl_image *map)
{
    const int n = cube->size, sub = 8;

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
    o.specular_options.size = n;
    o.specular_options.levels = rig.cube.levels;
    o.irradiance_options.size = VIEW_CAPTURE_IRRADIANCE;
    return map_bake(rig.ctx, &map, &o);
}

/* ---- drawing ----------------------------------------------------------- */

/* A level's texels, so that others can take their place. */
static ibl_cube taken(void)
{
    const ibl_cube cube = rig.cube;

    rig.cube = cube_alloc(rig.ctx, cube.size, cube.levels);
    return cube;
}

static void paraboloids_are_near_faces(void)
{
    /* Of level 0 it is edges, a pixel aside or mixed. */
    static const double most[4] = {0.3, 0.035, 0.015, 0.012};

    begin(64);
    CHECK(update() && view_capture_draws(rig.capture) == 6);
    ibl_cube faces = taken();
    rig.options.kind = VIEW_PROBE_PARABOLOIDS;
    CHECK(make() && update() && view_capture_draws(rig.capture) == 2);
    printf("nRMSE between the levels of paraboloids and faces'");
    for (int l = 0; l < faces.levels; l++) {
        const double e = cube_nrmse(&rig.cube, &faces, l);
        printf(" %.4f", e);
        CHECK_MSG(e < most[l], "level %d: %g", l, e);
    }
    printf("\n");
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

    begin(32);
    for (int i = 0; i < 4; i++) {
        static const int samples[] = {64, 64, 1, 300};
        rig.options.kind = i == 1 ? VIEW_PROBE_PARABOLOIDS : VIEW_PROBE_FACES;
        rig.options.samples = samples[i];
        CHECK(make());
        CHECK(view_capture_update(rig.capture, eye, constant, rgb));
        CHECK(read_back());
        CHECK_NEAR(furthest(&rig.cube, rgb), 0, 0x1p-11);
        CHECK_NEAR(furthest(&rig.irradiance, rgb), 0, 0x1p-11);
    }
}

/* A square that shines, in front of the room. */
typedef struct bright {
    const char *what;
    double towards[3]; /* its middle, from the eye */
    double half;       /* half its edge at a distance of 1 */
    double radiance;
} bright;

/* Its corners in clip space, for a strip of two triangles. */
static void panel_corners(const bright *p, const double clip[16],
                          const double position[3], GLfloat corners[16])
{
    const double *to = p->towards;
    const double length = sqrt(to[0] * to[0] + to[1] * to[1] + to[2] * to[2]);
    const double flat = hypot(to[0], to[2]);
    const double across[3] = {-to[2] / flat, 0, to[0] / flat};
    const double up[3] = {to[0] * to[1] / (flat * length), -flat / length,
                          to[2] * to[1] / (flat * length)};

    for (int i = 0; i < 4; i++) {
        const double u = i & 1 ? p->half : -p->half;
        const double v = i & 2 ? p->half : -p->half;
        for (int r = 0; r < 4; r++) {
            double sum = clip[12 + r];
            for (int k = 0; k < 3; k++)
                sum += clip[4 * k + r] * (position[k] + to[k] / length +
                                          u * across[k] + v * up[k]);
            corners[4 * i + r] = (GLfloat)sum;
        }
    }
}

static void panel_draw(void *cookie, const double clip[16],
                       const double position[3], int size, int side)
{
    static const view_shader_file files[] = {
        {"panel.vert", "layout(location = 0) in vec4 place;\n"
                       "void main() { gl_Position = place; }\n"},
        {"panel.frag", "uniform float radiance;\n"
                       "out vec4 colour;\n"
                       "void main() { colour = vec4(vec3(radiance), 1.0); }\n"},
        {NULL, NULL}};
    const bright *p = cookie;
    GLfloat corners[16];
    GLuint array = 0, buffer = 0;

    lit_capture(&rig.room, clip, position, size, side);
    panel_corners(p, clip, position, corners);
    const GLuint program = view_program_from(files, "panel.vert", "panel.frag");
    gl.UseProgram(program);
    gl.Disable(GL_DEPTH_TEST);
    gl.GenVertexArrays(1, &array);
    gl.GenBuffers(1, &buffer);
    gl.BindVertexArray(array);
    gl.BindBuffer(GL_ARRAY_BUFFER, buffer);
    gl.BufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STREAM_DRAW);
    gl.EnableVertexAttribArray(0);
    gl.VertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, 0, NULL);
    gl.Uniform1f(gl.GetUniformLocation(program, "radiance"),
                 (GLfloat)p->radiance);
    gl.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    gl.DeleteBuffers(1, &buffer);
    gl.DeleteVertexArrays(1, &array);
    gl.DeleteProgram(program);
}

static void near_library(const char *what, view_capture_scene *scene,
                         void *cookie, double bound)
{
    CHECK(view_capture_update(rig.capture, eye, scene, cookie));
    CHECK(read_back());
    const ibl_bake_result truth = library();
    printf("%s: nRMSE of levels", what);
    for (int l = 1; l < rig.cube.levels; l++) {
        const double e = cube_nrmse(&rig.cube, &truth.specular, l);
        printf(" %.4f", e);
        CHECK_MSG(e < bound, "%s, level %d: %g", what, l, e);
    }
    const double e = cube_nrmse(&rig.irradiance, &truth.irradiance, 0);
    printf(", irradiance %.4f\n", e);
    CHECK_MSG(e < bound, "%s, irradiance: %g", what, e);
}

static void levels_are_the_librarys(void)
{
    begin(64);
    near_library("room", lit_capture, &rig.room, 0.005);
}

/* In the middle of a face, on an edge, in a corner, and between these; and with
 * fewer samples, and more. */
static void levels_with_panels(void)
{
    static const struct {
        bright panel;
        int samples;
        double bound;
    } cases[] = {
        {{"small, middle, 50", {1, 0.02, 0.01}, 0.06, 50}, 64, 0.02},
        {{"small, corner, 50", {1, 1, 1}, 0.06, 50}, 64, 0.02},
        {{"middling, edge, 50", {1, 1, 0.013}, 0.25, 50}, 64, 0.02},
        {{"large, middle, 50", {1, 0.02, 0.01}, 0.6, 50}, 64, 0.02},
        {{"middling, aside, 200", {0.8, -1, 0.3}, 0.12, 200}, 64, 0.02},
        {{"small, corner, 1000", {1, 1, -1}, 0.06, 1000}, 64, 0.025},
        {{"middling, aside, 1000", {0.2, 1, 0.55}, 0.25, 1000}, 64, 0.025},
        {{"16 samples", {0.8, -1, 0.3}, 0.12, 50}, 16, 0.04},
        {{"300 samples", {0.8, -1, 0.3}, 0.12, 50}, 300, 0.01},
    };

    begin(64);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        bright p = cases[i].panel;
        rig.options.samples = cases[i].samples;
        CHECK(make());
        near_library(p.what, panel_draw, &p, cases[i].bound);
    }
}

/* ---- the library's ------------------------------------------------------ */

static void alphas_of(GLuint cube, int n, int level, float *a)
{
    gl.BindTexture(GL_TEXTURE_CUBE_MAP, cube);
    for (int f = 0; f < IBL_FACES; f++) {
        float *rgba = test_alloc((size_t)4 * n * n, sizeof *rgba);
        gl.GetTexImage(GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)f, level,
                       GL_RGBA, GL_FLOAT, rgba);
        for (int i = 0; i < n * n; i++)
            a[f * n * n + i] = rgba[4 * i + 3];
    }
}

static void alphas(int level, float *a)
{
    alphas_of(view_capture_specular(rig.capture),
              ibl_cube_edge(rig.cube.size, level), level, a);
}

/* What is behind the rim of a paraboloid is drawn as well. */
static void paraboloids_have_no_holes(void)
{
    float alpha[6 * 16 * 16];

    begin(16);
    rig.options.kind = VIEW_PROBE_PARABOLOIDS;
    CHECK(make() && update());
    alphas(0, alpha);
    for (int i = 0; i < 6 * 16 * 16; i++)
        CHECK_NEAR(alpha[i], 1, 0);
}

/* With options.cpu, and later of what the GPU has filtered: the same. */
static void library_filters_as_well(void)
{
    bright panel = {"panel", {0.8, -1, 0.3}, 0.2, 50};

    begin(64);
    CHECK(view_capture_update(rig.capture, eye, panel_draw, &panel));
    CHECK(read_back());
    const ibl_bake_result truth = library();
    ibl_cube gpu = taken();
    CHECK(view_capture_filter_cpu(rig.capture, rig.ctx));
    CHECK(read_back());
    printf("panel 50: nRMSE of the library's levels (GPU to them)");
    for (int l = 0; l < gpu.levels; l++) {
        const double e = l ? cube_nrmse(&rig.cube, &truth.specular, l) : 0;
        const double between = cube_nrmse(&gpu, &rig.cube, l);
        printf(" %.4f (%.4f)", e, between);
        /* Between texels there are lines here, there were steps there. */
        CHECK_MSG(e < 0.01, "level %d: %g", l, e);
        CHECK_MSG(between < (l ? 0.015 : 1e-9), "level %d: %g", l, between);
    }
    const double e = cube_nrmse(&rig.irradiance, &truth.irradiance, 0);
    printf(", irradiance %.4f\n", e);
    CHECK_MSG(e < 0.01, "irradiance: %g", e);

    ibl_cube later = taken();
    rig.options.cpu = rig.ctx;
    CHECK(make());
    CHECK(view_capture_update(rig.capture, eye, panel_draw, &panel));
    CHECK(read_back());
    CHECK(view_capture_steps(rig.capture) == 7);
    for (int l = 0; l < gpu.levels; l++)
        CHECK_NEAR(cube_nrmse(&rig.cube, &later, l), 0, 1e-9);
}

/* Of a limit that leaves out a wall and the sky: alpha is how much of what is
 * within a lobe sees. */
static void alpha_is_filtered(void)
{
    enum {
        COSINES = 6 * VIEW_CAPTURE_IRRADIANCE * VIEW_CAPTURE_IRRADIANCE
    };
    float gpu[6 * 16 * 16], cpu[6 * 16 * 16], first[6 * 64 * 64];
    float gpu_cosine[COSINES], cpu_cosine[COSINES];
    int holes = 0, between = 0;
    double worst = 0;

    begin(64);
    rig.room.limited = true;
    rig.room.limit_centre[0] = -20;
    rig.room.limit_half[0] = 23;
    rig.room.limit_half[1] = rig.room.limit_half[2] = 20;
    CHECK(update());
    alphas(0, first);
    for (int i = 0; i < 6 * 64 * 64; i++) {
        CHECK(first[i] == 0 || first[i] == 1);
        holes += first[i] == 0;
        if (first[i] == 0)
            CHECK(rig.cube.data[3 * i] == 0);
    }
    CHECK(holes > 64 * 64 / 2 && holes < 3 * 64 * 64);
    alphas(2, gpu);
    alphas_of(view_capture_irradiance(rig.capture), VIEW_CAPTURE_IRRADIANCE, 0,
              gpu_cosine);
    CHECK(view_capture_filter_cpu(rig.capture, rig.ctx));
    alphas(2, cpu);
    for (int i = 0; i < 6 * 16 * 16; i++) {
        between += gpu[i] > 0.1F && gpu[i] < 0.9F;
        CHECK(gpu[i] >= 0 && gpu[i] <= 1 && cpu[i] >= 0 && cpu[i] <= 1);
        worst = fmax(worst, fabs(gpu[i] - cpu[i]));
    }
    alphas_of(view_capture_irradiance(rig.capture), VIEW_CAPTURE_IRRADIANCE, 0,
              cpu_cosine);
    for (int i = 0; i < COSINES; i++) {
        CHECK(gpu_cosine[i] > 0.2F && gpu_cosine[i] <= 1);
        CHECK_NEAR(gpu_cosine[i], cpu_cosine[i], 0.05);
    }
    CHECK(between > 100);
    CHECK_MSG(worst < 0.05, "%g", worst);
}

/* ---- steps --------------------------------------------------------------- */

/* Whether all that is shown is red 1 or red 2; 0: neither. */
static int shown(void)
{
    const float one[3] = {1, 0.5F, 0.25F}, two[3] = {2, 1, 0.5F};

    if (!view_capture_read(rig.capture, &rig.cube) ||
        !view_capture_read_irradiance(rig.capture, &rig.irradiance))
        return 0;
    for (int i = 1; i <= 2; i++) {
        const float *rgb = i == 1 ? one : two;
        if (furthest(&rig.cube, rgb) < 1e-3 &&
            furthest(&rig.irradiance, rgb) < 1e-3)
            return i;
    }
    return 0;
}

static void steps(view_probe_capture kind)
{
    float one[3] = {1, 0.5F, 0.25F}, two[3] = {2, 1, 0.5F};

    rig.options.kind = kind;
    rig.options.levels = 4;
    rig.cube = cube_alloc(rig.ctx, 16, 4);
    CHECK(make());
    const int draws = kind ? 2 : 6;
    CHECK(view_capture_steps(rig.capture) == draws + 1 + 6 * 3 + 6);
    CHECK(view_capture_update(rig.capture, eye, constant, one));
    CHECK(shown() == 1);
    /* Each texture was all 1, or black, and is all 2 once every step is done;
       not one step before, nor after those of another update left off. */
    for (int round = 0; round < 2; round++) {
        float *next = round ? one : two;
        CHECK(!view_capture_advance(rig.capture, eye, constant, next, 3));
        view_capture_restart(rig.capture);
        for (int i = 0; i < view_capture_steps(rig.capture) - 1; i++) {
            CHECK(!view_capture_advance(rig.capture, eye, constant, next, 1));
            CHECK(shown() == 1 + round);
        }
        CHECK(view_capture_advance(rig.capture, eye, constant, next, 5));
        CHECK(shown() == 2 - round);
    }
}

static void step_by_step(void)
{
    begin(16);
    steps(VIEW_PROBE_FACES);
    steps(VIEW_PROBE_PARABOLOIDS);
}

/* Position counts when an update begins; scenes are called once a side. */
static void positions(void *cookie, const double clip[16],
                      const double position[3], int size, int side)
{
    int *calls = cookie;

    (void)clip;
    CHECK(position[0] == 1 && size == 16 && side == -1);
    calls[0]++;
}

static void position_is_that_of_the_first_step(void)
{
    const double at[3] = {1, 0, 0}, later[3] = {2, 0, 0};
    int calls = 0;

    begin(16);
    CHECK(!view_capture_advance(rig.capture, at, positions, &calls, 2));
    CHECK(view_capture_advance(rig.capture, later, positions, &calls, 100));
    CHECK(calls == 6);
}

/* ---- what is hostile ------------------------------------------------------
 */

static void wild(void *cookie, const double clip[16], const double position[3],
                 int size, int side)
{
    const float all[4] = {NAN, INFINITY, 1e6F, -1};
    const int *which = cookie;

    (void)clip, (void)position, (void)size, (void)side;
    const float c = all[*which];
    gl.ClearColor(c, c, c, 1);
    gl.Clear(GL_COLOR_BUFFER_BIT);
}

static void what_no_half_holds_is_cut(void)
{
    static const float kept[4] = {0, 65504, 65504, 0};

    begin(16);
    for (int i = 0; i < 4; i++) {
        CHECK(view_capture_update(rig.capture, eye, wild, &i));
        CHECK(view_capture_read(rig.capture, &rig.cube));
        const size_t count = ibl_cube_texels(rig.cube.size, rig.cube.levels);
        for (size_t k = 0; k < 3 * count; k++)
            CHECK_NEAR(rig.cube.data[k], kept[i], 0);
    }
}

static void reads_into_a_cube_that_fits(void)
{
    begin(16);
    view_test_catch();
    CHECK(!view_capture_read_irradiance(rig.capture, &rig.cube));
    CHECK(strstr(view_test_caught(), "for a capture of 32, 1"));
}

static void state_is_as_it_was(void)
{
    GLint viewport[4], framebuffer = -1;
    GLuint mine = 0;

    begin(16);
    gl.GenFramebuffers(1, &mine);
    gl.BindFramebuffer(GL_FRAMEBUFFER, mine);
    gl.Viewport(1, 2, 3, 4);
    CHECK(update());
    CHECK(view_capture_filter_cpu(rig.capture, rig.ctx));
    gl.GetIntegerv(GL_FRAMEBUFFER_BINDING, &framebuffer);
    gl.GetIntegerv(GL_VIEWPORT, viewport);
    CHECK(framebuffer == (GLint)mine);
    for (int i = 0; i < 4; i++)
        CHECK(viewport[i] == i + 1);
    gl.DeleteFramebuffers(1, &mine);
}

static const test tests[] = {
    TEST(paraboloids_are_near_faces),
    TEST(a_constant_stays),
    TEST(levels_are_the_librarys),
    TEST_SLOW(levels_with_panels),
    TEST(library_filters_as_well),
    TEST(paraboloids_have_no_holes),
    TEST(alpha_is_filtered),
    TEST(step_by_step),
    TEST(position_is_that_of_the_first_step),
    TEST(what_no_half_holds_is_cut),
    TEST(reads_into_a_cube_that_fits),
    TEST(state_is_as_it_was),
};
TEST_MAIN(tests)
