/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* program_invocation_short_name */
#include "common/signals.h"

#include <errno.h>
#include <jansson.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ibl/io.h"

/* Signals from outside that end a program, and ABRT, raised by libraries. */
static const int caught[] = {SIGHUP,  SIGINT,  SIGQUIT, SIGABRT, SIGUSR1,
                             SIGUSR2, SIGPIPE, SIGALRM, SIGTERM, SIGXCPU};

/* The handler. The signal is blocked while it runs, so the raised one arrives
 * when it returns, with the default action. */
static void die(int number)
{
    ibl_outputs_abort_all();
    signal(number, SIG_DFL);
    raise(number);
}

static void *need_bytes(size_t size)
{
    return ibl_need(malloc(size));
}

void ibl_signals_catch(void)
{
    struct sigaction action = {.sa_handler = die}, old;
    const size_t count = sizeof caught / sizeof *caught;

    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < count; i++)
        sigaddset(&action.sa_mask, caught[i]);
    for (size_t i = 0; i < count; i++)
        if (!sigaction(caught[i], NULL, &old) && old.sa_handler != SIG_IGN)
            sigaction(caught[i], &action, NULL);
    signal(SIGXFSZ, SIG_IGN);
    json_set_alloc_funcs(need_bytes, free);
}

void *ibl_need(void *p)
{
    if (p)
        return p;
    fprintf(stderr, "%s: no memory: ask for less, or end other programs\n",
            program_invocation_short_name);
    ibl_outputs_abort_all();
    _exit(1); /* other threads may run: no exit functions */
}

void ibl_append(char **text, const char *fmt, ...)
{
    const size_t used = *text ? strlen(*text) : 0;
    char *more = NULL;
    va_list ap;

    va_start(ap, fmt);
    if (vasprintf(&more, fmt, ap) < 0)
        ibl_need(NULL);
    va_end(ap);
    *text = ibl_need(realloc(*text, used + strlen(more) + 1));
    strcpy(*text + used, more);
    free(more);
}
