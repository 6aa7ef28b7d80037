/* SPDX-License-Identifier: MIT */
/* The choice of an endpoint mode's values: those of a form that bring the
 * squares of errors lowest, with each texel staying where it is on the line. */
#ifndef IBL_KERN_ASTC_QUANTISE_H
#define IBL_KERN_ASTC_QUANTISE_H

#include "kern/astc_fit.h"

enum {
    IBL_ASTC_NO_CODE = -1
};

/* Of values in a range: the integers that stand for them, or IBL_ASTC_NO_CODE.
 */
typedef struct ibl_astc_codes {
    signed short of[256];
} ibl_astc_codes;

void ibl_astc_set_codes(int range, ibl_astc_codes *codes);

/* The best ends of a mode, less origin, without quantisation. */
void ibl_astc_solve(int mode, const ibl_astc_sums sums[3], float ends[2][3]);

/* The squares for ends, less what they are without. */
static inline float ibl_astc_cost(const ibl_astc_sums *s, float e0, float e1)
{
    return e0 * (s->aa * e0 + 2 * (s->ab * e1 - s->a)) +
           e1 * (s->bb * e1 - 2 * s->b);
}

/*
 * Sets values, 4 or 6 of them, 0 to 255, for a form of the mode, near ends,
 * which are what solve has found. False: there are none.
 *   ends  the second has the largest value of any channel
 */
int ibl_astc_quantise(int mode, const ibl_astc_sums sums[3],
                      const float ends[2][3], const int origin[3], int form,
                      const ibl_astc_codes *codes, unsigned char values[6]);

#endif
