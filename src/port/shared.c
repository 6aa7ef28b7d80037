/* SPDX-License-Identifier: MIT */
/* What systems of POSIX share with WebAssembly, whose C library has these. */
#define _GNU_SOURCE
#include "port/port.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

int ibl_port_open(const char *path)
{
    return open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
}

int ibl_port_create(const char *path)
{
    return open(path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                0666);
}

ptrdiff_t ibl_port_read_at(int file, void *to, size_t size, uint64_t offset)
{
    return pread(file, to, size, (off_t)offset);
}

bool ibl_port_flush(int file)
{
    while (fsync(file)) {
        if (errno == EINVAL) /* of file systems that cannot flush */
            break;
        if (errno != EINTR)
            return false;
    }
    return true;
}

bool ibl_port_replace(const char *from, const char *to)
{
    return !rename(from, to);
}

bool ibl_port_make_folder(const char *path)
{
    return !mkdir(path, 0777);
}

size_t ibl_port_root(const char *path)
{
    return *path == '/';
}

static int64_t nanoseconds(struct timespec t)
{
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static bool identify(int failed, const struct stat *st, ibl_port_file *file)
{
    *file = (ibl_port_file){0};
    if (!failed)
        *file = (ibl_port_file){.device = (uint64_t)st->st_dev,
                                .number = (uint64_t)st->st_ino,
                                .size = (uint64_t)st->st_size,
                                .written = nanoseconds(st->st_mtim),
                                .changed = nanoseconds(st->st_ctim)};
    return !failed;
}

bool ibl_port_identify(const char *path, ibl_port_file *file)
{
    struct stat st;
    return identify(stat(path, &st), &st, file);
}

bool ibl_port_identify_folder(int folder, ibl_port_file *file)
{
    struct stat st;
    return identify(fstat(folder, &st), &st, file);
}

bool ibl_port_is_link(const char *path)
{
    struct stat st;
    return !lstat(path, &st) && S_ISLNK(st.st_mode);
}

bool ibl_port_resolve(const char *path, char real[IBL_PORT_PATH])
{
    return realpath(path, real);
}

void *ibl_port_alloc(size_t alignment, size_t bytes)
{
    void *p = aligned_alloc(alignment, bytes);
#ifdef MADV_HUGEPAGE
    if (p && alignment >= IBL_PORT_HUGE)
        madvise(p, bytes, MADV_HUGEPAGE); /* failure does no harm */
#endif
    return p;
}

void ibl_port_free(void *p)
{
    free(p);
}
