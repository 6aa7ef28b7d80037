/* SPDX-License-Identifier: MIT */
#include "cli/start.h"

#include <stdlib.h>

#include "cli/signals.h"
#include "common/bridge_file.h"

ibl_status ibl_start(const ibl_common *common, ibl_console *console,
                     ibl_ctx **ctx)
{
    ibl_ctx_options opts = ibl_ctx_options_default();
    char *bridge = ibl_bridge_beside();

    opts.threads = common->threads;
    opts.isa = (ibl_isa)common->isa;
    opts.log = ibl_console_log;
    opts.log_cookie = console;
    opts.progress = ibl_console_progress;
    opts.progress_cookie = console;
    opts.bridge = bridge;
    const ibl_status status = ibl_ctx_create(&opts, ctx);
    free(bridge);
    return status;
}

ibl_status ibl_start_outputs(ibl_ctx *ctx, int sync, ibl_outputs **outputs)
{
    const ibl_status status = ibl_outputs_create(ctx, outputs);

    if (!status) {
        ibl_outputs_sync(*outputs, sync);
        ibl_signals_guard(*outputs);
    }
    return status;
}

void ibl_end_outputs(ibl_outputs *outputs)
{
    /* Guarded until nothing is left. */
    ibl_outputs_abort(outputs);
    ibl_signals_guard(NULL);
    ibl_outputs_free(outputs);
}

ibl_status ibl_commit_outputs(ibl_outputs *outputs)
{
    ibl_signals_hold();
    const ibl_status status = ibl_outputs_commit(outputs);
    ibl_signals_guard(NULL);
    ibl_signals_release();
    return status;
}

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
