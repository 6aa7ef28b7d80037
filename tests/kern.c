/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* MAP_ANONYMOUS */
#include "kern.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

void kern_each_isa(void (*check)(ibl_isa isa))
{
    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT; isa = test_next_isa(isa))
        check(isa);
}

/* ---- memory ------------------------------------------------------------ */

enum {
    FENCE = 64 /* bytes before the memory, and before them a header */
};

struct header {
    unsigned char *map, *end; /* pages; of them what can be touched */
    size_t bytes;
};

void *kern_alloc(size_t bytes, size_t align)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const size_t before = sizeof(struct header) + FENCE + align;
    const size_t size = (before + bytes + page - 1) / page * page;
    unsigned char *map = mmap(NULL, size + page, PROT_READ | PROT_WRITE,
                              MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (map == MAP_FAILED || mprotect(map + size, page, PROT_NONE))
        exit(1);
    const struct header h = {map, map + size, bytes};
    unsigned char *memory = map + (size - bytes) / align * align;
    memset(map, KERN_FILL, size);
    memcpy(memory - FENCE - sizeof h, &h, sizeof h);
    return memory;
}

static bool is_filled(const unsigned char *from, const unsigned char *to)
{
    while (from < to && *from == KERN_FILL)
        from++;
    return from >= to;
}

void kern_free(void *memory)
{
    unsigned char *p = memory;
    struct header h;
    if (!p)
        return;
    memcpy(&h, p - FENCE - sizeof h, sizeof h);
    CHECK_MSG(is_filled(p - FENCE, p), "%zu bytes: written before", h.bytes);
    CHECK_MSG(is_filled(p + h.bytes, h.end), "%zu bytes: written beyond",
              h.bytes);
    munmap(h.map, (size_t)(h.end - h.map) + (size_t)sysconf(_SC_PAGESIZE));
}

/* ---- the same bytes ---------------------------------------------------- */

static bool is_near(const unsigned char *got, const unsigned char *want,
                    size_t at)
{
    kern_near a, b;
    memcpy(&a, got + at, sizeof a);
    memcpy(&b, want + at, sizeof b);
    return fabs(a.value - b.value) <= b.bound;
}

static void check_n(const kern_same *k, int n, uint64_t seed)
{
    const size_t bytes = (size_t)n * k->unit;
    unsigned char *want = kern_alloc(bytes, k->align);
    test_random r = {seed};
    const size_t right = k->run(IBL_ISA_AUTO, &r, n, want);
    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
         isa = test_next_isa(isa)) {
        unsigned char *got = kern_alloc(bytes, k->align);
        size_t same = 0;
        r = (test_random){seed};
        const size_t result = k->run(isa, &r, n, got);
        while (same < bytes &&
               (k->near ? is_near(got, want, same) : want[same] == got[same]))
            same += k->near ? sizeof(kern_near) : 1;
        CHECK_MSG(same == bytes, "%s, %s: of %d number %zu differs, seed %d",
                  k->name, ibl_isa_name(isa), n, same / k->unit, (int)seed);
        CHECK_MSG(result == right, "%s, %s: %d: returns %zu, not %zu", k->name,
                  ibl_isa_name(isa), n, result, right);
        kern_free(got);
    }
    kern_free(want);
}

void kern_check_same(const kern_same *k)
{
    for (int n = 0; n <= k->longest; n++)
        for (int i = 0; i < (TEST_SANITIZED ? 1 : k->rounds); i++)
            check_n(k, n, (uint64_t)(1000 * n + i));
    if (k->also)
        check_n(k, k->also, 1);
}
