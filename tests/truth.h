/* SPDX-License-Identifier: MIT */
/*
 * Truth for the tests: the sums of the conventions in ibl/ibl.h written out
 * in double precision, slowly, sharing no code with the library.
 * Directions are unit vectors, colours RGB.
 */
#ifndef TRUTH_H
#define TRUTH_H

#include "ibl/ibl.h"

/* Centre of pixel (i, j) of a w x h map, which may have fractions, and the
 * pixel's solid angle. */
void truth_latlong_direction(int w, int h, double i, double j, double dir[3]);
double truth_latlong_solid_angle(int w, int h, int j);
/* The pixel that holds a direction. */
void truth_latlong_pixel(int w, int h, const double dir[3], int *i, int *j);
/* Centre of a cube texel; (x, y) may have fractions: (x + .5) / n. */
void truth_cube_direction(int n, int face, double x, double y, double dir[3]);

/* The lobe's weight at the angle psi from R, q = sin^2(psi / 2), up to a
 * factor, and its integral over the sphere. */
double truth_lobe_weight(ibl_lobe lobe, double alpha, double q);
double truth_lobe_integral(ibl_lobe lobe, double alpha);
/* The integral of that weight, seen from dir, over pixel (i, j) of a map. */
double truth_pixel_weight(int w, int h, int i, int j, const double dir[3],
                          ibl_lobe lobe, double roughness);
/* G2 of Smith, height-correlated (Heitz 2014, eq. 99), or of Schlick with
 * k = alpha / 2 (Karis 2013). */
double truth_shadowing(ibl_geometry geometry, double alpha, double n_dot_l,
                       double n_dot_v);
/* f N.L / F of GGX (Walter et al. 2007, eq. 33), 0 below the surface, and
 * *fresnel = (1 - V.H)^5, so that F = F0 + (1 - F0) *fresnel. */
double truth_ggx(ibl_geometry geometry, double alpha, const double n[3],
                 const double v[3], const double l[3], double *fresnel);
/* The rule of Gauss and Legendre on -1..1, by Newton's method. */
void truth_gauss(int n, long double *node, long double *weight);
/* Real orthonormal spherical harmonic of ibl_bake_sh, l <= 64. */
double truth_sh(int l, int m, const double dir[3]);

#endif
