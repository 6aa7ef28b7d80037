/* SPDX-License-Identifier: MIT */
/*
 * Sums over arcs of an equirectangular row: what lies above a horizon is one
 * interval of each row's columns, and prefix sums give any interval at once.
 */
#ifndef IBL_KERN_ARC_H
#define IBL_KERN_ARC_H

#include <stddef.h>

#include "ibl/ibl.h"

/* One record: the x, then the z, then the y component of the sum of L d dO,
 * for L = R, G, B and the constant 1. */
#define IBL_ARC_LANES 12

/* Prefix sums of some rows: of each row width + 1 records, record i the sum
 * over its first i columns. */
typedef struct ibl_arc_rows {
    const double *sums;
    int rows, width;
} ibl_arc_rows;

typedef struct ibl_arc_dsp {
    /*
     * Writes the width + 1 records of one row.
     *   rgb    its pixels
     *   turn   cos(phi), sin(phi) of each column's centre
     *   level  sin(theta) dO of its pixels, rise: cos(theta) dO
     */
    void (*prefix)(const float *rgb, int width, const double *turn,
                   double level, double rise, double *sums);
    /*
     * Adds to sum, of each row, the columns whose centres are within half[row]
     * columns of centre, around the seam where it falls so.
     *   centre  in columns from the left edge, 0 <= centre < width
     *   half    at most width / 2; 0 or less: none; INFINITY: the whole row
     */
    void (*add)(const ibl_arc_rows *rows, double centre, const double *half,
                double sum[IBL_ARC_LANES]);
} ibl_arc_dsp;

/* isa: what the context uses, not IBL_ISA_AUTO. */
void ibl_arc_dsp_init(ibl_arc_dsp *dsp, ibl_isa isa);

void ibl_arc_prefix_c(const float *rgb, int width, const double *turn,
                      double level, double rise, double *sums);
void ibl_arc_add_c(const ibl_arc_rows *rows, double centre, const double *half,
                   double sum[IBL_ARC_LANES]);
void ibl_arc_prefix_avx2(const float *rgb, int width, const double *turn,
                         double level, double rise, double *sums);
void ibl_arc_add_avx2(const ibl_arc_rows *rows, double centre,
                      const double *half, double sum[IBL_ARC_LANES]);

#endif
