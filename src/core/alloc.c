/* SPDX-License-Identifier: MIT */
#define _DEFAULT_SOURCE
#include "core/alloc.h"

#include <malloc.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "ibl/ibl.h"

enum {
    ALIGNMENT = 64,
    HUGE_PAGE = 1 << 21, /* bytes; on x86-64 and on arm64 with pages of 4 KiB */
    HUGE_FROM = HUGE_PAGE / 4,
    KEPT_FROM = HUGE_PAGE / 8 /* smaller requests get no kept block */
};

/* Most bytes of kept blocks; 0 with sanitizers, which check each block. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define KEPT_BYTES 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define KEPT_BYTES 0
#endif
#endif
#ifndef KEPT_BYTES
#define KEPT_BYTES ((size_t)32 << 20)
#endif

/*
 * Large memory is allocated in huge pages. The first touch of a page costs
 * about the same for any page size, and makes most of the cost of short-lived
 * buffers: measured 0.4 ms per MiB with 4 KiB pages, 0.05 ms with huge pages.
 * Rounding up wastes at most 1.5 MiB per block; without huge pages the waste is
 * never touched.
 *
 * Some freed blocks are kept for reuse, since a bake allocates one after the
 * other: without this a bake of a 1k map takes 7 % longer. Allocations do not
 * know their context, so contexts share the kept blocks; the last frees them.
 */
typedef struct block {
    struct block *next;
    size_t bytes;
} block; /* header at the start of a kept block */

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static block *kept; /* guarded by lock, as the next two */
static size_t kept_bytes;
static int holders;        /* number of contexts */
static ibl_allocator hook; /* a program's, if it has functions; changes only
                              without contexts */

ibl_status ibl_set_allocator(const ibl_allocator *allocator)
{
    if (allocator && (!allocator->alloc || !allocator->release))
        return IBL_ERR_ARGUMENT;
    pthread_mutex_lock(&lock);
    const bool used = holders;
    if (!used)
        hook = allocator ? *allocator : (ibl_allocator){NULL, NULL, NULL};
    pthread_mutex_unlock(&lock);
    return used ? IBL_ERR_ARGUMENT : IBL_OK;
}

/* Takes the smallest kept block of bytes..most bytes; NULL: none. */
static void *take_kept(size_t bytes, size_t most)
{
    block **best = NULL, *at = NULL;

    pthread_mutex_lock(&lock);
    for (block **b = &kept; *b; b = &(*b)->next)
        if ((*b)->bytes >= bytes && (*b)->bytes <= most &&
            (!best || (*b)->bytes < (*best)->bytes))
            best = b;
    if (best) {
        at = *best;
        *best = at->next;
        kept_bytes -= at->bytes;
    }
    pthread_mutex_unlock(&lock);
    return at;
}

/* Keeps a block for reuse if possible; false: the caller must free it. The
 * block has the alignment of alloc_huge. */
static bool keep(void *at)
{
    const size_t bytes = malloc_usable_size(at) / HUGE_PAGE * HUGE_PAGE;

    pthread_mutex_lock(&lock);
    const bool stays = bytes && holders && bytes <= KEPT_BYTES - kept_bytes;
    if (stays) {
        *(block *)at = (block){kept, bytes};
        kept = at;
        kept_bytes += bytes;
    }
    pthread_mutex_unlock(&lock);
    return stays;
}

/* Returns the kept blocks to the system. The caller holds the lock. */
static void trim(void)
{
    while (kept) {
        block *b = kept;
        kept = b->next;
        free(b);
    }
    kept_bytes = 0;
}

void ibl_alloc_hold(void)
{
    pthread_mutex_lock(&lock);
    holders++;
    pthread_mutex_unlock(&lock);
}

void ibl_alloc_release(void)
{
    pthread_mutex_lock(&lock);
    if (!--holders)
        trim();
    pthread_mutex_unlock(&lock);
}

/* Bytes of physical memory. */
static size_t physical(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    return pages > 0 && size > 0 ? (size_t)pages * (size_t)size : SIZE_MAX;
}

static void *alloc_huge(size_t bytes)
{
    bytes = (bytes + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
    /* An overcommitting system might allocate it and kill the program later. */
    if (bytes > physical())
        return NULL;
    void *p = take_kept(bytes, 2 * bytes);
    if (p)
        return p;
    p = aligned_alloc(HUGE_PAGE, bytes);
    if (!p) {
        pthread_mutex_lock(&lock);
        trim();
        pthread_mutex_unlock(&lock);
        p = aligned_alloc(HUGE_PAGE, bytes);
    }
    if (!p)
        return NULL;
#ifdef MADV_HUGEPAGE
    madvise(p, bytes, MADV_HUGEPAGE); /* failure does no harm */
#endif
    return p;
}

/* Memory from the program or the C library, without huge pages. */
static void *alloc_plain(size_t bytes)
{
    if (!bytes)
        bytes = 1;
    if (hook.alloc)
        return hook.alloc(hook.cookie, bytes, ALIGNMENT);
    bytes = (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    return aligned_alloc(ALIGNMENT, bytes);
}

static bool fits(size_t n, size_t size)
{
    return !size || n <= (SIZE_MAX / 4 - HUGE_PAGE) / size;
}

void *ibl_alloc_array(size_t n, size_t size)
{
    if (!fits(n, size))
        return NULL;
    size_t bytes = n * size;
    if (hook.alloc)
        return alloc_plain(bytes);
    if (bytes >= HUGE_FROM)
        return alloc_huge(bytes);
    void *p = bytes >= KEPT_FROM ? take_kept(bytes, 2 * HUGE_PAGE) : NULL;
    if (p)
        return p;
    return alloc_plain(bytes);
}

void *ibl_alloc_sparse(size_t n, size_t size)
{
    return fits(n, size) ? alloc_plain(n * size) : NULL;
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
    if (p && hook.release)
        hook.release(hook.cookie, p);
    else if ((uintptr_t)p % HUGE_PAGE || !p || !keep(p))
        free(p);
}
