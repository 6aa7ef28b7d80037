/* SPDX-License-Identifier: MIT */
#include "core/cpu.h"

#include "port/port.h"

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

size_t ibl_memory_allowed(void)
{
    return (size_t)tighter(ibl_port_memory(), ibl_port_quota("", "memory.max"));
}

int ibl_cpu_count(void)
{
    const uint64_t cpus = (uint64_t)ibl_port_cpus();
    const int n = (int)tighter(cpus, ibl_port_quota("", "cpu.max"));

    return n < 1 ? 1 : n < 1024 ? n : 1024;
}
