/* SPDX-License-Identifier: MIT */
#include "kern/astc_hdr_block.h"

/* Section 23.21, for blocks of less than 31 texels. */
static uint32_t hash(uint32_t p)
{
    p ^= p >> 15;
    p -= p << 17;
    p += p << 7;
    p += p << 4;
    p ^= p >> 5;
    p += p << 16;
    p ^= p >> 7;
    p ^= p >> 3;
    p ^= p << 6;
    p ^= p >> 17;
    return p;
}

void ibl_astc_find_subsets(int pattern, int subsets,
                           unsigned char of[IBL_ASTC_TEXELS])
{
    const uint32_t seed = (uint32_t)(pattern + (subsets - 1) * 1024);
    const uint32_t random = hash(seed);
    const int by_seed = seed & 2 ? 4 : 5, by_count = subsets == 3 ? 6 : 5;
    uint32_t most[IBL_ASTC_TEXELS] = {0};

    for (int s = 0; s < subsets; s++) {
        uint32_t x_step = random >> 8 * s & 15,
                 y_step = random >> (8 * s + 4) & 15;
        x_step = x_step * x_step >> (seed & 1 ? by_seed : by_count);
        y_step = y_step * y_step >> (seed & 1 ? by_count : by_seed);
        for (uint32_t i = 0; i < IBL_ASTC_TEXELS; i++) {
            const uint32_t at = (x_step * 2 * (i % 4) + y_step * 2 * (i / 4) +
                                 (random >> (14 - 4 * s))) &
                                63;
            if (s && at <= most[i])
                continue;
            most[i] = at;
            of[i] = (unsigned char)s;
        }
    }
}

/* The largest range of which a sequence has at most this many bits; -1 if none
 * has. */
static int range_of(int values, int bits)
{
    int range = IBL_ISE_256;
    while (range >= IBL_ISE_6 && ibl_ise_bits(range, values) > bits)
        range--;
    return range >= IBL_ISE_6 ? range : -1;
}

/* The size of the grid of weights and their range, of the first 11 bits. Grids
 * wider or higher than the block are invalid, so few layouts are left. */
static int unpack_grid(ibl_bits128 bits, ibl_astc_block *b)
{
    const unsigned mode = ibl_bits128_get(bits, 0, 11);
    const int first = (int)(mode >> 5 & 3), second = (int)(mode >> 7 & 3);
    const int range = (int)((mode & 3) << 1 | (mode >> 4 & 1));
    const int layout = (int)(mode >> 2 & 3);

    if (!(mode & 3) || layout == 1 || layout == 2)
        return 0;
    b->height = first + 2;
    b->width = layout == 0 ? second + 4 : (second & 1) + 2;
    b->weight_range = range - 2 + (mode & 0x200 ? 6 : 0);
    b->planes = mode & 0x400 ? 2 : 1;
    if (b->width > 4 || b->height > 4 || (layout == 3 && second < 2))
        return 0;
    const int n =
        ibl_ise_bits(b->weight_range, b->planes * b->width * b->height);
    return n >= 24 && n <= 96;
}

/* The modes of several subsets' endpoints: one for all, or two classes of four
 * modes that are next to each other. Returns how many bits more that takes,
 * before bit `below`. */
static int unpack_modes(ibl_bits128 bits, int below, ibl_astc_block *b)
{
    const int n = b->subsets, more = 3 * n - 4;
    const int class = (int)ibl_bits128_get(bits, 23, 2);
    int code = (int)ibl_bits128_get(bits, 25, 4);

    for (int i = 0; i < n && !class; i++)
        b->mode[i] = code;
    if (!class)
        return 0;
    code |= (int)ibl_bits128_get(bits, below - more, more) << 4;
    for (int i = 0; i < n; i++)
        b->mode[i] =
            (class - 1 + (code >> i & 1)) << 2 | (code >> (n + 2 * i) & 3);
    return more;
}

int ibl_astc_unpack(ibl_bits128 bits, ibl_astc_block *b)
{
    int below, start = 17;

    b->subsets = 1 + (int)ibl_bits128_get(bits, 11, 2);
    if (!unpack_grid(bits, b) || (b->planes == 2 && b->subsets == 4))
        return 0;
    const int weights = b->planes * b->width * b->height;
    below = 128 - ibl_ise_bits(b->weight_range, weights);
    if (b->subsets == 1) {
        b->pattern = 0;
        b->mode[0] = (int)ibl_bits128_get(bits, 13, 4);
    } else {
        start = 29;
        b->pattern = (int)ibl_bits128_get(bits, 13, 10);
        below -= unpack_modes(bits, below, b);
    }
    if (b->planes == 2)
        b->plane2 = (int)ibl_bits128_get(bits, below -= 2, 2);
    b->values = 0;
    for (int i = 0; i < b->subsets; i++)
        b->values += 2 * (b->mode[i] / 4 + 1);
    if (b->values > IBL_ASTC_VALUES)
        return 0;
    b->value_range = range_of(b->values, below - start);
    if (b->value_range < 0)
        return 0;
    ibl_ise_get(bits, start, b->value_range, b->values, b->value);
    ibl_ise_get(ibl_bits128_reversed(bits), 0, b->weight_range, weights,
                b->weight);
    return 1;
}

ibl_bits128 ibl_astc_pack(const ibl_astc_block *b)
{
    const int fine = b->weight_range >= IBL_ISE_10;
    const unsigned range = (unsigned)(b->weight_range + (fine ? -4 : 2));
    ibl_bits128 weights = {0, 0}, bits;

    ibl_ise_put(&weights, 0, b->weight_range, IBL_ASTC_TEXELS, b->weight);
    bits = ibl_bits128_reversed(weights);
    /* A grid of 4x4, by the upper two bits of the range's number and one. */
    ibl_bits128_put(&bits, 0, 11,
                    range >> 1 | (range & 1) << 4 | 2 << 5 |
                        (unsigned)fine << 9);
    ibl_bits128_put(&bits, 11, 2, (unsigned)b->subsets - 1);
    if (b->subsets > 1)
        ibl_bits128_put(&bits, 13, 10, (unsigned)b->pattern);
    ibl_bits128_put(&bits, b->subsets > 1 ? 25 : 13, 4, (unsigned)b->mode[0]);
    ibl_ise_put(&bits, b->subsets > 1 ? 29 : 17, b->value_range, b->values,
                b->value);
    return bits;
}
