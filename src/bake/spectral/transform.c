/* SPDX-License-Identifier: MIT */
#include "bake/spectral/transform.h"

#include "core/alloc.h"
#include "core/context.h"

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
