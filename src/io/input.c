/* SPDX-License-Identifier: MIT */
#include "io/input.h"

#include <errno.h>
#include <locale.h>
#include <math.h>
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
#include "port/port.h"

/* The functions themselves, so that the library needs no other one. */
#define XXH_INLINE_ALL
#include <xxhash.h>

enum {
    POLL_MS = 50,          /* delay until a cancel is seen */
    FIRST_BYTES = 1 << 16, /* first read of a stream */
    MAX_READ = 1 << 24
};

/* More than any map, so that an endless stream does not fill the memory. */
#define MOST_STREAM ((uint64_t)4 << 30)

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

/* Reads a stream, or a small file, to its end, for which it waits until the
 * user cancels. */
static ibl_status read_stream(ibl_input *in)
{
    const uint64_t half = ibl_ctx_memory(in->ctx) / 2;
    const size_t most = half < MOST_STREAM ? (size_t)half : MOST_STREAM;
    size_t room = 0;

    for (;;) {
        if (in->size == room) {
            room = room ? 2 * room : FIRST_BYTES;
            unsigned char *more = ibl_alloc_array(room, 1);
            if (!more)
                return ibl_reject(in, IBL_ERR_MEMORY,
                                  "no memory for more than %zu bytes",
                                  in->size);
            if (in->size)
                memcpy(more, in->owned, in->size);
            ibl_free(in->owned);
            in->bytes = in->owned = more;
        }
        if (ibl_cancelled(in->ctx))
            return IBL_ERR_CANCELLED;
        if (!ibl_port_readable(in->fd, POLL_MS))
            continue;
        const ssize_t n =
            read(in->fd, (char *)in->owned + in->size, room - in->size);
        if (n == 0)
            return in->size ? IBL_OK : ibl_bad_file(in, "is empty");
        if (n < 0 && errno != EAGAIN && errno != EINTR)
            return ibl_input_unread(in, errno);
        in->size += n > 0 ? (size_t)n : 0;
        if (in->size > most)
            return ibl_bad_file(in,
                                "over %zu MiB, the most that is read of a "
                                "stream: save it as a file, or allow more "
                                "memory",
                                most >> 20);
    }
}

ibl_status ibl_input_open(ibl_ctx *ctx, const char *path, ibl_input *in)
{
    const bool named = strcmp(path, "-") != 0;
    struct stat st = {.st_size = 0};
    const char *why = NULL;

    *in = ibl_input_of(ctx, named ? path : "standard input", NULL, 0);
    in->fd = named ? ibl_port_open(path) : STDIN_FILENO;
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
    if (!status && named && regular && st.st_size >= FIRST_BYTES) {
        in->size = (size_t)st.st_size;
        if (ibl_port_shares_files)
            return IBL_OK;
        status = ibl_input_load(in);
    } else if (!status) { /* files of /proc report a size of 0 */
        status = read_stream(in);
    }
    if (named)
        close(in->fd);
    in->fd = -1;
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

ibl_status ibl_file_hash(const ibl_input *in, char hash[IBL_FILE_HASH])
{
    const int error = in->bytes ? 0 : ibl_hash_file(in->name, hash);

    if (in->bytes)
        ibl_hash_bytes(in->bytes, in->size, hash);
    return error ? ibl_input_unread(in, error) : IBL_OK;
}

bool ibl_take_number(char **t, double *value)
{
    const char *point = localeconv()->decimal_point;
    const size_t n = strspn(*t, " \t\r\n+-0123456789");
    const bool has = (*t)[n] == '.';
    char text[256], *end;

    snprintf(text, sizeof text, "%.*s%s%s", (int)n, *t, has ? point : "",
             *t + n + has);
    *value = strtod(text, &end);
    if (end == text || isnan(*value))
        return false;
    *t += end - text;
    if (has && end > text + n)
        *t -= strlen(point) - 1;
    return true;
}

/* ---- hashes ------------------------------------------------------------ */

_Static_assert(sizeof(XXH3_state_t) <= sizeof(ibl_hash), "no room for XXH3");

void ibl_hash_begin(ibl_hash *h)
{
    XXH3_128bits_reset((XXH3_state_t *)h->state);
}

void ibl_hash_add(ibl_hash *h, const void *bytes, size_t size)
{
    XXH3_128bits_update((XXH3_state_t *)h->state, bytes, size);
}

void ibl_hash_end(const ibl_hash *h, char text[IBL_FILE_HASH])
{
    const XXH128_hash_t x = XXH3_128bits_digest((const XXH3_state_t *)h->state);

    snprintf(text, IBL_FILE_HASH, "%016llx%016llx",
             (unsigned long long)x.high64, (unsigned long long)x.low64);
}

void ibl_hash_bytes(const void *bytes, size_t size, char text[IBL_FILE_HASH])
{
    ibl_hash h;

    ibl_hash_begin(&h);
    ibl_hash_add(&h, bytes, size);
    ibl_hash_end(&h, text);
}

int ibl_hash_file(const char *path, char text[IBL_FILE_HASH])
{
    unsigned char buffer[1 << 15]; /* fits in the L1 cache */
    struct stat st;
    ssize_t got = -1;
    ibl_hash h;
    const int fd = ibl_port_open(path);

    ibl_hash_begin(&h);
    if (fd >= 0 && !fstat(fd, &st)) {
        errno = S_ISDIR(st.st_mode) ? EISDIR : EINVAL;
        while (S_ISREG(st.st_mode) &&
               ((got = read(fd, buffer, sizeof buffer)) > 0 ||
                (got < 0 && errno == EINTR)))
            ibl_hash_add(&h, buffer, got > 0 ? (size_t)got : 0);
    }
    const int why = errno;
    ibl_hash_end(&h, text);
    if (fd >= 0)
        close(fd);
    return got ? why : 0;
}
