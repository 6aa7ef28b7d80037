/* SPDX-License-Identifier: MIT */
/* POSIX on Windows, where its C library lacks it or does something else; read
 * before each file. */
#ifndef IBL_PORT_WINDOWS_H
#define IBL_PORT_WINDOWS_H

#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <malloc.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <time.h>

#define O_NOCTTY 0
#define O_NOFOLLOW 0
#define O_NONBLOCK 0
#define O_CLOEXEC 0
#define open ibl_open /* folders, too; what is open can be removed */
int open(const char *path, int flags, ...);

struct ibl_stat { /* with numbers of files */
    unsigned st_mode;
    uint64_t st_dev, st_ino;
    int64_t st_size;
    struct timespec st_mtim, st_ctim;
};
#undef stat
#undef fstat
#define stat ibl_stat
#define fstat ibl_fstat
#define S_IFLNK 0xa000
#define S_ISLNK(mode) (((mode)&S_IFMT) == S_IFLNK)
int stat(const char *path, struct stat *st);
int lstat(const char *path, struct stat *st);
int fstat(int file, struct stat *st);

#define rename ibl_rename /* replaces */
int rename(const char *from, const char *to);
#define mkdir(path, ...) _mkdir(path)
int _mkdir(const char *path);
#define fsync _commit
#define realpath(path, real) (errno = ENOSYS, (char *)NULL)
ssize_t pread(int file, void *to, size_t size, off_t offset);

#define aligned_alloc(alignment, bytes) _aligned_malloc(bytes, alignment)
#define aligned_free _aligned_free
void *memmem(const void *bytes, size_t size, const void *part, size_t length);

#endif
