/* SPDX-License-Identifier: MIT */
/* The verdicts of a set of files as a table, as JSON and as an image. */
#ifndef CLI_JUDGE_REPORT_H
#define CLI_JUDGE_REPORT_H

#include <jansson.h>
#include <stdio.h>

#include "cli/judge.h"

enum {
    IBL_REPORT_ROWS = 2 * IBL_MAX_LEVELS + 1
};

typedef struct ibl_report {
    ibl_judge_options options;
    int count;
    ibl_verdict rows[IBL_REPORT_ROWS];
    bool has_lut;
    ibl_lut_verdict lut;
} ibl_report;

/* Judges a level and adds the verdict. False: as for ibl_judge_create. */
bool ibl_report_add(ibl_report *report, ibl_judge *judge,
                    const ibl_judge_level *level);
void ibl_report_free(ibl_report *report);

/* Whether all values are finite, and every nRMSE and the table's largest error
 * are at most max_error (NAN: no limit). If not, writes the reason to why, in
 * one line. */
bool ibl_report_passes(const ibl_report *report, double max_error, char *why,
                       size_t size);

void ibl_report_print(const ibl_report *report, FILE *to);
/* {"texels": .., "seed": .., "levels": [..], "lut": {..}}; NULL: no memory. */
json_t *ibl_report_json(const ibl_report *report);

/* Least cells along a face's edge with a judged texel each, for a heat map. */
enum {
    IBL_HEATMAP_GRID = 16
};

/*
 * Draws the errors as a PNG file: each judged level as an unfolded cube, a
 * pixel showing the relative error of the nearest judged texel, and the colour
 * scale below. The caller must free *png. False: no memory.
 */
bool ibl_heatmap_png(const ibl_report *report, void **png, size_t *size);

#endif
