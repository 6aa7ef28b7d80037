/* SPDX-License-Identifier: MIT */
/* The viewer's integral, which draws samples, against that of the library,
 * which sums over the map's pixels; its table of lights; errors and noise. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "reference.h"
#include "sets.h"
#include "shade.h"
#include "truth.h"
#include "view.h"
#include "view/truth.h"

/* A state, and the reference of the same beside it. */
static struct {
    ibl_ctx *ctx;
    baked_set set;
    view_renderer *renderer;
    view_settings side[2];
    ibl_image map;
    int width, height;
} on;

static void end(void *unused)
{
    (void)unused;
    view_set_free(&on.set);
}

/* Lights of some degrees on every face, an edge and near a corner, under a
 * smooth sky. */
static void add_lights(const ibl_image *map)
{
    static const double at[][3] = {
        {1, 0.2, 0.1},  {-1, 0.3, 0.4}, {0.1, 1, 0.2}, {0.2, -1, 0.3},
        {0.3, -0.1, 1}, {0, 0.3, -1},   {1, 0.1, 1},   {-1, 1, 0.9}};

    for (int y = 0; y < map->height; y++)
        for (int x = 0; x < map->width; x++) {
            float *p = map_pixel(map, x, y);
            double d[3];
            truth_latlong_direction(map->width, map->height, x, y, d);
            for (int k = 0; k < 3; k++)
                p[k] = 0.4F + 0.2F * (float)d[k];
            for (int i = 0; i < 24; i++) {
                const double *to = at[i / 3];
                const double cosine = test_dot(to, d) / sqrt(test_dot(to, to));
                p[i % 3] +=
                    (float)((i % 4 ? 60 : 250) * exp(100 * cosine - 100));
            }
        }
}

static void bake(double roughness_min, baked_set *set)
{
    ibl_specular_options opts = ibl_specular_options_default();

    opts.size = 32;
    opts.roughness_min = roughness_min;
    NEED(sets_bake_image(on.ctx, "test", &on.map, &opts, set));
}

/* A grid of rows x columns, 32 pixels a sphere. The environment is level 0. */
static void begin(bool dark, int rows, int columns)
{
    memset(&on, 0, sizeof on);
    on.width = 32 * columns;
    on.height = 32 * rows;
    test_defer(end, NULL);
    on.renderer = shade_begin(on.width, on.height);
    on.ctx = shade_ctx();
    on.side[0] = view_settings_default();
    on.side[0].rows = rows;
    on.side[0].columns = columns;
    on.side[0].compare = VIEW_SPLIT;
    on.map = map_constant(on.ctx, 128, 64, 0);
    if (!dark)
        add_lights(&on.map);
    bake(0.0, &on.set);
    NEED(view_renderer_load(on.renderer, &on.set));
}

/* The environment is the map of the set, turned. */
static void use_map(double yaw)
{
    const char *path = file_path("map.exr");

    NEED(file_save_exr(path, &on.map, NULL));
    free(on.set.baked.source);
    ibl_image_free(&on.set.map); /* it is read anew */
    on.set.map_tried = false;
    on.set.baked.source = strdup(path);
    on.set.baked.read = ibl_read_options_default();
    on.set.baked.yaw_deg = yaw;
    NEED(view_renderer_load(on.renderer, &on.set));
}

static size_t count_floats(void)
{
    return (size_t)3 * on.width * on.height;
}

/* The reference after samples more. */
static float *add(int samples)
{
    on.side[1] = on.side[0];
    on.side[1].reflection = VIEW_REFERENCE;
    view_renderer_pace(on.renderer, samples);
    NEED(shade_frame(on.side));
    return shade_read(1);
}

static double apart(const float *a, const float *b)
{
    double most = 0;

    for (size_t i = 0; i < count_floats(); i++)
        most = fmax(most, fabs((double)a[i] - b[i]) / (1 + fabs(b[i])));
    return most;
}

/* ---- against the integrals ---------------------------------------------- */

/* What the pixel of a sphere should be. */
static void expected(const ibl_reference *ref, const shade_pixel *p,
                     const view_sphere *ball, double rgb[3])
{
    double n[3], v[3], all[IBL_REFERENCE_BRDF];
    shade_light light = {.n_v = p->n_v};

    view_turn(on.side[0].turn, p->normal, n);
    view_turn(on.side[0].turn, p->view, v);
    NEED(!ibl_reference_brdf(ref,
                             on.set.baked.file[IBL_CONTENT_LUT].facts.geometry,
                             &ball->roughness, 1, n, v, 1, all) &&
         !ibl_reference_irradiance(ref, n, 1, light.irradiance) &&
         !ibl_reference_lut(on.ctx, p->n_v, ball->roughness,
                            on.set.baked.file[IBL_CONTENT_LUT].facts.geometry,
                            light.table));
    shade_split_sum(&on.side[0], ball, &light, rgb);
    for (int k = 0; k < 3; k++)
        rgb[k] += ball->f0[k] * all[k] + all[4 + k];
}

/* Relative errors of 1024 samples: each below a fifth, 2 % in the mean
 * square, and none in the mean but for 4 of its standard errors, and 0.05 % for
 * the table that the shader reads. */
static void compare(double yaw)
{
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    double sum = 0, square = 0, worst = 0;
    int count = 0;
    const int every = TEST_SANITIZED ? 17 : 5;
    const shade_pixel *pixels = shade_pixels(&on.side[0]);
    const ibl_reference *ref = reference_of(on.ctx, &on.map, yaw);

    use_map(yaw);
    const float *picture = add(1024);
    view_grid(&on.side[0], spheres);
    for (int i = 0; i < on.width * on.height; i += every) {
        const shade_pixel *p = &pixels[i];
        double rgb[3];
        if (p->sphere < 0 || p->n_v < 0.02)
            continue;
        expected(ref, p, &spheres[p->sphere], rgb);
        for (int k = 0; k < 3; k++) {
            const double off = picture[3 * i + k] / rgb[k] - 1;
            worst = fmax(worst, fabs(off));
            sum += off;
            square += off * off;
            count++;
        }
    }
    NEED(count > 50);
    const double mean = sum / count, rms = sqrt(square / count);
    /* R, G and B are of the same samples. */
    const double error = sqrt(3.0 * (square / count - mean * mean) / count);
    CHECK_MSG(fabs(mean) <= 4.0 * error + 5e-4, "%g +- %g", mean, error);
    CHECK_MSG(rms <= 0.02 && worst < 0.2, "noise: %g, %g", rms, worst);
    test_measured("noise", rms, 0.02);
}

/* Wide and narrow lobes of dielectrics and metals, from the front to grazing
 * angles; and the other geometry, of a table that comes with the set. */
TEST_SLOW(integrals)
{
    begin(false, 2, 3);
    on.side[0].roughness[0] = 0.1;
    for (int i = 0; i < 3; i++) {
        on.side[0].yaw = 20.0 - 90.0 * i;
        on.side[0].turn = i ? 217.0 : 37.0;
        on.side[0].pitch = i ? -25.0 : 25.0;
        on.side[0].multiscatter = i == 1;
        on.set.baked.file[IBL_CONTENT_LUT].facts.geometry =
            i < 2 ? IBL_GEOMETRY_SMITH : IBL_GEOMETRY_SCHLICK_IBL;
        compare(-70.0 * i);
    }
}

/* Each sphere's error against the picture that is looked up; seen: there is
 * something. */
static void as_looked_up(int samples, double most)
{
    int count;

    NEED(view_renderer_load(on.renderer, &on.set));
    add(samples);
    view_error *error = view_renderer_errors(on.renderer, &count);
    NEED(error && count == 6);
    test_defer(free, error);
    for (int i = 0; i < 6; i++)
        CHECK_MSG(view_error_rmse(error[i]) < most && error[i].truth2 > 0.1,
                  "%d, sphere %d: %g of %g", (int)on.side[0].parts, i,
                  view_error_rmse(error[i]), error[i].truth2);
}

/* What has no lobe to average, by one sample, and diffuse light. */
TEST(mirrors_and_parts)
{
    view_settings *s = &on.side[0];

    begin(false, 2, 3);
    s->parts = VIEW_PARTS_AMBIENT;
    as_looked_up(1, 1e-6);
    s->parts = VIEW_PARTS_DIFFUSE;
    s->metallic[1] = 0.5;
    as_looked_up(256, 0.03);
    s->parts = VIEW_PARTS_ALL;
    s->metallic[0] = s->metallic[1] = 1;
    s->roughness[1] = 0;
    s->turn = 75;
    s->multiscatter = false;
    as_looked_up(1, 1e-3);
}

/* Lights without a size are summed, not sampled: in the dark both pictures are
 * the same, up to Schlick's Fresnel in the table. */
TEST(point_lights)
{
    begin(true, 2, 3);
    on.side[0].light_count = 2;
    on.side[0].light[0] = (view_light){{2, 3, 4}, {10, 20, 30}};
    on.side[0].light[1] = (view_light){{-3, 1, 2}, {30, 5, 10}};
    on.set.baked.light_count = 1;
    on.set.baked.light[0] = (ibl_light){
        .direction = {0, 0.6, 0.8}, .radius = 0.02, .irradiance = {3, 2, 1}};
    as_looked_up(1, 1e-5);
    on.side[0].parts = VIEW_PARTS_DIRECT;
    as_looked_up(1, 1e-5);
}

/* The error of the only sphere. */
static view_error only_error(void)
{
    int count;
    view_error *errors = view_renderer_errors(on.renderer, &count);

    NEED(errors && count == 1);
    test_defer(free, errors);
    return *errors;
}

/* The noise that is told is that of the picture, or somewhat more. */
TEST(noise)
{
    double square = 0, truth = 0;

    begin(false, 1, 1);
    on.side[0].roughness[0] = 0.6;
    const float *picture = add(64);
    view_error few = only_error();
    const float *exact = add(4032);
    const view_error many = only_error();
    const shade_pixel *shown = shade_pixels(&on.side[0]);
    for (size_t i = 0; i < count_floats(); i++)
        if (shown[i / 3].sphere == 0) {
            square += pow((double)picture[i] - exact[i], 2);
            truth += pow(exact[i], 2);
        }
    const double noise = view_error_noise(few), is = sqrt(square / truth);
    CHECK_MSG(noise > 0.7 * is && noise < 3 * is, "%g, is %g", noise, is);
    CHECK(view_error_noise(many) < 0.3 * noise);
    few.noise2 = 0;
    CHECK(view_error_noise(few) == 0);
}

/* ---- sample after sample ------------------------------------------------ */

/* However samples are divided into draws, they are the same. Nothing of what
 * was before is left in what is begun anew. At VIEW_TRUTH_SAMPLES it rests. */
TEST(one_by_one)
{
    begin(false, 1, 2);
    const float *whole = add(37), *last = NULL;
    on.side[0].yaw = 33;
    add(3);
    CHECK(view_renderer_draw(on.renderer, on.side, &(view_area){0, 0, 20, 20}));
    on.side[0].yaw = 0;
    CHECK(!memcmp(add(37), whole, count_floats() * sizeof *whole));
    NEED(view_renderer_load(on.renderer, &on.set));
    for (int i = 0; i < 37; i++)
        last = add(1);
    CHECK(view_renderer_samples(on.renderer) == 37);
    CHECK_NEAR(apart(last, whole), 0, 2e-5);
    on.side[0].distance = 60; /* few pixels */
    add(VIEW_TRUTH_SAMPLES - 1);
    last = add(1000);
    CHECK(view_renderer_samples(on.renderer) == VIEW_TRUTH_SAMPLES);
    CHECK(!memcmp(add(1), last, count_floats() * sizeof *last));
}

/* Settings of a picture restart it; settings of only the display do not. */
TEST(restart)
{
    begin(false, 2, 2);
    for (int i = 0; i < 6; i++) {
        const view_settings old = on.side[0];
        view_settings *s = &on.side[0];
        view_renderer_load(on.renderer, &on.set);
        add(4);
        s->ev += i == 0;
        s->diffuse = i == 1 ? VIEW_DIFFUSE_SH : s->diffuse;
        s->yaw += 10 * (i == 2);
        s->multiscatter ^= i == 3;
        s->roughness[0] += 0.5 * (i == 4);
        s->rows -= i == 5;
        add(4);
        on.side[0] = old;
        CHECK_MSG(view_renderer_samples(on.renderer) == (i < 2 ? 8 : 4), "%d",
                  i);
    }
}

/* Everyone's clock, and how much it goes on by whenever it is looked at. */
static double now, tick;

double __wrap_ibl_now(void);

double __wrap_ibl_now(void)
{
    return now += tick;
}

/* By the clock there is a sample in the first frame, twice as many after one
 * that was quick, half as many after one that was slow, and no more than 64. */
TEST(by_the_clock)
{
    static const double took[] = {.01, .01, .07, .07, .2, .01,
                                  .01, .01, .01, .01, .01};
    static const int samples[] = {1, 2, 4, 4, 4, 2, 4, 8, 16, 32, 64};
    int all = 0;

    begin(false, 1, 1);
    for (size_t i = 0; i < sizeof took / sizeof *took; i++) {
        tick = took[i];
        add(0);
        all += samples[i];
        CHECK_MSG(view_renderer_samples(on.renderer) == all, "%zu: %d, not %d",
                  i, view_renderer_samples(on.renderer), all);
    }
    tick = 0;
}

/* ---- what it integrates -------------------------------------------------- */

/* The map, if it is at hand; else, with a note where it is another, level 0, or
 * of rough levels the skybox; and nothing where that is clipped. */
TEST(environments)
{
    baked_set rough;
    ibl_set_file *file = on.set.baked.file, *of = rough.baked.file;

    begin(false, 1, 1);
    on.side[0].background = VIEW_BACKGROUND_COLOUR;
    const float *level0 = add(8);
    use_map(0);
    add(1);
    CHECK(view_renderer_truth(on.renderer)->environment == on.set.baked.source);
    ibl_image_free(&on.set.map);
    on.set.map_tried = false; /* it is read again */
    strcpy(on.set.baked.source_hash, "0123456789abcdef0123456789abcdef");
    view_test_catch();
    NEED(view_renderer_load(on.renderer, &on.set));
    CHECK(apart(add(8), level0) < 1e-5);
    CHECK(strstr(view_test_caught(), "map.exr: cannot be read again"));
    CHECK(!strcmp(view_renderer_truth(on.renderer)->environment, "level 0"));
    /* Level 0 of one is the skybox of the other: that of the first is not the
     * environment. */
    bake(0.4, &rough);
    for (int i = 0; i < 2; i++) {
        ibl_texture *to = &(i ? of : file)[IBL_CONTENT_SKYBOX].texture;
        *to = (i ? file : of)[IBL_CONTENT_SPECULAR].texture;
        NEED(view_renderer_load(on.renderer, i ? &rough : &on.set));
        CHECK(apart(add(8), level0) < 1e-4);
        *to = (ibl_texture){0};
    }
    view_set_free(&rough);

    shade_constant(shade_sets, (const float[]){65504, 65504, 65504});
    shade_pack(shade_sets, IBL_PIXEL_RGBA16F, IBL_PIXEL_RG32F);
    shade_sets->set.baked.file[IBL_CONTENT_SPECULAR].pixel = IBL_PIXEL_RGBA16F;
    NEED(view_renderer_load(on.renderer, &shade_sets->set));
    view_test_catch();
    CHECK(!shade_frame(on.side));
    CHECK(strstr(view_test_caught(), "level 0 is clipped by rgba16f"));
}

/* ---- the table of lights --------------------------------------------------
 */

/* Chances are the tokens' shares, and in proportion to light above the mean. */
TEST(chances)
{
    enum {
        WIDTH = 38,
        HEIGHT = 19,
        COUNT = WIDTH * HEIGHT
    };
    static float rgb[COUNT][3];
    static double angle[COUNT];
    static int tokens[COUNT];
    const ibl_image map = {WIDTH, HEIGHT, *rgb};
    double all = 0, mean = 0;
    test_random random = {3};
    view_aim aim;

    for (int i = 0; i < COUNT; i++) {
        angle[i] = truth_latlong_solid_angle(WIDTH, HEIGHT, i / WIDTH);
        rgb[i][i % 3] = (float)pow(test_random_unit(&random), 4);
        mean += (double)rgb[i][i % 3] * angle[i] / (4 * M_PI);
    }
    for (int i = 0; i < COUNT; i++)
        all += angle[i] *= fmax((double)rgb[i][i % 3] - mean, 0);
    view_aim_make(&map, &aim);
    NEED(aim.width == WIDTH && aim.height == HEIGHT);
    for (int i = 0; i < VIEW_AIM_TOKENS; i++)
        tokens[(int)aim.tokens[i]]++;
    for (int i = 0; i < COUNT; i++) {
        CHECK((double)aim.chance[i] * VIEW_AIM_TOKENS == tokens[i]);
        CHECK_NEAR(tokens[i], angle[i] / all * VIEW_AIM_TOKENS, 1.01);
    }
    view_aim_free(&aim);
}

/* ---- errors ----------------------------------------------------------------
 */

/* A picture of f times the truth is off by |f - 1|; each of three by two parts
 * has its f. What is at the border of a part, or of the picture, does not
 * count. */
TEST(known_errors)
{
    enum {
        EDGE = 24
    };
    float truth[3 * EDGE * EDGE], picture[3 * EDGE * EDGE];
    int shown[EDGE * EDGE];
    const float *pictures[4] = {picture, truth, NULL, NULL};
    view_error errors[6];

    for (int i = 0; i < 3 * EDGE * EDGE; i++) {
        const int x = i / 3 % EDGE, y = i / 3 / EDGE;
        const int part = shown[i / 3] = 3 * (y / 12) + x / 8;
        const bool inside = x % 8 % 7 && y % 12 % 11;
        truth[i] = (float)(1 + i / 3 % 7);
        picture[i] = inside ? truth[i] * (0.5F + 0.25F * (float)part) : 1e6F;
    }
    view_errors(shown, 6, EDGE, EDGE, pictures, errors);
    for (int i = 0; i < 6; i++) {
        CHECK(errors[i].pixels == 6 * 10);
        CHECK_NEAR(view_error_rmse(errors[i]), fabs(0.25 * (i - 2)), 1e-6);
    }
    CHECK(view_error_rmse((view_error){0}) == -1);
}
