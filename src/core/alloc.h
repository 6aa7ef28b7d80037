/* SPDX-License-Identifier: MIT */
#ifndef IBL_CORE_ALLOC_H
#define IBL_CORE_ALLOC_H

#include <stddef.h>

/* Memory for n items of size bytes, 64-byte aligned, contents undefined;
 * ibl_free frees it. NULL if n * size overflows or exceeds the machine's
 * memory, or the system has none left. n * size == 0 gives a pointer, too. */
void *ibl_alloc_array(size_t n, size_t size);
/* The same, zeroed. */
void *ibl_alloc_zeroed(size_t n, size_t size);
/* As ibl_alloc_array, for memory that stays mostly untouched; untouched pages
 * cost nothing. */
void *ibl_alloc_sparse(size_t n, size_t size);
void ibl_free(void *p); /* NULL is allowed */
/* Between the first hold and the last release up to 64 MiB of freed memory are
 * kept for later allocations. */
void ibl_alloc_hold(void);
void ibl_alloc_release(void);

#endif
