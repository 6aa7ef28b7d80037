/* SPDX-License-Identifier: MIT */
/*
 * One kernel for several instruction sets. The Makefile compiles each
 * kern/NAME_simd.c once for each set, with its options and with IBL_SUFFIX
 * defined: IBL_FOR_ISA(ibl_name_init) is ibl_name_init_avx2 in one of them.
 * That function fills in the kernel's table, ibl_name_dsp.
 */
#ifndef IBL_KERN_ISA_H
#define IBL_KERN_ISA_H

#include "core/cpu.h"

#define IBL_JOIN(name, suffix) name##suffix
#define IBL_JOIN_VALUES(name, suffix) IBL_JOIN(name, suffix)
#define IBL_FOR_ISA(name) IBL_JOIN_VALUES(name, IBL_SUFFIX)

/* Declares what fills in the table of a kernel. */
#define IBL_DECLARE_INIT(name)                                                 \
    void name##_init_sse2(name##_dsp *dsp);                                    \
    void name##_init_avx2(name##_dsp *dsp);                                    \
    void name##_init_avx512(name##_dsp *dsp)

/* Replaces the plain versions in a kernel's table by those that isa allows. */
#if IBL_X86
#define IBL_INIT(name, dsp, isa)                                               \
    do {                                                                       \
        if ((isa) >= IBL_ISA_AVX512)                                           \
            name##_init_avx512(dsp);                                           \
        else if ((isa) >= IBL_ISA_AVX2)                                        \
            name##_init_avx2(dsp);                                             \
        else if ((isa) >= IBL_ISA_SSE2)                                        \
            name##_init_sse2(dsp);                                             \
    } while (0)
#else
#define IBL_INIT(name, dsp, isa) ((void)(isa))
#endif

#endif
