/* SPDX-License-Identifier: MIT */
/*
 * The last step of a spectral level: from samples on rings to texels, by 8 x 8
 * samples around each texel's centre. The same pass adds the other parts of a
 * texel. Rings are held in bands, so that a level needs a few MiB at any
 * degree.
 */
#ifndef IBL_BAKE_SPECTRAL_RESAMPLE_H
#define IBL_BAKE_SPECTRAL_RESAMPLE_H

#include <stddef.h>

#include "bake/spectral/point_lights.h"
#include "ibl/ibl.h"
#include "kern/interp.h"

enum {
    IBL_GRID_BORDER = 4 /* columns and rings around a band */
};

/* Samples a wave of the field's degree on the equator and along a meridian; see
 * kern/interp_simd.c. */
#define IBL_GRID_SAMPLES 2.2

/*
 * Samples of a function on the sphere: ring j at theta = pi (j + 1/2) / rings
 * from +Y, column i at phi = 2 pi (i + 1/2) / columns - pi in the world's
 * axes. Held are two bands, the rings first..first + pairs - 1 of each
 * hemisphere, counted from its pole. Around them is a border: columns go on
 * around the ring, rings beyond the pole are those before it half a turn away,
 * and beyond the equator are those of the other hemisphere.
 */
typedef struct ibl_ring_grid {
    int rings;   /* even, 2..IBL_MAX_EDGE */
    int columns; /* a power of two, 4..IBL_MAX_EDGE */
    int first, pairs;
    size_t stride, band; /* floats from ring to ring, and to the south's */
    float *data;         /* 4 floats a sample, 64-byte aligned */
} ibl_ring_grid;

/* The grid of a level of a degree, in bands, without data. Columns are a power
 * of two, and many enough but at the equator if they are just above two a
 * wave. */
ibl_ring_grid ibl_ring_grid_for(int degree);

/* Allocates a grid for at most `pairs` pairs at a time, contents undefined. It
 * is empty after an error. Free with ibl_ring_grid_free. */
ibl_status ibl_ring_grid_alloc(ibl_ctx *ctx, int rings, int columns, int pairs,
                               ibl_ring_grid *grid);
void ibl_ring_grid_free(ibl_ring_grid *grid); /* zeroed is fine */

/* Column 0 of a ring of a hemisphere, south or not, first - IBL_GRID_BORDER
 * to first + pairs + IBL_GRID_BORDER - 1; 64-byte aligned. */
static inline float *ibl_ring_grid_at(const ibl_ring_grid *grid, int south,
                                      int ring)
{
    return grid->data + (south ? grid->band : 0) +
           (size_t)(ring - grid->first + IBL_GRID_BORDER) * grid->stride +
           4 * IBL_GRID_BORDER;
}

/* Fills the part of the border that comes from a ring. Call it when the ring is
 * written, for all from max(first - IBL_GRID_BORDER, 0) to
 * min(first + pairs + IBL_GRID_BORDER, rings / 2) - 1 of both hemispheres. */
void ibl_ring_grid_close(const ibl_ring_grid *grid, int south, int ring);

/*
 * The parts of a level: at each texel's centre d, in each channel
 *     clamp(offset + gain (field(d) + lights(d))).
 */
typedef struct ibl_level_sum {
    const ibl_ring_grid *grid;      /* the field */
    const ibl_point_lights *bright; /* NULL: no lights */
    ibl_interp_range range;         /* gain a power of two; low may be
                                       -INFINITY, high INFINITY; NaN becomes
                                       low */
    int (*reach)[2]; /* NULL, or for each tile of IBL_LEVEL_TILE texels of a row
                        the rings that it needs: filled with the first band */
} ibl_level_sum;

enum {
    IBL_LEVEL_TILE = 64
};

/*
 * Writes the texels between the rings of the bands, of a level of cube, of any
 * projection and edge. Runs on ctx's pool. Nothing but rounding keeps constants
 * from staying constant: weights sum to 1. IBL_ERR_MEMORY, IBL_ERR_CANCELLED:
 * the level is unspecified. The same bytes for any number of threads.
 */
ibl_status ibl_spectral_texels(ibl_ctx *ctx, const ibl_level_sum *sum,
                               const ibl_cube *cube, int level);

#endif
