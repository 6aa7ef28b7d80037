/* SPDX-License-Identifier: MIT */
/* To be preloaded: SIGTERM comes as the first temporary is to be removed. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

int unlink(const char *path)
{
    static bool sent;

    if (!sent && strstr(path, ".iblbake-")) {
        sent = true;
        raise(SIGTERM);
    }
    return (int)syscall(SYS_unlinkat, AT_FDCWD, path, 0);
}
