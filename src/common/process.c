/* SPDX-License-Identifier: MIT */
#include "common/process.h"

#include <errno.h>
#include <string.h>
#include <time.h>

#include "common/option.h"

double ibl_now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void ibl_one_line(char *text)
{
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 0x7f)
            *c = '?';
}

void ibl_print_line(const char *kind, const char *text)
{
    char line[IBL_LINE_BYTES];

    snprintf(line, sizeof line, "%s%s", kind, text);
    ibl_one_line(line);
    fprintf(stderr, "%s: %s\n", ibl_this_program.name, line);
}

const char *ibl_unwritten(FILE *stream)
{
    if (!fflush(stream) && !ferror(stream))
        return NULL;
    return errno ? strerror(errno) : "an earlier write failed";
}
