/* SPDX-License-Identifier: MIT */
/*
 * The eight octants of the horizon, and the sums of their texels on the way
 * into the cube. Octant k reaches from the middle of a side face, psi = 0, to
 * its edge; phi grows along psi in the even ones. Those that see the map's
 * pixels in the same places share one geometry (image/level0_geometry.h) and
 * are the lanes of one set of sums: all eight of them if the yaw is a multiple
 * of half a pixel and the width one of four, else fewer.
 */
#ifndef IBL_IMAGE_LEVEL0_OCTANTS_H
#define IBL_IMAGE_LEVEL0_OCTANTS_H

#include <stddef.h>

#include "ibl/ibl.h"
#include "image/cube.h"
#include "image/level0_geometry.h"

/* Spans of a part's northern rows, kept for their mirrors in the south: of so
 * many rows, from the pole on, as there is room for. */
typedef struct ibl_octant_spans {
    ibl_octant_span *span;
    int count, room;
    int *begin; /* where those of each row do: rows + 1 */
    int rows;
} ibl_octant_spans;

/* Sums of a part of a wedge, of its part.ring latest lines. */
typedef struct ibl_octant_sums {
    ibl_wedge_part part;
    double *sums;    /* IBL_OCTANT_RGB for each slot */
    double *weights; /* one for each slot */
    int written;     /* lines before this one are in the cube */
    ibl_octant_spans kept;
} ibl_octant_sums;

enum {
    IBL_OCTANT_PARTS = 8
};

typedef struct ibl_octant_group {
    ibl_wedge wedge;
    int octants; /* 1..IBL_OCTANTS; other lanes repeat the first */
    int octant[IBL_OCTANTS];
    int *column; /* IBL_OCTANTS for each pixel of the wedge: columns, or their
                    offsets in floats */
    int parts;
    ibl_octant_sums sums[IBL_OCTANT_PARTS];
    ibl_octant_span *kept; /* room for the spans of all parts */
    double *shared;        /* sums of texels that are of two octants or more */
} ibl_octant_group;

typedef struct ibl_octant_set {
    int groups;
    ibl_octant_group group[IBL_OCTANTS];
    int of[IBL_OCTANTS], lane[IBL_OCTANTS]; /* group and lane of an octant */
    ibl_octants_dsp dsp;
    ibl_octant_place place[IBL_OCTANTS][3];
} ibl_octant_set;

/* For rows of columns pixels, rows of them, into level 0 of a cube. */
ibl_status ibl_octants_init(ibl_ctx *ctx, const ibl_cube *cube, int columns,
                            int rows, double yaw_deg, bool offsets,
                            ibl_octant_set *set);
void ibl_octants_free(ibl_octant_set *set);

/* Writes the lines before `line` of a part, which no row will touch again. */
void ibl_octants_finish(const ibl_octant_set *set, ibl_octant_group *g,
                        int part, int line);
/* Writes what octants share, after all lines. */
void ibl_octants_join(const ibl_octant_set *set);

#endif
