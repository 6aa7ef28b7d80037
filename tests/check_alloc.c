/* SPDX-License-Identifier: MIT */
/* Memory: alignment, zeroes, sizes around where huge pages begin, refusals. */
#include "core/alloc.h"

#include <malloc.h>
#include <stdint.h>
#include <string.h>

#include "test.h"

static const size_t sizes[] = {0,
                               1,
                               63,
                               64,
                               65,
                               4096,
                               (1 << 20) - 1,
                               1 << 20,
                               (1 << 21) - 1,
                               1 << 21,
                               (1 << 21) + 1,
                               5 << 20};

enum {
    SIZES = sizeof sizes / sizeof sizes[0]
};

enum {
    MIB = 1 << 20
};

/* Whether a block takes the memory of one that was freed, which fresh memory
 * of the system, all 0, cannot be. between: done meanwhile. */
static bool takes(int asked_mib, int freed_mib, ibl_ctx *between)
{
    const size_t freed = (size_t)freed_mib * MIB;
    const size_t asked = (size_t)asked_mib * MIB;
    unsigned char *p = ibl_alloc_array(freed, 1);
    if (!p)
        return false;
    memset(p, 77, freed);
    ibl_free(p);
    ibl_ctx_free(between);
    p = ibl_alloc_array(asked, 1);
    const bool same = p && p[asked / 2] == 77;
    ibl_free(p);
    return same;
}

/* What stays of many freed blocks, in MiB. */
static double left_of(int blocks, int mib)
{
    unsigned char *p[16];
    for (int i = 0; i < blocks; i++)
        p[i] = ibl_alloc_array((size_t)mib * MIB, 1);
    for (int i = 0; i < blocks; i++)
        ibl_free(p[i]);
    return (double)mallinfo2().hblkhd / MIB;
}

/* The first test, as its heap has no large holes. Memory is kept as long as
 * there is a context, whichever ends before: as much as there is room for,
 * again and again, and not for far less. */
TEST(kept_for_contexts)
{
    if (TEST_SANITIZED)
        test_skip("sanitizers are to see every block go");
    mallopt(M_MMAP_THRESHOLD, MIB); /* what is freed goes to the system */
    ibl_ctx *a, *b;
    NEED(!ibl_ctx_create(NULL, &a) && !ibl_ctx_create(NULL, &b));
    for (int i = 0; i < 8; i++)
        CHECK(takes(8, 8, NULL));
    CHECK(!takes(2, 16, NULL));
    CHECK(takes(8, 8, a));
    /* 32, and 2 of each block to align it. */
    CHECK(left_of(16, 6) < 56);
    CHECK(!takes(8, 8, b));
    CHECK(!takes(8, 8, NULL));
    CHECK(left_of(0, 0) < 1);
}

/* Two rounds, so that memory is used again that was not zero. */
TEST(every_size)
{
    unsigned char *p[SIZES];
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < SIZES; i++) {
            p[i] = ibl_alloc_zeroed(sizes[i], 1);
            NEED(p[i]);
            CHECK((uintptr_t)p[i] % 64 == 0);
            size_t others = 0;
            for (size_t k = 0; k < sizes[i]; k++)
                others += p[i][k] != 0;
            CHECK_MSG(!others, "%zu of %zu bytes not 0", others, sizes[i]);
            memset(p[i], i + 1, sizes[i]);
        }
        for (int i = 0; i < SIZES; i++) {
            CHECK(!sizes[i] ||
                  (p[i][0] == i + 1 && p[i][sizes[i] - 1] == i + 1));
            ibl_free(p[i]);
        }
    }
    ibl_free(NULL);
}

/* More large blocks than are remembered, freed in another order, some kept and
 * handed out again: none overlap. */
TEST(many_large)
{
    enum {
        BLOCKS = 80,
        EDGE = 1 << 20
    };
    static unsigned char *p[BLOCKS];
    test_random rnd = {5};

    ibl_alloc_hold();
    for (int n = 0; n < 600; n++) {
        const int i = (int)(test_random_u64(&rnd) % BLOCKS);
        if (p[i]) {
            CHECK(p[i][0] == i && p[i][EDGE - 1] == i);
            ibl_free(p[i]);
            p[i] = NULL;
        } else {
            const size_t more = (size_t)(test_random_u64(&rnd) % (3 * EDGE));
            p[i] = ibl_alloc_array(EDGE + more, 1);
            NEED(p[i]);
            p[i][0] = p[i][EDGE - 1] = (unsigned char)i;
        }
        if (n % 100 == 99) {
            ibl_alloc_release();
            ibl_alloc_hold();
        }
    }
    for (int i = 0; i < BLOCKS; i++)
        ibl_free(p[i]);
    ibl_alloc_release();
}

TEST(too_much)
{
    CHECK(!ibl_alloc_array(SIZE_MAX, 1));
    CHECK(!ibl_alloc_array(SIZE_MAX / 2, 1));
    CHECK(!ibl_alloc_array(SIZE_MAX / 2, 3));
    CHECK(!ibl_alloc_array(1, SIZE_MAX - 62));
    CHECK(!ibl_alloc_array((size_t)1 << 33, (size_t)1 << 33));
}
