/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "kern/astc_hdr.h"
#include "kern/astc_hdr_block.h"
#include "kern/astc_hdr_endpoints.h"

/* Both ends of a subset, 16 bits a channel, in q or, of the modes that cannot
 * exceed 1, in units of 1/65535. */
typedef struct ends {
    int e[2][3];
    int hdr;
} ends;

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* ---- endpoints that are grey ------------------------------------------- */

static void set_grey(ends *to, int e0, int e1)
{
    for (int c = 0; c < 3; c++) {
        to->e[0][c] = e0;
        to->e[1][c] = e1;
    }
}

static void hdr_grey_large(const unsigned char *v, ends *to)
{
    if (v[1] >= v[0])
        set_grey(to, v[0] << 4, v[1] << 4);
    else
        set_grey(to, (v[1] << 4) + 8, (v[0] << 4) - 8);
}

static void hdr_grey_small(const unsigned char *v, ends *to)
{
    const int fine = v[0] >> 7 ? 0 : 1, high = v[1] >> (5 - fine);
    const int low = v[1] & (fine ? 15 : 31), shift = 2 - fine;
    const int e0 = high << (9 - fine + 0) | (v[0] & 127) << shift;
    set_grey(to, e0, least(e0 + (low << shift), 4095));
}

/* ---- endpoints of at most 1 -------------------------------------------- */

/* Moves the upper bit of a, which becomes signed, to b. */
static void move_bit(int *a, int *b)
{
    *b = *b >> 1 | (*a & 0x80);
    *a = *a >> 1 & 63;
    if (*a & 32)
        *a -= 64;
}

static int byte(int v)
{
    return v < 0 ? 0 : v > 255 ? 255 : v;
}

static void ldr_grey(const unsigned char *v, ends *to, int mode)
{
    int e0 = v[0], e1 = v[1];
    if (mode == 1) {
        e0 = v[0] >> 2 | (v[1] & 0xC0);
        e1 = byte(e0 + (v[1] & 63));
    } else if (mode == 5) {
        move_bit(&e1, &e0);
        e1 = byte(e0 + e1);
    }
    set_grey(to, e0, e1);
}

/* Pairs of values are the two ends, or one and the way to the other. A sum that
 * falls says that red and green are stored as twice their mean with blue. */
static void ldr_colours(const unsigned char *v, ends *to, int offset)
{
    int pairs[3][2], rise = 0;

    for (int c = 0; c < 3; c++) {
        int a = v[2 * c], b = v[2 * c + 1];
        if (offset)
            move_bit(&b, &a);
        rise += offset ? b : b - a;
        pairs[c][0] = a;
        pairs[c][1] = offset ? a + b : b;
    }
    for (int i = 0; i < 2; i++) {
        const int from = rise >= 0 ? i : 1 - i, blue = pairs[2][from];
        for (int c = 0; c < 3; c++) {
            const int p = pairs[c][from];
            to->e[i][c] = byte(rise >= 0 || c == 2 ? p : (p + blue) >> 1);
        }
    }
}

static void ldr_scale(const unsigned char *v, ends *to)
{
    for (int c = 0; c < 3; c++) {
        to->e[0][c] = v[c] * v[3] >> 8;
        to->e[1][c] = v[c];
    }
}

/* Of one subset. Modes with alpha have its values last. */
static void find_ends(int mode, const unsigned char *v, ends *to)
{
    to->hdr = 1;
    if (mode == 2)
        hdr_grey_large(v, to);
    else if (mode == 3)
        hdr_grey_small(v, to);
    else if (mode == IBL_ASTC_SCALE)
        ibl_astc_scale_endpoints(v, to->e);
    else if (mode == IBL_ASTC_DIRECT || mode >= 14)
        ibl_astc_direct_endpoints(v, to->e);
    else
        to->hdr = 0;
    if (!to->hdr) {
        if (mode == 6 || mode == 10)
            ldr_scale(v, to);
        else if (mode < 6)
            ldr_grey(v, to, mode);
        else
            ldr_colours(v, to, mode & 1);
    }
    for (int i = 0; i < 6; i++)
        to->e[i / 3][i % 3] *= to->hdr ? 16 : 257;
}

/* ---- texels ------------------------------------------------------------ */

/* v / 65536 as a half, rounded down; the last is 1. */
static uint16_t unit_half(int v)
{
    int exponent = 14;
    if (v == 65535)
        return 0x3C00;
    if (v < 4)
        return (uint16_t)(v << 8);
    for (; v < 0x8000; v <<= 1)
        exponent--;
    return (uint16_t)(exponent << 10 | (v >> 5 & 1023));
}

/* The weights, 0 to 64, of texels, bilinear in sixteenths between those of the
 * grid; plane p of several has every p-th. Section 23.19. */
static void find_weights(const ibl_astc_block *b, const unsigned char *weight,
                         int plane, int texels[IBL_ASTC_TEXELS])
{
    for (int i = 0; i < IBL_ASTC_TEXELS; i++) {
        const int u = (342 * (i % 4) * (b->width - 1) + 32) >> 6;
        const int v = (342 * (i / 4) * (b->height - 1) + 32) >> 6;
        const int fx = u & 15, fy = v & 15, both = (fx * fy + 8) >> 4;
        const int right = fx ? b->planes : 0;
        const int down = fy ? b->planes * b->width : 0;
        const unsigned char *w =
            weight + ((u >> 4) + (v >> 4) * b->width) * b->planes + plane;
        texels[i] = (w[0] * (16 - fx - fy + both) + w[right] * (fx - both) +
                     w[down] * (fy - both) + w[right + down] * both + 8) >>
                    4;
    }
}

static void decode_texels(const ibl_astc_block *b, const ends *subsets,
                          uint16_t texels[16][3])
{
    unsigned char weight[2 * IBL_ASTC_TEXELS], subset[IBL_ASTC_TEXELS];
    int planes[2][IBL_ASTC_TEXELS];

    for (int i = 0; i < b->planes * b->width * b->height; i++)
        weight[i] =
            (unsigned char)ibl_ise_weight(b->weight_range, b->weight[i]);
    for (int p = 0; p < b->planes; p++)
        find_weights(b, weight, p, planes[p]);
    ibl_astc_find_subsets(b->pattern, b->subsets, subset);
    for (int i = 0; i < IBL_ASTC_TEXELS; i++) {
        const ends *s = &subsets[subset[i]];
        for (int c = 0; c < 3; c++) {
            const int w = planes[b->planes == 2 && b->plane2 == c][i];
            const int v = (s->e[0][c] * (64 - w) + s->e[1][c] * w + 32) >> 6;
            texels[i][c] = s->hdr ? ibl_astc_half(v) : unit_half(v);
        }
    }
}

/* A block of one colour: of halves if bit 9 is set, else of 1/65535. Where in
 * the texture it holds does not matter, but must be a rectangle or all ones. */
static int decode_void_extent(ibl_bits128 bits, uint16_t texels[16][3])
{
    int any = 0, at[4];

    for (int i = 0; i < 4; i++) {
        at[i] = (int)ibl_bits128_get(bits, 12 + 13 * i, 13);
        any |= at[i] != 8191;
    }
    if (ibl_bits128_get(bits, 10, 2) != 3 ||
        (any && (at[0] >= at[1] || at[2] >= at[3])))
        return 0;
    for (int i = 0; i < 16; i++)
        for (int c = 0; c < 3; c++) {
            const int v = (int)ibl_bits128_get(bits, 64 + 16 * c, 16);
            texels[i][c] =
                ibl_bits128_get(bits, 9, 1) ? (uint16_t)v : unit_half(v);
        }
    return 1;
}

int ibl_astc_hdr_decode_block(const unsigned char *block,
                              uint16_t texels[IBL_BLOCK_TEXELS][3])
{
    const ibl_bits128 bits = ibl_bits128_load(block);
    ibl_astc_block b;
    ends subsets[IBL_ASTC_SUBSETS];
    unsigned char value[IBL_ASTC_VALUES];

    memset(texels, 0, IBL_BLOCK_TEXELS * sizeof *texels);
    if (ibl_bits128_get(bits, 0, 9) == 0x1FC)
        return decode_void_extent(bits, texels);
    if (!ibl_astc_unpack(bits, &b))
        return 0;
    for (int i = 0; i < b.values; i++)
        value[i] = (unsigned char)ibl_ise_endpoint(b.value_range, b.value[i]);
    for (int s = 0, at = 0; s < b.subsets; s++) {
        find_ends(b.mode[s], value + at, &subsets[s]);
        at += 2 * (b.mode[s] / 4 + 1);
    }
    decode_texels(&b, subsets, texels);
    return 1;
}
