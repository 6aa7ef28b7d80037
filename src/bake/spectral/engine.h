/* SPDX-License-Identifier: MIT */
/*
 * The spectral method: lobes that depend on the angle to R alone are zonal
 * kernels, and a convolution with one multiplies the spherical harmonics of
 * the environment by a number for each degree (Ramamoorthi and Hanrahan 2001,
 * for the cosine). One analysis of the rows serves every level.
 *
 * What is computed is the integral of <ibl/ibl.h> over all pixels, constant
 * patches, to the tolerance. Pixels that outshine the rows around them are no
 * part of the analysis but added to each texel by the lobe's own formula: a
 * series that is cut rings, and next to a sun even a little of it would show.
 */
#ifndef IBL_BAKE_SPECTRAL_ENGINE_H
#define IBL_BAKE_SPECTRAL_ENGINE_H

#include <stdbool.h>

#include "bake/spectral/lights.h"
#include "bake/spectral/near.h"
#include "bake/spectral/resample.h"
#include "bake/spectral/row_fft.h"
#include "bake/spectral/transform.h"
#include "ibl/ibl.h"

#define IBL_SPECTRAL_GROUP IBL_ROW_FFT_ROWS /* analysed together */

/* What is known of IBL_SPECTRAL_GROUP rows. */
typedef struct ibl_spectral_group {
    ibl_row_range range;
    double squares; /* sum over its pixels, by solid angle */
    int exponent;   /* its Fourier coefficients are times 2^exponent */
    int lights;     /* taken out of it */
} ibl_spectral_group;

/* What is needed while rows come in. */
typedef struct ibl_spectral_reading {
    const float *rgb; /* rows first..added - 1, which were added last */
    int first, added;
    ibl_row_fft *azimuth;
    ibl_ring_spectra rows;
    float *scratch; /* worker_floats for each worker */
    size_t worker_floats;
    ibl_spectral_group *group;
    ibl_pixel_light *taken; /* IBL_LIGHTS_GROUP for each group */
} ibl_spectral_reading;

typedef struct ibl_spectral {
    ibl_ctx *ctx;
    int width, height, degree;
    int groups; /* of IBL_SPECTRAL_GROUP rows */
    double yaw; /* radians, 0..2 pi */
    ibl_spectral_reading reading;

    /* What is kept of the rows. */
    double scale;      /* of everything that is summed: see choose_scale */
    float mean[3];     /* of all but the lights; no part of the harmonics, and
                          added to every texel */
    float base[3];     /* taken from every pixel */
    double *power;     /* of the harmonics, in each degree */
    double unresolved; /* mean square of what is beyond the harmonics */
    float low[3], high[3]; /* the range of the map */
    double *weight;        /* solid angle of a pixel of each row */
    double *widths;        /* of each order, what a pixel's width makes of it */
    ibl_pixel_light *lights; /* added to each texel, scaled */
    int light_count;
    ibl_harmonics harmonics; /* of everything else */
} ibl_spectral;

/*
 * For a map of width x height pixels, turned by yaw_deg. Borrows ctx.
 *   degree   of the analysis, the highest of any level
 */
ibl_status ibl_spectral_create(ibl_ctx *ctx, int width, int height,
                               double yaw_deg, int degree, ibl_spectral **out);
void ibl_spectral_free(ibl_spectral *s); /* NULL is fine */

/* The next rows from the zenith, RGB: a multiple of IBL_SPECTRAL_GROUP, but for
 * the last ones. Begins jobs of the context's pool: ibl_run_end comes
 * before the next call for s, and rgb stays until that has returned. */
void ibl_spectral_add(ibl_spectral *s, int rows, const float *rgb);
/* All rows have been added. Reports as stage "analysis". */
ibl_status ibl_spectral_finish(ibl_spectral *s);

typedef struct ibl_spectral_target {
    const ibl_lobe_shape *shape; /* the lobe, or its far part */
    ibl_near *near;              /* the near part, all rows added; NULL: none */
    double tolerance;            /* of the relative error */
    ibl_cube *cube;              /* allocated */
    int level;                   /* of cube, that is written */
} ibl_spectral_target;

/*
 * Makes a level at the smallest degree that keeps the tolerance. Reports its
 * synthesis under stage, then "resampling".
 *   degree   written: that degree
 *   error    written: the estimate, a bound of the 95th percentile of
 *            ibl_relative_error over the level's texels
 */
ibl_status ibl_spectral_bake(ibl_spectral *s, const char *stage,
                             const ibl_spectral_target *target, int *degree,
                             double *error);

/* The coefficients of ibl_bake_sh, up to the degree of the analysis. */
ibl_status ibl_spectral_sh(const ibl_spectral *s, int degree, double *coeffs);

/* ---- between the files of the engine ---- */

/* The highest degree in which kernels are looked at: half as many again. */
static inline int ibl_spectral_known(int degree)
{
    return degree + degree / 2 + 8;
}

/* The azimuth of a light's centre in the world's axes. */
double ibl_spectral_azimuth(const ibl_spectral *s, const ibl_pixel_light *l);

/* Adds the Fourier coefficients of lights to those of their rows. */
ibl_status ibl_spectral_add_lights(const ibl_spectral *s,
                                   const ibl_pixel_light *lights, int count,
                                   ibl_ring_spectra *to);

#endif
