/* SPDX-License-Identifier: MIT */
/*
 * Scalar products of the lobes of a chain, weighted by what photographs show.
 *
 * For a map whose harmonics of degree l have the mean power C_l, of
 * photographs l^-1.5, the mean square, over all rotations of the map, of what a
 * function f of the sphere sees of it is <f, f>, with
 *     <f, g> = sum over l, m of C_l f_lm g_lm.
 * For zonal lobes a about d and b about d', c = d.d',
 *     <a, b> = sum over l of (2 l + 1) / 4 pi C_l k_a(l) k_b(l) P_l(c),
 * a function of one angle; k_b = 1 gives that of a point. Lobes are compared at
 * equal energy: C_0 has no effect and is left out.
 */
#ifndef IBL_BAKE_LOBE_KERNELS_H
#define IBL_BAKE_LOBE_KERNELS_H

#include <stddef.h>

#include "core/half.h"
#include "ibl/ibl.h"

enum {
    IBL_LOBE_BITS = 4,     /* log2 of rows in an octave */
    IBL_LOBE_OCTAVES = 20, /* of the tables: from 2^-20 to 1 */
    IBL_LOBE_ROWS = (IBL_LOBE_OCTAVES << IBL_LOBE_BITS) + 2,
    IBL_LOBE_SLOTS = 16,   /* in a row, one for each lobe */
    IBL_LOBE_DIFFUSE = 15, /* slot of the cosine lobe: irradiance */
    IBL_LOBE_DEGREE = 512
};

/* A chain of one level counts as two equal ones. Row i is for q =
 * ibl_lobe_row_at(i), a quarter of the squared chord of the two directions;
 * slot a is level a. */
typedef struct ibl_lobe_kernels {
    ibl_specular_layout layout;
    float *point;   /* <a, point> */
    float *same;    /* <a, a> */
    float *next;    /* <a, a + 1> */
    float *diffuse; /* <a, cosine> */
    double *lobe;   /* k_l of each level and, last, of the cosine: see
                       ibl_lobe_of */
} ibl_lobe_kernels;

/*
 *   layout  of a chain of GGX lobes
 * To be freed with ibl_lobe_kernels_free, also after an error.
 */
ibl_status ibl_lobe_kernels_make(ibl_ctx *ctx,
                                 const ibl_specular_layout *layout,
                                 ibl_lobe_kernels *out);
void ibl_lobe_kernels_free(ibl_lobe_kernels *k); /* zeroed is fine */

/* k_l, l = 0..IBL_LOBE_DEGREE, of a level, or of the cosine: level is then the
 * number of levels. */
static inline const double *ibl_lobe_of(const ibl_lobe_kernels *k, int level)
{
    return k->lobe + (size_t)level * (IBL_LOBE_DEGREE + 1);
}

/* A place in the tables, between two rows. */
typedef struct ibl_lobe_place {
    size_t row; /* in floats */
    float t;
} ibl_lobe_place;

/* q + 2^-octaves is a float whose exponent and first bits are the row. */
static inline float ibl_lobe_row_at(int row)
{
    const uint32_t first = (127u - IBL_LOBE_OCTAVES) << IBL_LOBE_BITS;
    const uint32_t bits = (first + (uint32_t)row) << (23 - IBL_LOBE_BITS);
    return ibl_float_of(bits) - 1.0f / (1 << IBL_LOBE_OCTAVES);
}

/* q in 0..1. */
static inline ibl_lobe_place ibl_lobe_place_of(float q)
{
    const uint32_t first = (127u - IBL_LOBE_OCTAVES) << IBL_LOBE_BITS;
    const int shift = 23 - IBL_LOBE_BITS;
    const uint32_t bits = ibl_bits_of(q + 1.0f / (1 << IBL_LOBE_OCTAVES));
    return (ibl_lobe_place){IBL_LOBE_SLOTS * (size_t)((bits >> shift) - first),
                            (float)(int)(bits & ((1u << shift) - 1)) *
                                (1.0f / (1 << shift))};
}

static inline float ibl_lobe_at(const float *table, ibl_lobe_place p, int slot)
{
    const float *f = table + p.row + slot;
    return f[0] + p.t * (f[IBL_LOBE_SLOTS] - f[0]);
}

#endif
