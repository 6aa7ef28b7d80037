/* SPDX-License-Identifier: MIT */
/*
 * The last step of a spectral level: from samples on rings to the texels of a
 * cube, by 8 x 8 samples around each texel's centre (interp_weights.h). The
 * same pass adds the other parts of a texel.
 *
 * Weights are made for the field's spectrum. Errors follow from it and from the
 * samples per wave at the field's degree: on the equator columns / degree,
 * along a meridian 2 rings / degree. Rms error in each of the two directions,
 * relative to the field:
 *
 *     samples a wave            2.2     2.5     3       4       5
 *     exponential, 1e-5 there   3.5e-5  1.4e-5  3.6e-6  3.9e-7  7e-8
 *     exponential, 1e-7 there   3.1e-6  1.2e-6  2.9e-7  3e-8    1e-8
 *     Gaussian,    1e-5 there   1.5e-4  5.5e-5  1.3e-5  1.3e-6  2.2e-7
 *     as strong as everywhere   6e-2    1.7e-2  3.0e-3  2.3e-4  3.3e-5
 *
 * The rounding of floats adds about 1e-7 of the largest values around.
 */
#ifndef IBL_BAKE_SPECTRAL_RESAMPLE_H
#define IBL_BAKE_SPECTRAL_RESAMPLE_H

#include <stddef.h>

#include "bake/spectral/point_lights.h"
#include "ibl/ibl.h"
#include "kern/interp.h"

enum {
    IBL_GRID_BORDER = 4 /* columns and rings around a grid */
};

/*
 * Samples of a function on the sphere: ring j at theta = pi (j + 1/2) / rings
 * from +Y, column i at phi = 2 pi (i + 1/2) / columns - pi in the world's
 * axes. Around them a border: columns go on around the ring, rings beyond a
 * pole are those before it half a turn away, as the function is.
 */
typedef struct ibl_ring_grid {
    int rings;     /* 1..IBL_MAX_EDGE */
    int columns;   /* a power of two, 4..IBL_MAX_EDGE */
    size_t stride; /* floats from ring to ring, a multiple of 16 */
    float *data;   /* 4 floats a sample, 64-byte aligned, borders included */
} ibl_ring_grid;

/*
 * Allocates a grid, contents undefined. It is empty after an error. Free with
 * ibl_ring_grid_free.
 */
ibl_status ibl_ring_grid_alloc(ibl_ctx *ctx, int rings, int columns,
                               ibl_ring_grid *grid);
void ibl_ring_grid_free(ibl_ring_grid *grid); /* zeroed is fine */

/* Column 0 of a ring, -IBL_GRID_BORDER..rings + IBL_GRID_BORDER - 1; 64-byte
 * aligned. */
static inline float *ibl_ring_grid_at(const ibl_ring_grid *grid, int ring)
{
    return grid->data + (size_t)(ring + IBL_GRID_BORDER) * grid->stride +
           4 * IBL_GRID_BORDER;
}

/*
 * Fills the part of the border that comes from rings first..first + count - 1.
 * Call it when these are written, best from the same job, while they are in the
 * cache. The border is complete when this was done for every ring.
 */
void ibl_ring_grid_close(const ibl_ring_grid *grid, int first, int count);

/*
 * Rms error of interpolating a field of that spectrum (see ibl_level_sum),
 * relative to the field without its mean: the table above for any spectrum and
 * grid. Takes 30 us.
 */
double ibl_ring_grid_error(const double *spectrum, int degree, int rings,
                           int columns);

/*
 * The parts of a level: at each texel's centre d, in each channel
 *     clamp(offset + gain (field(d) + lights(d))).
 */
typedef struct ibl_level_sum {
    const ibl_ring_grid *grid; /* the field, borders filled */
    const double *spectrum;    /* its amplitude at degrees 0..degree, in any
                                  unit (the lobe's k_l); NULL: falling
                                  exponentially to 1e-5 at degree */
    int degree;                /* of the field, >= 0 */
    const ibl_point_lights *bright; /* NULL: no lights */
    ibl_interp_range range;         /* gain a power of two; low may be
                                       -INFINITY, high INFINITY; NaN becomes
                                       low */
} ibl_level_sum;

/*
 * Writes every texel of a level of cube, of any projection and edge. Runs on
 * ctx's pool and reports progress under stage (NULL: silently). Nothing but
 * rounding keeps constants from staying constant: weights sum to 1.
 * IBL_ERR_MEMORY, IBL_ERR_CANCELLED: the level is unspecified. The same bytes
 * for any number of threads.
 */
ibl_status ibl_spectral_texels(ibl_ctx *ctx, const char *stage,
                               const ibl_level_sum *sum, const ibl_cube *cube,
                               int level);

#endif
