/* SPDX-License-Identifier: MIT */
/* What a shader sees of the maps: mirrors, seams, levels, pixel formats,
 * containers, harmonics, turns; and what part of a pixel a sphere covers. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "maps.h"
#include "shade.h"
#include "view/message.h"

static shade_set *const set = &shade_sets[0], *const other = &shade_sets[1];
static const float white[3] = {1, 1, 1};

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

static double largest(const float *rgb, int count)
{
    double most = 0;

    for (int i = 0; i < count; i++)
        most = fmax(most, rgb[i]);
    return most;
}

static double difference(const float *a, const float *b)
{
    const int count = 3 * shade_width() * shade_height();
    double worst = 0;

    for (int i = 0; i < count; i++)
        worst = fmax(worst, fabs((double)a[i] - b[i]));
    return worst / largest(b, count);
}

/* ---- mirrors ----------------------------------------------------------- */

/* Level 0 noise, the rest far brighter: whatever reads there is seen. */
static void noise(void)
{
    const size_t count = 3 * ibl_cube_texels(set->specular.size, 1);
    const size_t all =
        3 * ibl_cube_texels(set->specular.size, set->specular.levels);
    test_random r = {11};

    for (size_t i = 0; i < all; i++)
        set->specular.data[i] =
            i < count ? (float)test_random_unit(&r) : 1000.0f;
    shade_pack(set, IBL_PIXEL_RGBA32F, IBL_PIXEL_RG32F);
}

/* Every pixel, of the sphere and of the sky, is a lookup in level 0. */
TEST(mirror)
{
    shade_begin(160, 120);
    shade_constant(set, white);
    noise();
    for (int view = 0; view < 6; view++) {
        view_settings s = one_sphere("white", 0);
        double worst = 0, level0 = 0;
        int seen = 0, sky = 0;
        view_sphere ball[VIEW_MAX_GRID * VIEW_MAX_GRID];
        s.distance = 1.5;
        s.fov = 50;
        s.yaw = 61 * view;
        s.pitch = 30 * view - 75;
        s.turn = 100 * view;
        view_grid(&s, ball);
        float *picture = shade_draw(&set->set, &s);
        shade_pixel *pixels = shade_pixels(&s);
        for (int i = 0; i < 160 * 120; i++) {
            const shade_pixel *p = &pixels[i];
            double d[3], rgb[3], factor = 1;
            if (p->sphere == -2 || (p->sphere == 0 && p->n_v < 0.02))
                continue;
            if (p->sphere == 0) {
                double rg[2];
                shade_table(&set->lut, p->n_v, 0, rg);
                factor = rg[0] + rg[1];
                CHECK_NEAR(factor, 1, 1e-3);
                view_turn(s.turn, p->reflected, d);
                seen++;
            } else {
                const double ray[3] = {-p->view[0], -p->view[1], -p->view[2]};
                view_turn(s.turn, ray, d);
                sky++;
            }
            shade_cube(&set->specular, 0, d, rgb);
            for (int k = 0; k < 3; k++) {
                const double e = fabs(picture[3 * i + k] - factor * rgb[k]);
                *(p->sphere == 0 ? &worst : &level0) =
                    fmax(e, p->sphere == 0 ? worst : level0);
            }
        }
        CHECK_MSG(worst < 5e-4, "sphere off by %g", worst);
        CHECK_MSG(level0 < 5e-4, "sky off by %g", level0);
        CHECK(seen > 2000 && sky > 2000);
    }
}

/* A sky of its own is shown in place of level 0, and only behind. */
TEST(sky_of_its_own)
{
    const float red[3] = {4, 0, 0};

    shade_begin(64, 64);
    shade_constant(set, white);
    shade_constant(other, red);
    set->set.texture[VIEW_SKY] = other->set.texture[VIEW_SPECULAR];
    const view_settings s = one_sphere("white", 0);
    float *picture = shade_draw(&set->set, &s);
    CHECK(picture[0] == 4 && picture[1] == 0);
    const float *middle = picture + 3 * (32 * 64 + 32);
    CHECK_NEAR(middle[0], 1, 1e-3);
    CHECK_NEAR(middle[1], 1, 1e-3);
    memset(&set->set.texture[VIEW_SKY], 0, sizeof(ibl_texture));
}

static double level_value(int level)
{
    return 1 + level * level;
}

/* Constant levels, red by level and green 1: red over green is the level. */
static void levels_of(void)
{
    float *at = set->specular.data;

    for (int level = 0; level < set->specular.levels; level++) {
        const int n = ibl_cube_edge(set->specular.size, level);
        for (int i = 0; i < 6 * n * n; i++, at += 3) {
            at[0] = (float)level_value(level);
            at[1] = at[2] = 1;
        }
    }
    shade_pack(set, IBL_PIXEL_RGBA32F, IBL_PIXEL_RG32F);
}

/* Of a sky of its own smaller levels stand for many texels in a pixel; of a
 * specular chain they do not, however small the picture. */
TEST(small_pictures_of_the_sky)
{
    shade_begin(16, 16);
    shade_constant(set, white);
    levels_of();
    view_settings s = one_sphere("white", 1);
    s.distance = 900;
    s.fov = 120;
    for (int own = 0; own < 2; own++) {
        if (own)
            NEED(!ibl_texture_from_cube(
                shade_ctx(), &set->specular,
                &(ibl_texel_options){.struct_size = sizeof(ibl_texel_options),
                                     .pixel = IBL_PIXEL_RGBA32F,
                                     .overflow = IBL_OVERFLOW_CLIP},
                &set->set.texture[VIEW_SKY], NULL));
        float *picture = shade_draw(&set->set, &s);
        /* In the middle a pixel is 2 tan(60) / 16 = 0.22 wide, a texel of 32
         * in a face 0.0625: 3.5 of them, nearer to level 2 than to level 1. */
        const float seen = picture[3 * (16 * 8 + 4)];
        if (own)
            CHECK_MSG(seen > level_value(1) && seen < level_value(3),
                      "shows %g", seen);
        else
            CHECK(seen == level_value(0));
    }
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

/* ---- seams ------------------------------------------------------------- */

static void smooth_colour(const double d[3], float rgb[3])
{
    rgb[0] = (float)(1 + 0.8 * d[0] + 0.3 * d[1] * d[2]);
    rgb[1] = (float)(1 + 0.8 * d[1] - 0.3 * d[0] * d[2]);
    rgb[2] = (float)(1 + 0.8 * d[2] + 0.3 * d[0] * d[1]);
}

static void fill_smooth(const ibl_cube *cube)
{
    for (int level = 0; level < cube->levels; level++) {
        const int n = ibl_cube_edge(cube->size, level);
        for (int i = 0; i < IBL_FACES * n * n; i++) {
            double d[3];
            ibl_cube_direction(n, i / (n * n), i % n, i / n % n, d);
            smooth_colour(d, ibl_cube_face(cube, level, i / (n * n)) +
                                 3 * (i % (n * n)));
        }
    }
}

/* Largest change from pixel to pixel by the angle that the reflection turns,
 * inside of faces and from face to face. */
static void steps(const view_settings *s, double most[2], int seen[2])
{
    const int w = shade_width(), h = shade_height();
    float *picture = shade_draw(&set->set, s);
    shade_pixel *pixels = shade_pixels(s);

    for (int i = 0; i < w * (h - 1); i++) {
        for (int down = 0; down < 2; down++) {
            const int j = down ? i + w : i + 1;
            const shade_pixel *p = &pixels[i], *q = &pixels[j];
            double cosine = 0, step = 0;
            if (p->sphere < 0 || p->sphere != q->sphere || p->n_v < 0.2 ||
                q->n_v < 0.2)
                continue;
            for (int k = 0; k < 3; k++) {
                cosine += p->reflected[k] * q->reflected[k];
                step =
                    fmax(step, fabs(picture[3 * i + k] - picture[3 * j + k]));
            }
            double at[2];
            const int cross = shade_face(p->reflected, &at[0], &at[1]) !=
                              shade_face(q->reflected, &at[0], &at[1]);
            step /= acos(fmin(cosine, 1));
            most[cross] = fmax(most[cross], step);
            seen[cross]++;
        }
    }
}

/* The camera sees each edge and each corner in the middle of a mirror and of
 * rough spheres: directions with two and three equal coordinates. */
TEST(seams)
{
    double most[2] = {0, 0};
    int seen[2] = {0, 0};

    shade_begin(96, 32);
    shade_constant(set, white);
    fill_smooth(&set->specular);
    shade_pack(set, IBL_PIXEL_RGBA32F, IBL_PIXEL_RG32F);
    view_settings s = one_sphere("white", 0);
    s.columns = 3;
    s.roughness[1] = 1;
    s.multiscatter = false;
    for (int i = 0; i < 27; i++) {
        const double d[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        if (fabs(d[0]) + fabs(d[1]) + fabs(d[2]) < 2)
            continue;
        s.yaw = atan2(d[0], d[2]) * 180 / acos(-1.0);
        s.pitch = fmin(
            fmax(atan2(d[1], hypot(d[0], d[2])) * 180 / acos(-1.0), -89), 89);
        steps(&s, most, seen);
    }
    CHECK(seen[0] > 10000 && seen[1] > 1000);
    CHECK_MSG(most[1] <= 1.02 * most[0], "%g across, %g inside", most[1],
              most[0]);
}

/* ---- levels ------------------------------------------------------------ */

static void check_levels(const double *roughness, int count)
{
    view_settings s = one_sphere("white", 0);

    for (int level = 0; level < count - 1; level++) {
        for (int part = 0; part <= 4; part++) {
            const double t = part / 4.0, a = roughness[level];
            const double b = roughness[level + 1];
            /* Equal parts of the mapping's variable. */
            const double x = set->set.mapping == IBL_ROUGHNESS_FILAMENT
                                 ? (1 - t) * a * (2 - a) + t * b * (2 - b)
                                 : (1 - t) * a + t * b;
            s.roughness[0] = set->set.mapping == IBL_ROUGHNESS_FILAMENT
                                 ? 1 - sqrt(1 - x)
                                 : x;
            float *picture = shade_draw(&set->set, &s);
            const float *px = picture + 3 * (16 * 32 + 16);
            CHECK_NEAR(px[0] / px[1],
                       (1 - t) * level_value(level) +
                           t * level_value(level + 1),
                       1e-3);
            if (level == 0 && part == 0 && a == 0)
                CHECK(px[0] == px[1]);
        }
    }
}

/* Whole chains, and the library's chains of a part of the range and beyond. */
TEST(levels)
{
    shade_begin(32, 32);
    shade_constant(set, white);
    levels_of();
    for (int i = 0; i < 4; i++) {
        const bool part = i / 2;
        ibl_specular_options opts = ibl_specular_options_default();
        ibl_specular_layout layout;
        opts.mapping = i % 2 ? IBL_ROUGHNESS_FILAMENT : IBL_ROUGHNESS_LINEAR;
        opts.levels = set->specular.levels;
        opts.roughness_min = part ? 0.3 : 0;
        opts.roughness_max = part ? 0.8 : 1;
        NEED(!ibl_specular_layout_of(&opts, &layout));
        set->set.mapping = opts.mapping;
        set->set.lod_scale = layout.lod_scale;
        set->set.lod_offset = layout.lod_offset;
        check_levels(layout.roughness, layout.levels);
        for (int end = 0; end < 2 && part; end++) {
            const view_settings s = one_sphere("white", end ? 0.95 : 0.1);
            const float *px = shade_draw(&set->set, &s) + 3 * (16 * 32 + 16);
            CHECK_NEAR(px[0] / px[1], level_value(end ? layout.levels - 1 : 0),
                       1e-4);
        }
    }
}

/* ---- formats ----------------------------------------------------------- */

static void bake(shade_set *s, double yaw)
{
    ibl_specular_options opts = ibl_specular_options_default();
    test_random r = {21};
    ibl_image map = map_of_kind(shade_ctx(), &r, MAP_SMOOTH, 128, 64);

    opts.size = 64;
    opts.yaw_deg = yaw;
    shade_bake(s, &map, &opts);
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

    shade_begin(96, 96);
    bake(set, 0);
    const view_settings s = view_settings_default();
    float *exact = shade_draw(&set->set, &s);
    for (int i = 0; i < IBL_PIXEL_COUNT; i++) {
        const bool lut = ibl_pixel_channels((ibl_pixel)i) == 2;
        shade_pack(set, lut ? IBL_PIXEL_RGBA32F : (ibl_pixel)i,
                   lut ? (ibl_pixel)i : IBL_PIXEL_RG32F);
        const double d = difference(shade_draw(&set->set, &s), exact);
        CHECK_MSG(d <= step[i] && (d > 0 || step[i] == 0), "%s: off by %g",
                  ibl_pixel_name((ibl_pixel)i), d);
    }
}

/* ---- turns ------------------------------------------------ */

TEST(turn_is_a_turned_bake)
{
    shade_begin(128, 128);
    bake(set, 0);
    bake(other, 90);
    view_settings s = view_settings_default();
    for (int i = 0; i < 2; i++) {
        s.diffuse = (view_diffuse)i;
        s.turn = 90;
        float *a = shade_draw(&set->set, &s);
        s.turn = 0;
        float *b = shade_draw(&other->set, &s);
        float *c = shade_draw(&set->set, &s);
        CHECK_MSG(difference(a, b) < 1e-3, "off by %g", difference(a, b));
        CHECK(difference(c, b) > 0.1);
    }
}

/* ---- coverage ----------------------------------------------------------- */

/* White spheres on black: a pixel is the part of it that they cover, by 16x16
 * rays; overlapping ones too, but for where outlines cross. */
TEST(coverage)
{
    view_sphere balls[VIEW_MAX_GRID * VIEW_MAX_GRID];
    const int n = 48, sub = 16;

    shade_begin(n, n);
    shade_constant(set, white);
    view_settings s = one_sphere("white", 0.5);
    s.rows = s.columns = 2;
    s.metallic[1] = 1;
    s.roughness[1] = 0.5;
    s.multiscatter = true;
    s.sky = false;
    s.yaw = 25;
    s.pitch = -20;
    s.fov = 60;
    const int count = view_grid(&s, balls);
    const view_camera c = view_camera_of(&s, n, n);
    float *picture = shade_draw(&set->set, &s);
    double total = 0, expected = 0, worst = 0;
    for (int i = 0; i < n * n; i++) {
        int hits = 0;
        for (int k = 0; k < sub * sub; k++) {
            double ray[3];
            view_camera_ray(&c, n, n, i % n + (k % sub + 0.5) / sub - 0.5,
                            i / n + (k / sub + 0.5) / sub - 0.5, ray);
            hits += view_grid_hit(balls, count, c.eye, ray, NULL) >= 0;
        }
        const double part = hits / (double)(sub * sub);
        total += picture[3 * i];
        expected += part;
        worst = fmax(worst, fabs(picture[3 * i] - part));
        if (part == 0 || part == 1)
            CHECK_NEAR(picture[3 * i], part, 0.03);
    }
    CHECK_MSG(worst < 0.12, "a pixel off by %g", worst);
    CHECK_NEAR(total / expected, 1, 2e-3);
}
