/* SPDX-License-Identifier: MIT */
#include "kern/astc_hdr_block.h"

#include <string.h>

#include "kern/astc_hdr.h"
#include "kern/astc_hdr_endpoints.h"

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

void ibl_astc_find_subsets(int pattern, unsigned char of[IBL_BLOCK_TEXELS])
{
    const uint32_t seed = (uint32_t)(pattern + 1024);
    const uint32_t random = hash(seed);
    const int by_seed = seed & 2 ? 4 : 5, by_count = 5;
    uint32_t first[IBL_BLOCK_TEXELS];

    for (int s = 0; s < 2; s++) {
        uint32_t x_step = random >> 8 * s & 15,
                 y_step = random >> (8 * s + 4) & 15;
        x_step = x_step * x_step >> (seed & 1 ? by_seed : by_count);
        y_step = y_step * y_step >> (seed & 1 ? by_count : by_seed);
        for (uint32_t i = 0; i < IBL_BLOCK_TEXELS; i++) {
            const uint32_t at = (x_step * 2 * (i % 4) + y_step * 2 * (i / 4) +
                                 (random >> (14 - 4 * s))) &
                                63;
            of[i] = s && at > first[i];
            first[i] = at;
        }
    }
}

static uint64_t reversed_word(uint64_t v)
{
    v = (v >> 1 & 0x5555555555555555) | (v & 0x5555555555555555) << 1;
    v = (v >> 2 & 0x3333333333333333) | (v & 0x3333333333333333) << 2;
    v = (v >> 4 & 0x0F0F0F0F0F0F0F0F) | (v & 0x0F0F0F0F0F0F0F0F) << 4;
    return __builtin_bswap64(v);
}

/* Weights are stored from the last bit on. */
static ibl_bits128 reversed(ibl_bits128 b)
{
    return (ibl_bits128){reversed_word(b.high), reversed_word(b.low)};
}

/* The header of one plane of 4x4 weights, but for their range. */
enum {
    GRID = 0x40,
    GRID_BITS = 0x5EC
};

int ibl_astc_unpack(ibl_bits128 bits, ibl_astc_block *b)
{
    const unsigned header = ibl_bits128_get(bits, 0, 11);
    const int code = (int)((header & 3) << 1 | (header >> 4 & 1));
    const int fine = header >> 9 & 1, least = fine ? 2 : 3;
    const int subsets = 1 + (int)ibl_bits128_get(bits, 11, 2);
    const int start = subsets == 1 ? 17 : 29;

    if ((header & GRID_BITS) != GRID || code < least || (fine && code > 4) ||
        subsets > 2)
        return 0;
    *b = (ibl_astc_block){
        .subsets = subsets,
        .pattern = subsets == 1 ? 0 : (int)ibl_bits128_get(bits, 13, 10),
        .mode = (int)ibl_bits128_get(bits, start - 4, 4),
        .weight_range = code + (fine ? 3 : -3)};
    const int direct = b->mode == IBL_ASTC_DIRECT;
    if (!direct && b->mode != IBL_ASTC_SCALE)
        return 0;
    /* Two have one mode, and fewer levels. */
    if (subsets == 2 && (ibl_bits128_get(bits, 23, 2) ||
                         b->weight_range > (direct ? IBL_ISE_4 : IBL_ISE_8)))
        return 0;
    b->values = subsets * (direct ? 6 : 4);
    b->value_range = IBL_ISE_256; /* or the largest that there is room for */
    const int room =
        128 - start - ibl_ise_bits(b->weight_range, IBL_BLOCK_TEXELS);
    while (ibl_ise_bits(b->value_range, b->values) > room)
        b->value_range--;
    ibl_ise_get(bits, start, b->value_range, b->values, b->value);
    ibl_ise_get(reversed(bits), 0, b->weight_range, IBL_BLOCK_TEXELS,
                b->weight);
    return 1;
}

ibl_bits128 ibl_astc_pack(const ibl_astc_block *b)
{
    const int fine = b->weight_range >= IBL_ISE_10;
    const int code = b->weight_range - (fine ? 3 : -3);
    const int start = b->subsets == 1 ? 17 : 29;
    ibl_bits128 weights = {0, 0}, bits;

    ibl_ise_put(&weights, 0, b->weight_range, IBL_BLOCK_TEXELS, b->weight);
    bits = reversed(weights);
    ibl_bits128_put(&bits, 0, 11,
                    GRID | code >> 1 | (code & 1) << 4 | fine << 9);
    ibl_bits128_put(&bits, 11, 2, b->subsets - 1);
    if (b->subsets == 2)
        ibl_bits128_put(&bits, 13, 10, b->pattern);
    ibl_bits128_put(&bits, start - 4, 4, b->mode);
    ibl_ise_put(&bits, start, b->value_range, b->values, b->value);
    return bits;
}

int ibl_astc_hdr_decode_block(const unsigned char *block,
                              uint16_t texels[IBL_BLOCK_TEXELS][3])
{
    const ibl_bits128 bits = ibl_bits128_load(block);
    unsigned char value[IBL_ASTC_VALUES], subset[IBL_BLOCK_TEXELS] = {0};
    int ends[2][2][3];
    ibl_astc_block b;

    memset(texels, 0, IBL_BLOCK_TEXELS * sizeof *texels);
    if (bits.low == IBL_ASTC_ONE_COLOUR) {
        for (int i = 0; i < 3 * IBL_BLOCK_TEXELS; i++)
            texels[i / 3][i % 3] =
                (uint16_t)ibl_bits128_get(bits, 64 + 16 * (i % 3), 16);
        return 1;
    }
    if (!ibl_astc_unpack(bits, &b))
        return 0;
    for (int i = 0; i < b.values; i++)
        value[i] = (unsigned char)ibl_ise_endpoint(b.value_range, b.value[i]);
    for (int s = 0; s < b.subsets; s++)
        ibl_astc_line_ends(b.mode, value + s * b.values / b.subsets, ends[s]);
    if (b.subsets == 2)
        ibl_astc_find_subsets(b.pattern, subset);
    for (int i = 0; i < 3 * IBL_BLOCK_TEXELS; i++) {
        const int w = ibl_ise_weight(b.weight_range, b.weight[i / 3]);
        const int c = i % 3, s = subset[i / 3];
        const int q = (ends[s][0][c] * (64 - w) + ends[s][1][c] * w) * 16;
        texels[i / 3][c] = ibl_astc_half((q + 32) >> 6);
    }
    return 1;
}
