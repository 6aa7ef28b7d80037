/* SPDX-License-Identifier: MIT */
#ifndef IBL_CORE_ALLOC_H
#define IBL_CORE_ALLOC_H

#include <stddef.h>

/* Memory for n items of size bytes, 64-byte aligned, contents undefined; free
 * with ibl_free. NULL if n * size overflows or exceeds the machine's memory, or
 * the system has none. n * size == 0 gives a pointer that may be freed. */
void *ibl_alloc_array(size_t n, size_t size);
/* The same, zeroed. */
void *ibl_alloc_zeroed(size_t n, size_t size);
/* As ibl_alloc_array, for memory that stays mostly untouched, which costs
 * nothing. */
void *ibl_alloc_sparse(size_t n, size_t size);
void ibl_free(void *p); /* NULL is fine */
/* Between the first hold and the last release up to 32 MiB of freed memory are
 * kept for later allocations. */
void ibl_alloc_hold(void);
void ibl_alloc_release(void);

#endif
