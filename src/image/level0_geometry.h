/* SPDX-License-Identifier: MIT */
/*
 * The geometry of level 0 in an eighth of the horizon.
 *
 * An octant reaches from the middle of a side face to its edge: 45 degrees of
 * azimuth psi. All eight octants have the same texels on the top face, the side
 * and the bottom, except for mirroring. With x along the face's normal and z
 * along the other axis, both >= 0, and t = tan(theta),
 *     x = t cos(psi),  z = t sin(psi)      in the plane of the top, y = 1,
 *     Y = cos(psi) / x, z / x = tan(psi)   on the side.
 * Texels lie in lines. From the pole down, line 0..half - 1 is between two
 * borders x = const of the top, half.. between two borders Y = const of the
 * side: one family of curves, cosine = q / sqrt(a^2 + q^2), q = cos(psi),
 * a = x or 1 / Y. In a line, texels follow each other in z: their borders are
 * z = const on top, meridians on the side.
 *
 * A row of the source is cut into strips by the borders of its pixels and,
 * where it touches the side, by these meridians. So only curves cut a strip.
 * The parts of a pixel always add up to the pixel: an error of a curve moves
 * light between two texels, but loses none.
 */
#ifndef IBL_IMAGE_LEVEL0_GEOMETRY_H
#define IBL_IMAGE_LEVEL0_GEOMETRY_H

#include <stdbool.h>

#include "ibl/ibl.h"
#include "image/strip_coverage.h"
#include "kern/octant_sums.h"

/* The part of a source row on one side of the equator. The south is treated as
 * the north, counted from the nadir: rows that mirror each other are cut into
 * the same spans. */
typedef struct ibl_wedge_row {
    bool south;
    ibl_coverage_row cut;
    bool top_lines, side;      /* whether it can touch the top, the side */
    int first_line, last_line; /* that it can touch, counted from its pole */
} ibl_wedge_row;

typedef struct ibl_wedge_strip {
    double cosine, sine; /* of psi where it begins */
    double width;        /* in psi, radians */
    int pixel, column;   /* column of the texel on the side, or 0 */
    int run; /* strips from here on with consecutive pixels, equal width and the
                same column */
} ibl_wedge_strip;

/* Strips of a row, in order of psi. */
typedef struct ibl_wedge_strips {
    int count;
    ibl_wedge_strip *strip; /* count + 1; the last is the end of the one before
                               it */
    int *first; /* half + 1: first strip of each column, if cut by columns */
} ibl_wedge_strips;

typedef struct ibl_wedge {
    int size;  /* n, texels along a face's edge */
    int half;  /* texel lines from a face's middle to its edge; for odd n the
                  first is half a texel wide */
    int lines; /* from pole to pole */
    int pixels;
    double *border; /* a of the upper border of line 0..2 half - 1 */
    ibl_wedge_strips plain, cut; /* cut by pixels only; by columns, too */
} ibl_wedge;

/*
 * Makes the wedge for faces of `size` texels and rows of `columns` pixels. The
 * first pixel begins `before` of its width before psi = 0. Strips must be
 * short: at least 512 columns, and pixels hardly wider or taller than a texel.
 */
ibl_status ibl_wedge_init(ibl_ctx *ctx, int size, int columns, double before,
                          ibl_wedge *w);
void ibl_wedge_free(ibl_wedge *w);

/* Finds the part of row j of `rows` on one side of the equator; false: none. */
bool ibl_wedge_row_init(const ibl_wedge *w, int rows, int j, bool south,
                        ibl_wedge_row *row);

/* A part of a wedge: texels first_z..end_z - 1 of every line. */
typedef struct ibl_wedge_part {
    int first_z, end_z;
    int ring; /* number of lines with sums at a time */
} ibl_wedge_part;

/* Lines, counted from the zenith, that neither this nor later rows touch. */
int ibl_wedge_lines_before(const ibl_wedge *w, const ibl_wedge_row *row);

/* The first slot of a texel line, counted from the zenith. A line and its
 * mirror across the equator share slots at different times. */
int ibl_wedge_slot(const ibl_wedge *w, const ibl_wedge_part *part, int line);

/* Finds the strips begin..end - 1 of a row that can touch a part. */
const ibl_wedge_strips *ibl_wedge_range(const ibl_wedge *w,
                                        const ibl_wedge_row *row,
                                        const ibl_wedge_part *part, int *begin,
                                        int *end);

enum {
    IBL_WEDGE_SPANS = 1024 /* capacity of a sink */
};

/* Collects spans and passes many at a time to full. The caller sets full, which
 * takes the spans and sets count to 0. */
typedef struct ibl_wedge_sink {
    ibl_octant_span spans[IBL_WEDGE_SPANS];
    int count;
    void (*full)(struct ibl_wedge_sink *sink);
} ibl_wedge_sink;

/* Cuts the strips begin..end - 1. */
void ibl_wedge_cut(const ibl_wedge *w, const ibl_wedge_row *row,
                   const ibl_wedge_part *part, int begin, int end,
                   ibl_wedge_sink *sink);

#endif
