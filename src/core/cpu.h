/* SPDX-License-Identifier: MIT */
#ifndef IBL_CORE_CPU_H
#define IBL_CORE_CPU_H

#include <stdbool.h>

#include "ibl/ibl.h"

/* Vector versions are compiled for this target. */
#if defined(__x86_64__)
#define IBL_X86 1
#else
#define IBL_X86 0
#endif

/* Whether isa's instructions may run here; true for IBL_ISA_C. */
bool ibl_cpu_has(ibl_isa isa);

#endif
