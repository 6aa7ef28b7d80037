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

/* ---- jansson's memory ------------------------------------------------------
 *
 * Its lexer overlooks that there was no memory for a longer token, and reads
 * beyond what it has; other failures it reports as damage, or not at all. So an
 * allocator of ours stands before its own while it parses. After a failure it
 * ends the text. Before that, the lexer may ask once for twice its buffer, and
 * gets the block that is held for it: twice as large as any before it.
 */
static pthread_mutex_t one_file = PTHREAD_MUTEX_INITIALIZER;
static json_malloc_t ask;
static json_free_t give_back;
static _Thread_local struct {
    bool parses, failed;
    size_t left; /* of IBL_JSON_MEMORY */
    void *held;
    size_t size; /* of it */
} memory;

static void *allocate(size_t size)
{
    if (!memory.parses)
        return ask(size);
    void *p = size <= memory.left ? ask(size) : NULL;
    memory.left = size <= memory.left ? memory.left - size : 0;
    memory.failed |= !p;
    if (p && size > memory.size / 2) {
        give_back(memory.held);
        memory.held = ask(2 * size);
        memory.size = memory.held ? 2 * size : 0;
        memory.failed |= !memory.held;
    } else if (!p && size <= memory.size) {
        p = memory.held;
        memory.held = NULL;
        memory.size = 0;
    }
    return p;
}

/* Where a text comes from: a file, or what is left at a place. */
typedef struct source {
    FILE *file;
    const char *at;
    size_t left;
} source;

/* A byte at a time, so that none is left to read after a failure. */
static size_t next_byte(void *to, size_t size, void *from)
{
    source *s = from;
    char *byte = to;

    if (!size || memory.failed || (!s->file && !s->left))
        return 0;
    if (s->file) {
        const int c = getc_unlocked(s->file);
        *byte = (char)c;
        return c != EOF;
    }
    *byte = *s->at++;
    s->left--;
    return 1;
}

static json_t *parse(const char *name, source *s, size_t flags,
                     ibl_json_why *why)
{
    json_error_t error;

    pthread_mutex_lock(&one_file);
    json_get_alloc_funcs(&ask, &give_back);
    json_set_alloc_funcs(allocate, give_back);
    memory.parses = true;
    memory.failed = false;
    memory.left = IBL_JSON_MEMORY;
    json_t *root = json_load_callback(next_byte, s, flags, &error);
    const int io = s->file && ferror(s->file) ? errno : 0;
    memory.parses = false;
    give_back(memory.held);
    memory.held = NULL;
    memory.size = 0;
    json_set_alloc_funcs(ask, give_back);
    pthread_mutex_unlock(&one_file);
    if (root && !memory.failed && !io)
        return root;
    json_decref(root);
    if (memory.failed && !memory.left)
        return fail(why, IBL_ERR_FORMAT,
                    "%s: takes over %d MiB of memory, which no such file does",
                    name, IBL_JSON_MEMORY >> 20);
    if (memory.failed)
        return fail(why, IBL_ERR_MEMORY, "%s: no memory to read it", name);
    if (io)
        return fail(why, IBL_ERR_IO, "%s: cannot be read: %s", name,
                    strerror(io));
    return fail(why, IBL_ERR_FORMAT, "%s:%d:%d: no JSON: %s", name, error.line,
                error.column, error.text);
}

json_t *ibl_json_load(const char *path, size_t flags, ibl_json_why *why)
{
    source s = {.file = open_file(path, why)};

    if (!s.file)
        return NULL;
    json_t *root = parse(path, &s, flags, why);
    fclose(s.file);
    return root;
}

json_t *ibl_json_parse(const char *name, const void *text, size_t size,
                       size_t flags, ibl_json_why *why)
{
    return parse(name, &(source){.at = text, .left = size}, flags, why);
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
