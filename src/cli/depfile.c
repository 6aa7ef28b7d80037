/* SPDX-License-Identifier: MIT */
#include "cli/depfile.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/memory_file.h"

/*
 * Quotes as GCC's -MD does, which make and ninja both understand: a dollar is
 * doubled, '#' and ':' get a backslash, a blank too, and backslashes before a
 * blank are doubled.
 */
static void put_path(FILE *to, const char *path)
{
    size_t backslashes = 0;

    for (; *path; path++) {
        if (*path == ' ' || *path == '\t')
            for (size_t i = 0; i <= backslashes; i++)
                fputc('\\', to);
        else if (*path == '#' || *path == ':')
            fputc('\\', to);
        else if (*path == '$')
            fputc('$', to);
        backslashes = *path == '\\' ? backslashes + 1 : 0;
        fputc(*path, to);
    }
}

char *ibl_depfile_text(const ibl_bake *b)
{
    const ibl_opts *o = b->opts;
    const char *between = "";
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);

    if (!to)
        return NULL;
    for (int i = 0; i < IBL_OUTPUT_COUNT; i++)
        if (b->files[i].path) {
            fputs(between, to);
            put_path(to, b->files[i].path);
            between = " \\\n  ";
        }
    if (o->preview) {
        fputs(between, to);
        put_path(to, o->preview);
    }
    fputc(':', to);
    if (o->input && strcmp(o->input, "-") != 0) {
        fputc(' ', to);
        put_path(to, o->input);
    }
    fputc('\n', to);
    return ibl_memory_close(to, &file);
}
