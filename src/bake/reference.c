/* SPDX-License-Identifier: MIT */
/*
 * The reference integrals: a direction's sums over all pixels of the source. A
 * pixel is a patch of constant radiance; its weight is the lobe's integral.
 *
 * Where the lobe is smooth, 2 x 2 or 3 x 3 Gauss points in theta and phi are
 * enough, with sin(theta) in the integrand. Let a be the length over which the
 * weight changes and p the larger edge of a pixel. Two points miss at most
 * (p / a)^4 / 5 of a pixel's weight, three (p / a)^6 / 33 (from the fourth and
 * the sixth derivative of psi^-4, GGX's tail). Two are used from a = 40 p,
 * three from a = 9 p: errors below 1e-7. Nearer pixels, and those within a
 * pixel of the horizon, where the weight has a kink, use ibl_reference_patches.
 *
 * With N = V = R and c = cos(psi) = 1 - 2 q,
 *     D_ggx N.L = a2 c / (pi t^2),   t = q + a2 (1 - q).
 * (a2 / t)^2 is used in place of 1 / t^2: it is 1 at the peak, and constants
 * cancel in the quotient.
 *
 * A job takes a few directions over all rows and converts a row's pixels once.
 * Sums inside a row are plain, in LANES parts, with all terms >= 0. Rows are
 * added with compensation.
 */
#include <float.h>
#include <string.h>

#include "bake/reference_sums.h"
#include "brdf/lobe.h"
#include "core/alloc.h"
#include "core/context.h"
#include "image/image.h"

enum {
    LANES = 2, /* with more, registers spill */
    RUN = 16,  /* patches in one call */
    GROUP = 8  /* directions in a job */
};

static const double pi = REFERENCE_PI;

/* ---- create ----------------------------------------------------------- */

const ibl_gauss *ibl_reference_gauss(int n)
{
    static const ibl_gauss rules[] = {
        [2] = {{-0.577350269189625765, 0.577350269189625765}, {1, 1}},
        [3] = {{-0.774596669241483377, 0, 0.774596669241483377},
               {5.0 / 9, 8.0 / 9, 5.0 / 9}},
        [4] = {{-0.861136311594052575, -0.339981043584856265,
                0.339981043584856265, 0.861136311594052575},
               {0.347854845137453857, 0.652145154862546143,
                0.652145154862546143, 0.347854845137453857}},
        [6] = {{-0.932469514203152028, -0.661209386466264514,
                -0.238619186083196909, 0.238619186083196909,
                0.661209386466264514, 0.932469514203152028},
               {0.171324492379170345, 0.360761573048138608,
                0.467913934572691047, 0.467913934572691047,
                0.360761573048138608, 0.171324492379170345}},
        [8] = {
            {-0.960289856497536232, -0.796666477413626740,
             -0.525532409916328986, -0.183434642495649805, 0.183434642495649805,
             0.525532409916328986, 0.796666477413626740, 0.960289856497536232},
            {0.101228536290376259, 0.222381034453374471, 0.313706645877887287,
             0.362683783378361983, 0.362683783378361983, 0.313706645877887287,
             0.222381034453374471, 0.101228536290376259}}};

    return &rules[n];
}

/* Index in the tables of the first point of the rule n = 2 or 3. */
static size_t points_at(const ibl_reference *ref, int n)
{
    return (n == 2 ? 0 : 2) * ((size_t)ref->env->width + 1);
}

static void fill_tables(ibl_reference *ref)
{
    const int w = ref->env->width;

    for (int n = 2; n <= 3; n++) {
        double *c = ref->cos_phi + points_at(ref, n);
        double *s = ref->sin_phi + points_at(ref, n);
        for (int k = 0; k < n; k++) {
            const double at = 0.5 + 0.5 * ibl_reference_gauss(n)->node[k];
            for (int i = 0; i <= w; i++) {
                const double phi = 2 * pi * ((i + at) / w - 0.5);
                *c++ = cos(phi);
                *s++ = sin(phi);
            }
        }
    }
}

ibl_status ibl_reference_check(const ibl_reference *ref, size_t count,
                               const void *in, const void *out)
{
    if (ref && (!count || (in && out)))
        return IBL_OK;
    return ibl_missing(ref ? ref->ctx : NULL,
                       "what a reference reads or writes");
}

ibl_status ibl_reference_create(ibl_ctx *ctx, const ibl_image *env,
                                double yaw_deg, ibl_reference **out)
{
    if (!out)
        return ibl_missing(ctx, "ibl_reference_create: out");
    *out = NULL;
    const ibl_status status = ibl_check_image(ctx, env);
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
    const size_t points = REFERENCE_POINTS * ((size_t)env->width + 1);
    ref->cos_phi = ibl_alloc_array(points, sizeof(double));
    ref->sin_phi = ibl_alloc_array(points, sizeof(double));
    if (!ref->cos_phi || !ref->sin_phi) {
        ibl_reference_free(ref);
        return ibl_no_memory(ctx, "the reference's tables");
    }
    fill_tables(ref);
    *out = ref;
    return IBL_OK;
}

void ibl_reference_free(ibl_reference *ref)
{
    if (!ref)
        return;
    ibl_free(ref->cos_phi);
    ibl_free(ref->sin_phi);
    ibl_free(ref);
}

static ibl_aim aim_at(const ibl_reference *ref, const double dir[3])
{
    const double across = hypot(dir[0], dir[2]);
    const double phi = atan2(dir[2], dir[0]) + ref->yaw;

    const double length = hypot(across, dir[1]);

    return (ibl_aim){atan2(across, dir[1]), remainder(phi, 2 * pi),
                     across / length, dir[1] / length};
}

/* ---- lobes ------------------------------------------------------------ */

/* How a pixel is integrated, by q of its centre, from the aim outwards. */
enum kind {
    NONE,
    PATCH,
    NINE,
    FOUR,
    KINDS = 6 /* limits of PATCH, NINE, FOUR, NINE, PATCH */
};

struct lobe {
    ibl_weight weight;
    double inner[2]; /* below these q: patches; nine points */
    double outer[2]; /* above these q: nine points; patches */
};

/* Uses points where the weight changes slowly. Around the peak, and along the
 * horizon if the weight is not smooth there, it uses patches. */
static struct lobe lobe_of(const ibl_reference *ref, ibl_lobe which,
                           double alpha)
{
    const double p = fmax(pi / ref->env->height, 2 * pi / ref->env->width);
    struct lobe lobe = {ibl_reference_weight(which, alpha), {0, 0}, {1, 1}};
    const ibl_weight *w = &lobe.weight;

    for (int k = 0; k < 2; k++) {
        const double least = (k ? 40 : 9) * p, t = 0.25 * least * least;
        if (w->ring)
            lobe.inner[k] = 10 * w->alpha < least ? 1 : t;
        else if (!(w->width > 0))
            lobe.inner[k] = t <= w->a2 ? 0
                            : t >= 1   ? 1
                                       : (t - w->a2) / (1 - w->a2);
        else if (w->width < least)
            lobe.outer[!k] = 0;
        else if (w->fractional)
            lobe.outer[!k] = 0.5 - least / 6;
    }
    return lobe;
}

/* q of the angle of q plus `more` radians. */
static double moved_out(double q, double more)
{
    const double s = sin(fmin(fmax(asin(sqrt(q)) + 0.5 * more, 0), 0.5 * pi));

    return s * s;
}

/* Finds where the kinds end in row j, as q of the pixels' centres. A pixel
 * reaches no further from its centre than half its diagonal. */
static void find_limits(const ibl_reference *ref, const struct lobe *lobe,
                        int j, double limit[KINDS])
{
    const double tall = pi / ref->env->height;
    const double below = tall * (j + 1), above = tall * j;
    const double widest =
        above < 0.5 * pi && below > 0.5 * pi ? 1 : fmax(sin(above), sin(below));
    const double reach = 0.51 * hypot(tall, 2 * pi / ref->env->width * widest);
    const double horizon = 0.5 - 0.5 * sin(fmin(reach, 0.5 * pi));
    const ibl_weight *w = &lobe->weight;
    const double all[KINDS] = {w->least > 0 ? moved_out(w->least, -reach) : 0,
                               fmin(lobe->inner[0], horizon),
                               fmin(lobe->inner[1], horizon),
                               fmin(lobe->outer[0], horizon),
                               fmin(lobe->outer[1], horizon),
                               w->most < 0.5 ? moved_out(w->most, reach)
                                             : 1 - horizon};

    limit[0] = all[0];
    for (int k = 1; k < KINDS; k++)
        limit[k] = fmax(limit[k - 1], fmin(all[k], all[KINDS - 1]));
}

/* ---- points ----------------------------------------------------------- */

/* A row as seen from a direction, with n points in theta. There
 * cos(psi) = c0 + c1 cos(y), y the azimuth from the aim. mass: sin(theta) times
 * a point's part of the row's height, times half a pixel's width. */
struct row {
    const ibl_reference *ref;
    const struct lobe *lobe;
    const ibl_aim *aim;
    int j, n;
    double c0[3], c1[3], mass[3];
};

static struct row row_of(const ibl_reference *ref, const struct lobe *lobe,
                         const ibl_aim *aim, int j, int n)
{
    const double tall = pi / ref->env->height, wide = 2 * pi / ref->env->width;
    struct row row = {.ref = ref, .lobe = lobe, .aim = aim, .j = j, .n = n};

    for (int k = 0; k < n; k++) {
        const ibl_gauss *rule = ibl_reference_gauss(n);
        const double theta = tall * (j + 0.5 + 0.5 * rule->node[k]);
        const double s = sin(theta);
        row.c0[k] = cos(aim->theta) * cos(theta);
        row.c1[k] = aim->sin_theta * s;
        row.mass[k] = s * rule->mass[k] * 0.25 * tall * wide;
    }
    return row;
}

/* Adds columns begin..end - 1 by points, for any lobe. */
static void add_points(const struct row *row, const double *rgb, int begin,
                       int end, double sum[4])
{
    const size_t stride = (size_t)row->ref->env->width + 1;
    const double *c = row->ref->cos_phi + points_at(row->ref, row->n);
    const double *s = row->ref->sin_phi + points_at(row->ref, row->n);
    const double ahead = cos(row->aim->phi), aside = sin(row->aim->phi);

    for (int i = begin; i < end; i++) {
        double weight = 0;
        for (int k = 0; k < row->n; k++) {
            const size_t at = (size_t)k * stride + (size_t)i;
            const double y = c[at] * ahead + s[at] * aside;
            double line = 0;
            for (int g = 0; g < row->n; g++)
                line += row->mass[g] *
                        ibl_reference_weight_at(&row->lobe->weight,
                                                row->c0[g] + row->c1[g] * y);
            weight += line * ibl_reference_gauss(row->n)->mass[k];
        }
        for (int n = 0; n < 3; n++)
            sum[n] += weight * rgb[(size_t)n * stride + (size_t)i];
        sum[3] += weight;
    }
}

/* LANES doubles, a vector type of gcc and clang for any machine. load() needs
 * no alignment. */
typedef double lanes __attribute__((vector_size(LANES * sizeof(double))));

static lanes load(const double *from)
{
    lanes v;

    memcpy(&v, from, sizeof v);
    return v;
}

/* GGX at 2 x 2 points: w = c a2^2 / t^2 with t = t0 + t1 cos(y). c0 and c1
 * include the constant factors. */
struct four {
    double t0[2], t1[2], c0[2], c1[2];
};

/* Sum of two points in theta, with one division. */
static inline lanes pair(const struct four *f, lanes y)
{
    const lanes t = f->t0[0] + f->t1[0] * y, u = f->t0[1] + f->t1[1] * y;
    const lanes c = f->c0[0] + f->c1[0] * y, d = f->c0[1] + f->c1[1] * y;
    const lanes r = 1 / (t * u);

    return (c * (u * u) + d * (t * t)) * (r * r);
}

static void add_four(const struct row *row, const double *rgb, int begin,
                     int end, double sum[4])
{
    const size_t stride = (size_t)row->ref->env->width + 1;
    const double *c = row->ref->cos_phi, *s = row->ref->sin_phi;
    const double ahead = cos(row->aim->phi), aside = sin(row->aim->phi);
    const double a2 = row->lobe->weight.a2;
    struct four f;
    lanes part[4] = {{0}};

    for (int k = 0; k < 2; k++) {
        f.t0[k] = 0.5 * (1 + a2) - 0.5 * (1 - a2) * row->c0[k];
        f.t1[k] = -0.5 * (1 - a2) * row->c1[k];
        f.c0[k] = a2 * a2 * row->mass[k] * row->c0[k];
        f.c1[k] = a2 * a2 * row->mass[k] * row->c1[k];
    }
    for (int i = begin; i < end; i += LANES) {
        lanes w = pair(&f, load(c + i) * ahead + load(s + i) * aside) +
                  pair(&f, load(c + stride + i) * ahead +
                               load(s + stride + i) * aside);
        if (i + 1 == end)
            w[1] = 0;
        for (int n = 0; n < 3; n++)
            part[n] += w * load(rgb + (size_t)n * stride + i);
        part[3] += w;
    }
    for (int n = 0; n < 4; n++)
        sum[n] += part[n][0] + part[n][1];
}

/* ---- patches ---------------------------------------------------------- */

/* Adds columns begin..end - 1 by patches. Columns wrap around the map. */
static void add_patches(const struct row *row, const double *rgb, int begin,
                        int end, ibl_exact sum[4])
{
    const int w = row->ref->env->width;
    const size_t stride = (size_t)w + 1;
    ibl_pixels run = {w, row->ref->env->height, row->j, begin, end};
    double weight[RUN];

    for (; run.begin < end && !ibl_cancelled(row->ref->ctx);
         run.begin = run.end) {
        run.end = end - run.begin < RUN ? end : run.begin + RUN;
        ibl_reference_patches(row->aim, &row->lobe->weight, &run, weight);
        for (int i = run.begin; i < run.end; i++) {
            const double of = weight[i - run.begin];
            for (int n = 0; n < 3; n++)
                ibl_exact_add(
                    &sum[n],
                    of * rgb[(size_t)n * stride + (size_t)((i + w) % w)]);
            ibl_exact_add(&sum[3], of);
        }
    }
}

/* ---- one row ---------------------------------------------------------- */

static void add_columns(const struct row *row, const double *rgb, int begin,
                        int end, double sum[4])
{
    const int w = row->ref->env->width;
    void (*const add)(const struct row *, const double *, int, int, double *) =
        row->n == 2 && row->lobe->weight.lobe == IBL_LOBE_GGX ? add_four
                                                              : add_points;

    /* Columns beyond the left and the right border wrap around. */
    if (begin < 0)
        add(row, rgb, begin + w, (end < 0 ? end : 0) + w, sum);
    if (begin < w && end > 0)
        add(row, rgb, begin > 0 ? begin : 0, end < w ? end : w, sum);
    if (end > w)
        add(row, rgb, begin > w ? begin - w : 0, end - w, sum);
}

/* Where the kinds end in a row: numbers of columns to the left and to the right
 * of `first`, the first column that is not left of the aim. */
struct sides {
    int first, left[KINDS], right[KINDS];
};

static int clamped(double x, int most)
{
    return x < 0 ? 0 : x < most ? (int)x : most;
}

static void find_sides(const ibl_reference *ref, const ibl_aim *aim,
                       double polar, double scale, const double limit[KINDS],
                       struct sides *s)
{
    const int w = ref->env->width;
    const double at = (aim->phi / (2 * pi) + 0.5) * w;

    s->first = (int)ceil(at - 0.5);
    const double right = s->first + 0.5 - at;
    const int most = (w + (right < 0.5)) / 2;
    for (int k = 0; k < KINDS; k++) {
        const double of = limit[k] - polar;
        /* In columns: at most half a turn, or w for all. */
        const double reach = of <= 0 ? 0
                             : of >= scale
                                 ? w
                                 : 2 * asin(sqrt(of / scale)) / (2 * pi) * w;
        s->right[k] = clamped(ceil(reach - right), most);
        s->left[k] = clamped(ceil(reach - (1 - right)), w - most);
    }
}

static void add_row(const ibl_reference *ref, const struct lobe *lobe,
                    const ibl_aim *aim, int j, const double *rgb,
                    ibl_exact sum[4])
{
    static const int points[KINDS - 1] = {0, 3, 2, 3, 0};
    const double theta = pi * (j + 0.5) / ref->env->height;
    const double half = sin(0.5 * (theta - aim->theta)), polar = half * half;
    double limit[KINDS], plain[4] = {0};
    struct sides s;

    find_limits(ref, lobe, j, limit);
    if (polar >= limit[KINDS - 1])
        return;
    find_sides(ref, aim, polar, sin(theta) * aim->sin_theta, limit, &s);
    for (int k = 0; k < KINDS - 1; k++) {
        if (s.left[k + 1] == s.left[k] && s.right[k + 1] == s.right[k])
            continue;
        const struct row row = row_of(ref, lobe, aim, j, points[k]);
        const int at[4] = {s.first - s.left[k + 1], s.first - s.left[k],
                           s.first + s.right[k], s.first + s.right[k + 1]};
        for (int side = 0; side < 4; side += 2) {
            if (row.n)
                add_columns(&row, rgb, at[side], at[side + 1], plain);
            else
                add_patches(&row, rgb, at[side], at[side + 1], sum);
        }
    }
    for (int c = 0; c < 4; c++)
        ibl_exact_add(&sum[c], plain[c]);
}

/* ---- many directions -------------------------------------------------- */

struct sums {
    const ibl_reference *ref;
    struct lobe lobe;
    const double *dirs;
    size_t count;
    double *scratch; /* a row's colours, for each worker */
    double *rgb;
};

static size_t scratch_size(const ibl_reference *ref)
{
    return 3 * ((size_t)ref->env->width + 1);
}

static void convert_row(const ibl_reference *ref, int j, double *rgb)
{
    const int w = ref->env->width, stride = w + 1;
    const float *p = ref->env->data + 3 * (size_t)j * (size_t)w;

    for (int i = 0; i < w; i++) {
        rgb[i] = (double)p[3 * i];
        rgb[stride + i] = (double)p[3 * i + 1];
        rgb[2 * stride + i] = (double)p[3 * i + 2];
    }
}

void ibl_reference_mirror(const ibl_reference *ref, const double dir[3],
                          double rgb[3])
{
    const int w = ref->env->width, h = ref->env->height;
    const ibl_aim aim = aim_at(ref, dir);
    const int i = (int)floor((aim.phi / (2 * pi) + 0.5) * w);
    const int j = (int)(aim.theta / pi * h);
    const size_t at =
        (size_t)(j < h ? j : h - 1) * (size_t)w + (size_t)(i < 0 ? 0 : i % w);

    for (int c = 0; c < 3; c++)
        rgb[c] = (double)ref->env->data[3 * at + (size_t)c];
}

/* Makes a group's quotients; with no weight, takes the pixel's colour. */
static void sums_job(void *arg, int job, int worker)
{
    const struct sums *s = arg;
    const ibl_reference *ref = s->ref;
    const size_t first = (size_t)job * GROUP, left = s->count - first;
    const int n = left < GROUP ? (int)left : GROUP;
    double *colours = s->scratch + (size_t)worker * scratch_size(ref);
    ibl_exact sum[GROUP][4] = {{{0, 0}}};
    ibl_aim aim[GROUP];

    for (int k = 0; k < n; k++)
        aim[k] = aim_at(ref, s->dirs + 3 * (first + (size_t)k));
    for (int j = 0; j < ref->env->height && !ibl_cancelled(ref->ctx); j++) {
        convert_row(ref, j, colours);
        for (int k = 0; k < n; k++)
            add_row(ref, &s->lobe, &aim[k], j, colours, sum[k]);
    }
    for (int k = 0; k < n; k++) {
        const double weight = ibl_exact_total(&sum[k][3]);
        const size_t at = 3 * (first + (size_t)k);
        for (int c = 0; c < 3; c++)
            s->rgb[at + (size_t)c] = ibl_exact_total(&sum[k][c]) / weight;
        if (!(weight > 0))
            ibl_reference_mirror(ref, s->dirs + at, s->rgb + at);
    }
}

ibl_status ibl_reference_check_dirs(const ibl_reference *ref,
                                    const double *dirs, size_t count)
{
    for (size_t k = 0; k < count; k++) {
        const double *d = dirs + 3 * k;
        const double length = hypot(hypot(d[0], d[1]), d[2]);
        if (!(length > 0) || !isfinite(length))
            return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                            "direction %zu is (%g, %g, %g): must be a unit "
                            "vector",
                            k, d[0], d[1], d[2]);
    }
    return IBL_OK;
}

static ibl_status run_sums(const ibl_reference *ref, struct lobe lobe,
                           const double *dirs, size_t count, double *rgb)
{
    const size_t threads = (size_t)ibl_ctx_threads(ref->ctx);
    struct sums s = {ref, lobe, dirs, count, NULL, rgb};

    s.scratch = ibl_alloc_zeroed(threads, scratch_size(ref) * sizeof(double));
    if (!s.scratch)
        return ibl_no_memory(ref->ctx, "the reference's sums");
    const ibl_status status = ibl_run(
        ref->ctx, NULL, (int)((count + GROUP - 1) / GROUP), sums_job, &s);
    ibl_free(s.scratch);
    return status;
}

/* ---- the calls -------------------------------------------------------- */

ibl_status ibl_reference_lobe(const ibl_reference *ref, ibl_lobe lobe,
                              double roughness, const double *dirs,
                              size_t count, double *rgb)
{
    ibl_status status = ibl_reference_check(ref, count, dirs, rgb);
    if (status)
        return status;
    status = ibl_lobe_check(ref->ctx, lobe);
    if (status)
        return status;
    if (!(roughness >= 0 && roughness <= 1))
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                        "a roughness of %g: must be 0 to 1", roughness);
    status = ibl_reference_check_dirs(ref, dirs, count);
    if (status)
        return status;
    const double alpha = roughness * roughness;
    /* The part of a narrower lobe outside the pixel is less than alpha^2 times
     * the square of the number of pixels: negligible even against the whole
     * range of floats, 1e84. */
    if (!(alpha > 0) || ibl_reference_weight(lobe, alpha).alpha < 1e-75) {
        for (size_t k = 0; k < count; k++)
            ibl_reference_mirror(ref, dirs + 3 * k, rgb + 3 * k);
        return ibl_cancelled(ref->ctx) ? IBL_ERR_CANCELLED : IBL_OK;
    }
    return run_sums(ref, lobe_of(ref, lobe, alpha), dirs, count, rgb);
}

ibl_status ibl_reference_specular(const ibl_reference *ref, double roughness,
                                  const double *dirs, size_t count, double *rgb)
{
    return ibl_reference_lobe(ref, IBL_LOBE_GGX, roughness, dirs, count, rgb);
}

/* At roughness 1 the lobe is the cosine. */
ibl_status ibl_reference_irradiance(const ibl_reference *ref,
                                    const double *dirs, size_t count,
                                    double *rgb)
{
    return ibl_reference_lobe(ref, IBL_LOBE_GGX, 1, dirs, count, rgb);
}

/* ---- errors ------------------------------------------------------------ */

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

double ibl_relative_error(const double rgb[3], const double truth[3],
                          const double mean[3])
{
    const double d[3] = {rgb[0] - truth[0], rgb[1] - truth[1],
                         rgb[2] - truth[2]};
    const double floor = IBL_RELATIVE_FLOOR * length(mean);
    const double scale = fmax(length(truth), floor);
    /* FLT_MIN keeps the errors of a black map finite. */
    return length(d) / fmax(scale, (double)FLT_MIN);
}
