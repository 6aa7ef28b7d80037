/* SPDX-License-Identifier: MIT */
#ifndef IBL_CORE_CPU_H
#define IBL_CORE_CPU_H

#include <stdbool.h>
#include <stdint.h>

#include "ibl/ibl.h"

/* The CPUs that have vector versions; lanes.h takes little-endian ones. */
#if defined(__x86_64__)
#define IBL_X86 1
#define IBL_ARM64 0
#elif defined(__aarch64__)
#define IBL_X86 0
#define IBL_ARM64 1
#else
#define IBL_X86 0
#define IBL_ARM64 0
#endif

#endif
