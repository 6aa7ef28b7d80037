/* SPDX-License-Identifier: MIT */
/* The split sum: energy, every pixel against the same in double, centres
 * against the library's own sums over the source, point lights. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/reference.h"
#include "maps.h"
#include "reference.h"
#include "shade.h"
#include "textures.h"
#include "truth.h"

static shade_set *const set = &shade_sets[0];
static double shown(double linear)
{
    const double c = fmin(fmax(linear, 0), 1);

    return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
}

/* A row of white metal, from smooth to rough. */
static view_settings white_metal(void)
{
    view_settings s = view_settings_default();

    s.rows = 2;
    s.columns = 7;
    s.metallic[0] = 1;
    s.material = shade_material("white");
    s.multiscatter = false;
    return s;
}

/* ---- energy ------------------------------------------------------------ */

/* Everything of one colour, spheres too, edges included. */
static void furnace(const view_settings *s, const float rgb[3],
                    double tolerance)
{
    float *picture = shade_draw(&set->set, s);
    double worst = 0;

    for (int i = 0; i < 3 * shade_width() * shade_height(); i++)
        worst = fmax(worst, fabs(picture[i] / (double)rgb[i % 3] - 1));
    CHECK_MSG(worst <= tolerance, "off by %g", worst);
}

/* R and G by adaptive quadrature, at the nearest point that the table's texels
 * go to; at most 1 % from what they would be at that point itself. */
static void scattered_once(double n_v, double roughness, double rg[2])
{
    const double end = 0.5 / SHADE_TABLE;
    const double inside = fmin(fmax(roughness, end), 1 - end);
    double exact[2];

    reference_lut(n_v, inside, IBL_GEOMETRY_SMITH, rg);
    reference_lut(n_v, fmax(roughness, 1e-3), IBL_GEOMETRY_SMITH, exact);
    CHECK_NEAR(rg[0], exact[0], 0.01);
    CHECK_NEAR(rg[1], exact[1], 0.01);
}

/* Metals and dielectrics reflect or scatter no more than there is, and a white
 * one all of it; light of another colour is a factor. */
TEST(coloured_furnace)
{
    const float rgb[3] = {0.25f, 1.5f, 30};

    shade_begin(128, 128);
    shade_constant(set, rgb);
    view_settings s = view_settings_default();
    s.rows = 2; /* what is between plastic and metal absorbs */
    s.material = shade_material("white");
    for (int i = 0; i < 2; i++) {
        s.multiscatter = true;
        s.diffuse = (view_diffuse)i;
        furnace(&s, rgb, 1e-5);
    }
    s.yaw = 70;
    s.pitch = 30;
    s.turn = 77;
    furnace(&s, rgb, 1e-5);
}

/* Gold of every kind under a constant light. */
TEST_SLOW(constant_light)
{
    const float rgb[3] = {2, 0.5f, 0.125f};
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    double worst = 0;

    shade_begin(128, 128);
    shade_constant(set, rgb);
    view_settings s = view_settings_default();
    s.multiscatter = false;
    s.sky = false;
    float *picture = shade_draw(&set->set, &s);
    shade_pixel *pixels = shade_pixels(&s);
    view_grid(&s, spheres);
    for (int i = 0; i < shade_width() * shade_height(); i++) {
        const shade_pixel *p = &pixels[i];
        for (int k = 0; k < 3 && p->sphere == -1; k++)
            CHECK(picture[3 * i + k] == 0);
        if (p->sphere < 0 || p->n_v < 0.1 || i % 7)
            continue;
        const view_sphere *ball = &spheres[p->sphere];
        double rg[2];
        scattered_once(p->n_v, ball->roughness, rg);
        for (int k = 0; k < 3; k++) {
            const double f = ball->f0[k] * rg[0] + rg[1];
            const double all = f + ball->albedo[k] * (1 - f);
            worst = fmax(worst, fabs(picture[3 * i + k] / rgb[k] - all));
        }
    }
    CHECK_MSG(worst < 5e-4, "off by %g", worst);
}

/* ---- every pixel ------------------------------------------------------- */

static ibl_image smooth_map(uint64_t seed)
{
    test_random r = {seed};

    return map_of_kind(shade_ctx(), &r, MAP_SMOOTH, 128, 64);
}

/* The picture against shade_split_sum; tolerance relative to the brightest. */
static void against_double(const view_settings *s, double tolerance)
{
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    float *picture = shade_draw(&set->set, s);
    shade_pixel *pixels = shade_pixels(s);
    double worst = 0, most = 0;
    int seen = 0;

    view_grid(s, spheres);
    for (int i = 0; i < shade_width() * shade_height(); i++) {
        const shade_pixel *p = &pixels[i];
        shade_light light;
        double rgb[3];
        if (p->sphere < 0 || p->n_v < 0.02)
            continue;
        seen++;
        shade_look_up(set, s, &spheres[p->sphere], p, &light);
        shade_split_sum(s, &spheres[p->sphere], &light, rgb);
        for (int k = 0; k < 3; k++) {
            most = fmax(most, rgb[k]);
            worst = fmax(worst, fabs(picture[3 * i + k] - rgb[k]));
        }
    }
    CHECK(seen > 500);
    CHECK_MSG(worst <= tolerance * most, "off by %g of %g", worst, most);
}

TEST(pixels_in_double)
{
    ibl_specular_options opts = ibl_specular_options_default();

    shade_begin(128, 128);
    opts.size = 32;
    ibl_image map = smooth_map(5);
    for (int i = 0; i < 8; i++) {
        opts.mapping =
            i % 4 < 2 ? IBL_ROUGHNESS_LINEAR : IBL_ROUGHNESS_FILAMENT;
        if (i % 2 == 0)
            shade_bake(set, &map, &opts);
        view_settings s = view_settings_default();
        s.material = i;
        s.diffuse = (view_diffuse)(i / 2 % 2);
        s.multiscatter = i / 4;
        s.yaw = 50 * i;
        s.pitch = 8 * i - 30;
        s.turn = 33 * i;
        against_double(&s, 1e-4);
    }
}

/* A table of lobes for which one tap is irradiance, and two are of level 0,
 * half way to the normal and there. */
static void add_lobes(void)
{
    const float texels[2][4] = {{0, 0, 1, 0}, {0.75F, 0, 0, 0.25F}};
    ibl_texture *t = &set->set.texture[VIEW_LOBES];

    *t = texture_random(shade_ctx(), IBL_PIXEL_RGBA32F, (int[]){4, 4, 1, 1}, 4);
    for (size_t i = 0; i < t->bytes / sizeof *texels; i++)
        memcpy(t->data + i * sizeof *texels, texels[i / 32], sizeof *texels);
}

static void check_lobes(const view_settings *s, bool other, double bend)
{
    float *picture =
        test_alloc((size_t)(3 * shade_width() * shade_height()), sizeof(float));
    shade_pixel *pixels = shade_pixels(s);
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    double worst = 0, rgb[3], d[3], half[3];

    NEED(view_renderer_read(shade_renderer(), other, picture));
    view_grid(s, spheres);
    for (int i = 0; i < shade_width() * shade_height(); i++) {
        const shade_pixel *p = &pixels[i];
        shade_light light;
        if (p->sphere < 0 || p->n_v < 0.02)
            continue;
        shade_look_up(set, s, &spheres[p->sphere], p, &light);
        memcpy(light.specular, light.irradiance, sizeof light.specular);
        for (int tap = 0; tap < 2 && other; tap++) {
            for (int k = 0; k < 3; k++)
                d[k] = p->reflected[k] +
                       (bend + 0.5 * tap) * (p->normal[k] - p->reflected[k]);
            shade_cube(&set->specular, 0, d, tap ? half : light.specular);
        }
        for (int k = 0; k < 3 && other; k++)
            light.specular[k] = 0.5 * (light.specular[k] + half[k]);
        shade_split_sum(s, &spheres[p->sphere], &light, rgb);
        for (int k = 0; k < 3; k++)
            worst = fmax(worst, fabs(picture[3 * i + k] - rgb[k]));
    }
    CHECK_MSG(worst < 1e-4, "side %d is off by %g", other, worst);
}

/* Each side of a comparison is what its reflection says. */
TEST(lobes_of_a_table)
{
    ibl_specular_options opts = ibl_specular_options_default();

    shade_begin(128, 128);
    opts.size = 32;
    ibl_image map = smooth_map(5);
    shade_bake(set, &map, &opts);
    add_lobes();
    view_settings s = view_settings_default();
    s.reflection = VIEW_TABLE_LOBES;
    s.against = VIEW_TWO_TAPS;
    s.compare = VIEW_SPLIT;
    shade_draw(&set->set, &s);
    check_lobes(&s, false, 0);
    check_lobes(&s, true, 0.5);
}

/* Equal coefficients in every degree of irradiance; sums are cut off at 0. */
TEST(harmonics_in_double)
{
    const float dim[3] = {0.01f, 0.01f, 0.01f};
    test_random r = {17};

    shade_begin(96, 96);
    shade_constant(set, dim);
    view_settings s = view_settings_default();
    s.material = shade_material("white");
    s.diffuse = VIEW_DIFFUSE_SH;
    set->set.sh_degree = VIEW_SH_DEGREE;
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 75; k++)
            set->set.sh[k] = k < 27 || k >= 48 ? test_random_unit(&r) - 0.5 : 0;
        for (int k = 0; k < 3; k++)
            set->set.sh[k] = i ? 8 : -8;
        s.yaw = 60 * i;
        s.pitch = 12 * i - 30;
        against_double(&s, 1e-4);
    }
}

/* A scale of the irradiance map that another baker chose. */
TEST(irradiance_scale)
{
    ibl_specular_options opts = ibl_specular_options_default();

    shade_begin(96, 96);
    opts.size = 32;
    ibl_image map = smooth_map(6);
    shade_bake(set, &map, &opts);
    view_settings s = view_settings_default();
    float *ours = shade_draw(&set->set, &s);
    for (size_t i = 0; i < 3 * ibl_cube_texels(set->irradiance.size, 1); i++)
        set->irradiance.data[i] *= 4;
    shade_pack(set, IBL_PIXEL_RGBA32F, IBL_PIXEL_RG32F);
    set->set.irradiance_scale = 0.25;
    float *theirs = shade_draw(&set->set, &s);
    CHECK(!memcmp(ours, theirs, 3 * 96 * 96 * sizeof *ours));
}

/* ---- centres against the library ---------------------------------------- */

/* Sums over the source against the shader's lookups: within an 8-bit step. */
static void centres(const ibl_image *map, const view_settings *s)
{
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    ibl_reference *ref = NULL;
    double worst = 0;

    NEED(!ibl_reference_create(shade_ctx(), map, 0, &ref));
    float *picture = shade_draw(&set->set, s);
    shade_pixel *pixels = shade_pixels(s);
    const int count = view_grid(s, spheres);
    for (int i = 0; i < count; i++) {
        const int at = shade_centre(s, &spheres[i]);
        const shade_pixel *p = &pixels[at];
        const double r = spheres[i].roughness;
        shade_light light;
        double rgb[3];
        CHECK(p->sphere == i);
        CHECK(!ibl_reference_irradiance(ref, p->normal, 1, light.irradiance));
        CHECK(!ibl_reference_lut(shade_ctx(), p->n_v, r, IBL_GEOMETRY_SMITH,
                                 light.table));
        if (r > 0)
            CHECK(!ibl_reference_lobe(ref, IBL_LOBE_GGX, r, p->reflected, 1,
                                      light.specular));
        else /* pixels, where level 0 is smooth */
            shade_cube(&set->specular, 0, p->reflected, light.specular);
        shade_split_sum(s, &spheres[i], &light, rgb);
        for (int k = 0; k < 3; k++)
            worst =
                fmax(worst, fabs(shown(picture[3 * at + k]) - shown(rgb[k])));
    }
    CHECK_MSG(worst <= 1.0 / 255, "off by %g steps", worst * 255);
    ibl_reference_free(ref);
}

TEST(centres_by_library)
{
    ibl_specular_options opts = ibl_specular_options_default();

    shade_begin(217, 217);
    opts.size = 256;
    ibl_image map = smooth_map(9);
    for (int i = 0; i < 2; i++) {
        view_settings s = view_settings_default();
        /* A level for each column: every engine interpolates between levels. */
        opts.mapping = i ? IBL_ROUGHNESS_FILAMENT : IBL_ROUGHNESS_LINEAR;
        opts.levels = s.columns = 6;
        shade_bake(set, &map, &opts);
        s.multiscatter = i;
        if (i) {
            s.columns = 1;
            for (int level = 0; level < opts.levels; level++) {
                s.roughness[0] =
                    ibl_level_roughness(opts.mapping, level, opts.levels);
                centres(&map, &s);
            }
        } else {
            centres(&map, &s);
        }
    }
}

/* ---- point lights ------------------------------------------------------ */

/* Far lights all over the hemisphere, four at a time, are a white sky: what a
 * white metal reflects of them is R + G, of a white dielectric 1. */
TEST(lights_add_up_to_a_furnace)
{
    const float black[3] = {0, 0, 0};
    const int rings = TEST_SANITIZED ? 8 : 16, around = 2 * rings;
    const double far = 1e6;
    view_sphere ball[VIEW_MAX_GRID * VIEW_MAX_GRID];
    double sum[2] = {0, 0}, rg[2];

    shade_begin(31, 31);
    shade_constant(set, black);
    view_settings s = white_metal();
    s.columns = 1;
    s.metallic[0] = 0;
    s.metallic[1] = 1;
    s.roughness[0] = 0.7;
    s.light_count = 4;
    s.sky = false;
    view_grid(&s, ball);
    shade_pixel *pixels = shade_pixels(&s);
    for (int i = 0; i < rings * around; i += 4) {
        for (int j = 0; j < 4; j++) {
            /* Equal solid angles of the hemisphere towards the camera. */
            const double z = ((i + j) / around + 0.5) / rings;
            const double phi = ((i + j) % around + 0.5) * 2 * M_PI / around;
            s.light[j] =
                (view_light){{far * sqrt(1 - z * z) * cos(phi),
                              far * sqrt(1 - z * z) * sin(phi), far * z},
                             {0, far * far, 0}};
        }
        float *picture = shade_draw(&set->set, &s);
        for (int j = 0; j < 2; j++)
            sum[j] += picture[3 * shade_centre(&s, &ball[j]) + 1] * 2 * M_PI /
                      (rings * around);
        for (int j = 0; j < 31 * 31; j++)
            CHECK(picture[3 * j] == 0 && picture[3 * j + 2] == 0);
    }
    reference_lut(pixels[shade_centre(&s, &ball[1])].n_v, 0.7,
                  IBL_GEOMETRY_SMITH, rg);
    CHECK_NEAR(sum[1], rg[0] + rg[1], 0.02);
    CHECK_NEAR(sum[0], 1, 0.02);
}

/* One light as Walter, Heitz and Schlick have it, in double, over all pixels:
 * distance, back sides, all roughnesses. */
static double light_at(const view_sphere *ball, const shade_pixel *p,
                       const view_light *light, int k)
{
    const double r = fmax(ball->roughness, 0.045), a2 = r * r * r * r;
    double l[3], h[3], d2 = 0, nl = 0, nh = 0, vh = 0, length = 0;

    for (int j = 0; j < 3; j++) {
        l[j] =
            light->position[j] - ball->centre[j] - ball->radius * p->normal[j];
        d2 += l[j] * l[j];
    }
    for (int j = 0; j < 3; j++) {
        l[j] /= sqrt(d2);
        nl += l[j] * p->normal[j];
        h[j] = l[j] + p->view[j];
        length += h[j] * h[j];
    }
    for (int j = 0; j < 3; j++) {
        nh += h[j] * p->normal[j] / sqrt(length);
        vh += h[j] * p->view[j] / sqrt(length);
    }
    if (nl <= 0)
        return 0;
    const double tan2h = 1 / (nh * nh) - 1;
    const double d = 1 / (M_PI * a2 * pow(nh, 4) * pow(1 + tan2h / a2, 2));
    const double lambda_l = (sqrt(1 + a2 * (1 / (nl * nl) - 1)) - 1) / 2;
    const double lambda_v =
        (sqrt(1 + a2 * (1 / (p->n_v * p->n_v) - 1)) - 1) / 2;
    const double g = 1 / (1 + lambda_l + lambda_v);
    const double f = ball->f0[k] + (1 - ball->f0[k]) * pow(1 - vh, 5);
    return light->intensity[k] / d2 * d * g * f / (4 * p->n_v);
}

TEST(one_light)
{
    const float black[3] = {0, 0, 0};
    view_sphere balls[VIEW_MAX_GRID * VIEW_MAX_GRID];
    double worst = 0;

    shade_begin(128, 128);
    shade_constant(set, black);
    view_settings s = view_settings_default();
    s.material = shade_material("water"); /* nothing is diffuse */
    s.multiscatter = false;
    s.light_count = 2;
    s.light[0] = (view_light){{3, 2, 1}, {10, 5, 2}};
    s.light[1] = (view_light){{-6, 0, 0.5}, {3, 5, 20}};
    view_grid(&s, balls);
    float *picture = shade_draw(&set->set, &s);
    shade_pixel *pixels = shade_pixels(&s);
    for (int i = 0; i < 128 * 128; i++) {
        const shade_pixel *p = &pixels[i];
        if (p->sphere < 0 || p->n_v < 0.02)
            continue;
        for (int k = 0; k < 3; k++) {
            const double expected =
                light_at(&balls[p->sphere], p, &s.light[0], k) +
                light_at(&balls[p->sphere], p, &s.light[1], k);
            worst = fmax(worst, fabs(picture[3 * i + k] - expected) /
                                    (expected + 0.01));
        }
    }
    CHECK_MSG(worst < 2e-3, "off by %g", worst);
}

static double power_of(const float *rgb, const view_settings *s)
{
    const view_camera c = view_camera_of(s, 128, 128);
    const double area = 4 * test_dot(c.right, c.right) / (128.0 * 128);
    double sum = 0, ray[3];

    for (int i = 0; i < 128 * 128; i++) {
        view_camera_ray(&c, 128, 128, i % 128, i / 128, ray);
        sum += rgb[3 * i] * area * pow(test_dot(ray, c.forward), 3);
    }
    return sum;
}

/* A disc of the set, in a dark environment that is turned: as a point light
 * that is far away, and in the sky with its irradiance, unless a skybox has
 * it. */
TEST(discs_of_the_set)
{
    const float black[3] = {0, 0, 0};
    const double to[3] = {0.48, 0.64, 0.6}, far = 1e6;
    double worst = 0;

    shade_begin(128, 128);
    shade_constant(set, black);
    view_settings s = view_settings_default();
    s.roughness[0] = 0.3;
    s.turn = 33;
    s.sky = false;
    s.light_count = 1;
    for (int k = 0; k < 3; k++) {
        s.light[0].position[k] = far * to[k];
        s.light[0].intensity[k] = (k + 1) * far * far;
    }
    const float *point = shade_draw(&set->set, &s);
    s.light_count = 0;
    set->set.light_count = 1;
    set->set.light[0] = (ibl_light){.radius = 1e-4, .irradiance = {1, 2, 3}};
    view_turn(s.turn, to, set->set.light[0].direction);
    const float *disc = shade_draw(&set->set, &s);
    for (int i = 0; i < 3 * 128 * 128; i++)
        worst = fmax(worst, fabs(disc[i] - point[i]) / (point[i] + 0.01));
    CHECK_MSG(worst < 5e-3, "off by %g", worst);

    s.sky = true;
    s.yaw = atan2(-to[0], -to[2]) * 180 / acos(-1.0);
    s.pitch = -asin(to[1]) * 180 / acos(-1.0);
    s.distance = 1000;
    s.fov = 20;
    set->set.light[0].radius = 0.1;
    double power = power_of(shade_draw(&set->set, &s), &s);
    CHECK_NEAR(power, 1, 0.02);
    set->set.texture[VIEW_SKY] = set->set.texture[VIEW_SPECULAR];
    power = power_of(shade_draw(&set->set, &s), &s);
    CHECK_NEAR(power, 0, 1e-3);
    set->set.texture[VIEW_SKY] = (ibl_texture){0};
}

/* Smooth mirrors, grazing views, lights in and on spheres: all finite. */
TEST(everything_is_finite)
{
    const float bright[3] = {65504, 0, 1e-7f};

    shade_begin(128, 128);
    shade_constant(set, bright);
    view_settings s = view_settings_default();
    s.light_count = VIEW_MAX_LIGHTS;
    set->set.light_count = 4;
    for (int i = 0; i < 4; i++)
        set->set.light[i] = (ibl_light){.direction = {0.6 * (i / 2), 0.8, 0},
                                        .radius = i % 2 ? 0.0047 : 0.1,
                                        .irradiance = {1, 1e5, 3}};
    set->set.light[0].direction[2] = -0.6;
    set->set.light[1].direction[2] = 0.6;
    for (int i = 0; i < 2; i++) {
        s.multiscatter = i;
        s.yaw = 80 * i;
        s.light[0] = (view_light){{0, 0, 0.45}, {1, 1, 1}};
        s.light[1] = (view_light){{1, 0, 0}, {1e6, 1, 0}};
        s.light[2] = (view_light){{0, 1e6, 0}, {1e12, 1e12, 1e12}};
        float *picture = shade_draw(&set->set, &s);
        int wrong = 0;
        for (int k = 0; k < 3 * 128 * 128; k++)
            wrong += !(picture[k] >= 0) || isinf(picture[k]);
        CHECK_MSG(!wrong, "%d values", wrong);
    }
}
