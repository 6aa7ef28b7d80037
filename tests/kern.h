/* SPDX-License-Identifier: MIT */
/* What the tests of kernels share: every instruction set, and memory that
 * nothing may be read or written beyond. */
#ifndef KERN_H
#define KERN_H

#include "test.h"

/* For each instruction set that this CPU has, plain C first; and a test that
 * does so with the function f_of. */
void kern_each_isa(void (*check)(ibl_isa isa));
#define KERN_TEST(f)                                                           \
    TEST(f)                                                                    \
    {                                                                          \
        kern_each_isa(f##_of);                                                 \
    }
#define KERN_TEST_SLOW(f)                                                      \
    TEST_SLOW(f)                                                               \
    {                                                                          \
        kern_each_isa(f##_of);                                                 \
    }

/* Memory of some bytes, all KERN_FILL. It ends less than align, a power of two,
 * before a page that cannot be touched. Exits if there is none. */
enum {
    KERN_FILL = 0x7B /* a float of 1e36: no sum with one is right */
};
void *kern_alloc(size_t bytes, size_t align);
/* Checks that the bytes before and after are as they were. NULL is fine. */
void kern_free(void *memory);

/*
 * A kernel by all its versions. run() makes n things from random numbers, hands
 * them to the version for isa, and puts into out what that gives, `unit` bytes
 * for each; with IBL_ISA_AUTO what is right, by its definition. It returns what
 * is to be the same, too. All bytes are the same or, if near is set, out has
 * values, and what is right says how far off they may be.
 */
typedef struct kern_same {
    const char *name;
    size_t (*run)(ibl_isa isa, test_random *r, int n, void *out);
    size_t unit, align;  /* align: of out */
    int longest, rounds; /* n from 0 on; how often each */
    int also;            /* one more n, or 0 */
    bool near;
} kern_same;

typedef struct kern_near {
    double value, bound;
} kern_near;

void kern_check_same(const kern_same *k);

#endif
