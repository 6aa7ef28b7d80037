/* SPDX-License-Identifier: MIT */
/* The viewer's integral, which draws samples, against that of the library,
 * which sums over the map's pixels. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "reference.h"
#include "sets.h"
#include "shade.h"
#include "test.h"
#include "truth.h"
#include "view.h"
#include "view/renderer.h"
#include "view/truth.h"

/* ---- a scene in memory -------------------------------------------------- */

static struct {
    ibl_ctx *ctx;
    baked_set set;
    view_renderer *renderer;
    view_settings settings;
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
static void lights(const ibl_image *map)
{
    static const double at[][3] = {
        {1, 0.2, 0.1},  {-1, 0.3, 0.4}, {0.1, 1, 0.2}, {0.2, -1, 0.3},
        {0.3, -0.1, 1}, {0, 0.3, -1},   {1, 0.1, 1},   {-1, 1, 0.9}};

    for (int y = 0; y < map->height; ++y)
        for (int x = 0; x < map->width; ++x) {
            float *p = map_pixel(map, x, y);
            double d[3];
            truth_latlong_direction(map->width, map->height, x, y, d);
            map_set(map, x, y, 0.3F + 0.2F * (float)d[0],
                    0.5F + 0.2F * (float)d[1], 0.4F);
            for (int i = 0; i < 8; ++i) {
                const double cosine =
                    test_dot(at[i], d) / sqrt(test_dot(at[i], at[i]));
                const float light = (float)exp(100.0 * (cosine - 1.0));
                p[i % 3] += (100.0F + 30.0F * (float)i) * light;
                p[(i + 1) % 3] += 50.0F * light;
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

/* A grid of rows x columns in the dark or, with fill, under a map, 32 pixels a
 * sphere. The environment is level 0. */
static void begin(void (*fill)(const ibl_image *), int rows, int columns)
{
    memset(&on, 0, sizeof on);
    on.width = 32 * columns;
    on.height = 32 * rows;
    test_defer(end, NULL);
    on.renderer = shade_begin(on.width, on.height);
    on.ctx = shade_ctx();
    on.settings = view_settings_default();
    on.settings.compare = VIEW_SPLIT;
    on.settings.rows = rows;
    on.settings.columns = columns;
    on.map = map_constant(on.ctx, 128, 64, 0);
    if (fill)
        fill(&on.map);
    bake(0.0, &on.set);
    NEED(view_renderer_load(on.renderer, &on.set));
}

/* The environment is the map of the set, turned. */
static void use_map(double yaw)
{
    const char *path = file_path("map.exr");

    NEED(file_save_exr(path, &on.map, NULL));
    free(on.set.source);
    on.set.source = strdup(path);
    on.set.source_read = ibl_read_options_default();
    on.set.source_yaw = yaw;
    NEED(view_renderer_load(on.renderer, &on.set));
}

static size_t count_floats(void)
{
    return (size_t)3 * on.width * on.height;
}

static void draw(int samples)
{
    view_renderer_pace(on.renderer, samples);
    NEED(view_renderer_draw(on.renderer, &on.settings, on.width, on.height));
}

/* The reference after samples more; from test_alloc. */
static float *add(int samples)
{
    float *rgb = test_alloc(count_floats(), sizeof *rgb);

    draw(samples);
    NEED(view_renderer_read(on.renderer, true, rgb));
    return rgb;
}

/* ---- against the integrals -------------------------------------------- */

enum {
    BATCHES = 16,
    BATCH = 64 /* samples */
};

/* Means of stretches of the sequence that have no sample in common, each as it
 * would be alone: what a draw added to the mean. */
static void draw_batches(float *batches[BATCHES])
{
    const size_t floats = count_floats();
    double *sum = test_alloc(floats, sizeof *sum);

    for (int b = 0; b < BATCHES; ++b) {
        batches[b] = add(BATCH);
        for (size_t i = 0; i < floats; ++i) {
            const double all = (b + 1.0) * batches[b][i];
            batches[b][i] = (float)(all - sum[i]);
            sum[i] = all;
        }
    }
}

/* Mean and standard error of a pixel's batches. */
static double mean_of(float *const batches[BATCHES], size_t at, double *error)
{
    double mean = 0.0, square = 0.0;

    for (int b = 0; b < BATCHES; ++b)
        mean += batches[b][at] / (double)BATCHES;
    for (int b = 0; b < BATCHES; ++b)
        square += (batches[b][at] - mean) * (batches[b][at] - mean);
    *error = sqrt(square / (BATCHES * (BATCHES - 1.0)));
    return mean;
}

/* What the pixel of a sphere should be. */
static void expected(const ibl_reference *ref, const shade_pixel *p,
                     const view_sphere *ball, double rgb[3])
{
    double n[3], v[3], all[IBL_REFERENCE_BRDF];
    shade_light light = {.specular = {0}};

    view_turn(on.settings.turn, p->normal, n);
    view_turn(on.settings.turn, p->view, v);
    NEED(!ibl_reference_brdf(ref, on.set.geometry, &ball->roughness, 1, n, v, 1,
                             all) &&
         !ibl_reference_irradiance(ref, n, 1, light.irradiance) &&
         !ibl_reference_lut(on.ctx, p->n_v, ball->roughness, on.set.geometry,
                            light.table));
    shade_split_sum(&on.settings, ball, &light, rgb);
    for (int k = 0; k < 3; ++k)
        rgb[k] += ball->f0[k] * all[k] + all[4 + k];
}

/*
 * Each pixel is within 5 standard errors of what it should be, as its own
 * batches tell, and 0.2 % for the table that the shader reads. Over all pixels
 * the mean of the relative errors is within 4 of its standard errors and 0.05 %
 * of nothing, and their root mean square below 1.5 %.
 */
static void compare(double yaw)
{
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    float *batches[BATCHES];
    double sum = 0, square = 0;
    int count = 0;
    const int every = TEST_SANITIZED ? 17 : 5;
    const shade_pixel *pixels = shade_pixels(&on.settings);
    const ibl_reference *ref = reference_of(on.ctx, &on.map, yaw);

    use_map(yaw);
    draw_batches(batches);
    view_grid(&on.settings, spheres);
    for (int i = 0; i < on.width * on.height; i += every) {
        const shade_pixel *p = &pixels[i];
        double rgb[3], error;
        if (p->sphere < 0 || p->n_v < 0.02)
            continue;
        const view_sphere *ball = &spheres[p->sphere];
        expected(ref, p, ball, rgb);
        for (int k = 0; k < 3; ++k) {
            const size_t at = 3 * (size_t)i + (size_t)k;
            const double mean = mean_of(batches, at, &error);
            CHECK_MSG(fabs(mean - rgb[k]) <= 5.0 * error + 2e-3 * rgb[k],
                      "roughness %g, metallic %g, N.V %.3f: %g +- %g, should "
                      "be %g",
                      ball->roughness, ball->metallic, p->n_v, mean, error,
                      rgb[k]);
            sum += mean / rgb[k] - 1;
            square += pow(mean / rgb[k] - 1, 2);
            count++;
        }
    }
    NEED(count > 50);
    const double mean = sum / count, rms = sqrt(square / count);
    /* R, G and B are of the same samples. */
    const double error = sqrt(3.0 * (square / count - mean * mean) / count);
    CHECK_MSG(fabs(mean) <= 4.0 * error + 5e-4, "%g +- %g", mean, error);
    CHECK_MSG(rms <= 0.015, "noise: %g", rms);
    test_measured("noise", rms, 0.015);
}

/* Wide and narrow lobes of dielectrics and metals, from the front to grazing
 * angles; and the other geometry, of a table that comes with the set. */
TEST_SLOW(integrals)
{
    begin(lights, 2, 3);
    on.settings.roughness[0] = 0.1;
    for (int i = 0; i < 3; ++i) {
        on.settings.yaw = 20.0 - 90.0 * i;
        on.settings.turn = i ? 217.0 : 37.0;
        on.settings.pitch = i ? -25.0 : 25.0;
        on.settings.multiscatter = i == 1;
        on.set.geometry = i < 2 ? IBL_GEOMETRY_SMITH : IBL_GEOMETRY_SCHLICK_IBL;
        compare(-70.0 * i);
    }
}

/* ---- closed forms ------------------------------------------------------- */

/* Without a lobe there is nothing to average: one sample is the reflection of
 * level 0, as it is in the split sum. */
TEST(mirror)
{
    view_error error;

    begin(lights, 1, 1);
    on.settings.metallic[0] = 1.0;
    on.settings.roughness[0] = 0.0;
    on.settings.multiscatter = false;
    for (int turn = 0; turn < 360; turn += 75) {
        on.settings.turn = turn;
        draw(1);
        CHECK(view_renderer_errors(on.renderer, &error) == 1);
        const double rmse = view_error_rmse(error);
        CHECK_MSG(rmse < 1e-3, "turned by %d: %g", turn, rmse);
    }
}

/* Lights without a size are summed, not sampled: in the dark both pictures are
 * the same, up to Schlick's Fresnel in the table. */
TEST(point_lights)
{
    view_error errors[6];
    double most = 0.0;

    begin(NULL, 2, 3);
    on.settings.light_count = 2;
    on.settings.light[0] = (view_light){{2, 3, 4}, {10, 20, 30}};
    on.settings.light[1] = (view_light){{-3, 1, 2}, {30, 5, 10}};
    on.set.light_count = 1;
    on.set.light[0] = (ibl_light){
        .direction = {0, 0.6, 0.8}, .radius = 0.02, .irradiance = {3, 2, 1}};
    NEED(view_renderer_load(on.renderer, &on.set));
    const float *rgb = add(1);
    CHECK(view_renderer_errors(on.renderer, errors) == 6);
    for (int i = 0; i < 6; ++i)
        CHECK_MSG(view_error_rmse(errors[i]) < 1e-5, "sphere %d: %g", i,
                  view_error_rmse(errors[i]));
    for (size_t i = 0; i < count_floats(); ++i)
        most = fmax(most, rgb[i]);
    CHECK(most > 0.1);
}

/* ---- sample after sample ------------------------------------------------ */

static double largest_difference(const float *a, const float *b)
{
    double most = 0.0;

    for (size_t i = 0; i < count_floats(); ++i)
        most = fmax(most, fabs((double)a[i] - b[i]) / (1.0 + fabs(b[i])));
    return most;
}

/* However samples are divided into draws, they are the same. */
TEST(one_by_one)
{
    begin(lights, 1, 2);
    const float *whole = add(37), *last = NULL;
    NEED(view_renderer_load(on.renderer, &on.set));
    for (int i = 0; i < 37; ++i)
        last = add(1);
    CHECK(view_renderer_samples(on.renderer) == 37);
    CHECK_NEAR(largest_difference(last, whole), 0.0, 2e-5);
}

/* Draws of spheres: of the split sum, and of each pass of the reference. */
static PFNGLDRAWARRAYSINSTANCEDPROC draw_instances;
static int sphere_draws;

static void APIENTRY count_draw(GLenum kind, GLint first, GLsizei vertices,
                                GLsizei instances)
{
    ++sphere_draws;
    draw_instances(kind, first, vertices, instances);
}

/* How often a frame draws spheres. */
static int draws(int samples)
{
    sphere_draws = 0;
    draw_instances = gl.DrawArraysInstanced;
    gl.DrawArraysInstanced = count_draw;
    draw(samples);
    gl.DrawArraysInstanced = draw_instances;
    return sphere_draws;
}

/* Samples after a draw of 4 with settings changed by change, after 4 before;
 * *split: whether that drew the split sum as well. */
static int after(const view_settings *changed, bool *split)
{
    const view_settings old = on.settings;

    view_renderer_load(on.renderer, &on.set);
    NEED(draws(4) == 2 && view_renderer_samples(on.renderer) == 4);
    CHECK(draws(4) == 1);
    view_renderer_load(on.renderer, &on.set);
    CHECK(draws(4) == 2);
    on.settings = *changed;
    *split = draws(4) == 2;
    on.settings = old;
    return view_renderer_samples(on.renderer);
}

#define AFTER(member, value, samples, redrawn)                                 \
    do {                                                                       \
        view_settings changed = on.settings;                                   \
        bool split = false;                                                    \
        changed.member = (value);                                              \
        CHECK_MSG(after(&changed, &split) == (samples) && split == (redrawn),  \
                  "%s = %s", #member, #value);                                 \
    } while (0)

/* Settings of a picture restart it; settings of only the display do not. */
TEST(restart)
{
    begin(lights, 2, 2);
    AFTER(ev, 2.0, 8, false);
    AFTER(tone, VIEW_TONE_REINHARD, 8, false);
    AFTER(false_colour, true, 8, false);
    AFTER(compare, VIEW_DIFFERENCE, 8, false);
    AFTER(split, 0.25, 8, false);
    AFTER(gain, 3.0, 8, false);
    AFTER(diffuse, VIEW_DIFFUSE_SH, 8, true);
    AFTER(help, true, 8, false);
    AFTER(yaw, 10.0, 4, true);
    AFTER(pitch, 10.0, 4, true);
    AFTER(distance, 9.0, 4, true);
    AFTER(fov, 50.0, 4, true);
    AFTER(turn, 1.0, 4, true);
    AFTER(sky, !on.settings.sky, 4, true);
    AFTER(multiscatter, !on.settings.multiscatter, 4, true);
    AFTER(material, 1, 4, true);
    AFTER(rows, 1, 4, true);
    AFTER(columns, 3, 4, true);
    AFTER(metallic[1], 0.5, 4, true);
    AFTER(roughness[0], 0.5, 4, true);
    AFTER(light_count, 1, 4, true);
}

/* Nothing of what was before is left in what is begun anew. */
TEST(same_as_new)
{
    begin(lights, 1, 2);
    const float *first = add(5);
    on.settings.yaw = 33.0;
    draw(3);
    CHECK(view_renderer_draw(on.renderer, &on.settings, 20, 20));
    on.settings.yaw = 0.0;
    CHECK(!memcmp(add(5), first, count_floats() * sizeof *first));
}

/* At VIEW_TRUTH_SAMPLES it rests. */
TEST(rest)
{
    begin(lights, 1, 1);
    on.settings.distance = 40.0; /* few pixels */
    draw(VIEW_TRUTH_SAMPLES - 1);
    const float *last = add(1000);
    CHECK(view_renderer_samples(on.renderer) == VIEW_TRUTH_SAMPLES);
    CHECK(!memcmp(add(1), last, count_floats() * sizeof *last));
    CHECK(view_renderer_samples(on.renderer) == VIEW_TRUTH_SAMPLES);
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
    static const struct {
        double took;
        int samples; /* and those after the frame, of that one */
    } frames[] = {{0.01, 1},  {0.01, 2},  {0.01, 4},  {0.01, 8}, {0.07, 16},
                  {0.07, 16}, {0.2, 16},  {0.2, 8},   {0.01, 4}, {0.01, 8},
                  {0.01, 16}, {0.01, 32}, {0.01, 64}, {0.01, 64}};
    int all = 0;

    begin(lights, 1, 1);
    for (size_t i = 0; i < sizeof frames / sizeof *frames; ++i) {
        tick = frames[i].took;
        draw(0);
        all += frames[i].samples;
        CHECK_MSG(view_renderer_samples(on.renderer) == all, "%zu: %d, not %d",
                  i, view_renderer_samples(on.renderer), all);
    }
    tick = 0;
}

/* A chain of rough levels alone with a skybox: that is the environment. One
 * with the environment in it has no need of a skybox, which may be another. */
TEST(skybox)
{
    baked_set rough;

    begin(lights, 1, 2);
    on.settings.sky = false;
    const float *whole = add(8);
    bake(0.4, &rough);
    CHECK(rough.roughness[0] > 0.3 && !rough.texture[VIEW_SKY].data);
    on.set.texture[VIEW_SKY] = rough.texture[VIEW_SPECULAR];
    CHECK(view_renderer_load(on.renderer, &on.set));
    CHECK(largest_difference(add(8), whole) < 1e-4);
    on.set.texture[VIEW_SKY] = (ibl_texture){0};
    rough.texture[VIEW_SKY] = on.set.texture[VIEW_SPECULAR];
    on.set.texture[VIEW_SPECULAR] = (ibl_texture){0};
    CHECK(view_renderer_load(on.renderer, &rough));
    CHECK(largest_difference(add(8), whole) < 1e-4);
    view_set_free(&rough);
}

/* The map, if it is at hand, or level 0, with a note where it cannot be read.
 */
TEST(map)
{
    begin(lights, 1, 1);
    const float *level0 = add(1);
    CHECK(!strcmp(view_renderer_environment(on.renderer), "level 0"));
    use_map(0);
    add(1);
    CHECK(view_renderer_environment(on.renderer) == on.set.source);
    on.set.source_peak = 12345; /* as of another layer */
    NEED(view_renderer_load(on.renderer, &on.set));
    add(1);
    CHECK(!strcmp(view_renderer_environment(on.renderer), "level 0"));
    on.set.source_peak = 0;
    NEED(file_save(on.set.source, "no map", 6));
    view_test_catch();
    NEED(view_renderer_load(on.renderer, &on.set));
    const float *without = add(1);
    CHECK(strstr(view_test_caught(), "cannot be read again"));
    CHECK(largest_difference(without, level0) < 1e-5);
}
