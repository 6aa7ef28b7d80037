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
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "core/vector.h"

/* Where the values of the circle are read, in pixels beyond it. The first is
 * far enough that no pixel within the circle is read. */
static const double ring_from = 0.75, ring_to = 1.25;
/* Of a light, its mean square distance from the middle over that of a disc;
 * that of lights which are surely several; and the least share of a part in
 * what is divided. */
static const double most_spread = 1.1, several = 1.7, least_part = 1.0 / 16;
enum {
    RING_READS = 3, /* pixels from there to there, for each value */
    GATHER_STEPS = 8
};

typedef struct ring_value {
    double x, y; /* on the unit circle */
    double rgb[3];
} ring_value;

typedef struct filled_pixel {
    size_t index;
    double solid_angle, x, y; /* as those of the ring */
    float rgb[3];
    int part;
} filled_pixel;

typedef struct part {
    double at[2]; /* its middle, as the pixels' x and y */
    double light, square, sum[2], distance2; /* the last three by square */
} part;

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
    part part[IBL_MAX_LIGHTS];
} filling;

/* ---- the ring ------------------------------------------------------------ */

static ring_value ring_value_at(const filling *f, double phi)
{
    ring_value v = {cos(phi), sin(phi), {0}};
    double dir[3];

    for (int k = 0; k < RING_READS; k++) {
        const double pixels =
            ring_from + (ring_to - ring_from) * k / (RING_READS - 1);
        const double angle = f->disc->radius + pixels * f->grid->edge;
        for (int c = 0; c < 3; c++)
            dir[c] = cos(angle) * f->disc->centre[c] +
                     sin(angle) * (v.x * f->right[c] + v.y * f->up[c]);
        const float *rgb = f->map->data + 3 * ibl_map_pixel(f->grid, dir);
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
    *to = (filled_pixel){p->index, p->row->solid_angle, x, y, {0}, 0};
    for (int c = 0; c < 3; c++)
        to->rgb[c] = (float)(sum[c] / weights);
}

static bool fill(filling *f)
{
    const ibl_disc *d = f->disc;
    const double *c = d->centre;
    const double axis[3] = {fabs(c[1]) > 0.5, fabs(c[1]) <= 0.5, 0};
    size_t count = 0;

    cross3(axis, c, f->right);
    unit3(f->right);
    cross3(c, f->right, f->up);
    ibl_map_visit_cap(f->grid, d->centre, d->radius, count_pixel, &count);
    f->pixels = ibl_alloc_array(count, sizeof *f->pixels);
    if (!f->pixels || !make_ring(f))
        return false;
    ibl_map_visit_cap(f->grid, d->centre, d->radius, fill_pixel, f);
    return true;
}

/* ---- the lights ---------------------------------------------------------- */

static double taken(const filling *f, const filled_pixel *p, int c)
{
    return (double)f->map->data[3 * p->index + (size_t)c] - (double)p->rgb[c];
}

static double distance2(const filled_pixel *p, const part *to)
{
    const double x = p->x - to->at[0], y = p->y - to->at[1];
    return x * x + y * y;
}

static double luminance_taken(const filling *f, const filled_pixel *p)
{
    return ibl_luminance(
        (const double[]){taken(f, p, 0), taken(f, p, 1), taken(f, p, 2)});
}

/* Makes parts of the pixels that are nearest to the middle of each, and moves
 * the middles to those of the squared radiance, by which glow hardly counts. */
static void gather(filling *f, int parts)
{
    for (int step = 0; step < GATHER_STEPS; step++) {
        for (int k = 0; k < parts; k++)
            f->part[k] = (part){.at = {f->part[k].at[0], f->part[k].at[1]}};
        for (filled_pixel *p = f->pixels; p < f->pixels + f->count; p++) {
            const double y = fmax(luminance_taken(f, p), 0);
            const double square = y * y * p->solid_angle;
            p->part = 0;
            for (int k = 1; k < parts; k++)
                if (distance2(p, &f->part[k]) < distance2(p, &f->part[p->part]))
                    p->part = k;
            part *to = &f->part[p->part];
            to->light += y * p->solid_angle;
            to->square += square;
            to->sum[0] += square * p->x;
            to->sum[1] += square * p->y;
            to->distance2 += square * (p->x * p->x + p->y * p->y);
        }
        for (part *k = f->part; k < f->part + parts; k++)
            for (int c = 0; c < 2 && k->square > 0; c++)
                k->at[c] = k->sum[c] / k->square;
    }
}

/* Square of the radius of a disc as far spread: twice the mean square of the
 * distance from the middle. A unit of the plane is twice the edge in radians.
 */
static double spread2(const filling *f, const part *p)
{
    return 8 * f->edge * f->edge *
           (p->distance2 / p->square - p->at[0] * p->at[0] -
            p->at[1] * p->at[1]);
}

/*
 * Divides what is more spread than a light, in at most so many: of which it
 * leaves some for others unless they are surely several. A new part begins at
 * the brightest far pixel. Returns how many.
 */
static int divide(filling *f, int most, int others)
{
    int parts = 1;

    gather(f, 1);
    for (int i = 0; i < parts && parts < most;) {
        const part all = f->part[i];
        const double radius2 = all.light * (all.light / all.square) / IBL_PI;
        double far = 0;
        const double limit = parts < most - others ? most_spread : several;
        if (!(spread2(f, &all) > limit * radius2)) {
            i++;
            continue;
        }
        for (const filled_pixel *p = f->pixels; p < f->pixels + f->count; p++) {
            const double y = luminance_taken(f, p);
            const double here = y * y * p->solid_angle * distance2(p, &all);
            if (p->part == i && y > 0 && here > far) {
                far = here;
                f->part[parts].at[0] = p->x;
                f->part[parts].at[1] = p->y;
            }
        }
        gather(f, parts + 1);
        if (f->part[parts].light >= least_part * all.light) {
            parts++;
        } else {
            gather(f, parts);
            i++;
        }
    }
    return parts;
}

/* The light of a channel of a part; if there is none, its pixels stay as they
 * are. */
static double channel_light(filling *f, int k, int c)
{
    double sum = 0;

    for (const filled_pixel *p = f->pixels; p < f->pixels + f->count; p++)
        sum += p->part == k ? taken(f, p, c) * p->solid_angle : 0;
    for (filled_pixel *p = f->pixels; p < f->pixels + f->count && sum <= 0; p++)
        if (p->part == k)
            p->rgb[c] = f->map->data[3 * p->index + (size_t)c];
    return fmax(sum, 0);
}

/* A part as a light. False: it has none, and its pixels stay as they are. */
static bool make_light(filling *f, int k, ibl_light *light)
{
    double sum = 0, square = 0;

    *light = (ibl_light){.radius = 0};
    for (int c = 0; c < 3; c++)
        light->irradiance[c] = channel_light(f, k, c);
    for (const filled_pixel *p = f->pixels; p < f->pixels + f->count; p++) {
        const double y = p->part == k ? luminance_taken(f, p) : 0;
        double flux[3];
        ibl_map_flux(f->grid, p->index, flux);
        for (int c = 0; c < 3; c++)
            light->direction[c] += y * flux[c];
        sum += y * p->solid_angle;
        square += y * y * p->solid_angle;
    }
    if (sum > 0 && unit3(light->direction)) {
        const double wide2 = spread2(f, &f->part[k]);
        light->radius = ibl_disc_radius(sum * (sum / square));
        if (wide2 > most_spread * light->radius * light->radius)
            light->radius = fmax(light->radius, fmin(sqrt(wide2), 0.1));
    }
    for (int c = 0; c < 3 && light->radius > 0; c++)
        light->radiance[c] =
            light->irradiance[c] / ibl_disc_solid_angle(light->radius);
    return light->radius > 0;
}

ibl_status ibl_disc_take(ibl_ctx *ctx, const ibl_map_grid *grid, ibl_image *map,
                         const ibl_disc *disc, int most, int others,
                         ibl_light *lights, int *count)
{
    filling f = {.grid = grid, .map = map, .disc = disc};
    const bool ok = fill(&f);
    const int parts = ok ? divide(&f, most - *count, others) : 0;
    for (int k = 0; k < parts; k++) {
        if (!make_light(&f, k, &lights[*count]))
            continue;
        ++*count;
        for (const filled_pixel *p = f.pixels; p < f.pixels + f.count; p++)
            for (size_t c = 0; c < 3 && p->part == k; c++)
                map->data[3 * p->index + c] = p->rgb[c];
    }
    ibl_free(f.ring);
    ibl_free(f.pixels);
    return ok ? IBL_OK : ibl_no_memory(ctx, "a light of the map");
}
