/* SPDX-License-Identifier: MIT */
#include "kern/texel_error.h"

#include <math.h>

static float square(const float v[3])
{
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

void ibl_texel_error_add_c(const float *t, const float *d, size_t first,
                           size_t count, ibl_error_sums *sums)
{
    for (size_t i = first; i < count; i++) {
        const float *a = t + 3 * i, *b = d + 3 * i;
        const float off[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
        const float wrong = square(off), truth = square(a);
        const size_t lane = i % IBL_ERROR_LANES;
        if (!(truth < INFINITY))
            continue;
        sums->wrong[lane] += (double)wrong;
        sums->truth[lane] += (double)truth;
        sums->relative[lane] +=
            truth > 0 ? (double)(sqrtf(wrong) / sqrtf(truth)) : wrong > 0;
        sums->count[lane]++;
        float light = 0, lost = 0;
        for (int c = 0; c < 3; c++) {
            const float own = a[c] > 0 ? a[c] : 0;
            light += own;
            lost += b[c] > 0 ? 0 : own;
        }
        sums->light[lane] += (double)light;
        sums->lost[lane] += (double)lost;
    }
}

static void add(const float *t, const float *d, size_t count,
                ibl_error_sums *sums)
{
    ibl_texel_error_add_c(t, d, 0, count, sums);
}

IBL_KERNEL(ibl_texel_error, add)
