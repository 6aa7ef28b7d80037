/* SPDX-License-Identifier: MIT */
/* The split sum: energy, every pixel against the same in double, pixel formats,
 * lights that are no part of the maps. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "maps.h"
#include "shade.h"
#include "textures.h"

enum {
    EDGE = 128, /* of pictures */
    FLOATS = 3 * EDGE * EDGE
};

static shade_set *const set = &shade_sets[0], *const other = &shade_sets[1];
static const float black[3] = {0, 0, 0}, white[3] = {1, 1, 1};

static view_settings one_sphere(const char *material, double roughness)
{
    view_settings s = view_settings_default();

    s.rows = s.columns = 1;
    s.metallic[0] = 1;
    s.roughness[0] = roughness;
    s.material = shade_material(material);
    s.multiscatter = false;
    return s;
}

/* Metals and dielectrics reflect or scatter no more than there is, and a white
 * one all of it; light of another colour is a factor. Edges, too. */
TEST(coloured_furnace)
{
    const float rgb[3] = {0.25f, 1.5f, 30};

    shade_begin(EDGE, EDGE);
    shade_constant(set, rgb);
    view_settings s = view_settings_default();
    s.rows = 2; /* what is between plastic and metal absorbs */
    s.material = shade_material("white");
    for (int i = 0; i < 3; i++) {
        double worst = 0;
        s.diffuse = (view_diffuse)(i % 2);
        s.yaw = s.turn = 35 * i;
        s.pitch = 15 * i;
        const float *picture = shade_draw(&set->set, &s);
        for (int k = 0; k < FLOATS; k++)
            worst = fmax(worst, fabs(picture[k] / (double)rgb[k % 3] - 1));
        CHECK_MSG(worst <= 1e-5, "off by %g", worst);
    }
}

/* ---- every pixel ------------------------------------------------------- */

static void bake(ibl_roughness_map mapping, int size)
{
    ibl_specular_options opts = ibl_specular_options_default();
    test_random r = {5};
    const ibl_image map = map_of_kind(shade_ctx(), &r, MAP_SMOOTH, 128, 64);

    opts.size = size;
    opts.mapping = mapping;
    shade_bake(set, &map, &opts);
}

/* What add_lobes says that a lobe sees, of irradiance by one tap. */
static void see_lobe(const view_settings *s, const shade_pixel *p, int taps,
                     shade_light *light)
{
    double d[3], env[3], rgb[3], sum[3] = {0};

    for (int tap = 0; tap < 4; tap++) {
        for (int k = 0; k < 3; k++)
            d[k] = p->reflected[k] +
                   (0.5 + tap / 6.0) * (p->normal[k] - p->reflected[k]);
        view_turn(s->turn, d, env);
        shade_cube(&set->specular, 0, env, rgb);
        for (int k = 0; k < 3; k++)
            sum[k] += rgb[k] / 4;
    }
    for (int k = 0; k < 3; k++)
        light->specular[k] = taps == 1 ? light->irradiance[k] : sum[k];
}

/* A side of the last picture against shade_split_sum, its sky against level 0.
 * taps: of lobes; 0: a plain split sum. */
static void compare(const view_settings *s, bool side, int taps)
{
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    float *picture = test_alloc(FLOATS, sizeof *picture);
    const shade_pixel *pixels = shade_pixels(s);
    double worst = 0, most = 0;
    int seen[2] = {0};

    NEED(view_renderer_read(shade_renderer(), side, picture));
    view_grid(s, spheres);
    for (int i = 0; i < EDGE * EDGE; i++) {
        const shade_pixel *p = &pixels[i];
        double env[3], rgb[3];
        shade_light light;
        if (p->sphere == -2 || (p->sphere >= 0 && p->n_v < 0.02))
            continue;
        if (p->sphere >= 0) {
            shade_look_up(set, s, &spheres[p->sphere], p, &light);
            if (taps)
                see_lobe(s, p, taps, &light);
            shade_split_sum(s, &spheres[p->sphere], &light, rgb);
        } else {
            const double ray[3] = {-p->view[0], -p->view[1], -p->view[2]};
            view_turn(s->turn, ray, env);
            shade_cube(&set->specular, 0, env, rgb);
        }
        seen[p->sphere >= 0]++;
        for (int k = 0; k < 3; k++) {
            most = fmax(most, rgb[k]);
            worst = fmax(worst, fabs(picture[3 * i + k] - rgb[k]));
        }
    }
    CHECK(seen[0] > 500 && seen[1] > 500);
    CHECK_MSG(worst <= 1e-4 * most, "off by %g of %g", worst, most);
}

/* Every second picture is of levels and irradiance that are scaled, and of
 * harmonics that are cut off at 0. */
TEST(pixels_in_double)
{
    shade_begin(EDGE, EDGE);
    for (int i = 0; i < 8; i++) {
        if (i % 2 == 0)
            bake(i % 4 ? IBL_ROUGHNESS_FILAMENT : IBL_ROUGHNESS_LINEAR, 32);
        view_settings s = view_settings_default();
        s.material = i;
        s.diffuse = (view_diffuse)(i / 2 % 2);
        s.multiscatter = i / 4;
        s.yaw = 50 * i;
        s.pitch = 8 * i - 30;
        s.turn = 33 * i;
        if (i % 2) {
            set->set.lod_scale *= 1.25;
            set->set.lod_offset = -0.3;
            set->set.irradiance_scale = 0.25;
            memset(set->set.sh, 0, 3 * sizeof *set->set.sh);
        }
        shade_draw(&set->set, &s);
        compare(&s, false, 0);
    }
}

/* A table of lobes for which one tap is irradiance, and four are of level 0,
 * from half way to the normal to there. */
static void add_lobes(void)
{
    const float texels[2][4] = {{0, 0, 1, 0}, {0.75F, 0, 0, 0.25F}};
    ibl_texture *t = &set->set.texture[VIEW_LOBES];

    *t = texture_random(shade_ctx(), IBL_PIXEL_RGBA32F, (int[]){4, 4, 1, 1}, 4);
    for (size_t i = 0; i < t->bytes / sizeof *texels; i++)
        memcpy(t->data + i * sizeof *texels, texels[i / 32], sizeof *texels);
}

/* Each side of a comparison is what its reflection says. */
TEST(lobes_of_a_table)
{
    shade_begin(EDGE, EDGE);
    bake(IBL_ROUGHNESS_FILAMENT, 32);
    add_lobes();
    view_settings s = view_settings_default();
    s.reflection = VIEW_TABLE_LOBES;
    s.against = VIEW_FOUR_TAPS;
    s.compare = VIEW_SPLIT;
    s.turn = 20;
    shade_draw(&set->set, &s);
    compare(&s, false, 1);
    compare(&s, true, 4);
}

/* To half a step of theirs: relative to the pixel for floats, to the
 * largest component for RGB9E5, of whatever is brightest here. Blocks to some
 * percent. */
TEST(near_in_all_formats)
{
    static const double step[IBL_PIXEL_COUNT] = {
        [IBL_PIXEL_RGBA16F] = 0x1p-11, [IBL_PIXEL_RGBA32F] = 0,
        [IBL_PIXEL_RGB9E5] = 0x1p-9,   [IBL_PIXEL_R11G11B10F] = 0x1p-6,
        [IBL_PIXEL_BC6H] = 0.1,        [IBL_PIXEL_UASTC_HDR] = 0.1,
        [IBL_PIXEL_ASTC4X4HDR] = 0.1,  [IBL_PIXEL_RG16F] = 2 * 0x1p-11,
        [IBL_PIXEL_RG32F] = 0};
    const view_settings s = view_settings_default();

    shade_begin(EDGE, EDGE);
    bake(IBL_ROUGHNESS_FILAMENT, 64);
    const float *exact = shade_draw(&set->set, &s);
    for (int i = 0; i < IBL_PIXEL_COUNT; i++) {
        const bool lut = ibl_pixel_channels((ibl_pixel)i) == 2;
        double off = 0, most = 0;
        shade_pack(set, lut ? IBL_PIXEL_RGBA32F : (ibl_pixel)i,
                   lut ? (ibl_pixel)i : IBL_PIXEL_RG32F);
        const float *picture = shade_draw(&set->set, &s);
        for (int k = 0; k < FLOATS; k++) {
            off = fmax(off, fabs((double)picture[k] - exact[k]));
            most = fmax(most, exact[k]);
        }
        CHECK_MSG(off <= step[i] * most && (off > 0 || step[i] == 0),
                  "%s: off by %g", ibl_pixel_name((ibl_pixel)i), off / most);
    }
}

/* A sky of its own is shown in place of level 0, and only behind. Small levels
 * of it stand for many texels in a pixel; of a specular chain they do not. */
TEST(sky_of_its_own)
{
    const float red[3] = {4, 0, 0};

    shade_begin(16, 16);
    shade_constant(set, white);
    shade_constant(other, red);
    ibl_texture *sky = &set->set.texture[VIEW_SKY];
    *sky = other->set.texture[VIEW_SPECULAR];
    view_settings s = one_sphere("white", 0);
    const float *rgb = shade_draw(&set->set, &s);
    CHECK(rgb[0] == 4 && rgb[1] == 0);
    for (int k = 0; k < 2; k++)
        CHECK_NEAR(rgb[3 * (8 * 16 + 8) + k], 1, 1e-3);

    ibl_cube *cube = &other->specular;
    for (int level = 1; level < cube->levels; level++)
        for (int i = 0; i < 18 * 1024 >> 2 * level; i++)
            ibl_cube_face(cube, level, 0)[i] = (float)(4 + level);
    shade_pack(other, IBL_PIXEL_RGBA32F, IBL_PIXEL_RG32F);
    s.distance = 900;
    s.fov = 120;
    /* In the middle a pixel is 2 tan(60) / 16 = 0.22 wide, a texel of 32 in a
     * face 0.0625: 3.5 of them, nearer to level 2 than to level 1. */
    *sky = other->set.texture[VIEW_SPECULAR];
    CHECK(fabs(shade_draw(&set->set, &s)[3 * (16 * 8 + 4)] - 6.0) < 1);
    *sky = (ibl_texture){0};
    CHECK(shade_draw(&other->set, &s)[3 * (16 * 8 + 4)] == 4);
}

/* An eye in a sphere sees through it; nothing is ever not a number. */
TEST(from_within)
{
    shade_begin(64, 48);
    shade_constant(set, white);
    view_settings s = one_sphere("gold", 0.5);
    for (int i = 0; i < 3; i++) {
        s.distance = i < 2 ? 0.1 + 0.349 * i : 0.4501;
        float *picture = shade_draw(&set->set, &s);
        for (int k = 0; k < 3 * 64 * 48; k++)
            CHECK(i < 2 ? picture[k] == 1 : picture[k] > 0 && picture[k] <= 1);
    }
}

/* ---- lights ------------------------------------------------------------- */

/* Distance, back sides, all roughnesses, metals and others. */
TEST(two_lights)
{
    view_sphere balls[VIEW_MAX_GRID * VIEW_MAX_GRID];
    double worst = 0;

    shade_begin(EDGE, EDGE);
    shade_constant(set, black);
    view_settings s = view_settings_default();
    s.light_count = 2;
    s.light[0] = (view_light){{3, 2, 1}, {10, 5, 2}};
    s.light[1] = (view_light){{-6, 0, 0.5}, {3, 5, 20}};
    view_grid(&s, balls);
    const float *picture = shade_draw(&set->set, &s);
    const shade_pixel *pixels = shade_pixels(&s);
    for (int at = 0; at < EDGE * EDGE; at++) {
        const shade_pixel *p = &pixels[at];
        const view_sphere *ball = &balls[p->sphere < 0 ? 0 : p->sphere];
        shade_light light = {.specular = {0}};
        double direct[3] = {0}, rgb[3];
        if (p->sphere < 0 || p->n_v < 0.02)
            continue;
        for (int i = 0; i < 2; i++) {
            double l[3];
            for (int k = 0; k < 3; k++)
                l[k] = s.light[i].position[k] - ball->centre[k] -
                       ball->radius * p->normal[k];
            const double d2 = test_dot(l, l);
            for (int k = 0; k < 3; k++)
                l[k] /= sqrt(d2);
            const double n_l = fmax(test_dot(p->normal, l), 0);
            const double alpha = pow(fmax(ball->roughness, 0.045), 2);
            for (int k = 0; k < 3; k++) {
                const double e = s.light[i].intensity[k] / d2;
                direct[k] +=
                    e * ibl_disc_brdf(IBL_GEOMETRY_SMITH, alpha, ball->f0[k], 0,
                                      p->normal, p->view, l);
                light.irradiance[k] += e * n_l / M_PI;
            }
        }
        ibl_lookup_lut(&set->lut, p->n_v, ball->roughness, light.table);
        shade_split_sum(&s, ball, &light, rgb);
        for (int k = 0; k < 3; k++)
            worst = fmax(worst, fabs(picture[3 * at + k] - rgb[k] - direct[k]) /
                                    (rgb[k] + direct[k] + 0.01));
    }
    CHECK_MSG(worst < 2e-3, "off by %g", worst);
}

static double power_of(const float *rgb, const view_settings *s)
{
    const view_camera c = view_camera_of(s, EDGE, EDGE);
    const double area = 4 * test_dot(c.right, c.right) / ((double)EDGE * EDGE);
    double sum = 0, ray[3];

    for (int i = 0; i < EDGE * EDGE; i++) {
        view_camera_ray(&c, EDGE, EDGE, i % EDGE, i / EDGE, ray);
        sum += rgb[3 * i] * area * pow(test_dot(ray, c.forward), 3);
    }
    return sum;
}

/* A disc of the set, in a dark environment that is turned: as a point light
 * that is far away, and in the sky with its irradiance, unless a skybox has
 * it. */
TEST(discs_of_the_set)
{
    const double to[3] = {0.48, 0.64, 0.6}, far = 1e6;
    double worst = 0;

    shade_begin(EDGE, EDGE);
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
    for (int i = 0; i < FLOATS; i++)
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

    shade_begin(EDGE, EDGE);
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
        for (int k = 0; k < FLOATS; k++)
            wrong += !(picture[k] >= 0) || isinf(picture[k]);
        CHECK_MSG(!wrong, "%d values", wrong);
    }
}
