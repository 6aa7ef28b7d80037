/* SPDX-License-Identifier: MIT */
/* Shared by the files of the reference. See ibl/reference.h. */
#ifndef IBL_BAKE_REFERENCE_SUMS_H
#define IBL_BAKE_REFERENCE_SUMS_H

#include <math.h>
#include <stdbool.h>

#include "ibl/reference.h"

#define REFERENCE_PI 3.14159265358979323846

struct ibl_reference {
    ibl_ctx *ctx;
    const ibl_image *env;
    double yaw; /* radians, 0..2 pi: the map's azimuth minus the world's */
    double *cos_phi, *sin_phi; /* of the map's azimuth: width + 1 for each of
                                  REFERENCE_POINTS in a column */
};

enum {
    REFERENCE_POINTS = 5 /* across a pixel: by 2 and by 3 Gauss points */
};

/* Gauss-Legendre points on -1..1 and weights; n is 2, 3, 4, 6 or 8. */
typedef struct ibl_gauss {
    double node[8], mass[8];
} ibl_gauss;

const ibl_gauss *ibl_reference_gauss(int n);

/* A sum with compensation for rounding (Neumaier 1974). */
typedef struct ibl_exact {
    double value, rest;
} ibl_exact;

static inline void ibl_exact_add(ibl_exact *s, double x)
{
    const double t = s->value + x;

    s->rest +=
        fabs(s->value) >= fabs(x) ? (s->value - t) + x : (x - t) + s->value;
    s->value = t;
}

static inline double ibl_exact_total(const ibl_exact *s)
{
    return s->value + s->rest;
}

/* A direction in the map's frame. */
typedef struct ibl_aim {
    double theta; /* from +Y */
    double phi;   /* the map's azimuth, -pi..pi */
    double sin_theta, cos_theta;
} ibl_aim;

/*
 * A lobe's weight as a function of q, the squared sine of half the angle from
 * the aim, scaled so that the largest is about 1:
 *   GGX      (a2 / t)^2 (1 - 2 q),  t = q + a2 (1 - q)
 *   Charlie  (2 q)^power (1 - 2 q) (power + 1) e, power = 1 / (2 alpha)
 *   Phong    (1 - 2 q)^power, power = 1 + (1 / a2 - 1) / 2
 */
typedef struct ibl_weight {
    ibl_lobe lobe;
    double alpha, a2, power, scale;
    double least, most; /* range of q; outside it the weight is below 1e-20 */
    double total;       /* its integral over q */
    double width;       /* radians over which it changes; 0: 2 sqrt(t) (GGX) */
    bool ring;          /* 0 at the aim, and not smooth there */
    bool fractional;    /* not smooth on the horizon */
} ibl_weight;

/* alpha in (0, 1]; for Charlie, values below 1e-9 count as 1e-9. */
ibl_weight ibl_reference_weight(ibl_lobe lobe, double alpha);
/* The weight at an angle whose cosine c is in 0..1, up to rounding. */
double ibl_reference_weight_at(const ibl_weight *weight, double c);

/*
 * Pixels begin..end - 1 of row j of a w x h map. Columns wrap around and are
 * less than a turn from the aim. ibl_reference_patches writes a weight's
 * integral over each, with a relative error of about 1e-10.
 */
typedef struct ibl_pixels {
    int w, h, j, begin, end;
} ibl_pixels;

void ibl_reference_patches(const ibl_aim *aim, const ibl_weight *weight,
                           const ibl_pixels *run, double *out);

/* Returns IBL_ERR_ARGUMENT if ref is NULL or, with count > 0, in or out is. */
ibl_status ibl_reference_check(const ibl_reference *ref, size_t count,
                               const void *in, const void *out);
/* Returns IBL_ERR_ARGUMENT if a direction has no length, or no finite one. */
ibl_status ibl_reference_check_dirs(const ibl_reference *ref,
                                    const double *dirs, size_t count);
/* The same for an ibl_geometry that there is not. */
ibl_status ibl_reference_check_geometry(ibl_ctx *ctx, ibl_geometry geometry);

/* Colour of the pixel that contains a direction. */
void ibl_reference_mirror(const ibl_reference *ref, const double dir[3],
                          double rgb[3]);

#endif
