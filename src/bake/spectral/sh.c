/* SPDX-License-Identifier: MIT */
/* The coefficients themselves, with everything that was kept apart. */
#include <math.h>
#include <string.h>

#include "bake/spectral/state.h"
#include "core/context.h"

/* The rows besides the lights; from here on nothing is scaled. */
static void add_rows(const ibl_spectral *s, ibl_harmonics *sum)
{
    for (int m = 0; m <= sum->degree; m++) {
        const size_t count = 6 * (size_t)(sum->degree - m + 1);
        const double *from = ibl_harmonics_at(&s->harmonics, m);
        double *to = ibl_harmonics_at(sum, m);
        for (size_t i = 0; i < count; i++)
            to[i] = (to[i] + from[i]) / s->scale;
    }
}

static void add_mean(const ibl_spectral *s, ibl_harmonics *sum)
{
    double *a = ibl_harmonics_at(sum, 0);
    for (int c = 0; c < 3; c++)
        a[2 * c] += (double)s->mean[c] * sqrt(4 * IBL_PI);
}

/* The lights alone. */
static ibl_status analyse_lights(const ibl_spectral *s, ibl_harmonics *out)
{
    ibl_ring_spectra rows;
    ibl_status status =
        ibl_ring_spectra_alloc(s->ctx, s->height, out->degree + 1, &rows);
    if (status)
        return status;
    memset(rows.data, 0,
           6 * (size_t)rows.orders * rows.stride * sizeof *rows.data);
    status = ibl_spectral_add_lights(s, s->lights, s->light_count, &rows);
    if (!status)
        status = ibl_sht_analyse_patches(s->ctx, NULL, &rows, s->widths, out);
    ibl_ring_spectra_free(&rows);
    return status;
}

ibl_status ibl_spectral_sh(const ibl_spectral *s, int degree, double *coeffs)
{
    ibl_harmonics sum;
    ibl_status status = ibl_harmonics_alloc(s->ctx, degree, &sum);
    if (status)
        return status;
    status = analyse_lights(s, &sum);
    if (!status) {
        add_rows(s, &sum);
        add_mean(s, &sum);
        status = ibl_sht_to_sh(s->ctx, &sum, degree, 0, coeffs);
    }
    ibl_harmonics_free(&sum);
    return status;
}
