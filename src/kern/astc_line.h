/* SPDX-License-Identifier: MIT */
/* The texels of a block as an encoder sees them, and the line through those of
 * a subset. */
#ifndef IBL_KERN_ASTC_LINE_H
#define IBL_KERN_ASTC_LINE_H

#include "kern/astc_ways.h"

/* Of 16 texels of 3 floats; and those of a subset, 0 or 1, of a pattern. */
void ibl_astc_load(const float *texels, ibl_astc_texels *t);
void ibl_astc_take(const ibl_astc_tables *tb, const ibl_astc_texels *all,
                   int pattern, int subset, ibl_astc_texels *t);

/* The line of a mode without quantisation: its ends, less origin, with the
 * texels between them. */
void ibl_astc_find_line(const ibl_astc_tables *tb, const ibl_astc_texels *t,
                        int mode, float ends[2][3]);

/*
 * The best line near one without quantisation.
 *   rounds       at most, of fitting ends to weights and weights to ends
 *   best->error  of its texels; of a block of one subset this and the error as
 *                BC6H, by ibl_astc_both. FLT_MAX if there is none
 */
void ibl_astc_fit_line(const ibl_astc_tables *tb, const ibl_astc_texels *t,
                       const ibl_astc_way *w, int rounds,
                       const float from[2][3], ibl_astc_line *best);

/* The line of a block of one subset with texels at given levels, if its error
 * is less than best's. */
void ibl_astc_fit_levels(const ibl_astc_tables *tb, const ibl_astc_texels *t,
                         const ibl_astc_way *w, const unsigned char level[16],
                         ibl_astc_line *best);

/* What counts, of a block and of it as BC6H, which most GPUs of desktops
 * sample. Not less than the former: it is to be better than one colour. */
static inline float ibl_astc_both(float error, float as_bc6h)
{
    return as_bc6h > error ? 0.7f * error + 0.3f * as_bc6h : error;
}

#endif
