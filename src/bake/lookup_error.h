/* SPDX-License-Identifier: MIT */
/*
 * The squared error of what a shader draws of a view, over all rotations of a
 * map, from the map's spectrum: sums over the harmonics of the lobes of the
 * lookup and of the surface (bake/lobe_bands.h).
 *
 * In units of the energy that the lobe reflects, the surface sends out T + a c,
 * T its lobe, c the cosine lobe about N and a the diffuse albedo; drawn is
 *     g ((1 - w) K + w c') + a c',
 * K the lobe that is looked up, w its weight of irradiance, c' the cosine lobe
 * as it was baked, g the ratio of the BRDF table to the truth.
 */
#ifndef IBL_BAKE_LOOKUP_ERROR_H
#define IBL_BAKE_LOOKUP_ERROR_H

#include <stdbool.h>

#include "bake/lobe_bands.h"
#include "bake/lobe_kernels.h"

enum {
    IBL_LOOKUP_APART = IBL_BANDS_DIRECTIONS,
    IBL_LOOKUP_ANGLES = IBL_BANDS_DIRECTIONS + 2
};

/* The first directions of the bands of a view. */
enum {
    IBL_TO_N,
    IBL_TO_R
};

/* The directions of its taps, and what it reads. */
typedef struct ibl_lookup_use {
    int taps;
    int at[2]; /* of the directions of the bands */
    double lod, weight;
} ibl_lookup_use;

/* The lobes of a view and what multiplies them. */
typedef struct ibl_lookup_view {
    ibl_lobe_bands bands;
    /* P_l(cos(angle)): of the directions; of those of two taps from each
     * other, for each F0 */
    double p[IBL_LOOKUP_ANGLES][IBL_BANDS_MOST];
} ibl_lookup_view;

/* What was baked, besides the levels. */
typedef struct ibl_lookup_set {
    double diffuse, table; /* a and g */
    int irradiance;        /* edge; 0: harmonics of degree 2; -1: exact */
    double step, slope;    /* of texels, as in ibl_expected_set */
} ibl_lookup_set;

/* Adds the direction mix(R, N, bend) to the bands of a view. */
int ibl_lookup_direction(ibl_lobe_bands *b, double n_dot_v, double bend);

/* A lookup by a table, with its directions. */
ibl_lookup_use ibl_lookup_by_table(const ibl_lobe_table *t,
                                   const ibl_lobe_kernels *k, int f, int taps,
                                   double n_dot_v, double roughness,
                                   ibl_lobe_bands *b);

/* P_l(cos(angle)) at the degrees of the bands, for count angles. */
void ibl_lookup_legendre(const double *angle, int count,
                         const ibl_lobe_bands *b, double p[][IBL_BANDS_MOST]);

/* The mean square of what bilinear lookups in faces of an edge add to the mean
 * blur of a wave of a degree; mirror: texels are means. */
double ibl_lookup_scatter(int edge, bool mirror, int degree);

/* What level 0 keeps of a wave where it interpolates a map, whose highest
 * degree is `most`, 0 if it is not known: see ibl_cube_from_latlong. */
double ibl_lookup_pixels(int edge, int most, int degree);

/* |drawn - sent|^2. */
double ibl_lookup_error(const ibl_lobe_kernels *k, const ibl_lookup_view *v,
                        int f, const ibl_lookup_use *use,
                        const ibl_lookup_set *set);

/* |sent|^2. */
double ibl_lookup_power(const ibl_lobe_kernels *k, const ibl_lookup_view *v,
                        int f, double diffuse);

#endif
