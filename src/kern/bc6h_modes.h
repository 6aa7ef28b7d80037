/* SPDX-License-Identifier: MIT */
/* The tables of BC6H, for the decoder and the encoder, and what both compute
 * from them. */
#ifndef IBL_KERN_BC6H_MODES_H
#define IBL_KERN_BC6H_MODES_H

#include <stdbool.h>
#include <stdint.h>

enum {
    IBL_BC6H_MODES = 14,
    IBL_BC6H_ONE_REGION = 10, /* the first such mode in the table */
    IBL_BC6H_RUNS = 23,       /* at most, of a mode */
    IBL_BC6H_PARTITIONS = 32, /* of blocks of two regions */
    IBL_BC6H_ENDPOINTS = 4    /* two of each region */
};

/* Bits of a header that follow each other: bits `from` to `to`, in this order,
 * of value 3 * endpoint + channel. */
typedef struct ibl_bc6h_run {
    unsigned char value, from, to;
} ibl_bc6h_run;

/*
 * A block is, from its lowest bit: the mode's number, the endpoints' header
 * bits, the partition (two regions only), the indices. An index has 3 bits with
 * two regions, else 4; the highest bit of that of a region's anchor is left
 * out, since it is 0.
 */
typedef struct ibl_bc6h_mode {
    unsigned char number;        /* 2 bits if below 2, else 5 */
    unsigned char regions;       /* 1 or 2 */
    unsigned char bits;          /* of the first endpoint */
    unsigned char other_bits[3]; /* of the others' R, G, B */
    bool deltas;                 /* the others are differences to the first */
    ibl_bc6h_run runs[IBL_BC6H_RUNS];
} ibl_bc6h_mode;

/* Modes of two regions, then those of one, each from the finest endpoints to
 * the coarsest, which is also from the least range of differences on. */
extern const ibl_bc6h_mode ibl_bc6h_modes[IBL_BC6H_MODES];

/* Bit i: texel i is in the second region. The first region's anchor is texel
 * 0, the second's is in the other table. */
extern const uint16_t ibl_bc6h_partitions[IBL_BC6H_PARTITIONS];
extern const unsigned char ibl_bc6h_anchors[IBL_BC6H_PARTITIONS];

/* 64ths of the second endpoint in the colour of an index of 3 and of 4 bits. */
extern const unsigned char ibl_bc6h_weights[2][16];

/* Header bits of a mode's endpoints. */
static inline int ibl_bc6h_header_bits(const ibl_bc6h_mode *mode)
{
    return (mode->regions == 1 ? 65 : 77) - (mode->number < 2 ? 2 : 5);
}

/* The value of 0..65535 that q of some bits, unsigned, stands for. */
static inline int ibl_bc6h_unquantise(int q, int bits)
{
    if (bits == 16 || q == 0)
        return q;
    return q == (1 << bits) - 1 ? 0xFFFF : ((q << 16) + 0x8000) >> bits;
}

/* The half between two such values, weight 64ths from the first. */
static inline int ibl_bc6h_half(int first, int second, int weight)
{
    return ((first * (64 - weight) + second * weight + 32) >> 6) * 31 >> 6;
}

#endif
