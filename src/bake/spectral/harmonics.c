/* SPDX-License-Identifier: MIT */
/* What holds harmonics, and what is asked of them. */
#include <math.h>

#include "bake/sh_rotate.h"
#include "bake/spectral/transform.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"

static const double pi = IBL_PI;

enum {
    LINE = 16 /* floats in a cache line */
};

ibl_status ibl_ring_spectra_alloc(ibl_ctx *ctx, int rings, int orders,
                                  ibl_ring_spectra *out)
{
    const size_t stride = (((size_t)rings + LINE - 1) / LINE | 1) * LINE;

    *out = (ibl_ring_spectra){0};
    if (rings < 1 || rings > IBL_MAX_EDGE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "%d rings: must be 1 to %d",
                        rings, IBL_MAX_EDGE);
    if (orders < 1 || orders > IBL_SHT_MAX_DEGREE + 1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%d orders of a ring: must be 1 to %d", orders,
                        IBL_SHT_MAX_DEGREE + 1);
    float *data = ibl_alloc_array(6 * (size_t)orders, stride * sizeof *data);
    if (!data)
        return ibl_no_memory(ctx, "the spectra of the rings");
    *out = (ibl_ring_spectra){rings, orders, stride, data};
    return IBL_OK;
}

void ibl_ring_spectra_free(ibl_ring_spectra *s)
{
    if (!s)
        return;
    ibl_free(s->data);
    *s = (ibl_ring_spectra){0};
}

ibl_status ibl_harmonics_alloc(ibl_ctx *ctx, int degree, ibl_harmonics *out)
{
    *out = (ibl_harmonics){0};
    if (degree < 0 || degree > IBL_SHT_MAX_DEGREE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "harmonics of degree %d: must be 0 to %d", degree,
                        IBL_SHT_MAX_DEGREE);
    const size_t n = (size_t)degree + 1;
    double *data = ibl_alloc_array(n * (n + 1) / 2, 6 * sizeof *data);
    if (!data)
        return ibl_no_memory(ctx, "spherical harmonics");
    *out = (ibl_harmonics){degree, data};
    return IBL_OK;
}

void ibl_harmonics_free(ibl_harmonics *h)
{
    if (!h)
        return;
    ibl_free(h->data);
    *h = (ibl_harmonics){0};
}

void ibl_sht_power(const ibl_harmonics *h, double *power)
{
    for (int l = 0; l <= h->degree; l++)
        power[l] = 0.0;
    for (int m = 0; m <= h->degree; m++) {
        const double *a = ibl_harmonics_at(h, m);
        for (int l = m; l <= h->degree; l++, a += 6) {
            double square = 0.0;
            for (int part = 0; part < 6; part++)
                square += a[part] * a[part];
            power[l] += m ? 2.0 * square : square;
        }
    }
}

/* ---- to the basis of ibl_bake_sh ------------------------------------ */

struct conversion {
    const ibl_harmonics *in;
    double yaw_deg;
    double *coeffs;
    double *work; /* of each worker */
    int degree;
};

static size_t work_size(int degree)
{
    return 6 * ((size_t)degree + 1) + ibl_sh_rotate_work(degree);
}

/*
 * Order m of one degree, for ibl_sh_rotate: the integrals with g P_lm cos(m p)
 * and g P_lm sin(m p), where g = 1 for m = 0, else sqrt(2), and
 * p = 90 degrees + yaw - phi is the world's azimuth about y, from z towards
 * x. a is the integral with P_lm e^(-i m phi).
 */
static void to_real(int m, double yaw_deg, const double *a, double *to)
{
    const double g = m ? sqrt(2.0) : 1.0;
    const double angle = fmod(m * (90.0 + yaw_deg), 360.0) / 180.0 * pi;
    const double c = g * cos(angle), s = g * sin(angle);

    for (int k = 0; k < 3; k++) {
        to[k] = c * a[2 * k] - s * a[2 * k + 1];
        to[3 + k] = s * a[2 * k] + c * a[2 * k + 1];
    }
}

static void convert_job(void *arg, int l, int worker)
{
    const struct conversion *c = arg;
    double *ring = c->work + (size_t)worker * work_size(c->degree);

    for (int m = 0; m <= l; m++)
        to_real(m, c->yaw_deg, ibl_harmonics_at(c->in, m) + 6 * (size_t)(l - m),
                ring + 6 * (size_t)m);
    ibl_sh_rotate(l, ring, c->coeffs + 3 * (size_t)l * (size_t)l,
                  ring + 6 * ((size_t)c->degree + 1));
}

ibl_status ibl_sht_to_sh(ibl_ctx *ctx, const ibl_harmonics *in, int degree,
                         double yaw_deg, double *coeffs)
{
    struct conversion c = {.in = in, .coeffs = coeffs, .degree = degree};

    if (degree < 0 || degree > in->degree || degree > IBL_MAX_SH_DEGREE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "spherical harmonics of degree %d from harmonics of "
                        "degree %d: must be 0 to that and at most %d",
                        degree, in->degree, IBL_MAX_SH_DEGREE);
    if (!isfinite(yaw_deg))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "the yaw must be finite");
    c.yaw_deg = fmod(yaw_deg, 360.0);
    c.work = ibl_alloc_array((size_t)ibl_ctx_threads(ctx),
                             work_size(degree) * sizeof *c.work);
    if (!c.work)
        return ibl_no_memory(ctx, "the spherical harmonics");
    const ibl_status status = ibl_run(ctx, NULL, degree + 1, convert_job, &c);
    ibl_free(c.work);
    return status;
}
