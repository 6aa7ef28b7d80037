/* SPDX-License-Identifier: MIT */
/*
 * The spectral method. A lobe that depends only on the angle to R is a zonal
 * kernel: a convolution with it multiplies the spherical harmonics of the
 * environment by one number per degree (Ramamoorthi and Hanrahan 2001, for the
 * cosine). One analysis of the rows serves every level.
 *
 * The result is the integral of <ibl/ibl.h> over all pixels, as constant
 * patches, within the tolerance. Pixels that outshine the rows around them are
 * left out of the analysis and added to each texel by the lobe's formula: a
 * truncated series rings, which is visible next to a sun.
 */
#ifndef IBL_BAKE_SPECTRAL_ENGINE_H
#define IBL_BAKE_SPECTRAL_ENGINE_H

#include <stdbool.h>
#include <stddef.h>

#include "bake/spectral/resample.h"
#include "bake/spectral/row_fft.h"
#include "bake/spectral/transform.h"
#include "ibl/ibl.h"

enum {
    IBL_LIGHTS_GROUP = 4096, /* most lights of a group of rows */
    IBL_LIGHTS_MOST = 4096   /* most lights of the whole map */
};

/* A pixel, and its radiance above the value that replaced it. */
typedef struct ibl_pixel_light {
    int row, column;
    float rgb[3];
    double energy; /* of all channels; the caller sets it */
} ibl_pixel_light;

/* Values of a group of rows, for each channel. */
typedef struct ibl_row_range {
    float low[3], high[3];
    double mean[3];
} ibl_row_range;

/* Results for IBL_ROW_GROUP rows. */
typedef struct ibl_spectral_group {
    ibl_row_range range;
    int exponent; /* its Fourier coefficients are scaled by 2^exponent */
    int lights;   /* number of lights taken out of it */
} ibl_spectral_group;

/* State while rows are added. */
typedef struct ibl_spectral_reading {
    const float *rgb; /* the rows added last: first..added - 1 */
    int first, added;
    ibl_row_fft *azimuth;
    ibl_row_spectra rows;
    float *scratch; /* worker_floats for each worker */
    size_t worker_floats;
    ibl_spectral_group *group;
    size_t room;            /* for lights of a group */
    ibl_pixel_light *taken; /* room for each group */
} ibl_spectral_reading;

typedef struct ibl_spectral {
    ibl_ctx *ctx;
    int width, height, degree;
    int single; /* see ibl_harmonics */
    int groups; /* of IBL_ROW_GROUP rows */
    double yaw; /* radians, 0..2 pi */
    ibl_spectral_reading reading;

    /* Results of the analysis. */
    double scale;          /* of the lights and harmonics: see choose_scale */
    float mean[3];         /* without lights; in no harmonic, but added to every
                              texel */
    float low[3], high[3]; /* the range of the map */
    double *weight;        /* solid angle of a pixel of each row */
    double *widths;        /* for each m: int e^(-i m phi) over a pixel */
    ibl_pixel_light *lights; /* added to each texel, scaled */
    int light_count;
    ibl_harmonics harmonics; /* without the mean and the lights */
    double *power;           /* of the harmonics in each degree */
} ibl_spectral;

/*
 * For a map of width x height pixels, turned by yaw_deg. Borrows ctx.
 *   degree   of the analysis, the highest of any level
 *   single   from this degree on it may use floats
 */
ibl_status ibl_spectral_create(ibl_ctx *ctx, int width, int height,
                               double yaw_deg, int degree, int single,
                               ibl_spectral **out);
void ibl_spectral_free(ibl_spectral *s); /* NULL is fine */

/* Adds the next rows from the zenith, RGB: a multiple of IBL_ROW_GROUP,
 * except for the last rows. Starts jobs on the context's pool: ibl_run_end must
 * come before the next call for s; rgb must stay valid until then. */
void ibl_spectral_add(ibl_spectral *s, int rows, const float *rgb);
/* To be called when all rows are added. Reports as stage "analysis". */
ibl_status ibl_spectral_finish(ibl_spectral *s);

typedef struct ibl_spectral_target {
    const ibl_lobe_shape *shape;
    int most;         /* of its degrees, so that it does not depend on others */
    double tolerance; /* of the relative error */
    ibl_cube *cube;   /* allocated */
    int level;        /* the level of cube to write */
} ibl_spectral_target;

/*
 * Makes a level at the smallest degree that keeps the tolerance. Reports as
 * `stage`.
 *   degree   written: that degree
 *   error    written: estimated bound of the 95th percentile of
 *            ibl_relative_error over the level's texels
 */
ibl_status ibl_spectral_bake(ibl_spectral *s, const char *stage,
                             const ibl_spectral_target *target, int *degree,
                             double *error);

/* The coefficients of ibl_bake_sh, up to the degree of the analysis. */
ibl_status ibl_spectral_sh(const ibl_spectral *s, int degree, double *coeffs);

/* ---- between the files of the engine ---- */

/* The azimuth of a light's centre in the world's axes. */
double ibl_spectral_azimuth(const ibl_spectral *s, const ibl_pixel_light *l);

/* Adds the Fourier coefficients of lights to those of their rows. */
ibl_status ibl_spectral_add_lights(const ibl_spectral *s,
                                   const ibl_pixel_light *lights, int count,
                                   ibl_row_spectra *to);

#endif
