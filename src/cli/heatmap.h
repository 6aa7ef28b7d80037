/* SPDX-License-Identifier: MIT */
#ifndef CLI_HEATMAP_H
#define CLI_HEATMAP_H

#include "cli/judge_report.h"

/* Cells along a face's edge in which at least one texel should be judged. */
enum {
    IBL_HEATMAP_GRID = 16
};

/*
 * Where the error sits, as a PNG file: each judged level as an unfolded cube
 * whose pixels have the relative error of the nearest judged texel, and the
 * scale of the colours below. *png is the caller's to free. False: no memory.
 */
bool ibl_heatmap_png(const ibl_report *report, void **png, size_t *size);

#endif
