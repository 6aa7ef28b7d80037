/* SPDX-License-Identifier: MIT */
#include "bake/spectral/point_lights.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "bake/spectral/lobe_table.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "core/vector.h"
#include "image/cube.h"

enum {
    BLOCK = IBL_RADIAL_BLOCK,
    MOST_NODES = 16 /* along one side of a cluster */
};

/* Distance from which a cluster counts as far, in radians, and the share of
 * such texels among those that see it. */
static const double far_away = 0.5;
static const double far_part = 0.88;

/* Largest radius of a cluster of several lights: it is nearly flat. */
static const double widest = 0.25;

/* Cost of visiting a cluster, in points. */
static const double cost_of_cluster = 1;

/* A cap that contains a cluster, or the texels of a block. */
struct cap {
    double centre[3], sine, cosine; /* of a radius up to pi / 2 */
};

/* A part of a list of points. */
struct span {
    int first, count;
};

enum range {
    NEAR,
    FAR
};

struct pixel {
    ibl_patch patch;
    double middle[3], radius;
    struct span points[2]; /* by range */
    bool cut;              /* at the horizon */
};

/* A cluster's frame, and a rectangle in it that contains its points. */
struct frame {
    double axis[3][3]; /* u, v and up */
    double low[2], high[2];
};

/* The points that replace a cluster: at nodes along u and v, or, if there are
 * 0 x 0 nodes, those of its pixels. */
struct stand {
    int nodes[2];
    struct span points;
};

struct cluster {
    struct cap cap;
    struct frame frame;
    struct span pixels;
    struct stand stand[2]; /* by range */
};

struct ibl_point_lights {
    ibl_lobe_shape shape;
    ibl_radial lobe;
    ibl_rule rule; /* along the sides of cut pixels */
    int pixels, clusters, points;
    struct pixel *pixel;
    struct cluster *cluster;
    ibl_radial_light *point; /* of pixels, near and far, then of nodes */
};

/* State during creation. */
struct maker {
    ibl_point_lights *b;
    double reach[2]; /* distance of the lobe's singularities, by range */
    double error;
    ibl_patch_light
        *light; /* the pixels' points, before they are put in order */
    int lights;
};

/* Allows for the rounding of points to floats. */
static const double slack = 1e-6;

static double far_reach_of(const ibl_lobe_shape *shape, double near)
{
    switch (shape->kind) {
    case IBL_LOBE_TAILED:
        return hypot(near, far_away);
    case IBL_LOBE_RING:
        return fmin(near, far_away);
    case IBL_LOBE_COMPACT:
        break;
    }
    return near;
}

/* ---- clusters ---------------------------------------------------------- */

/* Finds a cap around some pixels; returns its radius. */
static double find_cap(const struct pixel *pixel, int count, struct cap *cap)
{
    double radius = 0, least = 1;

    *cap = (struct cap){.sine = 1};
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            cap->centre[k] += pixel[i].middle[k];
    if (!unit3(cap->centre))
        return IBL_PI;
    for (int i = 0; i < count; i++) {
        least = fmin(least, dot3(cap->centre, pixel[i].middle));
        radius = fmax(radius, pixel[i].radius);
    }
    return radius + acos(fmin(fmax(least, -1), 1));
}

static void find_frame(const struct maker *m, struct cluster *c)
{
    struct frame *f = &c->frame;
    double *up = f->axis[2];

    memcpy(up, c->cap.centre, sizeof c->cap.centre);
    const double side[3] = {fabs(up[0]) < 0.6, fabs(up[0]) >= 0.6, 0};
    cross3(side, up, f->axis[0]);
    unit3(f->axis[0]);
    cross3(up, f->axis[0], f->axis[1]);
    for (int k = 0; k < 2; k++) {
        f->low[k] = INFINITY;
        f->high[k] = -INFINITY;
    }
    for (int i = 0; i < c->pixels.count; i++) {
        const struct span *near =
            &m->b->pixel[c->pixels.first + i].points[NEAR];
        for (int j = 0; j < near->count; j++)
            for (int k = 0; k < 2; k++) {
                const double *d = m->light[near->first + j].direction;
                const double at = dot3(f->axis[k], d);
                f->low[k] = fmin(f->low[k], at);
                f->high[k] = fmax(f->high[k], at);
            }
    }
}

/* Chooses the fewer points: those at nodes, or those of the pixels. */
static void plan_stand(const struct maker *m, struct cluster *c,
                       enum range range)
{
    const struct pixel *pixel = m->b->pixel + c->pixels.first;
    struct stand *s = &c->stand[range];
    int n[2];

    *s = (struct stand){.points = {0}};
    for (int i = 0; i < c->pixels.count; i++)
        s->points.count += pixel[i].points[range].count;
    if (c->pixels.count == 1 ||
        (range == NEAR && m->b->shape.kind == IBL_LOBE_RING))
        return;
    for (int k = 0; k < 2; k++) {
        const double extent = c->frame.high[k] - c->frame.low[k];
        n[k] = 1 + (int)fmin(-log(0.1 * m->error) /
                                 asinh(2 * m->reach[range] / extent),
                             MOST_NODES);
    }
    if (n[0] > MOST_NODES || n[1] > MOST_NODES ||
        n[0] * n[1] >= s->points.count)
        return;
    memcpy(s->nodes, n, sizeof n);
    s->points.count = n[0] * n[1];
}

/* Plans a cluster; returns its cost in points that a texel sees on average. */
static double plan_cluster(const struct maker *m, struct cluster *c)
{
    double radius =
        find_cap(m->b->pixel + c->pixels.first, c->pixels.count, &c->cap);

    if (c->pixels.count > 1) {
        const struct frame *f = &c->frame;
        if (radius > widest)
            return INFINITY;
        find_frame(m, c);
        /* Nodes may lie outside the pixels. */
        radius = fmax(radius, asin(hypot(fmax(f->high[0], -f->low[0]),
                                         fmax(f->high[1], -f->low[1]))));
    }
    if (radius < IBL_PI / 2) {
        c->cap.sine = sin(radius);
        c->cap.cosine = cos(radius);
    }
    plan_stand(m, c, NEAR);
    plan_stand(m, c, FAR);
    return cost_of_cluster + (1 - far_part) * c->stand[NEAR].points.count +
           far_part * c->stand[FAR].points.count;
}

static void swap(struct pixel *a, struct pixel *b)
{
    const struct pixel kept = *a;
    *a = *b;
    *b = kept;
}

/* Divides pixels in two at the middle of the longest side of their box; returns
 * the number of pixels in the first part. */
static int divide_pixels(struct pixel *pixel, int count)
{
    double low[3], high[3], longest = -1;
    int side = 0, below = 0;

    for (int k = 0; k < 3; k++) {
        low[k] = high[k] = pixel[0].middle[k];
        for (int i = 1; i < count; i++) {
            low[k] = fmin(low[k], pixel[i].middle[k]);
            high[k] = fmax(high[k], pixel[i].middle[k]);
        }
        if (high[k] - low[k] > longest) {
            longest = high[k] - low[k];
            side = k;
        }
    }
    for (int i = 0; i < count; i++)
        if (pixel[i].middle[side] < 0.5 * (low[side] + high[side]))
            swap(&pixel[i], &pixel[below++]);
    /* Rounding can leave a part empty if all are in one place. */
    return below && below < count ? below : count / 2;
}

/* Appends the cheapest clusters of some pixels; returns their cost. */
static double find_clusters(const struct maker *m, struct span pixels)
{
    ibl_point_lights *b = m->b;
    struct pixel *pixel = b->pixel + pixels.first;
    struct cluster whole = {.pixels = pixels};
    const int before = b->clusters;
    const double cost = plan_cluster(m, &whole);
    double divided = INFINITY;

    if (pixels.count > 1) {
        const int below = divide_pixels(pixel, pixels.count);
        divided = find_clusters(m, (struct span){pixels.first, below}) +
                  find_clusters(m, (struct span){pixels.first + below,
                                                 pixels.count - below});
    }
    if (cost > divided)
        return divided;
    b->clusters = before;
    b->cluster[b->clusters++] = whole;
    return cost;
}

/* ---- points ------------------------------------------------------------ */

static void put_point(const double at[3], const double rgb[3],
                      ibl_radial_light *out)
{
    for (int k = 0; k < 3; k++) {
        out->at[k] = (float)at[k];
        out->rest[k] = (float)(at[k] - (double)out->at[k]);
        out->rgb[k] = (float)rgb[k];
    }
    out->rgb[3] = 0;
}

/* Chebyshev nodes along a side of a cluster, and 1 over the products of their
 * differences, for Lagrange's polynomials. */
struct nodes {
    int count;
    double at[MOST_NODES], factor[MOST_NODES];
};

static void make_side(const struct frame *f, int side, int count,
                      struct nodes *n)
{
    const double low = f->low[side], high = f->high[side];

    n->count = count;
    for (int i = 0; i < count; i++)
        n->at[i] = 0.5 * (low + high) +
                   0.5 * (high - low) * cos(IBL_PI * (i + 0.5) / count);
    for (int i = 0; i < count; i++) {
        double product = 1;
        for (int k = 0; k < count; k++)
            product *= k == i ? 1 : n->at[i] - n->at[k];
        n->factor[i] = 1 / product;
    }
}

static void share_along(const struct nodes *n, double x, double *share)
{
    for (int i = 0; i < n->count; i++) {
        share[i] = n->factor[i];
        for (int k = 0; k < n->count; k++)
            share[i] *= k == i ? 1 : x - n->at[k];
    }
}

/* Adds a light to the nodes of its cluster. */
static void share_out(const struct frame *f, const struct nodes side[2],
                      const ibl_patch_light *light, double (*rgb)[3])
{
    double share[2][MOST_NODES];

    for (int k = 0; k < 2; k++)
        share_along(&side[k], dot3(f->axis[k], light->direction), share[k]);
    for (int i = 0; i < side[0].count; i++)
        for (int j = 0; j < side[1].count; j++, rgb++)
            for (int k = 0; k < 3; k++)
                (*rgb)[k] += share[0][i] * share[1][j] * light->rgb[k];
}

/* Makes the points at nodes. */
static void make_nodes(const struct maker *m, const struct cluster *c,
                       const struct stand *s)
{
    const struct frame *f = &c->frame;
    double rgb[MOST_NODES * MOST_NODES][3] = {{0}};
    struct nodes side[2];

    for (int k = 0; k < 2; k++)
        make_side(f, k, s->nodes[k], &side[k]);
    for (int i = 0; i < c->pixels.count; i++) {
        const struct span *near =
            &m->b->pixel[c->pixels.first + i].points[NEAR];
        for (int k = 0; k < near->count; k++)
            share_out(f, side, &m->light[near->first + k], rgb);
    }
    for (int i = 0; i < s->points.count; i++) {
        const double u = side[0].at[i / side[1].count];
        const double v = side[1].at[i % side[1].count];
        const double up = sqrt(1 - u * u - v * v);
        double d[3];
        for (int k = 0; k < 3; k++)
            d[k] = u * f->axis[0][k] + v * f->axis[1][k] + up * f->axis[2][k];
        put_point(d, rgb[i], &m->b->point[s->points.first + i]);
    }
}

/* Makes the points of the pixels, near and far. */
static ibl_status make_lights(struct maker *m)
{
    const ibl_point_lights *b = m->b;
    ibl_patch_rules rules = {.down = {.count = 0}};
    int next = 0;

    m->lights = 0;
    for (int i = 0; i < 2 * b->pixels; i++) {
        struct pixel *p = &b->pixel[i % b->pixels];
        struct span *points = &p->points[i / b->pixels];
        points->first = m->lights;
        points->count = ibl_patch_points(&p->patch, m->reach[i / b->pixels],
                                         m->error, &rules, NULL);
        m->lights += points->count;
    }
    m->light = ibl_alloc_array((size_t)m->lights, sizeof *m->light);
    for (int i = 0; m->light && i < 2 * b->pixels; i++)
        next += ibl_patch_points(&b->pixel[i % b->pixels].patch,
                                 m->reach[i / b->pixels], m->error, &rules,
                                 m->light + next);
    return m->light ? IBL_OK : IBL_ERR_MEMORY;
}

/* Stores the points of the pixels in the order of clusters. */
static void put_pixels(const struct maker *m)
{
    const ibl_point_lights *b = m->b;
    int next = 0;

    for (int i = 0; i < 2 * b->pixels; i++) {
        struct span *points = &b->pixel[i % b->pixels].points[i / b->pixels];
        const ibl_patch_light *light = m->light + points->first;
        points->first = next;
        for (int k = 0; k < points->count; k++)
            put_point(light[k].direction, light[k].rgb, &b->point[next++]);
    }
}

static ibl_status make_points(const struct maker *m)
{
    ibl_point_lights *b = m->b;

    b->points = m->lights;
    for (int i = 0; i < 2 * b->clusters; i++) {
        struct stand *s = &b->cluster[i / 2].stand[i % 2];
        s->points.first = b->points;
        if (s->nodes[0])
            b->points += s->points.count;
    }
    b->point = ibl_alloc_array((size_t)b->points, sizeof *b->point);
    if (!b->point)
        return IBL_ERR_MEMORY;
    for (int i = 0; i < 2 * b->clusters; i++) {
        const struct cluster *c = &b->cluster[i / 2];
        if (c->stand[i % 2].nodes[0])
            make_nodes(m, c, &c->stand[i % 2]);
    }
    put_pixels(m);
    for (int i = 0; i < 2 * b->clusters; i++) {
        struct cluster *c = &b->cluster[i / 2];
        if (!c->stand[i % 2].nodes[0])
            c->stand[i % 2].points.first =
                b->pixel[c->pixels.first].points[i % 2].first;
    }
    return IBL_OK;
}

static ibl_status make_bright(struct maker *m)
{
    ibl_status status = make_lights(m);

    if (!status && m->b->pixels)
        find_clusters(m, (struct span){0, m->b->pixels});
    if (!status)
        status = make_points(m);
    ibl_free(m->light);
    return status;
}

/* Chooses the pixels that are cut at the horizon. If the lobe ends there with a
 * slope, a patch of radius r whose points are half a turn off misses up to
 * slope r / 4 of its light. */
static void find_cuts(const struct maker *m, double least)
{
    ibl_point_lights *b = m->b;
    /* Phong has no slope at 0 itself. */
    const double slope = 100 * ibl_lobe_value(&b->shape, 0.495, 0.01);
    double largest = 0;

    for (int i = 0; i < b->pixels; i++) {
        struct pixel *p = &b->pixel[i];
        double most = 0;
        for (int c = 0; c < 3; c++)
            most = fmax(most, (double)p->patch.rgb[c]);
        most *= ibl_patch_angle(&p->patch);
        p->cut = 0.25 * slope * p->radius * most * sqrt(b->pixels) > least;
        if (p->cut)
            largest = fmax(largest, fmin(2 * p->radius, ibl_patch_widest));
    }
    if (largest > 0) {
        /* The integral over a cut meridian grows as a square. */
        const int nodes = ibl_rule_nodes(largest, m->reach[NEAR], m->error);
        ibl_rule_make((nodes > 2 ? nodes : 2) + (largest > 0.01), &b->rule);
    }
}

ibl_status ibl_point_lights_create(ibl_ctx *ctx, const ibl_patch *patches,
                                   int count, const ibl_lobe_shape *shape,
                                   double error, double least,
                                   ibl_point_lights **out)
{
    ibl_point_lights *b = *out = ibl_alloc_zeroed(1, sizeof *b);
    struct maker m = {.b = b, .error = error};
    ibl_status status = b ? IBL_OK : IBL_ERR_MEMORY;

    m.reach[NEAR] = 2 * shape->alpha;
    m.reach[FAR] = far_reach_of(shape, m.reach[NEAR]);
    if (b) {
        b->shape = *shape;
        b->pixels = count;
        b->pixel = ibl_alloc_array((size_t)count, sizeof *b->pixel);
        b->cluster = ibl_alloc_array((size_t)count + 1, sizeof *b->cluster);
        status = b->pixel && b->cluster ? IBL_OK : IBL_ERR_MEMORY;
    }
    for (int i = 0; i < count && !status; i++) {
        struct pixel *p = &b->pixel[i];
        *p = (struct pixel){.patch = patches[i]};
        ibl_patch_middle(&patches[i], p->middle);
        p->radius = ibl_patch_radius(&patches[i]);
    }
    if (!status) {
        find_cuts(&m, least);
        status = make_bright(&m);
    }
    if (status)
        status = ibl_no_memory(ctx, "the lights");
    else
        status = ibl_radial_make(ctx, shape, &b->lobe);
    if (status) {
        ibl_point_lights_free(b);
        *out = NULL;
    }
    return status;
}

void ibl_point_lights_free(ibl_point_lights *b)
{
    if (!b)
        return;
    ibl_radial_free(&b->lobe);
    ibl_free(b->pixel);
    ibl_free(b->cluster);
    ibl_free(b->point);
    ibl_free(b);
}

int ibl_point_lights_count(const ibl_point_lights *b)
{
    return b->points;
}

/* ---- texels ------------------------------------------------------------ */

/* A block of texels of a row. */
struct block {
    float point[6 * BLOCK]; /* in the world's axes */
    struct cap cap;
};

static void make_block(int face, const float *point, struct block *block)
{
    const ibl_face_axes *axes = &ibl_face[face];
    const signed char *axis[3] = {axes->forward, axes->right, axes->down};
    double end[2][3];
    struct cap *cap = &block->cap;

    for (int j = 0; j < 3; j++)
        for (int k = 0; k < 3; k++)
            for (int rest = 0; rest < 6 && axis[j][k]; rest += 3)
                for (int i = 0; i < BLOCK; i++)
                    block->point[(k + rest) * BLOCK + i] =
                        axis[j][k] * point[(j + rest) * BLOCK + i];
    for (int k = 0; k < 3; k++) {
        end[0][k] = (double)block->point[k * BLOCK];
        end[1][k] = (double)block->point[(k + 1) * BLOCK - 1];
        cap->centre[k] = end[0][k] + end[1][k];
    }
    /* A row of a face is less than half a great circle. */
    unit3(cap->centre);
    cap->cosine = fmax(dot3(cap->centre, end[0]), 0);
    cap->sine = sqrt(fmax(1 - cap->cosine * cap->cosine, 0));
}

/* Wide blocks get half the sphere, which no horizon leaves out. */
static void make_wide_block(const float *point, struct block *block)
{
    struct cap *cap = &block->cap;

    memcpy(block->point, point, sizeof block->point);
    *cap = (struct cap){.cosine = 1};
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < BLOCK; i++)
            cap->centre[k] += (double)point[k * BLOCK + i];
    if (!(dot3(cap->centre, cap->centre) > 1e-6))
        cap->centre[1] = 1;
    unit3(cap->centre);
    for (int i = 0; i < BLOCK; i++) {
        double cosine = 0;
        for (int k = 0; k < 3; k++)
            cosine += cap->centre[k] * (double)point[k * BLOCK + i];
        cap->cosine = fmax(fmin(cap->cosine, cosine), 0);
    }
    cap->sine = sqrt(fmax(1 - cap->cosine * cap->cosine, 0));
}

static void add_points(const ibl_point_lights *b, const struct span *points,
                       const ibl_radial_dsp *dsp, const struct block *block,
                       float *rgba)
{
    dsp->add(&b->lobe, b->point + points->first, points->count, block->point,
             BLOCK, rgba);
}

/* Replaces the points of a pixel by its exact integral above d's horizon. */
static void cut_pixel(const ibl_point_lights *b, const struct pixel *p,
                      const double d[3], float *rgba)
{
    const double value = ibl_patch_lobe(&p->patch, &b->shape, &b->rule, d);
    const struct span *points = &p->points[FAR];

    for (int k = 0; k < 3; k++)
        rgba[k] += (float)(value * (double)p->patch.rgb[k]);
    for (int i = points->first; i < points->first + points->count; i++) {
        const ibl_radial_light *l = &b->point[i];
        double at[3];
        for (int k = 0; k < 3; k++)
            at[k] = (double)l->at[k] + (double)l->rest[k];
        const double cosine = dot3(d, at);
        const double point =
            ibl_lobe_value(&b->shape, 0.5 - 0.5 * cosine, cosine);
        for (int k = 0; k < 3; k++)
            rgba[k] -= (float)(point * (double)l->rgb[k]);
    }
}

/* Cuts the pixels of a cluster that the horizon of a texel crosses. */
static void cut_cluster(const ibl_point_lights *b, const struct cluster *c,
                        const double d[3], float *rgba)
{
    for (int i = c->pixels.first; i < c->pixels.first + c->pixels.count; i++) {
        const struct pixel *p = &b->pixel[i];
        if (p->cut && fabs(dot3(d, p->middle)) < p->radius)
            cut_pixel(b, p, d, rgba);
    }
}

/* Adds a cluster to texels whose horizons may cross it. If a horizon does, it
 * adds the cluster's pixels instead. */
static void add_crossed(const ibl_point_lights *b, const struct cluster *c,
                        const struct span *points, const ibl_radial_dsp *dsp,
                        const struct block *block, float *rgba)
{
    const struct pixel *first = &b->pixel[c->pixels.first];
    const struct pixel *last = first + c->pixels.count - 1;
    const int from = first->points[FAR].first;
    const int to = last->points[FAR].first + last->points[FAR].count;
    float whole[4 * BLOCK] = {0}, pixels[4 * BLOCK] = {0};
    bool any = false;

    add_points(b, points, dsp, block, whole);
    for (int i = 0; i < BLOCK; i++) {
        const float *sum = whole;
        double d[3];
        for (int k = 0; k < 3; k++)
            d[k] = (double)block->point[k * BLOCK + i] +
                   (double)block->point[(k + 3) * BLOCK + i];
        if (fabs(dot3(d, c->cap.centre)) < c->cap.sine + slack &&
            (c->pixels.count > 1 || first->cut)) {
            if (!any)
                add_points(b, &(struct span){from, to - from}, dsp, block,
                           pixels);
            any = true;
            cut_cluster(b, c, d, pixels + 4 * i);
            sum = pixels;
        }
        for (int k = 0; k < 3; k++)
            rgba[4 * i + k] += sum[4 * i + k];
    }
}

static void add_block(const ibl_point_lights *b, const ibl_radial_dsp *dsp,
                      const struct block *block, float *rgba)
{
    for (int i = 0; i < b->clusters; i++) {
        const struct cluster *cluster = &b->cluster[i];
        const struct cap *x = &block->cap, *y = &cluster->cap;
        const double cosine = dot3(x->centre, y->centre);
        /* Of the sum of the radii. */
        const double s = x->sine * y->cosine + x->cosine * y->sine + slack;
        const double c = x->cosine * y->cosine - x->sine * y->sine;
        const bool far =
            c > 0 && cosine < c * cos(far_away) - s * sin(far_away);
        const struct span *points = &cluster->stand[far ? FAR : NEAR].points;

        if (c > 0 && cosine < -s)
            continue;
        if (c > 0 && cosine > s)
            add_points(b, points, dsp, block, rgba);
        else
            add_crossed(b, cluster, points, dsp, block, rgba);
    }
}

void ibl_point_lights_add(const ibl_point_lights *b, int face,
                          const ibl_radial_dsp *dsp, const float *point,
                          float *rgba)
{
    struct block block;

    make_block(face, point, &block);
    add_block(b, dsp, &block, rgba);
}

void ibl_point_lights_add_at(const ibl_point_lights *b,
                             const ibl_radial_dsp *dsp, const float *point,
                             float *rgba)
{
    struct block block;

    make_wide_block(point, &block);
    add_block(b, dsp, &block, rgba);
}
