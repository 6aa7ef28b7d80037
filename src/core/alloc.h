/* SPDX-License-Identifier: MIT */
#ifndef IBL_CORE_ALLOC_H
#define IBL_CORE_ALLOC_H

#include <stddef.h>

/*
 * Memory for n items of size bytes, 64-byte aligned, contents undefined.
 * NULL if n * size overflows or the system has none. n * size == 0 gives a
 * pointer that may be freed. Free with ibl_free.
 */
void *ibl_alloc_array(size_t n, size_t size);
/* The same, zeroed. */
void *ibl_alloc_zeroed(size_t n, size_t size);
void ibl_free(void *p); /* NULL is fine */
/* Returns to the system what is kept of freed memory, 32 MiB at most. */
void ibl_alloc_trim(void);

#endif
