/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* vasprintf */
#include "common/signals.h"

#include <jansson.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/path.h"
#include "ibl/io.h"
#include "port/port.h"

static void *need_bytes(size_t size)
{
    return ibl_need(malloc(size));
}

static const char *program = "iblbake";

void ibl_signals_catch(int argc, char **argv)
{
    if (argc)
        program = ibl_path_name(*argv);
    ibl_port_begin(argc, argv, ibl_outputs_abort_all);
    json_set_alloc_funcs(need_bytes, free);
}

void *ibl_need(void *p)
{
    if (p)
        return p;
    fprintf(stderr, "%s: no memory: ask for less, or end other programs\n",
            program);
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
