/* SPDX-License-Identifier: MIT */
/*
 * The eight octants of the horizon, and the sums of their texels before they
 * are written to the cube. Octant k reaches from the middle of a side face,
 * psi = 0, to its edge; phi grows along psi in the even ones. Octants whose
 * pixels have the same positions share one geometry (image/level0_geometry.h)
 * and are the lanes of one set of sums: all eight if the yaw is a multiple of
 * half a pixel and the width a multiple of four, else fewer.
 */
#ifndef IBL_IMAGE_LEVEL0_OCTANTS_H
#define IBL_IMAGE_LEVEL0_OCTANTS_H

#include <stddef.h>

#include "ibl/ibl.h"
#include "image/cube.h"
#include "image/level0_geometry.h"

/* Sums of a part of a wedge for its latest part.ring lines. */
typedef struct ibl_octant_sums {
    ibl_wedge_part part;
    double *sums;    /* IBL_OCTANT_RGB for each slot */
    double *weights; /* one for each slot */
    int written;     /* lines before this one are in the cube */
    /* Spans of northern rows for their mirrors in the south: of the first rows
     * from the pole, as many as fit, each followed by their number. */
    ibl_octant_span *kept;
    int kept_rows, kept_spans, room;
} ibl_octant_sums;

enum {
    IBL_OCTANT_PARTS = 8
};

typedef struct ibl_octant_group {
    ibl_wedge wedge;
    int octants; /* 1..IBL_OCTANTS; unused lanes repeat the first */
    int octant[IBL_OCTANTS];
    int *column; /* IBL_OCTANTS for each pixel of the wedge: its columns, or
                    their offsets in floats */
    int parts;
    ibl_octant_sums sums[IBL_OCTANT_PARTS];
    double *shared; /* sums of texels in two octants or more */
} ibl_octant_group;

typedef struct ibl_octant_set {
    int groups;
    ibl_octant_group group[IBL_OCTANTS];
    int of[IBL_OCTANTS], lane[IBL_OCTANTS]; /* group and lane of each octant */
    ibl_octants_dsp dsp;
    ibl_octant_place place[IBL_OCTANTS][3];
} ibl_octant_set;

/* Prepares level 0 of a cube from `rows` rows of `columns` pixels. */
ibl_status ibl_octants_init(ibl_ctx *ctx, const ibl_cube *cube, int columns,
                            int rows, double yaw_deg, bool offsets,
                            ibl_octant_set *set);
void ibl_octants_free(ibl_octant_set *set);

/* Writes the lines of a part before `line`; no later row may touch them. */
void ibl_octants_finish(const ibl_octant_set *set, ibl_octant_group *g,
                        int part, int line);
/* Writes the texels that octants share, after all lines. */
void ibl_octants_join(const ibl_octant_set *set);

#endif
