/* SPDX-License-Identifier: MIT */
/* What the tests of ibl/reference.h share. */
#ifndef TESTS_REFERENCE_H
#define TESTS_REFERENCE_H

#include "ibl/reference.h"
#include "maps.h"
#include "test.h"

/* A map that a reference is made of. */
typedef struct subject {
    ibl_ctx *ctx;
    ibl_image env;
    double yaw_deg;
} subject;

/* Freed after the running test, as a subject. */
ibl_reference *reference_of(ibl_ctx *ctx, const ibl_image *map, double yaw_deg);

/* Random values 0..1, few bright; seed 0: black. */
subject *subject_make(int threads, int width, int height, uint64_t seed,
                      double yaw_deg);

/* The reference of a subject's map as it is now. */
ibl_reference *subject_ref(const subject *s);

/* theta from +Y, phi as the map's columns without yaw. */
void polar_direction(double theta, double phi, double d[3]);
void random_direction(test_random *rnd, double d[3]);
/* A view at n_dot_v from a normal, on a random side. */
void random_view(test_random *rnd, const double normal[3], double n_dot_v,
                 double view[3]);

/* The calls of ibl/reference.h for a map, or the table, at one point. */
void reference_mean(const ibl_image *map, double rgb[3]);
void reference_irradiance(const ibl_image *map, const double normal[3],
                          double rgb[3]);
void reference_lut(double n_dot_v, double roughness, ibl_geometry geometry,
                   double scale_bias[2]);

extern const long double pi_l;

/* Exact solid angle of a pixel in row j of a w x h map. */
long double row_angle(int w, int h, int j);

#endif
