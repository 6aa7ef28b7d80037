/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/alloc.h"
#include "io/container.h"

static ibl_status failed(ibl_ctx *ctx, const char *path, const char *what)
{
    return ibl_fail(ctx, IBL_ERR_IO, "%s: %s: %s", path, what, strerror(errno));
}

/* Reads until size bytes are there or the file ends. */
static ibl_status read_all(ibl_ctx *ctx, const char *path, int fd,
                           unsigned char *bytes, size_t size, size_t *got)
{
    enum {
        CHUNK = 1 << 22 /* after each, a look whether to stop */
    };
    *got = 0;
    while (*got < size) {
        const size_t left = size - *got;
        const ssize_t n = read(fd, bytes + *got, left < CHUNK ? left : CHUNK);
        if (ibl_cancelled(ctx))
            return IBL_ERR_CANCELLED;
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return failed(ctx, path, "cannot be read");
        if (n == 0)
            break;
        *got += (size_t)n;
    }
    return IBL_OK;
}

ibl_status ibl_texture_read(ibl_ctx *ctx, const char *path, ibl_texture *tex,
                            ibl_container *container)
{
    unsigned char *bytes = NULL;
    struct stat st;
    ibl_status status;
    size_t got = 0;

    *tex = (ibl_texture){0};
    /* Not blocking, for a FIFO would. */
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return failed(ctx, path, "cannot be opened");
    if (fstat(fd, &st)) {
        status = failed(ctx, path, "cannot be read");
        goto done;
    }
    if (!S_ISREG(st.st_mode)) {
        status = ibl_fail(ctx, IBL_ERR_IO, "%s: is %s, a file is needed", path,
                          S_ISDIR(st.st_mode) ? "a directory" : "no file");
        goto done;
    }
    bytes = ibl_alloc_array((size_t)st.st_size, 1);
    if (!bytes) {
        status = ibl_no_memory(ctx, path);
        goto done;
    }
    status = read_all(ctx, path, fd, bytes, (size_t)st.st_size, &got);
    if (!status)
        status = ibl_texture_decode(ctx, path, bytes, got, tex, container);

done:
    close(fd);
    ibl_free(bytes);
    return status;
}
