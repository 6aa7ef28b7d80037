/* SPDX-License-Identifier: MIT */
/* Every version of the pixel encoders against the plain one, byte for byte. */
#define _GNU_SOURCE
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "kern/pixel.h"
#include "test.h"

static float hostile(test_random *r)
{
    static const float values[] = {
        0,        -0.0f,    NAN,        INFINITY,   -INFINITY, 65504,
        65505,    65519.9f, 65520,      -65504,     -65520,    FLT_MAX,
        -FLT_MAX, FLT_MIN,  0x1p-14f,   0x1p-24f,   0x1p-25f,  0x1.000002p-25f,
        -1e-40f,  1,        0x1.ffcp0f, 0x1.ffep0f, 65408,     65024};
    const uint64_t u = test_random_u64(r);
    float f;
    switch (u >> 62) {
    case 0:
        return values[u % (sizeof values / sizeof values[0])];
    case 1: {
        const uint32_t bits = (uint32_t)u;
        memcpy(&f, &bits, sizeof f);
        return f;
    }
    default:
        return (float)ldexp(2 * test_random_unit(r) - 1, (int)(u % 44) - 26);
    }
}

static void compare(ibl_isa isa, ibl_pixel p, const float *src, size_t count,
                    size_t offset)
{
    enum {
        GUARD = 64
    };
    ibl_pixel_dsp plain, fast;
    const size_t bytes = count * ibl_pixel_bytes(p);
    unsigned char *a = malloc(bytes + GUARD + offset);
    unsigned char *b = malloc(bytes + GUARD + offset);
    ibl_pixel_dsp_init(&plain, IBL_ISA_C);
    ibl_pixel_dsp_init(&fast, isa);
    memset(a, 0xAA, bytes + GUARD + offset);
    memset(b, 0xAA, bytes + GUARD + offset);
    const size_t beyond_a = plain.encode[p](src, count, a + offset);
    const size_t beyond_b = fast.encode[p](src, count, b + offset);
    CHECK_MSG(beyond_a == beyond_b, "%s %s count %zu: %zu beyond, plain %zu",
              ibl_isa_name(isa), ibl_pixel_name(p), count, beyond_b, beyond_a);
    CHECK_MSG(!memcmp(a, b, bytes + GUARD + offset),
              "%s %s count %zu offset %zu: bytes differ", ibl_isa_name(isa),
              ibl_pixel_name(p), count, offset);
    free(a);
    free(b);
}

static void lengths(void)
{
    test_random r = {11};
    for (ibl_isa isa = IBL_ISA_SSE2; isa <= IBL_ISA_AVX512; isa++) {
        if (!ibl_cpu_has(isa))
            continue;
        for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
            for (size_t count = 0; count < 70; count++) {
                const size_t floats = count * (size_t)ibl_pixel_channels(p);
                float *src = malloc(floats * sizeof *src + 1);
                for (size_t i = 0; i < floats; i++)
                    src[i] = hostile(&r);
                compare(isa, p, src, count, count % 5);
                free(src);
            }
        }
    }
}

/* Bit patterns all over the floats, signs, denormals and NaNs included. */
static void sweep(void)
{
    enum {
        COUNT = 300000
    };
    float *src = malloc(3 * COUNT * sizeof *src);
    uint32_t bits = 0;
    for (int i = 0; i < 3 * COUNT; i++, bits += 4771u)
        memcpy(src + i, &bits, sizeof bits);
    for (ibl_isa isa = IBL_ISA_SSE2; isa <= IBL_ISA_AVX512; isa++) {
        for (ibl_pixel p = 0; ibl_cpu_has(isa) && p < IBL_PIXEL_COUNT; p++)
            compare(isa, p, src, COUNT, 0);
    }
    free(src);
}

/* Nothing is read beyond the last texel: the next page cannot be. */
static void page_end(void)
{
    test_random r = {12};
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *map = mmap(NULL, 2 * page, PROT_READ | PROT_WRITE,
                     MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    NEED(map != MAP_FAILED);
    mprotect(map + page, page, PROT_NONE);
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
        if (!ibl_cpu_has(isa))
            continue;
        for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
            for (size_t count = 1; count < 20; count++) {
                const size_t floats = count * (size_t)ibl_pixel_channels(p);
                float *src = (float *)(void *)(map + page) - floats;
                for (size_t i = 0; i < floats; i++)
                    src[i] = hostile(&r);
                compare(isa, p, src, count, 0);
            }
        }
    }
    munmap(map, 2 * page);
}

static const test tests[] = {TEST(lengths), TEST(sweep), TEST(page_end)};

TEST_MAIN(tests)
