/* SPDX-License-Identifier: MIT */
/*
 * Irradiance as the sum over every pixel of the source, at a cost of a few
 * operations per texel and row. For a normal N = (sn cos p, cn, sn sin p) and
 * a row at the polar angle t,
 *     N.L = sn sin(t) cos(phi - p) + cn cos(t) > 0
 * holds on one arc around p, of half width acos(-cn cos(t) / (sn sin(t))),
 * and N.L is linear in L: the sum over the arc is N . sum of L d dO, which is
 * two records of a prefix sum along the row (kern/arc.h).
 *
 * The arc's width depends on |cn| and its sign alone, which up to 16 texels
 * of a cube share: those are handled together, as a family.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "bake/hemisphere.h"
#include "bake/irradiance.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "kern/arc.h"

static const double pi = IBL_PI;

enum {
    FAMILY_TEXELS = 16,
    CHUNK_FAMILIES = 2048, /* bounds the memory of large cubes */
    JOB_FAMILIES = 16,
    MIN_ROWS = 4,
    MAX_ROWS = 32
};

/* Bytes of prefix sums at a time, about what a core's cache holds. */
static const size_t rows_bytes = 1 << 20;

struct texel {
    double normal[3]; /* turned into the map's own frame */
    double centre;    /* its azimuth in columns */
    double sum[IBL_ARC_LANES];
    float *out;
};

struct family {
    double sine, cosine; /* of the angle from the pole, cosine >= 0 */
    int texels;
    struct texel texel[FAMILY_TEXELS];
};

struct bake {
    const ibl_image *env;
    ibl_cube *out;
    double cos_yaw, sin_yaw;
    double *turn; /* cos, sin of each column */
    double *tilt; /* cos, sin of each row */
    double *sums;
    struct family *families;
    int64_t first_family; /* number of families[0] */
    int family_count;
    int first_row;
    ibl_arc_rows rows;
    ibl_arc_dsp dsp;
    bool has_mean;
    double mean[3]; /* of the map, once a texel has asked for it */
};

/* Solid angle of a pixel of a row; sine is that of the row's centre. */
static double pixel_angle(const ibl_image *env, double sine)
{
    return 4.0 * pi / env->width * sine * sin(0.5 * pi / env->height);
}

/* ---- families -------------------------------------------------------- */

static void add_texel(const struct bake *b, struct family *f, int face, int x,
                      int y)
{
    const int n = b->out->size, w = b->env->width;
    struct texel *t = &f->texel[f->texels++];
    double dir[3];

    ibl_cube_direction(n, face, x, y, dir);
    memset(t->sum, 0, sizeof t->sum);
    t->normal[0] = dir[0] * b->cos_yaw - dir[2] * b->sin_yaw;
    t->normal[1] = dir[1];
    t->normal[2] = dir[2] * b->cos_yaw + dir[0] * b->sin_yaw;
    t->centre = (atan2(t->normal[2], t->normal[0]) / (2.0 * pi) + 0.5) * w;
    if (t->centre >= w)
        t->centre -= w;
    t->out = ibl_cube_face(b->out, 0, face) + 3 * ((size_t)y * n + x);
}

/* The texels (x, y) and those mirrored from it, each once. */
static void add_mirrored(const struct bake *b, struct family *f, int face,
                         int x, int y)
{
    const int last = b->out->size - 1;

    add_texel(b, f, face, x, y);
    if (last - x != x)
        add_texel(b, f, face, last - x, y);
    if (last - y != y)
        add_texel(b, f, face, x, last - y);
    if (last - x != x && last - y != y)
        add_texel(b, f, face, last - x, last - y);
}

/*
 * Family number k of a cube: first those of the four side faces, one for each
 * texel of a quarter face, then those of the top and the bottom, for which
 * (x, y) and (y, x) are alike, so that half of the numbers have no texels.
 */
static void make_family(const struct bake *b, int64_t k, struct family *f)
{
    static const int sides[] = {0, 1, 4, 5};
    const int half = (b->out->size + 1) / 2;
    const int64_t quarter = (int64_t)half * half;
    const int x = (int)(k % half), y = (int)(k % quarter / half);

    f->texels = 0;
    if (k < quarter) {
        for (int i = 0; i < 4; i++)
            add_mirrored(b, f, sides[i], x, y);
    } else if (x <= y) {
        for (int face = 2; face < 4; face++) {
            add_mirrored(b, f, face, x, y);
            if (x != y)
                add_mirrored(b, f, face, y, x);
        }
    }
    if (f->texels) {
        const double *n = f->texel[0].normal;
        f->cosine = fabs(n[1]);
        f->sine = hypot(n[0], n[2]);
    }
}

/* ---- sums ----------------------------------------------------------- */

static void prefix_job(void *arg, int job, int worker)
{
    const struct bake *b = arg;
    const ibl_image *env = b->env;
    const size_t row = (size_t)(b->first_row + job), w = (size_t)env->width;
    const double cosine = b->tilt[2 * row], sine = b->tilt[2 * row + 1];
    const double angle = pixel_angle(env, sine);
    (void)worker;

    b->dsp.prefix(env->data + 3 * row * w, env->width, b->turn, sine * angle,
                  cosine * angle,
                  b->sums + (size_t)job * (w + 1) * IBL_ARC_LANES);
}

/* Half widths of the visible arcs, in columns, for the family's normals that
 * point up (cosine >= 0) and for those that point down. */
static void arcs(const struct bake *b, const struct family *f,
                 double up[MAX_ROWS], double down[MAX_ROWS])
{
    const double width = b->env->width;

    for (int r = 0; r < b->rows.rows; r++) {
        const double *tilt = b->tilt + 2 * (size_t)(b->first_row + r);
        const double level = f->sine * tilt[1], rise = f->cosine * tilt[0];
        if (rise >= level) {
            up[r] = INFINITY;
            down[r] = 0.0;
        } else if (rise <= -level) {
            up[r] = 0.0;
            down[r] = INFINITY;
        } else {
            up[r] = acos(-rise / level) / (2.0 * pi) * width;
            down[r] = 0.5 * width - up[r];
        }
    }
}

static void sum_job(void *arg, int job, int worker)
{
    const struct bake *b = arg;
    const int first = job * JOB_FAMILIES;
    double up[MAX_ROWS], down[MAX_ROWS];
    (void)worker;

    for (int k = first; k < first + JOB_FAMILIES && k < b->family_count; k++) {
        struct family *f = &b->families[k];
        if (!f->texels)
            continue;
        arcs(b, f, up, down);
        for (int i = 0; i < f->texels; i++) {
            struct texel *t = &f->texel[i];
            b->dsp.add(&b->rows, t->centre, t->normal[1] < 0.0 ? down : up,
                       t->sum);
        }
    }
}

static void family_job(void *arg, int job, int worker)
{
    const struct bake *b = arg;
    (void)worker;

    make_family(b, b->first_family + job, &b->families[job]);
}

/* ---- results -------------------------------------------------------- */

/* Mean radiance of the map, for normals that have no pixel's centre above
 * their horizon: that takes a map of one or two columns or rows. */
static const double *mean_radiance(struct bake *b)
{
    const float *p = b->env->data;

    if (b->has_mean)
        return b->mean;
    for (int j = 0; j < b->env->height; j++) {
        const double angle = pixel_angle(b->env, b->tilt[2 * (size_t)j + 1]);
        for (int i = 0; i < b->env->width; i++, p += 3) {
            for (int k = 0; k < 3; k++)
                b->mean[k] += p[k] * angle / (4.0 * pi);
        }
    }
    b->has_mean = true;
    return b->mean;
}

static void finish_texel(struct bake *b, const struct texel *t)
{
    const double *n = t->normal, *s = t->sum;
    double rgb[4];

    for (int k = 0; k < 4; k++)
        rgb[k] = n[0] * s[k] + n[2] * s[4 + k] + n[1] * s[8 + k];
    if (rgb[3] < 1e-12) {
        memcpy(rgb, mean_radiance(b), sizeof b->mean);
        rgb[3] = 1.0;
    }
    for (int k = 0; k < 3; k++)
        t->out[k] = rgb[k] > 0.0 ? (float)(rgb[k] / rgb[3]) : 0.0f;
}

/* All rows, for the families in hand. */
static ibl_status sum_rows(ibl_ctx *ctx, struct bake *b, int rows, double begin,
                           double share)
{
    const int height = b->env->height;
    const int jobs = (b->family_count + JOB_FAMILIES - 1) / JOB_FAMILIES;
    ibl_status status;

    for (int row = 0; row < height; row += rows) {
        const int count = height - row < rows ? height - row : rows;
        b->first_row = row;
        b->rows = (ibl_arc_rows){b->sums, count, b->env->width};
        ibl_progress(ctx, "irradiance", begin + share * row / height);
        status = ibl_run(ctx, NULL, count, prefix_job, b);
        if (!status)
            status = ibl_run(ctx, NULL, jobs, sum_job, b);
        if (status)
            return status;
    }
    return IBL_OK;
}

static ibl_status sum_cube(ibl_ctx *ctx, struct bake *b, int rows)
{
    const int64_t half = (b->out->size + 1) / 2, all = 2 * half * half;
    ibl_status status;

    for (int64_t k = 0; k < all; k += CHUNK_FAMILIES) {
        b->first_family = k;
        b->family_count =
            (int)(all - k < CHUNK_FAMILIES ? all - k : CHUNK_FAMILIES);
        status = ibl_run(ctx, NULL, b->family_count, family_job, b);
        if (!status)
            status = sum_rows(ctx, b, rows, (double)k / (double)all,
                              (double)b->family_count / (double)all);
        if (status)
            return status;
        for (int i = 0; i < b->family_count; i++) {
            for (int j = 0; j < b->families[i].texels; j++)
                finish_texel(b, &b->families[i].texel[j]);
        }
    }
    ibl_progress(ctx, "irradiance", 1.0);
    return IBL_OK;
}

static void fill_angles(struct bake *b)
{
    const int w = b->env->width, h = b->env->height;

    for (int i = 0; i < w; i++) {
        const double phi = 2.0 * pi * ((i + 0.5) / w - 0.5);
        b->turn[2 * (size_t)i] = cos(phi);
        b->turn[2 * (size_t)i + 1] = sin(phi);
    }
    for (int j = 0; j < h; j++) {
        const double theta = pi * (j + 0.5) / h;
        b->tilt[2 * (size_t)j] = cos(theta);
        b->tilt[2 * (size_t)j + 1] = sin(theta);
    }
}

static ibl_status sum_pixels(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                             ibl_cube *out)
{
    const double yaw = fmod(yaw_deg, 360.0) / 180.0 * pi;
    const size_t w = (size_t)env->width;
    const size_t record = IBL_ARC_LANES * sizeof(double);
    const size_t fit = rows_bytes / ((w + 1) * record);
    const int rows = fit > MAX_ROWS   ? MAX_ROWS
                     : fit < MIN_ROWS ? MIN_ROWS
                                      : (int)fit;
    struct bake b = {.env = env, .out = out};
    ibl_status status;

    b.cos_yaw = cos(yaw);
    b.sin_yaw = sin(yaw);
    b.turn = ibl_alloc_array(w, 2 * sizeof *b.turn);
    b.tilt = ibl_alloc_array((size_t)env->height, 2 * sizeof *b.tilt);
    b.sums = ibl_alloc_array((size_t)rows * (w + 1), record);
    b.families = ibl_alloc_array(CHUNK_FAMILIES, sizeof *b.families);
    if (b.turn && b.tilt && b.sums && b.families) {
        fill_angles(&b);
        ibl_arc_dsp_init(&b.dsp, ibl_ctx_isa(ctx));
        status = sum_cube(ctx, &b, rows);
    } else {
        status = ibl_no_memory(ctx, "the irradiance");
    }
    ibl_free(b.turn);
    ibl_free(b.tilt);
    ibl_free(b.sums);
    ibl_free(b.families);
    return status;
}

ibl_irradiance_options ibl_irradiance_options_default(void)
{
    return (ibl_irradiance_options){.size = 32};
}

ibl_status ibl_irradiance_check(ibl_ctx *ctx,
                                const ibl_irradiance_options *opts)
{
    if (opts->size < 1 || opts->size > IBL_MAX_CUBE_SIZE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "irradiance faces of size %d: must be 1 to %d",
                        opts->size, IBL_MAX_CUBE_SIZE);
    if (!(opts->step >= 0.0 && opts->step <= 0.5))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an irradiance step of %g: must be 0 to 0.5 radians",
                        opts->step);
    if (!isfinite(opts->yaw_deg))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "the yaw must be finite");
    return IBL_OK;
}

ibl_status ibl_bake_irradiance(ibl_ctx *ctx, const ibl_image *env,
                               const ibl_irradiance_options *opts,
                               ibl_cube *out)
{
    const ibl_irradiance_options defaults = ibl_irradiance_options_default();
    ibl_status status;

    if (!opts)
        opts = &defaults;
    status = ibl_irradiance_check(ctx, opts);
    if (!status)
        status = ibl_cube_alloc(ctx, opts->size, 1, out);
    if (status)
        return status;
    status = opts->step > 0.0 ? ibl_irradiance_grid(ctx, env, opts, out)
                              : sum_pixels(ctx, env, opts->yaw_deg, out);
    if (status)
        ibl_cube_free(out);
    return status;
}
