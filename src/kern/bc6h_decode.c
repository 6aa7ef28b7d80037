/* SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>

#include "kern/bc6h.h"
#include "kern/bc6h_modes.h"

/* What is left of a block, the next bit lowest. */
typedef ibl_bits128 bits;

/* The next count bits, 1..16. */
static int take(bits *b, int count)
{
    const int value = (int)ibl_bits128_get(*b, 0, count);
    b->low = b->low >> count | b->high << (64 - count);
    b->high >>= count;
    return value;
}

/* NULL for a reserved one. */
static const ibl_bc6h_mode *take_mode(bits *b)
{
    int number = take(b, 2);
    if (number >= 2)
        number |= take(b, 3) << 2;
    for (int i = 0; i < IBL_BC6H_MODES; i++)
        if (ibl_bc6h_modes[i].number == number)
            return &ibl_bc6h_modes[i];
    return NULL;
}

static void take_run(bits *b, const ibl_bc6h_run *run, int *value)
{
    const int step = run->from <= run->to ? 1 : -1;
    for (int i = run->from; i != run->to + step; i += step)
        *value |= take(b, 1) << i;
}

static int extend_sign(int value, int count)
{
    const int sign = 1 << (count - 1);
    return ((value & (2 * sign - 1)) ^ sign) - sign;
}

/* From header bits to what an endpoint of mode->bits bits is. */
static int endpoint(const ibl_bc6h_mode *mode, const int *values, int i,
                    bool is_signed)
{
    const int c = i % 3, count = mode->bits;
    int value = values[i];
    if (i >= 3 && mode->deltas)
        value = values[c] + extend_sign(value, mode->other_bits[c]);
    value &= (1 << count) - 1;
    return is_signed ? extend_sign(value, count) : value;
}

/* As ibl_bc6h_unquantise, to -32767..32767; 16 bits also give -32768. */
static int unquantise_signed(int q, int count)
{
    const int size = abs(q);
    if (count == 16 || q == 0)
        return q;
    const int value = size >= (1 << (count - 1)) - 1
                          ? 0x7FFF
                          : ((size << 15) + 0x4000) >> (count - 1);
    return q < 0 ? -value : value;
}

static uint16_t signed_half(int first, int second, int weight)
{
    /* The shift of a negative sum rounds down. */
    const int value = (first * (64 - weight) + second * weight + 32) >> 6;
    const int size = abs(value) * 31 >> 5;
    return (uint16_t)(value < 0 && size ? 0x8000 | size : size);
}

/* Takes the endpoints, as what colours are mixed from. */
static void take_endpoints(bits *b, const ibl_bc6h_mode *mode, bool is_signed,
                           int ends[3 * IBL_BC6H_ENDPOINTS])
{
    int values[3 * IBL_BC6H_ENDPOINTS] = {0};
    const ibl_bc6h_run *run = mode->runs;
    for (int left = ibl_bc6h_header_bits(mode); left > 0; run++) {
        take_run(b, run, &values[run->value]);
        left -= 1 + abs(run->to - run->from);
    }
    for (int i = 0; i < 6 * mode->regions; i++) {
        const int q = endpoint(mode, values, i, is_signed);
        ends[i] = is_signed ? unquantise_signed(q, mode->bits)
                            : ibl_bc6h_unquantise(q, mode->bits);
    }
}

static int decode(const unsigned char *block, bool is_signed,
                  uint16_t texels[IBL_BLOCK_TEXELS][3])
{
    bits b = ibl_bits128_load(block);
    const ibl_bc6h_mode *mode = take_mode(&b);
    int ends[3 * IBL_BC6H_ENDPOINTS];
    if (!mode) {
        memset(texels, 0, IBL_BLOCK_TEXELS * sizeof *texels);
        return 0;
    }
    take_endpoints(&b, mode, is_signed, ends);
    const bool two = mode->regions == 2;
    const int partition = two ? take(&b, 5) : 0;
    const unsigned second = two ? ibl_bc6h_partitions[partition] : 0;
    for (int i = 0; i < IBL_BLOCK_TEXELS; i++) {
        const bool anchor = i == 0 || (two && i == ibl_bc6h_anchors[partition]);
        const int index = take(&b, (two ? 3 : 4) - anchor);
        const int weight = ibl_bc6h_weights[!two][index];
        const int *first = ends + (second >> i & 1 ? 6 : 0);
        for (int c = 0; c < 3; c++)
            texels[i][c] =
                is_signed
                    ? signed_half(first[c], first[3 + c], weight)
                    : (uint16_t)ibl_bc6h_half(first[c], first[3 + c], weight);
    }
    return 1;
}

int ibl_bc6h_decode_block(const unsigned char *block,
                          uint16_t texels[IBL_BLOCK_TEXELS][3])
{
    return decode(block, false, texels);
}

int ibl_bc6h_decode_signed_block(const unsigned char *block,
                                 uint16_t texels[IBL_BLOCK_TEXELS][3])
{
    return decode(block, true, texels);
}
