/* SPDX-License-Identifier: MIT */
#include "kern/astc_ise.h"

/* An integer is a trit, a quint or neither, above some bits. base: 3, 5 or 1.
 */
static const struct {
    unsigned char bits, base;
} ranges[IBL_ISE_RANGES] = {{0, 3}, {2, 1}, {0, 5}, {1, 3}, {3, 1},
                            {1, 5}, {2, 3}, {4, 1}, {3, 5}, {6, 1},
                            {4, 5}, {7, 1}, {6, 3}, {8, 1}};

int ibl_ise_levels(int range)
{
    return ranges[range].base << ranges[range].bits;
}

/* Five trits take 8 bits, three quints 7. */
int ibl_ise_bits(int range, int count)
{
    const int base = ranges[range].base;
    const int digits = base == 3   ? (8 * count + 4) / 5
                       : base == 5 ? (7 * count + 2) / 3
                                   : 0;
    return count * ranges[range].bits + digits;
}

static void get_trits(unsigned t, unsigned char digits[5])
{
    unsigned c = t & 31;
    if ((t >> 2 & 7) == 7) {
        c = (t >> 5) << 2 | (t & 3);
        digits[4] = digits[3] = 2;
    } else if ((t >> 5 & 3) == 3) {
        digits[4] = 2;
        digits[3] = (unsigned char)(t >> 7);
    } else {
        digits[4] = (unsigned char)(t >> 7);
        digits[3] = t >> 5 & 3;
    }
    if ((c & 3) == 3) {
        digits[2] = 2;
        digits[1] = (unsigned char)(c >> 4);
        digits[0] = (unsigned char)((c >> 2 & 2) | (c >> 2 & ~(c >> 3) & 1));
    } else if ((c >> 2 & 3) == 3) {
        digits[2] = digits[1] = 2;
        digits[0] = c & 3;
    } else {
        digits[2] = (unsigned char)(c >> 4);
        digits[1] = c >> 2 & 3;
        digits[0] = c & 3;
    }
}

static unsigned put_trits(const unsigned char d[5])
{
    unsigned c;
    if (d[2] == 2 && d[1] == 2)
        c = 3u << 2 | d[0];
    else if (d[2] == 2)
        c = (unsigned)d[1] << 4 | (unsigned)d[0] << 2 | 3;
    else
        c = (unsigned)d[2] << 4 | (unsigned)d[1] << 2 | d[0];
    if (d[4] == 2 && d[3] == 2)
        return (c >> 2) << 5 | 7u << 2 | (c & 3);
    if (d[4] == 2)
        return (unsigned)d[3] << 7 | 3u << 5 | c;
    return (unsigned)d[4] << 7 | (unsigned)d[3] << 5 | c;
}

static void get_quints(unsigned q, unsigned char digits[3])
{
    unsigned c = q & 31;
    if ((q >> 1 & 3) == 3 && (q >> 5 & 3) == 0) {
        digits[2] = q & 1 ? 4 : q >> 3 & 3;
        digits[1] = digits[0] = 4;
        return;
    }
    if ((q >> 1 & 3) == 3) {
        digits[2] = 4;
        c = (q & 0x18) | (~q >> 5 & 3) << 1 | (q & 1);
    } else {
        digits[2] = q >> 5 & 3;
    }
    digits[1] = (c & 7) == 5 ? 4 : (unsigned char)(c >> 3);
    digits[0] = (c & 7) == 5 ? (unsigned char)(c >> 3) : c & 7;
}

static unsigned put_quints(const unsigned char d[3])
{
    if (d[0] == 4 && d[1] == 4)
        return d[2] == 4 ? 7 : (unsigned)d[2] << 3 | 6;
    const unsigned c =
        d[1] == 4 ? (unsigned)d[0] << 3 | 5 : (unsigned)d[1] << 3 | d[0];
    if (d[2] == 4)
        return (~c >> 1 & 3) << 5 | (c & 0x18) | 6 | (c & 1);
    return (unsigned)d[2] << 5 | c;
}

/* How the bits of a group's number are dealt out, behind each integer's own:
 * 2 2 1 2 1 of the trits', 3 2 2 of the quints'. */
static const signed char trit_bits[] = {2, 2, 1, 2, 1};
static const signed char quint_bits[] = {3, 2, 2};

/* The bits of a sequence alone: those behind it read as 0. */
static ibl_bits128 cut(ibl_bits128 bits, int at, int n)
{
    ibl_bits128 b = {0, 0};
    for (int i = 0; i < n; i += 32) {
        const int some = n - i < 32 ? n - i : 32;
        ibl_bits128_put(&b, i, some, ibl_bits128_get(bits, at + i, some));
    }
    return b;
}

void ibl_ise_get(ibl_bits128 bits, int at, int range, int count,
                 unsigned char *values)
{
    const ibl_bits128 b = cut(bits, at, ibl_ise_bits(range, count));
    const int n = ranges[range].bits, base = ranges[range].base;
    const int group = base == 3 ? 5 : base == 5 ? 3 : 1;
    const signed char *dealt = base == 3 ? trit_bits : quint_bits;

    for (int i = 0, bit = 0; i < count; i += group) {
        unsigned char low[5], digits[5] = {0};
        unsigned packed = 0;
        for (int k = 0, to = 0; k < group; k++, bit += n) {
            low[k] = (unsigned char)ibl_bits128_get(b, bit, n);
            if (base == 1)
                continue;
            packed |= ibl_bits128_get(b, bit + n, dealt[k]) << to;
            to += dealt[k];
            bit += dealt[k];
        }
        if (base == 3)
            get_trits(packed, digits);
        else if (base == 5)
            get_quints(packed, digits);
        for (int k = 0; k < group && i + k < count; k++)
            values[i + k] = (unsigned char)(digits[k] << n | low[k]);
    }
}

void ibl_ise_put(ibl_bits128 *bits, int at, int range, int count,
                 const unsigned char *values)
{
    const int n = ranges[range].bits, base = ranges[range].base;
    const int group = base == 3 ? 5 : base == 5 ? 3 : 1;
    const signed char *dealt = base == 3 ? trit_bits : quint_bits;

    for (int i = 0; i < count; i += group) {
        unsigned char digits[5] = {0};
        int packed = 0;
        for (int k = 0; k < group && i + k < count; k++)
            digits[k] = (unsigned char)(values[i + k] >> n);
        if (base > 1)
            packed = (int)(base == 3 ? put_trits(digits) : put_quints(digits));
        for (int k = 0; k < group && i + k < count; k++) {
            ibl_bits128_put(bits, at, n, values[i + k]);
            at += n;
            if (base == 1)
                continue;
            ibl_bits128_put(bits, at, dealt[k], packed);
            packed >>= dealt[k];
            at += dealt[k];
        }
    }
}

/* The specification's D C + B, then what A, the lowest bit, turns over; bits b,
 * c, ... stand at these places of B, lowest first. */
int ibl_ise_endpoint(int range, int value)
{
    static const struct {
        unsigned short c, places[5];
    } of[IBL_ISE_RANGES] = {
        [IBL_ISE_40] = {26, {0x082, 0x105}},
        [IBL_ISE_80] = {13, {0x040, 0x081, 0x102}},
        [IBL_ISE_192] = {5, {0x010, 0x020, 0x040, 0x080, 0x101}}};
    const int n = ranges[range].bits, a = value & 1 ? 0x1FF : 0;
    int b = 0;

    if (ranges[range].base == 1) /* its bits are repeated */
        return value << (8 - n) | value >> (2 * n - 8);
    for (int i = 1; i < n; i++)
        if (value >> i & 1)
            b |= of[range].places[i - 1];
    return (a & 0x80) | (((value >> n) * of[range].c + b) ^ a) >> 2;
}

int ibl_ise_weight(int range, int value)
{
    static const unsigned char weights[][16] = {
        [IBL_ISE_3] = {0, 32, 64},
        [IBL_ISE_4] = {0, 21, 43, 64},
        [IBL_ISE_5] = {0, 16, 32, 48, 64},
        [IBL_ISE_6] = {0, 64, 12, 52, 25, 39},
        [IBL_ISE_8] = {0, 9, 18, 27, 37, 46, 55, 64},
        [IBL_ISE_10] = {0, 64, 7, 57, 14, 50, 21, 43, 28, 36},
        [IBL_ISE_12] = {0, 64, 17, 47, 5, 59, 23, 41, 11, 53, 28, 36},
        [IBL_ISE_16] = {0, 4, 8, 12, 17, 21, 25, 29, 35, 39, 43, 47, 52, 56, 60,
                        64}};
    return weights[range][value];
}
