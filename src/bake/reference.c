/* SPDX-License-Identifier: MIT */
/*
 * The sums over every pixel, a direction against the whole source. In
 *     q = sin^2(psi / 2) = sin^2(dtheta / 2)
 *                          + sin(theta) sin(theta_N) sin^2(dphi / 2),
 * psi the angle between N and L, both terms are >= 0 and nothing cancels in
 * the narrowest lobe. With N = V = R, N.L = 1 - 2q and N.H^2 = 1 - q, so
 *     D_ggx N.L = a2 (1 - 2q) / (pi t^2),   t = q + a2 (1 - q).
 * The factor a2 / t, squared, is used in place of 1 / t^2: it is 1 at the peak
 * and the constants cancel in the quotient.
 *
 * The other lobes take ibl_reference_weight_at for each pixel.
 *
 * A job takes a few directions over a few rows: a row's pixels are converted
 * once for all of them. Inside a row sums are plain, in LANES parts, all terms
 * >= 0; rows are added with compensation.
 */
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "bake/reference_sums.h"
#include "core/alloc.h"
#include "core/context.h"

enum {
    LANES = 2,            /* more spill registers */
    GROUP = 8,            /* directions of a job */
    JOB_PIXELS = 1 << 16, /* of each */
    BATCH_SUMS = 1 << 16  /* partial sums held at once */
};

static const double pi = REFERENCE_PI;

/* ---- create ----------------------------------------------------------- */

static void fill_tables(ibl_reference *ref)
{
    const int w = ref->env->width, h = ref->env->height;

    for (int i = 0; i < ref->padded; i++) {
        const double half = pi * ((i + 0.5) / w - 0.5);
        ref->half_sin[i] = i < w ? sin(half) : INFINITY;
        ref->half_cos[i] = i < w ? cos(half) : 0;
    }
    for (int j = 0; j < h; j++) {
        ref->row_theta[j] = pi * (j + 0.5) / h;
        /* cos(top) - cos(bottom), as a product that cancels nothing. */
        ref->row_angle[j] =
            2 * pi / w * 2 * sin(ref->row_theta[j]) * sin(0.5 * pi / h);
    }
}

ibl_status ibl_reference_create(ibl_ctx *ctx, const ibl_image *env,
                                double yaw_deg, ibl_reference **out)
{
    *out = NULL;
    if (env->width < 1 || env->width > IBL_MAX_EDGE || env->height < 1 ||
        env->height > IBL_MAX_EDGE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a map of %dx%d pixels: must be 1x1 to %dx%d",
                        env->width, env->height, IBL_MAX_EDGE, IBL_MAX_EDGE);
    if (!isfinite(yaw_deg))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a yaw of %g degrees: must be finite", yaw_deg);
    ibl_reference *ref = ibl_alloc_zeroed(1, sizeof *ref);
    if (!ref)
        return ibl_no_memory(ctx, "the reference");
    ref->ctx = ctx;
    ref->env = env;
    ref->yaw = (yaw_deg - 360 * floor(yaw_deg / 360)) / 180 * pi;
    ref->padded = (env->width + LANES - 1) / LANES * LANES;
    const size_t w = (size_t)ref->padded, h = (size_t)env->height;
    ref->half_sin = ibl_alloc_array(w, sizeof(double));
    ref->half_cos = ibl_alloc_array(w, sizeof(double));
    ref->row_theta = ibl_alloc_array(h, sizeof(double));
    ref->row_angle = ibl_alloc_array(h, sizeof(double));
    if (!ref->half_sin || !ref->half_cos || !ref->row_theta ||
        !ref->row_angle) {
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
    ibl_free(ref->half_sin);
    ibl_free(ref->half_cos);
    ibl_free(ref->row_theta);
    ibl_free(ref->row_angle);
    ibl_free(ref);
}

int ibl_reference_strip(const ibl_reference *ref, int pixels)
{
    const int rows = pixels / ref->env->width;

    return rows < 1 ? 1 : rows < ref->env->height ? rows : ref->env->height;
}

static ibl_aim aim_at(const ibl_reference *ref, const double dir[3])
{
    const double across = hypot(dir[0], dir[2]);
    const double phi = atan2(dir[2], dir[0]) + ref->yaw;

    return (ibl_aim){atan2(across, dir[1]), remainder(phi, 2 * pi),
                     across / hypot(across, dir[1])};
}

/* ---- one row ---------------------------------------------------------- */

/* The lobe, and where its pixels are divided. */
struct lobe {
    ibl_weight weight;
    double near; /* GGX: t below which a pixel counts as a patch, 0: nowhere */
    double mix;  /* the others: share of a pixel that counts as a patch */
};

/* Columns begin[k]..end[k] - 1, in one or two parts. */
struct span {
    int parts, begin[2], end[2];
};

/* The columns, and up to LANES more, that have q < limit in a row. */
static struct span columns_within(const ibl_reference *ref, const ibl_aim *aim,
                                  double polar, double scale, double limit)
{
    const int w = ref->env->width;
    struct span all = {1, {0, 0}, {ref->padded, 0}};
    if (scale <= 0 || (limit - polar) >= scale)
        return all;
    const double reach = 2 * asin(sqrt((limit - polar) / scale)) / (2 * pi) * w;
    const double centre = (aim->phi / (2 * pi) + 0.5) * w - 0.5;
    int begin = (int)floor(centre - reach) - 1;
    int end = (int)ceil(centre + reach) + 2;
    if (end - begin >= w)
        return all;
    if (begin >= 0 && end <= w) {
        begin = begin / LANES * LANES;
        end = (end + LANES - 1) / LANES * LANES;
        return (struct span){1, {begin, 0}, {end, 0}};
    }
    begin = (begin + w) % w / LANES * LANES;
    end = ((end + w - 1) % w + LANES) / LANES * LANES;
    if (begin < end)
        return all;
    return (struct span){2, {0, begin}, {end, ref->padded}};
}

/* LANES doubles at once, a type of gcc and clang for any machine. */
typedef double lanes __attribute__((vector_size(LANES * sizeof(double))));
typedef int64_t mask __attribute__((vector_size(LANES * sizeof(int64_t))));

/* Adds the weights of columns begin..end - 1, and their colours, to sum. The
 * arrays, begin and stride are aligned to LANES. */
static void add_columns(const struct lobe *lobe, double polar, double scale,
                        const double *across, const double *rgb, int stride,
                        int begin, int end, lanes sum[4])
{
    const lanes *a = (const lanes *)(across + begin);
    const lanes *red = (const lanes *)(rgb + begin);
    const lanes *green = (const lanes *)(rgb + stride + begin);
    const lanes *blue = (const lanes *)(rgb + 2 * (size_t)stride + begin);
    const double a2 = lobe->weight.a2, near = lobe->near;
    lanes r = sum[0], g = sum[1], b = sum[2], all = sum[3];

    for (int k = 0; k < (end - begin) / LANES; k++) {
        const lanes q = polar + scale * a[k];
        const lanes t = q + a2 * (1 - q), f = a2 / t, c = 1 - 2 * q;
        const mask use = (c > 0) & (t >= near);
        const lanes w = (lanes)((mask)(c * f * f) & use);
        r += w * red[k];
        g += w * green[k];
        b += w * blue[k];
        all += w;
    }
    sum[0] = r;
    sum[1] = g;
    sum[2] = b;
    sum[3] = all;
}

static double total(lanes v)
{
    return v[0] + v[1];
}

/* ---- pixels near the peak --------------------------------------------- */

static double integral(const ibl_reference *ref, const struct lobe *lobe,
                       const ibl_aim *aim, int i, int j)
{
    const double wide = pi / ref->env->width,
                 tall = 0.5 * pi / ref->env->height;
    const double x = ref->row_theta[j] - aim->theta;
    const double phi = 2 * pi * ((i + 0.5) / ref->env->width - 0.5);
    const double y = remainder(phi - aim->phi, 2 * pi);
    const ibl_patch patch = {x - tall, x + tall, y - wide, y + wide};

    return ibl_reference_patch(aim, &lobe->weight, &patch);
}

/* A patch's weight: that of its centre where t = near, its integral where
 * t <= near / 4, smoothly in between. */
static double patch_weight(const ibl_reference *ref, const struct lobe *lobe,
                           const ibl_aim *aim, int i, int j, double q, double t)
{
    const double patch = integral(ref, lobe, aim, i, j);
    const double s = (lobe->near - t) / (0.75 * lobe->near);
    if (s >= 1)
        return patch;
    const double mix = s * s * (3 - 2 * s);
    const double centre =
        ibl_reference_weight_at(&lobe->weight, q) * ref->row_angle[j];
    return centre + mix * (patch - centre);
}

static void add_exact(const ibl_reference *ref, int i, int j, double weight,
                      ibl_exact sum[4])
{
    const float *row = ref->env->data + 3 * (size_t)j * (size_t)ref->env->width;

    for (int c = 0; c < 3; c++)
        ibl_exact_add(&sum[c], weight * (double)row[3 * i + c]);
    ibl_exact_add(&sum[3], weight);
}

static void add_near(const ibl_reference *ref, const struct lobe *lobe,
                     const ibl_aim *aim, int j, double polar, double scale,
                     const double *across, ibl_exact sum[4])
{
    const double a2 = lobe->weight.a2;
    /* t < near, solved for q and moved out a little. */
    const double limit = a2 < 1 ? (lobe->near - a2) / (1 - a2) * (1 + 1e-9) : 2;
    if (polar >= limit || ibl_cancelled(ref->ctx))
        return;
    const struct span s = columns_within(ref, aim, polar, scale, limit);
    for (int part = 0; part < s.parts; part++) {
        for (int i = s.begin[part]; i < s.end[part] && i < ref->env->width;
             i++) {
            const double q = polar + scale * across[i];
            const double t = q + a2 * (1 - q);
            if (t < lobe->near)
                add_exact(ref, i, j, patch_weight(ref, lobe, aim, i, j, q, t),
                          sum);
        }
    }
}

/* ---- other lobes ------------------------------------------------------ */

/* Weights of columns begin..end - 1 by their centres. */
static void add_centres(const ibl_reference *ref, const struct lobe *lobe,
                        int j, double polar, double scale, const double *across,
                        int begin, int end, double sum[4])
{
    const float *row = ref->env->data + 3 * (size_t)j * (size_t)ref->env->width;

    for (int i = begin; i < end && i < ref->env->width; i++) {
        const double w =
            ibl_reference_weight_at(&lobe->weight, polar + scale * across[i]);
        for (int c = 0; c < 3; c++)
            sum[c] += w * (double)row[3 * i + c];
        sum[3] += w;
    }
}

/* Weights of columns begin..end - 1, patches in part. */
static void add_patches(const ibl_reference *ref, const struct lobe *lobe,
                        const ibl_aim *aim, int j, double polar, double scale,
                        const double *across, int begin, int end, double least,
                        ibl_exact sum[4])
{
    for (int i = begin; i < end && i < ref->env->width; i++) {
        const double q = polar + scale * across[i];
        if (q < least)
            continue;
        const double centre =
            ibl_reference_weight_at(&lobe->weight, q) * ref->row_angle[j];
        const double patch = integral(ref, lobe, aim, i, j);
        add_exact(ref, i, j, centre + lobe->mix * (patch - centre), sum);
    }
}

/* q of an angle that is that of q and `more`. */
static double moved_out(double q, double more)
{
    const double half = asin(sqrt(q)) + 0.5 * more;
    const double s = sin(fmin(fmax(half, 0), 0.5 * pi));

    return s * s;
}

/* A row of Charlie or Phong. A pixel reaches no further from its centre than
 * half its diagonal. */
static void add_other(const ibl_reference *ref, const struct lobe *lobe,
                      const ibl_aim *aim, int j, double polar, double scale,
                      const double *across, ibl_exact sum[4])
{
    const double reach = lobe->mix > 0 ? 0.51 * hypot(pi / ref->env->height,
                                                      2 * pi / ref->env->width)
                                       : 0;
    const double most = moved_out(lobe->weight.most, reach);
    const double least = moved_out(lobe->weight.least, -reach);
    double row[4] = {0};

    if (polar >= most || ibl_cancelled(ref->ctx))
        return;
    const struct span s = columns_within(ref, aim, polar, scale, most);
    for (int k = 0; k < s.parts; k++) {
        if (lobe->mix > 0)
            add_patches(ref, lobe, aim, j, polar, scale, across, s.begin[k],
                        s.end[k], least, sum);
        else
            add_centres(ref, lobe, j, polar, scale, across, s.begin[k],
                        s.end[k], row);
    }
    for (int c = 0; c < 4; c++)
        ibl_exact_add(&sum[c], row[c] * ref->row_angle[j]);
}

/* ---- many directions -------------------------------------------------- */

struct sums {
    const ibl_reference *ref;
    struct lobe lobe;
    const ibl_aim *aims;
    int count;            /* of a batch */
    int strip, strips;    /* rows of a job, jobs of a group */
    double *scratch;      /* of each worker: a row's colours, GROUP acrosses */
    ibl_exact (*part)[4]; /* strips for each direction */
};

static size_t scratch_size(const ibl_reference *ref)
{
    return (3 + GROUP) * (size_t)ref->padded;
}

static void convert_row(const ibl_reference *ref, int j, double *rgb)
{
    const int w = ref->env->width, stride = ref->padded;
    const float *p = ref->env->data + 3 * (size_t)j * (size_t)w;

    for (int i = 0; i < w; i++) {
        rgb[i] = (double)p[3 * i];
        rgb[stride + i] = (double)p[3 * i + 1];
        rgb[2 * stride + i] = (double)p[3 * i + 2];
    }
}

/* sin^2(dphi / 2) of every column. */
static void fill_across(const ibl_reference *ref, const ibl_aim *aim,
                        double *across)
{
    const double s = sin(0.5 * aim->phi), c = cos(0.5 * aim->phi);

    for (int i = 0; i < ref->padded; i++) {
        const double d = ref->half_sin[i] * c - ref->half_cos[i] * s;
        across[i] = d * d;
    }
}

static void add_row(const ibl_reference *ref, const struct lobe *lobe,
                    const ibl_aim *aim, int j, const double *rgb,
                    const double *across, ibl_exact sum[4])
{
    const double half = sin(0.5 * (ref->row_theta[j] - aim->theta));
    const double polar = half * half;
    const double scale = sin(ref->row_theta[j]) * aim->sin_theta;
    lanes row[4] = {{0}};

    if (lobe->weight.lobe != IBL_LOBE_GGX) {
        add_other(ref, lobe, aim, j, polar, scale, across, sum);
        return;
    }
    if (lobe->near > 0)
        add_near(ref, lobe, aim, j, polar, scale, across, sum);
    if (polar >= 0.5)
        return;
    const struct span s = columns_within(ref, aim, polar, scale, 0.5);
    for (int k = 0; k < s.parts; k++)
        add_columns(lobe, polar, scale, across, rgb, ref->padded, s.begin[k],
                    s.end[k], row);
    for (int c = 0; c < 4; c++)
        ibl_exact_add(&sum[c], total(row[c]) * ref->row_angle[j]);
}

static void sums_job(void *arg, int job, int worker)
{
    const struct sums *s = arg;
    const ibl_reference *ref = s->ref;
    const int group = job / s->strips * GROUP, strip = job % s->strips;
    const int left = s->count - group, n = left < GROUP ? left : GROUP;
    const int begin = strip * s->strip;
    const int end = begin + s->strip < ref->env->height ? begin + s->strip
                                                        : ref->env->height;
    double *rgb = s->scratch + (size_t)worker * scratch_size(ref);
    double *across = rgb + 3 * (size_t)ref->padded;

    for (int k = 0; k < n; k++) {
        fill_across(ref, &s->aims[group + k], across + k * (size_t)ref->padded);
        memset(s->part[(size_t)(group + k) * (size_t)s->strips + strip], 0,
               sizeof *s->part);
    }
    for (int j = begin; j < end; j++) {
        convert_row(ref, j, rgb);
        for (int k = 0; k < n; k++)
            add_row(ref, &s->lobe, &s->aims[group + k], j, rgb,
                    across + k * (size_t)ref->padded,
                    s->part[(size_t)(group + k) * (size_t)s->strips + strip]);
    }
}

/* The quotient of a direction's sums; false where nothing has weight. */
static bool quotient(const struct sums *s, int direction, double rgb[3])
{
    ibl_exact sum[4] = {{0, 0}};

    for (int k = 0; k < s->strips; k++) {
        const ibl_exact *part =
            s->part[(size_t)direction * (size_t)s->strips + k];
        for (int c = 0; c < 4; c++) {
            ibl_exact_add(&sum[c], part[c].value);
            ibl_exact_add(&sum[c], part[c].rest);
        }
    }
    const double weight = ibl_exact_total(&sum[3]);
    if (!(weight > 0))
        return false;
    for (int c = 0; c < 3; c++)
        rgb[c] = ibl_exact_total(&sum[c]) / weight;
    return true;
}

static ibl_status check_dirs(const ibl_reference *ref, const double *dirs,
                             size_t count)
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
    struct sums s = {.ref = ref, .lobe = lobe};
    const size_t threads = (size_t)ibl_ctx_threads(ref->ctx);
    ibl_status status = IBL_OK;

    s.strip = ibl_reference_strip(ref, JOB_PIXELS);
    s.strips = (ref->env->height + s.strip - 1) / s.strip;
    int batch = BATCH_SUMS / s.strips / GROUP * GROUP;
    batch = batch < GROUP ? GROUP : batch;
    ibl_aim *aims = ibl_alloc_array((size_t)batch, sizeof *aims);
    s.aims = aims;
    s.scratch = ibl_alloc_zeroed(threads, scratch_size(ref) * sizeof(double));
    s.part = ibl_alloc_array((size_t)batch * (size_t)s.strips, sizeof *s.part);
    if (!aims || !s.scratch || !s.part) {
        status = ibl_no_memory(ref->ctx, "the reference's sums");
        goto fail;
    }
    for (size_t at = 0; at < count && !status; at += (size_t)s.count) {
        s.count = count - at < (size_t)batch ? (int)(count - at) : batch;
        for (int k = 0; k < s.count; k++)
            aims[k] = aim_at(ref, dirs + 3 * (at + (size_t)k));
        status =
            ibl_run(ref->ctx, NULL, (s.count + GROUP - 1) / GROUP * s.strips,
                    sums_job, &s);
        for (int k = 0; k < s.count && !status; k++) {
            double *to = rgb + 3 * (at + (size_t)k);
            if (!quotient(&s, k, to))
                status = ibl_reference_mean(ref, to);
        }
    }
fail:
    ibl_free(aims);
    ibl_free(s.scratch);
    ibl_free(s.part);
    return status;
}

/* ---- the calls -------------------------------------------------------- */

static void mirror(const ibl_reference *ref, const double dir[3], double rgb[3])
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

/* The share of patches, between two widths in pixels. */
static double mix_of(double alpha, double patches, double centres)
{
    const double s = (centres - alpha) / (centres - patches);

    return s <= 0 ? 0 : s >= 1 ? 1 : s * s * (3 - 2 * s);
}

static struct lobe lobe_of(const ibl_reference *ref, ibl_lobe which,
                           double alpha)
{
    const double pixel = fmax(pi / ref->env->height, 2 * pi / ref->env->width);
    struct lobe lobe = {.weight = ibl_reference_weight(which, alpha)};

    if (which == IBL_LOBE_CHARLIE)
        lobe.mix = mix_of(alpha, 0.5 * pixel, pixel);
    else if (which == IBL_LOBE_PHONG)
        lobe.mix = mix_of(alpha, pixel, 2 * pixel);
    else if (16 * pixel * pixel > alpha * alpha)
        lobe.near = 16 * pixel * pixel;
    return lobe;
}

ibl_status ibl_reference_lobe(const ibl_reference *ref, ibl_lobe lobe,
                              double roughness, const double *dirs,
                              size_t count, double *rgb)
{
    if (lobe < IBL_LOBE_GGX || lobe > IBL_LOBE_PHONG)
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                        "lobe %d: must be ggx (%d), charlie (%d) or phong (%d)",
                        (int)lobe, IBL_LOBE_GGX, IBL_LOBE_CHARLIE,
                        IBL_LOBE_PHONG);
    if (!(roughness >= 0 && roughness <= 1))
        return ibl_fail(ref->ctx, IBL_ERR_ARGUMENT,
                        "a roughness of %g: must be 0 to 1", roughness);
    ibl_status status = check_dirs(ref, dirs, count);
    if (status)
        return status;
    double alpha = roughness * roughness;
    if (lobe == IBL_LOBE_CHARLIE && roughness > 0)
        alpha = fmax(alpha, 1e-9);
    /* Narrower than that, the lobe outside the pixel, less than alpha^2 times
     * the pixels' number squared, is nothing even to the floats' whole range
     * of 1e84. */
    if (alpha < 1e-75) {
        for (size_t k = 0; k < count; k++)
            mirror(ref, dirs + 3 * k, rgb + 3 * k);
        return ibl_cancelled(ref->ctx) ? IBL_ERR_CANCELLED : IBL_OK;
    }
    return run_sums(ref, lobe_of(ref, lobe, alpha), dirs, count, rgb);
}

ibl_status ibl_reference_specular(const ibl_reference *ref, double roughness,
                                  const double *dirs, size_t count, double *rgb)
{
    return ibl_reference_lobe(ref, IBL_LOBE_GGX, roughness, dirs, count, rgb);
}

/* At alpha = 1 the lobe is the cosine. */
ibl_status ibl_reference_irradiance(const ibl_reference *ref,
                                    const double *dirs, size_t count,
                                    double *rgb)
{
    const ibl_status status = check_dirs(ref, dirs, count);
    const struct lobe cosine = {.weight =
                                    ibl_reference_weight(IBL_LOBE_GGX, 1)};

    return status ? status : run_sums(ref, cosine, dirs, count, rgb);
}
