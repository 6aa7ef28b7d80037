/* SPDX-License-Identifier: MIT */
/* iblview: shows what a material looks like under a baked environment. */
#include <errno.h>
#include <stdio.h>
#include <unistd.h>

#include "common/path.h"
#include "common/process.h"
#include "common/signals.h"
#include "view/app.h"
#include "view/message.h"

/* Shows the share of a bake that is done on a terminal. */
static void show_progress(void *cookie, const char *stage, double done,
                          double whole)
{
    (void)cookie;
    done = whole < 0 ? done : whole;
    fprintf(stderr, "\r%-20s %3.0f %%\033[K%s", stage, 100 * done,
            done >= 1 ? "\r\033[K" : "");
}

static bool run(const view_options *o)
{
    ibl_ctx_options opts = ibl_ctx_options_default();
    ibl_ctx *ctx;

    if (o->quiet)
        view_quiet();
    opts.log = view_log;
    opts.memory = ibl_memory_allowed() / 4 * 3;
    opts.bridge = ibl_bridge_beside();
    if (!o->quiet && isatty(STDERR_FILENO))
        opts.progress = show_progress;
    if (ibl_ctx_create(&opts, &ctx))
        return false;
    const bool ok =
        (view_options_file(o) ? view_still_run : view_window_run)(ctx, o);
    ibl_ctx_free(ctx);
    return ok;
}

int main(int argc, char **argv)
{
    view_options o;
    int status;

    ibl_signals_catch(argc, argv);
    if (view_options_parse(argc > 0 ? argv + 1 : argv, &o, &status))
        status = run(&o) ? 0 : 1;
    errno = 0;
    const char *why = ibl_unwritten(stdout);
    if (!why || status)
        return status;
    view_fail("standard output cannot be written: %s", why);
    return 1;
}
