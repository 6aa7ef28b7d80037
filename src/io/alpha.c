/* SPDX-License-Identifier: MIT */
#include "io/alpha.h"

#include <math.h>

#include "ibl/io.h"

/* What renderers and filters leave of 0 and 1 is no fault of the file. */
static const float rounding = 1e-3f;

const char *ibl_alpha_name(ibl_alpha alpha)
{
    static const char *const names[] = {"ignore", "file", "straight"};
    return names[alpha];
}

ibl_alpha_count ibl_alpha_count_none(void)
{
    return (ibl_alpha_count){.lowest = INFINITY,
                             .highest = -INFINITY,
                             .least = INFINITY,
                             .most = -INFINITY};
}

static float mend(float a, ibl_alpha_count *count)
{
    if (!isfinite(a)) {
        count->nonfinite++;
        return 0;
    }
    count->lowest = fminf(count->lowest, a);
    count->highest = fmaxf(count->highest, a);
    count->beyond += a < -rounding || a > 1 + rounding;
    return a > 0 ? fminf(a, 1) : 0;
}

void ibl_alpha_apply(float *alpha, float *rgb, size_t pixels, bool straight,
                     ibl_alpha_count *count)
{
    for (size_t i = 0; i < pixels; i++, rgb += 3) {
        const bool known = isfinite(alpha[i]);
        const float a = mend(alpha[i], count);
        const float factor = straight || a <= 0 ? a : 1;

        alpha[i] = a;
        count->least = fminf(count->least, a);
        count->most = fmaxf(count->most, a);
        count->hidden +=
            !straight && a <= 0 && known && rgb[0] + rgb[1] + rgb[2] > 0;
        for (int k = 0; k < 3; k++)
            rgb[k] *= factor;
    }
}
