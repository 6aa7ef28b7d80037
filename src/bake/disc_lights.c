/* SPDX-License-Identifier: MIT */
/*
 * Compact sources of a map, taken out as lights: see ibl_image_take_lights.
 *
 * 1. Pixels above the threshold are looked at from the brightest down. A circle
 *    grows around each, and moves to the middle of the light in it, until what
 *    is around it is dark. Pixels of that circle are not looked at again.
 * 2. What lies in the circle above the ring around it is a source. It is kept
 *    if it is small enough and strong enough.
 * 3. The strongest are taken, one after the other.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/disc_take.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/vector.h"
#include "image/image.h"

#define DEGREE (IBL_PI / 180)

static const double max_radius = 2.5 * DEGREE;
static const double max_pixel = 6 * DEGREE;
static const double least_share = 0.1;      /* of pi times the mean radiance */
static const double most_beside = 1.0 / 32; /* of the peak, around a circle */
static const double least_contrast = 10;    /* of a light to the ring */
static const double most_left = 0.1; /* of a source's light, under the ring */

typedef struct source {
    ibl_disc disc;
    double light; /* int dY dO, above the ring around the circle */
} source;

typedef struct bright_pixel {
    size_t index;
    double luminance;
} bright_pixel;

typedef struct finder {
    ibl_ctx *ctx;
    const ibl_image *map;
    ibl_map_grid grid;
    double mean;          /* of the map; all in luminance */
    double times;         /* threshold / mean */
    double radius;        /* largest of a light */
    double threshold;     /* half the radiance of a light of the least share and
                             that radius */
    bright_pixel *pixels; /* above the threshold, the brightest first */
    size_t pixel_count;
    unsigned char *seen; /* of each pixel of the map: 1 within a circle */
    source *sources;     /* compact ones, the strongest first; one more */
    int most, count;
    int wide;          /* sources that are not compact */
    double most_faint; /* the strongest of those that are too faint */
} finder;

/* ---- pixels above the threshold ------------------------------------------ */

static size_t pixel_number(const ibl_image *map)
{
    return (size_t)map->width * (size_t)map->height;
}

static double pixel_luminance(const finder *f, size_t pixel)
{
    return ibl_pixel_luminance(f->map->data + 3 * pixel);
}

static void measure(finder *f)
{
    double light = 0;
    size_t pixel = 0;

    for (int j = 0; j < f->map->height; j++) {
        double row = 0;
        for (int i = 0; i < f->map->width; i++)
            row += pixel_luminance(f, pixel++);
        light += row * f->grid.rows[j].solid_angle;
    }
    f->mean = light / (4 * IBL_PI);
    f->radius = fmax(max_radius, fmin(f->grid.edge, max_pixel));
    f->times = 0.5 * least_share * IBL_PI / ibl_disc_solid_angle(f->radius);
    f->threshold = f->times * f->mean;
}

static int brightest_first(const void *a, const void *b)
{
    const bright_pixel *p = a, *q = b;
    if (p->luminance != q->luminance)
        return p->luminance > q->luminance ? -1 : 1;
    return p->index < q->index ? -1 : 1;
}

static bool collect_pixels(finder *f)
{
    const size_t all = pixel_number(f->map);
    size_t count = 0;

    for (size_t i = 0; i < all; i++)
        count += pixel_luminance(f, i) > f->threshold;
    f->pixels = ibl_alloc_array(count, sizeof *f->pixels);
    f->seen = ibl_alloc_zeroed(all, 1);
    f->sources = ibl_alloc_array((size_t)f->most + 1, sizeof *f->sources);
    if (!f->pixels || !f->seen || !f->sources)
        return false;
    for (size_t i = 0; i < all; i++)
        if (pixel_luminance(f, i) > f->threshold)
            f->pixels[f->pixel_count++] =
                (bright_pixel){i, pixel_luminance(f, i)};
    qsort(f->pixels, count, sizeof *f->pixels, brightest_first);
    return true;
}

/* ---- a circle and the ring around it ------------------------------------- */

typedef struct circle_sums {
    const finder *f;
    double inner;                /* cosine of the circle's radius */
    double light, angle, square; /* int Y dO, int dO, int Y^2 dO within */
    double moment[3], area[3];   /* int Y w dO, int w dO within */
    double ring_light, ring_angle, ring_peak;
} circle_sums;

static void add_pixel(void *cookie, const ibl_cap_pixel *p)
{
    circle_sums *s = cookie;
    const double y = pixel_luminance(s->f, p->index);
    const double angle = p->row->solid_angle;
    double flux[3];

    if (p->cosine <= s->inner) {
        s->ring_light += y * angle;
        s->ring_angle += angle;
        s->ring_peak = fmax(s->ring_peak, y);
        return;
    }
    s->light += y * angle;
    s->square += y * y * angle;
    s->angle += angle;
    ibl_map_flux(&s->f->grid, p->index, flux);
    for (int c = 0; c < 3; c++) {
        s->moment[c] += y * flux[c];
        s->area[c] += flux[c];
    }
}

static circle_sums sum_circle(const finder *f, const ibl_disc *disc)
{
    circle_sums s = {.f = f, .inner = cos(disc->radius)};

    ibl_map_visit_cap(&f->grid, disc->centre, disc->radius + 1.5 * f->grid.edge,
                      add_pixel, &s);
    return s;
}

static double ring_mean(const circle_sums *s)
{
    return s->ring_angle > 0 ? s->ring_light / s->ring_angle : 0;
}

/* Light above the ring. */
static double excess(const circle_sums *s)
{
    return s->light - ring_mean(s) * s->angle;
}

/* Moves a circle to the middle of the light above the ring. */
static void centre_disc(const circle_sums *s, ibl_disc *disc)
{
    double to[3];

    for (int c = 0; c < 3; c++)
        to[c] = s->moment[c] - ring_mean(s) * s->area[c];
    if (dot3(to, disc->centre) > 0 && unit3(to))
        memcpy(disc->centre, to, sizeof to);
}

/*
 * Grows a circle until the ring around it has no pixel near the peak, and a
 * mean below the threshold. If it stays above, as haze around a sun may, it is
 * the widest circle with little of the light under the ring. One pixel more is
 * for what a blurred edge has outside. False: there is no such circle.
 */
static bool grow(const finder *f, double peak, ibl_disc *disc)
{
    const double limit = 2 * f->radius, edge = f->grid.edge;
    const double beside = fmax(peak * most_beside, f->threshold);
    ibl_disc at = {.radius = edge};
    bool found = false, dark = false;

    memcpy(at.centre, disc->centre, sizeof at.centre);
    while (at.radius <= limit && !dark) {
        const circle_sums s = sum_circle(f, &at);
        const double left = ring_mean(&s) * s.angle / excess(&s);
        dark = ring_mean(&s) <= f->threshold && s.ring_peak <= beside;
        if (dark || (s.ring_peak <= beside && left > 0 && left < most_left)) {
            *disc = at;
            found = true;
        }
        centre_disc(&s, &at);
        at.radius += fmax(0.5 * edge, 0.1 * at.radius);
    }
    if (!found)
        disc->radius = limit;
    disc->radius += edge;
    return found;
}

/* ---- sources ------------------------------------------------------------- */

static void mark_seen(void *cookie, const ibl_cap_pixel *p)
{
    ((unsigned char *)cookie)[p->index] = 1;
}

/* Keeps the strongest; of equals the one that came first. */
static void keep(finder *f, const source *s)
{
    int at = f->count;

    for (; at > 0 && f->sources[at - 1].light < s->light; at--)
        f->sources[at] = f->sources[at - 1];
    f->sources[at] = *s;
    if (f->count < f->most)
        f->count++;
}

static void judge(finder *f, const ibl_disc *disc, bool is_alone)
{
    const circle_sums s = sum_circle(f, disc);
    const double ring = ring_mean(&s), light = excess(&s);
    const double square = s.square - 2 * ring * s.light + ring * ring * s.angle;
    const double radiance = square / light;

    if (!is_alone || radiance < least_contrast * ring ||
        ibl_disc_radius(light / radiance) > f->radius)
        f->wide++;
    else if (light < least_share * IBL_PI * f->mean)
        f->most_faint = fmax(f->most_faint, light);
    else
        keep(f, &(source){*disc, light});
}

/* A pixel beside a source may lead to the source again: then the middle of its
 * circle has been seen. */
static void look_at(finder *f, const bright_pixel *p)
{
    ibl_disc disc;

    ibl_map_direction(&f->grid, p->index, disc.centre);
    const bool is_alone = grow(f, p->luminance, &disc);
    if (!f->seen[ibl_map_pixel(&f->grid, disc.centre)])
        judge(f, &disc, is_alone);
    ibl_map_visit_cap(&f->grid, disc.centre, disc.radius, mark_seen, f->seen);
    f->seen[p->index] = 1;
}

static ibl_status find_sources(finder *f)
{
    for (size_t i = 0; i < f->pixel_count; i++) {
        if (ibl_cancelled(f->ctx))
            return IBL_ERR_CANCELLED;
        if (!f->seen[f->pixels[i].index])
            look_at(f, &f->pixels[i]);
    }
    return IBL_OK;
}

/* ---- the call ------------------------------------------------------------ */

/* What else is bright, and why it was not taken. */
static void describe_rest(const finder *f, char *text, size_t size)
{
    if (!f->pixel_count)
        snprintf(text, size,
                 "no pixel is %.0f times as bright as the mean, which a "
                 "compact source is",
                 f->times);
    else if (f->wide)
        snprintf(text, size,
                 "what%s is bright is wider than %.3g degrees, or has bright "
                 "things beside it",
                 f->count ? " else" : "", 2 * f->radius / DEGREE);
    else if (f->most_faint > 0 || !f->count)
        snprintf(text, size,
                 "the strongest%s compact source gives %.2g %% of the light, "
                 "less than %.0f %%",
                 f->count ? " other" : "",
                 100 * f->most_faint / (IBL_PI * f->mean), 100 * least_share);
    else
        snprintf(text, size, "the map has no other compact source");
}

static void say_why(const finder *f)
{
    char rest[160];

    describe_rest(f, rest, sizeof rest);
    if (f->count)
        ibl_warn(f->ctx, "%d of %d lights were taken: %s", f->count, f->most,
                 rest);
    else
        ibl_warn(f->ctx, "no light was taken: %s", rest);
}

static int stronger_first(const void *a, const void *b)
{
    const double p = ibl_luminance(((const ibl_light *)a)->irradiance);
    const double q = ibl_luminance(((const ibl_light *)b)->irradiance);
    return (p < q) - (p > q);
}

static void turn(double yaw, double direction[3])
{
    const double x = direction[0], z = direction[2];
    direction[0] = cos(yaw) * x + sin(yaw) * z;
    direction[2] = cos(yaw) * z - sin(yaw) * x;
}

static ibl_status take_all(const finder *f, ibl_image *map, double yaw,
                           ibl_light *lights, int *count)
{
    ibl_status status = IBL_OK;
    int n = 0;

    for (int i = 0; i < f->count && !status; i++) {
        status = ibl_disc_take(f->ctx, &f->grid, map, &f->sources[i].disc,
                               &lights[n]);
        if (!status && lights[n].radius > 0)
            turn(yaw, lights[n++].direction);
    }
    qsort(lights, (size_t)n, sizeof *lights, stronger_first);
    *count = status ? 0 : n;
    return status;
}

static ibl_status run(finder *f, ibl_image *map, double yaw, ibl_light *lights,
                      int *count)
{
    if (!ibl_map_grid_create(map->width, map->height, &f->grid))
        return ibl_no_memory(f->ctx, "the lights of a map");
    measure(f);
    if (!collect_pixels(f))
        return ibl_no_memory(f->ctx, "the lights of a map");
    const ibl_status status = find_sources(f);
    if (status)
        return status;
    if (f->count < f->most)
        say_why(f);
    return take_all(f, map, yaw, lights, count);
}

ibl_status ibl_image_take_lights(ibl_ctx *ctx, ibl_image *map, double yaw_deg,
                                 int most, ibl_light *lights, int *count)
{
    finder f = {.ctx = ctx, .map = map, .most = most};
    ibl_status status = ibl_check_image(ctx, map);

    if (status)
        return status;
    if (!lights || !count)
        return ibl_missing(ctx, "ibl_image_take_lights: lights or count");
    *count = 0;
    if (most < 1 || most > IBL_MAX_LIGHTS)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "%d lights: must be 1 to %d",
                        most, IBL_MAX_LIGHTS);
    if (!isfinite(yaw_deg))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a yaw of %g degrees: must be finite", yaw_deg);
    ibl_progress(ctx, "lights", 0);
    status = run(&f, map, remainder(yaw_deg, 360) * DEGREE, lights, count);
    ibl_progress(ctx, "lights", 1);
    ibl_map_grid_free(&f.grid);
    ibl_free(f.pixels);
    ibl_free(f.seen);
    ibl_free(f.sources);
    return status;
}
