/* SPDX-License-Identifier: MIT */
/* What the files of the spectral engine share. */
#ifndef IBL_BAKE_SPECTRAL_STATE_H
#define IBL_BAKE_SPECTRAL_STATE_H

#include <stdbool.h>

#include "bake/spectral/azimuth.h"
#include "bake/spectral/engine.h"
#include "bake/spectral/lights.h"
#include "bake/spectral/resample.h"
#include "bake/spectral/transform.h"
#include "core/pi.h"

/* Memory that levels use one after the other, and what is in the grid: the
 * diffuse lobe is that of a level, too. */
typedef struct ibl_spectral_work {
    ibl_ring_spectra spectra;
    ibl_ring_grid grid;
    ibl_lobe_shape shape; /* its alpha 0: nothing */
    int degree;
    double margin; /* see level.c */
} ibl_spectral_work;

void ibl_spectral_work_free(ibl_spectral_work *work);

/* Rows that were added last. */
typedef struct ibl_spectral_batch {
    const float *rgb;
    int first, rows;
} ibl_spectral_batch;

struct ibl_spectral {
    ibl_ctx *ctx;
    int width, height, degree;
    bool halved; /* the map is twice as wide and high */
    double yaw;  /* radians, 0..2 pi */

    double scale; /* of everything that is summed: see choose_scale */

    /* While rows come in. */
    int added;  /* rows */
    int groups; /* of IBL_SPECTRAL_GROUP rows */
    ibl_spectral_batch batch;
    ibl_azimuth *azimuth;
    ibl_ring_spectra rows;
    float *scratch; /* worker_floats for each worker */
    size_t worker_floats;
    ibl_row_range *range;   /* of each group */
    double *squares;        /* of each group: sum over its pixels, by dO */
    float peak;             /* of the groups until now */
    int *found;             /* lights of each group */
    ibl_pixel_light *taken; /* IBL_LIGHTS_GROUP for each group */

    /* What is kept of them. */
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

    ibl_spectral_work work;
};

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
