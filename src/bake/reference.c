/* SPDX-License-Identifier: MIT */
/*
 * Sums over the pixels of the source as patches of constant radiance, by an
 * adaptive rule in double precision.
 *
 * A kernel is the weight of a direction: a lobe, a cosine, a BRDF. Where it is
 * smooth, the integral over a block of pixels needs its values at 8 x 8
 * Chebyshev nodes of theta and phi only: with l the Lagrange polynomials,
 *     integral L w dO = sum w(node a, b) M_ab,
 *     M_ab = integral L l_a(theta) l_b(phi) sin(theta) dtheta dphi.
 * M is exact, separable, and that of a block follows from those of its four
 * parts. A polynomial of degree 7 on an interval of half length e misses about
 * (2 z)^-8 of a function whose nearest singularity is z e away; 4 of these
 * lengths leave 1e-6, 3, for BRDFs, 1e-4. Other blocks are divided, down to 16
 * x 16 pixels.
 *
 * These are weighed at their centres, but near the peak: there, a pixel is
 * halved until 2 x 2 or 3 x 3 Gauss points are enough, and cut at the horizon.
 * So are, afterwards, those of which the centre may miss more than a share of
 * all light, `tolerance`: bright ones, and in small maps those on the horizon.
 */
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "bake/reference_check.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/vector.h"
#include "ibl/reference.h"
#include "image/image.h"

enum {
    NODES = 8,
    LEAF = 16, /* rows and columns of the smallest blocks */
    LEVELS = 16,
    RUN = 16, /* points that are weighed at once; LEAF */
    SUMS = IBL_REFERENCE_BRDF,
    GAUSS = 6
};

static const double pi = 3.14159265358979323846;
static const double WIDEST = 0.8;    /* half a block, radians */
static const double LOW = 0.25;      /* radians */
static const double NOTHING = -36;   /* logarithm of a weight */
static const double SMALLEST = 1e-7; /* alpha; a smaller one is a mirror */

/* Gauss-Legendre points on 0..1, and weights of sum 1. */
static const struct gauss {
    double node[GAUSS], mass[GAUSS];
} gauss[] = {
    [1] = {{0.5}, {1}},
    [2] = {{0.211324865405187118, 0.788675134594812882}, {0.5, 0.5}},
    [3] = {{0.112701665379258311, 0.5, 0.887298334620741689},
           {5.0 / 18, 8.0 / 18, 5.0 / 18}},
    [6] = {{0.033765242898423986, 0.169395306766867743, 0.380690406958401546,
            0.619309593041598454, 0.830604693233132257, 0.966234757101576014},
           {0.085662246189585173, 0.180380786524069304, 0.233956967286345524,
            0.233956967286345524, 0.180380786524069304, 0.085662246189585173}}};

/* cos(pi (a + 1/2) / 8) */
static const double node[NODES] = {
    0.980785280403230431,  0.831469612302545236,  0.555570233019602289,
    0.195090322016128331,  -0.195090322016128193, -0.555570233019601956,
    -0.831469612302545347, -0.980785280403230431};

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

/* ---- blocks ------------------------------------------------------------- */

/* Rows or columns of a block. */
typedef struct band {
    double middle[2], half; /* cosine and sine of the middle; radians */
    double widest;          /* of rows: the largest sine */
    double c[NODES], s[NODES];
    double mass[NODES]; /* integral of l sin(theta), or of l */
} band;

typedef struct level {
    int rows, columns; /* of blocks */
    band *row, *column;
    float *moments; /* M of each block: R, G, B */
} level;

struct ibl_reference {
    ibl_ctx *ctx;
    const ibl_image *env;
    double yaw; /* radians, 0..2 pi: the map's azimuth minus the world's */
    bool coarse;
    int levels;
    level level[LEVELS];
    double (*row)[NODES], (*column)[NODES]; /* l's integrals over pixels */
    double (*theta)[2], *phi[2]; /* cosine and sine of pixels' centres */
};

/* The azimuth of a column's left border, the theta of a row's upper one. */
static double azimuth_of(const ibl_reference *ref, double column)
{
    return 2 * pi * (column / ref->env->width - 0.5);
}

static double theta_of(const ibl_reference *ref, double row)
{
    return pi * row / ref->env->height;
}

static float *moments_at(const level *l, int j, int i)
{
    return l->moments +
           3 * NODES * NODES * ((size_t)j * (size_t)l->columns + (size_t)i);
}

/* Lagrange polynomials of the nodes at x in -1..1. */
static void lagrange(double x, double l[NODES])
{
    for (int a = 0; a < NODES; a++) {
        l[a] = 1;
        for (int b = 0; b < NODES; b++)
            if (b != a)
                l[a] *= (x - node[b]) / (node[a] - node[b]);
    }
}

static void fill_band(band *b, double from, double to)
{
    const double middle = 0.5 * (from + to);

    b->half = 0.5 * (to - from);
    b->middle[0] = cos(middle);
    b->middle[1] = sin(middle);
    b->widest = from < 0.5 * pi && to > 0.5 * pi ? 1 : fmax(sin(from), sin(to));
    for (int a = 0; a < NODES; a++) {
        b->c[a] = cos(middle + b->half * node[a]);
        b->s[a] = sin(middle + b->half * node[a]);
    }
}

/* A part's nodes among those of its parent. */
static void part_nodes(const band *part, const band *whole,
                       double l[NODES][NODES])
{
    const double sine =
        part->middle[1] * whole->middle[0] - part->middle[0] * whole->middle[1];

    for (int a = 0; a < NODES; a++)
        lagrange((asin(sine) + part->half * node[a]) / whole->half, l[a]);
}

/* Of a band of level 0: the integrals over its pixels, and their sum. */
static void integrate_band(const ibl_reference *ref, bool row, int i, int n)
{
    double (*const at)(const ibl_reference *, double) =
        row ? theta_of : azimuth_of;
    const int begin = i * LEAF, end = begin + LEAF < n ? begin + LEAF : n;
    const double middle = 0.5 * (at(ref, begin) + at(ref, end));
    band *b = (row ? ref->level[0].row : ref->level[0].column) + i;

    for (int p = begin; p < end; p++) {
        double *out = (row ? ref->row : ref->column)[p], l[NODES];
        const double from = at(ref, p), wide = at(ref, p + 1) - from;
        for (int g = 0; g < GAUSS; g++) {
            const double x = from + wide * gauss[GAUSS].node[g];
            const double mass =
                wide * gauss[GAUSS].mass[g] * (row ? sin(x) : 1);
            lagrange((x - middle) / b->half, l);
            for (int a = 0; a < NODES; a++)
                out[a] += mass * l[a];
        }
        for (int a = 0; a < NODES; a++)
            b->mass[a] += out[a];
    }
}

/* The bands of a level along an axis of n pixels. */
static void fill_bands(const ibl_reference *ref, int k, bool row, int n)
{
    double (*const at)(const ibl_reference *, double) =
        row ? theta_of : azimuth_of;
    const level *l = &ref->level[k];
    const int step = LEAF << k, count = row ? l->rows : l->columns;

    for (int i = 0; i < count; i++) {
        band *b = (row ? l->row : l->column) + i;
        const band *part = k ? (row ? l[-1].row : l[-1].column) + 2 * i : b;
        const int end = (i + 1) * step < n ? (i + 1) * step : n;
        const int parts = i * step + step / 2 < n ? 2 : 1;
        fill_band(b, at(ref, i * step), at(ref, end));
        if (!k)
            integrate_band(ref, row, i, n);
        for (int m = 0; k && m < parts; m++) {
            double to[NODES][NODES];
            part_nodes(&part[m], b, to);
            for (int a = 0; a < NODES * NODES; a++)
                b->mass[a % NODES] +=
                    part[m].mass[a / NODES] * to[a / NODES][a % NODES];
        }
    }
}

static void add_line(const double row[NODES], const double line[3][NODES],
                     double m[3][NODES][NODES])
{
    for (int c = 0; c < 3; c++)
        for (int a = 0; a < NODES; a++)
            for (int b = 0; b < NODES; b++)
                m[c][a][b] += row[a] * line[c][b];
}

/* Adds pixels, of level 0, or the nodes of a part of a block to its M. */
static void add_moments(const ibl_reference *ref, int k, int j, int i, int part,
                        double m[3][NODES][NODES])
{
    const level *l = &ref->level[k];
    const int w = ref->env->width, h = ref->env->height;

    if (k == 0) {
        const int begin = i * LEAF, end = begin + LEAF < w ? begin + LEAF : w;
        for (int y = j * LEAF; y < (j + 1) * LEAF && y < h; y++) {
            double line[3][NODES] = {{0}};
            const float *p =
                ref->env->data + 3 * ((size_t)y * (size_t)w + (size_t)begin);
            for (int x = begin; x < end; x++, p += 3)
                for (int c = 0; c < 3; c++)
                    for (int b = 0; b < NODES; b++)
                        line[c][b] += ref->column[x][b] * (double)p[c];
            add_line(ref->row[y], line, m);
        }
        return;
    }
    const int y = 2 * j + part / 2, x = 2 * i + part % 2;
    double row[NODES][NODES], column[NODES][NODES];
    if (y >= l[-1].rows || x >= l[-1].columns)
        return;
    part_nodes(&l[-1].row[y], &l->row[j], row);
    part_nodes(&l[-1].column[x], &l->column[i], column);
    const float *from = moments_at(&l[-1], y, x);
    for (int a = 0; a < NODES; a++) {
        double line[3][NODES] = {{0}};
        for (int c = 0; c < 3; c++)
            for (int q = 0; q < NODES; q++)
                for (int b = 0; b < NODES; b++)
                    line[c][b] += column[q][b] *
                                  (double)from[(c * NODES + a) * NODES + q];
        add_line(row[a], line, m);
    }
}

struct blocks {
    const ibl_reference *ref;
    int k;
};

static void blocks_job(void *arg, int j, int worker)
{
    const struct blocks *of = arg;
    const level *l = &of->ref->level[of->k];
    (void)worker;

    for (int i = 0; i < l->columns; i++) {
        double m[3][NODES][NODES] = {{{0}}};
        for (int part = 0; part < (of->k ? 4 : 1); part++)
            add_moments(of->ref, of->k, j, i, part, m);
        float *out = moments_at(l, j, i);
        for (int n = 0; n < 3 * NODES * NODES; n++)
            out[n] = (float)(&m[0][0][0])[n];
    }
}

/* Levels end where blocks become too wide to be used. */
static ibl_status make_levels(ibl_reference *ref)
{
    const int w = ref->env->width, h = ref->env->height;
    ibl_status status = IBL_OK;

    ref->row = ibl_alloc_zeroed((size_t)h, sizeof *ref->row);
    ref->column = ibl_alloc_zeroed((size_t)w, sizeof *ref->column);
    ref->theta = ibl_alloc_array((size_t)h, sizeof *ref->theta);
    ref->phi[0] = ibl_alloc_array(2 * ((size_t)w + RUN), sizeof(double));
    if (!ref->row || !ref->column || !ref->theta || !ref->phi[0])
        return ibl_no_memory(ref->ctx, "the reference's polynomials");
    for (int j = 0; j < h; j++) {
        ref->theta[j][0] = cos(theta_of(ref, j + 0.5));
        ref->theta[j][1] = sin(theta_of(ref, j + 0.5));
    }
    ref->phi[1] = ref->phi[0] + w + RUN;
    for (int i = 0; i < w + RUN; i++) {
        ref->phi[0][i] = cos(azimuth_of(ref, i + 0.5));
        ref->phi[1][i] = sin(azimuth_of(ref, i + 0.5));
    }
    for (int k = 0; k < LEVELS && !status; k++) {
        const int step = LEAF << k;
        level *l = &ref->level[k];
        if (k && (step * pi / w > WIDEST || step * pi / h > 2 * WIDEST))
            break;
        l->rows = (h + step - 1) / step;
        l->columns = (w + step - 1) / step;
        l->row = ibl_alloc_zeroed((size_t)l->rows, sizeof *l->row);
        l->column = ibl_alloc_zeroed((size_t)l->columns, sizeof *l->column);
        l->moments = ibl_alloc_array((size_t)l->rows * (size_t)l->columns,
                                     3 * NODES * NODES * sizeof(float));
        ref->levels = k + 1;
        if (!l->row || !l->column || !l->moments)
            return ibl_no_memory(ref->ctx, "the reference's blocks");
        fill_bands(ref, k, true, h);
        fill_bands(ref, k, false, w);
        struct blocks of = {ref, k};
        status = ibl_run(ref->ctx, NULL, l->rows, blocks_job, &of);
    }
    return status;
}

ibl_status ibl_reference_create(ibl_ctx *ctx, const ibl_image *env,
                                double yaw_deg, ibl_reference **out)
{
    if (!out)
        return ibl_missing(ctx, "ibl_reference_create: out");
    *out = NULL;
    ibl_status status = ibl_check_image(ctx, env);
    if (status)
        return status;
    if (!isfinite(yaw_deg))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a yaw of %g degrees: must be finite", yaw_deg);
    ibl_reference *ref = ibl_alloc_zeroed(1, sizeof *ref);
    if (!ref)
        return ibl_no_memory(ctx, "the reference");
    ref->ctx = ctx;
    ref->env = env;
    ref->yaw = (yaw_deg - 360 * floor(yaw_deg / 360)) / 180 * pi;
    status = make_levels(ref);
    if (status)
        ibl_reference_free(ref);
    else
        *out = ref;
    return status;
}

void ibl_reference_coarsen(ibl_reference *ref)
{
    ref->coarse = true;
}

void ibl_reference_free(ibl_reference *ref)
{
    if (!ref)
        return;
    for (int k = 0; k < ref->levels; k++) {
        ibl_free(ref->level[k].row);
        ibl_free(ref->level[k].column);
        ibl_free(ref->level[k].moments);
    }
    ibl_free(ref->row);
    ibl_free(ref->column);
    ibl_free(ref->theta);
    ibl_free(ref->phi[0]);
    ibl_free(ref);
}

/* ---- kernels ------------------------------------------------------------ */

enum kind {
    GGX,
    CHARLIE,
    PHONG,
    COSINE,
    SMITH,
    SCHLICK
};

/* Z of the frame is the normal, in the map's frame; the viewer of a BRDF is at
 * (sv, 0, nv). */
typedef struct kernel {
    enum kind kind;
    double axis[3][3];
    double alpha, a2, power;
    double sv, nv, v; /* v: Smith's of the viewer, or Schlick's k */
    double scale;     /* of the sums */
    double tolerance; /* share of all light that a pixel's centre may miss, */
    double dim;       /* and that a block on the horizon may have as a whole */
    double step;      /* 3 x 3 points need no more than reach / step, */
    double near;      /* and nodes reach / near, for half a block */
} kernel;

/* Directions above the horizon, in the kernel's frame, and their weights. */
typedef struct run {
    double x[RUN], y[RUN], z[RUN];
    double f[2][RUN];   /* of a BRDF [1] is times Schlick's (1 - V.H)^5 */
    double reach2[RUN]; /* square of about the distance to a peak */
} run;

/*
 * With q = sin^2(psi / 2):
 *   GGX      (a2 / t)^2 cos(psi),  t = q + a2 (1 - q): N = V = R
 *   Charlie  (2 q)^(1 / 2 alpha) cos(psi)
 *   Phong    cos(psi)^(1 + (1 / a2 - 1) / 2)
 * With H = (x + sv, y, z + nv) / |.| its squared sine and cosine are s2 / h2
 * and c2 / h2, and D G / (4 N.V) without scale is
 *     h2^2 z / ((s2 + a2 c2)^2 g).
 * Nothing cancels near a peak.
 */
static void weigh(const kernel *k, run *p)
{
    const double a2 = k->a2, b2 = 1 - a2, sv = k->sv, nv = k->nv, v = k->v;
    const bool smith = k->kind == SMITH;

    for (int i = 0; i < RUN && k->kind < SMITH; i++) {
        const double q =
            0.5 * (p->x[i] * p->x[i] + p->y[i] * p->y[i]) / (1 + p->z[i]);
        const double t = q + a2 * (1 - q);
        p->reach2[i] = 4 * t;
        p->f[0][i] = p->z[i] * (a2 / t) * (a2 / t);
        p->f[1][i] = 0;
    }
    for (int i = 0; i < RUN && k->kind >= SMITH; i++) {
        const double x = p->x[i] + sv, z = p->z[i], up = z + nv;
        const double s2 = x * x + p->y[i] * p->y[i], c2 = up * up;
        const double h2 = s2 + c2, t = s2 + a2 * c2;
        const double miss = 1 - 0.5 * sqrt(h2), miss2 = miss * miss;
        const double g = smith ? v * z + nv * sqrt(a2 + b2 * z * z) + DBL_MIN
                               : v + (1 - v) * z;
        p->reach2[i] = t;
        p->f[0][i] = z * (h2 / t) * (h2 / t) / g;
        p->f[1][i] = p->f[0][i] * miss2 * miss2 * miss;
    }
    if (k->kind == GGX || k->kind >= SMITH)
        return;
    const double wide = k->kind == COSINE    ? pi
                        : k->kind == CHARLIE ? 6 * k->alpha
                                             : 3 * k->alpha;
    for (int i = 0; i < RUN; i++) {
        const double q2 =
            (p->x[i] * p->x[i] + p->y[i] * p->y[i]) / (1 + p->z[i]);
        p->reach2[i] = wide * wide;
        p->f[0][i] = p->z[i];
        if (k->kind == CHARLIE) {
            p->f[0][i] *= pow(q2, k->power);
            p->reach2[i] = fmin(p->reach2[i], fmax(q2, 1e-6));
        } else if (k->kind == PHONG) {
            p->f[0][i] = pow(p->z[i], k->power);
        }
    }
}

/* Turns a direction into the map's frame. */
static void into_map(const ibl_reference *ref, const double d[3], double out[3])
{
    const double c = cos(ref->yaw), s = sin(ref->yaw);
    const double turned[3] = {c * d[0] - s * d[2], d[1], s * d[0] + c * d[2]};

    memcpy(out, turned, sizeof turned);
    unit3(out);
}

/* Sets the axes from a direction and a view of any length. */
static void aim(const ibl_reference *ref, const double normal[3],
                const double view[3], kernel *k)
{
    double *x = k->axis[0], *y = k->axis[1], *z = k->axis[2], to[3];

    into_map(ref, normal, z);
    into_map(ref, view, to);
    cross3(z, to, y);
    k->sv = sqrt(dot3(y, y));
    k->nv = fmax(dot3(z, to), 0);
    if (!unit3(y)) {
        const double other[3] = {fabs(z[0]) < 0.5, fabs(z[0]) >= 0.5, 0};
        cross3(z, other, y);
        unit3(y);
    }
    cross3(y, z, x);
}

static void shape(kernel *k, enum kind kind, double alpha, bool coarse)
{
    k->kind = kind;
    k->alpha = kind == CHARLIE ? fmax(alpha, 1e-3) : alpha;
    k->a2 = k->alpha * k->alpha;
    k->power = kind == CHARLIE ? 0.5 / k->alpha : 1 + 0.5 * (1 / k->a2 - 1);
    k->scale = 1;
    k->v = 0;
    k->tolerance = coarse ? 1e-5 : kind < SMITH ? 2e-8 : 2e-6;
    k->dim = coarse ? 1e-2 : 1e-3;
    k->step = coarse ? 2 : kind < SMITH ? 4.5 : 2.5;
    k->near = coarse ? 1.8 : kind < SMITH ? 4 : 3;
    if (kind == SMITH) {
        k->v = sqrt(k->a2 + (1 - k->a2) * k->nv * k->nv);
        k->scale = k->a2 / (2 * pi);
    } else if (kind == SCHLICK) {
        k->v = 0.5 * k->alpha;
        k->scale = k->a2 / (4 * pi * (k->v + (1 - k->v) * k->nv));
    }
}

/* ---- sums --------------------------------------------------------------- */

/* A block that is to be looked at again. */
typedef struct rough {
    int level, row, column;
    double most; /* weight that a centre may miss, in parts of a pixel's flux */
} rough;

typedef struct sum {
    const ibl_reference *ref;
    const kernel *kernel;
    run run; /* points that wait to be weighed */
    int waiting;
    double value[4][RUN]; /* R, G, B and 1 times a solid angle */
    /* of these, weighed, then the same times Schlick's term; by place in run */
    double part[SUMS][RUN];
    /* Blocks of level 0 that were summed by their centres, and smooth ones that
     * the horizon crosses; each has room for all blocks. */
    rough *list, *later;
    size_t count, later_count;
    double least[4]; /* light that counts; 0: not yet known */
} sum;

static void local(const kernel *k, double ct, double st, double cp, double sp,
                  double l[3])
{
    for (int n = 0; n < 3; n++)
        l[n] =
            k->axis[n][1] * ct + st * (k->axis[n][0] * cp + k->axis[n][2] * sp);
}

static void flush(sum *s)
{
    weigh(s->kernel, &s->run);
    for (int n = 0; n < SUMS; n++)
        for (int i = 0; i < RUN; i++)
            s->part[n][i] += s->value[n % 4][i] * s->run.f[n / 4][i];
    memset(s->value, 0, sizeof s->value);
    s->waiting = 0;
}

static void add(sum *s, const double l[3], const double rgb[3], double mass,
                double one)
{
    const int i = s->waiting++;

    s->run.x[i] = l[0];
    s->run.y[i] = l[1];
    s->run.z[i] = fmax(l[2], 0);
    for (int c = 0; c < 3; c++)
        s->value[c][i] = rgb[c] * mass;
    s->value[3][i] = one;
    if (s->waiting == RUN)
        flush(s);
}

static double total(const sum *s, int n)
{
    double all = 0;

    for (int i = 0; i < RUN; i++)
        all += s->part[n][i];
    return all;
}

/* About the distance to what is not smooth, but for the horizon; large where
 * there is nothing within a radius. low: the least that a BRDF's change along
 * the horizon counts. */
static double reach_at(const kernel *k, const double l[3], double radius,
                       double low)
{
    if (k->kind >= SMITH) {
        const double x = l[0] + k->sv, up = l[2] + k->nv;
        const double peak = x * x + l[1] * l[1] + k->a2 * up * up;
        const double edge = k->kind == SMITH ? k->nv * k->alpha / k->v : k->v;
        return fmin(sqrt(peak), fmax(fmax(l[2], 0) + edge, low));
    }
    const double q = fmin(fmax(0.5 * (1 - l[2]), 0), 1);
    if (k->kind == GGX)
        return 2 * sqrt(q + k->a2 * (1 - q));
    if (k->kind == COSINE)
        return pi;
    const double psi = 2 * asin(sqrt(q));
    const double least = fmin(psi + radius, 1.57);
    const double most = fmin(fmax(psi - radius, 0), 1.57);
    const double largest = k->kind == CHARLIE ? 1 - cos(least) : cos(most);
    if (k->power * log(largest) < NOTHING)
        return pi;
    return k->kind == CHARLIE ? fmin(6 * k->alpha, fmax(psi, 1e-3))
                              : 3 * k->alpha;
}

/* A pixel or a part of one. */
typedef struct patch {
    double theta[2], phi[2], rgb[3];
} patch;

enum {
    PLANES = 4, /* through the origin; a patch is on the positive side of all */
    KNOTS = 2 + 4 * PLANES + PLANES * (PLANES - 1)
};

/* Azimuths within a patch that end smooth parts of what planes leave of it. */
static void add_knot(const patch *p, double phi, double *at, int *count)
{
    const double turns = floor((phi - p->phi[0]) / (2 * pi));

    if (isfinite(phi) && phi - 2 * pi * turns < p->phi[1])
        at[(*count)++] = phi - 2 * pi * turns;
}

/* 3 x 3 directions with their solid angles for each part of a patch between
 * its knots, where planes meet its parallels or each other. */
static int cut(const patch *p, const double (*plane)[3], int planes,
               double out[9 * KNOTS][4])
{
    const struct gauss *rule = &gauss[3];
    double at[KNOTS] = {p->phi[0], p->phi[1]};
    int knots = 2, count = 0;

    for (int n = 0; n < planes; n++) {
        const double *z = plane[n], middle = atan2(z[2], z[0]);
        const double lean = z[1] / hypot(z[0], z[2]);
        for (int m = 0; m < 2; m++) {
            const double away = acos(-lean / tan(p->theta[m]));
            add_knot(p, middle - away, at, &knots);
            add_knot(p, middle + away, at, &knots);
        }
        for (int m = 0; m < n; m++) {
            double corner[3];
            cross3(z, plane[m], corner);
            add_knot(p, atan2(corner[2], corner[0]), at, &knots);
            add_knot(p, atan2(-corner[2], -corner[0]), at, &knots);
        }
    }
    qsort(at, (size_t)knots, sizeof *at, ascending);
    for (int n = 0; n < 3 * (knots - 1); n++) {
        const double wide = at[n / 3 + 1] - at[n / 3];
        const double phi = at[n / 3] + wide * rule->node[n % 3];
        const double cp = cos(phi), sp = sin(phi);
        double from = p->theta[0], to = p->theta[1];
        for (int m = 0; m < planes; m++) {
            const double *z = plane[m];
            double top = atan2(z[0] * cp + z[2] * sp, z[1]);
            top += top < -0.5 * pi ? 2 * pi : 0;
            from = fmax(from, top - 0.5 * pi);
            to = fmin(to, top + 0.5 * pi);
        }
        for (int a = 0; a < 3 && wide > 0 && from < to; a++, count++) {
            const double theta = from + (to - from) * rule->node[a];
            const double st = sin(theta);
            out[count][0] = st * cp;
            out[count][1] = cos(theta);
            out[count][2] = st * sp;
            out[count][3] =
                st * wide * (to - from) * rule->mass[a] * rule->mass[n % 3];
        }
    }
    return count;
}

/* Adds what of a patch is above the horizon. */
static void add_cut(sum *s, const patch *p)
{
    const double(*axis)[3] = s->kernel->axis;
    double at[9 * KNOTS][4];
    const int count = cut(p, axis + 2, 1, at);

    for (int n = 0; n < count; n++) {
        const double l[3] = {dot3(axis[0], at[n]), dot3(axis[1], at[n]),
                             dot3(axis[2], at[n])};
        add(s, l, p->rgb, at[n][3], at[n][3]);
    }
}

/* A BRDF changes across the plane of the viewer 1 / V.H times as fast as in it:
 * edges count less the nearer they are to that plane. */
static void add_patch(sum *s, const patch *p)
{
    const kernel *k = s->kernel;
    const double tall = p->theta[1] - p->theta[0];
    const double turn = p->phi[1] - p->phi[0];
    const double theta = 0.5 * (p->theta[0] + p->theta[1]);
    const double phi = 0.5 * (p->phi[0] + p->phi[1]);
    const double ct = cos(theta), st = sin(theta), cp = cos(phi), sp = sin(phi);
    const double wide = turn * fmin(1, st + 0.5 * tall);
    const double radius = 0.51 * sqrt(tall * tall + wide * wide);
    double l[3], across[3][2], down = tall, along = wide;

    local(k, ct, st, cp, sp, l);
    if (fmax(tall, wide) < 1.5 && l[2] < -radius)
        return;
    if (k->kind >= SMITH) {
        const double x = l[0] + k->sv, up = l[2] + k->nv, *y = k->axis[1];
        const double vh2 = 0.25 * (x * x + l[1] * l[1] + up * up);
        const double south = ct * (cp * y[0] + sp * y[2]) - st * y[1];
        const double east = cp * y[2] - sp * y[0];
        down *= sqrt(fmin(1, vh2 + south * south));
        along *= sqrt(fmin(1, vh2 + east * east));
    }
    const double edge = fmax(down, along);
    const double reach = reach_at(k, l, radius, 0.03);
    if ((edge > reach / k->step && edge > SMALLEST / 16) || turn > 1 ||
        tall > 1) {
        patch half = *p;
        double *cut = along > down || turn > 1 ? half.phi : half.theta;
        const double middle = 0.5 * (cut[0] + cut[1]), end = cut[1];
        cut[1] = middle;
        add_patch(s, &half);
        cut[0] = middle;
        cut[1] = end;
        add_patch(s, &half);
        return;
    }
    if (l[2] < radius) {
        add_cut(s, p);
        return;
    }
    const int n = edge < 0.4 * reach / k->step ? 2 : 3;
    for (int b = 0; b < n; b++) {
        across[b][0] = cos(p->phi[0] + turn * gauss[n].node[b]);
        across[b][1] = sin(p->phi[0] + turn * gauss[n].node[b]);
    }
    for (int a = 0; a < n; a++) {
        const double t = p->theta[0] + tall * gauss[n].node[a];
        const double z = cos(t), r = sin(t);
        for (int b = 0; b < n; b++) {
            const double mass =
                r * tall * turn * gauss[n].mass[a] * gauss[n].mass[b];
            local(k, z, r, across[b][0], across[b][1], l);
            add(s, l, p->rgb, mass, mass);
        }
    }
}

/* Row j of a block of level 0, by the centres of its pixels. */
typedef struct line {
    double angle;      /* solid angle of a pixel */
    double light[RUN]; /* of that the part that its centre's weight counts */
    double miss[RUN];  /* weight that the centre may miss; -1: near a peak */
    double most;       /* the largest */
    run run;
} line;

/* False: all are below the horizon. */
static bool weigh_centres(const sum *s, int j, int x, line *p)
{
    const ibl_reference *ref = s->ref;
    const kernel *k = s->kernel;
    const double tall = pi / ref->env->height, st = ref->theta[j][1];
    const double wide = 2 * pi / ref->env->width * st;
    const double edge = tall > wide ? tall : wide;
    const double radius = 0.51 * hypot(tall, wide);
    const double *cp = ref->phi[0] + x, *sp = ref->phi[1] + x;
    double *const l[3] = {p->run.x, p->run.y, p->run.z};
    const double nearest = 0.16 / (k->step * k->step);
    double height[RUN], highest = -1;

    for (int n = 2; n >= 0; n--) {
        const double up = k->axis[n][1] * ref->theta[j][0];
        const double ahead = k->axis[n][0] * st, aside = k->axis[n][2] * st;
        for (int i = 0; i < RUN; i++)
            l[n][i] = up + ahead * cp[i] + aside * sp[i];
        for (int i = 0; n == 2 && i < RUN; i++)
            highest = l[2][i] > highest ? l[2][i] : highest;
        if (n == 2 && highest < -radius)
            return false;
    }
    for (int i = 0; i < RUN; i++) {
        height[i] = l[2][i];
        l[2][i] = l[2][i] > radius ? l[2][i] : radius;
    }
    weigh(k, &p->run);
    p->angle = wide * 2 * sin(0.5 * tall);
    p->most = 0;
    for (int i = 0; i < RUN; i++) {
        const double z = height[i], part2 = edge * edge / p->run.reach2[i];
        const double miss =
            z < radius ? 0.3 : 0.7 * part2 + 0.1 * sqrt(part2) * edge / z;
        const double above = z > 0 ? z / l[2][i] : 0;
        const bool near = part2 > nearest && z > -radius;
        p->light[i] = near ? 0 : p->angle * above;
        p->miss[i] = near ? -1 : z > -radius ? miss * p->run.f[0][i] : 0;
        p->most = p->miss[i] > p->most ? p->miss[i] : p->most;
    }
    return true;
}

static void add_pixel(sum *s, int j, int i)
{
    const float *rgb = s->ref->env->data +
                       3 * ((size_t)j * (size_t)s->ref->env->width + (size_t)i);
    const patch p = {{theta_of(s->ref, j), theta_of(s->ref, j + 1)},
                     {azimuth_of(s->ref, i), azimuth_of(s->ref, i + 1)},
                     {(double)rgb[0], (double)rgb[1], (double)rgb[2]}};

    add_patch(s, &p);
}

/* Adds a pixel by its centre times a factor. */
static void add_centre(sum *s, const line *p, const float *rgb, int i,
                       double factor)
{
    const double light = factor * p->light[i];

    for (int n = 0; n < 2; n++) {
        const double f = light * p->run.f[n][i];
        for (int c = 0; c < 3; c++)
            s->part[4 * n + c][i] += f * (double)rgb[c];
        s->part[4 * n + 3][i] += f;
    }
}

/* Adds the pixels of a block of level 0 by their centres, but exactly near the
 * peak. */
static void add_centres(sum *s, int row, int column)
{
    const int w = s->ref->env->width, h = s->ref->env->height;
    const int x = column * LEAF, n = w - x < LEAF ? w - x : LEAF;
    double most = 0;
    line p;

    for (int j = row * LEAF; j < (row + 1) * LEAF && j < h; j++) {
        const float *rgb =
            s->ref->env->data + 3 * ((size_t)j * (size_t)w + (size_t)x);
        if (!weigh_centres(s, j, x, &p))
            continue;
        most = fmax(most, p.most);
        for (int i = 0; i < n; i++, rgb += 3)
            if (p.miss[i] < 0)
                add_pixel(s, j, x + i);
            else
                add_centre(s, &p, rgb, i, 1);
    }
    s->list[s->count++] = (rough){0, row, column, most};
}

/* Adds exactly, in place of their centres, those that hold much of all light
 * for what the centre may miss. */
static void add_bright(sum *s, const rough *of, const double least[4])
{
    const int w = s->ref->env->width, h = s->ref->env->height;
    const int x = of->column * LEAF, n = w - x < LEAF ? w - x : LEAF;
    line p;

    for (int j = of->row * LEAF; j < (of->row + 1) * LEAF && j < h; j++) {
        const float *rgb =
            s->ref->env->data + 3 * ((size_t)j * (size_t)w + (size_t)x);
        const double angle = 2 * pi * pi / w / h * s->ref->theta[j][1];
        bool ready = false;
        for (int i = 0; i < n; i++, rgb += 3) {
            double much = 1 / least[3];
            for (int c = 0; c < 3; c++)
                much = fmax(much, (double)rgb[c] / least[c]);
            if (much * of->most * angle < 1)
                continue;
            if (!ready && !weigh_centres(s, j, x, &p))
                break;
            ready = true;
            if (much * p.miss[i] * p.angle > 1) {
                add_centre(s, &p, rgb, i, -1);
                add_pixel(s, j, x + i);
            }
        }
    }
}

/* Adds a block by its nodes, as many rows of them at once as there is room. */
static void add_nodes(sum *s, const band *row, const band *column,
                      const float *moments)
{
    const kernel *k = s->kernel;
    double *const l[3] = {s->run.x, s->run.y, s->run.z};

    if (s->waiting)
        flush(s);
    for (int a = 0; a < NODES; a++) {
        const int at = a * NODES % RUN;
        for (int n = 0; n < 3; n++) {
            const double up = k->axis[n][1] * row->c[a];
            const double ahead = k->axis[n][0] * row->s[a];
            const double aside = k->axis[n][2] * row->s[a];
            for (int b = 0; b < NODES; b++)
                l[n][at + b] = up + ahead * column->c[b] + aside * column->s[b];
        }
        for (int b = 0; b < NODES; b++)
            l[2][at + b] = l[2][at + b] > 0 ? l[2][at + b] : 0;
        for (int b = 0; b < NODES; b++) {
            for (int c = 0; c < 3; c++)
                s->value[c][at + b] =
                    (double)moments[(c * NODES + a) * NODES + b];
            s->value[3][at + b] = row->mass[a] * column->mass[b];
        }
        if (at + NODES == RUN)
            flush(s);
    }
}

/* Whether a block of a solid angle cannot give more light than counts. */
static bool is_dim(const sum *s, const double highest[3], const float *moments,
                   double angle)
{
    run p = {.x = {highest[0]}, .y = {highest[1]}, .z = {highest[2]}};
    bool dim = true;

    weigh(s->kernel, &p);
    for (int c = 0; c < 4 && dim; c++) {
        double flux = c < 3 ? 0 : angle;
        for (int n = 0; n < NODES * NODES && c < 3; n++)
            flux += (double)moments[c * NODES * NODES + n];
        dim = flux * p.f[0][0] * s->kernel->tolerance <
              s->kernel->dim * s->least[c];
    }
    return dim;
}

/* Smooth blocks that the horizon crosses wait until it is known how much light
 * counts: dim ones are then weighed at their nodes above it. */
static void add_block(sum *s, int k, int j, int i)
{
    const level *l = &s->ref->level[k];
    double at[3];

    if (j >= l->rows || i >= l->columns)
        return;
    const band *row = &l->row[j], *column = &l->column[i];
    const double tall = row->half, wide = column->half * row->widest;
    const double edge = fmax(tall, wide), radius = 1.02 * hypot(tall, wide);
    const bool fits = tall < WIDEST && column->half < WIDEST;
    local(s->kernel, row->middle[0], row->middle[1], column->middle[0],
          column->middle[1], at);
    if (fits && at[2] < -radius)
        return;
    const bool smooth =
        fits && s->kernel->near * edge < reach_at(s->kernel, at, radius, LOW);
    const bool crossed = at[2] < radius;
    if (smooth && crossed && (edge < 0.25 || !k) && !(s->least[3] > 0)) {
        s->later[s->later_count++] = (rough){k, j, i, 0};
        return;
    }
    at[2] += radius;
    if (smooth &&
        (!crossed || is_dim(s, at, moments_at(l, j, i), 4 * tall * wide))) {
        add_nodes(s, row, column, moments_at(l, j, i));
    } else if (k) {
        for (int n = 0; n < 4; n++)
            add_block(s, k - 1, 2 * j + n / 2, 2 * i + n % 2);
    } else {
        add_centres(s, j, i);
    }
}

static void find_least(sum *s)
{
    flush(s);
    for (int c = 0; c < 4; c++)
        s->least[c] = s->kernel->tolerance * total(s, c) + DBL_MIN;
}

/* All light by a kernel. */
static void add_all(sum *s, double out[SUMS])
{
    const int top = s->ref->levels - 1;
    const level *l = &s->ref->level[top];

    memset(s->part, 0, sizeof s->part);
    memset(s->value, 0, sizeof s->value);
    memset(s->least, 0, sizeof s->least);
    memset(&s->run, 0, sizeof s->run);
    s->count = s->later_count = 0;
    for (int n = 0; n < l->rows * l->columns; n++)
        add_block(s, top, n / l->columns, n % l->columns);
    find_least(s);
    for (const rough *r = s->later; r < s->later + s->later_count; r++)
        add_block(s, r->level, r->row, r->column);
    find_least(s);
    for (size_t n = 0; n < s->count; n++)
        add_bright(s, &s->list[n], s->least);
    flush(s);
    for (int n = 0; n < SUMS; n++)
        out[n] = total(s, n);
}

/* ---- the calls ---------------------------------------------------------- */

/* Directions, or pairs of normal and view, each with n kernels. */
typedef struct job {
    const ibl_reference *ref;
    enum kind kind;
    const double *roughness;
    int n;
    const double *normals, *views;
    size_t count;
    double *out;
    rough *lists; /* room for all blocks of each thread */
} job;

static size_t leaves(const ibl_reference *ref)
{
    return (size_t)ref->level[0].rows * (size_t)ref->level[0].columns;
}

/* The pixel that contains the reflected direction, in the map's frame. */
static void mirror(const ibl_reference *ref, const kernel *k, double rgb[3])
{
    const int w = ref->env->width, h = ref->env->height;
    double r[3];

    for (int n = 0; n < 3; n++)
        r[n] = k->nv * k->axis[2][n] - k->sv * k->axis[0][n];
    const double turns = atan2(r[2], r[0]) / (2 * pi) + 0.5;
    const int i = (int)floor(turns * w);
    const int j = (int)(atan2(hypot(r[0], r[2]), r[1]) / pi * h);
    const float *p =
        ref->env->data +
        3 * ((size_t)(j < h ? j : h - 1) * (size_t)w + (size_t)(i < w ? i : 0));
    for (int c = 0; c < 3; c++)
        rgb[c] = (double)p[c];
}

static void view_job(void *arg, int at, int worker)
{
    const job *all = arg;
    const size_t i = (size_t)at;
    double sums[SUMS];
    kernel k;
    sum s;

    s.ref = all->ref;
    s.kernel = &k;
    s.list = all->lists + 2 * (size_t)worker * leaves(all->ref);
    s.later = s.list + leaves(all->ref);
    s.waiting = 0;
    aim(all->ref, all->normals + 3 * i, all->views + 3 * i, &k);
    for (int n = 0; n < all->n; n++) {
        const double r = all->roughness[n];
        const bool lobe = all->kind < SMITH;
        double *out =
            all->out + (i * (size_t)all->n + (size_t)n) * (lobe ? 3 : SUMS);
        if (all->kind == COSINE || (r > 0 && r * r >= SMALLEST) ||
            (all->kind == CHARLIE && r > 0)) {
            shape(&k, all->kind, r * r, all->ref->coarse);
            add_all(&s, sums);
        } else { /* F0 and the rest of Schlick's term */
            const double miss = 1 - k.nv;
            k.scale = 1;
            mirror(all->ref, &k, sums);
            sums[3] = 1;
            for (int c = 0; c < 4; c++)
                sums[4 + c] = sums[c] * pow(miss, 5);
        }
        for (int c = 0; c < (lobe ? 3 : 4); c++) {
            if (lobe) {
                out[c] = sums[c] / sums[3];
                continue;
            }
            out[4 + c] = sums[4 + c] * k.scale;
            out[c] = sums[c] * k.scale - out[4 + c];
        }
    }
}

static ibl_status check_pointers(const ibl_reference *ref, size_t count,
                                 const void *in, const void *out)
{
    if (ref && (!count || (in && out)))
        return IBL_OK;
    return ibl_missing(ref ? ref->ctx : NULL,
                       "what a reference reads or writes");
}

static ibl_status check_job(const job *all, const void *out)
{
    const ibl_reference *ref = all->ref;
    const ibl_status status =
        check_pointers(ref, all->count, all->normals, out);

    if (status || !all->count)
        return status;
    if (!all->views || !all->roughness)
        return check_pointers(ref, 1, NULL, out);
    if (all->n < 1)
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                        "%d roughnesses: must be at least 1", all->n);
    for (int k = 0; k < all->n; k++)
        if (!(all->roughness[k] >= 0 && all->roughness[k] <= 1))
            return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                            "a roughness of %g: must be 0 to 1",
                            all->roughness[k]);
    for (size_t k = 0; k < 2 * all->count; k++) {
        const double *d = k < all->count ? all->normals + 3 * k
                                         : all->views + 3 * (k - all->count);
        const double length = hypot(hypot(d[0], d[1]), d[2]);
        if (!(length > 0) || !isfinite(length))
            return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                            "direction %zu is (%g, %g, %g): must be a unit "
                            "vector",
                            k % all->count, d[0], d[1], d[2]);
    }
    for (size_t k = 0; k < all->count; k++)
        if (!(dot3(all->normals + 3 * k, all->views + 3 * k) >= 0))
            return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                            "view %zu is below the surface", k);
    return IBL_OK;
}

static ibl_status run_all(job *all, double *out)
{
    const ibl_reference *ref = all->ref;
    ibl_status status = check_job(all, out);

    if (status)
        return status;
    all->out = out;
    all->lists = ibl_alloc_array((size_t)ibl_ctx_threads(ref->ctx),
                                 2 * leaves(ref) * sizeof *all->lists);
    if (!all->lists)
        return ibl_no_memory(ref->ctx, "the reference's sums");
    status = ibl_run(ref->ctx, NULL, (int)all->count, view_job, all);
    ibl_free(all->lists);
    return status;
}

ibl_status ibl_reference_lobe(const ibl_reference *ref, ibl_lobe lobe,
                              double roughness, const double *dirs,
                              size_t count, double *rgb)
{
    static const enum kind kinds[] = {[IBL_LOBE_GGX] = GGX,
                                      [IBL_LOBE_CHARLIE] = CHARLIE,
                                      [IBL_LOBE_PHONG] = PHONG};
    const ibl_status status = check_pointers(ref, count, dirs, rgb);

    if (status)
        return status;
    if (lobe < IBL_LOBE_GGX || lobe > IBL_LOBE_PHONG)
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT, "lobe %d: must be 0 to 2",
                        (int)lobe);
    job all = {ref, kinds[lobe], &roughness, 1, dirs, dirs, count, NULL, NULL};
    return run_all(&all, rgb);
}

ibl_status ibl_reference_irradiance(const ibl_reference *ref,
                                    const double *dirs, size_t count,
                                    double *rgb)
{
    const double any = 1;
    job all = {ref, COSINE, &any, 1, dirs, dirs, count, NULL, NULL};

    return run_all(&all, rgb);
}

ibl_status ibl_reference_brdf(const ibl_reference *ref, ibl_geometry geometry,
                              const double *roughness, int n,
                              const double *normals, const double *views,
                              size_t count, double *out)
{
    const ibl_status status = check_pointers(ref, 1, ref, ref);

    if (status || ibl_reference_check_geometry(ref->ctx, geometry))
        return status ? status : IBL_ERR_ARGUMENT;
    job all = {ref,       geometry == IBL_GEOMETRY_SMITH ? SMITH : SCHLICK,
               roughness, n,
               normals,   views,
               count,     NULL,
               NULL};
    return run_all(&all, out);
}

/* ---- harmonics ---------------------------------------------------------- */

enum {
    SH_JOBS = 16
};

struct harmonics {
    const ibl_reference *ref;
    int degree, n, parts; /* n x n points in each of parts x parts of a pixel */
    double *sums;         /* of each job */
};

/* Adds every Y_lm at a direction, times a flux, by the recurrence in l of
 * normalised functions: with the polar axis +Z, P_mm times cos(m phi) and
 * sin(m phi) are the parts of (x + i y)^m. */
static void add_harmonics(int degree, const double d[3], const double rgb[3],
                          double *sums)
{
    double re = sqrt(1 / (4 * pi)), im = 0;

    for (int m = 0; m <= degree; m++) {
        const double m2 = (double)m * m;
        double p = 1, before = 0;
        if (m) {
            const double k = sqrt((2 * m + 1.0) / (m == 1 ? 1 : 2 * m));
            const double next = k * (re * d[0] - im * d[1]);
            im = k * (re * d[1] + im * d[0]);
            re = next;
        }
        for (int l = m; l <= degree; l++) {
            const double l2 = (double)l * l, n2 = (l + 1.0) * (l + 1.0);
            for (int c = 0; c < 3; c++) {
                sums[3 * (l * (l + 1) - m) + c] += m ? p * im * rgb[c] : 0;
                sums[3 * (l * (l + 1) + m) + c] += p * re * rgb[c];
            }
            const double next =
                sqrt((4 * n2 - 1) / (n2 - m2)) *
                (d[2] * p - sqrt((l2 - m2) / (4 * l2 - 1)) * before);
            before = p;
            p = next;
        }
    }
}

static void harmonics_job(void *arg, int part, int worker)
{
    const struct harmonics *h = arg;
    const ibl_image *env = h->ref->env;
    const int across = h->n * h->parts, w = env->width * across;
    const int rows = env->height * across;
    const double *mass = gauss[h->n].mass, *place = gauss[h->n].node;
    double *sums = h->sums + 3 * (size_t)part * (size_t)(h->degree + 1) *
                                 (size_t)(h->degree + 1);
    (void)worker;

    for (int j = rows * part / SH_JOBS; j < rows * (part + 1) / SH_JOBS; j++) {
        const double theta =
            theta_of(h->ref, (j / h->n + place[j % h->n]) / h->parts);
        const double ct = cos(theta), st = sin(theta);
        const float *p =
            env->data + 3 * (size_t)(j / across) * (size_t)env->width;
        if (ibl_cancelled(h->ref->ctx))
            return;
        for (int i = 0; i < w; i++) {
            const double phi =
                azimuth_of(h->ref, (i / h->n + place[i % h->n]) / h->parts) -
                h->ref->yaw;
            const double angle = st * mass[j % h->n] * mass[i % h->n] * 2 * pi *
                                 pi / env->height / env->width / h->parts /
                                 h->parts;
            const float *at = p + 3 * (i / across);
            const double rgb[3] = {angle * (double)at[0], angle * (double)at[1],
                                   angle * (double)at[2]};
            const double d[3] = {st * cos(phi), ct, st * sin(phi)};
            add_harmonics(h->degree, d, rgb, sums);
        }
    }
}

ibl_status ibl_reference_sh(const ibl_reference *ref, int degree,
                            double *coeffs)
{
    ibl_status status = check_pointers(ref, 1, ref, coeffs);
    if (status)
        return status;
    if (degree < 0 || degree > IBL_MAX_SH_DEGREE)
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                        "degree %d of a reference: must be 0 to %d", degree,
                        IBL_MAX_SH_DEGREE);
    const size_t count = 3 * (size_t)(degree + 1) * (size_t)(degree + 1);
    const double pixel =
        (degree + 1) * fmax(pi / ref->env->height, 2 * pi / ref->env->width);
    struct harmonics h = {ref, degree, pixel < 0.02 ? 2 : 3,
                          (int)ceil(2 * pixel),
                          ibl_alloc_zeroed(SH_JOBS * count, sizeof *h.sums)};
    status = h.sums ? ibl_run(ref->ctx, NULL, SH_JOBS, harmonics_job, &h)
                    : ibl_no_memory(ref->ctx, "the reference's harmonics");
    memset(coeffs, 0, status ? 0 : count * sizeof *coeffs);
    for (size_t k = 0; k < SH_JOBS * count && !status; k++)
        coeffs[k % count] += h.sums[k];
    ibl_free(h.sums);
    return status;
}

ibl_status ibl_reference_mean(const ibl_reference *ref, double rgb[3])
{
    const ibl_status status = check_pointers(ref, 1, ref, rgb);
    const level *l = status ? NULL : &ref->level[ref->levels - 1];

    for (int c = 0; c < 3 && !status; c++)
        rgb[c] = 0;
    for (int k = 0; !status && k < 3 * NODES * NODES * l->rows * l->columns;
         k++)
        rgb[k / NODES / NODES % 3] += (double)l->moments[k] / (4 * pi);
    return status;
}

/* ---- texels of level 0 -------------------------------------------------- */

struct texels {
    const ibl_reference *ref;
    ibl_projection projection;
    int size;
    int finer_x, finer_y; /* finer pixels per pixel of the source */
    int columns, rows;    /* of finer pixels */
    double *bend;         /* for each two adjacent rows: see find_bends */
    const ibl_texel *texel;
    double *rgb;
};

/* The point of the octahedron |x| + |y| + |z| = 1 over a point of its map. */
static void lift(double u, double v, double d[3])
{
    const bool below = fabs(u) + fabs(v) > 1;

    d[0] = below ? copysign(1 - fabs(v), u) : u;
    d[1] = 1 - fabs(u) - fabs(v);
    d[2] = below ? copysign(1 - fabs(u), v) : v;
}

/*
 * The planes that enclose a texel, whose edges they meet. An octahedral one is
 * two triangles, `half` 1 the one away from the map's middle: the equator
 * crosses some along their diagonal. Of an equirectangular one the planes are
 * its meridians; theta: its parallels.
 */
static int planes_of(const struct texels *t, ibl_texel at, int half,
                     double plane[PLANES][3], double theta[2])
{
    /* For each face the directions of u = v = 0, of u and of v. */
    static const double axes[6][3][3] = {{{1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
                                         {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
                                         {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},
                                         {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
                                         {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},
                                         {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}}};
    const double n = t->size;
    int count = t->projection == IBL_PROJECTION_EQUIRECT ? 2 : 4;
    double d[3][3];

    theta[0] = 0;
    theta[1] = pi;
    for (int side = 0; side < count; side++) {
        const int sign = side % 2 ? -1 : 1;
        const double place = (side < 2 ? at.x : at.y) + side % 2;
        const double phi = 2 * pi * place / (4 * n) - pi;
        for (int k = 0; k < 3; k++)
            plane[side][k] =
                count == 2 ? sign * (k ? (k - 1) * cos(phi) : -sin(phi))
                           : sign * (axes[at.face][1 + side / 2][k] -
                                     (2 * place / n - 1) * axes[at.face][0][k]);
    }
    if (t->projection == IBL_PROJECTION_EQUIRECT) {
        theta[0] = pi * at.y / (2 * n);
        theta[1] = pi * (at.y + 1) / (2 * n);
    } else if (t->projection == IBL_PROJECTION_OCTAHEDRAL) {
        const int out_x = at.x >= n, out_y = at.y >= n;
        const double u[2] = {(at.x + 1 - out_x) / n - 1,
                             (at.x + out_x) / n - 1};
        const double v[2] = {(at.y + 1 - out_y) / n - 1,
                             (at.y + out_y) / n - 1};
        lift(u[half], v[half], d[0]);
        lift(u[1], v[0], d[1]);
        lift(u[0], v[1], d[2]);
        for (count = 0; count < 3; count++) {
            cross3(d[count], d[(count + 1) % 3], plane[count]);
            const double side = dot3(plane[count], d[(count + 2) % 3]);
            for (int k = 0; k < 3; k++)
                plane[count][k] *= side < 0 ? -1 : 1;
        }
    }
    for (int k = 0; k < count; k++)
        into_map(t->ref, plane[k], plane[k]);
    return count;
}

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
        double lacks = 0, takes = 0;
        for (int row = first; row < first + t->finer_y; row++) {
            const double w = (row + 0.5) / t->finer_y - 0.5 - j;
            const double zone = sin(pi * (row + 0.5) / t->rows);
            lacks += ((w > 0.5) - w) * zone;
            takes += w * (1 - w) * zone;
        }
        t->bend[j] = takes > 0 ? lacks / takes : 0;
    }
}

/* The value of a finer pixel, which may be a pixel of the source. A row beyond
 * a pole is the row at the pole, half a turn away. */
static void pixel_value(const struct texels *t, int row, int column,
                        double rgb[3])
{
    const ibl_image *env = t->ref->env;
    const int w = env->width, h = env->height;
    const double x = (column + 0.5) / t->finer_x - 0.5;
    const double y = (row + 0.5) / t->finer_y - 0.5, part = y - floor(y);
    const int upper = (int)floor(y);
    const bool inside = upper >= 0 && upper < h - 1;
    const double lower =
        part + (inside ? t->bend[upper] * part * (1 - part) : 0);

    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int k = 0; k < 4; k++) {
        const int j = upper + k / 2, at = j < 0 ? 0 : j < h ? j : h - 1;
        const double turned = j == at ? x : x + 0.5 * w;
        const double right = turned - floor(turned);
        const int i = ((int)floor(turned) + k % 2 + w) % w;
        const double weight =
            (k / 2 ? lower : 1 - lower) * (k % 2 ? right : 1 - right);
        const float *p = env->data + 3 * ((size_t)at * (size_t)w + (size_t)i);
        for (int c = 0; c < 3 && weight > 0; c++)
            rgb[c] += weight * (double)p[c];
    }
}

/* Adds what planes enclose of rows j.. and columns i.. of finer pixels. */
static void add_range(const struct texels *t, const double (*plane)[3],
                      int planes, const double theta[2], const int j[2],
                      const int i[2], double all[4])
{
    const patch p = {{fmax(pi * j[0] / t->rows, theta[0]),
                      fmin(pi * j[1] / t->rows, theta[1])},
                     {2 * pi * ((double)i[0] / t->columns - 0.5),
                      2 * pi * ((double)i[1] / t->columns - 0.5)},
                     {0}};
    const double turn = p.phi[1] - p.phi[0], tall = p.theta[1] - p.theta[0];
    const double middle = 0.5 * (p.theta[0] + p.theta[1]);
    const double phi = 0.5 * (p.phi[0] + p.phi[1]);
    const double radius =
        turn > 1 ? pi : 0.51 * hypot(tall, turn * (sin(middle) + 0.5 * tall));
    const double d[3] = {sin(middle) * cos(phi), cos(middle),
                         sin(middle) * sin(phi)};
    double at[9 * KNOTS][4], rgb[3];

    if (tall <= 0)
        return;
    for (int k = 0; k < planes; k++)
        if (dot3(plane[k], d) < -radius)
            return;
    if (j[1] - j[0] > 1 || i[1] - i[0] > 1) {
        const bool wide = turn > tall ? i[1] - i[0] > 1 : j[1] - j[0] <= 1;
        const int *of = wide ? i : j, half = (of[0] + of[1]) / 2;
        for (int k = 0; k < 2; k++) {
            const int part[2] = {k ? half : of[0], k ? of[1] : half};
            add_range(t, plane, planes, theta, wide ? j : part, wide ? part : i,
                      all);
        }
        return;
    }
    pixel_value(t, j[0], i[0], rgb);
    for (int n = cut(&p, plane, planes, at); n-- > 0;)
        for (int c = 0; c < 4; c++)
            all[c] += at[n][3] * (c < 3 ? rgb[c] : 1);
}

static void texel_job(void *arg, int at, int worker)
{
    const struct texels *t = arg;
    const int halves = t->projection == IBL_PROJECTION_OCTAHEDRAL ? 2 : 1;
    const int j[2] = {0, t->rows}, i[2] = {0, t->columns};
    double all[4] = {0}, plane[PLANES][3], theta[2];
    (void)worker;

    for (int half = 0; half < halves; half++) {
        const int planes = planes_of(t, t->texel[at], half, plane, theta);
        add_range(t, (const double(*)[3])plane, planes, theta, j, i, all);
    }
    for (int c = 0; c < 3; c++)
        t->rgb[3 * at + c] = all[c] / all[3];
}

/* The smallest count with count n >= least. */
static int parts(int n, int least)
{
    return (least + n - 1) / n;
}

ibl_status ibl_reference_texels(const ibl_reference *ref,
                                ibl_projection projection, int base, int size,
                                const ibl_texel *texels, size_t count,
                                double *rgb)
{
    ibl_status status = check_pointers(ref, count, texels, rgb);
    if (status)
        return status;
    if (size < 1 || base < size || base > IBL_MAX_CUBE_SIZE ||
        projection < IBL_PROJECTION_CUBE ||
        projection > IBL_PROJECTION_OCTAHEDRAL)
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                        "texels of size %d of %d, projection %d: must be 1 to "
                        "%d, and a projection 0 to 2",
                        size, base, (int)projection, IBL_MAX_CUBE_SIZE);
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
    /* The finer grid that <ibl/ibl.h> defines for the size of level 0. */
    const int w = ref->env->width, h = ref->env->height;
    struct texels t = {ref, projection, size, 1, 1, w, h, NULL, texels, rgb};
    if (w < 4 * base || h < 2 * base) {
        t.finer_x = parts(w, 4 * base > 512 ? 4 * base : 512);
        t.finer_x += t.finer_x * w % 2;
        t.finer_y = parts(h, 2 * base);
        t.columns = w * t.finer_x;
        t.rows = h * t.finer_y;
    }
    t.bend = ibl_alloc_array((size_t)h, sizeof *t.bend);
    if (!t.bend)
        return ibl_no_memory(ref->ctx, "the reference's rows");
    find_bends(&t);
    status = ibl_run(ref->ctx, NULL, (int)count, texel_job, &t);
    ibl_free(t.bend);
    return status;
}

double ibl_relative_error(const double rgb[3], const double truth[3],
                          const double mean[3])
{
    const double floor = IBL_RELATIVE_FLOOR * sqrt(dot3(mean, mean));
    const double scale = fmax(sqrt(dot3(truth, truth)), floor);

    /* FLT_MIN keeps the errors of a black map finite. */
    return distance3(rgb, truth) / fmax(scale, (double)FLT_MIN);
}
