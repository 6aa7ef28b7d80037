/* SPDX-License-Identifier: MIT */
/* Lights that are taken out of maps. */
#include <math.h>
#include <string.h>

#include "reference.h"
#include "truth.h"

#define DEGREE (M_PI / 180)

enum {
    WIDTH = 1024,
    HEIGHT = 512,
    PARTS = 12 /* of a pixel along an edge */
};

static const double pixel = M_PI / HEIGHT;

/* The direction of a place in a map, in pixels. */
static void look(const ibl_image *map, double x, double y, double dir[3])
{
    truth_latlong_direction(map->width, map->height, x - 0.5, y - 0.5, dir);
}

static double solid_angle(const ibl_image *map, int y)
{
    return truth_latlong_solid_angle(map->width, map->height, y);
}

static double angle_between(const double a[3], const double b[3])
{
    const double cross[3] = {a[1] * b[2] - a[2] * b[1],
                             a[2] * b[0] - a[0] * b[2],
                             a[0] * b[1] - a[1] * b[0]};
    return atan2(sqrt(test_dot(cross, cross)), test_dot(a, b));
}

/* The covered share of a pixel. */
static double coverage(const ibl_image *map, int x, int y, const double to[3],
                       double radius)
{
    double dir[3];
    int inside = 0;

    const double edge = 2 * M_PI / map->height;
    if (fabs(acos(to[1]) - M_PI * (y + 0.5) / map->height) > radius + edge)
        return 0;
    look(map, x + 0.5, y + 0.5, dir);
    const double far = angle_between(dir, to) - radius;
    if (fabs(far) > edge)
        return far < 0;
    for (int k = 0; k < PARTS * PARTS; k++) {
        look(map, x + (k % PARTS + 0.5) / PARTS, y + (k / PARTS + 0.5) / PARTS,
             dir);
        inside += test_dot(dir, to) > cos(radius);
    }
    return inside / (double)(PARTS * PARTS);
}

/* Adds a disc; returns its light, as the floats have it. */
static double paint(const ibl_image *map, const double to[3], double radius,
                    const float rgb[3])
{
    double light = 0;

    for (int y = 0; y < map->height; y++)
        for (int x = 0; x < map->width; x++) {
            const float share = (float)coverage(map, x, y, to, radius);
            float *p = map_pixel(map, x, y);
            const float was = p[0];
            for (int c = 0; c < 3 && share > 0; c++)
                p[c] += share * rgb[c];
            light += ((double)p[0] - (double)was) * solid_angle(map, y);
        }
    return light;
}

/* A sky that rises by `slope` from -X to +X. */
static ibl_image sky(ibl_ctx *ctx, double slope)
{
    const ibl_image map = map_constant(ctx, WIDTH, HEIGHT, 1);
    double dir[3];

    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            look(&map, x + 0.5, y + 0.5, dir);
            for (int c = 0; c < 3; c++)
                map_pixel(&map, x, y)[c] = (float)(1 + slope * dir[0]);
        }
    return map;
}

static const float white[3] = {20000, 20000, 20000};

static int take(ibl_ctx *ctx, ibl_image *map, int most, ibl_light *lights)
{
    int count = -1;
    NEED(!ibl_image_take_lights(ctx, map, 0, most, lights, &count));
    return count;
}

/* The largest deviation of a map from another. */
static double most_change(const ibl_image *a, const ibl_image *b)
{
    double most = 0;
    for (size_t i = 0; i < map_floats(a); i++)
        most = fmax(most, fabs((double)a->data[i] - (double)b->data[i]));
    return most;
}

/* ---- discs ------------------------------------------------------------------
 */

/* Discs around a middle: degrees along the row and across it, radius, and what
 * they have of 20000. */
static const struct scene {
    double x, y, slope; /* the middle in pixels, the sky */
    int count;
    double at[12];
} scenes[] = {
    {300.3, 200.8, 0, 1, {0, 0, 0.4, 1}}, /* anywhere */
    {0.1, 256.2, 0.5, 1, {0, 0, 0.8, 1}}, /* over the seam, on the horizon */
    {1023.7, 90.4, 0, 1, {0, 0, 1.2, 1}}, /* over the seam */
    {700, 0.3, 0.5, 1, {0, 0, 1.6, 1}},   /* at the poles */
    {10.9, 509.2, 0, 1, {0, 0, 2, 1}},
    {511.5, 40.6, 0.5, 1, {0, 0, 2.4, 1}}, /* near one */
    /* as one lamp; unequal; over the seam; at a pole; beside a fainter one;
     * 500 on 1; the strongest is not the brightest */
    {300, 200, 0, 2, {-0.75, 0, 0.4, 1, 0.75, 0, 0.4, 1}},
    {300, 200, 0.5, 2, {-0.7, 0, 0.4, 1, 0.7, 0.5, 0.4, 0.3}},
    {1024, 150, 0, 3, {-1.4, 0, 0.4, 1, 0, 0, 0.4, 1, 1.4, 0, 0.4, 1}},
    {100, 1, 0, 2, {-0.75, 0, 0.4, 1, 0.75, 0, 0.4, 0.6}},
    {600, 300, 0, 3, {-0.75, 0, 0.4, 1, 0.75, 0, 0.4, 1, 4, 0, 0.4, 0.2}},
    {600, 300, 0, 2, {-0.75, 0, 0.4, 0.025, 0.75, 0, 0.4, 0.03}},
    {405, 200, 0, 2, {-1.65, 0, 0.4, 4.5, 1.65, 0, 1, 1}},
};

static void place_disc(const double middle[3], const double *at, double to[3])
{
    const double flat = hypot(middle[0], middle[2]);
    const double row[3] = {-middle[2] / flat, 0, middle[0] / flat};

    for (int c = 0; c < 3; c++)
        to[c] = middle[c] + row[c] * at[0] * DEGREE;
    to[1] += at[1] * DEGREE;
    const double length = sqrt(test_dot(to, to));
    for (int c = 0; c < 3; c++)
        to[c] /= length;
}

/* Each is a light of its own with its energy, the strongest first, and nothing
 * of it is left: of a constant sky all that is left is that, of one with a
 * slope what keeps to it. As many as were found are the same again. A pixel's
 * coverage widens a disc by a sixth of a pixel. */
static void check_scene(ibl_ctx *ctx, const struct scene *k)
{
    const ibl_image before = sky(ctx, k->slope);
    ibl_image map = map_scaled(ctx, &before, 1);
    ibl_light lights[8], again[8];
    double middle[3], to[3][3], painted[3];
    const bool alone = k->count == 1;

    look(&map, k->x, k->y, middle);
    for (int i = 0; i < k->count; i++) {
        const float most = 20000 * (float)k->at[4 * i + 3];
        place_disc(middle, k->at + 4 * i, to[i]);
        painted[i] = paint(&map, to[i], k->at[4 * i + 2] * DEGREE,
                           (const float[]){most, most, most});
    }
    ibl_image other = map_scaled(ctx, &map, 1),
              third = map_scaled(ctx, &map, 1);
    const double yaw = 40.0 * (double)(k - scenes); /* which turns the world */
    int count = 0;
    NEED(!ibl_image_take_lights(ctx, &map, yaw, alone ? 1 : 8, lights, &count));
    for (int i = 0; i < k->count; i++) {
        const double phi = atan2(to[i][2], to[i][0]) - yaw * DEGREE;
        polar_direction(acos(to[i][1]), phi, to[i]);
    }
    CHECK_MSG(count == k->count, "scene %td: %d lights", k - scenes, count);
    for (int i = 0; i < k->count && i < count; i++) {
        int at = 0;
        for (int j = 1; j < count; j++)
            if (angle_between(lights[j].direction, to[i]) <
                angle_between(lights[at].direction, to[i]))
                at = j;
        const double off = angle_between(lights[at].direction, to[i]) / pixel;
        const double wider =
            (lights[at].radius - k->at[4 * i + 2] * DEGREE) / pixel;
        const double light = fabs(lights[at].irradiance[0] / painted[i] - 1);
        CHECK_MSG(off <= 0.1 && fabs(wider) <= (alone ? 0.25 : 0.3) &&
                      light <= (!alone         ? 0.01
                                : k->slope > 0 ? 1e-5
                                               : 1e-7),
                  "scene %td: %g pixels off, %g wider, %g of the light",
                  k - scenes, off, wider, light);
        CHECK(!i || lights[i].irradiance[1] <=
                        lights[i - 1].irradiance[1] * (1 + 1e-6F));
    }
    CHECK_NEAR(most_change(&map, &before), 0,
               k->slope > 0 ? 3 * k->slope * pixel : 1e-6);
    CHECK(take(ctx, &other, count, again) == count);
    if (k == &scenes[6]) { /* as one they have the light of both */
        CHECK(take(ctx, &third, 1, again) == 1);
        CHECK_NEAR(again[0].irradiance[0] / (painted[0] + painted[1]), 1, 1e-5);
        CHECK_NEAR(again[0].radius / DEGREE, sqrt(2 * 0.75 * 0.75 + 0.16), 0.1);
    }
    CHECK(yaw > 0 || !memcmp(lights, again, (size_t)count * sizeof *lights));
}

TEST(discs)
{
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++)
        check_scene(test_ctx(1, IBL_ISA_AUTO), &scenes[i]);
}

/* One pixel has its own solid angle. */
TEST(one_pixel)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);

    for (int y = 0; y < 64; y += 21) {
        ibl_image map = map_constant(ctx, 128, 64, 1);
        ibl_light light;
        double to[3];
        map_set(&map, 127, y, 1e6F, 2e6F, 0);
        NEED(take(ctx, &map, 1, &light) == 1);
        look(&map, 127.5, y + 0.5, to);
        const double omega = solid_angle(&map, y);
        CHECK_NEAR(angle_between(light.direction, to), 0, 0.2 * M_PI / 64);
        CHECK_NEAR(4 * M_PI * pow(sin(light.radius / 2), 2) / omega, 1, 1e-5);
        CHECK_NEAR(light.radiance[0] / (1e6 - 1), 1, 1e-5);
        CHECK_NEAR(light.irradiance[1] / ((2e6 - 1) * omega), 1, 1e-6);
        CHECK(light.irradiance[2] == 0 && light.radiance[2] == 0);
        CHECK(map_pixel(&map, 127, y)[0] == 1);
        CHECK(map_pixel(&map, 127, y)[2] == 0);
    }
}

static void untouched(const ibl_image *map, const char *why)
{
    static test_messages kept;
    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    ibl_image now = map_scaled(ctx, map, 1);
    ibl_light lights[4];

    kept.text[IBL_LOG_WARNING][0] = 0;
    CHECK(take(ctx, &now, 4, lights) == 0);
    CHECK(!memcmp(now.data, map->data, map_floats(map) * sizeof *map->data));
    CHECK_MSG(strstr(kept.text[IBL_LOG_WARNING], why) != NULL, "%s",
              kept.text[IBL_LOG_WARNING]);
}

/* Adds a haze that falls with a power of the distance in pixels. */
static void paint_haze(const ibl_image *map, const double to[3], double most,
                       double power)
{
    double dir[3];

    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            look(map, x + 0.5, y + 0.5, dir);
            const double away = fmax(angle_between(dir, to) / pixel, 0.5);
            for (int c = 0; c < 3; c++)
                map_pixel(map, x, y)[c] += (float)(most * pow(away, -power));
        }
}

/* Around a sun haze may stay bright as far as circles go, if that is little of
 * the light. Haze alone is no light. */
TEST(bright_haze)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_image map = sky(ctx, 0), alone = sky(ctx, 0);
    ibl_light light;
    double to[3];

    look(&map, 300.5, 150.5, to);
    paint_haze(&map, to, 1e5, 2);
    paint_haze(&alone, to, 1e5, 2);
    map_pixel(&map, 300, 150)[1] += 2.8e6F;
    NEED(take(ctx, &map, 1, &light) == 1);
    CHECK_NEAR(angle_between(light.direction, to) / pixel, 0, 0.1);
    CHECK(map_pixel(&map, 300, 150)[0] > 300 &&
          map_pixel(&map, 300, 150)[0] < 2000);
    untouched(&alone, "wider than 5 degrees");
}

/* ---- energy -------------------------------------------------------------- */

/* Nothing is lost or won, whatever the map; no value leaves the range. */
TEST(random_maps)
{
    static test_messages kept;
    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    ibl_light lights[IBL_MAX_LIGHTS];

    for (uint64_t seed = 1; seed <= (TEST_SANITIZED ? 30 : 150); seed++) {
        test_random r = {seed};
        const int w = 1 + test_random_below(&r, 64);
        const int h = seed % 2 ? 1 + w / 2 : 1 + test_random_below(&r, 40);
        ibl_image map =
            map_of_kind(ctx, &r, (map_kind)(seed % MAP_KINDS), w, h);
        double before[3], after[3], low[3], high[3], now_low, now_high;
        for (int c = 0; c < 3; c++)
            map_range(&map, c, &low[c], &high[c]);
        reference_mean(&map, before);
        const int count = take(ctx, &map, IBL_MAX_LIGHTS, lights);
        reference_mean(&map, after);
        for (int c = 0; c < 3; c++) {
            for (int i = 0; i < count; i++)
                after[c] += lights[i].irradiance[c] / (4 * M_PI);
            CHECK_MSG(fabs(after[c] - before[c]) <= 1e-7 * before[c],
                      "seed %d: %.17g, not %.17g", (int)seed, after[c],
                      before[c]);
            map_range(&map, c, &now_low, &now_high);
            CHECK(now_low >= low[c] && now_high <= high[c]);
        }
    }
}

/* ---- nothing to take ----------------------------------------------------- */

static void paint_rectangle(const ibl_image *map, int width, int height,
                            float value)
{
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            map_set(map, 300 + x, 150 + y, value, value, value);
}

/* Windows, tubes, soft skies. */
TEST(nothing)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    test_random r = {5};
    const ibl_image constant = map_constant(ctx, 256, 128, 3);
    const ibl_image black = map_constant(ctx, 256, 128, 0);
    const ibl_image smooth = map_of_kind(ctx, &r, MAP_SMOOTH, 256, 128);
    const ibl_image window = sky(ctx, 0), tube = sky(ctx, 0),
                    thin = sky(ctx, 0);
    double to[3];

    untouched(&constant, "no pixel is 16 times");
    untouched(&black, "no pixel is 16 times");
    untouched(&smooth, "no pixel is 16 times");
    paint_rectangle(&window, 30, 40, 1000);
    untouched(&window, "wider than 5 degrees");
    paint_rectangle(&tube, 100, 3, 1e5F);
    untouched(&tube, "wider than 5 degrees");
    paint_rectangle(&thin, 400, 1, 1e5F);
    untouched(&thin, "wider than 5 degrees");
    const ibl_image wide = sky(ctx, 0);
    look(&wide, 100, 100, to);
    paint(&wide, to, 3 * DEGREE, white);
    untouched(&wide, "wider than 5 degrees");
}
