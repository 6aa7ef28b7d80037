/* SPDX-License-Identifier: MIT */
#include "kern/strip.h"

#include <string.h>

void ibl_strip_load_c(const float *const rows[IBL_STRIP_LANES], int count,
                      const ibl_strip_change *change, float *lanes,
                      size_t channel)
{
    for (size_t i = 0; i < (size_t)count; i++)
        for (size_t c = 0; c < 3; c++)
            for (size_t r = 0; r < IBL_STRIP_LANES; r++)
                lanes[c * channel + i * IBL_STRIP_LANES + r] =
                    (rows[r][3 * i + c] - change->subtract[c]) * change->scale;
}

void ibl_strip_store_c(const float *lanes, size_t channel, int count,
                       float *const rows[IBL_STRIP_LANES], int used)
{
    for (size_t i = 0; i < (size_t)count; i++)
        for (size_t r = 0; r < (size_t)used; r++) {
            const float *from = lanes + i * IBL_STRIP_LANES + r;
            rows[r][4 * i] = from[0];
            rows[r][4 * i + 1] = from[channel];
            rows[r][4 * i + 2] = from[2 * channel];
            rows[r][4 * i + 3] = 0;
        }
}

void ibl_strip_spread_c(const ibl_strip_spread *spread, const float *pixels,
                        int start, int count, float *samples)
{
    int64_t cleared =
        start ? ibl_strip_first(spread, start - 1) + IBL_STRIP_TAPS : 0;
    for (int i = start; i < start + count; i++) {
        const int64_t first = ibl_strip_first(spread, i);
        const float *taps =
            spread->taps + (size_t)(i % spread->period) * IBL_STRIP_TAPS;
        for (; cleared < first + IBL_STRIP_TAPS; cleared++)
            memset(samples + cleared * IBL_STRIP_LANES, 0,
                   IBL_STRIP_LANES * sizeof *samples);
        for (int t = 0; t < IBL_STRIP_TAPS; t++)
            for (int r = 0; r < IBL_STRIP_LANES; r++)
                samples[(first + t) * IBL_STRIP_LANES + r] +=
                    taps[t] * pixels[r];
        pixels += IBL_STRIP_LANES;
    }
}

void ibl_strip_dsp_init(ibl_strip_dsp *dsp, ibl_isa isa)
{
    *dsp = (ibl_strip_dsp){ibl_strip_load_c, ibl_strip_store_c,
                           ibl_strip_spread_c};
    IBL_INIT(ibl_strip, dsp, isa);
}
