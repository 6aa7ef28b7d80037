/* SPDX-License-Identifier: MIT */
/*
 * GGX as a function of the angle has its nearest singularities 2 alpha i from
 * the peak, and from a texel that is d away their distance is
 * hypot(2 alpha, d). n points leave rho^-2n of an integral over a length e,
 * with rho = r + sqrt(1 + r^2), r = 2 reach / e (the largest ellipse around the
 * interval without a singularity). Phong is about a Gaussian of that width.
 */
#include "bake/spectral/point_lights.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "core/vector.h"
#include "kern/brdf_quadrature.h"

enum {
    BLOCK = IBL_RADIAL_BLOCK,
    GROUP = 16,      /* lights */
    MOST_NODES = 16, /* along a side of a pixel */
    KINK = 6,
    MOST_PARTS = 12,
    MOST_LIGHTS = 4096 /* that may come of splitting pixels */
};

/* For texels to which it is near, far, on the horizon, or below it. */
enum range {
    NEAR,
    FAR,
    CUT,
    RANGES,
    BELOW = RANGES
};

/* From here on, in radii of a pixel, a texel is far from it: the variance of
 * the light is enough for GGX, to 2e-5. */
static const double far_away = 20;

/* Most distance of a group's lights from its first. */
static const double most_apart = 0.05;

/* Sides of the parts of a pixel that the horizon may cut: flat, and the lobe is
 * about linear over them. */
static const double flat = 0.0062;

typedef float block __attribute__((vector_size(4 * BLOCK)));

/* Allows for the rounding of points to floats. */
static const double slack = 1e-6;

struct light {
    ibl_patch patch;
    double middle[3];
    double angle[2]; /* up to which it is near, and its radius */
    int nodes[RANGES][2];
};

/* Lights that lie close together are near, far or cut together. */
struct group {
    double middle[3];
    double sine[2], cosine[2]; /* of the angles that hold its lights' */
    int lights, first[RANGES]; /* how many, and its points */
};

struct ibl_point_lights {
    ibl_radial lobe;
    int count;
    struct group *group;     /* count, and one more: the points' end */
    ibl_radial_light *point; /* all FAR, then all NEAR, then all CUT */
};

/* Nodes that keep the relative error of an integral over a length `extent`. One
 * misses (extent / reach)^2 2/3 of a function that falls as the fourth power of
 * the distance. */
static int nodes_of(double extent, double reach, double error)
{
    const int least = extent * extent * 2 > 3 * error * reach * reach ? 2 : 1;
    const double left = -log(fmin(0.06 * error, 0.1));
    const double n = ceil(0.5 * left / asinh(2 * reach / extent));
    return (int)fmin(fmax(n, least), MOST_NODES);
}

/* Writes down x across points. */
static void put_points(const ibl_patch *p, const int nodes[2],
                       ibl_radial_light *out)
{
    const int down = nodes[0], across = nodes[1];
    const double middle = 0.5 * (p->theta[0] + p->theta[1]);
    const double height = p->theta[1] - p->theta[0];
    /* A product without cancellation. */
    const double angle = 2 * p->width * sin(middle) * sin(0.5 * height);
    double y[MOST_NODES], x[MOST_NODES], row[MOST_NODES], mass[MOST_NODES];
    /* Sides of the rectangle of its variance. */
    const double shift = height * height / 12 / tan(middle);
    const double tall = sqrt(height * height / 12 - shift * shift) * sqrt(3);
    const double wide =
        0.5 * p->width * sqrt(0.5) * hypot(sin(p->theta[0]), sin(p->theta[1]));
    double sum = 0;

    ibl_gauss_points(down, y, row);
    ibl_gauss_points(across, x, mass);
    for (int j = 0; j < down; j++) {
        y[j] = p->theta[0] + height * y[j];
        /* A single point is the centroid, on a parallel that of its arc. */
        if (down == 1)
            y[j] += (1 - 0.5 * height / tan(0.5 * height)) / tan(middle);
        row[j] *= sin(y[j]);
        sum += row[j];
        if (across == 1)
            y[j] = atan2(sin(y[j]) * sin(0.5 * p->width) / (0.5 * p->width),
                         cos(y[j]));
    }
    for (int j = 0; j < down; j++)
        for (int i = 0; i < across; i++, out++) {
            const double phi = p->phi + p->width * (x[i] - 0.5);
            const double at[3] = {sin(y[j]) * cos(phi), cos(y[j]),
                                  sin(y[j]) * sin(phi)};
            const bool alone = down == 1 && across == 1;
            const double side[2][3] = {{tall * cos(y[j]) * cos(phi),
                                        -tall * sin(y[j]),
                                        tall * cos(y[j]) * sin(phi)},
                                       {-wide * sin(phi), 0, wide * cos(phi)}};
            for (int k = 0; k < 3; k++) {
                out->at[k] = (float)at[k];
                out->rest[k] = (float)(at[k] - (double)out->at[k]);
                out->rgb[k] =
                    (float)((double)p->rgb[k] * angle * row[j] / sum * mass[i]);
                out->side[0][k] = alone ? (float)side[0][k] : 0;
                out->side[1][k] = alone ? (float)side[1][k] : 0;
            }
            out->rgb[3] = alone ? (float)((tall * tall + wide * wide) / 3) : 0;
        }
}

/* Part k of parts[0] x parts[1] of a pixel. */
static ibl_patch part_of(const ibl_patch *p, const int parts[2], int k)
{
    const double height = (p->theta[1] - p->theta[0]) / parts[0];
    ibl_patch part = *p;

    part.theta[0] += height * (k / parts[1]);
    part.theta[1] = part.theta[0] + height;
    part.width /= parts[1];
    part.phi += part.width * (k % parts[1] + 0.5) - 0.5 * p->width;
    return part;
}

static void plan(const ibl_lobe_shape *shape, double error, struct light *l)
{
    const ibl_patch *p = &l->patch;
    const double middle = 0.5 * (p->theta[0] + p->theta[1]);
    const double side[2] = {p->theta[1] - p->theta[0], p->width * sin(middle)};
    const double radius = 0.5 * hypot(side[0], side[1]);
    const bool ggx = shape->lobe == IBL_LOBE_GGX;
    const double reach = 2 * shape->alpha;
    const double taper = 2 * side[0] / fabs(tan(middle)); /* at a pole */

    l->middle[0] = sin(middle) * cos(p->phi);
    l->middle[1] = cos(middle);
    l->middle[2] = sin(middle) * sin(p->phi);
    l->angle[0] = ggx ? fmin(far_away * radius, 1) : 6 * radius;
    l->angle[1] = radius;
    for (int k = 0; k < 2; k++) {
        const int nodes = nodes_of(side[k], reach, error);
        /* Charlie may have a kink in its middle. */
        l->nodes[NEAR][k] =
            shape->lobe == IBL_LOBE_CHARLIE && nodes < KINK ? KINK : nodes;
        l->nodes[FAR][k] = ggx ? 1 : nodes;
        l->nodes[CUT][k] =
            (int)fmin(ceil(fmax(side[k] / flat, k ? 0 : taper)), MOST_PARTS);
    }
}

/* Makes a group of the first lights. */
static void make_group(const struct light *l, int count, struct group *g)
{
    double angle[2] = {0};

    *g = (struct group){0};
    while (g->lights < count && g->lights < GROUP &&
           distance3(l[0].middle, l[g->lights].middle) <= most_apart) {
        for (int k = 0; k < 3; k++)
            g->middle[k] += l[g->lights].middle[k];
        g->lights++;
    }
    unit3(g->middle);
    for (int i = 0; i < g->lights; i++)
        for (int k = 0; k < 2; k++)
            angle[k] = fmax(angle[k],
                            2 * asin(0.5 * distance3(g->middle, l[i].middle)) +
                                l[i].angle[k]);
    for (int k = 0; k < 2; k++) {
        g->sine[k] = sin(angle[k]);
        g->cosine[k] = cos(angle[k]);
    }
}

/* Writes down the points of a light for a range and returns their number. */
static int put_range(const struct light *l, enum range range,
                     ibl_radial_light *out)
{
    static const int one[2] = {1, 1};
    const int *nodes = l->nodes[range], count = nodes[0] * nodes[1];

    if (range != CUT)
        put_points(&l->patch, nodes, out);
    for (int k = 0; k < count && range == CUT; k++) {
        const ibl_patch part = part_of(&l->patch, nodes, k);
        put_points(&part, one, out + k);
    }
    return count;
}

ibl_status ibl_point_lights_create(ibl_ctx *ctx, const ibl_patch *patches,
                                   int count, const ibl_lobe_shape *shape,
                                   double error, ibl_point_lights **out)
{
    ibl_point_lights *p = *out = ibl_alloc_zeroed(1, sizeof *p);
    /* Pixels that are too large for MOST_NODES are lights in parts. */
    const double most = fmax(floor(sqrt((double)MOST_LIGHTS / count)), 1);
    int points = 0, split = 1;

    for (int i = 0; i < count; i++) {
        const double height = patches[i].theta[1] - patches[i].theta[0];
        split = (int)fmax(split, ceil(height / (8 * shape->alpha)));
    }
    split = (int)fmin(split, most);
    const int parts[2] = {split, split}, lights = count * split * split;
    struct light *light = ibl_alloc_array((size_t)lights, sizeof *light);
    if (p)
        p->group = ibl_alloc_array((size_t)lights + 1, sizeof *p->group);
    if (!p || !p->group || !light)
        goto fail;
    p->lobe = ibl_radial_of(shape);
    for (int i = 0; i < lights; i++) {
        light[i].patch =
            part_of(&patches[i / (split * split)], parts, i % (split * split));
        plan(shape, error, &light[i]);
        for (int r = 0; r < RANGES; r++)
            points += light[i].nodes[r][0] * light[i].nodes[r][1];
    }
    p->point = ibl_alloc_array((size_t)points, sizeof *p->point);
    if (!p->point)
        goto fail;
    for (int i = 0; i < lights; i += p->group[p->count++].lights)
        make_group(light + i, lights - i, &p->group[p->count]);
    p->group[p->count].lights = 0;
    points = 0;
    for (int r = 0; r < RANGES; r++) {
        const struct light *l = light;
        for (int i = 0; i <= p->count; i++) {
            struct group *g = &p->group[i];
            g->first[r] = points;
            for (int k = 0; k < g->lights; k++)
                points += put_range(l++, r, p->point + points);
        }
    }
    ibl_free(light);
    return IBL_OK;
fail:
    ibl_free(light);
    ibl_point_lights_free(p);
    *out = NULL;
    return ibl_no_memory(ctx, "the lights");
}

void ibl_point_lights_free(ibl_point_lights *p)
{
    if (!p)
        return;
    ibl_free(p->group);
    ibl_free(p->point);
    ibl_free(p);
}

/* A cap on the sphere. */
struct cap {
    double centre[3], cosine, sine;
};

/* Around BLOCK directions from one in their middle, at most half the sphere. */
static struct cap cap_of(const float *point, int stride)
{
    struct cap cap;
    float cosine = 1;
    block d[3], along;

    for (int k = 0; k < 3; k++) {
        memcpy(&d[k], point + k * stride, sizeof d[k]);
        cap.centre[k] = (double)d[k][BLOCK / 2];
    }
    along = d[0][BLOCK / 2] * d[0] + d[1][BLOCK / 2] * d[1] +
            d[2][BLOCK / 2] * d[2];
    for (int i = 0; i < BLOCK; i++)
        cosine = along[i] < cosine ? along[i] : cosine;
    cap.cosine = fmax((double)cosine, 0);
    cap.sine = sqrt(1 - cap.cosine * cap.cosine);
    return cap;
}

static enum range range_of(const struct group *g, const struct cap *cap)
{
    const double c = dot3(cap->centre, g->middle);
    const double *sine = g->sine, *cosine = g->cosine;

    /* Both together may reach around a quarter of the sphere. */
    if (cap->cosine * cosine[1] <= cap->sine * sine[1] + slack ||
        fabs(c) <= cap->sine * cosine[1] + cap->cosine * sine[1] + slack)
        return CUT;
    return c < 0                                               ? BELOW
           : c > cap->cosine * cosine[0] - cap->sine * sine[0] ? NEAR
                                                               : FAR;
}

void ibl_point_lights_add(const ibl_point_lights *p, const ibl_radial_dsp *dsp,
                          const float *point, int stride, float *rgba)
{
    const struct cap cap = cap_of(point, stride);
    const struct group *end = p->group + p->count, *g = p->group;

    while (g < end) {
        const enum range range = range_of(g, &cap);
        const struct group *from = g;
        while (++g < end && range_of(g, &cap) == range)
            continue;
        if (range == BELOW)
            continue;
        const int first = from->first[range];
        (range == NEAR  ? dsp->add
         : range == FAR ? dsp->add_far
                        : dsp->add_cut)(&p->lobe, p->point + first,
                                        g->first[range] - first, point, stride,
                                        rgba);
    }
}
