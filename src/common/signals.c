/* SPDX-License-Identifier: MIT */
#include "common/signals.h"

#include <errno.h>
#include <stdatomic.h>
#include <stddef.h>

/* Signals from outside that end a program, and ABRT, raised by libraries. */
static const int caught[] = {SIGHUP,  SIGINT,  SIGQUIT, SIGABRT, SIGUSR1,
                             SIGUSR2, SIGPIPE, SIGALRM, SIGTERM, SIGXCPU};
static _Atomic(ibl_outputs *) guarded; /* a signal aborts these */

/* The handler. The signal is blocked while it runs, so the raised one arrives
 * when it returns, with the default action. */
static void die(int number)
{
    const int saved = errno;

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
    /* write() then fails at a file-size limit, and that is reported. */
    signal(SIGXFSZ, SIG_IGN);
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

ibl_status ibl_start_outputs(ibl_ctx *ctx, int sync, ibl_outputs **outputs)
{
    const ibl_status status = ibl_outputs_create(ctx, outputs);

    if (!status) {
        ibl_outputs_sync(*outputs, sync);
        atomic_store(&guarded, *outputs);
    }
    return status;
}

void ibl_end_outputs(ibl_outputs *outputs)
{
    /* A signal may abort them too until no file is left. */
    ibl_outputs_abort(outputs);
    atomic_store(&guarded, NULL);
    ibl_outputs_free(outputs);
}
