/* SPDX-License-Identifier: MIT */
#ifndef IBL_CORE_ALLOC_H
#define IBL_CORE_ALLOC_H

#include <stddef.h>

/*
 * Memory for n items of size bytes, 64-byte aligned, contents undefined.
 * NULL if n * size overflows, is more than the machine has in all, or the
 * system has none. n * size == 0 gives a pointer that may be freed. Free with
 * ibl_free.
 */
void *ibl_alloc_array(size_t n, size_t size);
/* The same, zeroed. */
void *ibl_alloc_zeroed(size_t n, size_t size);
/* The same as the first, for what will mostly stay untouched: that takes no
 * memory. */
void *ibl_alloc_sparse(size_t n, size_t size);
void ibl_free(void *p); /* NULL is fine */
/* Between the first hold and its release 32 MiB at most of freed memory are
 * kept for the next who asks; the last release returns them to the system. */
void ibl_alloc_hold(void);
void ibl_alloc_release(void);

#endif
