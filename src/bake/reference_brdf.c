/* SPDX-License-Identifier: MIT */
/*
 * What a surface reflects: the whole BRDF, or lobes of many roughnesses, over
 * the pixels as constant patches.
 *
 * A pixel is one point at its centre where the integrand changes slowly over
 * it. Elsewhere it is divided into halves, along its longer edge, until 2 x 2
 * Gauss points are enough. With H = (V + L) / |V + L|, D_ggx is 1 / t^2 with
 * t = (s2 + a2 c2) / h2 as in kern/reflection.h, and changes over sqrt(t). A
 * patch with edges of at most p moves H by at most p / sqrt(h2). So only
 * q = s2 + a2 c2 counts:
 *   q >= (30 p)^2  one point misses 16/24 (p / 30 p)^2 < 1e-3 of the patch's
 *                  light, from the second derivative of psi^-4, GGX's tail
 *   q >= (6 p)^2   2 x 2 points miss (1/6)^4 / 5 < 2e-4
 * Within 2 p above the horizon 2 x 2 points are used, too; patches that it
 * crosses are divided down to CROSSING. All roughnesses of a view share its
 * points, which are those for the smallest alpha.
 */
#include <string.h>

#include "bake/reference_sums.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/vector.h"
#include "kern/reflection.h"

enum {
    BLOCK = IBL_REFLECTION_BLOCK,
    GROUP = 8,  /* views in a job */
    DEPTH = 40, /* halvings of an edge, enough for SMALLEST */
    SUMS = IBL_REFERENCE_BRDF
};

static const double pi = REFERENCE_PI;
static const double CROSSING = 4e-3; /* radians */
/* A smaller alpha is a mirror's: of its light, less than (alpha / p)^2 comes
 * from beyond the pixel. */
static const double SMALLEST = 1e-7;

/* ---- what is summed --------------------------------------------------- */

/* A rotation about an axis. */
typedef struct turn {
    double c, s;
} turn;

/* An edge that was halved d times; rotations are from its centre. */
typedef struct edge {
    double length[DEPTH]; /* radians */
    turn half[DEPTH];     /* to its ends */
    turn quarter[DEPTH];  /* to the centres of its halves */
    turn gauss[DEPTH];    /* to its two Gauss points */
} edge;

typedef struct sums {
    const ibl_reference *ref;
    ibl_reflection_dsp dsp;
    ibl_reflection_kind kind;
    const double *roughness;
    size_t step; /* from a view's roughnesses to the next view's; 0: the same */
    int n;       /* roughnesses of a view */
    const double *normals, *views;
    size_t count;
    edge theta, phi;
    int width;             /* columns of a row, a multiple of BLOCK */
    double *cos_phi;       /* of the pixels' centres */
    double *sin_phi;       /* ... */
    struct worker *worker; /* one for each thread */
    double *out;
} sums;

/* A roughness as a viewer sees it. */
typedef struct blur {
    ibl_reflection_shape shape;
    double scale; /* of the sums */
    bool mirror;
} blur;

/* Axes of the surface's frame, in the map's frame: Z is the normal, the viewer
 * is at (sv, 0, nv). */
typedef struct view {
    double axis[3][3];
    double sv, nv;
    const double *normal, *view; /* as given */
    blur *blurs;
    double a2; /* the smallest */
    double *out;
} view;

/* Points of parts of pixels, until a block is full. */
typedef struct worker {
    double *rgb; /* a row's colours: R, G, B of `width` pixels each */
    blur *blurs; /* n for each view of a job */
    ibl_reflection_points row, part;
    double part_rgb[3 * BLOCK];
    int parts;
} worker;

static turn turn_of(double angle)
{
    return (turn){cos(angle), sin(angle)};
}

static turn turned(turn a, turn by, int sign)
{
    return (turn){a.c * by.c - sign * a.s * by.s,
                  a.s * by.c + sign * a.c * by.s};
}

static edge edge_of(double length)
{
    edge e;

    for (int d = 0; d < DEPTH; d++) {
        const double now = ldexp(length, -d);
        e.length[d] = now;
        e.half[d] = turn_of(0.5 * now);
        e.quarter[d] = turn_of(0.25 * now);
        e.gauss[d] = turn_of(0.5 * now * ibl_reference_gauss(2)->node[1]);
    }
    return e;
}

/* ---- one view --------------------------------------------------------- */

/* D G / (4 N.L N.V) N.L in terms of what the kernel sums. */
static blur blur_of(ibl_reflection_kind kind, double nv, double roughness)
{
    const double alpha = roughness * roughness, a2 = alpha * alpha;
    const double k = 0.5 * alpha;
    blur b = {{kind, a2, nv, 0}, 1, alpha < SMALLEST};

    switch (kind) {
    case IBL_REFLECTION_SMITH:
        b.shape.v = sqrt(a2 + (1 - a2) * nv * nv);
        b.scale = a2 / (2 * pi);
        break;
    case IBL_REFLECTION_SCHLICK:
        b.shape.v = k;
        b.scale = a2 / (4 * pi * (k + (1 - k) * nv));
        break;
    case IBL_REFLECTION_LOBE:
        break;
    }
    return b;
}

/* Turns a direction into the map's frame. */
static void into_map(const ibl_reference *ref, const double dir[3],
                     double out[3])
{
    const double c = cos(ref->yaw), s = sin(ref->yaw);

    out[0] = c * dir[0] - s * dir[2];
    out[1] = dir[1];
    out[2] = s * dir[0] + c * dir[2];
    unit3(out);
}

static view view_of(const sums *s, size_t i, blur *blurs)
{
    const double *roughness = s->roughness + i * s->step;
    view v = {.normal = s->normals + 3 * i,
              .view = s->views + 3 * i,
              .blurs = blurs,
              .a2 = 1,
              .out = s->out + i * (size_t)s->n * SUMS};
    double to[3], *x = v.axis[0], *y = v.axis[1], *z = v.axis[2];

    into_map(s->ref, v.normal, z);
    into_map(s->ref, v.view, to);
    cross3(z, to, y);
    v.sv = sqrt(dot3(y, y));
    v.nv = fmax(dot3(z, to), 0);
    if (!unit3(y)) {
        const double other[3] = {fabs(z[0]) < 0.5, fabs(z[0]) >= 0.5, 0};
        cross3(z, other, y);
        unit3(y);
    }
    cross3(y, z, x);
    for (int k = 0; k < s->n; k++) {
        blurs[k] = blur_of(s->kind, v.nv, roughness[k]);
        if (!blurs[k].mirror)
            v.a2 = fmin(v.a2, blurs[k].shape.a2);
    }
    memset(v.out, 0, (size_t)s->n * SUMS * sizeof *v.out);
    return v;
}

static void add_points(const sums *s, const view *v,
                       const ibl_reflection_points *p, const double *rgb,
                       int stride, int count)
{
    for (int k = 0; k < s->n; k++)
        if (!v->blurs[k].mirror)
            s->dsp.add(&v->blurs[k].shape, p, rgb, (size_t)stride, count,
                       v->out + SUMS * k);
}

/* ---- parts of a pixel ------------------------------------------------- */

/* A part of a pixel: its centre, and how often its edges were halved. */
typedef struct part {
    turn theta, phi;
    int tall, wide;
} part;

static void flush(const sums *s, const view *v, worker *w)
{
    const int count = (w->parts + 7) & ~7;

    for (int i = w->parts; i < count; i++)
        w->part.z[i] = w->part.c2[i] = w->part.s2[i] = 1, w->part.mass[i] = 0;
    add_points(s, v, &w->part, w->part_rgb, BLOCK, count);
    w->parts = 0;
}

/* The direction in the surface's frame. */
static void place(const view *v, turn theta, turn phi, double l[3])
{
    const double dir[3] = {theta.s * phi.c, theta.c, theta.s * phi.s};

    for (int k = 0; k < 3; k++)
        l[k] = dot3(v->axis[k], dir);
}

static void add_point(const sums *s, const view *v, worker *w, turn theta,
                      turn phi, double area, const double rgb[3])
{
    const int i = w->parts;
    double l[3];

    place(v, theta, phi, l);
    if (!(l[2] > 0))
        return;
    const double x = l[0] + v->sv, z = l[2] + v->nv;
    const double s2 = x * x + l[1] * l[1], c2 = z * z, h2 = s2 + c2;
    const double miss = 1 - 0.5 * sqrt(h2);
    w->part.z[i] = l[2];
    w->part.s2[i] = s2;
    w->part.c2[i] = c2;
    w->part.mass[i] = area * theta.s * l[2] * h2 * h2;
    w->part.fc[i] = miss * miss * (miss * miss) * miss;
    for (int c = 0; c < 3; c++)
        w->part_rgb[c * BLOCK + i] = rgb[c];
    if (++w->parts == BLOCK)
        flush(s, v, w);
}

/* The larger edge of a part, at the widest of its rows. *wider: it is the one
 * along a row. */
static double larger_edge(const sums *s, const part *p, bool *wider)
{
    const double tall = s->theta.length[p->tall];
    const turn half = s->theta.half[p->tall];
    const double widest = p->theta.s * half.c + fabs(p->theta.c) * half.s;
    const double wide = s->phi.length[p->wide] * (widest < 1 ? widest : 1);

    *wider = wide > tall;
    return wide > tall ? wide : tall;
}

/* Whether 2 x 2 points are too few. */
static bool is_coarse(const view *v, const part *p, double size)
{
    double l[3];

    place(v, p->theta, p->phi, l);
    const double x = l[0] + v->sv, z = l[2] + v->nv;
    const double q = x * x + l[1] * l[1] + v->a2 * z * z;
    const bool below = l[2] < -0.71 * size;
    const bool crossing = l[2] < 0.71 * size && size > CROSSING;
    return !below && (q < 36 * size * size || crossing) &&
           p->tall + 1 < DEPTH && p->wide + 1 < DEPTH;
}

static void add_part(const sums *s, const view *v, worker *w, part p,
                     const double rgb[3])
{
    const double area = s->theta.length[p.tall] * s->phi.length[p.wide] / 4;
    bool wider;

    if (is_coarse(v, &p, larger_edge(s, &p, &wider))) {
        const turn by =
            wider ? s->phi.quarter[p.wide++] : s->theta.quarter[p.tall++];
        for (int sign = -1; sign < 2; sign += 2) {
            part half = p;
            turn *at = wider ? &half.phi : &half.theta;
            *at = turned(*at, by, sign);
            add_part(s, v, w, half, rgb);
        }
        return;
    }
    for (int k = 0; k < 4; k++)
        add_point(
            s, v, w, turned(p.theta, s->theta.gauss[p.tall], k & 1 ? 1 : -1),
            turned(p.phi, s->phi.gauss[p.wide], k & 2 ? 1 : -1), area, rgb);
}

/* ---- rows ------------------------------------------------------------- */

static ibl_reflection_row row_of(const sums *s, const view *v, turn theta,
                                 double size)
{
    const int w = s->ref->env->width;
    ibl_reflection_row row = {.sv = v->sv,
                              .nv = v->nv,
                              .wide = v->a2,
                              .least = 900 * size * size,
                              .low = 2 * size};

    for (int k = 0; k < 3; k++) {
        row.at[k] = v->axis[k][1] * theta.c;
        row.ahead[k] = v->axis[k][0] * theta.s;
        row.aside[k] = v->axis[k][2] * theta.s;
    }
    /* cos(theta0) - cos(theta1) times a pixel's width. */
    row.solid_angle = 2 * theta.s * s->theta.half[0].s * (2 * pi / w);
    return row;
}

/* Whether a block of columns can reach higher than z. */
static bool is_above(const sums *s, const ibl_reflection_row *row, int first,
                     double z)
{
    const int middle = first + BLOCK / 2;
    const double half = (0.5 * BLOCK + 1) * s->phi.length[0];
    const double z0 = row->at[2] + row->ahead[2] * s->cos_phi[middle] +
                      row->aside[2] * s->sin_phi[middle];

    return z0 + half * hypot(row->ahead[2], row->aside[2]) > z;
}

/* Adds n pixels from column `first` on that place() left out, in parts. */
static void add_rest(const sums *s, const view *v, worker *w, part pixel,
                     double size, int first, int n)
{
    for (int i = 0; i < n; i++) {
        const double *rgb = w->rgb + first + i;
        const double at[3] = {rgb[0], rgb[s->width], rgb[2 * s->width]};
        if (w->row.mass[i] > 0 || w->row.z[i] <= -size)
            continue;
        pixel.phi = (turn){s->cos_phi[first + i], s->sin_phi[first + i]};
        add_part(s, v, w, pixel, at);
    }
}

static void add_row(const sums *s, const view *v, worker *w, turn theta)
{
    const int columns = s->ref->env->width;
    const part pixel = {.theta = theta};
    bool wider;
    const double size = larger_edge(s, &pixel, &wider);
    const ibl_reflection_row row = row_of(s, v, theta, size);

    for (int first = 0; first < columns; first += BLOCK) {
        const int left = columns - first, n = left < BLOCK ? left : BLOCK;
        if (!is_above(s, &row, first, -size))
            continue;
        const int whole = s->dsp.place(&row, s->cos_phi + first,
                                       s->sin_phi + first, n, &w->row);
        if (whole < n)
            add_rest(s, v, w, pixel, size, first, n);
        if (whole)
            add_points(s, v, &w->row, w->rgb + first, s->width, BLOCK);
    }
    flush(s, v, w);
}

static void convert_row(const sums *s, int j, double *rgb)
{
    const int w = s->ref->env->width;
    const float *p = s->ref->env->data + 3 * (size_t)j * (size_t)w;

    for (int i = 0; i < w; i++)
        for (int c = 0; c < 3; c++)
            rgb[c * s->width + i] = (double)p[3 * i + c];
}

/* ---- many views ------------------------------------------------------- */

/* R = 2 (N.V) N - V. */
static void mirror(const sums *s, const view *v, double out[SUMS])
{
    const double fc = pow(1 - v->nv, 5);
    double n[3], to[3], r[3], rgb[4] = {0, 0, 0, 1};

    memcpy(n, v->normal, sizeof n);
    memcpy(to, v->view, sizeof to);
    unit3(n);
    unit3(to);
    for (int k = 0; k < 3; k++)
        r[k] = 2 * v->nv * n[k] - to[k];
    ibl_reference_mirror(s->ref, r, rgb);
    for (int c = 0; c < 4; c++) {
        out[c] = rgb[c];
        out[4 + c] = fc * rgb[c];
    }
}

/* From sums of w and w Fc to those of the factor of F0 and of the rest. */
static void finish(const sums *s, const view *v)
{
    for (int k = 0; k < s->n; k++) {
        double *out = v->out + SUMS * k;
        const double scale = v->blurs[k].mirror ? 1 : v->blurs[k].scale;
        if (v->blurs[k].mirror)
            mirror(s, v, out);
        for (int c = 0; c < 4 && s->kind != IBL_REFLECTION_LOBE; c++) {
            out[4 + c] *= scale;
            out[c] = out[c] * scale - out[4 + c];
        }
    }
}

static void sums_job(void *arg, int job, int thread)
{
    const sums *s = arg;
    const size_t first = (size_t)job * GROUP, left = s->count - first;
    const int n = left < GROUP ? (int)left : GROUP, h = s->ref->env->height;
    worker *w = &s->worker[thread];
    view v[GROUP];

    for (int k = 0; k < n; k++)
        v[k] = view_of(s, first + (size_t)k, w->blurs + k * s->n);
    for (int j = 0; j < h && !ibl_cancelled(s->ref->ctx); j++) {
        const turn theta = turn_of(pi * (j + 0.5) / h);
        convert_row(s, j, w->rgb);
        for (int k = 0; k < n; k++)
            add_row(s, &v[k], w, theta);
    }
    for (int k = 0; k < n; k++)
        finish(s, &v[k]);
}

static void free_worker(worker *w)
{
    ibl_free(w->rgb);
    ibl_free(w->blurs);
}

static bool make_worker(const sums *s, worker *w)
{
    w->rgb = ibl_alloc_zeroed(3 * (size_t)s->width, sizeof *w->rgb);
    w->blurs = ibl_alloc_array(GROUP * (size_t)s->n, sizeof *w->blurs);
    return w->rgb && w->blurs;
}

static void free_sums(sums *s)
{
    for (int i = 0; s->worker && i < ibl_ctx_threads(s->ref->ctx); i++)
        free_worker(&s->worker[i]);
    ibl_free(s->worker);
    ibl_free(s->cos_phi);
    ibl_free(s->sin_phi);
}

static bool make_tables(sums *s)
{
    const int w = s->ref->env->width, h = s->ref->env->height;
    const int threads = ibl_ctx_threads(s->ref->ctx);
    bool ok = true;

    s->theta = edge_of(pi / h);
    s->phi = edge_of(2 * pi / w);
    s->width = (w + BLOCK - 1) / BLOCK * BLOCK;
    s->cos_phi = ibl_alloc_zeroed((size_t)s->width, sizeof *s->cos_phi);
    s->sin_phi = ibl_alloc_zeroed((size_t)s->width, sizeof *s->sin_phi);
    s->worker = ibl_alloc_zeroed((size_t)threads, sizeof *s->worker);
    for (int i = 0; i < threads && s->worker && ok; i++)
        ok = make_worker(s, &s->worker[i]);
    if (!ok || !s->worker || !s->cos_phi || !s->sin_phi)
        return false;
    for (int i = 0; i < s->width; i++) {
        const double phi = 2 * pi * ((i + 0.5) / w - 0.5);
        s->cos_phi[i] = cos(phi);
        s->sin_phi[i] = sin(phi);
    }
    return true;
}

static ibl_status run(sums *s)
{
    ibl_reflection_dsp_init(&s->dsp, ibl_ctx_isa(s->ref->ctx));
    const ibl_status status =
        make_tables(s)
            ? ibl_run(s->ref->ctx, NULL, (int)((s->count + GROUP - 1) / GROUP),
                      sums_job, s)
            : ibl_no_memory(s->ref->ctx, "the reference's sums");
    free_sums(s);
    return status;
}

/* ---- the calls -------------------------------------------------------- */

static ibl_status check_roughness(const ibl_reference *ref,
                                  const double *roughness, int n, size_t count)
{
    if (n < 1)
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                        "%d roughnesses: must be at least 1", n);
    for (size_t k = 0; k < (size_t)n * count; k++)
        if (!(roughness[k] >= 0 && roughness[k] <= 1))
            return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                            "a roughness of %g: must be 0 to 1", roughness[k]);
    return IBL_OK;
}

static ibl_status check_views(const ibl_reference *ref, const double *normals,
                              const double *views, size_t count)
{
    for (size_t k = 0; k < 3 * count; k += 3)
        if (!(dot3(normals + k, views + k) >= 0))
            return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                            "view %zu is below the surface", k / 3);
    return IBL_OK;
}

/* out: the caller's pointer for the results. */
static ibl_status check(const sums *s, const void *out)
{
    const ibl_reference *ref = s->ref;
    ibl_status status = ibl_reference_check(ref, s->count, s->normals, out);
    if (!status)
        status = ibl_reference_check(ref, s->count, s->views, s->roughness);
    if (!status)
        status =
            check_roughness(ref, s->roughness, s->n, s->step ? s->count : 1);
    if (!status)
        status = ibl_reference_check_dirs(ref, s->normals, s->count);
    if (!status)
        status = ibl_reference_check_dirs(ref, s->views, s->count);
    return status ? status : check_views(ref, s->normals, s->views, s->count);
}

ibl_status ibl_reference_brdf(const ibl_reference *ref, ibl_geometry geometry,
                              const double *roughness, int n,
                              const double *normals, const double *views,
                              size_t count, double *out)
{
    sums s = {ref,
              .kind = geometry == IBL_GEOMETRY_SMITH ? IBL_REFLECTION_SMITH
                                                     : IBL_REFLECTION_SCHLICK,
              .roughness = roughness,
              .n = n,
              .normals = normals,
              .views = views,
              .count = count,
              .out = out};
    ibl_status status = check(&s, out);
    if (!status)
        status = ibl_reference_check_geometry(ref->ctx, geometry);
    return status ? status : run(&s);
}

ibl_status ibl_reference_lobes(const ibl_reference *ref,
                               const double *roughness, int n,
                               const double *dirs, size_t count, double *rgb)
{
    sums s = {ref,
              .kind = IBL_REFLECTION_LOBE,
              .roughness = roughness,
              .step = (size_t)n,
              .n = n,
              .normals = dirs,
              .views = dirs,
              .count = count};
    ibl_status status = check(&s, rgb);
    if (status)
        return status;
    s.out = ibl_alloc_array((size_t)n * count, SUMS * sizeof *s.out);
    if (!s.out)
        return ibl_no_memory(ref->ctx, "the reference's sums");
    status = run(&s);
    for (size_t k = 0; k < (size_t)n * count && !status; k++)
        for (int c = 0; c < 3; c++)
            rgb[3 * k + (size_t)c] =
                s.out[SUMS * k + (size_t)c] / s.out[SUMS * k + 3];
    ibl_free(s.out);
    return status;
}
