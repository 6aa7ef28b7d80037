/* SPDX-License-Identifier: MIT */
#include "view/interrupt.h"

#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>

/* ABRT comes from drivers that give up. */
static const int caught[] = {SIGHUP, SIGINT, SIGQUIT, SIGABRT, SIGTERM};
static _Atomic(ibl_outputs *) guarded;

/* The signal is blocked here: the one raised arrives afterwards, with the
 * default action. */
static void die(int number)
{
    ibl_outputs_abort(atomic_load(&guarded));
    signal(number, SIG_DFL);
    raise(number);
}

void view_interrupt_catch(void)
{
    struct sigaction action = {.sa_handler = die}, old;

    sigfillset(&action.sa_mask);
    for (size_t i = 0; i < sizeof caught / sizeof caught[0]; i++)
        if (!sigaction(caught[i], NULL, &old) && old.sa_handler != SIG_IGN)
            sigaction(caught[i], &action, NULL);
    /* A file-size limit is an error of write(), with its own message. */
    signal(SIGXFSZ, SIG_IGN);
}

void view_interrupt_guard(ibl_outputs *outputs)
{
    atomic_store(&guarded, outputs);
}

void view_interrupt_end(ibl_outputs *outputs)
{
    /* Guarded until nothing is left. */
    ibl_outputs_abort(outputs);
    view_interrupt_guard(NULL);
    ibl_outputs_free(outputs);
}
