/* SPDX-License-Identifier: MIT */
#include "io/input.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/context.h"

enum {
    POLL_MS = 50,          /* delay until a cancel is seen */
    GRACE_MS = 500,        /* time for a pipe's writer to open it */
    FIRST_BYTES = 1 << 16, /* first read of a stream */
    MAX_READ = 1 << 24
};

/* Limit for streams of unknown kind, so that they do not fill the memory. */
static const uint64_t longest_unknown = (uint64_t)256 << 20;

typedef struct loading {
    ibl_input in; /* bytes is NULL until all are read */
    bool stream;  /* a read may wait for a writer */
    bool may_end; /* a read of 0 bytes is the end: there was a writer */
    ibl_longest_fn *longest;
    unsigned char *bytes;
    size_t size, room;
    uint64_t file_size; /* of a regular file, else 0 */
} loading;

ibl_status ibl_reject(const ibl_input *in, ibl_status status, const char *fmt,
                      ...)
{
    char text[4096 + 1024]; /* a path and a message */
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(text, sizeof text, fmt, ap);
    va_end(ap);
    return ibl_fail(in->ctx, status, "%s: %s", in->name, text);
}

ibl_status ibl_allow(const ibl_input *in, size_t bytes)
{
    const size_t most = ibl_ctx_memory(in->ctx);

    if (bytes <= most)
        return IBL_OK;
    return ibl_reject(in, IBL_ERR_MEMORY,
                      "takes %.0f MiB of memory, more than the %.0f that are "
                      "allowed: scale it down, or allow more",
                      ceil((double)bytes / (1 << 20)),
                      floor((double)most / (1 << 20)));
}

const char *ibl_quote(const char *text, char out[IBL_QUOTE_BYTES])
{
    const int kept = IBL_QUOTE_BYTES - 4;
    snprintf(out, IBL_QUOTE_BYTES, "%.*s%s", kept, text,
             strlen(text) > (size_t)kept ? "..." : "");
    for (char *c = out; *c; c++)
        *c = *c >= ' ' && *c < 127 ? *c : '?';
    return out;
}

ibl_status ibl_input_unread(const ibl_input *in, int error)
{
    return ibl_reject(in, IBL_ERR_IO, "cannot be read: %s", strerror(error));
}

static ibl_status refuse(const loading *l, const char *why)
{
    return ibl_reject(&l->in, IBL_ERR_IO, "%s", why);
}

/* Waits until a stream has data or the user cancels. */
static ibl_status wait_for(const loading *l)
{
    struct pollfd p = {.fd = l->in.fd, .events = POLLIN};
    while (!ibl_cancelled(l->in.ctx)) {
        const int n = poll(&p, 1, POLL_MS);
        if (n > 0)
            return IBL_OK;
        if (n < 0 && errno != EINTR)
            return refuse(l, strerror(errno));
        if (n == 0 && !l->may_end)
            return IBL_OK;
    }
    return IBL_ERR_CANCELLED;
}

/* Reads once. *n is 0 at the end of the file. */
static ibl_status read_some(loading *l, ssize_t *n)
{
    int waited = 0;
    for (;;) {
        const size_t room = l->room - l->size;
        ibl_status status = l->stream ? wait_for(l) : IBL_OK;
        if (status)
            return status;
        *n = read(l->in.fd, l->bytes + l->size,
                  room < MAX_READ ? room : MAX_READ);
        if (*n > 0 || (*n == 0 && l->may_end))
            return IBL_OK;
        if (*n < 0 && errno == EAGAIN) {
            l->may_end = true; /* there is a writer, but no data yet */
        } else if (*n < 0 && errno != EINTR) {
            return refuse(l, strerror(errno));
        } else if (*n == 0) {
            if (waited >= GRACE_MS)
                return refuse(l, "is a pipe that nobody writes to");
            waited += POLL_MS; /* the time that wait_for took */
        }
    }
}

static ibl_status too_long(const loading *l, uint64_t most, const char *why)
{
    return ibl_bad_file(&l->in, "over %llu MiB%s",
                        (unsigned long long)(most >> 20), why);
}

/* Doubles the room, up to one byte over the limit for the kind of the file. */
static ibl_status make_room(loading *l)
{
    const uint64_t longest = !l->stream   ? IBL_LONGEST
                             : l->longest ? l->longest(l->bytes, l->size)
                                          : 0;
    const uint64_t kind = longest ? longest : longest_unknown;
    const uint64_t allowed = ibl_ctx_memory(l->in.ctx) / 2;
    const uint64_t most = kind < allowed ? kind : allowed;
    if (l->size > most)
        return too_long(l, most,
                        most < kind ? ", half of the memory that is allowed: "
                                      "read it from a file, or allow more"
                        : longest   ? ", more than a file that begins so has"
                                    : " of no known kind of file");
    const size_t room = l->room <= most / 2 ? l->room * 2 : (size_t)most + 1;
    unsigned char *more = room > l->room ? ibl_alloc_array(room, 1) : NULL;
    if (!more)
        return ibl_reject(&l->in, IBL_ERR_MEMORY,
                          "no memory for more than %zu bytes", l->size);
    memcpy(more, l->bytes, l->size);
    ibl_free(l->bytes);
    l->bytes = more;
    l->room = room;
    return IBL_OK;
}

static ibl_status read_all(loading *l)
{
    for (;;) {
        ssize_t n;
        ibl_status status = IBL_OK;
        if (l->size == l->room)
            status = make_room(l);
        if (!status)
            status = read_some(l, &n);
        if (status)
            return status;
        if (n == 0)
            break;
        l->may_end = true;
        l->size += (size_t)n;
        if (ibl_cancelled(l->in.ctx))
            return IBL_ERR_CANCELLED;
    }
    if (!l->size)
        return ibl_bad_file(&l->in, "is empty");
    return IBL_OK;
}

/* Checks that the opened file is of a kind that can be read. */
static ibl_status look(loading *l, bool standard_input)
{
    struct stat st;
    if (fstat(l->in.fd, &st))
        return refuse(l, strerror(errno));
    if (S_ISDIR(st.st_mode))
        return refuse(l, "is a directory, a file is needed");
    if (standard_input && isatty(l->in.fd))
        return refuse(l, "is a terminal; pipe a file into it");
    if (!standard_input && !S_ISREG(st.st_mode) && !S_ISFIFO(st.st_mode))
        return refuse(l, "is a device, not a file; for standard input give -");
    l->stream = !S_ISREG(st.st_mode);
    l->may_end = standard_input || !S_ISFIFO(st.st_mode);
    if (l->stream)
        return IBL_OK;
    l->file_size = (uint64_t)st.st_size;
    if (l->file_size <= IBL_LONGEST)
        return IBL_OK;
    return too_long(l, IBL_LONGEST, ", more than any map or texture has");
}

/* Reads everything into memory; *in becomes that memory. */
static ibl_status load(loading *l, ibl_input *in)
{
    /* One byte more, to see the end; files of /proc report a size of 0. */
    l->room = FIRST_BYTES;
    if (l->file_size >= FIRST_BYTES)
        l->room = (size_t)l->file_size + 1;
    const ibl_status fits = ibl_allow(&l->in, l->room);
    if (fits)
        return fits;
    l->bytes = ibl_alloc_array(l->room, 1);
    if (!l->bytes)
        return ibl_reject(&l->in, IBL_ERR_MEMORY, "no memory for its %zu bytes",
                          l->room);
    const ibl_status status = read_all(l);
    if (status) {
        ibl_free(l->bytes);
        return status;
    }
    *in = ibl_input_of(l->in.ctx, l->in.name, l->bytes, l->size);
    in->owned = l->bytes;
    return IBL_OK;
}

ibl_status ibl_input_open(ibl_ctx *ctx, const char *path,
                          ibl_longest_fn *longest, ibl_input *in)
{
    const bool standard_input = !strcmp(path, "-");
    loading l = {.in = {.ctx = ctx,
                        .name = standard_input ? "standard input" : path,
                        .fd = STDIN_FILENO},
                 .longest = longest};
    ibl_status status;

    /* O_NONBLOCK: else a FIFO without a writer blocks for ever. */
    if (!standard_input)
        l.in.fd = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (l.in.fd < 0)
        return ibl_reject(&l.in, IBL_ERR_IO, "cannot be opened: %s",
                          strerror(errno));
    status = look(&l, standard_input);
    if (!status && !standard_input && l.file_size >= FIRST_BYTES) {
        *in = l.in;
        in->size = (size_t)l.file_size;
        return IBL_OK;
    }
    if (!status)
        status = load(&l, in);
    if (!standard_input)
        close(l.in.fd);
    return status;
}

ibl_input ibl_input_of(ibl_ctx *ctx, const char *name, const void *bytes,
                       size_t size)
{
    return (ibl_input){
        .ctx = ctx, .name = name, .size = size, .bytes = bytes, .fd = -1};
}

bool ibl_input_has(const ibl_input *in, uint64_t at, uint64_t size)
{
    const size_t there = in->head ? in->head : in->size;

    return at <= there && size <= there - at;
}

ibl_status ibl_input_load(ibl_input *in)
{
    loading l = {.in = *in, .may_end = true, .file_size = in->size};
    if (in->bytes)
        return IBL_OK;
    if (lseek(in->fd, 0, SEEK_SET))
        return refuse(&l, strerror(errno));
    const ibl_status status = load(&l, in);
    if (!status)
        close(l.in.fd);
    return status;
}

bool ibl_input_read(const ibl_input *in, uint64_t offset, size_t size,
                    void *dst, size_t *got)
{
    const size_t left = offset < in->size ? in->size - (size_t)offset : 0;

    size = size < left ? size : left;
    *got = 0;
    if (in->bytes) {
        if (size) /* bytes may be NULL */
            memcpy(dst, in->bytes + offset, size);
        *got = size;
        return true;
    }
    while (*got < size) {
        const ssize_t n = pread(in->fd, (char *)dst + *got, size - *got,
                                (off_t)(offset + *got));
        if (n == 0)
            return true;
        if (n < 0 && errno != EINTR)
            return false;
        *got += n > 0 ? (size_t)n : 0;
    }
    return true;
}

void ibl_input_close(ibl_input *in)
{
    ibl_free(in->owned);
    if (in->fd >= 0)
        close(in->fd);
    *in = ibl_input_of(in->ctx, in->name, NULL, 0);
}
