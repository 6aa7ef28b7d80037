/* SPDX-License-Identifier: MIT */
/*
 * A kernel is a table of functions, ibl_name_dsp. kern/NAME_simd.c has them on
 * the vectors of lanes.h and ends with IBL_VECTOR_KERNEL; the Makefile compiles
 * it once for each instruction set, with its options and with IBL_SUFFIX
 * defined, and once with IBL_PLAIN defined, for every CPU. Only if kern/NAME.c
 * ends with IBL_KERNEL, that is the plain version instead.
 * CONTRIBUTING.md lists what a new instruction set needs.
 */
#ifndef IBL_KERN_ISA_H
#define IBL_KERN_ISA_H

#include "core/cpu.h"

/* Declares name_dsp_init, which fills the table for an instruction set (not
 * IBL_ISA_AUTO), and the functions it calls. */
#define IBL_DECLARE_KERNEL(name)                                               \
    void name##_dsp_init(name##_dsp *dsp, ibl_isa isa);                        \
    void name##_init_sse2(name##_dsp *dsp);                                    \
    void name##_init_avx2(name##_dsp *dsp);                                    \
    void name##_init_neon(name##_dsp *dsp)

/* Replaces the plain functions of a table by those for isa. */
#if IBL_X86
#define IBL_INIT_VECTORS(name, dsp, isa)                                       \
    if ((isa) >= IBL_ISA_AVX2)                                                 \
        name##_init_avx2(dsp);                                                 \
    else if ((isa) >= IBL_ISA_SSE2)                                            \
    name##_init_sse2(dsp)
#elif IBL_ARM64
#define IBL_INIT_VECTORS(name, dsp, isa)                                       \
    if ((isa) == IBL_ISA_NEON)                                                 \
    name##_init_neon(dsp)
#else
#define IBL_INIT_VECTORS(name, dsp, isa) ((void)(isa))
#endif

/* Defines name_dsp_init; plain functions are in the order of the table. */
#define IBL_KERNEL(name, ...)                                                  \
    void name##_dsp_init(name##_dsp *dsp, ibl_isa isa)                         \
    {                                                                          \
        *dsp = (name##_dsp){__VA_ARGS__};                                      \
        IBL_INIT_VECTORS(name, dsp, isa);                                      \
    }

/* Defines name_init for the instruction set being compiled. */
#ifdef IBL_PLAIN
#define IBL_VECTOR_KERNEL IBL_KERNEL
#else
#define IBL_VECTOR_KERNEL(name, ...)                                           \
    void IBL_FOR_ISA(name##_init)(name##_dsp * dsp)                            \
    {                                                                          \
        *dsp = (name##_dsp){__VA_ARGS__};                                      \
    }
#endif

/* IBL_FOR_ISA(ibl_name_init) is ibl_name_init_avx2, for example. */
#define IBL_JOIN(name, suffix) name##suffix
#define IBL_JOIN_VALUES(name, suffix) IBL_JOIN(name, suffix)
#define IBL_FOR_ISA(name) IBL_JOIN_VALUES(name, IBL_SUFFIX)

#endif
