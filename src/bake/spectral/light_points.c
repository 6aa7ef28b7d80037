/* SPDX-License-Identifier: MIT */
/*
 * Bright pixels, which are patches, as point lights: the points of Gauss and
 * Legendre along theta and phi.
 *
 * GGX as a function of the angle has its nearest singularities 2 alpha i from
 * the peak, and n points leave rho^-2n of an integral over a length e, with
 * rho = r + sqrt(1 + r^2), r = 4 alpha / e (the largest ellipse around the
 * interval without a singularity). Phong is about a Gaussian, and the far part
 * of a lobe a smooth function, of that width.
 */
#include <math.h>
#include <stdbool.h>

#include "bake/spectral/state.h"
#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"

enum {
    MAX_POINTS = 66 /* along one side */
};

/* The horizon has bends of its own in what is wider. */
static const double widest = 0.4;

typedef struct rule {
    int count;
    double node[MAX_POINTS], mass[MAX_POINTS]; /* on -1..1, masses sum to 2 */
} rule;

/* Gauss and Legendre, by Newton's method. */
static void make_rule(int n, rule *r)
{
    r->count = n;
    for (int i = 0; i < n; i++) {
        double x = cos(IBL_PI * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 8; step++) {
            double p = 1, below = 0;
            for (int l = 0; l < n; l++) {
                const double next = ((2 * l + 1) * x * p - l * below) / (l + 1);
                below = p;
                p = next;
            }
            slope = n * (x * p - below) / (x * x - 1);
            x -= p / slope;
        }
        r->node[i] = x;
        r->mass[i] = 2 / ((1 - x * x) * slope * slope);
    }
}

/* The square of the distance from which one does, or less than 0: GGX changes
 * over hypot(2 alpha, distance), and falls as the fourth power of that; a point
 * misses (extent / that)^2 2/3. */
static double one_point_square(double extent, const ibl_light_target *t)
{
    return extent * extent * 2 / (3 * t->error) -
           4 * t->shape->alpha * t->shape->alpha;
}

static int points_for(double extent, const ibl_light_target *t)
{
    const ibl_lobe_shape *shape = t->shape;
    const double left = -log(fmin(0.6 * t->error, 0.1));
    const int least =
        t->error < 1e-3 || one_point_square(extent, t) > 0 ? 2 : 1;
    double size = shape->alpha;
    if (shape->split > 0)
        size = fmax(size, 1 / sqrt(shape->split));
    const double n = fmax(ceil(0.5 * left / asinh(4 * size / extent)), least);
    return n < MAX_POINTS - 2 ? (int)n : MAX_POINTS - 2;
}

/* Along theta and phi, as the light before had them. */
typedef struct rules {
    rule rows, columns;
} rules;

/* Points of a light; NULL: only counts them. */
static int add_points(const ibl_spectral *s, const ibl_pixel_light *l,
                      const ibl_light_target *t, double whole, rules *kept,
                      ibl_light *out)
{
    const double height = IBL_PI / s->height, width = 2 * IBL_PI / s->width;
    const double theta = height * (l->row + 0.5);
    const int down = points_for(height, t);
    const int across = points_for(width * sin(theta), t);
    const double phi = ibl_spectral_azimuth(s, l);
    rule *rows = &kept->rows, *columns = &kept->columns;

    if (!out)
        return down * across;
    if (rows->count != down)
        make_rule(down, rows);
    if (columns->count != across)
        make_rule(across, columns);
    double sum = 0;
    for (int j = 0; j < down; j++)
        sum += rows->mass[j] * sin(theta + 0.5 * height * rows->node[j]);
    for (int j = 0; j < down; j++) {
        const double at = theta + 0.5 * height * rows->node[j];
        for (int i = 0; i < across; i++, out++) {
            const double azimuth = phi + 0.5 * width * columns->node[i];
            const double share = whole * s->weight[l->row] * rows->mass[j] *
                                 sin(at) / sum * columns->mass[i] / 2;
            out->direction[0] = sin(at) * cos(azimuth);
            out->direction[1] = cos(at);
            out->direction[2] = sin(at) * sin(azimuth);
            for (int c = 0; c < 3; c++)
                out->energy[c] = (float)((double)l->rgb[c] * share);
        }
    }
    return down * across;
}

/* The points of all lights, the first of light i at first[i]. */
typedef struct all_points {
    ibl_light *light;
    int *first; /* and one more */
} all_points;

static void free_points(all_points *p)
{
    ibl_free(p->light);
    ibl_free(p->first);
}

static ibl_status make_points(const ibl_spectral *s, const ibl_light_target *t,
                              double whole, all_points *out)
{
    const int lights = s->light_count;
    rules kept = {.rows = {.count = 0}};
    *out = (all_points){0};
    out->first = ibl_alloc_array((size_t)lights + 1, sizeof *out->first);
    if (!out->first)
        return ibl_no_memory(s->ctx, "the lights");
    out->first[0] = 0;
    for (int i = 0; i < lights; i++)
        out->first[i + 1] =
            out->first[i] + add_points(s, &s->lights[i], t, whole, &kept, NULL);
    out->light =
        ibl_alloc_array((size_t)out->first[lights], sizeof *out->light);
    if (!out->light) {
        free_points(out);
        return ibl_no_memory(s->ctx, "the lights");
    }
    for (int i = 0; i < lights; i++)
        add_points(s, &s->lights[i], t, whole, &kept,
                   out->light + out->first[i]);
    return IBL_OK;
}

/* The distance from which one point does. Charlie and Phong fall much faster.
 * It is nowhere or far above the horizon, farther than a block of texels on
 * faces of n is long. */
static double one_point_from(const ibl_spectral *s, const ibl_light_target *t)
{
    const double extent = fmax(IBL_PI / s->height, 2 * IBL_PI / s->width);
    const double square = one_point_square(extent, t);

    if (t->shape->lobe != IBL_LOBE_GGX || square > 0.5 || extent > 0.01 ||
        t->n < 32)
        return INFINITY;
    return sqrt(fmax(square, 0));
}

ibl_status ibl_spectral_bright(const ibl_spectral *s, const ibl_light_target *t,
                               double whole, ibl_bright **out)
{
    all_points points;
    ibl_status status = make_points(s, t, whole, &points);
    *out = NULL;
    if (status)
        return status;
    status = ibl_bright_create(s->ctx, points.light, points.first,
                               s->light_count, one_point_from(s, t), out);
    free_points(&points);
    return status;
}

/* ---- lights on the horizon ---------------------------------------------- */

/* The texels of a level that are corrected. */
struct horizon {
    const ibl_spectral *s;
    const ibl_light_target *target;
    all_points points;
    struct cap *caps; /* of each light */
    int down, across; /* patches that a large one is divided into */
    rule rule;
    float *local;
};

/* What holds a light's patch. */
struct cap {
    double centre[3], sine; /* of its radius */
    double corner[4][3];
    double bulge; /* of its parallels, beyond what joins its corners */
    const ibl_light *points; /* of those that stand for it there */
    int count;
    ibl_light middle;
};

static void set_cap(struct horizon *h, int light)
{
    const ibl_spectral *s = h->s;
    const ibl_pixel_light *l = &s->lights[light];
    const double height = IBL_PI / s->height, width = 2 * IBL_PI / s->width;
    const double theta = height * (l->row + 0.5);
    const double phi = ibl_spectral_azimuth(s, l);
    const ibl_light *points = h->points.light + h->points.first[light];
    const int count = h->points.first[light + 1] - h->points.first[light];
    /* Along a parallel, then along a meridian. */
    const double radius =
        0.5 * height + 0.5 * width * sin(theta) * (1 + 0.5 * height);
    struct cap *cap = &h->caps[light];

    *cap = (struct cap){
        .centre = {sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi)},
        .sine = radius < 1 ? sin(radius) : 2,
        .points = points,
        .count = count,
        .middle = ibl_light_middle(points, count)};
    cap->bulge = width < 0.5 ? width * width / 8 : 2;
    for (int k = 0; k < 4; k++) {
        const double at = height * (l->row + k / 2);
        const double azimuth = phi + (k % 2 - 0.5) * width;
        cap->corner[k][0] = sin(at) * cos(azimuth);
        cap->corner[k][1] = cos(at);
        cap->corner[k][2] = sin(at) * sin(azimuth);
    }
    if (isfinite(one_point_from(s, h->target))) {
        cap->points = &cap->middle;
        cap->count = 1;
    }
}

/* A light's patch, its azimuth seen from a texel. */
struct patch {
    double theta[2], delta, width;
};

/* int K sin(theta) dtheta along a meridian, above the horizon only, which a
 * meridian crosses once. */
static double meridian_sum(const struct horizon *h, const double d[3],
                           const struct patch *p, double delta)
{
    const double sine = hypot(d[0], d[2]);
    const double bound = d[1] > 0 ? atan2(d[1], -sine * cos(delta))
                                  : atan2(-d[1], sine * cos(delta));
    double from = p->theta[0], to = p->theta[1], sum = 0;

    /* The pole at theta = 0 is above the horizon, or the other one. */
    if (d[1] > 0)
        to = fmin(fmax(bound, from), to);
    else
        from = fmax(fmin(bound, to), from);
    for (int k = 0; k < h->rule.count; k++) {
        const double theta =
            0.5 * (from + to) + 0.5 * (to - from) * h->rule.node[k];
        const double cosine =
            cos(theta) * d[1] + sin(theta) * sine * cos(delta);
        sum += h->rule.mass[k] * sin(theta) *
               ibl_lobe_value(h->target->shape, 0.5 - 0.5 * cosine, cosine);
    }
    return 0.5 * (to - from) * sum;
}

/* Where the horizon crosses the rows' edges, between azimuths: the sum over a
 * meridian has corners there. From falls back to `from`. Sorted; returns how
 * many there are. */
static int corners(const double d[3], const struct patch *p, double out[6])
{
    const double sine = hypot(d[0], d[2]);
    const double from = p->delta - 0.5 * p->width;
    int count = 0;

    out[count++] = from;
    for (int i = 0; i < 2; i++) {
        const double cosine =
            -cos(p->theta[i]) * d[1] / (sin(p->theta[i]) * sine);
        for (int k = -1; fabs(cosine) < 1 && k <= 1; k += 2) {
            const double at = k * acos(cosine) - from;
            const double past = at - 2 * IBL_PI * floor(at / (2 * IBL_PI));
            if (past < p->width)
                out[count++] = from + past;
        }
    }
    out[count++] = from + p->width;
    for (int i = 1; i < count; i++)
        for (int k = i; k > 0 && out[k] < out[k - 1]; k--) {
            const double swap = out[k];
            out[k] = out[k - 1];
            out[k - 1] = swap;
        }
    return count;
}

static double patch_sum(const struct horizon *h, const double d[3],
                        const struct patch *p)
{
    double at[6], sum = 0;
    const int count = corners(d, p, at);
    for (int i = 1; i < count; i++) {
        const double half = 0.5 * (at[i] - at[i - 1]);
        for (int k = 0; half > 0 && k < h->rule.count; k++)
            sum += half * h->rule.mass[k] *
                   meridian_sum(h, d, p, at[i] - half + half * h->rule.node[k]);
    }
    return sum;
}

static double point_value(const struct horizon *h, const double d[3],
                          const double at[3])
{
    const double cosine = d[0] * at[0] + d[1] * at[1] + d[2] * at[2];
    return ibl_lobe_value(h->target->shape, 0.5 - 0.5 * cosine, cosine);
}

/* What the points of a light lack in a direction. */
static void correct(const struct horizon *h, int light, const double d[3],
                    float *rgb)
{
    const ibl_spectral *s = h->s;
    const ibl_pixel_light *l = &s->lights[light];
    const struct cap *cap = &h->caps[light];
    const double height = IBL_PI / s->height / h->down;
    const double width = 2 * IBL_PI / s->width / h->across;
    const double delta = ibl_spectral_azimuth(s, l) - atan2(d[2], d[0]);
    double exact = 0;

    for (int j = 0; j < h->down; j++)
        for (int i = 0; i < h->across; i++) {
            const int row = l->row * h->down + j;
            const struct patch p = {
                .theta = {height * row, height * (row + 1)},
                .delta = delta + (i + 0.5 - 0.5 * h->across) * width,
                .width = width};
            exact += patch_sum(h, d, &p);
        }
    for (int c = 0; c < 3; c++) {
        double sum = exact * (double)l->rgb[c];
        for (int k = 0; k < cap->count; k++)
            sum -= (double)cap->points[k].energy[c] *
                   point_value(h, d, cap->points[k].direction);
        rgb[c] += (float)sum;
    }
}

/* Whether the horizon crosses a light's patch. */
static bool is_crossed(const struct cap *cap, const double d[3])
{
    bool above = false, below = false;

    for (int k = 0; k < 4; k++) {
        const double *at = cap->corner[k];
        const double cosine = d[0] * at[0] + d[1] * at[1] + d[2] * at[2];
        above |= cosine > -cap->bulge;
        below |= cosine < cap->bulge;
    }
    return above && below;
}

/* The texels first..last - 1 of a row whose horizon may cross a cap: unscaled
 * directions are linear in x, and at most sqrt(3) long. */
static void find_near(const struct horizon *h, int job, const struct cap *cap,
                      int *first, int *last)
{
    const ibl_face_axes *axes = &ibl_face[job / h->target->n];
    const double down =
        (2 * (job % h->target->n) + 1) / (double)h->target->n - 1;
    const double right = ibl_face_along(axes->right, cap->centre);
    const double middle = ibl_face_along(axes->forward, cap->centre) +
                          down * ibl_face_along(axes->down, cap->centre);
    const double most = 1.7321 * cap->sine;
    const double slope = fmax(fabs(right), 1e-9);
    const double at = right < 0 ? middle / slope : -middle / slope;
    const double from = fmax(at - most / slope, -1);
    const double to = fmin(at + most / slope, 1);

    *first = from <= to ? (int)(0.5 * h->target->n * (from + 1)) : 0;
    *last = from <= to ? (int)(0.5 * h->target->n * (to + 1)) + 1 : 0;
    if (*last > h->target->n)
        *last = h->target->n;
}

static void horizon_job(void *arg, int job, int worker)
{
    const struct horizon *h = arg;
    float *row = h->local + 3 * (size_t)job * (size_t)h->target->n;

    (void)worker;
    for (int i = 0; i < h->s->light_count; i++) {
        const struct cap *cap = &h->caps[i];
        int first, last;
        find_near(h, job, cap, &first, &last);
        for (int x = first; x < last; x++) {
            double d[3];
            ibl_cube_direction(h->target->n, job / h->target->n, x,
                               job % h->target->n, d);
            if (is_crossed(cap, d))
                correct(h, i, d, row + 3 * x);
        }
    }
}

ibl_status ibl_spectral_horizon(const ibl_spectral *s,
                                const ibl_light_target *target, float *local)
{
    struct horizon h = {.s = s, .target = target, .local = local};
    const double height = IBL_PI / s->height, width = 2 * IBL_PI / s->width;
    ibl_status status = make_points(s, target, 1, &h.points);

    if (status)
        return status;
    h.caps = ibl_alloc_array((size_t)s->light_count, sizeof *h.caps);
    if (!h.caps)
        status = ibl_no_memory(s->ctx, "the lights on the horizon");
    for (int i = 0; !status && i < s->light_count; i++)
        set_cap(&h, i);
    h.down = (int)ceil(height / widest);
    h.across = (int)ceil(width / widest);
    const double largest = fmax(height / h.down, width / h.across);
    make_rule(points_for(largest, target) + (largest > 0.01), &h.rule);
    if (!status)
        status = ibl_run(s->ctx, NULL, IBL_FACES * target->n, horizon_job, &h);
    ibl_free(h.caps);
    free_points(&h.points);
    return status;
}
