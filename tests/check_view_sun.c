/* SPDX-License-Identifier: MIT */
/* The sun: found in an environment whose sun is known, taken off it, and its
 * light and shadows in the room against rays that are cast to it. */
#include "maps.h"
#include "room.h"
#include "sets.h"
#include "truth.h"
#include "view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/baked_set.h"
#include "view/renderer.h"
#include "view/room_parts.h"
#include "view/upload.h"
#include "view/vector.h"

#define PI 3.14159265358979323846

/* What is left of a texel in a direction, unit, of the environment. */
static void cut_sun(const view_room_sun *sun, const double direction[3],
                    double rgb[3])
{
    const double y = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    const bool cut = view_room_sun_shines(sun) && y > sun->limit &&
                     test_dot(direction, sun->direction) >= sun->cosine;

    for (int k = 0; k < 3 && cut; k++)
        rgb[k] *= sun->limit / y;
}

/* ---- finding it ---------------------------------------------------------- */

/* Radiance of a direction (unit). */
typedef void radiance(const void *cookie, const double d[3], double rgb[3]);

/* Means over texels, of so many places each way in them, or but one where the
 * direction is not within a tenth of that. */
static ibl_texture cube_of(ibl_ctx *ctx, int size, int most, radiance *light,
                           const void *cookie, const double near_by[3])
{
    ibl_cube cube = {0};
    ibl_texture tex = {0};

    if (ibl_cube_alloc(ctx, size, 1, &cube))
        exit(1);
    for (int i = 0; i < IBL_FACES * size * size; i++) {
        const int face = i / (size * size), y = i / size % size, x = i % size;
        double sum[3] = {0}, whole = 0, d[3], rgb[3];
        ibl_cube_direction(size, face, x, y, d);
        const int fine = test_dot(d, near_by) > 0.98 ? most : 1;
        for (int j = 0; j < fine * fine; j++) {
            const int u = x * fine + j % fine, v = y * fine + j / fine;
            const double a = ibl_cube_solid_angle(size * fine, u, v);
            ibl_cube_direction(size * fine, face, u, v, d);
            light(cookie, d, rgb);
            for (int k = 0; k < 3; k++)
                sum[k] += a * rgb[k];
            whole += a;
        }
        for (int k = 0; k < 3; k++)
            cube.data[3 * i + k] = (float)(sum[k] / whole);
    }
    if (ibl_texture_from_cube(
            ctx, &cube,
            &(ibl_texel_options){.pixel = IBL_PIXEL_RGBA32F,
                                 .overflow = IBL_OVERFLOW_CLIP},
            &tex, NULL))
        exit(1);
    ibl_cube_free(&cube);
    return tex;
}

/* A disc on a gradient. */
typedef struct disc {
    double direction[3], radius_deg, radiance[3];
} disc;

static void disc_light(const void *cookie, const double d[3], double rgb[3])
{
    const disc *s = cookie;
    const bool in = test_dot(d, s->direction) > cos(s->radius_deg * PI / 180);

    for (int k = 0; k < 3; k++)
        rgb[k] = (in ? s->radiance[k] : 0) + 0.5 + 0.3 * d[1] + 0.05 * k;
}

/* Integrals of the whole and of what the sun leaves. */
static void integrate(const ibl_texture *tex, const view_room_sun *sun,
                      double whole[3], double left[3])
{
    const int n = tex->width;
    const float *texel = (const float *)(const void *)tex->data;

    memset(whole, 0, 3 * sizeof *whole);
    memset(left, 0, 3 * sizeof *left);
    for (int i = 0; i < IBL_FACES * n * n; i++, texel += 4) {
        const double a = ibl_cube_solid_angle(n, i % n, i / n % n);
        double d[3], rgb[3];
        ibl_cube_direction(n, i / (n * n), i % n, i / n % n, d);
        for (int k = 0; k < 3; k++) {
            rgb[k] = (double)texel[k];
            whole[k] += a * rgb[k];
        }
        cut_sun(sun, d, rgb);
        for (int k = 0; k < 3; k++)
            left[k] += a * rgb[k];
    }
}

/* Luminance, as a mean over what is more than 10 degrees away. */
static double mean_beside(const ibl_texture *tex, const double direction[3])
{
    const int n = tex->width;
    const float *texel = (const float *)(const void *)tex->data;
    double sum = 0, whole = 0;

    for (int i = 0; i < IBL_FACES * n * n; i++, texel += 4) {
        const double a = ibl_cube_solid_angle(n, i % n, i / n % n);
        double d[3];
        ibl_cube_direction(n, i / (n * n), i % n, i / n % n, d);
        if (test_dot(d, direction) > cos(10 * PI / 180))
            continue;
        sum += a * (0.2126 * (double)texel[0] + 0.7152 * (double)texel[1] +
                    0.0722 * (double)texel[2]);
        whole += a;
    }
    return sum / whole;
}

static void check_disc(ibl_ctx *ctx, int size, disc s)
{
    view_room_sun sun;
    double whole[3], left[3];

    normalise3(s.direction);
    ibl_texture tex = cube_of(ctx, size, 48, disc_light, &s, s.direction);
    NEED(view_room_sun_find(&tex, &sun));
    NEED(view_room_sun_shines(&sun));
    const double apart =
        acos(fmin(test_dot(sun.direction, s.direction), 1)) * 180 / PI;
    CHECK_MSG(apart < 45.0 / size, "%g degrees, %d texels", apart, size);
    const double angle = 2 * PI * (1 - cos(s.radius_deg * PI / 180));
    for (int k = 0; k < 3; k++)
        CHECK_NEAR(sun.irradiance[k] / (s.radiance[k] * angle), 1, 0.01);
    /* What is left is 8 times the mean outside of the cone of 10 degrees. */
    CHECK_NEAR(sun.cosine, cos(10 * PI / 180), 1e-12);
    CHECK_NEAR(sun.limit, 8 * mean_beside(&tex, s.direction), 0.05);
    /* Nothing is taken from what is beside the cone. */
    const double *z = sun.direction;
    const double c = cos(12 * PI / 180), r = sin(12 * PI / 180);
    const double flat = hypot(z[0], z[2]);
    const double beside[3] = {c * z[0] + r * z[2] / flat, c * z[1],
                              c * z[2] - r * z[0] / flat};
    double rgb[3] = {9e9, 9e9, 9e9};
    cut_sun(&sun, beside, rgb);
    CHECK_NEAR(rgb[0], 9e9, 0);
    integrate(&tex, &sun, whole, left);
    for (int k = 0; k < 3; k++)
        CHECK_NEAR((left[k] + sun.irradiance[k]) / whole[k], 1, 1e-12);
    ibl_texture_free(&tex);
}

/* In the middle of a face, off it, on an edge, in a corner, at a pole. */
TEST(finds_known_sun)
{
    static const double directions[][3] = {
        {1, 0, 0}, {-0.3, 0.7, 0.5}, {1, 0.4, -1}, {-1, 1, 1}, {0.001, 1, 0}};
    ibl_ctx *ctx = view_test_ctx(1);

    for (int i = 0; i < 5; i++) {
        disc s = {.radius_deg = 1 + 0.3 * i, .radiance = {9000, 7000, 4000}};
        memcpy(s.direction, directions[i], sizeof s.direction);
        check_disc(ctx, i % 2 ? 96 : 64, s);
    }
}

/* A box of half the edge tan, bright by so much, on 1. */
typedef struct soft {
    double tan, radiance;
} soft;

static void soft_light(const void *cookie, const double d[3], double rgb[3])
{
    const soft *s = cookie;
    const bool in =
        d[2] > 0 && fabs(d[0]) < s->tan * d[2] && fabs(d[1]) < s->tan * d[2];

    rgb[0] = rgb[1] = rgb[2] = in ? s->radiance : 1;
}

/* Even light, a soft box, a little lamp; and all black. */
TEST(finds_no_other)
{
    static const soft boxes[] = {
        {0, 0}, {0.3, 60}, {1, 60}, {0.02, 30}, {0.5, 1e4}};
    ibl_ctx *ctx = view_test_ctx(1);

    for (size_t i = 0; i <= sizeof boxes / sizeof *boxes; i++) {
        const disc none = {.direction = {1, 0, 0}};
        view_room_sun sun;
        ibl_texture tex =
            i < sizeof boxes / sizeof *boxes
                ? cube_of(ctx, 32, 1, soft_light, &boxes[i], none.direction)
                : cube_of(ctx, 32, 1, disc_light, &none, none.direction);
        if (i == 0)
            memset(tex.data, 0, tex.bytes);
        CHECK(view_room_sun_find(&tex, &sun));
        CHECK_MSG(!view_room_sun_shines(&sun), "%zu: %g", i, sun.irradiance[1]);
        double rgb[3] = {9, 99, 9e9};
        cut_sun(&sun, sun.direction, rgb);
        CHECK_NEAR(rgb[2], 9e9, 0);
        ibl_texture_free(&tex);
    }
}

static void even_disc(const void *cookie, const double d[3], double rgb[3])
{
    const disc *s = cookie;
    const bool in = test_dot(d, s->direction) > cos(s->radius_deg * PI / 180);

    for (int k = 0; k < 3; k++)
        rgb[k] = in ? s->radiance[k] : 1;
}

/* On 1, discs on either side of each limit: of the spread, which is the radius
 * by the root of 2 and 2 degrees at most, and of the irradiance besides 8 times
 * the mean, which is a tenth of pi at least. */
TEST(limits_of_suns)
{
    const double angle = 2 * PI * (1 - cos(PI / 180));
    const double least = 8 + 0.1 * PI / angle;
    const struct {
        double radius_deg, radiance;
        bool shines;
    } discs[] = {{2.75, 9000, true},
                 {2.95, 9000, false},
                 {1, 1.15 * least, true},
                 {1, 0.85 * least, false}};
    ibl_ctx *ctx = view_test_ctx(1);

    for (int i = 0; i < 4; i++) {
        const double l = discs[i].radiance;
        const disc s = {.direction = {0, 0, 1},
                        .radius_deg = discs[i].radius_deg,
                        .radiance = {l, l, l}};
        view_room_sun sun;
        ibl_texture tex = cube_of(ctx, 256, 8, even_disc, &s, s.direction);
        CHECK(view_room_sun_find(&tex, &sun));
        CHECK_MSG(view_room_sun_shines(&sun) == discs[i].shines, "disc %d", i);
        ibl_texture_free(&tex);
    }
}

static void bake_sky(ibl_ctx *ctx, int size, baked_set *set)
{
    ibl_specular_options o = ibl_specular_options_default();
    ibl_image map;

    o.size = size;
    o.levels = 1;
    NEED(!ibl_image_read(ctx, test_data("sky.exr"), NULL, &map, NULL));
    NEED(sets_bake_image(ctx, "sky", &map, &o, set));
    ibl_image_free(&map);
}

/* Of a photograph's like the same comes out at each size and of halves. */
TEST(finds_sun_of_sky)
{
    ibl_ctx *ctx = view_test_ctx(0);
    view_room_sun first = {0};

    for (int size = 64; size <= 256; size *= 2) {
        baked_set set;
        view_room_sun sun;
        bake_sky(ctx, size, &set);
        CHECK(view_room_sun_find(&set.texture[VIEW_SPECULAR], &sun));
        CHECK(view_room_sun_shines(&sun));
        if (size == 64)
            first = sun;
        CHECK(test_dot(sun.direction, first.direction) > cos(0.7 * PI / 180));
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(sun.irradiance[k] / first.irradiance[k], 1, 0.05);
        view_set_free(&set);
    }
}

/* ---- in the room --------------------------------------------------------- */

enum {
    WIDTH = 160,
    HEIGHT = 96,
    FEW = 2 /* pixels */
};

/* Of the world, for a turn of 0. */
static view_room_sun sun_at(double x, double y, double z)
{
    view_room_sun sun = {.direction = {x, y, z},
                         .irradiance = {6, 5, 3},
                         .limit = 4,
                         .cosine = cos(10 * PI / 180)};

    normalise3(sun.direction);
    return sun;
}

static view_room_draw sunny_draw(const view_camera *camera,
                                 const view_room_sun *sun)
{
    static const ibl_probe all = {.influence = {.half = {20, 20, 20}}};
    view_room_draw d = lit_draw(camera);

    d.environment.sun = *sun;
    /* One probe has all, so that nothing is taken off what is white. */
    d.dynamic = (view_probe_maps){.count = 1,
                                  .probe = &all,
                                  .specular = lit.white_layer,
                                  .irradiance = lit.white_layer,
                                  .irradiance_scale = 1};
    return d;
}

/* Whether a point is in a box: such have no light. */
static bool is_inside(const double p[3])
{
    for (int i = 0; i < view_room_boxes(); i++) {
        const view_room_box *b = view_room_box_at(i);
        if (p[0] > b->low[0] && p[0] < b->high[0] && p[1] > b->low[1] &&
            p[1] < b->high[1] && p[2] > b->low[2] && p[2] < b->high[2])
            return true;
    }
    return false;
}

/* How many of nine points about that of a hit see the sun: as far away across
 * its light as the texels that are looked up, in the plane of the surface. */
static int count_seen(const view_room_draw *d, const room_hit *h,
                      const double l[3], double away)
{
    double right[3] = {l[2], 0, -l[0]}, up[3];
    int seen = 0;

    normalise3(right);
    for (int k = 0; k < 3; k++)
        up[k] = l[(k + 1) % 3] * right[(k + 2) % 3] -
                l[(k + 2) % 3] * right[(k + 1) % 3];
    for (int i = 0; i < 9; i++) {
        const double a = away * (i % 3 - 1), b = away * (i / 3 - 1);
        const double rise =
            -(a * test_dot(h->normal, right) + b * test_dot(h->normal, up)) /
            test_dot(h->normal, l);
        double p[3];
        for (int k = 0; k < 3; k++)
            p[k] = h->point[k] + a * right[k] + b * up[k] + rise * l[k] +
                   1e-5 * h->normal[k];
        seen += !is_inside(p) && room_cast(d, p, l).what < 0;
    }
    return seen;
}

/* What it gives a surface. */
static void sun_term(const view_room_sun *sun, const room_hit *h,
                     const double l[3], const double eye_ray[3], double rgb[3])
{
    const view_room_material *m = h->material;
    const double r = (double)m->roughness, alpha = r * r, a2 = alpha * alpha;
    const double n_l = test_dot(h->normal, l),
                 n_v = -test_dot(h->normal, eye_ray);
    double half[3];

    for (int k = 0; k < 3; k++)
        half[k] = l[k] - eye_ray[k];
    normalise3(half);
    const double n_h = test_dot(h->normal, half),
                 v_h = -test_dot(half, eye_ray);
    const double k2 = 1 - (1 - a2) * n_h * n_h;
    const double v = 0.5 / (n_v * sqrt(n_l * n_l * (1 - a2) + a2) +
                            n_l * sqrt(n_v * n_v * (1 - a2) + a2));
    for (int k = 0; k < 3; k++) {
        const double f0 = (double)m->f0[k], albedo = (double)m->albedo[k];
        const double f = f0 + (1 - f0) * pow(1 - v_h, 5);
        const double specular =
            r < 0.045 || f0 <= 0 ? 0 : a2 / (PI * k2 * k2) * v * f;
        rgb[k] = sun->irradiance[k] * n_l * (specular + (1 - f0) * albedo / PI);
    }
}

/* Whether a pixel has what is expected, in the sun or not. */
static bool has_colour(const float *pixel, const view_room_draw *d,
                       const room_hit *h, const double l[3],
                       const double ray[3], bool in_sun, double tolerance)
{
    double rgb[3] = {0};

    if (in_sun)
        sun_term(&d->environment.sun, h, l, ray, rgb);
    for (int k = 0; k < 3; k++) {
        const double f0 = (double)h->material->f0[k];
        rgb[k] += f0 + (1 - f0) * (double)h->material->albedo[k] +
                  (double)h->material->emission[k];
        if (!(fabs((double)pixel[k] - rgb[k]) < tolerance * rgb[k]))
            return false;
    }
    return true;
}

/* bad: wrong lit and dark ones; a few shadow corners lie between the points. */
typedef struct counts {
    int lit, dark, unsure, bad;
} counts;

/* The hit of all rays near a pixel's centre; what -2: on different sides. */
static room_hit hit_of(const view_camera *c, const view_room_draw *d, int i,
                       double ray[3])
{
    room_hit h = {.what = -2};

    for (int j = 8; j >= 0; j--) {
        const room_hit other = h;
        view_camera_ray(c, WIDTH, HEIGHT, i % WIDTH + 0.6 * ((j + 1) % 3 - 1),
                        i / WIDTH + 0.6 * ((j + 4) / 3 % 3 - 1), ray);
        h = room_cast(d, c->eye, ray);
        if (j < 8 &&
            (h.what != other.what || test_dot(h.normal, other.normal) < 0.8)) {
            h.what = -2;
            return h;
        }
    }
    return h;
}

/* Spheres, of triangles, count where the tolerance is less than theirs. */
static void count_pixels(const view_camera *c, const view_room_draw *d,
                         double tolerance, counts *n)
{
    const view_room_environment *e = &d->environment;
    const double away = 2 * 0.008; /* nearly the largest texel of shadows */
    const bool spheres = tolerance < 0.08;
    float *picture = lit_render(d);
    double l[3], ray[3];

    *n = (counts){0};
    view_turn(-e->turn, e->sun.direction, l);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const room_hit h = hit_of(c, d, i, ray);
        const double n_l = h.what >= 0 ? test_dot(h.normal, l) : 0;
        const bool round = h.what >= view_room_boxes();
        if (h.what < 0 ||
            (round &&
             (!spheres || test_dot(h.normal, ray) > -0.4 || fabs(n_l) < 0.1)))
            continue;
        const int seen = n_l <= 0      ? 0
                         : !d->shadows ? 9
                                       : count_seen(d, &h, l, away);
        const bool ok = has_colour(picture + 4 * i, d, &h, l, ray, seen > 0,
                                   round ? 0.08 : tolerance);
        n->lit += seen == 9;
        n->dark += seen == 0;
        n->unsure += seen > 0 && seen < 9;
        n->bad += !ok && seen % 9 == 0;
    }
}

/* Whole pictures: boxes, spheres that move from one to the next, the sun where
 * it comes through these or those windows, or from above. */
TEST_SLOW(shadows_are_those_of_rays)
{
    static const struct {
        double eye[3], at[3], sun[3], seconds, turn;
    } views[] = {
        {{3.4, 2.3, 4.6}, {-0.8, 0.6, -1}, {-0.8, 0.5, 0.55}, 0, 0},
        {{4.5, 1.8, -1.3}, {-3, 0.2, 0.4}, {-0.9, 0.2, 0.1}, 1.7, 0},
        {{0.2, 3.8, 0.3}, {0.3, 0, 0.1}, {-0.4, 0.35, 0.8}, 3.1, 70},
        {{4, 3, -4}, {-1, 0.6, 2}, {-0.35, 0.3, 0.7}, 6.9, -30},
        {{-9, 5, 8}, {0, 1, 0}, {-0.3, 0.8, 0.5}, 4.4, 0}, /* from outside */
    };

    lit_begin(WIDTH, HEIGHT);
    for (size_t v = 0; v < sizeof views / sizeof views[0]; v++) {
        const view_camera c =
            room_camera(views[v].eye, views[v].at, 70, WIDTH, HEIGHT);
        view_room_sun sun =
            sun_at(views[v].sun[0], views[v].sun[1], views[v].sun[2]);
        double world[3];
        counts n;
        memcpy(world, sun.direction, sizeof world);
        view_turn(views[v].turn, world, sun.direction);
        view_room_draw d = sunny_draw(&c, &sun);
        d.seconds = views[v].seconds;
        d.environment.turn = views[v].turn;
        for (int shadows = 1; shadows >= 0; shadows--) {
            d.shadows = shadows;
            count_pixels(&c, &d, 0.004, &n);
            CHECK_MSG(n.bad == 0 && n.lit > 300 && (n.dark > 100 || !shadows) &&
                          n.unsure < 2000,
                      "view %zu, shadows %d: %d wrong, %d lit, %d dark, "
                      "%d unsure",
                      v, shadows, n.bad, n.lit, n.dark, n.unsure);
        }
    }
}

/* From one draw to the next only one thing is another: what moves takes its
 * shadow along, or has none where it is not drawn, and the sun turns with the
 * environment. */
TEST_SLOW(shadows_follow)
{
    static const struct {
        double seconds, turn;
        bool still;
    } draws[] = {
        {4, 0, false},  {1.6, 0, false}, {1.6, 0, true},
        {1.6, 9, true}, {1.6, 9, false}, {6, 9, false},
    };
    const double eye[3] = {1.5, 2.8, 0.5}, at[3] = {3.3, 0, -1.7};
    int sunlit[sizeof draws / sizeof *draws];

    lit_begin(WIDTH, HEIGHT);
    /* Through a window on the mirror, before which another sphere comes. */
    const view_room_sun sun = sun_at(-5, 1.1, 2.5);
    const view_camera c = room_camera(eye, at, 80, WIDTH, HEIGHT);
    view_room_draw d = sunny_draw(&c, &sun);
    for (size_t i = 0; i < sizeof draws / sizeof *draws; i++) {
        counts n;
        d.moving = !draws[i].still;
        d.seconds = draws[i].seconds;
        d.environment.turn = draws[i].turn;
        count_pixels(&c, &d, 0.004, &n);
        CHECK_MSG(n.bad <= FEW, "draw %zu: %d wrong, %d lit", i, n.bad, n.lit);
        sunlit[i] = n.lit;
    }
    CHECK_MSG(sunlit[1] < sunlit[0] - 50, "%d, %d", sunlit[0], sunlit[1]);
    CHECK_MSG(sunlit[1] < sunlit[2] - 50, "%d, %d", sunlit[2], sunlit[1]);
    CHECK_MSG(abs(sunlit[3] - sunlit[2]) > 50, "%d, %d", sunlit[2], sunlit[3]);
    /* The same but for one component of its direction, and one more. */
    static const double near_by[][3] = {{-0.8, 0.36, 0.48},
                                        {-0.8, 0.48, 0.36},
                                        {-0.8, 0.48, -0.36},
                                        {0.8, 0.48, -0.36}};
    for (int i = 0; i < 4; i++) {
        counts n;
        d = sunny_draw(&c, &sun);
        memcpy(d.environment.sun.direction, near_by[i], sizeof near_by[i]);
        count_pixels(&c, &d, 0.004, &n);
        CHECK_MSG(n.bad <= FEW, "sun %d: %d wrong, %d lit", i, n.bad, n.lit);
    }
}

/* The sky that is shown, whatever was shown before. */
TEST_SLOW(each_set_has_its_own)
{
    static baked_set plain;
    view_settings s = view_settings_default();
    baked_set sunny;

    view_test_begin(32, 24);
    s.mode = VIEW_SCENE;
    s.probe_size = 16;
    view_renderer *r = view_renderer_create();
    sets_white(&plain);
    bake_sky(view_test_ctx(0), 64, &sunny);
    for (int i = 0; i < 4; i++) {
        NEED(view_renderer_load(r, i % 2 ? &sunny : &plain));
        CHECK(view_renderer_draw(r, &s, 32, 24));
        const view_scene *stage = view_renderer_stage(r);
        CHECK(view_room_sun_shines(
                  &view_scene_state_of(stage)->draw.environment.sun) ==
              (i % 2 == 1));
    }
    view_renderer_free(r);
    view_set_free(&sunny);
}

/* The sky has what is left. */
TEST(sky_is_cut)
{
    const double eye[3] = {0, 9, 0}, at[3] = {-9, 16, 3};

    lit_begin(WIDTH, HEIGHT);
    const view_camera c = room_camera(eye, at, 70, WIDTH, HEIGHT);
    view_room_sun sun = sun_at(-9, 8, 4);
    view_room_draw d = sunny_draw(&c, &sun);
    d.environment.turn = 20;
    view_turn(20,
              (double[]){sun.direction[0], sun.direction[1], sun.direction[2]},
              sun.direction);
    d.environment.sun = sun;
    d.environment.sky = room_cube_of(10, 20, 30, 1);
    float *picture = lit_render(&d);
    int bad = 0, cut = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double ray[3], rgb[3] = {10, 20, 30}, env[3];
        view_camera_ray(&c, WIDTH, HEIGHT, i % WIDTH, i / WIDTH, ray);
        view_turn(20, ray, env);
        if (fabs(test_dot(env, sun.direction) - sun.cosine) < 1e-5)
            continue;
        cut_sun(&sun, env, rgb);
        cut += rgb[0] < 9;
        for (int k = 0; k < 3; k++)
            bad += !(fabs((double)picture[4 * i + k] - rgb[k]) < 1e-4);
    }
    CHECK_MSG(bad == 0 && cut > 300 && cut < 5000, "%d wrong, %d cut", bad,
              cut);
}

/* A map of even_disc. */
static ibl_image map_of(ibl_ctx *ctx, const disc *s)
{
    ibl_image map = map_constant(ctx, 512, 256, 1);

    for (int i = 0; i < 512 * 256; i++) {
        double d[3], rgb[3];
        truth_latlong_direction(512, 256, i % 512, i / 512, d);
        even_disc(s, d, rgb);
        map_set(&map, i % 512, i / 512, (float)rgb[0], (float)rgb[1],
                (float)rgb[2]);
    }
    return map;
}

static bool use_set(const baked_set *set, view_room_environment *e)
{
    e->specular = view_upload(&set->texture[VIEW_SPECULAR], false, "specular");
    e->irradiance =
        view_upload(&set->texture[VIEW_IRRADIANCE], false, "irradiance");
    e->lod[0] = (float)set->lod_scale;
    e->lod[1] = (float)set->lod_offset;
    e->lod[2] = (float)(set->texture[VIEW_SPECULAR].levels - 1);
    e->lod[3] = (float)set->mapping;
    e->irradiance_scale = (float)set->irradiance_scale;
    return e->specular && e->irradiance &&
           view_room_sun_find(&set->texture[VIEW_SPECULAR], &e->sun);
}

/* Without a probe a baked environment lights all: together with the light of
 * its sun as much as what is about it and that light. */
TEST(is_not_counted_twice)
{
    const double eye[3] = {3.4, 2.3, 4.6}, at[3] = {-0.8, 0.6, -1};
    disc s = {{-0.8, 0.5, 0.55}, 2, {901, 701, 501}};
    baked_set set = {0};

    lit_begin(WIDTH, HEIGHT);
    ibl_ctx *ctx = view_test_ctx(1);
    normalise3(s.direction);
    ibl_image map = map_of(ctx, &s);
    const view_camera c = room_camera(eye, at, 70, WIDTH, HEIGHT);
    view_room_draw d = sunny_draw(&c, &(view_room_sun){0});
    counts n;
    NEED(sets_bake_image(ctx, "sun", &map, NULL, &set) &&
         use_set(&set, &d.environment));
    d.dynamic = (view_probe_maps){0};
    CHECK(view_room_sun_shines(&d.environment.sun));
    count_pixels(&c, &d, 0.1, &n);
    CHECK_MSG(n.bad == 0 && n.lit > 300, "%d wrong, %d lit, %d dark", n.bad,
              n.lit, n.dark);
    view_set_free(&set);
}

/* A sun that is no part of the maps is added, and nothing is cut. */
TEST(apart_from_maps)
{
    const double eye[3] = {3.4, 2.3, 4.6}, at[3] = {-0.8, 0.6, -1};
    const view_camera c = room_camera(eye, at, 70, WIDTH, HEIGHT);
    view_room_sun sun = sun_at(-0.8, 0.5, 0.55);
    counts n;

    lit_begin(WIDTH, HEIGHT);
    sun.apart = true;
    sun.limit = 0;
    view_room_draw d = sunny_draw(&c, &sun);
    d.environment.specular = d.environment.irradiance =
        room_cube_of(1, 1, 1, 1);
    d.environment.irradiance_scale = 1;
    d.dynamic = (view_probe_maps){0};
    for (int fit = 0; fit < 2; fit++) {
        d.environment.fit = fit;
        count_pixels(&c, &d, 0.004, &n);
        CHECK_MSG(n.bad == 0 && n.lit > 300, "fit %d: %d wrong, %d lit", fit,
                  n.bad, n.lit);
    }
}
