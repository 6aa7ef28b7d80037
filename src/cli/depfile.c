/* SPDX-License-Identifier: MIT */
#include "cli/depfile.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/memory_file.h"

/*
 * Quotes as GCC's -MD does, which make and ninja both understand: a dollar is
 * doubled, '#' and ':' get a backslash, a blank too, and backslashes before a
 * blank are doubled. What cannot be quoted was refused.
 */
static void put_path(FILE *to, const char *path)
{
    size_t backslashes = 0;

    for (; *path; path++) {
        if (*path == ' ')
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

/*
 * Besides these make takes '=' for a variable's, '|' and ';' for what follows
 * the prerequisites, '%' for a pattern, a last ')' for an archive's, '~' for a
 * home; ninja ends a name at most others. There is nothing to quote them with.
 */
bool ibl_depfile_refuses(const char *path, char why[IBL_DEPFILE_WHY])
{
    const size_t length = strlen(path);
    const char last = length ? path[length - 1] : 'a';
    const char *at = path;

    while (*at && !iscntrl((unsigned char)*at) &&
           !strchr("\"%&'*;<=>?^`|", *at))
        at++;
    if (*at == '\n')
        snprintf(why, IBL_DEPFILE_WHY, "a line break");
    else if (iscntrl((unsigned char)*at) && *at)
        snprintf(why, IBL_DEPFILE_WHY, "a control character");
    else if (*at)
        snprintf(why, IBL_DEPFILE_WHY, "a %c", *at);
    else if (*path == '~')
        snprintf(why, IBL_DEPFILE_WHY, "a ~ at its beginning");
    else if (strchr(" \\:)", last))
        snprintf(why, IBL_DEPFILE_WHY, "'%c' at its end", last);
    else
        return false;
    return true;
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
