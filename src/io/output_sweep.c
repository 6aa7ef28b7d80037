/* SPDX-License-Identifier: MIT */
/* Temporaries of sets of outputs whose process was killed. */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "ibl/io.h"

/* Whether a name is that of a temporary (outputs.c), and of which process. */
static bool is_temporary(const char *name, long *pid)
{
    static const char mark[] = ".iblbake-";
    const char *last = NULL;
    unsigned serial;
    int end = 0;

    for (const char *at = name; (at = strstr(at, mark)); at++)
        last = at;
    return name[0] == '.' && last && last > name &&
           sscanf(last + sizeof mark - 1, "%ld-%u.tmp%n", pid, &serial, &end) ==
               2 &&
           end && !last[sizeof mark - 1 + (size_t)end] && *pid > 0;
}

/* A process of another machine or container seems dead; it has a lock. */
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
