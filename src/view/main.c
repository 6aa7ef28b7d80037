/* SPDX-License-Identifier: MIT */
/* iblview: shows what a material looks like under a baked environment. */
#include <stdio.h>
#include <unistd.h>

#include "view/app.h"
#include "view/message.h"
#include "view/still.h"

/* Tells the stage of a bake on a terminal. */
static void show_progress(void *cookie, const char *stage, double done)
{
    (void)cookie;
    fprintf(stderr, "\r%-20s %3.0f %%\033[K%s", stage, 100 * done,
            done >= 1 ? "\r\033[K" : "");
}

static ibl_ctx *make_context(const view_options *o)
{
    ibl_ctx_options opts = ibl_ctx_options_default();
    ibl_ctx *ctx = NULL;

    opts.log = view_log;
    if (!o->quiet && isatty(STDERR_FILENO))
        opts.progress = show_progress;
    if (ibl_ctx_create(&opts, &ctx))
        return NULL;
    return ctx;
}

int main(int argc, char **argv)
{
    view_options o;
    int status;

    if (!view_options_parse(argc, argv, &o, &status))
        return status;
    if (o.quiet)
        view_quiet();
    ibl_ctx *ctx = make_context(&o);
    if (!ctx)
        return 1;
    const bool window = !o.offscreen && !o.contact_sheet && o.texel[0] < 0;
    const bool ok = window ? view_app_run(ctx, &o) : view_still_run(ctx, &o);
    ibl_ctx_free(ctx);
    if (fflush(stdout) || ferror(stdout)) {
        view_fail("standard output cannot be written");
        return 1;
    }
    return ok ? 0 : 1;
}
