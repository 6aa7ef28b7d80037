/* SPDX-License-Identifier: MIT */
#define _DEFAULT_SOURCE
#include "core/alloc.h"

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
    PAGE = 1 << 16,      /* whole pages on every system */
    HUGE_PAGE = 1 << 21, /* on x86-64 and on arm64 with pages of 4 KiB */
    FROM = 1 << 17,      /* bytes of the smallest block in the heap */
    UP_TO = 1 << 25,     /* and of the largest */
    HEAP = 1 << 28,
    KEPT = 1 << 25, /* most bytes of a gap that are kept */
    BLOCKS = 500
};

/* Sanitizers are to see each block. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define HAS_HEAP false
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define HAS_HEAP false
#endif
#endif
#ifndef HAS_HEAP
#define HAS_HEAP true
#endif

/*
 * Large blocks lie in a heap of huge pages, each in the smallest gap that it
 * fits in. The first touch of a page costs about the same for any size of page,
 * and is most of the cost of short-lived buffers: measured .4 ms for each MiB
 * in pages of 4 KiB, .05 in huge ones. A stage of a bake begins with what the
 * one before it freed, so a process grows to what it needs at once. Blocks know
 * no context, so contexts share the heap; without any, what is free in it goes
 * back to the system.
 */
typedef struct block {
    size_t at, end;
} block;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static char *heap;           /* NULL: not yet. Guarded by lock, as the rest */
static block blocks[BLOCKS]; /* in the heap, by place */
static int count;
static size_t touched;     /* behind it the heap takes no memory */
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

/* Reserves addresses for the heap. */
static bool make_heap(void)
{
    char *p = mmap(NULL, HEAP + HUGE_PAGE, PROT_READ | PROT_WRITE,
                   MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (p == MAP_FAILED)
        return false;
    const size_t skip = -(uintptr_t)p % HUGE_PAGE;
    if (skip)
        munmap(p, skip);
    munmap(p + skip + HEAP, HUGE_PAGE - skip);
    heap = p + skip;
#ifdef MADV_HUGEPAGE
    madvise(heap, HEAP, MADV_HUGEPAGE); /* failure does no harm */
#endif
    return true;
}

/* Where gap i begins, before block i or behind the last. */
static size_t gap(int i)
{
    return i ? blocks[i - 1].end : 0;
}

static void *take(size_t bytes)
{
    int best = count;

    bytes = (bytes + PAGE - 1) / PAGE * PAGE;
    if (count == BLOCKS || (!heap && !make_heap()))
        return NULL;
    for (int i = 0; i < count; i++) {
        const size_t room = blocks[i].at - gap(i);
        if (room >= bytes &&
            (best == count || room < blocks[best].at - gap(best)))
            best = i;
    }
    const block b = {gap(best), gap(best) + bytes};
    if (b.end > HEAP)
        return NULL;
    memmove(&blocks[best + 1], &blocks[best],
            (size_t)(count++ - best) * sizeof *blocks);
    blocks[best] = b;
    touched = b.end > touched ? b.end : touched;
    return heap + b.at;
}

/* Returns to the system what is free in the heap, but for the beginning of each
 * gap while there is a context. */
static void trim(void)
{
    const size_t kept = holders ? KEPT : 0;

    for (int i = 0; i <= count; i++) {
        const size_t at = gap(i) + kept;
        const size_t end = i < count ? blocks[i].at : touched;
        if (at < end)
            madvise(heap + at, end - at, MADV_DONTNEED);
    }
    if (touched > gap(count) + kept)
        touched = gap(count) + kept;
    if (heap && !count && !holders) {
        munmap(heap, HEAP);
        heap = NULL;
    }
}

/* False: it is not in the heap. */
static bool release(const char *p)
{
    pthread_mutex_lock(&lock);
    const bool inside = heap && p >= heap && p < heap + HEAP;
    int i = 0;
    while (inside && heap + blocks[i].at != p)
        i++;
    if (inside) {
        memmove(&blocks[i], &blocks[i + 1],
                (size_t)(--count - i) * sizeof *blocks);
        trim();
    }
    pthread_mutex_unlock(&lock);
    return inside;
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
    holders--;
    trim();
    pthread_mutex_unlock(&lock);
}

/* Bytes of physical memory. */
static size_t physical(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    return pages > 0 && size > 0 ? (size_t)pages * (size_t)size : SIZE_MAX;
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
    const size_t bytes = n * size, pages = ((bytes - 1) | (HUGE_PAGE - 1)) + 1;
    void *p = NULL;
    if (bytes < FROM || hook.alloc)
        return alloc_plain(bytes);
    pthread_mutex_lock(&lock);
    if (HAS_HEAP && bytes <= UP_TO)
        p = take(bytes);
    pthread_mutex_unlock(&lock);
    /* An overcommitting system might allocate it and kill the program later. */
    if (p || bytes > physical())
        return p;
    if (!HAS_HEAP)
        return alloc_plain(bytes);
    p = aligned_alloc(HUGE_PAGE, pages);
#ifdef MADV_HUGEPAGE
    if (p)
        madvise(p, pages, MADV_HUGEPAGE); /* failure does no harm */
#endif
    return p;
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
    else if (!p || (uintptr_t)p % PAGE || !release(p))
        free(p);
}
