/* SPDX-License-Identifier: MIT */
#include "cli/session.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/path.h"

ibl_status ibl_start(const ibl_common *common, ibl_console *console,
                     ibl_ctx **ctx)
{
    ibl_ctx_options opts = ibl_ctx_options_default();
    char *bridge = ibl_bridge_beside();

    opts.threads = common->threads;
    opts.isa = common->isa;
    opts.log = ibl_console_log;
    opts.log_cookie = console;
    opts.progress = ibl_console_progress;
    opts.progress_cookie = console;
    opts.bridge = bridge;
    const ibl_status status = ibl_ctx_create(&opts, ctx);
    free(bridge);
    return status;
}

/* ---- warnings --------------------------------------------------------- */

void ibl_warn_of_small_faces(ibl_console *console,
                             const ibl_specular_layout *layout)
{
    const int last = ibl_cube_edge(layout->size, layout->levels - 1);

    if (layout->levels > 1 && last < 4)
        ibl_console_warn(console,
                         "the last level has faces of %dx%d: lookups between "
                         "texels are off by 10 %% on faces of 2x2 and by 20 to "
                         "30 %% on 1x1: take fewer --levels or a larger --size",
                         last, last);
}

void ibl_overflow_add(const ibl_overflow_level *level, ibl_overflow_level *sum)
{
    sum->texels += level->texels;
    sum->moved = fmax(sum->moved, level->moved);
    sum->lost = fmax(sum->lost, level->lost);
}

void ibl_warn_of_overflow(ibl_console *console, const char *file,
                          ibl_pixel pixel, ibl_overflow overflow,
                          const ibl_overflow_level *sum)
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
