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

/* CPUs that the cgroups of this process allow, of version 1 or 2, rounded up;
 * 0: no limit. root is "" but for tests, which have a system of their own. */
int ibl_cpu_quota(const char *root);

#endif
