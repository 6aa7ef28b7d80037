/* SPDX-License-Identifier: MIT */
/*
 * Names of temporaries, and the removal of those whose process was killed. A
 * name has the host of its process: on a file system that several machines
 * share, processes of the others look dead.
 */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "ibl/io.h"
#include "io/temporary.h"

enum {
    KEPT_NAME_BYTES = 128 /* most of the target's name in a temporary's */
};

static const char mark[] = ".iblbake-";

/* A hash of this host's name, FNV-1a of 32 bits. */
static unsigned host(void)
{
    struct utsname system;
    uint32_t hash = 2166136261u;

    if (!uname(&system))
        for (const char *c = system.nodename; *c; c++)
            hash = (hash ^ (unsigned char)*c) * 16777619u;
    return hash;
}

void ibl_temporary_name(char *to, size_t bytes, const char *name,
                        unsigned serial)
{
    snprintf(to, bytes, ".%.*s%s%08x-%ld-%u.tmp", KEPT_NAME_BYTES, name, mark,
             host(), (long)getpid(), serial);
}

/* Whether a name is that of a temporary of this host, and of which process. */
static bool is_temporary(const char *name, long *pid)
{
    const char *last = NULL;
    unsigned made_by, serial;
    int end = 0;

    for (const char *at = name; (at = strstr(at, mark)); at++)
        last = at;
    return name[0] == '.' && last && last > name &&
           sscanf(last + sizeof mark - 1, "%8x-%ld-%u.tmp%n", &made_by, pid,
                  &serial, &end) == 3 &&
           end && !last[sizeof mark - 1 + (size_t)end] && made_by == host() &&
           *pid > 0;
}

/* A process of another container may seem dead; it has a lock. */
static bool is_dead(long pid)
{
    return kill((pid_t)pid, 0) && errno == ESRCH;
}

void ibl_outputs_sweep(int directory)
{
    const int fd = openat(directory, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *dir = fd < 0 ? NULL : fdopendir(fd);
    const struct dirent *d;
    long pid;

    while (dir && (d = readdir(dir)))
        if (is_temporary(d->d_name, &pid) && is_dead(pid))
            unlinkat(directory, d->d_name, 0);
    if (dir)
        closedir(dir);
    else if (fd >= 0)
        close(fd);
}
