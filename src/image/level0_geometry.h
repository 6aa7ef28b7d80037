/* SPDX-License-Identifier: MIT */
/*
 * The geometry of level 0 in an eighth of the horizon.
 *
 * From the middle of a side face to its edge, 45 degrees of azimuth psi, the
 * texels of the top face, the side and the bottom lie the same way in all
 * eight octants, but for mirrors. With x along the face's normal and z along
 * the other axis, both >= 0, and t = tan(theta),
 *     x = t cos(psi),  z = t sin(psi)      in the plane of the top, y = 1,
 *     Y = cos(psi) / x, z / x = tan(psi)   on the side.
 * Texels lie in lines. From the pole down, line 0..half - 1 is between two
 * borders x = const of the top, half.. between two borders Y = const of the
 * side: one family of curves, cosine = q / sqrt(a^2 + q^2), q = cos(psi),
 * a = x or 1 / Y. In a line, texels follow each other in z: their borders are
 * z = const on top, meridians on the side.
 *
 * A row of the source is cut into strips by its pixels' borders and, where
 * there is a side, by those meridians, so that within a strip only curves are
 * left to cut it. Whatever the curves, a pixel's parts add up to the pixel:
 * what one texel loses the other gains.
 */
#ifndef IBL_IMAGE_LEVEL0_GEOMETRY_H
#define IBL_IMAGE_LEVEL0_GEOMETRY_H

#include <stdbool.h>

#include "ibl/ibl.h"
#include "image/strip_coverage.h"
#include "kern/octant_sums.h"

/* A row of the source between two borders and not across the equator. South of
 * it all is as in the north, counted from the nadir: rows that mirror each
 * other are cut into the same spans. */
typedef struct ibl_wedge_row {
    bool south;
    ibl_coverage_row cut; /* cosines and tangents of the borders */
    double top_cot, bottom_cot;
    bool top_lines, side;      /* which texels it can touch */
    int first_line, last_line; /* that it can touch, from its pole on */
} ibl_wedge_row;

/* Strips of a row, in order of psi. */
typedef struct ibl_wedge_strips {
    int count;
    double *cosine, *sine, *secant; /* of psi: count + 1 borders */
    double *width;                  /* count, in psi */
    int *pixel, *column;            /* count; the texel on the side, or 0 */
    int *run;   /* count: the first strip that does not go on with this one as
                   the next pixel, as wide, of the same column */
    int *first; /* half + 1: of each column, if cut by them */
} ibl_wedge_strips;

typedef struct ibl_wedge {
    int size;  /* n */
    int half;  /* texel lines from a face's middle to its edge; with n odd the
                  first one is half a texel wide */
    int lines; /* from pole to pole */
    int pixels;
    double *border; /* a of the upper border of line 0..2 half - 1 */
    ibl_wedge_strips plain, cut; /* by pixels alone; by columns, too */
} ibl_wedge;

/*
 * For faces of size, rows of columns pixels; the first pixel begins `before`
 * of its width before psi = 0. The longest strip must be short: 512 columns or
 * more, and no pixel much wider or taller than a texel.
 */
ibl_status ibl_wedge_init(ibl_ctx *ctx, int size, int columns, double before,
                          ibl_wedge *w);
void ibl_wedge_free(ibl_wedge *w);

/* The part of row j of `rows` on one side of the equator; false: none. */
bool ibl_wedge_row_init(const ibl_wedge *w, int rows, int j, bool south,
                        ibl_wedge_row *row);

/* A part of a wedge: the texels first_z..end_z - 1 of every line. */
typedef struct ibl_wedge_part {
    int first_z, end_z;
    int ring; /* lines that have sums at a time */
} ibl_wedge_part;

/* Lines, from the zenith on, that neither this row nor one after it touches. */
int ibl_wedge_lines_before(const ibl_wedge *w, const ibl_wedge_row *row);

/* Where sums of a texel line, from the zenith on, begin: in slots. A line and
 * its mirror across the equator have the same ones, but not at the same time.
 */
int ibl_wedge_slot(const ibl_wedge *w, const ibl_wedge_part *part, int line);

/* Strips of a row that can hold something of a part: begin..end - 1. */
const ibl_wedge_strips *ibl_wedge_range(const ibl_wedge *w,
                                        const ibl_wedge_row *row,
                                        const ibl_wedge_part *part, int *begin,
                                        int *end);

enum {
    IBL_WEDGE_SPANS = 1024 /* that a sink collects */
};

/* Collects spans and hands them on, many at a time. full is the caller's to
 * set: it takes the spans and sets count to 0. */
typedef struct ibl_wedge_sink {
    ibl_octant_span spans[IBL_WEDGE_SPANS];
    int count;
    void (*full)(struct ibl_wedge_sink *sink);
    double *zone; /* the caller's work space: two for every strip */
} ibl_wedge_sink;

/* Cuts the strips; pixels are counted from that of strip begin. */
void ibl_wedge_cut(const ibl_wedge *w, const ibl_wedge_row *row,
                   const ibl_wedge_part *part, int begin, int end,
                   ibl_wedge_sink *sink);

#endif
