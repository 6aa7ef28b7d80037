/* SPDX-License-Identifier: MIT */
/*
 * The smooth map under a light.
 *
 * Within a circle of the sphere, the harmonic function of the values on it is a
 * weighted mean of these: harmonic functions stay harmonic when the sphere is
 * projected stereographically, and for the unit disc Poisson's integral has the
 * weight (1 - |z|^2) / |z - e|^2 of point e at point z. As a mean it is never
 * beyond the range of the values. The sums are divided by that of the weights,
 * so the factor 1 - |z|^2 is left out.
 */
#include "bake/disc_take.h"

#include <math.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "core/vector.h"

/* Where the values of the circle are read, in pixels beyond it. The first is
 * far enough that no pixel within the circle is read. */
static const double ring_from = 0.75, ring_to = 1.25;
enum {
    RING_READS = 3 /* pixels from there to there, for each value */
};

typedef struct ring_value {
    double x, y; /* on the unit circle */
    double rgb[3];
} ring_value;

typedef struct filled_pixel {
    size_t index;
    float rgb[3];
} filled_pixel;

typedef struct filling {
    const ibl_map_grid *grid;
    const ibl_image *map;
    const ibl_disc *disc;
    double right[3], up[3]; /* with the disc's centre, an orthonormal frame */
    double edge;            /* radius of the ring of values, projected */
    ring_value *ring;
    int ring_count;
    filled_pixel *pixels;
    size_t count;
} filling;

/* ---- the ring ------------------------------------------------------------ */

static void make_frame(filling *f)
{
    const double *c = f->disc->centre;
    const double axis[3] = {fabs(c[1]) > 0.5, fabs(c[1]) <= 0.5, 0};

    cross3(axis, c, f->right);
    unit3(f->right);
    cross3(c, f->right, f->up);
}

/* Radiance `angle` away from the centre, towards (x, y). */
static const float *read_ring(const filling *f, double angle, double x,
                              double y)
{
    double dir[3];

    for (int c = 0; c < 3; c++)
        dir[c] = cos(angle) * f->disc->centre[c] +
                 sin(angle) * (x * f->right[c] + y * f->up[c]);
    return f->map->data + 3 * ibl_map_pixel(f->grid, dir);
}

static ring_value ring_value_at(const filling *f, double phi)
{
    ring_value v = {cos(phi), sin(phi), {0}};

    for (int k = 0; k < RING_READS; k++) {
        const double pixels =
            ring_from + (ring_to - ring_from) * k / (RING_READS - 1);
        const float *rgb =
            read_ring(f, f->disc->radius + pixels * f->grid->edge, v.x, v.y);
        for (int c = 0; c < 3; c++)
            v.rgb[c] += (double)rgb[c] / RING_READS;
    }
    return v;
}

/* Two values for each pixel along the ring. */
static bool make_ring(filling *f)
{
    const double radius =
        f->disc->radius + 0.5 * (ring_from + ring_to) * f->grid->edge;

    f->edge = tan(0.5 * radius);
    f->ring_count = 16 + (int)(4 * IBL_PI * radius / f->grid->edge);
    f->ring = ibl_alloc_array((size_t)f->ring_count, sizeof *f->ring);
    for (int k = 0; f->ring && k < f->ring_count; k++)
        f->ring[k] = ring_value_at(f, 2 * IBL_PI * k / f->ring_count);
    return f->ring != NULL;
}

/* ---- what is within ------------------------------------------------------ */

static void count_pixel(void *cookie, const ibl_cap_pixel *p)
{
    (void)p;
    ++*(size_t *)cookie;
}

static void fill_pixel(void *cookie, const ibl_cap_pixel *p)
{
    filling *f = cookie;
    const double scale = 1 / ((1 + p->cosine) * f->edge);
    const double x = dot3(p->direction, f->right) * scale;
    const double y = dot3(p->direction, f->up) * scale;
    double sum[3] = {0}, weights = 0;

    for (int k = 0; k < f->ring_count; k++) {
        const ring_value *v = &f->ring[k];
        const double dx = x - v->x, dy = y - v->y;
        const double weight = 1 / (dx * dx + dy * dy);
        for (int c = 0; c < 3; c++)
            sum[c] += weight * v->rgb[c];
        weights += weight;
    }
    filled_pixel *to = &f->pixels[f->count++];
    to->index = p->index;
    for (int c = 0; c < 3; c++)
        to->rgb[c] = (float)(sum[c] / weights);
}

static bool fill(filling *f)
{
    const ibl_disc *d = f->disc;
    size_t count = 0;

    ibl_map_visit_cap(f->grid, d->centre, d->radius, count_pixel, &count);
    f->pixels = ibl_alloc_array(count, sizeof *f->pixels);
    if (!f->pixels || !make_ring(f))
        return false;
    ibl_map_visit_cap(f->grid, d->centre, d->radius, fill_pixel, f);
    return true;
}

/* ---- the light ----------------------------------------------------------- */

static double taken(const filling *f, const filled_pixel *p, int c)
{
    return (double)f->map->data[3 * p->index + (size_t)c] - (double)p->rgb[c];
}

static double solid_angle(const filling *f, const filled_pixel *p)
{
    return f->grid->rows[p->index / (size_t)f->grid->width].solid_angle;
}

/* The light of a channel; if there is none, its pixels stay as they are. */
static double channel_light(filling *f, int c)
{
    double sum = 0;

    for (size_t i = 0; i < f->count; i++)
        sum += taken(f, &f->pixels[i], c) * solid_angle(f, &f->pixels[i]);
    for (size_t i = 0; i < f->count && sum <= 0; i++)
        f->pixels[i].rgb[c] = f->map->data[3 * f->pixels[i].index + (size_t)c];
    return fmax(sum, 0);
}

/* Direction and radius, by luminance. */
static void set_shape(const filling *f, ibl_light *light)
{
    double sum = 0, square = 0;

    for (size_t i = 0; i < f->count; i++) {
        const filled_pixel *p = &f->pixels[i];
        const double y = ibl_luminance(
            (const double[]){taken(f, p, 0), taken(f, p, 1), taken(f, p, 2)});
        double flux[3];
        ibl_map_flux(f->grid, p->index, flux);
        for (int c = 0; c < 3; c++)
            light->direction[c] += y * flux[c];
        sum += y * solid_angle(f, p);
        square += y * y * solid_angle(f, p);
    }
    if (sum > 0 && unit3(light->direction))
        light->radius = ibl_disc_radius(sum * (sum / square));
}

static void write_pixels(const filling *f, ibl_image *map)
{
    for (size_t i = 0; i < f->count; i++)
        for (int c = 0; c < 3; c++)
            map->data[3 * f->pixels[i].index + (size_t)c] = f->pixels[i].rgb[c];
}

ibl_status ibl_disc_take(ibl_ctx *ctx, const ibl_map_grid *grid, ibl_image *map,
                         const ibl_disc *disc, ibl_light *light)
{
    filling f = {.grid = grid, .map = map, .disc = disc};
    ibl_light made = {0};

    make_frame(&f);
    const bool ok = fill(&f);
    if (ok) {
        for (int c = 0; c < 3; c++)
            made.irradiance[c] = channel_light(&f, c);
        set_shape(&f, &made);
        for (int c = 0; c < 3 && made.radius > 0; c++)
            made.radiance[c] =
                made.irradiance[c] / ibl_disc_solid_angle(made.radius);
        if (made.radius > 0)
            write_pixels(&f, map);
    }
    ibl_free(f.ring);
    ibl_free(f.pixels);
    *light = made;
    return ok ? IBL_OK : ibl_no_memory(ctx, "a light of the map");
}
