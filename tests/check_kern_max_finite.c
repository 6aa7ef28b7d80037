/* SPDX-License-Identifier: MIT */
/* Every version of ibl_max_finite beside a plain reading of its contract. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kern/max_finite.h"
#include "test.h"

enum {
    LONGEST = 300
};

static const ibl_isa levels[] = {IBL_ISA_C, IBL_ISA_SSE2, IBL_ISA_AVX2,
                                 IBL_ISA_AVX512};

static void check(const float *src, size_t count)
{
    bool clean = true;
    float most = 0;
    for (size_t i = 0; i < count; i++) {
        clean = clean && isfinite(src[i]) && !signbit(src[i]);
        most = src[i] > most ? src[i] : most;
    }
    for (size_t k = 0; k < sizeof levels / sizeof levels[0]; k++) {
        if (levels[k] > ibl_isa_best())
            continue;
        const uint32_t bits = ibl_max_finite(levels[k])(src, count);
        float got;
        memcpy(&got, &bits, sizeof got);
        CHECK_MSG(clean == (bits < IBL_INFINITE_BITS), "%s, %zu: %08x",
                  ibl_isa_name(levels[k]), count, bits);
        CHECK_MSG(!clean || got == most, "%s, %zu: %g, not %g",
                  ibl_isa_name(levels[k]), count, (double)got, (double)most);
    }
}

/* Every length, every place for one odd float, odd floats around the range
 * that must not be seen. */
static void lengths_and_places(void)
{
    const float odd[] = {INFINITY, -INFINITY, NAN,   -NAN,    -0.0f,
                         -1e-45f,  1e-45f,    3e38f, 65504.0f};
    static float buffer[LONGEST + 2];
    test_random r = {31};

    for (size_t n = 0; n <= LONGEST; n++) {
        buffer[0] = -1;
        buffer[n + 1] = NAN;
        for (size_t i = 0; i < n; i++)
            buffer[1 + i] = (float)test_random_unit(&r);
        check(buffer + 1, n);
        for (size_t i = 0; i < n; i++) {
            const float was = buffer[1 + i];
            buffer[1 + i] = odd[(i + n) % (sizeof odd / sizeof odd[0])];
            check(buffer + 1, n);
            buffer[1 + i] = was;
        }
    }
}

static void random_bits(void)
{
    static float src[LONGEST];
    test_random r = {32};
    for (int round = 0; round < 2000; round++) {
        const size_t n = (size_t)(test_random_unit(&r) * LONGEST);
        for (size_t i = 0; i < n; i++) {
            const uint32_t bits = (uint32_t)test_random_u64(&r) &
                                  (round % 2 ? 0x7effffffu : 0xffffffffu);
            memcpy(src + i, &bits, sizeof bits);
        }
        check(src, n);
    }
}

static const test tests[] = {TEST(lengths_and_places), TEST(random_bits)};
TEST_MAIN(tests)
