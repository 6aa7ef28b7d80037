/* SPDX-License-Identifier: MIT */
#include "kern/share_lanes.h"

void ibl_share_sse2(const ibl_share_row *row, const ibl_share_cuts *cuts,
                    int count, double *share)
{
    shares(row, cuts, count, share);
}
