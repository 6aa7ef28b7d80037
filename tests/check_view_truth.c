/* SPDX-License-Identifier: MIT */
/*
 * The reference against the same integral written out in double: sums over
 * parts of level 0's texels for wide lobes, over half vectors for narrow ones.
 * Neither knows how the shader draws its samples.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "ibl/reference.h"
#include "maps.h"
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
    int width, height;
} on;

/* Lights on every face, an edge and near a corner, under a smooth sky. */
static void lights(ibl_image *map)
{
    static const double at[][3] = {
        {1, 0.2, 0.1},  {-1, 0.3, 0.4}, {0.1, 1, 0.2}, {0.2, -1, 0.3},
        {0.3, -0.1, 1}, {0, 0.3, -1},   {1, 0.1, 1},   {-1, 1, 0.9}};

    for (int y = 0; y < map->height; ++y)
        for (int x = 0; x < map->width; ++x) {
            float *p = map->data + 3 * (y * map->width + x);
            p[0] = 0.3F + 0.2F * (float)sin(0.1 * x);
            p[1] = 0.5F - 0.3F * (float)y / (float)map->height;
            p[2] = 0.4F;
        }
    for (int i = 0; i < 8; ++i) {
        const double length = sqrt(test_dot(at[i], at[i]));
        const double d[3] = {at[i][0] / length, at[i][1] / length,
                             at[i][2] / length};
        int x, y;
        truth_latlong_pixel(map->width, map->height, d, &x, &y);
        float *p = map->data + 3 * (y * map->width + x);
        p[i % 3] = 100.0F + 30.0F * (float)i;
        p[(i + 1) % 3] = 50.0F;
    }
}

static void constant(ibl_image *map)
{
    for (int i = 0; i < 3 * map->width * map->height; ++i)
        map->data[i] = 1.0F;
}

static void black(ibl_image *map)
{
    memset(map->data, 0,
           (size_t)3 * map->width * map->height * sizeof *map->data);
}

static bool bake(void (*fill)(ibl_image *), double roughness_min,
                 baked_set *set)
{
    ibl_specular_options opts = ibl_specular_options_default();
    ibl_image map;
    bool ok;

    opts.size = 16;
    opts.roughness_min = roughness_min;
    if (ibl_image_alloc(on.ctx, 64, 32, &map) != IBL_OK)
        return false;
    fill(&map);
    ok = sets_bake_image(on.ctx, "test", &map, &opts, set);
    ibl_image_free(&map);
    return ok;
}

static void end(void *unused)
{
    (void)unused;
    view_set_free(&on.set);
}

/* A grid of rows x columns under a map, 32 pixels a sphere. */
static void begin(void (*fill)(ibl_image *), int rows, int columns)
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
    NEED(bake(fill, 0.0, &on.set) && view_renderer_load(on.renderer, &on.set));
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

/* The spheres of the grid. */
static const view_sphere *spheres(void)
{
    static view_sphere all[VIEW_MAX_GRID * VIEW_MAX_GRID];

    view_grid(&on.settings, all);
    return all;
}

/* ---- the integrals in double -------------------------------------------- */

enum {
    PARTS = 8,       /* of a texel along an axis */
    HALF_STEPS = 384 /* of half vectors along each axis */
};

/* Level 0 as points: directions of the world, light times solid angle. */
typedef struct field {
    ibl_cube cube;
    double turn;
    int count;
    double (*d)[3], (*light)[3], *solid_angle;
} field;

static field make_field(void)
{
    field f = {.turn = on.settings.turn};

    NEED(!ibl_texture_to_cube(on.ctx, &on.set.texture[VIEW_SPECULAR], &f.cube));
    const int n = f.cube.size * PARTS;
    f.count = 6 * n * n;
    f.d = test_alloc((size_t)f.count, sizeof *f.d);
    f.light = test_alloc((size_t)f.count, sizeof *f.light);
    f.solid_angle = test_alloc((size_t)f.count, sizeof *f.solid_angle);
    for (int i = 0; i < f.count; ++i) {
        const int x = i % n, y = i / n % n;
        double d[3];
        truth_cube_direction(n, i / n / n, x, y, d);
        shade_cube(&f.cube, 0, d, f.light[i]);
        view_turn(-f.turn, d, f.d[i]);
        f.solid_angle[i] = ibl_cube_solid_angle(n, x, y);
    }
    return f;
}

/* Smith's lambda: Heitz 2014, eq. 72. */
static double lambda(double cosine, double alpha)
{
    const double tan2 = (1.0 - cosine * cosine) / (cosine * cosine);

    return 0.5 * (sqrt(1.0 + alpha * alpha * tan2) - 1.0);
}

static double masking(double n_l, double n_v, double alpha,
                      ibl_geometry geometry)
{
    const double k = 0.5 * alpha;

    if (geometry == IBL_GEOMETRY_SMITH)
        return 1.0 / (1.0 + lambda(n_l, alpha) + lambda(n_v, alpha));
    return n_l / (n_l * (1.0 - k) + k) * n_v / (n_v * (1.0 - k) + k);
}

static double fresnel(double f0, double v_h)
{
    return f0 + (1.0 - f0) * pow(1.0 - v_h, 5.0);
}

/* Sum over all of level 0 of F D G / (4 N.V) L, and of N.L / pi L. */
static void by_texels(const field *f, const shade_pixel *p,
                      const view_sphere *ball, double specular[3],
                      double diffuse[3])
{
    const double alpha = ball->roughness * ball->roughness;

    for (int i = 0; i < f->count; ++i) {
        const double *l = f->d[i], n_l = test_dot(p->normal, l);
        double h[3], length2 = 0.0;
        if (n_l <= 0.0)
            continue;
        for (int k = 0; k < 3; ++k) {
            h[k] = l[k] + p->view[k];
            length2 += h[k] * h[k];
        }
        const double n_h = test_dot(p->normal, h) / sqrt(length2);
        const double v_h = test_dot(p->view, h) / sqrt(length2);
        const double t = n_h * n_h * (alpha * alpha - 1.0) + 1.0;
        const double d = alpha * alpha / (M_PI * t * t);
        const double g = masking(n_l, p->n_v, alpha, on.set.geometry);
        for (int k = 0; k < 3; ++k) {
            const double light = f->light[i][k] * f->solid_angle[i];
            specular[k] +=
                fresnel(ball->f0[k], v_h) * d * g / (4.0 * p->n_v) * light;
            diffuse[k] += n_l / M_PI * light;
        }
    }
}

/* The specular sum over half vectors, dL = 4 V.H dH, the measure D N.H dH being
 * du dphi / 2 pi (Walter et al. 2007, eq. 35 and 36), by midpoints in phi and
 * in the fourth root of 1 - u, so that the lobe's tail has its part of them. */
static void by_half_vectors(const field *f, const shade_pixel *p,
                            const view_sphere *ball, double specular[3])
{
    const double alpha = ball->roughness * ball->roughness;
    double t[3], b[3];

    for (int k = 0; k < 3; ++k)
        t[k] = p->view[k] - p->n_v * p->normal[k];
    const double length = sqrt(test_dot(t, t));
    for (int k = 0; k < 3; ++k)
        t[k] /= length;
    for (int k = 0; k < 3; ++k)
        b[k] = p->normal[(k + 1) % 3] * t[(k + 2) % 3] -
               p->normal[(k + 2) % 3] * t[(k + 1) % 3];
    for (int i = 0; i < HALF_STEPS * HALF_STEPS; ++i) {
        const double w = 1.0 - (i / HALF_STEPS + 0.5) / HALF_STEPS;
        const double left = w * w * (w * w); /* 1 - u */
        const double phi = 2.0 * M_PI * (i % HALF_STEPS + 0.5) / HALF_STEPS;
        const double tan_h = alpha * sqrt((1.0 - left) / left);
        const double n_h = 1.0 / sqrt(1.0 + tan_h * tan_h);
        double h[3], l[3], env[3], light[3];
        for (int k = 0; k < 3; ++k)
            h[k] = n_h *
                   (p->normal[k] + tan_h * (cos(phi) * t[k] + sin(phi) * b[k]));
        const double v_h = test_dot(p->view, h);
        for (int k = 0; k < 3; ++k)
            l[k] = 2.0 * v_h * h[k] - p->view[k];
        const double n_l = test_dot(p->normal, l);
        if (n_l <= 0.0 || v_h <= 0.0)
            continue;
        view_turn(f->turn, l, env);
        shade_cube(&f->cube, 0, env, light);
        const double g = masking(n_l, p->n_v, alpha, on.set.geometry) * v_h /
                         (p->n_v * n_h) * 4.0 * w * w * w /
                         ((double)HALF_STEPS * HALF_STEPS);
        for (int k = 0; k < 3; ++k)
            specular[k] += fresnel(ball->f0[k], v_h) * g * light[k];
    }
}

/* What irradiance / pi is multiplied by: Fdez-Aguera 2019, and what specular
 * light leaves to the diffuse. */
static double diffuse_factor(double f0, double albedo, const double rg[2],
                             bool multiple)
{
    const double single = f0 * rg[0] + rg[1], lost = 1.0 - rg[0] - rg[1];
    const double average = f0 + (1.0 - f0) / 21.0;
    const double more =
        multiple ? single * average / (1.0 - average * lost) * lost : 0.0;

    return more + albedo * (1.0 - single - more);
}

static void expected(const field *f, const shade_pixel *p,
                     const view_sphere *ball, double rgb[3])
{
    double specular[3] = {0.0}, diffuse[3] = {0.0}, rg[2];

    by_texels(f, p, ball, specular, diffuse);
    if (ball->roughness < 0.4) {
        memset(specular, 0, sizeof specular);
        by_half_vectors(f, p, ball, specular);
    }
    NEED(!ibl_reference_lut(on.ctx, p->n_v, ball->roughness, on.set.geometry,
                            rg));
    for (int k = 0; k < 3; ++k)
        rgb[k] = specular[k] +
                 diffuse[k] * diffuse_factor(ball->f0[k], ball->albedo[k], rg,
                                             on.settings.multiscatter);
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

/* Relative errors of all pixels together: what they have in common. */
typedef struct bias {
    double sum[BATCHES + 1], square[BATCHES + 1];
    int count;
} bias;

static void add_to_bias(bias *all, float *const batches[BATCHES], size_t at,
                        double mean, double truth)
{
    for (int b = 0; b <= BATCHES; ++b) {
        const double e = (b < BATCHES ? batches[b][at] : mean) / truth - 1.0;
        all->sum[b] += e;
        all->square[b] += e * e;
    }
    ++all->count;
}

/*
 * Each pixel is within 5 standard errors of what it should be, as its own
 * batches tell, and 0.2 % for the sums here and the table that the shader
 * reads. Over all pixels the mean of the relative errors is within 4 of its
 * standard errors and 0.05 % of nothing, of the whole picture and of each batch
 * alone, and their root mean square below `noise`.
 */
static void compare(double noise)
{
    float *batches[BATCHES];
    bias all = {.count = 0};
    field f = make_field();
    const int every = TEST_SANITIZED ? 17 : 7;
    const shade_pixel *pixels = shade_pixels(&on.settings);

    draw_batches(batches);
    for (int i = 0; i < on.width * on.height; i += every) {
        const shade_pixel *p = &pixels[i];
        double rgb[3], error;
        if (p->sphere < 0 || p->n_v < 0.02)
            continue;
        const view_sphere *ball = &spheres()[p->sphere];
        expected(&f, p, ball, rgb);
        for (int k = 0; k < 3; ++k) {
            const size_t at = 3 * (size_t)i + (size_t)k;
            const double mean = mean_of(batches, at, &error);
            CHECK_MSG(fabs(mean - rgb[k]) <= 5.0 * error + 2e-3 * rgb[k],
                      "roughness %g, metallic %g, N.V %.3f: %g +- %g, should "
                      "be %g",
                      ball->roughness, ball->metallic, p->n_v, mean, error,
                      rgb[k]);
            add_to_bias(&all, batches, at, mean, rgb[k]);
        }
    }
    CHECK(all.count > 50);
    for (int b = 0; b <= BATCHES && all.count; ++b) {
        const double mean = all.sum[b] / all.count;
        /* R, G and B are of the same samples. */
        const double error =
            sqrt(3.0 * (all.square[b] / all.count - mean * mean) / all.count);
        CHECK_MSG(fabs(mean) <= 4.0 * error + 5e-4, "batch %d: %g +- %g", b,
                  mean, error);
    }
    const double rms = sqrt(all.square[BATCHES] / all.count);
    CHECK_MSG(rms <= noise, "noise: %g", rms);
    ibl_cube_free(&f.cube);
}

/* Wide lobes of dielectrics and metals, from the front to grazing angles. */
TEST_SLOW(wide_lobes)
{
    begin(lights, 2, 3);
    on.settings.roughness[0] = 0.4;
    on.settings.yaw = 20.0;
    for (int i = 0; i < 2; ++i) {
        on.settings.turn = i ? 217.0 : 37.0;
        on.settings.pitch = i ? -25.0 : 25.0;
        on.settings.multiscatter = i;
        compare(0.01);
    }
}

TEST_SLOW(narrow_lobes)
{
    begin(lights, 1, 2);
    on.settings.roughness[0] = 0.1;
    on.settings.roughness[1] = 0.25;
    on.settings.metallic[0] = 1.0;
    on.settings.multiscatter = false;
    on.settings.yaw = -70.0;
    compare(0.01);
}

/* The geometry of the table that comes with the set. */
TEST(schlick_geometry)
{
    begin(lights, 1, 2);
    on.settings.roughness[0] = 0.5;
    on.settings.metallic[0] = 1.0;
    on.settings.multiscatter = false;
    on.settings.pitch = -40.0;
    on.set.geometry = IBL_GEOMETRY_SCHLICK_IBL;
    NEED(view_renderer_load(on.renderer, &on.set));
    compare(0.01);
}

/* ---- closed forms ------------------------------------------------------- */

/* Under light of 1 from everywhere white spheres, of whatever roughness and
 * kind, show 1 if nothing is lost; else what the table says. */
TEST_SLOW(white_furnace)
{
    begin(constant, 2, 4);
    on.settings.material = shade_material("white");
    for (int multiple = 0; multiple < 2; ++multiple) {
        on.settings.multiscatter = multiple;
        const float *rgb = add(512);
        const shade_pixel *pixels = shade_pixels(&on.settings);
        for (int i = 0; i < on.width * on.height; i += 5) {
            const shade_pixel *p = &pixels[i];
            double rg[2] = {1.0, 0.0};
            if (p->sphere < 0 || p->n_v < 0.05)
                continue;
            const view_sphere *ball = &spheres()[p->sphere];
            if (!multiple)
                ibl_reference_lut(on.ctx, p->n_v, ball->roughness,
                                  on.set.geometry, rg);
            const double single = ball->f0[0] * rg[0] + rg[1];
            CHECK_NEAR(rgb[3 * i],
                       multiple ? 1.0
                                : single + ball->albedo[0] * (1.0 - single),
                       1e-2);
        }
    }
}

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

    begin(black, 2, 3);
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
    NEED(bake(lights, 0.4, &rough));
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

/* The lights, and twice them, turned, in a file. */
static void save_twice(ibl_image *map)
{
    ibl_image turned;
    const int n = 64;

    NEED(!ibl_image_alloc(on.ctx, n, n / 2, map) &&
         !ibl_image_alloc(on.ctx, n, n / 2, &turned));
    lights(map);
    for (int i = 0; i < n * n / 2; ++i)
        for (int k = 0; k < 3; ++k)
            turned.data[3 * i + k] =
                2 * map->data[3 * (i / n * n + (i + n / 4) % n) + k];
    NEED(file_save_exr(file_path("twice.exr"), &turned, NULL));
    ibl_image_free(&turned);
}

/* Of a mirror's pixels, the share that is not twice the map's pixel. */
static double share_off(const ibl_image *map, const float *rgb)
{
    const shade_pixel *pixels = shade_pixels(&on.settings);
    int all = 0, off = 0;

    for (int i = 0; i < on.width * on.height; ++i) {
        int x, y;
        if (pixels[i].sphere < 0)
            continue;
        truth_latlong_pixel(map->width, map->height, pixels[i].reflected, &x,
                            &y);
        const float *p = map->data + 3 * (y * map->width + x);
        all++;
        for (int k = 0; k < 3; k++)
            if (fabs(rgb[3 * i + k] - 2.0 * p[k]) > 1e-4 * p[k]) {
                off++;
                break;
            }
    }
    return (double)off / all;
}

/* The mean difference of a picture from twice another, over its mean. */
static double share_apart(const float *twice, const float *rgb)
{
    double apart = 0, all = 0;

    for (size_t i = 0; i < count_floats(); ++i) {
        apart += fabs(twice[i] - 2.0 * rgb[i]);
        all += 2.0 * rgb[i];
    }
    return apart / all;
}

/* The map, if it is at hand, with the turn that it was baked with and constant
 * over each pixel, or level 0 with a note. */
TEST(map)
{
    ibl_image map;

    begin(lights, 1, 1);
    on.settings.sky = on.settings.multiscatter = false;
    on.settings.material = shade_material("white");
    on.settings.metallic[0] = on.settings.metallic[1] = 1;
    on.settings.roughness[0] = on.settings.roughness[1] = 0;
    const float *level0 = add(1);
    CHECK(!strcmp(view_renderer_environment(on.renderer), "level 0"));
    on.settings.roughness[0] = on.settings.roughness[1] = 0.5;
    const float *rough = add(256);
    save_twice(&map);
    on.set.source = strdup(file_path("twice.exr"));
    on.set.source_read = ibl_read_options_default();
    on.set.source_yaw = -90;
    NEED(view_renderer_load(on.renderer, &on.set));
    CHECK(share_apart(add(256), rough) < 0.2);
    on.settings.roughness[0] = on.settings.roughness[1] = 0;
    const double off = share_off(&map, add(1));
    ibl_image_free(&map);
    CHECK(view_renderer_environment(on.renderer) == on.set.source);
    CHECK_MSG(off < 0.01, "%.1f %% of the pixels are off", 100 * off);
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
