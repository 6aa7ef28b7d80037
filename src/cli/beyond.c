/* SPDX-License-Identifier: MIT */
#include "cli/beyond.h"

#include <math.h>
#include <stdio.h>

void ibl_beyond_add(const ibl_overflow_level *level, ibl_overflow_level *sum)
{
    sum->texels += level->texels;
    sum->moved = fmax(sum->moved, level->moved);
    sum->lost = fmax(sum->lost, level->lost);
}

void ibl_beyond_warn(ibl_console *console, const char *file, ibl_pixel pixel,
                     ibl_overflow overflow, const ibl_overflow_level *sum)
{
    char moved[96] = "", lost[96] = "";

    if (!sum->texels)
        return;
    if (sum->moved > 0)
        snprintf(moved, sizeof moved,
                 ": %.2g %% of a level's light went to the texels around %s",
                 100 * sum->moved, sum->texels == 1 ? "it" : "them");
    if (sum->lost > 0)
        snprintf(lost, sizeof lost, ": %.2g %% of a level's light is lost%s",
                 100 * sum->lost,
                 overflow == IBL_OVERFLOW_CLIP ? "" : " for want of room");
    ibl_console_warn(
        console,
        "%s: %zu %s brighter than %.9g, the most that %s "
        "holds%s%s: --pixel rgba32f keeps it in its place",
        file, sum->texels, sum->texels == 1 ? "texel is" : "texels are",
        (double)ibl_pixel_max(pixel), ibl_pixel_name(pixel), moved, lost);
}

json_t *ibl_beyond_json(const ibl_overflow_level *level)
{
    return json_pack("{s:I,s:f,s:f}", "texels", (json_int_t)level->texels,
                     "moved", level->moved, "lost", level->lost);
}
