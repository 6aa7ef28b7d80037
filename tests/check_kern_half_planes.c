/* SPDX-License-Identifier: MIT */
/* Bytes of ZIP, and planes of halves: every version, every length, guarded. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/half.h"
#include "kern/half_planes.h"
#include "test.h"

enum {
    ALL = 65536,
    LONGEST = 70,
    GUARD = 16
};

static const ibl_isa levels[] = {IBL_ISA_C, IBL_ISA_SSE2, IBL_ISA_AVX2,
                                 IBL_ISA_AVX512};

/* IEEE 754: (-1)^s 2^(e - 15) 1.m, and below it 2^-14 0.m. */
static float value(unsigned half)
{
    const int e = (int)(half >> 10 & 31);
    const double m = half & 1023;
    const double sign = half & 0x8000 ? -1 : 1;
    if (e == 31)
        return m > 0 ? NAN : (float)(sign * (double)INFINITY);
    return (float)(sign * (e ? ldexp(1024 + m, e - 25) : ldexp(m, -24)));
}

static bool equal(float a, float b)
{
    return (isnan(a) && isnan(b)) || !memcmp(&a, &b, sizeof a);
}

static void every_half(void)
{
    unsigned char *bytes = malloc(2 * ALL + 1);
    float *rgb = malloc(3 * ALL * sizeof *rgb);
    for (int i = 0; i < ALL; i++) {
        bytes[1 + 2 * i] = (unsigned char)i;
        bytes[2 + 2 * i] = (unsigned char)(i >> 8);
    }
    /* from an odd address; B is R, as of grey files */
    const unsigned char *const plane[3] = {bytes + 1, bytes + 1 + ALL,
                                           bytes + 1};
    for (size_t k = 0; k < sizeof levels / sizeof levels[0]; k++) {
        int wrong = 0;
        if (levels[k] > ibl_isa_best())
            continue;
        ibl_half_planes(levels[k])(plane, ALL / 2, rgb);
        for (unsigned i = 0; i < ALL / 2; i++)
            wrong += !equal(rgb[3 * i], value(i)) +
                     !equal(rgb[3 * i + 1], value(i + ALL / 2)) +
                     !equal(rgb[3 * i + 2], value(i));
        CHECK_MSG(!wrong, "%s: %d wrong", ibl_isa_name(levels[k]), wrong);
    }
    free(rgb);
    free(bytes);
}

static void lengths(void)
{
    static unsigned char bytes[3][2 * LONGEST];
    static float want[3 * LONGEST], got[3 * LONGEST + GUARD];
    test_random r = {41};

    for (int n = 0; n <= LONGEST; n++) {
        /* at the ends of the planes, where asan looks */
        const unsigned char *const plane[3] = {bytes[0] + 2 * (LONGEST - n),
                                               bytes[1] + 2 * (LONGEST - n),
                                               bytes[2] + 2 * (LONGEST - n)};
        for (int i = 0; i < 6 * LONGEST; i++)
            bytes[i / (2 * LONGEST)][i % (2 * LONGEST)] =
                (unsigned char)test_random_u64(&r);
        ibl_half_planes_c(plane, n, want);
        for (size_t k = 0; k < sizeof levels / sizeof levels[0]; k++) {
            if (levels[k] > ibl_isa_best())
                continue;
            for (int i = 0; i < 3 * LONGEST + GUARD; i++)
                got[i] = -12345;
            ibl_half_planes(levels[k])(plane, n, got);
            for (int i = 0; i < 3 * n; i++)
                CHECK_MSG(equal(got[i], want[i]), "%s, %d of %d",
                          ibl_isa_name(levels[k]), i, n);
            for (int i = 3 * n; i < 3 * n + GUARD; i++)
                CHECK(got[i] == -12345);
        }
    }
}

/* What a writer does, as OpenEXR's file layout says: bytes at even places,
 * those at odd ones, then differences. */
static void predict(const unsigned char *src, int size, unsigned char *dst)
{
    int n = 0, last;

    for (int first = 0; first < 2; first++)
        for (int i = first; i < size; i += 2)
            dst[n++] = src[i];
    last = size ? dst[0] : 0;
    for (int i = 1; i < size; i++) {
        const int now = dst[i];
        dst[i] = (unsigned char)(now - last + 128);
        last = now;
    }
}

/* In pieces, as lines of a block are. */
static void unzip(const ibl_unzip_dsp *dsp, const unsigned char *src, int size,
                  test_random *r, unsigned char *dst)
{
    unsigned char last[2];

    ibl_unzip_begin(dsp, src, (size_t)size / 2, last);
    for (int i = 0; i < size / 2;) {
        const int some = 1 + (int)(test_random_u64(r) % 300);
        const int n = some < size / 2 - i ? some : size / 2 - i;
        dsp->next(src + i, src + size / 2 + i, (size_t)n, last, dst + 2 * i);
        i += n;
    }
}

static void differences(void)
{
    enum {
        MOST = 700
    };
    static unsigned char bytes[MOST], packed[MOST], got[MOST + GUARD];
    test_random r = {42};

    for (int n = 0; n <= MOST; n += 2) {
        unsigned char *src = packed + MOST - n; /* at the end, for asan */
        for (int i = 0; i < n; i++)
            bytes[i] = (unsigned char)test_random_u64(&r);
        predict(bytes, n, src);
        for (size_t k = 0; k < sizeof levels / sizeof levels[0]; k++) {
            ibl_unzip_dsp dsp;
            if (levels[k] > ibl_isa_best())
                continue;
            ibl_unzip_dsp_init(&dsp, levels[k]);
            memset(got, 99, sizeof got);
            unzip(&dsp, src, n, &r, got);
            CHECK_MSG(!memcmp(got, bytes, (size_t)n), "%s, %d",
                      ibl_isa_name(levels[k]), n);
            for (int i = n; i < n + GUARD; i++)
                CHECK(got[i] == 99);
        }
    }
}

/* Between each two halves that follow each other, 2^16 in place of Inf: what is
 * nearer, and of ties the even one. */
static void from_floats(void)
{
    int wrong = 0;
    for (unsigned h = 0; h < 0x7C00; h++) {
        const float low = value(h);
        const float high = h == 0x7BFF ? 0x1p16f : value(h + 1);
        const float middle = low + 0.5f * (high - low);
        wrong += ibl_half_to_float((uint16_t)h) != low;
        for (unsigned sign = 0; sign <= 0x8000; sign += 0x8000) {
            const float s = sign ? -1 : 1;
            const unsigned even = h % 2 ? h + 1 : h;
            wrong += ibl_half_from_float(s * low) != (sign | h);
            wrong += ibl_half_from_float(s * middle) != (sign | even);
            wrong +=
                ibl_half_from_float(s * nextafterf(middle, low)) != (sign | h);
            wrong += ibl_half_from_float(s * nextafterf(middle, high)) !=
                     (sign | (h + 1));
        }
    }
    CHECK_MSG(!wrong, "%d wrong", wrong);
    CHECK(ibl_half_from_float(INFINITY) == 0x7C00);
    CHECK(isnan(ibl_half_to_float(ibl_half_from_float(NAN))));
}

static const test tests[] = {TEST(differences), TEST(every_half),
                             TEST(from_floats), TEST(lengths)};
TEST_MAIN(tests)
