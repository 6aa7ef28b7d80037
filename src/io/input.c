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

static ibl_status too_long(const ibl_input *in, uint64_t most, const char *why)
{
    return ibl_bad_file(in, "over %llu MiB%s", (unsigned long long)(most >> 20),
                        why);
}

/* Doubles the room of a stream's bytes, up to one byte over what it may have.
 */
static ibl_status make_room(const ibl_input *in, ibl_longest_fn *longest,
                            unsigned char **bytes, size_t size, size_t *room)
{
    const uint64_t known = longest ? longest(*bytes, size) : 0;
    const uint64_t kind = known ? known : longest_unknown;
    const uint64_t allowed = ibl_ctx_memory(in->ctx) / 2;
    const uint64_t most = kind < allowed ? kind : allowed;

    if (size > most)
        return too_long(in, most,
                        most < kind ? ", half of the memory that is allowed: "
                                      "read it from a file, or allow more"
                        : known     ? ", more than a file that begins so has"
                                    : " of no known kind of file");
    const size_t larger = *room <= most / 2 ? *room * 2 : (size_t)most + 1;
    unsigned char *more = ibl_alloc_array(larger, 1);
    if (!more)
        return ibl_reject(in, IBL_ERR_MEMORY,
                          "no memory for more than %zu bytes", size);
    memcpy(more, *bytes, size);
    ibl_free(*bytes);
    *bytes = more;
    *room = larger;
    return IBL_OK;
}

/* Reads a stream, or a small file, to its end. Waits for a pipe's data until
 * the user cancels, and for the writer of a named one for a moment. */
static ibl_status read_stream(const ibl_input *in, bool pipe, bool named,
                              ibl_longest_fn *longest, unsigned char **bytes,
                              size_t *size)
{
    size_t room = FIRST_BYTES;
    bool may_end = !pipe || !named; /* there was a writer */
    int waited = 0;

    *bytes = ibl_alloc_array(room, 1);
    *size = 0;
    if (!*bytes)
        return ibl_no_memory(in->ctx, "a file");
    for (;;) {
        struct pollfd p = {.fd = in->fd, .events = POLLIN};
        ibl_status status = IBL_OK;
        if (*size == room)
            status = make_room(in, longest, bytes, *size, &room);
        if (!status && ibl_cancelled(in->ctx))
            status = IBL_ERR_CANCELLED;
        if (status)
            return status;
        if (pipe && poll(&p, 1, POLL_MS) <= 0 && may_end)
            continue;
        const ssize_t n = read(in->fd, *bytes + *size, room - *size);
        if (n == 0 && may_end)
            return *size ? IBL_OK : ibl_bad_file(in, "is empty");
        if (n < 0 && errno != EAGAIN && errno != EINTR)
            return ibl_input_unread(in, errno);
        if (n == 0 && waited >= GRACE_MS)
            return ibl_reject(in, IBL_ERR_IO,
                              "is a pipe that nobody writes to");
        if (n == 0)
            waited += POLL_MS; /* that poll took */
        else
            may_end |= n > 0 || errno == EAGAIN;
        *size += n > 0 ? (size_t)n : 0;
    }
}

ibl_status ibl_input_open(ibl_ctx *ctx, const char *path,
                          ibl_longest_fn *longest, ibl_input *in)
{
    const bool named = strcmp(path, "-") != 0;
    unsigned char *bytes = NULL;
    struct stat st = {.st_size = 0};
    const char *why = NULL;
    size_t size = 0;

    *in = ibl_input_of(ctx, named ? path : "standard input", NULL, 0);
    /* O_NONBLOCK: else a FIFO without a writer blocks for ever. */
    in->fd = named ? open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)
                   : STDIN_FILENO;
    if (in->fd < 0 || fstat(in->fd, &st))
        return ibl_reject(in, IBL_ERR_IO, "cannot be opened: %s",
                          strerror(errno));
    const bool regular = S_ISREG(st.st_mode);
    if (S_ISDIR(st.st_mode))
        why = "is a directory, a file is needed";
    else if (!named && isatty(in->fd))
        why = "is a terminal; pipe a file into it";
    else if (named && !regular && !S_ISFIFO(st.st_mode))
        why = "is a device, not a file; for standard input give -";
    ibl_status status = why ? ibl_reject(in, IBL_ERR_IO, "%s", why) : IBL_OK;
    if (!status && regular && (uint64_t)st.st_size > IBL_LONGEST)
        status =
            too_long(in, IBL_LONGEST, ", more than any map or texture has");
    if (!status && named && regular && st.st_size >= FIRST_BYTES) {
        in->size = (size_t)st.st_size;
        return IBL_OK;
    }
    if (!status) /* files of /proc report a size of 0 */
        status = read_stream(in, !regular, named, longest, &bytes, &size);
    if (named)
        close(in->fd);
    *in = ibl_input_of(ctx, in->name, bytes, size);
    in->owned = bytes;
    if (status)
        ibl_input_close(in);
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
    if (in->bytes)
        return IBL_OK;
    const ibl_status fits = ibl_allow(in, in->size);
    if (fits)
        return fits;
    unsigned char *bytes = ibl_alloc_array(in->size, 1);
    size_t got = 0;
    if (!bytes)
        return ibl_reject(in, IBL_ERR_MEMORY, "no memory for its %zu bytes",
                          in->size);
    ibl_status status = IBL_OK;
    for (size_t at = 0, n = 1; n > 0 && !status; at = got += n) {
        if (ibl_cancelled(in->ctx))
            status = IBL_ERR_CANCELLED;
        else if (!ibl_input_read(in, at, MAX_READ, bytes + at, &n))
            status = ibl_input_unread(in, errno);
    }
    if (!status && !got)
        status = ibl_bad_file(in, "is empty");
    if (status) {
        ibl_free(bytes);
        return status;
    }
    close(in->fd);
    *in = ibl_input_of(in->ctx, in->name, bytes, got);
    in->owned = bytes;
    return IBL_OK;
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
