/* SPDX-License-Identifier: MIT */
#include "json/json_load.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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

/* Opens a regular file; NULL: see why. */
static FILE *open_file(const char *path, ibl_json_why *why)
{
    /* O_NONBLOCK: do not wait for the writer of a FIFO. */
    const int fd = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    FILE *file = NULL;
    struct stat st;

    if (fd < 0 || fstat(fd, &st))
        fail(why, IBL_ERR_IO, "%s: cannot be read: %s", path, strerror(errno));
    else if (S_ISDIR(st.st_mode))
        fail(why, IBL_ERR_IO,
             "%s: is a directory: give the name of a file in it", path);
    else if (!S_ISREG(st.st_mode))
        fail(why, IBL_ERR_IO,
             "%s: is no file, but a pipe or a device: give the name of a file",
             path);
    else if (st.st_size > IBL_JSON_BYTES)
        fail(why, IBL_ERR_FORMAT, "%s: over %d MiB, which no such file has",
             path, IBL_JSON_BYTES >> 20);
    else if (!(file = fdopen(fd, "rb")))
        fail(why, IBL_ERR_MEMORY, "%s: no memory to read it", path);
    if (fd >= 0 && !file)
        close(fd);
    return file;
}

/* jansson says of a failed allocation that the text is wrong, or nothing. So
 * one that notes failures stands before its allocator while it parses.
 */
static pthread_mutex_t one_file = PTHREAD_MUTEX_INITIALIZER;
static json_malloc_t ask;
static _Thread_local bool out_of_memory;

static void *allocate(size_t size)
{
    void *p = ask(size);

    out_of_memory |= !p;
    return p;
}

/* Parses text or, if that is NULL, a file. */
static json_t *parse(const char *text, FILE *file, size_t flags,
                     json_error_t *error)
{
    json_free_t give_back;

    pthread_mutex_lock(&one_file);
    json_get_alloc_funcs(&ask, &give_back);
    json_set_alloc_funcs(allocate, give_back);
    out_of_memory = false;
    errno = 0;
    json_t *root =
        text ? json_loads(text, flags, error) : json_loadf(file, flags, error);
    json_set_alloc_funcs(ask, give_back);
    pthread_mutex_unlock(&one_file);
    return root;
}

json_t *ibl_json_load(const char *path, size_t flags, ibl_json_why *why)
{
    FILE *file = open_file(path, why);
    json_error_t error;

    if (!file)
        return NULL;
    json_t *root = parse(NULL, file, flags, &error);
    const int failed = ferror(file) ? errno : 0;
    fclose(file);
    if (root && !out_of_memory && !failed)
        return root;
    json_decref(root);
    if (out_of_memory)
        return fail(why, IBL_ERR_MEMORY, "%s: no memory to read it", path);
    if (failed)
        return fail(why, IBL_ERR_IO, "%s: cannot be read: %s", path,
                    strerror(failed));
    return fail(why, IBL_ERR_FORMAT, "%s:%d:%d: no JSON: %s", path, error.line,
                error.column, error.text);
}

ibl_status ibl_json_parse(const char *text, size_t flags, json_t **root)
{
    json_error_t error;

    *root = parse(text, NULL, flags, &error);
    if (*root && !out_of_memory)
        return IBL_OK;
    json_decref(*root);
    *root = NULL;
    return out_of_memory ? IBL_ERR_MEMORY : IBL_ERR_FORMAT;
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
