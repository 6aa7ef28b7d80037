/* SPDX-License-Identifier: MIT */
/* The coefficients of a map in the layout of ibl_bake_sh, with all that the
 * analysis keeps apart. */
#include <math.h>
#include <string.h>

#include "bake/spectral/engine.h"
#include "core/context.h"

/* Analyses only the lights. */
static ibl_status analyse_lights(const ibl_spectral *s, ibl_harmonics *out)
{
    ibl_row_spectra rows;
    ibl_status status =
        ibl_row_spectra_alloc(s->ctx, s->height, out->degree, &rows);
    if (status)
        return status;
    out->single = s->single;
    memset(rows.data, 0, rows.at[rows.groups] * sizeof *rows.data);
    status = ibl_spectral_add_lights(s, s->lights, s->light_count, &rows);
    if (!status)
        status = ibl_sht_analyse(s->ctx, NULL, &rows, s->widths, out);
    ibl_row_spectra_free(&rows);
    return status;
}

/* The harmonics of the map. *sum is empty after an error. */
static ibl_status add_all(const ibl_spectral *s, int degree, ibl_harmonics *sum)
{
    const size_t edge = (size_t)degree + 1;
    ibl_status status = ibl_harmonics_alloc(s->ctx, degree, sum);
    if (status)
        return status;
    memset(sum->data, 0, 3 * edge * (edge + 1) * sizeof *sum->data);
    if (s->light_count)
        status = analyse_lights(s, sum);
    for (int m = 0; m <= degree && !status; m++) {
        const float *from = ibl_harmonics_at(&s->harmonics, m);
        float *to = ibl_harmonics_at(sum, m);
        for (int i = 0; i < 6 * (degree - m + 1); i++)
            to[i] = (float)(((double)to[i] + (double)from[i]) / s->scale);
    }
    for (int c = 0; c < 3; c++)
        sum->data[2 * c] += (float)((double)s->mean[c] * sqrt(4 * IBL_PI));
    if (status)
        ibl_harmonics_free(sum);
    return status;
}

ibl_status ibl_spectral_sh(const ibl_spectral *s, int degree, double *coeffs)
{
    const ibl_axes about_y = {.up = IBL_UP_Z}; /* phi backwards */
    ibl_harmonics sum;
    ibl_status status = add_all(s, degree, &sum);
    for (int m = 0; m <= degree && !status; m++)
        for (int l = m; l <= degree; l++)
            for (int c = 0; c < 3; c++) {
                const float *a =
                    ibl_harmonics_at(&sum, m) + 6 * (l - m) + 2 * c;
                const double g = m ? sqrt(2) : 1;
                coeffs[3 * (l * (l + 1) - m) + c] = g * (double)a[1];
                coeffs[3 * (l * (l + 1) + m) + c] = g * (double)a[0];
            }
    if (!status)
        status = ibl_sh_turn_axes(s->ctx, degree, about_y, 1, coeffs);
    ibl_harmonics_free(&sum);
    return status;
}
