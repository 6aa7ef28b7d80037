/* SPDX-License-Identifier: MIT */
/* To be preloaded: the allocation after NO_MEMORY_AT others fails, once. */
#include <errno.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>

/* What glibc's own are called besides. */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t n, size_t size);
void *__libc_realloc(void *old, size_t size);

static long left = -1;

static bool fails(void)
{
    static bool asked;

    if (!asked) {
        const char *at = getenv("NO_MEMORY_AT");
        asked = true;
        left = at ? atol(at) : -1;
    }
    if (left < 0 || left-- > 0)
        return false;
    errno = ENOMEM;
    return true;
}

void *malloc(size_t size)
{
    return fails() ? NULL : __libc_malloc(size);
}

void *calloc(size_t n, size_t size)
{
    return fails() ? NULL : __libc_calloc(n, size);
}

void *realloc(void *old, size_t size)
{
    return fails() ? NULL : __libc_realloc(old, size);
}
