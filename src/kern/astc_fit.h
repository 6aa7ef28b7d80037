/* SPDX-License-Identifier: MIT */
/* The sums over the texels of a block that its encoder spends its time on. All
 * versions give the same bits: they add in the same order. */
#ifndef IBL_KERN_ASTC_FIT_H
#define IBL_KERN_ASTC_FIT_H

#include "kern/astc_hdr.h"

/* Texels, by channels. A step on the scale q of astc_hdr_endpoints.h counts as
 * that change of light, relative to the texel's; those of other subsets count
 * as nothing. */
typedef struct ibl_astc_texels {
    _Alignas(64) float light[3][16];
    float share[16];     /* of an error's square: 1 / light^2 of the texel */
    float q[3][16];      /* less origin */
    float weight[3][16]; /* of (an error of q)^2, where it is small */
    int origin[3];
} ibl_astc_texels;

/* Where between two ends a texel may lie: at level i, 0 to count - 1. */
typedef struct ibl_astc_levels {
    int count;
    unsigned char step[32]; /* sixty-fourths of the way, growing */
    unsigned char code[32]; /* the integer that stands for it */
} ibl_astc_levels;

/* What the weighted squares of errors in q are, for ends e0 and e1:
 * aa e0^2 + 2 ab e0 e1 + bb e1^2 - 2 a e0 - 2 b e1 + what they are without. */
typedef struct ibl_astc_sums {
    float aa, ab, bb, a, b;
} ibl_astc_sums;

enum {
    IBL_ASTC_PATTERNS = 27,
    IBL_ASTC_PATTERNS_PADDED = 32
};

typedef struct ibl_astc_fit_dsp {
    /* How far each texel is between the ends, in [0, 1], by the place nearest
     * to it on the line. The ends are less t->origin. */
    void (*project)(const ibl_astc_texels *t, const float ends[2][3],
                    float s[16]);
    /* The sums of each channel for texels at s. */
    void (*sums)(const ibl_astc_texels *t, const float s[16],
                 ibl_astc_sums sums[3]);
    /* Squares of errors of texels that are steps/64 between the ends, as
     * decoded; ends are of 16 bits. */
    float (*error)(const ibl_astc_texels *t, const int ends[2][3],
                   const int steps[16]);
    /* The same of the texels that BC6H has between such ends. */
    float (*error_bc6h)(const ibl_astc_texels *t, const int ends[2][3],
                        const int steps[16]);
    /*
     * For each pattern how well its two subsets are told apart: the sum, over
     * both, of |sum of points|^2 / texels.
     *   second  1 for the texels of the second subset, by texels
     *   count   texels of it
     */
    void (*split)(const float points[3][16],
                  const float second[16][IBL_ASTC_PATTERNS_PADDED],
                  const float count[IBL_ASTC_PATTERNS_PADDED],
                  float gain[IBL_ASTC_PATTERNS_PADDED]);
    /*
     * How much less the weighted squares are with texels at the levels of an
     * earlier block, between the best ends, than with one colour.
     *   places  of texels between the ends, for each of count blocks; there
     *           are as many as gain has
     */
    void (*match)(const ibl_astc_texels *t,
                  const float places[16][IBL_ASTC_PAST], int count,
                  float gain[IBL_ASTC_PAST]);
} ibl_astc_fit_dsp;

/* Sets x to the weighted distances of a channel's texels from their mean;
 * returns 1 / the sum of the weights, or 0. */
static inline float ibl_astc_centre(const ibl_astc_texels *t, int c,
                                    float x[16])
{
    float all = 0, sum = 0;
    for (int i = 0; i < 16; i++) {
        all += t->weight[c][i];
        sum += t->weight[c][i] * t->q[c][i];
    }
    const float inverse = all > 0 ? 1 / all : 0;
    for (int i = 0; i < 16; i++)
        x[i] = t->weight[c][i] * (t->q[c][i] - sum * inverse);
    return inverse;
}

/* encode_alike of ibl_astc_hdr_dsp with a version of these functions; past
 * NULL: encode. */
void ibl_astc_hdr_encode(const ibl_astc_fit_dsp *fit, const float *texels,
                         size_t count, ibl_quality quality, ibl_astc_past *past,
                         unsigned char *blocks);

#endif
