/* SPDX-License-Identifier: MIT */
/* What the files of the reference share. See ibl/reference.h. */
#ifndef IBL_BAKE_REFERENCE_SUMS_H
#define IBL_BAKE_REFERENCE_SUMS_H

#include <math.h>

#include "ibl/reference.h"

#define REFERENCE_PI 3.14159265358979323846

struct ibl_reference {
    ibl_ctx *ctx;
    const ibl_image *env;
    double yaw;        /* radians, 0..2 pi: the map's azimuth is the world's
                          plus this */
    int padded;        /* width, rounded up to whole LANES */
    double *half_sin;  /* padded: of half the azimuth of a column's centre,
                          infinite beyond width */
    double *half_cos;  /* padded */
    double *row_theta; /* height: of the row's centre */
    double *row_angle; /* height: solid angle of one of its pixels */
};

/* A sum that carries what rounding dropped (Neumaier 1974). */
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
    double sin_theta;
} ibl_aim;

/* A rectangle in theta and phi, as offsets from an aim. */
typedef struct ibl_patch {
    double x0, x1; /* theta */
    double y0, y1; /* phi, -2 pi..2 pi */
} ibl_patch;

/*
 * A lobe's weight as a function of q, the squared sine of half the angle from
 * the aim, scaled so that the largest is about 1:
 *   GGX      (a2 / t)^2 (1 - 2 q),  t = q + a2 (1 - q)
 *   Charlie  (2 q)^power (1 - 2 q) (power + 1) e, power = 1 / (2 alpha)
 *   Phong    (1 - 2 q)^power, power = 1 + (1 / a2 - 1) / 2
 */
typedef struct ibl_weight {
    ibl_lobe lobe;
    double a2, power, scale;
    double least, most; /* q; elsewhere the weight is less than 1e-20 */
    double whole;       /* its integral over the sphere is at most this */
} ibl_weight;

/* alpha in [1e-75, 1]; Charlie's no less than 1e-9. */
ibl_weight ibl_reference_weight(ibl_lobe lobe, double alpha);
double ibl_reference_weight_at(const ibl_weight *weight, double q);

/* The integral of a weight over a patch. Relative error about 1e-8. */
double ibl_reference_patch(const ibl_aim *aim, const ibl_weight *weight,
                           const ibl_patch *patch);

/* Rows that a job takes, so that it takes about a millisecond. */
int ibl_reference_strip(const ibl_reference *ref, int pixels);

#endif
