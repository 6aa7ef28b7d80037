/* SPDX-License-Identifier: MIT */
#include "core/alloc.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum {
    ALIGNMENT = 64
};

void *ibl_alloc_array(size_t n, size_t size)
{
    if (size && n > (SIZE_MAX / 2 - ALIGNMENT) / size)
        return NULL;
    size_t bytes = n * size;
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
