/* SPDX-License-Identifier: MIT */
#include "json/json_load.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "port/port.h"

enum {
    FILE_BYTES = 1 << 28, /* glTF has buffers in its text */
    ITEMS = 1 << 23       /* of about 128 bytes each in memory */
};

static void *fail(ibl_json_why *why, ibl_status status, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
static void *fail(ibl_json_why *why, ibl_status status, const char *fmt, ...)
{
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(why->line, sizeof why->line, fmt, ap);
    va_end(ap);
    why->status = status;
    return NULL;
}

json_t *ibl_json_parse(const char *name, const void *text, size_t size,
                       size_t flags, ibl_json_why *why)
{
    const char *at = text;
    json_error_t error;
    int items = 0;

    for (size_t i = 0; i < size && items <= ITEMS; i++)
        items += at[i] == ',' || at[i] == '[' || at[i] == '{';
    if (items > ITEMS)
        return fail(why, IBL_ERR_FORMAT,
                    "%s: over %d values, which no such file has", name, ITEMS);
    json_t *root = json_loadb(text, size, flags, &error);
    if (root)
        return root;
    if (json_error_code(&error) == json_error_out_of_memory)
        return fail(why, IBL_ERR_MEMORY, "%s: no memory to read it", name);
    return fail(why, IBL_ERR_FORMAT, "%s:%d:%d: no JSON: %s", name, error.line,
                error.column, error.text);
}

json_t *ibl_json_load(const char *path, size_t flags, ibl_json_why *why)
{
    const int fd = ibl_port_open(path);
    json_t *root = NULL;
    struct stat st;
    FILE *file = NULL;
    char *text = NULL;

    if (fd < 0 || fstat(fd, &st))
        fail(why, IBL_ERR_IO, "%s: cannot be read: %s", path, strerror(errno));
    else if (S_ISDIR(st.st_mode))
        fail(why, IBL_ERR_IO,
             "%s: is a directory: give the name of a file in it", path);
    else if (!S_ISREG(st.st_mode))
        fail(why, IBL_ERR_IO,
             "%s: is no file, but a pipe or a device: give the name of a file",
             path);
    else if (st.st_size > FILE_BYTES)
        fail(why, IBL_ERR_FORMAT, "%s: over %d MiB, which no such file has",
             path, FILE_BYTES >> 20);
    else if (!(file = fdopen(fd, "rb")) ||
             !(text = malloc((size_t)st.st_size + 1)))
        fail(why, IBL_ERR_MEMORY, "%s: no memory to read it", path);
    if (text) {
        const size_t size = fread(text, 1, (size_t)st.st_size, file);
        root = ferror(file) ? fail(why, IBL_ERR_IO, "%s: cannot be read: %s",
                                   path, strerror(errno))
                            : ibl_json_parse(path, text, size, flags, why);
    }
    free(text);
    if (file)
        fclose(file);
    else if (fd >= 0)
        close(fd);
    return root;
}

bool ibl_json_numbers(const json_t *list, double *to, int count)
{
    for (int i = 0; i < count; i++) {
        const json_t *x = json_array_get(list, (size_t)i);
        to[i] = json_number_value(x);
        if (!json_is_number(x) || !isfinite(to[i]))
            return false;
    }
    return true;
}
