/* SPDX-License-Identifier: MIT */
#include "kern/row_block.h"

void ibl_row_block_load_c(const float *const rows[IBL_ROW_BLOCK_LANES],
                          int count, float scale, float *lanes, size_t channel)
{
    for (size_t i = 0; i < (size_t)count; i++)
        for (size_t c = 0; c < 3; c++)
            for (size_t r = 0; r < IBL_ROW_BLOCK_LANES; r++)
                lanes[c * channel + i * IBL_ROW_BLOCK_LANES + r] =
                    rows[r][3 * i + c] * scale;
}

void ibl_row_block_store_c(const float *lanes, size_t channel, int count,
                           float *const rows[IBL_ROW_BLOCK_LANES], int used)
{
    for (size_t i = 0; i < (size_t)count; i++)
        for (size_t r = 0; r < (size_t)used; r++) {
            const float *from = lanes + i * IBL_ROW_BLOCK_LANES + r;
            rows[r][4 * i] = from[0];
            rows[r][4 * i + 1] = from[channel];
            rows[r][4 * i + 2] = from[2 * channel];
            rows[r][4 * i + 3] = 0;
        }
}
