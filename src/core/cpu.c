/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "core/cpu.h"

#include <fcntl.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#if IBL_X86
#include <cpuid.h>
#endif

/* The best set that CPU and system have. The instruction that tells costs
 * some microseconds under a hypervisor, so it is asked as little as may be. */
static ibl_isa find_best(void)
{
#if IBL_X86
    enum {
        LEAF_1 = bit_OSXSAVE | bit_AVX | bit_FMA | bit_F16C,
        SAVED_AVX = 0x06, /* registers that the system keeps, of XCR0 */
        SAVED_AVX512 = 0xE6
    };
    const unsigned leaf_7 =
        bit_AVX512F | bit_AVX512BW | bit_AVX512DQ | bit_AVX512VL;
    unsigned top, eax, ebx, ecx, edx, saved, high;

    __cpuid(0, top, ebx, ecx, edx);
    if (top < 7)
        return IBL_ISA_SSE2;
    __cpuid(1, eax, ebx, ecx, edx);
    if ((ecx & LEAF_1) != LEAF_1)
        return IBL_ISA_SSE2;
    __asm__ volatile("xgetbv" : "=a"(saved), "=d"(high) : "c"(0));
    __cpuid_count(7, 0, eax, ebx, ecx, edx);
    if ((saved & SAVED_AVX) != SAVED_AVX || !(ebx & bit_AVX2))
        return IBL_ISA_SSE2;
    return (saved & SAVED_AVX512) == SAVED_AVX512 && (ebx & leaf_7) == leaf_7
               ? IBL_ISA_AVX512
               : IBL_ISA_AVX2;
#else
    return IBL_ISA_C;
#endif
}

ibl_isa ibl_isa_best(void)
{
    static atomic_int best; /* IBL_ISA_AUTO: not yet known */
    int isa = atomic_load(&best);
    if (isa == IBL_ISA_AUTO) {
        isa = (int)find_best();
        atomic_store(&best, isa);
    }
    return (ibl_isa)isa;
}

/* Each set includes those before it. */
bool ibl_cpu_has(ibl_isa isa)
{
    return isa >= IBL_ISA_C && isa <= ibl_isa_best();
}

const char *ibl_isa_name(ibl_isa isa)
{
    static const char *const names[] = {"auto", "c", "sse2", "avx2", "avx512"};
    const size_t i = (size_t)isa;
    return i < sizeof names / sizeof names[0] ? names[i] : "unknown";
}

/* What one read of a system's file gives, as text; false if it is not there. */
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

/* CPUs that a cgroup (version 2) with this cpu.max allows; 0: no limit. */
static int quota_of(const char *path)
{
    char text[64];
    long long quota = 0, period = 0;
    if (!read_text(path, text, sizeof text))
        return 0;
    const int n = sscanf(text, "%lld %lld", &quota, &period);
    if (n != 2 || quota <= 0 || period <= 0)
        return 0;
    return (int)((quota + period - 1) / period);
}

/* The tightest quota from this process's cgroup up to the root. */
static int cgroup_quota(void)
{
    char text[8192], path[8192 + 64];
    text[0] = '\n';
    if (!read_text("/proc/self/cgroup", text + 1, sizeof text - 1))
        return 0;
    char *group = strstr(text, "\n0::"); /* the line of version 2 */
    if (!group)
        return 0;
    group += 4;
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
