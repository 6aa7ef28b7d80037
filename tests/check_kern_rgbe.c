/* SPDX-License-Identifier: MIT */
/* Radiance pixels: every version against ldexp and against the plain one. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/cpu.h"
#include "kern/rgbe.h"
#include "test.h"

enum {
    MAX_COUNT = 4096,
    GUARD = 64
};

static const ibl_isa levels[] = {IBL_ISA_C, IBL_ISA_SSE2, IBL_ISA_AVX2,
                                 IBL_ISA_AVX512};
static test_random rng = {20};

static int below(int n)
{
    return (int)(test_random_u64(&rng) % (uint64_t)n);
}

/* Every mantissa with every exponent, against the definition in double. */
static void every_pixel(void)
{
    enum {
        PLANE = 256 * 256
    };
    unsigned char *planes = malloc(4 * PLANE);
    float *rgb = malloc(3 * PLANE * sizeof *rgb);
    const float scale[3] = {1, 0.5f, 3};

    for (int i = 0; i < PLANE; i++) {
        planes[i] = (unsigned char)i;
        planes[PLANE + i] = (unsigned char)(255 - (i & 255));
        planes[2 * PLANE + i] = (unsigned char)(i * 7);
        planes[3 * PLANE + i] = (unsigned char)(i >> 8);
    }
    for (size_t l = 0; l < sizeof levels / sizeof *levels; l++) {
        ibl_rgbe_dsp dsp;
        int wrong = 0;
        if (!ibl_cpu_has(levels[l]))
            continue;
        ibl_rgbe_dsp_init(&dsp, levels[l]);
        dsp.to_rgb(planes, PLANE, PLANE, scale, rgb);
        for (int i = 0; i < PLANE; i++) {
            for (int c = 0; c < 3; c++) {
                const int e = planes[3 * PLANE + i];
                const float value =
                    e ? (float)ldexp(planes[c * PLANE + i], e - 136) : 0.0f;
                const float want = value * scale[c];
                wrong += memcmp(&want, &rgb[3 * i + c], sizeof want) != 0;
            }
        }
        CHECK_MSG(!wrong, "%s: %d components wrong", ibl_isa_name(levels[l]),
                  wrong);
    }
    free(rgb);
    free(planes);
}

/* Every length around the vectors, odd offsets, nothing written beyond. */
static void lengths(void)
{
    static unsigned char planes[4 * 256 + 8];
    static float want[3 * 256], got[3 * 256 + 2 * GUARD];

    for (size_t i = 0; i < sizeof planes; i++)
        planes[i] = (unsigned char)below(256);
    for (size_t l = 0; l < sizeof levels / sizeof *levels; l++) {
        ibl_rgbe_dsp dsp;
        if (!ibl_cpu_has(levels[l]))
            continue;
        ibl_rgbe_dsp_init(&dsp, levels[l]);
        for (int n = 0; n <= 130; n++) {
            const unsigned char *src = planes + below(8);
            const float scale[3] = {(float)test_random_unit(&rng), 1e-30f,
                                    1e30f};
            float *dst = got + GUARD + below(8);
            memset(got, 0xA5, sizeof got);
            ibl_rgbe_to_rgb_c(src, 200, n, scale, want);
            dsp.to_rgb(src, 200, n, scale, dst);
            CHECK_MSG(!memcmp(want, dst, 3 * (size_t)n * sizeof *want),
                      "%s differs at length %d", ibl_isa_name(levels[l]), n);
            uint32_t before, after;
            memcpy(&before, dst - 1, sizeof before);
            memcpy(&after, dst + 3 * n, sizeof after);
            CHECK_MSG(before == 0xA5A5A5A5u && after == 0xA5A5A5A5u,
                      "%s writes beyond %d pixels", ibl_isa_name(levels[l]), n);
        }
    }
}

/* A random record of runs and literals; what it stands for goes to plain.
 * Returns its size. */
static size_t encode(int count, int longest, unsigned char *record,
                     unsigned char *plain)
{
    unsigned char *p = record;
    while (count > 0) {
        const bool run = below(2);
        int n = 1 + below(longest);
        if (n > count)
            n = count;
        if (run) {
            if (n > 127)
                n = 127;
            *p++ = (unsigned char)(128 + n);
            memset(plain, *p++ = (unsigned char)below(256), (size_t)n);
        } else {
            *p++ = (unsigned char)n;
            for (int i = 0; i < n; i++)
                *p++ = plain[i] = (unsigned char)below(256);
        }
        plain += n;
        count -= n;
    }
    return (size_t)(p - record);
}

/* The slack that is promised is all that is used: both buffers are of their
 * exact size, which AddressSanitizer watches; guards watch the rest. */
static void expands(void)
{
    static unsigned char record[2 * MAX_COUNT], plain[MAX_COUNT];

    for (int round = 0; round < 3000; round++) {
        const int count = 1 + below(round % 3 ? 300 : MAX_COUNT);
        const size_t bytes = encode(count, 1 + below(128), record, plain);
        unsigned char *src = malloc(bytes + IBL_RGBE_SLACK);
        unsigned char *dst = malloc((size_t)count + IBL_RGBE_SLACK + GUARD);
        memcpy(src, record, bytes);
        memset(src + bytes, 0x5A, IBL_RGBE_SLACK);
        for (size_t l = 0; l < sizeof levels / sizeof *levels; l++) {
            const size_t slack = levels[l] == IBL_ISA_C ? 0 : IBL_RGBE_SLACK;
            unsigned char *guard = dst + count + slack;
            ibl_rgbe_dsp dsp;
            if (!ibl_cpu_has(levels[l]))
                continue;
            ibl_rgbe_dsp_init(&dsp, levels[l]);
            memset(dst, 0xEE, (size_t)count + IBL_RGBE_SLACK + GUARD);
            CHECK_MSG(dsp.expand(src, count, dst) == src + bytes,
                      "%s ends elsewhere, count %d round %d",
                      ibl_isa_name(levels[l]), count, round);
            CHECK_MSG(!memcmp(dst, plain, (size_t)count),
                      "%s differs, count %d round %d", ibl_isa_name(levels[l]),
                      count, round);
            for (int i = 0; i < GUARD; i++)
                CHECK_MSG(guard[i] == 0xEE, "%s writes beyond, count %d",
                          ibl_isa_name(levels[l]), count);
        }
        free(src);
        free(dst);
    }
}

static const test tests[] = {TEST(every_pixel), TEST(lengths), TEST(expands)};
TEST_MAIN(tests)
