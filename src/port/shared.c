/* SPDX-License-Identifier: MIT */
/* What all systems share. */
#define _GNU_SOURCE
#include "port/port.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if __has_include(<sys/mman.h>)
#include <sys/mman.h>
#endif

void ibl_port_use_slashes(char *path)
{
#ifdef _WIN32
    while ((path = strchr(path, '\\')))
        *path = '/';
#else
    (void)path;
#endif
}

int ibl_port_open(const char *path)
{
    return open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
}

int ibl_port_create(const char *path)
{
    return open(path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                0666);
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
#ifdef aligned_free
    aligned_free(p);
#else
    free(p);
#endif
}

/* ---- groups, where Linux has files of them ------------------------------- */

/* What a group's file allows: bytes, or quota and period, as CPUs rounded up.
 * 0: "max", or there is no such file, as of a container's parents. */
static uint64_t limit_of(const char *path)
{
    unsigned long long limit, period = 1;
    FILE *file = fopen(path, "r");
    const int read = file ? fscanf(file, "%llu %llu", &limit, &period) : 0;

    if (file)
        fclose(file);
    return read < 1 || !period ? 0 : limit / period + (limit % period != 0);
}

/* The group is that of version 2, in a line "0::GROUP". */
uint64_t ibl_port_quota(const char *root, const char *name)
{
    char group[4096] = "", path[2 * sizeof group];
    uint64_t best = 0;

    snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
    FILE *file = fopen(path, "r");
    while (file && strncmp(group, "0::", 3) != 0)
        if (!fgets(group, sizeof group, file)) {
            fclose(file);
            return 0;
        }
    if (!file)
        return 0;
    fclose(file);
    group[strcspn(group, "\n")] = '\0';
    for (;;) {
        snprintf(path, sizeof path, "%s/sys/fs/cgroup%s/%s", root, group + 3,
                 name);
        const uint64_t limit = limit_of(path);
        if (limit && (!best || limit < best))
            best = limit;
        char *slash = strrchr(group, '/');
        if (!slash)
            return best;
        *slash = '\0';
    }
}
