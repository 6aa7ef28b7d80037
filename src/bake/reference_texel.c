/* SPDX-License-Identifier: MIT */
/*
 * Level 0: the mean of the source over a texel's solid angle.
 *
 * A half plane through the vertical axis, at azimuth phi, meets a texel in one
 * interval of theta: on a face a meridian is a straight line and a texel is
 * convex. The integral of sin(theta) dtheta over the interval is exact, since
 * the rows of the source, or of its finer interpolation, are constant. The
 * remaining integral over phi is smooth except where the meridian passes a
 * corner of the texel, a boundary of columns, or a point where an edge of the
 * texel crosses a boundary of rows. These knots have closed forms; Gauss points
 * integrate between them. An edge at height y and distance a from the axis,
 * foot at azimuth phi_f, has cot(theta) = y / a cos(phi - phi_f). No interval
 * between knots is longer than its distance from the edge's singularities in
 * the complex plane, and 8 points leave less than 1e-9.
 *
 * The equator crosses texels of an octahedral map along their diagonals. Each
 * half is a triangle of straight edges, as a cube's texel is a square of such.
 */
#include <stdbool.h>
#include <stdlib.h>

#include "bake/reference_sums.h"
#include "core/alloc.h"
#include "core/context.h"

enum {
    GAUSS = 8,
    EDGES = 4,
    GROUP = 8 /* texels in a job */
};

static const double pi = REFERENCE_PI;

/* ---- the texel -------------------------------------------------------- */

/* For each face the directions of u = v = 0, of u and of v. */
static const double face_axes[6][3][3] = {
    {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
    {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
    {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}}};

/* The directions d with plane . d >= 0 for all four planes. */
struct region {
    double plane[4][3];
    double corner[4]; /* azimuths in the world; NaN: a pole */
    double phi0, phi1;
    double theta0, theta1; /* between these as well */
};

/* Sets the azimuths from the corners' and the middle's. */
static void find_azimuths(struct region *r, const double middle[3])
{
    const double centre = r->phi0 = r->phi1 = atan2(middle[2], middle[0]);
    for (int c = 0; c < 4; c++) {
        const double turn = remainder(r->corner[c] - centre, 2 * pi);
        r->phi0 = fmin(r->phi0, centre + turn);
        r->phi1 = fmax(r->phi1, centre + turn);
    }
    r->theta0 = 0;
    r->theta1 = pi;
}

static double azimuth(const double d[3])
{
    return d[0] == 0 && d[2] == 0 ? NAN : atan2(d[2], d[0]);
}

static struct region region_of(int size, ibl_texel texel)
{
    const double(*axis)[3] = face_axes[texel.face];
    const double u[2] = {2.0 * texel.x / size - 1,
                         2.0 * (texel.x + 1) / size - 1};
    const double v[2] = {2.0 * texel.y / size - 1,
                         2.0 * (texel.y + 1) / size - 1};
    const bool polar = texel.face == 2 || texel.face == 3;
    struct region r;
    double middle[3];

    for (int k = 0; k < 3; k++) {
        for (int side = 0; side < 2; side++) {
            const int sign = side ? -1 : 1;
            r.plane[side][k] = sign * (axis[1][k] - u[side] * axis[0][k]);
            r.plane[2 + side][k] = sign * (axis[2][k] - v[side] * axis[0][k]);
        }
        middle[k] = axis[0][k] + 0.5 * (u[0] + u[1]) * axis[1][k] +
                    0.5 * (v[0] + v[1]) * axis[2][k];
    }
    for (int c = 0; c < 4; c++) {
        double d[3];
        for (int k = 0; k < 3; k++)
            d[k] = axis[0][k] + u[c % 2] * axis[1][k] + v[c / 2] * axis[2][k];
        r.corner[c] = azimuth(d);
    }
    find_azimuths(&r, middle);
    if (polar && u[0] < 0 && u[1] > 0 && v[0] < 0 && v[1] > 0) {
        r.phi0 = -pi;
        r.phi1 = pi;
    }
    return r;
}

/* A row of an equirectangular map has no planes. */
static struct region equirect_region(int size, ibl_texel texel)
{
    const double width = 2 * pi / (4 * size), height = pi / (2 * size);

    return (struct region){.corner = {NAN, NAN, NAN, NAN},
                           .phi0 = width * texel.x - pi,
                           .phi1 = width * (texel.x + 1) - pi,
                           .theta0 = height * texel.y,
                           .theta1 = height * (texel.y + 1)};
}

/* The point of the octahedron |x| + |y| + |z| = 1 over a point of its map. */
static void lift(double u, double v, double d[3])
{
    const bool below = fabs(u) + fabs(v) > 1;

    d[0] = below ? copysign(1 - fabs(v), u) : u;
    d[1] = 1 - fabs(u) - fabs(v);
    d[2] = below ? copysign(1 - fabs(u), v) : v;
}

/* The half of an octahedral texel that is nearer to the map's middle, or the
 * farther one. */
static struct region octahedral_region(int size, ibl_texel texel, int farther)
{
    const int out_x = texel.x >= size, out_y = texel.y >= size;
    const double u[2] = {(double)(texel.x + 1 - out_x) / size - 1,
                         (double)(texel.x + out_x) / size - 1};
    const double v[2] = {(double)(texel.y + 1 - out_y) / size - 1,
                         (double)(texel.y + out_y) / size - 1};
    struct region r = {.corner[3] = NAN};
    double d[3][3], middle[3];

    lift(u[farther], v[farther], d[0]);
    lift(u[1], v[0], d[1]);
    lift(u[0], v[1], d[2]);
    for (int e = 0; e < 4; e++) {
        const double *a = d[e % 3], *b = d[(e + 1) % 3], *c = d[(e + 2) % 3];
        double side = 0;
        for (int k = 0; k < 3; k++) {
            const int i = (k + 1) % 3, j = (k + 2) % 3;
            r.plane[e][k] = a[i] * b[j] - a[j] * b[i];
            side += r.plane[e][k] * c[k];
        }
        for (int k = 0; k < 3; k++)
            r.plane[e][k] *= side < 0 ? -1 : 1;
    }
    for (int k = 0; k < 3; k++) {
        middle[k] = d[0][k] + d[1][k] + d[2][k];
        r.corner[k] = azimuth(d[k]);
    }
    find_azimuths(&r, middle);
    return r;
}

/* The texel's interval of theta at azimuth phi in the world. */
static void interval(const struct region *r, double phi, double *from,
                     double *to)
{
    const double c = cos(phi), s = sin(phi);

    *from = r->theta0;
    *to = r->theta1;
    for (int k = 0; k < 4; k++) {
        /* up cos(theta) + across sin(theta) >= 0 */
        const double up = r->plane[k][1];
        const double across = r->plane[k][0] * c + r->plane[k][2] * s;
        if (up > 0)
            *to = fmin(*to, atan2(up, -across));
        else if (up < 0)
            *from = fmax(*from, atan2(-up, across));
    }
    *to = fmax(*from, *to);
}

/* ---- knots ------------------------------------------------------------ */

struct texels {
    const ibl_reference *ref;
    ibl_projection projection;
    int base, size;
    int finer_x, finer_y; /* finer pixels per pixel of the source */
    int columns, rows;    /* of finer pixels */
    double *bend;         /* for each two adjacent rows: see find_bends */
    const ibl_texel *texel;
    size_t count;
    double *rgb;
    double *knots; /* max_knots for each worker */
};

static size_t max_knots(const struct texels *t)
{
    return (size_t)t->columns + 4 + EDGES * 2 * ((size_t)t->rows + 2) + 64;
}

struct knots {
    const struct region *r;
    double *at;
    size_t count;
};

/* Keeps an azimuth, of any turn, if it is inside the region. */
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

/* Keeps the azimuths where edges cross boundaries of rows. On an edge,
 * cot(theta) = slope cos(phi - foot). */
static void keep_crossings(const struct texels *t, struct knots *k)
{
    for (int e = 0; e < EDGES; e++) {
        const double *n = k->r->plane[e];
        const double slope = hypot(n[0], n[2]) / fabs(n[1]);
        const double foot = atan2(-n[2] / n[1], -n[0] / n[1]);
        for (int j = 1; n[1] != 0 && j < t->rows; j++) {
            const double theta = pi * j / t->rows;
            const double c = cos(theta) / sin(theta) / slope;
            if (!(fabs(c) <= 1))
                continue;
            keep(k, foot + acos(c));
            keep(k, foot - acos(c));
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
    for (int c = 0; c < 4; c++)
        keep(&k, r->corner[c]);
    for (int c = 1; c < 16; c++)
        keep(&k, r->phi0 + c * pi / 8);
    at[k.count++] = r->phi1;
    qsort(at, k.count, sizeof *at, ascending);
    return k.count;
}

/* ---- the source along a meridian -------------------------------------- */

/*
 * Finds b of the weight t + b t (1 - t) of the lower of two adjacent rows of
 * the source: summed by solid angle over the finer rows between both, these
 * weights give the solid angle of the finer rows below the border of the two.
 */
static void find_bends(const struct texels *t)
{
    for (int j = 0; j + 1 < t->ref->env->height; j++) {
        /* First finer row whose centre is not above that of row j. */
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

/* Adds `part` times a row of the source at x. A row beyond a pole is the row at
 * the pole, half a turn away. x: a finer pixel's centre, in columns of the
 * source from the centre of the first. */
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

/* The value of a finer pixel, which may be a pixel of the source. */
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

/* Adds the integral of a column over theta = from..to; sum[3]: of 1. */
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
    const ibl_gauss *rule = ibl_reference_gauss(GAUSS);
    double wedge[4] = {0};

    for (int k = 0; k < GAUSS; k++) {
        const double phi = middle + half * rule->node[k];
        const double turns = (phi + t->ref->yaw) / (2 * pi) + 0.5;
        const int column = (int)((turns - floor(turns)) * t->columns);
        double from, to, sum[4] = {0};
        interval(r, phi, &from, &to);
        add_patches(t, column < t->columns ? column : 0, from, to, sum);
        for (int c = 0; c < 4; c++)
            wedge[c] += rule->mass[k] * sum[c];
    }
    for (int c = 0; c < 4; c++)
        ibl_exact_add(&total[c], wedge[c] * half);
}

static void add_region(const struct texels *t, const struct region *r,
                       double *at, ibl_exact total[4])
{
    const size_t count = find_knots(t, r, at);

    for (size_t k = 0; k + 1 < count && !ibl_cancelled(t->ref->ctx); k++) {
        if (at[k + 1] > at[k])
            add_wedge(t, r, at[k], at[k + 1], total);
    }
}

static void make_texel(const struct texels *t, size_t which, double *at)
{
    const int halves = t->projection == IBL_PROJECTION_OCTAHEDRAL ? 2 : 1;
    const ibl_texel texel = t->texel[which];
    ibl_exact total[4] = {{0, 0}};

    for (int k = 0; k < halves; k++) {
        const struct region r = halves == 2
                                    ? octahedral_region(t->size, texel, k)
                                : t->projection == IBL_PROJECTION_EQUIRECT
                                    ? equirect_region(t->size, texel)
                                    : region_of(t->size, texel);
        add_region(t, &r, at, total);
    }
    for (size_t c = 0; c < 3; c++)
        t->rgb[3 * which + c] =
            ibl_exact_total(&total[c]) / ibl_exact_total(&total[3]);
}

static void texel_job(void *arg, int job, int worker)
{
    const struct texels *t = arg;
    const size_t first = (size_t)job * GROUP;

    for (size_t k = first; k < first + GROUP && k < t->count; k++)
        make_texel(t, k, t->knots + (size_t)worker * max_knots(t));
}

static ibl_status check_texels(const ibl_reference *ref,
                               ibl_projection projection, int base, int size,
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
    if (projection < IBL_PROJECTION_CUBE ||
        projection > IBL_PROJECTION_OCTAHEDRAL)
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                        "projection %d: must be 0 to 2", (int)projection);
    const ibl_level_shape s = ibl_level_shape_of(projection, size);
    for (size_t k = 0; k < count; k++) {
        const ibl_texel t = texels[k];
        if (t.face < 0 || t.face >= s.faces || t.x < 0 || t.x >= s.width ||
            t.y < 0 || t.y >= s.height)
            return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                            "texel (%d, %d) of face %d: must be on faces 0 to "
                            "%d of %dx%d texels",
                            t.x, t.y, t.face, s.faces - 1, s.width, s.height);
    }
    return IBL_OK;
}

/* The smallest count with count n >= least. */
static int parts(int n, int least)
{
    int count = 1;
    while (count * n < least)
        count++;
    return count;
}

/* Finds the finer grid that <ibl/ibl.h> defines for the size of level 0. */
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

ibl_status ibl_reference_texels(const ibl_reference *ref,
                                ibl_projection projection, int base, int size,
                                const ibl_texel *texels, size_t count,
                                double *rgb)
{
    ibl_status status = ibl_reference_check(ref, count, texels, rgb);
    if (!status)
        status = check_texels(ref, projection, base, size, texels, count);
    if (status)
        return status;
    struct texels t = {.ref = ref,
                       .projection = projection,
                       .base = base,
                       .size = size,
                       .texel = texels,
                       .count = count,
                       .rgb = rgb};
    find_grid(&t);
    t.bend = ibl_alloc_array((size_t)ref->env->height, sizeof *t.bend);
    t.knots = ibl_alloc_array((size_t)ibl_ctx_threads(ref->ctx),
                              max_knots(&t) * sizeof *t.knots);
    if (t.knots && t.bend) {
        find_bends(&t);
        status = ibl_run(ref->ctx, NULL, (int)((count + GROUP - 1) / GROUP),
                         texel_job, &t);
    } else {
        status = ibl_no_memory(ref->ctx, "the reference's knots");
    }
    ibl_free(t.bend);
    ibl_free(t.knots);
    return status;
}
