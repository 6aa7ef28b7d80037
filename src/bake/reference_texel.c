/* SPDX-License-Identifier: MIT */
/*
 * Level 0: the mean of the source over a texel's solid angle.
 *
 * A half plane through the vertical axis, at azimuth phi, meets a texel in one
 * interval of theta: on a face a meridian is a straight line and a texel is
 * convex. The integral over the interval is exact, with sin(theta) dtheta
 * against constants, the rows of the source or of its interpolation's finer
 * pixels. What is left is an integral over phi of a function that is smooth but
 * where the meridian passes a corner of the texel, a boundary of columns or a
 * point where one of the texel's edges crosses a boundary of rows.
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
    int base, size;
    int finer_x, finer_y; /* pixels for each of the source */
    int columns, rows;    /* of them */
    double *bend;         /* rows of the source less 1: see find_bends */
    const ibl_texel *texel;
    double *rgb;
    double *knots; /* max_knots of each worker */
};

static size_t max_knots(const struct texels *t)
{
    return (size_t)t->columns + 4 + MAX_EDGES * 2 * ((size_t)t->rows + 2) + 64;
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

/* Where the edges meet the boundaries of rows. */
static void keep_crossings(const struct texels *t, struct knots *k)
{
    const struct region *r = k->r;
    const int h = t->rows;
    const int first = (int)floor(r->theta0 / pi * h);
    const int last = (int)ceil(r->theta1 / pi * h);

    for (int j = first < 0 ? 0 : first; j <= last && j <= h; j++) {
        const double theta = pi * j / h;
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
    const double per_turn = t->columns;
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

/*
 * The b of the weights t + b t (1 - t) between each two rows of the source: by
 * solid angle, the finer rows before the border of the two count as one of the
 * upper altogether, the others as one of the lower.
 */
static void find_bends(const struct texels *t)
{
    for (int j = 0; j + 1 < t->ref->env->height; j++) {
        /* The first finer row whose centre is not before that of row j. */
        const int first = j * t->finer_y + t->finer_y / 2;
        ibl_exact lacks = {0, 0}, takes = {0, 0};
        for (int row = first; row < first + t->finer_y; row++) {
            const double w = (row + 0.5) / t->finer_y - 0.5 - j;
            const double zone = sin(pi * (row + 0.5) / t->rows);
            ibl_exact_add(&lacks, ((w > 0.5) - w) * zone);
            ibl_exact_add(&takes, w * (1 - w) * zone);
        }
        const double room = ibl_exact_total(&takes);
        t->bend[j] = room > 0 ? ibl_exact_total(&lacks) / room : 0;
    }
}

/* Adds a part of a row of the source, which may be one beyond a pole: there it
 * is that beside the pole, half a turn on. x: a finer pixel's centre, in
 * columns of the source counted from the centre of the first. */
static void add_source(const struct texels *t, int row, double x, double part,
                       double rgb[3])
{
    const ibl_image *env = t->ref->env;
    const int w = env->width, h = env->height;
    const bool beyond = row < 0 || row >= h;
    const int j = row < 0 ? 0 : row >= h ? h - 1 : row;
    const float *source = env->data + 3 * (size_t)j * (size_t)w;
    const double at = beyond ? x + 0.5 * w : x, left = floor(at);

    for (int k = 0; k < 2; k++) {
        const double weight = part * (k ? at - left : 1 - (at - left));
        const int column = ((int)left + k + w) % w;
        if (weight <= 0)
            continue;
        for (int c = 0; c < 3; c++)
            rgb[c] += weight * (double)source[3 * column + c];
    }
}

/* The value of a finer pixel: the source's own where they are the same. */
static void pixel_value(const struct texels *t, int row, int column,
                        double rgb[3])
{
    const double x = (column + 0.5) / t->finer_x - 0.5;
    const double y = (row + 0.5) / t->finer_y - 0.5;
    const int upper = (int)floor(y);
    const bool inside = upper >= 0 && upper < t->ref->env->height - 1;
    const double w = y - upper;
    const double lower = w + (inside ? t->bend[upper] * w * (1 - w) : 0);

    rgb[0] = rgb[1] = rgb[2] = 0;
    add_source(t, upper, x, 1 - lower, rgb);
    if (lower > 0)
        add_source(t, upper + 1, x, lower, rgb);
}

/* Adds the integral from..to of constant rows, and the solid angle. */
static void add_patches(const struct texels *t, int column, double from,
                        double to, double sum[4])
{
    const int h = t->rows;

    for (int j = (int)(from / pi * h); j < h && pi * j / h < to; j++) {
        const double a = fmax(from, pi * j / h);
        const double b = fmin(to, pi * (j + 1) / h);
        const double weight = 2 * sin(0.5 * (a + b)) * sin(0.5 * (b - a));
        double rgb[3];
        if (b <= a)
            continue;
        pixel_value(t, j, column, rgb);
        for (int c = 0; c < 3; c++)
            sum[c] += weight * rgb[c];
        sum[3] += weight;
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
        const double turns = (phi + t->ref->yaw) / (2 * pi) + 0.5;
        const int column = (int)((turns - floor(turns)) * t->columns);
        double from, to, sum[4] = {0};
        interval(r, phi, &from, &to);
        add_patches(t, column < t->columns ? column : 0, from, to, sum);
        for (int c = 0; c < 4; c++)
            wedge[c] += mass[k] * sum[c];
    }
    for (int c = 0; c < 4; c++)
        ibl_exact_add(&total[c], wedge[c] * half);
}

static void texel_job(void *arg, int job, int worker)
{
    const struct texels *t = arg;
    double *at = t->knots + (size_t)worker * max_knots(t);
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

static ibl_status check_texels(const ibl_reference *ref, int base, int size,
                               const ibl_texel *texels, size_t count)
{
    if (size < 1 || size > IBL_MAX_CUBE_SIZE)
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                        "a cube of size %d: must be 1 to %d", size,
                        IBL_MAX_CUBE_SIZE);
    if (base < size || base > IBL_MAX_CUBE_SIZE)
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                        "size %d of level 0 of a cube: must be %d to %d", base,
                        size, IBL_MAX_CUBE_SIZE);
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

/* The least number of parts of n that are `least` together. */
static int parts(int n, int least)
{
    int count = 1;
    while (count * n < least)
        count++;
    return count;
}

/* The grid that <ibl/ibl.h> says for the size of level 0. */
static void find_grid(struct texels *t)
{
    const int w = t->ref->env->width, h = t->ref->env->height;
    const int across = 4 * t->base, down = 2 * t->base;

    t->finer_x = t->finer_y = 1;
    if (w < across || h < down) {
        t->finer_x = parts(w, across > 512 ? across : 512);
        t->finer_x += t->finer_x * w % 2;
        t->finer_y = parts(h, down);
    }
    t->columns = w * t->finer_x;
    t->rows = h * t->finer_y;
}

ibl_status ibl_reference_texels(const ibl_reference *ref, int base, int size,
                                const ibl_texel *texels, size_t count,
                                double *rgb)
{
    ibl_status status = ibl_reference_check(ref, count, texels, rgb);
    if (!status)
        status = check_texels(ref, base, size, texels, count);
    if (status)
        return status;
    struct texels t = {.ref = ref, .base = base, .size = size};
    find_grid(&t);
    t.bend = ibl_alloc_array((size_t)ref->env->height, sizeof *t.bend);
    t.knots = ibl_alloc_array((size_t)ibl_ctx_threads(ref->ctx),
                              max_knots(&t) * sizeof *t.knots);
    if (t.knots && t.bend)
        find_bends(&t);
    else
        status = ibl_no_memory(ref->ctx, "the reference's knots");
    for (size_t at = 0; at < count && !status;) {
        const int n = count - at < 65536 ? (int)(count - at) : 65536;
        t.texel = texels + at;
        t.rgb = rgb + 3 * at;
        status = ibl_run(ref->ctx, NULL, n, texel_job, &t);
        at += (size_t)n;
    }
    ibl_free(t.bend);
    ibl_free(t.knots);
    return status;
}
