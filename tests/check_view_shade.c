/* SPDX-License-Identifier: MIT */
/* Spheres: every pixel of a table of states against the same in double, what is
 * behind them, energy, pixel formats, edges and places in pixels. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "float_exr.h"
#include "maps.h"
#include "shade.h"
#include "textures.h"
#include "view.h"
#include "view/vector.h"

enum {
    EDGE = 128, /* of pictures */
    FLOATS = 3 * EDGE * EDGE
};

static shade_set *const set = &shade_sets[0], *const other = &shade_sets[1];

/* Metals and dielectrics reflect or scatter no more than there is, and a white
 * one all of it; light of another colour is a factor. Edges, too. */
TEST(coloured_furnace)
{
    const float rgb[3] = {0.25f, 1.5f, 30};
    view_settings s = view_settings_default();

    shade_begin(EDGE, EDGE);
    shade_constant(set, rgb);
    s.rows = 2; /* what is between plastic and metal absorbs */
    s.material = shade_material("white");
    for (int i = 0; i < 3; i++) {
        s.diffuse = (view_diffuse)i;
        s.yaw = s.turn = 35 * i;
        s.pitch = 15 * i;
        const float *picture = shade_draw(&set->set, &s);
        for (int k = 0; k < FLOATS; k++)
            CHECK_NEAR(picture[k] / (double)rgb[k % 3], 1, 1e-5);
    }
}

/* ---- every pixel ------------------------------------------------------- */

typedef struct state {
    const char *what;
    view_parts parts;
    view_diffuse diffuse;
    int taps;    /* of add_lobes; 0: split sum */
    bool scaled; /* levels and irradiance, and harmonics cut off at 0 */
    bool single, rough_fresnel;
    bool bare; /* no harmonics */
    bool lit;  /* by two lights and a disc */
    bool map;  /* at hand */
    bool own_sky;
    view_background background;
    double step;     /* of the pixel format; 0: floats */
    ibl_pixel pixel; /* of cubes, or of the table */
} state;

/* Radiance of the map: harmonics of degree 1. */
static double light(const double d[3], int k)
{
    return 2 + 0.5 * d[k] + 0.25 * d[(k + 1) % 3];
}

static void save_map(const char *path)
{
    enum {
        COLUMNS = 256
    };
    const ibl_image map = map_constant(shade_ctx(), COLUMNS, COLUMNS / 2, 0);

    for (int i = 0; i < COLUMNS * COLUMNS / 2; i++) {
        const double phi = 2 * M_PI * ((i % COLUMNS + 0.5) / COLUMNS - 0.5);
        const double theta = 2 * M_PI * (i / COLUMNS + 0.5) / COLUMNS;
        const double d[3] = {sin(theta) * cos(phi), cos(theta),
                             sin(theta) * sin(phi)};
        for (int k = 0; k < 3; k++)
            map.data[3 * i + k] = (float)light(d, k);
    }
    NEED(file_save_exr(path, &map, NULL));
}

/* A table of lobes for which one tap is irradiance, and four are of level 0,
 * from half way to the normal to there. */
static void add_lobes(baked_set *to)
{
    const float texels[2][4] = {{0, 0, 1, 0}, {0.75F, 0, 0, 0.25F}};
    ibl_texture *t = &to->baked.file[IBL_CONTENT_LOBE_TABLE].texture;

    *t = texture_random(shade_ctx(), IBL_PIXEL_RGBA32F, (int[]){4, 4, 1, 1}, 4);
    for (size_t i = 0; i < t->bytes / sizeof *texels; i++)
        memcpy(t->data + i * sizeof *texels, texels[i / 32], sizeof *texels);
}

/* Adds lights to what is reflected and to irradiance / pi. */
static void add_lights(const view_settings *s, const shade_set *by,
                       const view_sphere *ball, const shade_pixel *p,
                       double specular[3], double diffuse[3])
{
    for (int i = 0; i < s->light_count + by->set.baked.light_count; i++) {
        const bool disc = i >= s->light_count;
        const ibl_light *sun =
            &by->set.baked.light[disc ? i - s->light_count : 0];
        double l[3], d2 = 1;
        if (disc)
            view_turn(-s->turn, sun->direction, l);
        else {
            for (int k = 0; k < 3; k++)
                l[k] = s->light[i].position[k] - ball->centre[k] -
                       ball->radius * p->normal[k];
            d2 = test_dot(l, l);
            normalise3(l);
        }
        const double n_l = test_dot(p->normal, l);
        const double edge = disc ? sin(sun->radius) : 0;
        for (int k = 0; k < 3; k++) {
            const double e =
                disc ? sun->irradiance[k] : s->light[i].intensity[k] / d2;
            const double r =
                disc ? ball->roughness : fmax(ball->roughness, 0.045);
            specular[k] +=
                e * ibl_disc_brdf(IBL_GEOMETRY_SMITH, r * r, ball->f0[k],
                                  disc ? sun->radius : 0, p->normal, p->view,
                                  l);
            /* A part of a disc may be below. */
            diffuse[k] += e / M_PI *
                          (fabs(n_l) < edge ? pow(n_l + edge, 2) / (4 * edge)
                                            : fmax(n_l, 0));
        }
    }
}

/* What the pixel of a sphere is. */
static void seen(const state *is, const view_settings *s, const shade_set *by,
                 const view_sphere *ball, const shade_pixel *p, double rgb[3])
{
    static const shade_lobe lobes[] = {
        {.diffuse = 1, .taps = 1},
        {.bend = 0.75, .half_distance = 0.25, .taps = 4}};
    double n[3], v[3], direct[3] = {0}, diffuse[3] = {0};
    shade_light light;

    shade_look_up(by, s, ball, p, &light);
    view_turn(s->turn, p->normal, n);
    view_turn(s->turn, p->view, v);
    if (is->taps)
        shade_see(&by->specular, &lobes[is->taps > 1], n, v, light.irradiance,
                  light.specular);
    add_lights(s, by, ball, p, direct, diffuse);
    for (int k = 0; k < 3; k++) {
        const bool maps =
            s->parts != VIEW_PARTS_AMBIENT && s->parts != VIEW_PARTS_DIRECT;
        light.specular[k] *= maps && s->parts != VIEW_PARTS_DIFFUSE;
        light.irradiance[k] = light.irradiance[k] * maps + diffuse[k];
        light.irradiance[k] *= s->parts != VIEW_PARTS_SPECULAR;
    }
    shade_split_sum(s, ball, &light, rgb);
    for (int k = 0; k < 3; k++)
        rgb[k] += (s->parts != VIEW_PARTS_DIFFUSE) * direct[k] +
                  (s->parts == VIEW_PARTS_AMBIENT
                       ? cube_mean(&by->specular, 0, k) *
                             (ball->albedo[k] + ball->metallic * ball->f0[k])
                       : 0);
}

/* What a pixel without a sphere is. */
static void behind(const view_settings *s, const shade_set *by,
                   const shade_pixel *p, double rgb[3])
{
    const double ray[3] = {-p->view[0], -p->view[1], -p->view[2]};
    const ibl_cube *cube = by->set.own_sky ? &other->specular : &by->specular;
    double d[3], in_map[3];

    view_turn(s->turn, ray, d);
    view_turn(by->set.baked.yaw_deg, d, in_map);
    ibl_lookup_chain(
        cube, d,
        s->background == VIEW_BACKGROUND_BLUR ? shade_level(&by->set, s->blur)
        : s->background == VIEW_BACKGROUND_LEVEL ? s->background_level
                                                 : 0,
        rgb);
    for (int k = 0; k < 3; k++)
        rgb[k] = s->background == VIEW_BACKGROUND_COLOUR
                     ? s->background_colour[k]
                 : s->background == VIEW_BACKGROUND_TRANSPARENT ? 0
                 : s->background == VIEW_BACKGROUND_MAP &&
                         by->set.baked.source && !by->set.own_sky
                     ? light(in_map, k)
                     : rgb[k];
    for (int i = 0; i < by->set.baked.light_count; i++) {
        const ibl_light *sun = &by->set.baked.light[i];
        const double s2 = pow(sin(sun->radius / 2), 2);
        for (int k = 0; k < 3 && test_dot(sun->direction, d) > 1 - 2 * s2; k++)
            rgb[k] += sun->irradiance[k] / (4 * M_PI * s2);
    }
}

/* The worst error of a picture, of what is larger than a percent. */
static double compare(const state *is, const view_settings *s,
                      const shade_set *by, const float *picture)
{
    view_sphere balls[VIEW_MAX_GRID * VIEW_MAX_GRID];
    const shade_pixel *pixels = shade_pixels(s);
    double worst = 0;
    int counts[2] = {0};

    view_grid(s, balls);
    for (int i = 0; i < EDGE * EDGE; i += is->lit || is->bare ? 41 : 3) {
        const shade_pixel *p = &pixels[i];
        double rgb[3];
        if (p->sphere == -2 || (p->sphere >= 0 && p->n_v < 0.02))
            continue;
        if (p->sphere >= 0)
            seen(is, s, by, &balls[p->sphere], p, rgb);
        else
            behind(s, by, p, rgb);
        counts[p->sphere >= 0]++;
        for (int k = 0; k < 3; k++)
            worst = fmax(worst,
                         fabs(picture[3 * i + k] - rgb[k]) / (rgb[k] + 0.01));
    }
    CHECK(counts[0] > 20 && counts[1] > 20);
    return worst;
}

static void use(const state *is, view_settings *s, baked_set *to)
{
    s->parts = is->parts;
    s->diffuse = is->diffuse;
    s->reflection = !is->taps       ? VIEW_SPLIT_SUM
                    : is->taps == 1 ? VIEW_TABLE_LOBES
                                    : VIEW_FOUR_TAPS;
    s->multiscatter = !is->single;
    s->rough_fresnel = is->rough_fresnel;
    s->background = is->background;
    s->background_level = 2;
    s->background_colour[1] = 0.5;
    if (is->taps)
        add_lobes(to);
    if (is->scaled) {
        to->baked.file[IBL_CONTENT_SPECULAR].facts.lod_scale *= 1.25;
        to->baked.file[IBL_CONTENT_SPECULAR].facts.lod_offset = -0.3;
        to->baked.file[IBL_CONTENT_IRRADIANCE].facts.irradiance_scale = 0.25;
        memset(to->sh, 0, 3 * sizeof *to->sh);
    }
    if (is->bare)
        to->sh_degree = -1;
    if (is->map) {
        to->baked.source = strdup(file_path("map.exr"));
        to->baked.read = ibl_read_options_default();
        to->baked.yaw_deg = 130;
    }
    if (is->own_sky) {
        to->own_sky = true;
        to->baked.file[IBL_CONTENT_SKYBOX].texture =
            other->set.baked.file[IBL_CONTENT_SPECULAR].texture;
    }
    if (is->lit) {
        s->roughness[0] = 0.3;
        s->light_count = 2;
        s->light[0] = (view_light){{3, 2, 1}, {10, 5, 2}};
        s->light[1] = (view_light){{-6, 0, 0.5}, {3, 5, 20}};
        to->baked.light_count = 2; /* the second is in the sky's upper left */
        to->baked.light[0] = (ibl_light){.direction = {0.48, -0.64, 0.6},
                                         .radius = 0.05,
                                         .irradiance = {1, 2, 3}};
        to->baked.light[1] =
            (ibl_light){.radius = 0.1, .irradiance = {3, 1, 2}};
        const view_camera c = view_camera_of(s, EDGE, EDGE);
        double ray[3];
        view_test_ray(&c, EDGE, EDGE, 12, 12, ray);
        view_turn(s->turn, ray, to->baked.light[1].direction);
    }
}

TEST(pixels_in_double)
{
    static const state states[] = {
        {.what = "split sum"},
        {.what = "single scattering", .single = true},
        {.what = "harmonics", .diffuse = VIEW_DIFFUSE_SH},
        {.what = "the last level", .diffuse = VIEW_DIFFUSE_LAST},
        {.what = "what the engine takes", .diffuse = VIEW_DIFFUSE_AUTO},
        {.what = "scaled", .scaled = true},
        {.what = "cut off", .scaled = true, .diffuse = VIEW_DIFFUSE_SH},
        {.what = "one tap", .taps = 1},
        {.what = "four taps", .taps = 4},
        {.what = "the tutorials' Fresnel", .rough_fresnel = true},
        {.what = "lights", .lit = true},
        {.what = "ambient", .parts = VIEW_PARTS_AMBIENT, .lit = true},
        {.what = "of the map", .parts = VIEW_PARTS_AMBIENT, .bare = true},
        {.what = "direct", .parts = VIEW_PARTS_DIRECT, .lit = true},
        {.what = "diffuse", .parts = VIEW_PARTS_DIFFUSE, .lit = true},
        {.what = "specular",
         .parts = VIEW_PARTS_SPECULAR,
         .lit = true,
         .taps = 1},
        {.what = "blur", .background = VIEW_BACKGROUND_BLUR},
        {.what = "level", .background = VIEW_BACKGROUND_LEVEL},
        {.what = "colour", .background = VIEW_BACKGROUND_COLOUR},
        {.what = "nothing", .background = VIEW_BACKGROUND_TRANSPARENT},
        {.what = "map", .map = true},
        {.what = "blurred map",
         .map = true,
         .background = VIEW_BACKGROUND_BLUR},
        {.what = "skybox", .map = true, .own_sky = true},
        {.what = "rgba16f", .pixel = IBL_PIXEL_RGBA16F, .step = 0x1p-11},
        {.what = "rgb9e5", .pixel = IBL_PIXEL_RGB9E5, .step = 0x1p-7},
        {.what = "r11g11b10f", .pixel = IBL_PIXEL_R11G11B10F, .step = 0x1p-6},
        {.what = "bc6h", .pixel = IBL_PIXEL_BC6H, .step = 0.3},
        {.what = "uastc-hdr", .pixel = IBL_PIXEL_UASTC_HDR, .step = 0.3},
        {.what = "astc", .pixel = IBL_PIXEL_ASTC4X4HDR, .step = 0.3},
        {.what = "rg16f", .pixel = IBL_PIXEL_RG16F, .step = 0x1p-10},
    };

    shade_begin(EDGE, EDGE);
    save_map(file_path("map.exr"));
    shade_kind(other, IBL_ROUGHNESS_LINEAR, MAP_SMOOTH);
    shade_kind(set, IBL_ROUGHNESS_FILAMENT, MAP_SMOOTH);
    for (int i = 0; i < (int)(sizeof states / sizeof *states); i++) {
        const state *is = &states[i];
        shade_set *from = i % 2 && !is->own_sky ? other : set;
        const bool table = ibl_pixel_channels(is->pixel) == 2;
        if (is->step > 0)
            shade_pack(from, table ? IBL_PIXEL_RGBA32F : is->pixel,
                       table ? is->pixel : IBL_PIXEL_RG32F);
        shade_set by = *from;
        view_settings s = view_settings_default();
        s.material = i % VIEW_MATERIALS;
        s.yaw = 50 * i;
        s.pitch = 8 * (i % 8) - 30;
        s.turn = 33 * i;
        by.set.diffuse = VIEW_DIFFUSE_SH;
        use(is, &s, &by.set);
        const float *picture = shade_draw(&by.set, &s);
        if (s.diffuse == VIEW_DIFFUSE_AUTO)
            s.diffuse = VIEW_DIFFUSE_SH;
        const double off = compare(is, &s, &by, picture);
        const double exact = is->lit ? 5e-3 : is->map ? 2e-3 : 1e-3;
        CHECK_MSG(off < fmax(exact, is->step) && off > is->step / 100,
                  "%s: off by %g", is->what, off);
        ibl_texture_free(&by.set.baked.file[IBL_CONTENT_LOBE_TABLE].texture);
        ibl_image_free(&by.set.map);
        free(by.set.baked.source);
    }
}

/* ---- limits ---------------------------------------------------------------
 */

/* Smooth mirrors, grazing views, lights in and on spheres, an eye within: all
 * finite. */
TEST(everything_is_finite)
{
    view_settings s = view_settings_default();

    shade_begin(EDGE, EDGE);
    shade_constant(set, (const float[]){65504, 0, 1e-7f});
    set->set.baked.light_count = s.light_count = 3;
    for (int i = 0; i < 3; i++) {
        set->set.baked.light[i] =
            (ibl_light){.direction = {0.6 * (i - 1), 0.8, 0},
                        .radius = i % 2 ? 0.0047 : 0.1,
                        .irradiance = {1, 1e5, 3}};
        s.light[i] = (view_light){{i == 1, i == 2 ? 1e6 : 0, i ? 0 : 0.45},
                                  {1e12, 1, 0}};
    }
    for (int i = 0; i < 4; i++) {
        s.rough_fresnel = i == 3;
        s.yaw = 80 * i;
        s.distance = 0.3 * i;
        const float *picture = shade_draw(&set->set, &s);
        for (int k = 0; k < FLOATS; k++)
            CHECK(picture[k] >= 0 && !isinf(picture[k]));
    }
}

/* ---- edges ----------------------------------------------------- */

enum {
    WIDTH = 48,
    HEIGHT = 40
};

/* White spheres on nothing, some before others: a pixel is the part of it that
 * they cover, by 32 x 32 rays, but for where outlines cross; so is its alpha.
 */
TEST(edges_by_area)
{
    enum {
        N = 32
    };
    static float alpha[WIDTH * HEIGHT];
    static const double most[] = {0, 0.16, 0.1, 0.05, 0.04};

    shade_begin(WIDTH, HEIGHT);
    shade_constant(set, (const float[]){0.5F, 0.5F, 0.5F});
    for (int n = 1; n <= 4; n++) {
        view_settings s = view_settings_default();
        view_sphere balls[VIEW_MAX_GRID * VIEW_MAX_GRID];
        double sum = 0, all = 0, worst = 0;
        s.antialias = n;
        s.metallic[0] = 1;
        s.material = shade_material("white");
        s.background = VIEW_BACKGROUND_TRANSPARENT;
        s.rows = s.columns = 2;
        s.yaw = 25;
        s.pitch = -20;
        s.fov = 60;
        const view_camera c = view_camera_of(&s, WIDTH, HEIGHT);
        const int count = view_grid(&s, balls);
        const float *rgb = shade_draw(&set->set, &s);
        /* Of the texture that was read. */
        gl.GetTexImage(GL_TEXTURE_2D, 0, GL_ALPHA, GL_FLOAT, alpha);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            int hits = 0;
            for (int k = 0; k < N * N; k++) {
                double d[3];
                view_test_ray(&c, WIDTH, HEIGHT,
                              i % WIDTH + (k % N + 0.5) / N - 0.5,
                              i / WIDTH + (k / N + 0.5) / N - 0.5, d);
                hits += view_test_hit(balls, count, c.eye, d, NULL) >= 0;
            }
            const double part = hits / (double)(N * N);
            sum += rgb[3 * i] / 0.5;
            all += part;
            worst = fmax(worst, fabs(rgb[3 * i] / 0.5 - part));
            CHECK_NEAR(alpha[(HEIGHT - 1 - i / WIDTH) * WIDTH + i % WIDTH],
                       rgb[3 * i] / 0.5, 1e-5);
        }
        CHECK_MSG(worst < most[n], "%d: %g", n, worst);
        CHECK_NEAR(sum / all, 1, 2e-3);
    }
}
