/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "core/cpu.h"

#include <fcntl.h>
#include <limits.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* The best set that CPU and system support. All CPUs with AVX2 have F16C. */
ibl_isa ibl_isa_best(void)
{
#if IBL_X86
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")
               ? IBL_ISA_AVX2
               : IBL_ISA_SSE2;
#elif IBL_ARM64
    return IBL_ISA_NEON;
#else
    return IBL_ISA_C;
#endif
}

/* A CPU's sets are in order: each includes those before it. */
int ibl_isa_supported(ibl_isa isa)
{
    const ibl_isa first = IBL_X86 ? IBL_ISA_SSE2 : IBL_ISA_NEON;

    return isa == IBL_ISA_C || (isa >= first && isa <= ibl_isa_best());
}

const char *ibl_isa_name(ibl_isa isa)
{
    static const char *const names[] = {"auto", "c", "sse2", "avx2", "neon"};
    const size_t i = (size_t)isa;
    return i < sizeof names / sizeof names[0] ? names[i] : "unknown";
}

const char *ibl_isa_arithmetic(ibl_isa isa)
{
    return isa == IBL_ISA_AVX2 || isa == IBL_ISA_NEON ? "fused" : "plain";
}

/* Reads a small system file as text; false if it is missing or empty. */
static bool read_text(const char *path, char *text, size_t size)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return false;
    const ssize_t n = read(fd, text, size - 1);
    close(fd);
    text[n > 0 ? n : 0] = '\0';
    return n > 0;
}

enum {
    GROUP_BYTES = 8192,             /* bytes of /proc/self/cgroup */
    PATH_BYTES = GROUP_BYTES + 4096 /* bytes of the path of a group's file */
};

/* A limit of a group; 0: none. */
typedef uint64_t limit_fn(const char *group, bool unified);

/* CPUs that a group allows, rounded up. Version 1 has quota and period in two
 * files, with -1 for no limit; version 2 one, with "max". */
static uint64_t quota_of(const char *group, bool unified)
{
    static const char *const files[2][2] = {
        {"cpu.cfs_quota_us", "cpu.cfs_period_us"}, {"cpu.max"}};
    char path[PATH_BYTES + 32], text[64], both[2 * sizeof text + 2] = "";
    long long quota = 0, period = 0;

    for (int i = 0; i < 2 && files[unified][i]; i++) {
        snprintf(path, sizeof path, "%s/%s", group, files[unified][i]);
        if (!read_text(path, text, sizeof text))
            return 0;
        strcat(strcat(both, text), " ");
    }
    if (sscanf(both, "%lld %lld", &quota, &period) != 2 || quota <= 0 ||
        period <= 0)
        return 0;
    return (uint64_t)((quota + period - 1) / period);
}

/* Bytes that a group allows. No limit is a huge one in version 1, "max" in
 * version 2. */
static uint64_t bytes_of(const char *group, bool unified)
{
    char path[PATH_BYTES + 32], text[64];
    unsigned long long bytes;

    snprintf(path, sizeof path, "%s/memory.%s", group,
             unified ? "max" : "limit_in_bytes");
    return read_text(path, text, sizeof text) &&
                   sscanf(text, "%llu", &bytes) == 1
               ? bytes
               : 0;
}

/* The tighter of two limits; 0 means none. */
static uint64_t tighter(uint64_t a, uint64_t b)
{
    return a && (!b || a < b) ? a : b;
}

/* The tightest limit from a group up to the root of its hierarchy. Shortens
 * group. In a container the parents of its group may be missing. */
static uint64_t limit_up(const char *hierarchy, char *group, bool unified,
                         limit_fn *limit)
{
    char path[PATH_BYTES];
    for (uint64_t best = 0;;) {
        snprintf(path, sizeof path, "%s%s", hierarchy, group);
        best = tighter(limit(path, unified), best);
        char *slash = strrchr(group, '/');
        if (!slash)
            return best;
        *slash = '\0';
    }
}

/* Whether a list such as "cpu,cpuacct" contains a controller. */
static bool has(const char *list, const char *controller)
{
    const size_t length = strlen(controller);
    for (; *list; list += strcspn(list, ","), list += *list == ',')
        if (!strncmp(list, controller, length) &&
            (list[length] == ',' || !list[length]))
            return true;
    return false;
}

/* Lines are NUMBER:CONTROLLERS:GROUP; version 2 has 0 and no controllers. */
static uint64_t find_limit(const char *root, const char *controller,
                           limit_fn *limit)
{
    char text[GROUP_BYTES], path[PATH_BYTES], *rest;
    uint64_t best = 0;

    snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
    if (!read_text(path, text, sizeof text))
        return 0;
    for (char *line = strtok_r(text, "\n", &rest); line;
         line = strtok_r(NULL, "\n", &rest)) {
        char *list = strchr(line, ':');
        char *group = list ? strchr(list + 1, ':') : NULL;
        if (!group)
            continue;
        *group++ = '\0';
        const bool unified = !list[1];
        if (!unified && !has(list + 1, controller))
            continue;
        snprintf(path, sizeof path, "%s/sys/fs/cgroup%s%s", root,
                 unified ? "" : "/", unified ? "" : controller);
        best = tighter(limit_up(path, group, unified, limit), best);
    }
    return best;
}

int ibl_cpu_quota(const char *root)
{
    const uint64_t cpus = find_limit(root, "cpu", quota_of);
    return cpus < INT_MAX ? (int)cpus : INT_MAX;
}

uint64_t ibl_memory_quota(const char *root)
{
    return find_limit(root, "memory", bytes_of);
}

size_t ibl_memory_allowed(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    const uint64_t all =
        pages > 0 && size > 0 ? (uint64_t)pages * (uint64_t)size : 0;
    return (size_t)tighter(all, ibl_memory_quota(""));
}

int ibl_cpu_count(void)
{
    int n;
    cpu_set_t set;
    if (!sched_getaffinity(0, sizeof set, &set))
        n = CPU_COUNT(&set);
    else
        n = (int)sysconf(_SC_NPROCESSORS_ONLN);
    const int quota = ibl_cpu_quota("");
    if (quota && quota < n)
        n = quota;
    if (n < 1)
        n = 1;
    return n < 1024 ? n : 1024;
}
