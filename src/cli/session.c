/* SPDX-License-Identifier: MIT */
#include "cli/session.h"

#include <errno.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>

#include "common/path.h"

/* ---- signals ---------------------------------------------------------- */

/* What ends a program and may come from outside; ABRT comes from libraries
 * that give up. */
static const int caught[] = {SIGHUP,  SIGINT,  SIGQUIT, SIGABRT, SIGUSR1,
                             SIGUSR2, SIGPIPE, SIGALRM, SIGTERM, SIGXCPU};
static _Atomic(ibl_outputs *) guarded;
static _Atomic(pid_t) running;

/* The signal is blocked while this runs, so that the one raised here arrives
 * when it returns, with the default action. */
static void die(int number)
{
    const int saved = errno;
    const pid_t group = atomic_load(&running);

    if (group > 0) {
        kill(-group, SIGKILL);
        waitpid(group, NULL, 0);
    }
    ibl_outputs_abort(atomic_load(&guarded));
    signal(number, SIG_DFL);
    raise(number);
    errno = saved;
}

static void caught_set(sigset_t *set)
{
    sigemptyset(set);
    for (size_t i = 0; i < sizeof caught / sizeof caught[0]; i++)
        sigaddset(set, caught[i]);
}

void ibl_signals_pass(void (*handler)(int number))
{
    struct sigaction action = {.sa_handler = handler}, old;

    caught_set(&action.sa_mask);
    for (size_t i = 0; i < sizeof caught / sizeof caught[0]; i++)
        if (!sigaction(caught[i], NULL, &old) && old.sa_handler != SIG_IGN)
            sigaction(caught[i], &action, NULL);
}

void ibl_signals_catch(void)
{
    ibl_signals_pass(die);
    /* A file-size limit is an error of write(), with its own message. */
    signal(SIGXFSZ, SIG_IGN);
}

void ibl_signals_guard(ibl_outputs *outputs)
{
    atomic_store(&guarded, outputs);
}

void ibl_signals_group(pid_t group)
{
    atomic_store(&running, group);
}

void ibl_signals_hold(void)
{
    sigset_t set;
    caught_set(&set);
    pthread_sigmask(SIG_BLOCK, &set, NULL);
}

void ibl_signals_release(void)
{
    sigset_t set;
    caught_set(&set);
    pthread_sigmask(SIG_UNBLOCK, &set, NULL);
}

/* ---- context and outputs ---------------------------------------------- */

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
