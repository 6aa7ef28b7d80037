/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* fopencookie, vasprintf */
#include "json/text.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum {
    FIRST_BYTES = 4096
};

/* Returning 0 sets the stream's error. */
static ssize_t take_piece(void *cookie, const char *bytes, size_t size)
{
    ibl_memory_file *m = cookie;

    if (m->room - m->size <= size) {
        const size_t room = 2 * (m->size + size);
        char *grown = realloc(m->text, room);
        if (!grown)
            return 0;
        m->text = grown;
        m->room = room;
    }
    memcpy(m->text + m->size, bytes, size);
    m->size += size;
    return (ssize_t)size;
}

FILE *ibl_memory_open(ibl_memory_file *m)
{
    FILE *to = NULL;

    *m = (ibl_memory_file){.text = malloc(FIRST_BYTES), .room = FIRST_BYTES};
    if (m->text)
        to = fopencookie(m, "w", (cookie_io_functions_t){.write = take_piece});
    if (!to)
        free(m->text);
    return to;
}

char *ibl_memory_close(FILE *to, ibl_memory_file *m)
{
    if (!to)
        return NULL;
    const int failed = ferror(to);
    if (fclose(to) || failed) {
        free(m->text);
        return NULL;
    }
    m->text[m->size] = '\0';
    return m->text;
}

char *ibl_format(const char *fmt, ...)
{
    char *text;
    va_list ap;

    va_start(ap, fmt);
    const int length = vasprintf(&text, fmt, ap);
    va_end(ap);
    return length < 0 ? NULL : text;
}

void ibl_names_text(const char *const *names, char *text, size_t size)
{
    *text = '\0';
    for (int i = 0; names[i]; i++) {
        const size_t used = strlen(text);
        const char *between = i == 0 ? "" : names[i + 1] ? ", " : " or ";
        snprintf(text + used, size - used, "%s%s", between, names[i]);
    }
}

int ibl_names_find(const char *const *names, const char *word)
{
    for (int i = 0; names[i]; i++)
        if (!strcmp(names[i], word))
            return i;
    return -1;
}
