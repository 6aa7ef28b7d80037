/* SPDX-License-Identifier: MIT */
#include "core/alloc.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "ibl/ibl.h"
#include "port/port.h"

enum {
    ALIGNMENT = 64,
    PAGE = 1 << 16, /* whole pages on every system */
    FROM = 1 << 17, /* bytes of the smallest block in the heap */
    HEAP = 1 << 26,
    BLOCKS = HEAP / FROM
};

/* Sanitizers are to see each block. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#elif defined(__has_feature)
#define SANITIZED                                                              \
    (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define SANITIZED 0
#endif

/*
 * Large blocks lie in a heap of huge pages, each in the smallest gap that it
 * fits in. The first touch of a page costs about the same for any size of page,
 * and is most of the cost of short-lived buffers: a bake of a 1k map takes 1.6
 * times as long without the heap. A stage of a bake begins with what the one
 * before it freed, so a process grows to what it needs at once. Blocks know no
 * context, so contexts share the heap; without any it goes back to the system
 * with its last block.
 */
typedef struct block {
    size_t at, end;
} block;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static char *heap;           /* NULL: not yet. Guarded by lock, as the rest */
static block blocks[BLOCKS]; /* in the heap, by place */
static int count;
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

static void *take_huge(size_t bytes)
{
    return ibl_port_alloc(IBL_PORT_HUGE,
                          ((bytes - 1) | (IBL_PORT_HUGE - 1)) + 1);
}

/* A block of the heap; NULL: it has no room. */
static void *take(size_t bytes)
{
    size_t least = SIZE_MAX, end = 0;
    int best = 0;

    bytes = (bytes + PAGE - 1) / PAGE * PAGE;
    if (count == BLOCKS || (!heap && !(heap = take_huge(HEAP))))
        return NULL;
    for (int i = 0; i <= count; i++) { /* gap i is before block i */
        const size_t room = (i < count ? blocks[i].at : HEAP) - end;
        if (room >= bytes && room < least) {
            least = room;
            best = i;
        }
        end = i < count ? blocks[i].end : HEAP;
    }
    if (least == SIZE_MAX)
        return NULL;
    memmove(&blocks[best + 1], &blocks[best],
            (size_t)(count++ - best) * sizeof *blocks);
    blocks[best].at = best ? blocks[best - 1].end : 0;
    blocks[best].end = blocks[best].at + bytes;
    return heap + blocks[best].at;
}

static void free_unused_heap(void)
{
    if (count || holders)
        return;
    ibl_port_free(heap);
    heap = NULL;
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
        free_unused_heap();
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
    free_unused_heap();
    pthread_mutex_unlock(&lock);
}

/* Bytes of physical memory. */
static size_t physical(void)
{
    const uint64_t bytes = ibl_port_memory();
    return bytes && bytes < SIZE_MAX ? (size_t)bytes : SIZE_MAX;
}

/* Memory from the program or the C library, without huge pages. */
static void *alloc_plain(size_t bytes)
{
    if (hook.alloc)
        return hook.alloc(hook.cookie, bytes ? bytes : 1, ALIGNMENT);
    return ibl_port_alloc(ALIGNMENT, (bytes / ALIGNMENT + 1) * ALIGNMENT);
}

static bool fits(size_t n, size_t size)
{
    return !size || n <= (SIZE_MAX / 4 - IBL_PORT_HUGE) / size;
}

void *ibl_alloc_array(size_t n, size_t size)
{
    if (!fits(n, size))
        return NULL;
    const size_t bytes = n * size;
    if (bytes < FROM || hook.alloc || (SANITIZED && bytes <= physical()))
        return alloc_plain(bytes);
    pthread_mutex_lock(&lock);
    void *p = SANITIZED ? NULL : take(bytes);
    pthread_mutex_unlock(&lock);
    /* An overcommitting system might allocate it and kill the program later. */
    return p || bytes > physical() ? p : take_huge(bytes);
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
        ibl_port_free(p);
}
