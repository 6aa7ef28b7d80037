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
#include "maps.h"
#include "test.h"
#include "truth.h"
#include "view.h"
#include "view/capture.h"
#include "view/cube.h"
#include "view/program.h"

static const double eye[3] = {0.3, 0.2, -0.4};

/* ---- what tests share -------------------------------------------------- */

static struct {
    box_scene box;
    ibl_ctx *ctx;
    view_capture_options options;
    view_capture *capture;
    ibl_cube cube, irradiance; /* as read */
} rig;

static void end(void *unused)
{
    (void)unused;
    view_capture_free(rig.capture);
    box_end(&rig.box);
    ibl_cube_free(&rig.irradiance);
    ibl_cube_free(&rig.cube);
}

static bool make(void)
{
    view_capture_free(rig.capture);
    rig.capture = view_capture_create(&rig.options);
    return rig.capture;
}

static void begin(int size, double panel, bool open)
{
    memset(&rig, 0, sizeof rig);
    rig.box = (box_scene){.panel = panel, .open = open};
    view_test_begin(32, 32);
    rig.ctx = view_test_ctx(0);
    rig.options = view_capture_options_default();
    rig.options.size = size;
    test_defer(end, NULL);
    NEED(box_begin(&rig.box) && make() &&
         !ibl_cube_alloc(rig.ctx, size, view_capture_levels(rig.capture),
                         &rig.cube) &&
         !ibl_cube_alloc(rig.ctx, VIEW_CAPTURE_IRRADIANCE, 1, &rig.irradiance));
}

static bool read_back(void)
{
    return view_capture_read(rig.capture, &rig.cube) &&
           view_capture_read_irradiance(rig.capture, &rig.irradiance);
}

static bool update(void)
{
    return view_capture_update(rig.capture, eye, box_draw, &rig.box) &&
           read_back();
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
static bool library(ibl_method method, ibl_bake_result *result)
{
    const int n = rig.cube.size;
    ibl_bake_options o = ibl_bake_options_default();
    ibl_image map;

    if (ibl_image_alloc(rig.ctx, 8 * n, 4 * n, &map))
        return false;
    patches(&rig.cube, &map);
    const ibl_environment env = {.image = &map};
    o.specular_options.size = n;
    o.specular_options.levels = rig.cube.levels;
    o.specular_options.method = method;
    o.specular_options.samples = rig.options.samples;
    o.irradiance_options.size = VIEW_CAPTURE_IRRADIANCE;
    const bool ok = !ibl_bake_environment(rig.ctx, &env, &o, result);
    ibl_image_free(&map);
    return ok;
}

/* ---- drawing ----------------------------------------------------------- */

/* What a texel shows; false where that is not the same all over it and a
 * quarter of a texel around. */
static bool traced(int face, int x, int y, double rgba[4])
{
    static const double aside[5][2] = {
        {0, 0}, {-0.75, -0.75}, {0.75, -0.75}, {-0.75, 0.75}, {0.75, 0.75}};
    const int n = rig.cube.size;

    for (int i = 0; i < 5; i++) {
        double d[3], other[4];
        truth_cube_direction(n, face, x + aside[i][0], y + aside[i][1], d);
        box_trace(&rig.box, eye, d, i ? other : rgba);
        if (i && memcmp(other, rgba, sizeof other) != 0)
            return false;
    }
    return true;
}

typedef struct seen {
    double wrong; /* share of texels of one colour that are off by 0.01 */
    double worst; /* difference of these */
    int fewest;   /* of these on a face */
} seen;

static seen compare(void)
{
    const int n = rig.cube.size;
    seen s = {.fewest = n * n};
    int all = 0, wrong = 0;

    for (int f = 0; f < IBL_FACES; f++) {
        const int before = all;
        for (int i = 0; i < n * n; i++) {
            const float *got = ibl_cube_face(&rig.cube, 0, f) + (size_t)3 * i;
            double rgba[4], off = 0;
            if (!traced(f, i % n, i / n, rgba))
                continue;
            for (int k = 0; k < 3; k++)
                off = fmax(off, fabs(got[k] - rgba[k]));
            s.worst = fmax(s.worst, off);
            wrong += off > 0.01;
            all++;
        }
        s.fewest = all - before < s.fewest ? all - before : s.fewest;
    }
    s.wrong = wrong / (double)all;
    return s;
}

static void faces_show_what_rays_meet(void)
{
    begin(64, 0, false);
    CHECK(update());
    const seen s = compare();
    CHECK_MSG(s.worst <= 0x1p-11, "worst %g", s.worst);
    CHECK_MSG(s.fewest > 64 * 64 / 4, "fewest %d", s.fewest);
    CHECK(rig.box.calls == 6);
    CHECK(view_capture_draws(rig.capture) == 6);
}

/* A level's texels, so that others can take their place. */
static ibl_cube taken(void)
{
    const ibl_cube cube = rig.cube;

    rig.cube = (ibl_cube){0};
    CHECK(!ibl_cube_alloc(rig.ctx, cube.size, cube.levels, &rig.cube));
    return cube;
}

static void paraboloids_are_near_faces(void)
{
    /* Of level 0 it is edges of squares, a pixel aside or mixed. */
    static const double most[4] = {0.2, 0.015, 0.008, 0.008};

    begin(64, 0, false);
    CHECK(update());
    ibl_cube faces = taken();
    rig.options.kind = VIEW_PROBE_PARABOLOIDS;
    rig.box.calls = 0;
    CHECK(make() && update());
    CHECK(rig.box.calls == 2 && view_capture_draws(rig.capture) == 2);
    const seen s = compare();
    printf("paraboloids: %.4f of one colour are off, at most %.3f; nRMSE "
           "between their levels and faces'",
           s.wrong, s.worst);
    CHECK_MSG(s.wrong < 0.08, "%g", s.wrong);
    for (int l = 0; l < faces.levels; l++) {
        const double e = cube_nrmse(&rig.cube, &faces, l);
        printf(" %.4f", e);
        CHECK_MSG(e < most[l], "level %d: %g", l, e);
    }
    printf("\n");
    ibl_cube_free(&faces);
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

    begin(32, 0, false);
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

/* A square that shines, in front of the box. */
typedef struct bright {
    const char *what;
    double towards[3]; /* its middle, from the eye */
    double half;       /* half its edge at a distance of 1 */
    double radiance;
    box_scene *box;
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

    box_draw(p->box, clip, position, size, side);
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
    ibl_bake_result truth = {0};

    CHECK(view_capture_update(rig.capture, eye, scene, cookie));
    CHECK(read_back());
    CHECK(library(IBL_METHOD_AUTO, &truth));
    printf("%s: nRMSE of levels", what);
    for (int l = 1; l < rig.cube.levels; l++) {
        const double e = cube_nrmse(&rig.cube, &truth.specular, l);
        printf(" %.4f", e);
        CHECK_MSG(e < bound, "%s, level %d: %g", what, l, e);
    }
    const double e = cube_nrmse(&rig.irradiance, &truth.irradiance, 0);
    printf(", irradiance %.4f\n", e);
    CHECK_MSG(e < bound, "%s, irradiance: %g", what, e);
    ibl_bake_result_free(&truth);
}

static void levels_are_the_librarys(void)
{
    begin(64, 0, false);
    near_library("room", box_draw, &rig.box, 0.003);
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
        {{"small, middle, 50", {1, 0.02, 0.01}, 0.06, 50, NULL}, 64, 0.02},
        {{"small, corner, 50", {1, 1, 1}, 0.06, 50, NULL}, 64, 0.02},
        {{"middling, edge, 50", {1, 1, 0.013}, 0.25, 50, NULL}, 64, 0.02},
        {{"large, middle, 50", {1, 0.02, 0.01}, 0.6, 50, NULL}, 64, 0.02},
        {{"middling, aside, 200", {0.8, -1, 0.3}, 0.12, 200, NULL}, 64, 0.02},
        {{"small, corner, 1000", {1, 1, -1}, 0.06, 1000, NULL}, 64, 0.025},
        {{"middling, aside, 1000", {0.2, 1, 0.55}, 0.25, 1000, NULL},
         64,
         0.025},
        {{"16 samples", {0.8, -1, 0.3}, 0.12, 50, NULL}, 16, 0.04},
        {{"300 samples", {0.8, -1, 0.3}, 0.12, 50, NULL}, 300, 0.01},
    };

    begin(64, 0, false);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        bright p = cases[i].panel;
        p.box = &rig.box;
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
        float *rgba = malloc((size_t)4 * n * n * sizeof *rgba);
        NEED(rgba);
        gl.GetTexImage(GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)f, level,
                       GL_RGBA, GL_FLOAT, rgba);
        for (int i = 0; i < n * n; i++)
            a[f * n * n + i] = rgba[4 * i + 3];
        free(rgba);
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

    begin(16, 0, false);
    rig.options.kind = VIEW_PROBE_PARABOLOIDS;
    CHECK(make() && update());
    alphas(0, alpha);
    for (int i = 0; i < 6 * 16 * 16; i++)
        CHECK_NEAR(alpha[i], 1, 0);
}

/* With options.cpu, and later of what the GPU has filtered: the same. */
static void library_filters_as_well(void)
{
    begin(64, 50, false);
    CHECK(update());
    ibl_bake_result truth = {0};
    CHECK(library(IBL_METHOD_AUTO, &truth));
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
    CHECK(make() && update());
    CHECK(view_capture_steps(rig.capture) == 7);
    for (int l = 0; l < gpu.levels; l++)
        CHECK_NEAR(cube_nrmse(&rig.cube, &later, l), 0, 1e-9);
    ibl_cube_free(&later);
    ibl_cube_free(&gpu);
    ibl_bake_result_free(&truth);
}

/* Without a ceiling: alpha is how much of the room a lobe sees. */
static void alpha_is_filtered(void)
{
    enum {
        COSINES = 6 * VIEW_CAPTURE_IRRADIANCE * VIEW_CAPTURE_IRRADIANCE
    };
    float gpu[6 * 16 * 16], cpu[6 * 16 * 16], first[6 * 64 * 64];
    float gpu_cosine[COSINES], cpu_cosine[COSINES];
    int holes = 0, between = 0;
    double worst = 0;

    begin(64, 0, true);
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
    ibl_cube_free(&rig.cube);
    NEED(!ibl_cube_alloc(rig.ctx, 16, 4, &rig.cube));
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
    begin(16, 0, false);
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

    begin(16, 0, false);
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

    begin(16, 0, false);
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
    begin(16, 0, false);
    view_test_catch();
    CHECK(!view_capture_read_irradiance(rig.capture, &rig.cube));
    CHECK(strstr(view_test_caught(), "for a capture of 32, 1"));
}

static void state_is_as_it_was(void)
{
    GLint viewport[4], framebuffer = -1;
    GLuint mine = 0;

    begin(16, 0, false);
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
    TEST(faces_show_what_rays_meet),
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
