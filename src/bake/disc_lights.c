/* SPDX-License-Identifier: MIT */
/*
 * Compact sources of a map, taken out as lights: see ibl_image_take_lights.
 *
 * 1. Bright pixels are looked at from the brightest down. A circle grows around
 *    each, and moves to the middle of the light in it, until what is around it
 *    is dark. Pixels of that circle are not looked at again.
 * 2. What lies in the circle above the ring around it is a source, if it is
 *    small enough.
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
static const double contrast = 16;   /* of a light to the map's mean and to each
                                        pixel of the ring */
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
    double bright;        /* contrast times the map's mean luminance */
    double radius;        /* largest of a light */
    bright_pixel *pixels; /* above that, the brightest first */
    size_t pixel_count;
    unsigned char *seen; /* of each pixel of the map: 1 within a circle */
    source *sources;     /* compact ones, the strongest first; one more */
    int most, count;
    bool wide; /* there are sources that are not compact */
} finder;

/* ---- bright pixels ------------------------------------------------------- */

static double pixel_luminance(const finder *f, size_t pixel)
{
    return ibl_pixel_luminance(f->map->data + 3 * pixel);
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
    const size_t all = (size_t)f->map->width * (size_t)f->map->height;
    size_t count = 0;
    double light = 0;

    for (size_t j = 0, pixel = 0; pixel < all; j++) {
        double row = 0;
        for (int i = 0; i < f->map->width; i++)
            row += pixel_luminance(f, pixel++);
        light += row * f->grid.rows[j].solid_angle;
    }
    f->bright = contrast * light / (4 * IBL_PI);
    f->radius = fmax(max_radius, fmin(f->grid.edge, max_pixel));
    for (size_t i = 0; i < all; i++)
        count += pixel_luminance(f, i) > f->bright;
    f->pixels = ibl_alloc_array(count, sizeof *f->pixels);
    f->seen = ibl_alloc_zeroed(all, 1);
    f->sources = ibl_alloc_array((size_t)f->most + 1, sizeof *f->sources);
    if (!f->pixels || !f->seen || !f->sources)
        return false;
    for (size_t i = 0; i < all; i++)
        if (pixel_luminance(f, i) > f->bright)
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

/*
 * Grows a circle around a pixel until the ring around it is dark. If it never
 * is, as in haze around a sun, it is the widest circle with little of the light
 * under the ring. A pixel beside a source may lead to the source again: then
 * the middle of its circle has been seen.
 */
static void look_at(finder *f, size_t pixel, double peak)
{
    const double edge = f->grid.edge;
    const double own =
        peak * f->grid.rows[pixel / (size_t)f->grid.width].solid_angle;
    ibl_disc at = {.radius = f->radius};
    double size = HUGE_VAL; /* radius of a disc of that light */
    bool dark = false;

    ibl_map_direction(&f->grid, pixel, at.centre);
    source found = {at, 0}; /* not yet a source */
    for (at.radius = edge; at.radius <= 2 * f->radius && !dark;
         at.radius += fmax(0.5 * edge, 0.1 * at.radius)) {
        circle_sums s = {.f = f, .inner = cos(at.radius)};
        double to[3];
        ibl_map_visit_cap(&f->grid, at.centre, at.radius + 2.5 * edge,
                          add_pixel, &s);
        const double ring = s.ring_light / fmax(s.ring_angle, 1e-300);
        const double light = s.light - ring * s.angle;
        const double radiance = fmin(
            (s.square - 2 * ring * s.light + ring * ring * s.angle) / light,
            peak);
        /* Texture has as much above the ring as below it. */
        const bool is = light > 0.5 * own && s.ring_peak <= radiance / contrast;
        dark = is && ring <= f->bright;
        if (dark || (is && ring * s.angle < most_left * light)) {
            /* What a blurred edge has outside is in one pixel more. */
            found = (source){at, light};
            found.disc.radius += edge;
            size = ibl_disc_radius(light / radiance);
        }
        for (int c = 0; c < 3; c++)
            to[c] = s.moment[c] - ring * s.area[c];
        if (dot3(to, at.centre) > 0 && unit3(to))
            memcpy(at.centre, to, sizeof to);
    }
    if (size > f->radius)
        f->wide = true;
    else if (!f->seen[ibl_map_pixel(&f->grid, found.disc.centre)])
        keep(f, &found);
    ibl_map_visit_cap(&f->grid, found.disc.centre, found.disc.radius, mark_seen,
                      f->seen);
    f->seen[pixel] = 1;
}

/* ---- the call ------------------------------------------------------------ */

/* Says why fewer were taken. */
static void say_why(const finder *f, int taken)
{
    char which[48] = "no light was taken";

    if (taken)
        snprintf(which, sizeof which, "%d of %d lights were taken", taken,
                 f->most);
    if (!f->pixel_count)
        ibl_warn(f->ctx,
                 "%s: no pixel is %g times as bright as the mean, which a "
                 "compact source is",
                 which, contrast);
    else if (f->wide)
        ibl_warn(f->ctx,
                 "%s: what%s is bright is wider than %.3g degrees, or has "
                 "bright things beside it",
                 which, taken ? " else" : "", 2 * f->radius / DEGREE);
    else
        ibl_warn(f->ctx, "%s: the map has no other compact source", which);
}

static int stronger_first(const void *a, const void *b)
{
    const double p = ibl_luminance(((const ibl_light *)a)->irradiance);
    const double q = ibl_luminance(((const ibl_light *)b)->irradiance);
    return (p < q) - (p > q);
}

static ibl_status run(finder *f, ibl_image *map, double yaw, ibl_light *lights,
                      int *count)
{
    ibl_status status = IBL_OK;
    int n = 0;

    if (!ibl_map_grid_create(map->width, map->height, &f->grid) ||
        !collect_pixels(f))
        return ibl_no_memory(f->ctx, "the lights of a map");
    for (size_t i = 0; i < f->pixel_count; i++) {
        if (ibl_cancelled(f->ctx))
            return IBL_ERR_CANCELLED;
        if (!f->seen[f->pixels[i].index])
            look_at(f, f->pixels[i].index, f->pixels[i].luminance);
    }
    for (int i = 0; i < f->count && n < f->most && !status; i++)
        status = ibl_disc_take(f->ctx, &f->grid, map, &f->sources[i].disc,
                               f->most, f->count - 1 - i, lights, &n);
    if (status)
        return status;
    for (ibl_light *l = lights; l < lights + n; l++) {
        const double x = l->direction[0], z = l->direction[2];
        l->direction[0] = cos(yaw) * x + sin(yaw) * z;
        l->direction[2] = cos(yaw) * z - sin(yaw) * x;
    }
    qsort(lights, (size_t)n, sizeof *lights, stronger_first);
    *count = n;
    if (n < f->most)
        say_why(f, n);
    return IBL_OK;
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
