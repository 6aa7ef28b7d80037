/* SPDX-License-Identifier: MIT */
#include "kern/astc_ise.h"

ibl_bits128 ibl_bits128_load(const unsigned char block[16])
{
    ibl_bits128 b = {0, 0};
    for (int i = 0; i < 8; i++) {
        b.low |= (uint64_t)block[i] << 8 * i;
        b.high |= (uint64_t)block[8 + i] << 8 * i;
    }
    return b;
}

void ibl_bits128_store(ibl_bits128 bits, unsigned char block[16])
{
    for (int i = 0; i < 8; i++) {
        block[i] = (unsigned char)(bits.low >> 8 * i);
        block[8 + i] = (unsigned char)(bits.high >> 8 * i);
    }
}

static uint64_t reversed(uint64_t v)
{
    v = (v >> 1 & 0x5555555555555555) | (v & 0x5555555555555555) << 1;
    v = (v >> 2 & 0x3333333333333333) | (v & 0x3333333333333333) << 2;
    v = (v >> 4 & 0x0F0F0F0F0F0F0F0F) | (v & 0x0F0F0F0F0F0F0F0F) << 4;
    return __builtin_bswap64(v);
}

ibl_bits128 ibl_bits128_reversed(ibl_bits128 bits)
{
    return (ibl_bits128){reversed(bits.high), reversed(bits.low)};
}

unsigned ibl_bits128_get(ibl_bits128 bits, int at, int n)
{
    uint64_t v;
    if (at >= 128)
        return 0;
    if (at >= 64)
        v = bits.high >> (at - 64);
    else
        v = bits.low >> at | (at ? bits.high << (64 - at) : 0);
    return (unsigned)(v & ((UINT64_C(1) << n) - 1));
}

void ibl_bits128_put(ibl_bits128 *bits, int at, int n, unsigned value)
{
    if (at >= 64) {
        bits->high |= (uint64_t)value << (at - 64);
        return;
    }
    bits->low |= (uint64_t)value << at;
    if (at + n > 64)
        bits->high |= (uint64_t)value >> (64 - at);
}

/* An integer is a trit, a quint or neither, above some bits. base: 3, 5 or 1.
 * (D C + B) is what unquantises endpoints; B as bits to copy the integer's bits
 * b, c, ... to. */
static const struct {
    unsigned char bits, base;
} ranges[IBL_ISE_RANGES] = {{1, 1}, {0, 3}, {2, 1}, {0, 5}, {1, 3}, {3, 1},
                            {1, 5}, {2, 3}, {4, 1}, {2, 5}, {3, 3}, {5, 1},
                            {3, 5}, {4, 3}, {6, 1}, {4, 5}, {5, 3}, {7, 1},
                            {5, 5}, {6, 3}, {8, 1}};

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
        unsigned packed = 0;
        for (int k = 0; k < group && i + k < count; k++)
            digits[k] = (unsigned char)(values[i + k] >> n);
        if (base > 1)
            packed = base == 3 ? put_trits(digits) : put_quints(digits);
        for (int k = 0; k < group && i + k < count; k++) {
            ibl_bits128_put(bits, at, n, values[i + k] & ((1u << n) - 1));
            at += n;
            if (base == 1)
                continue;
            ibl_bits128_put(bits, at, dealt[k],
                            packed & ((1u << dealt[k]) - 1));
            packed >>= dealt[k];
            at += dealt[k];
        }
    }
}

/* An integer of n bits, repeated to fill `to` bits. */
static int repeated(int value, int n, int to)
{
    int v = 0;
    for (int at = to - n; at > -n; at -= n)
        v |= at >= 0 ? value << at : value >> -at;
    return v;
}

/* The specification's D C + B, then what A, the lowest bit, turns over. bits:
 * the integer's bits b, c, ... stand at these places of B, lowest first. */
static int unquantise(int value, int n, int c, const unsigned short *places,
                      int top)
{
    const int a = value & 1 ? 4 * top - 1 : 0;
    int b = 0;
    for (int i = 1; i < n; i++)
        if (value >> i & 1)
            b |= places[i - 1];
    const int t = ((value >> n) * c + b) ^ a;
    return (a & top) | t >> 2;
}

int ibl_ise_endpoint(int range, int value)
{
    static const unsigned short places[IBL_ISE_RANGES][5] = {
        [IBL_ISE_12] = {0x116},
        [IBL_ISE_20] = {0x10C},
        [IBL_ISE_24] = {0x085, 0x10A},
        [IBL_ISE_40] = {0x082, 0x105},
        [IBL_ISE_48] = {0x041, 0x082, 0x104},
        [IBL_ISE_80] = {0x040, 0x081, 0x102},
        [IBL_ISE_96] = {0x020, 0x040, 0x081, 0x102},
        [IBL_ISE_160] = {0x020, 0x040, 0x080, 0x101},
        [IBL_ISE_192] = {0x010, 0x020, 0x040, 0x080, 0x101}};
    static const unsigned char factor[IBL_ISE_RANGES] = {
        [IBL_ISE_6] = 204, [IBL_ISE_10] = 113, [IBL_ISE_12] = 93,
        [IBL_ISE_20] = 54, [IBL_ISE_24] = 44,  [IBL_ISE_40] = 26,
        [IBL_ISE_48] = 22, [IBL_ISE_80] = 13,  [IBL_ISE_96] = 11,
        [IBL_ISE_160] = 6, [IBL_ISE_192] = 5};
    const int n = ranges[range].bits;

    return factor[range]
               ? unquantise(value, n, factor[range], places[range], 0x80)
               : repeated(value, n, 8);
}

int ibl_ise_weight(int range, int value)
{
    static const unsigned char whole[2][5] = {{0, 32, 63}, {0, 16, 32, 47, 63}};
    static const unsigned short places[IBL_ISE_RANGES][2] = {
        [IBL_ISE_12] = {0x45},
        [IBL_ISE_20] = {0x42},
        [IBL_ISE_24] = {0x21, 0x42}};
    static const unsigned char factor[IBL_ISE_RANGES] = {[IBL_ISE_6] = 50,
                                                         [IBL_ISE_10] = 28,
                                                         [IBL_ISE_12] = 23,
                                                         [IBL_ISE_20] = 13,
                                                         [IBL_ISE_24] = 11};
    const int n = ranges[range].bits;
    int w;

    if (!n)
        w = whole[range == IBL_ISE_5][value];
    else if (factor[range])
        w = unquantise(value, n, factor[range], places[range], 0x20);
    else
        w = repeated(value, n, 6);
    return w + (w > 32);
}
