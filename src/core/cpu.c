/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "core/cpu.h"

#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#if IBL_X86
#include <cpuid.h>
#endif

#if IBL_X86
/* Not every compiler's __builtin_cpu_supports knows "f16c"; its registers are
 * AVX's, which that function has checked the system for. */
static bool has_f16c(void)
{
    unsigned eax, ebx, ecx, edx;
    return __get_cpuid(1, &eax, &ebx, &ecx, &edx) && (ecx & bit_F16C);
}
#endif

bool ibl_cpu_has(ibl_isa isa)
{
#if IBL_X86
    __builtin_cpu_init();
    switch (isa) {
    case IBL_ISA_SSE2:
        return true;
    case IBL_ISA_AVX2:
        return __builtin_cpu_supports("avx2") &&
               __builtin_cpu_supports("fma") && has_f16c();
    case IBL_ISA_AVX512:
        return ibl_cpu_has(IBL_ISA_AVX2) && __builtin_cpu_supports("avx512f") &&
               __builtin_cpu_supports("avx512bw") &&
               __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512vl");
    default:
        break;
    }
#endif
    return isa == IBL_ISA_C;
}

ibl_isa ibl_isa_best(void)
{
    ibl_isa best = IBL_ISA_C;
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
        if (ibl_cpu_has(isa))
            best = isa;
    }
    return best;
}

const char *ibl_isa_name(ibl_isa isa)
{
    static const char *const names[] = {"auto", "c", "sse2", "avx2", "avx512"};
    const size_t i = (size_t)isa;
    return i < sizeof names / sizeof names[0] ? names[i] : "unknown";
}

/* CPUs that a cgroup (version 2) with this cpu.max allows; 0: no limit. */
static int quota_of(const char *path)
{
    FILE *f = fopen(path, "r");
    if (!f)
        return 0;
    long long quota = 0, period = 0;
    const int n = fscanf(f, "%lld %lld", &quota, &period);
    fclose(f);
    if (n != 2 || quota <= 0 || period <= 0)
        return 0;
    return (int)((quota + period - 1) / period);
}

/* The tightest quota from this process's cgroup up to the root. */
static int cgroup_quota(void)
{
    char line[3072], path[4096];
    FILE *f = fopen("/proc/self/cgroup", "r");
    if (!f)
        return 0;
    char *group = NULL;
    while (!group && fgets(line, sizeof line, f)) {
        if (!strncmp(line, "0::", 3))
            group = line + 3;
    }
    fclose(f);
    if (!group)
        return 0;
    group[strcspn(group, "\n")] = '\0';

    int best = 0;
    for (;;) {
        snprintf(path, sizeof path, "/sys/fs/cgroup%s/cpu.max", group);
        const int quota = quota_of(path);
        if (quota && (!best || quota < best))
            best = quota;
        char *slash = strrchr(group, '/');
        if (!slash)
            break;
        *slash = '\0';
    }
    return best;
}

int ibl_cpu_count(void)
{
    int n;
    cpu_set_t set;
    if (!sched_getaffinity(0, sizeof set, &set))
        n = CPU_COUNT(&set);
    else
        n = (int)sysconf(_SC_NPROCESSORS_ONLN);
    const int quota = cgroup_quota();
    if (quota && quota < n)
        n = quota;
    if (n < 1)
        n = 1;
    return n < 1024 ? n : 1024;
}
