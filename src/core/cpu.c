/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "core/cpu.h"

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

/* The tighter of two limits; 0 means none. */
static uint64_t tighter(uint64_t a, uint64_t b)
{
    return a && (!b || a < b) ? a : b;
}

/* What a group's file allows: bytes, or quota and period, as CPUs rounded up.
 * 0: "max", or there is no such file, as of a container's parents. */
static uint64_t limit_of(const char *path)
{
    unsigned long long limit, period = 1;
    FILE *file = fopen(path, "re");
    const int read = file ? fscanf(file, "%llu %llu", &limit, &period) : 0;

    if (file)
        fclose(file);
    return read < 1 || !period ? 0 : limit / period + (limit % period != 0);
}

/* The tightest limit from this process's group up to the root. The group is
 * that of version 2, in a line "0::GROUP". */
static uint64_t find_limit(const char *root, const char *name)
{
    char group[4096] = "", path[2 * sizeof group];
    uint64_t best = 0;

    snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
    FILE *file = fopen(path, "re");
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
        best = tighter(limit_of(path), best);
        char *slash = strrchr(group, '/');
        if (!slash)
            return best;
        *slash = '\0';
    }
}

int ibl_cpu_quota(const char *root)
{
    const uint64_t cpus = find_limit(root, "cpu.max");
    return cpus < INT_MAX ? (int)cpus : INT_MAX;
}

uint64_t ibl_memory_quota(const char *root)
{
    return find_limit(root, "memory.max");
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
