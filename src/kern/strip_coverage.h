/* SPDX-License-Identifier: MIT */
/*
 * How a border of texels cuts a strip of a row of pixels: the shares of many
 * strips at once. All versions give the same bytes.
 *
 * With psi an azimuth, q = cos(psi), r = sin(psi), every border is
 *     cosine(theta) = q / sqrt(a^2 + q^2),
 * which falls as psi grows to 90 degrees. (One that rises falls from the other
 * end: with q and r, and the strip's ends, exchanged.) It crosses cosine(theta)
 * where q = a / tan(theta).
 */
#ifndef IBL_KERN_STRIP_COVERAGE_H
#define IBL_KERN_STRIP_COVERAGE_H

#include "ibl/ibl.h"
#include "kern/isa.h"

enum {
    IBL_COVERAGE_PAD = 8 /* arrays are a multiple of so many long */
};

/* A row of pixels between two angles theta up to 90 degrees. */
typedef struct ibl_coverage_row {
    double top, bottom;         /* cosines, top > bottom */
    double top_tan, bottom_tan; /* 0 to infinite */
} ibl_coverage_row;

/* Strips and a border of each. The strip is from psi[0] to psi[1] > psi[0], at
 * most 0.02 apart. */
typedef struct ibl_coverage_cuts {
    double *a;
    double *q[2], *r[2];
    double *width; /* psi[1] - psi[0] */
} ibl_coverage_cuts;

typedef struct ibl_coverage_dsp {
    /*
     * share[i] = the part of strip i of a row above its border, 0..1. Within
     * the row a border is taken as straight but for its bow, which makes the
     * area right to fourth order (Hermite's end correction of the trapezium
     * rule). Arrays are read and written up to the next multiple of
     * IBL_COVERAGE_PAD.
     */
    void (*share)(const ibl_coverage_row *row, const ibl_coverage_cuts *cuts,
                  int count, double *share);
} ibl_coverage_dsp;

IBL_DECLARE_KERNEL(ibl_coverage);

#endif
