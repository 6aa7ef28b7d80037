/* SPDX-License-Identifier: MIT */
#include "io/input.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/context.h"

enum {
    POLL_MS = 50,          /* how soon a cancel is seen */
    GRACE_MS = 500,        /* for a pipe's writer to come */
    FIRST_BYTES = 1 << 16, /* of a stream */
    MAX_READ = 1 << 24
};

/* Streams end somewhere; a machine's memory should not be what ends them. */
static const uint64_t longest_unknown = (uint64_t)256 << 20;

typedef struct loading {
    ibl_ctx *ctx;
    const char *name;
    int fd;
    bool stream;  /* may wait for a writer */
    bool may_end; /* a pipe has had a writer, so that its end is its end */
    ibl_longest_fn *longest;
    unsigned char *bytes;
    size_t size, room;
    uint64_t file_size; /* of a regular file, else 0 */
} loading;

static ibl_status refuse(const loading *in, const char *why)
{
    return ibl_fail(in->ctx, IBL_ERR_IO, "%s: %s", in->name, why);
}

/* Twice as much, but not more than one byte over the most. */
static ibl_status grow(loading *in, uint64_t most)
{
    const size_t room = in->room <= most / 2 ? in->room * 2 : (size_t)most + 1;
    unsigned char *more = room > in->room ? ibl_alloc_array(room, 1) : NULL;
    if (!more)
        return ibl_fail(in->ctx, IBL_ERR_MEMORY,
                        "%s: no memory for more than %zu bytes", in->name,
                        in->size);
    memcpy(more, in->bytes, in->size);
    ibl_free(in->bytes);
    in->bytes = more;
    in->room = room;
    return IBL_OK;
}

/* Waits until a stream has something, with an eye on cancelling. */
static ibl_status wait_for(const loading *in)
{
    struct pollfd p = {.fd = in->fd, .events = POLLIN};
    while (!ibl_cancelled(in->ctx)) {
        const int n = poll(&p, 1, POLL_MS);
        if (n > 0)
            return IBL_OK;
        if (n < 0 && errno != EINTR)
            return refuse(in, strerror(errno));
        if (n == 0 && !in->may_end)
            return IBL_OK;
    }
    return IBL_ERR_CANCELLED;
}

/* Reads once. *n is 0 at the end. */
static ibl_status read_some(loading *in, ssize_t *n)
{
    int waited = 0;
    for (;;) {
        const size_t room = in->room - in->size;
        ibl_status status = in->stream ? wait_for(in) : IBL_OK;
        if (status)
            return status;
        *n = read(in->fd, in->bytes + in->size,
                  room < MAX_READ ? room : MAX_READ);
        if (*n > 0 || (*n == 0 && in->may_end))
            return IBL_OK;
        if (*n < 0 && errno == EAGAIN) {
            in->may_end = true; /* there is a writer, but no data yet */
        } else if (*n < 0 && errno != EINTR) {
            return refuse(in, strerror(errno));
        } else if (*n == 0) {
            if (waited >= GRACE_MS)
                return refuse(in, "is a pipe that nobody writes to");
            waited += POLL_MS; /* what wait_for took */
        }
    }
}

static ibl_status too_long(const loading *in, uint64_t most, const char *why)
{
    return ibl_fail(in->ctx, IBL_ERR_FORMAT, "%s: over %llu MiB%s", in->name,
                    (unsigned long long)(most >> 20), why);
}

/* Room for more of what may go on. */
static ibl_status make_room(loading *in)
{
    const uint64_t longest =
        in->stream ? in->longest(in->bytes, in->size) : IBL_LONGEST;
    const uint64_t most = longest ? longest : longest_unknown;
    if (in->size > most)
        return too_long(in, most,
                        longest ? ", more than a file that begins so has"
                                : " of no known kind of file");
    return grow(in, most);
}

static ibl_status read_all(loading *in)
{
    for (;;) {
        ssize_t n;
        ibl_status status = IBL_OK;
        if (in->size == in->room)
            status = make_room(in);
        if (!status)
            status = read_some(in, &n);
        if (status)
            return status;
        if (n == 0)
            break;
        in->may_end = true;
        in->size += (size_t)n;
        if (ibl_cancelled(in->ctx))
            return IBL_ERR_CANCELLED;
    }
    if (!in->size)
        return ibl_fail(in->ctx, IBL_ERR_FORMAT, "%s: is empty", in->name);
    return IBL_OK;
}

/* Looks at what was opened. */
static ibl_status look(loading *in, bool standard_input)
{
    struct stat st;
    if (fstat(in->fd, &st))
        return refuse(in, strerror(errno));
    if (S_ISDIR(st.st_mode))
        return refuse(in, "is a directory, a file is needed");
    if (standard_input && isatty(in->fd))
        return refuse(in, "is a terminal; pipe a file into it");
    if (!standard_input && !S_ISREG(st.st_mode) && !S_ISFIFO(st.st_mode))
        return refuse(in, "is a device, not a file; for standard input give -");
    in->stream = !S_ISREG(st.st_mode);
    in->may_end = standard_input || !S_ISFIFO(st.st_mode);
    if (in->stream)
        return IBL_OK;
    in->file_size = (uint64_t)st.st_size;
    return in->file_size <= IBL_LONGEST
               ? IBL_OK
               : too_long(in, IBL_LONGEST,
                          ", more than any map or texture has");
}

static ibl_status load(loading *in)
{
    /* One byte over, to see the end; a size of 0 may be a file of /proc. */
    in->room = FIRST_BYTES;
    if (in->file_size >= FIRST_BYTES)
        in->room = (size_t)in->file_size + 1;
    in->bytes = ibl_alloc_array(in->room, 1);
    if (!in->bytes)
        return ibl_fail(in->ctx, IBL_ERR_MEMORY,
                        "%s: no memory for its %zu bytes", in->name, in->room);
    const ibl_status status = read_all(in);
    if (status)
        ibl_free(in->bytes);
    return status;
}

static ibl_input loaded(const loading *l)
{
    return (ibl_input){l->name, l->size, l->bytes, l->bytes, -1};
}

ibl_status ibl_input_open(ibl_ctx *ctx, const char *path,
                          ibl_longest_fn *longest, ibl_input *in)
{
    const bool standard_input = !strcmp(path, "-");
    loading l = {.ctx = ctx,
                 .name = standard_input ? "standard input" : path,
                 .fd = STDIN_FILENO,
                 .longest = longest};
    ibl_status status;

    /* Not blocking: a FIFO without a writer would, for ever. */
    if (!standard_input)
        l.fd = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (l.fd < 0)
        return ibl_fail(ctx, IBL_ERR_IO, "%s: cannot be opened: %s", path,
                        strerror(errno));
    status = look(&l, standard_input);
    if (!status && !standard_input && l.file_size >= FIRST_BYTES) {
        *in =
            (ibl_input){.name = path, .size = (size_t)l.file_size, .fd = l.fd};
        return IBL_OK;
    }
    if (!status)
        status = load(&l);
    if (!standard_input)
        close(l.fd);
    if (!status)
        *in = loaded(&l);
    return status;
}

ibl_input ibl_input_of(const char *name, const void *bytes, size_t size)
{
    return (ibl_input){.name = name, .bytes = bytes, .size = size, .fd = -1};
}

ibl_status ibl_input_load(ibl_ctx *ctx, ibl_longest_fn *longest, ibl_input *in)
{
    loading l = {.ctx = ctx,
                 .name = in->name,
                 .fd = in->fd,
                 .may_end = true,
                 .longest = longest,
                 .file_size = in->size};
    if (in->bytes)
        return IBL_OK;
    if (lseek(in->fd, 0, SEEK_SET))
        return refuse(&l, strerror(errno));
    const ibl_status status = load(&l);
    if (status)
        return status;
    ibl_input_close(in);
    *in = loaded(&l);
    return IBL_OK;
}

bool ibl_input_read(const ibl_input *in, uint64_t offset, size_t size,
                    void *dst, size_t *got)
{
    const size_t left = offset < in->size ? in->size - (size_t)offset : 0;

    size = size < left ? size : left;
    *got = 0;
    if (in->bytes) {
        if (size) /* there may be no bytes to point to */
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
    *in = (ibl_input){.name = in->name, .fd = -1};
}
