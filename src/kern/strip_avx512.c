/* SPDX-License-Identifier: MIT */
#include "kern/strip_lanes.h"

void ibl_strip_load_avx512(const float *const rows[IBL_STRIP_LANES], int count,
                           const ibl_strip_change *change, float *lanes,
                           size_t channel)
{
    load(rows, count, change, lanes, channel);
}

void ibl_strip_store_avx512(const float *lanes, size_t channel, int count,
                            float *const rows[IBL_STRIP_LANES], int used)
{
    store(lanes, channel, count, rows, used);
}

void ibl_strip_spread_avx512(const ibl_strip_spread *spread,
                             const float *pixels, int start, int count,
                             float *samples)
{
    spread_all(spread, pixels, start, count, samples);
}
