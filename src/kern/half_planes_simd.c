/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "kern/half_planes.h"
#include "kern/lanes.h"

/* Sixteen bytes, in every instruction set. */
typedef unsigned char bytes __attribute__((vector_size(16)));

static inline bytes load(const unsigned char *src)
{
    bytes v;
    memcpy(&v, src, sizeof v);
    return v;
}

static unsigned char sum(const unsigned char *src, size_t count)
{
    unsigned char lanes[16];
    bytes sums = {0};
    size_t i = 0;

    for (; i + 16 <= count; i += 16)
        sums += load(src + i);
    memcpy(lanes, &sums, sizeof lanes);
    return (unsigned char)(ibl_unzip_sum_c(lanes, 16) +
                           ibl_unzip_sum_c(src + i, count - i));
}

/* v moved n bytes up, with zeros below. */
#define MOVED(v, n)                                                            \
    __builtin_shufflevector((bytes){0}, v, 16 - n, 17 - n, 18 - n, 19 - n,     \
                            20 - n, 21 - n, 22 - n, 23 - n, 24 - n, 25 - n,    \
                            26 - n, 27 - n, 28 - n, 29 - n, 30 - n, 31 - n)

/* Decodes the next 16 bytes from their differences. *last is the previous byte
 * in every lane, and becomes the last of these. Adds up 2, 4, 8, 16 differences
 * first; only the addition of *last depends on earlier bytes. */
static inline bytes add_up(const unsigned char *src, bytes *last)
{
    bytes v = load(src) ^ 128;

    v += MOVED(v, 1);
    v += MOVED(v, 2);
    v += MOVED(v, 4);
    v += MOVED(v, 8);
    v += *last;
    *last = __builtin_shufflevector(v, v, 15, 15, 15, 15, 15, 15, 15, 15, 15,
                                    15, 15, 15, 15, 15, 15, 15);
    return v;
}

static void unzip(const unsigned char *even, const unsigned char *odd,
                  size_t count, unsigned char last[2], unsigned char *dst)
{
    bytes last_even = (bytes){0} + last[0], last_odd = (bytes){0} + last[1];
    size_t i = 0;

    for (; i + 16 <= count; i += 16) {
        const bytes a = add_up(even + i, &last_even);
        const bytes b = add_up(odd + i, &last_odd);
        const bytes low = __builtin_shufflevector(
            a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
        const bytes high = __builtin_shufflevector(
            a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
        memcpy(dst + 2 * i, &low, sizeof low);
        memcpy(dst + 2 * i + 16, &high, sizeof high);
    }
    last[0] = last_even[0];
    last[1] = last_odd[0];
    ibl_unzip_c(even + i, odd + i, count - i, last, dst + 2 * i);
}

#ifdef HALVES
static void to_rgb(const unsigned char *const plane[3], int count, float *dst)
{
    int i = 0;

    for (; i + VF < count; i += VF, dst += 3 * VF)
        vf_store_rgb(dst, vf_load_halves(plane[0] + 2 * i),
                     vf_load_halves(plane[1] + 2 * i),
                     vf_load_halves(plane[2] + 2 * i));
    const unsigned char *const rest[3] = {plane[0] + 2 * i, plane[1] + 2 * i,
                                          plane[2] + 2 * i};
    ibl_half_planes_c(rest, count - i, dst);
}
#else
#define to_rgb ibl_half_planes_c
#endif

IBL_VECTOR_KERNEL(ibl_half_planes, sum, unzip, to_rgb)
