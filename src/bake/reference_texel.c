/* SPDX-License-Identifier: MIT */
/*
 * Level 0: the mean of the source over a texel's solid angle.
 *
 * A half plane through the vertical axis, at azimuth phi, meets a texel in one
 * interval of theta: on a face a meridian is a straight line and a texel is
 * convex. The integral over the interval is exact, with sin(theta) dtheta
 * against constants (a pixel's row) or against pieces from centre to centre.
 * What is left is an integral over phi of a function that is smooth but where
 * the meridian passes a corner of the texel, a boundary of the source's columns
 * or a point where one of the texel's edges crosses a boundary of its rows.
 * Between those knots, which are all found in closed form, it is done by Gauss
 * points. An edge at height y and distance a from the axis, its foot at azimuth
 * phi_f, has cot(theta) = y / a cos(phi - phi_f), no knot interval is longer
 * than its distance from the edge's singularities in the complex plane, and 8
 * points leave less than 1e-9.
 */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "bake/reference_sums.h"
#include "core/alloc.h"
#include "core/context.h"

enum {
    GAUSS = 8,
    MAX_EDGES = 4
};

static const double pi = REFERENCE_PI;

static const double node[GAUSS] = {-0.960289856497536232, -0.796666477413626740,
                                   -0.525532409916328986, -0.183434642495649805,
                                   0.183434642495649805,  0.525532409916328986,
                                   0.796666477413626740,  0.960289856497536232};
static const double mass[GAUSS] = {0.101228536290376259, 0.222381034453374471,
                                   0.313706645877887287, 0.362683783378361983,
                                   0.362683783378361983, 0.313706645877887287,
                                   0.222381034453374471, 0.101228536290376259};

/* ---- the texel -------------------------------------------------------- */

/* A texel that is not a meridian's: cot(theta) = slope cos(phi - foot). */
struct edge {
    double slope, foot;
};

struct region {
    double u0, u1, v0, v1; /* on its face */
    bool polar;            /* on +Y or -Y */
    double up;             /* there 1 or -1 */
    double forward;        /* on the others: azimuth of the face's centre */
    double phi0, phi1;     /* azimuths of the world */
    double theta0, theta1; /* bounds, not tight */
    int edges;
    struct edge edge[MAX_EDGES];
};

/* The number of a..b next to 0. */
static double nearest_zero(double a, double b)
{
    return a > 0 ? a : b < 0 ? b : 0;
}

static double largest(double a, double b)
{
    return fmax(fabs(a), fabs(b));
}

/* +X (1, -v, -u)  -X (-1, -v, u)  +Z (u, -v, 1)  -Z (-u, -v, -1): azimuth
 * forward - atan(u), and -v cos(azimuth - forward) is cot(theta). */
static void side_region(int face, struct region *r)
{
    const double forward[6] = {0, pi, 0, 0, 0.5 * pi, -0.5 * pi};
    const double near = 1 / sqrt(1 + pow(nearest_zero(r->u0, r->u1), 2));
    const double far = 1 / sqrt(1 + pow(largest(r->u0, r->u1), 2));

    r->forward = forward[face];
    r->phi0 = r->forward - atan(r->u1);
    r->phi1 = r->forward - atan(r->u0);
    r->theta0 = atan2(1, -r->v0 * (r->v0 < 0 ? near : far));
    r->theta1 = atan2(1, -r->v1 * (r->v1 < 0 ? far : near));
    r->edges = 2;
    r->edge[0] = (struct edge){-r->v0, r->forward};
    r->edge[1] = (struct edge){-r->v1, r->forward};
}

/* +Y (u, 1, v)  -Y (u, -1, -v): azimuth atan2(up v, u). */
static void polar_region(struct region *r)
{
    const double u[4] = {r->u0, r->u1, r->u0, r->u1};
    const double v[4] = {r->v0, r->v0, r->v1, r->v1};
    const double inner =
        hypot(nearest_zero(r->u0, r->u1), nearest_zero(r->v0, r->v1));
    const double outer = hypot(largest(r->u0, r->u1), largest(r->v0, r->v1));

    r->theta0 = r->up > 0 ? atan(inner) : pi - atan(outer);
    r->theta1 = r->up > 0 ? atan(outer) : pi - atan(inner);
    if (r->u0 < 0 && r->u1 > 0 && r->v0 < 0 && r->v1 > 0) {
        r->phi0 = -pi;
        r->phi1 = pi;
    } else {
        const double middle = atan2(r->up * (r->v0 + r->v1), r->u0 + r->u1);
        r->phi0 = r->phi1 = middle;
        for (int k = 0; k < 4; k++) {
            if (u[k] == 0 && v[k] == 0)
                continue;
            const double d =
                remainder(atan2(r->up * v[k], u[k]) - middle, 2 * pi);
            r->phi0 = fmin(r->phi0, middle + d);
            r->phi1 = fmax(r->phi1, middle + d);
        }
    }
    const double at[4] = {r->u0, r->u1, r->up * r->v0, r->up * r->v1};
    for (int k = 0; k < 4; k++) {
        const double turn = k < 2 ? 0 : 0.5 * pi;
        if (at[k] != 0)
            r->edge[r->edges++] = (struct edge){r->up / fabs(at[k]),
                                                at[k] > 0 ? turn : turn + pi};
    }
}

static struct region region_of(int size, ibl_texel texel)
{
    struct region r = {.u0 = 2.0 * texel.x / size - 1,
                       .u1 = 2.0 * (texel.x + 1) / size - 1,
                       .v0 = 2.0 * texel.y / size - 1,
                       .v1 = 2.0 * (texel.y + 1) / size - 1};

    r.polar = texel.face == 2 || texel.face == 3;
    r.up = texel.face == 3 ? -1 : 1;
    if (r.polar)
        polar_region(&r);
    else
        side_region(texel.face, &r);
    return r;
}

/* Clips from..to, the part of a ray that is left, to the slab a..b. */
static void clip(double direction, double a, double b, double *from, double *to)
{
    if (fabs(direction) < 1e-300)
        return;
    const double p = a / direction, q = b / direction;
    *from = fmax(*from, fmin(p, q));
    *to = fmin(*to, fmax(p, q));
}

/* The texel's interval of theta at an azimuth of the world. */
static void interval(const struct region *r, double phi, double *from,
                     double *to)
{
    if (!r->polar) {
        const double c = cos(phi - r->forward);
        *from = atan2(1, -r->v0 * c);
        *to = atan2(1, -r->v1 * c);
        return;
    }
    double inner = 0, outer = 2;
    clip(cos(phi), r->u0, r->u1, &inner, &outer);
    clip(r->up * sin(phi), r->v0, r->v1, &inner, &outer);
    outer = fmax(inner, outer);
    *from = r->up > 0 ? atan(inner) : pi - atan(outer);
    *to = r->up > 0 ? atan(outer) : pi - atan(inner);
}

/* ---- knots ------------------------------------------------------------ */

struct texels {
    const ibl_reference *ref;
    int size;
    bool linear_x, linear_y;
    const ibl_texel *texel;
    double *rgb;
    double *knots; /* max_knots of each worker */
};

static size_t max_knots(const ibl_image *env)
{
    return 2 * (size_t)env->width + 4 +
           MAX_EDGES * 2 * ((size_t)env->height + 2) + 64;
}

struct knots {
    const struct region *r;
    double *at;
    size_t count;
};

/* Keeps an azimuth, in any turn, that is inside the region. */
static void keep(struct knots *k, double phi)
{
    const double turn = 2 * pi;

    phi = k->r->phi0 + (phi - k->r->phi0) -
          turn * floor((phi - k->r->phi0) / turn);
    if (phi > k->r->phi0 && phi < k->r->phi1)
        k->at[k->count++] = phi;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

/* Where the edges meet the boundaries of rows, or their centres. */
static void keep_crossings(const struct texels *t, struct knots *k)
{
    const struct region *r = k->r;
    const int h = t->ref->env->height;
    const double shift = t->linear_y ? 0.5 : 0;
    const int first = (int)floor(r->theta0 / pi * h - shift);
    const int last = (int)ceil(r->theta1 / pi * h - shift);

    for (int j = first < 0 ? 0 : first; j <= last && j + shift <= h; j++) {
        const double theta = pi * (j + shift) / h;
        const double cot = cos(theta) / sin(theta);
        for (int e = 0; e < r->edges; e++) {
            const double c = cot / r->edge[e].slope;
            if (!(fabs(c) <= 1))
                continue;
            keep(k, r->edge[e].foot + acos(c));
            keep(k, r->edge[e].foot - acos(c));
        }
    }
}

static size_t find_knots(const struct texels *t, const struct region *r,
                         double *at)
{
    struct knots k = {r, at, 0};
    const double per_turn =
        (t->linear_x || t->linear_y ? 2.0 : 1.0) * t->ref->env->width;
    /* In units of columns, or of half columns where centres count too. */
    const double from = ((r->phi0 + t->ref->yaw) / (2 * pi) + 0.5) * per_turn;
    const double to = ((r->phi1 + t->ref->yaw) / (2 * pi) + 0.5) * per_turn;

    at[k.count++] = r->phi0;
    for (double x = floor(from) + 1; x < to; x++)
        at[k.count++] = (x / per_turn - 0.5) * 2 * pi - t->ref->yaw;
    keep_crossings(t, &k);
    if (r->polar) {
        for (int c = 0; c < 4; c++)
            keep(&k,
                 atan2(r->up * (c < 2 ? r->v0 : r->v1), c % 2 ? r->u1 : r->u0));
    }
    for (int c = 1; c < 16; c++)
        keep(&k, r->phi0 + c * pi / 8);
    at[k.count++] = r->phi1;
    qsort(at, k.count, sizeof *at, ascending);
    return k.count;
}

/* ---- the source along a meridian -------------------------------------- */

/* Row j where the azimuth's coordinate in columns is x. */
static void row_value(const struct texels *t, int j, double x, double rgb[3])
{
    const int w = t->ref->env->width;
    const float *row = t->ref->env->data + 3 * (size_t)j * (size_t)w;
    const double at = t->linear_x ? floor(x - 0.5) : floor(x);
    const double weight = t->linear_x ? x - 0.5 - at : 0;
    const int left = (int)(at - w * floor(at / w)) % w;
    const int right = (left + 1) % w;

    for (int c = 0; c < 3; c++)
        rgb[c] = (1 - weight) * (double)row[3 * left + c] +
                 weight * (double)row[3 * right + c];
}

/* Adds the integral from..to of constant rows, and the solid angle. */
static void add_patches(const struct texels *t, double x, double from,
                        double to, double sum[4])
{
    const ibl_reference *ref = t->ref;
    const int h = ref->env->height;

    for (int j = (int)(from / pi * h); j < h && pi * j / h < to; j++) {
        const double top = pi * j / h, bottom = pi * (j + 1) / h;
        const double a = fmax(from, top), b = fmin(to, bottom);
        const double weight =
            a == top && b == bottom
                ? ref->row_angle[j] / (2 * pi / ref->env->width)
                : 2 * sin(0.5 * (a + b)) * sin(0.5 * (b - a));
        double rgb[3];
        if (b <= a)
            continue;
        row_value(t, j, x, rgb);
        for (int c = 0; c < 3; c++)
            sum[c] += weight * rgb[c];
        sum[3] += weight;
    }
}

/* A row's value, beyond a pole that of the row next to it, half a turn on. */
static void centre_value(const struct texels *t, int j, double x, double rgb[3])
{
    const int h = t->ref->env->height;

    if (j < 0)
        row_value(t, 0, x + 0.5 * t->ref->env->width, rgb);
    else if (j >= h)
        row_value(t, h - 1, x + 0.5 * t->ref->env->width, rgb);
    else
        row_value(t, j, x, rgb);
}

/*
 * The bend b of the weights t + b t (1 - t) between two row centres a step s
 * apart, around theta: the integral of ((t > 1/2) - t) sin over that of
 * t (1 - t) sin. With t = 1/2 + u / s only the odd part of the sine, around
 * theta, counts above and only the even part below:
 *     cot(theta) h (h - sin(h)) / (sin(h) - h cos(h)),   h = s / 2.
 */
static double bend(double theta, double step)
{
    const double h = 0.5 * step;
    const double ratio = h < 0.01 ? 0.5 * (1 + h * h / 20)
                                  : (h - sin(h)) / (sin(h) - h * cos(h));

    return h * ratio * cos(theta) / sin(theta);
}

/* The integral of the lower row's weight from..to, zero the upper's centre. */
static double lower_weight(double zero, double step, double b, double from,
                           double to)
{
    const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
    double sum = 0;

    for (int k = 0; k < GAUSS; k++) {
        const double theta = middle + half * node[k];
        const double t = (theta - zero) / step;
        sum += mass[k] * (t + b * t * (1 - t)) * sin(theta);
    }
    return sum * half;
}

/* The same for values that run from row centre to row centre. */
static void add_linear(const struct texels *t, double x, double from, double to,
                       double sum[4])
{
    const int h = t->ref->env->height;
    const double step = pi / h;

    for (int j = (int)floor(from / step - 0.5); (j + 0.5) * step < to; j++) {
        const double zero = (j + 0.5) * step;
        const double a = fmax(from, zero), b = fmin(to, zero + step);
        const bool inside = j >= 0 && j < h - 1;
        double upper[3], lower[3];
        if (b <= a)
            continue;
        const double all = 2 * sin(0.5 * (a + b)) * sin(0.5 * (b - a));
        const double second = lower_weight(
            zero, step, inside ? bend((j + 1) * step, step) : 0, a, b);
        centre_value(t, j, x, upper);
        centre_value(t, j + 1, x, lower);
        for (int c = 0; c < 3; c++)
            sum[c] += all * upper[c] + second * (lower[c] - upper[c]);
        sum[3] += all;
    }
}

/* ---- the call --------------------------------------------------------- */

static void add_wedge(const struct texels *t, const struct region *r,
                      double phi0, double phi1, ibl_exact total[4])
{
    const double middle = 0.5 * (phi0 + phi1), half = 0.5 * (phi1 - phi0);
    double wedge[4] = {0};

    for (int k = 0; k < GAUSS; k++) {
        const double phi = middle + half * node[k];
        const double x =
            ((phi + t->ref->yaw) / (2 * pi) + 0.5) * t->ref->env->width;
        double from, to, sum[4] = {0};
        interval(r, phi, &from, &to);
        if (t->linear_y)
            add_linear(t, x, from, to, sum);
        else
            add_patches(t, x, from, to, sum);
        for (int c = 0; c < 4; c++)
            wedge[c] += mass[k] * sum[c];
    }
    for (int c = 0; c < 4; c++)
        ibl_exact_add(&total[c], wedge[c] * half);
}

static void texel_job(void *arg, int job, int worker)
{
    const struct texels *t = arg;
    double *at = t->knots + (size_t)worker * max_knots(t->ref->env);
    const struct region r = region_of(t->size, t->texel[job]);
    const size_t count = find_knots(t, &r, at);
    ibl_exact total[4] = {{0, 0}};

    for (size_t k = 0; k + 1 < count && !ibl_cancelled(t->ref->ctx); k++) {
        if (at[k + 1] > at[k])
            add_wedge(t, &r, at[k], at[k + 1], total);
    }
    for (int c = 0; c < 3; c++)
        t->rgb[3 * (size_t)job + (size_t)c] =
            ibl_exact_total(&total[c]) / ibl_exact_total(&total[3]);
}

static ibl_status check_texels(const ibl_reference *ref, int size,
                               const ibl_texel *texels, size_t count)
{
    if (size < 1 || size > IBL_MAX_CUBE_SIZE)
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                        "a cube of size %d: must be 1 to %d", size,
                        IBL_MAX_CUBE_SIZE);
    for (size_t k = 0; k < count; k++) {
        const ibl_texel t = texels[k];
        if (t.face < 0 || t.face >= IBL_FACES || t.x < 0 || t.x >= size ||
            t.y < 0 || t.y >= size)
            return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                            "texel (%d, %d) of face %d: must be on faces 0 to "
                            "5 of %d texels squared",
                            t.x, t.y, t.face, size);
    }
    return IBL_OK;
}

ibl_status ibl_reference_texels(const ibl_reference *ref, int size,
                                const ibl_texel *texels, size_t count,
                                double *rgb)
{
    ibl_status status = check_texels(ref, size, texels, count);
    if (status)
        return status;
    struct texels t = {.ref = ref,
                       .size = size,
                       .linear_x = ref->env->width < 4 * size,
                       .linear_y = ref->env->height < 2 * size};
    t.knots = ibl_alloc_array((size_t)ibl_ctx_threads(ref->ctx),
                              max_knots(ref->env) * sizeof *t.knots);
    if (!t.knots)
        return ibl_no_memory(ref->ctx, "the reference's knots");
    for (size_t at = 0; at < count && !status;) {
        const int n = count - at < 65536 ? (int)(count - at) : 65536;
        t.texel = texels + at;
        t.rgb = rgb + 3 * at;
        status = ibl_run(ref->ctx, NULL, n, texel_job, &t);
        at += (size_t)n;
    }
    ibl_free(t.knots);
    return status;
}
