/* SPDX-License-Identifier: MIT */
/*
 * The spherical harmonics of the lobe of bake/true_lobe.h at some degrees: its
 * power, and its sum of harmonics in some directions. With the lookups of
 * bake/lobe_kernels.h these give the error of a lookup:
 *     <T, T> = sum over l of C_l power(l),
 *     <K(d), T> = sum over l of C_l k(l) toward(d, l).
 */
#ifndef IBL_BAKE_LOBE_BANDS_H
#define IBL_BAKE_LOBE_BANDS_H

#include "bake/lobe_kernels.h"
#include "ibl/ibl.h"
#include "kern/legendre_sums.h"

enum {
    IBL_BANDS_DIRECTIONS = 8,
    IBL_BANDS_MOST = 80, /* degrees */
    IBL_BANDS_RINGS = 40,
    IBL_BANDS_COLUMNS = 32, /* on half a ring */
    IBL_BANDS_ORDERS = 12
};

/* What is the same for all lobes: points of rings around the mirror direction,
 * and the recurrence of what they are summed with. */
typedef struct ibl_bands_rule {
    ibl_legendre_sums_dsp dsp;
    double at[IBL_BANDS_RINGS], weight[IBL_BANDS_RINGS]; /* on 0..1 */
    double sine[IBL_BANDS_COLUMNS];                      /* of phi */
    double wave[IBL_BANDS_COLUMNS][IBL_BANDS_ORDERS];    /* cos(m phi) */
    /* Of Legendre's functions, for degrees m.. of an order m. */
    double factor[IBL_BANDS_ORDERS][IBL_LOBE_DEGREE + 1];
    double scale[IBL_BANDS_ORDERS][IBL_LOBE_DEGREE + 1];
} ibl_bands_rule;

void ibl_bands_rule_init(ibl_bands_rule *rule, ibl_isa isa);

typedef struct ibl_lobe_bands {
    int count;
    int degree[IBL_BANDS_MOST];   /* 1 or more, rising */
    double share[IBL_BANDS_MOST]; /* C_l (2 l + 1) / 4 pi that it stands for */
    int directions;
    double angle[IBL_BANDS_DIRECTIONS]; /* from N towards R */
    double energy[2];                   /* F0 = 1, .04: scale F0 + bias */
    int orders;                         /* that matter, and their harmonics: */
    double order[2][IBL_BANDS_ORDERS][IBL_BANDS_MOST];
    /* At each degree: */
    double power[2][IBL_BANDS_MOST];
    double toward[2][IBL_BANDS_DIRECTIONS][IBL_BANDS_MOST];
} ibl_lobe_bands;

/* Degrees in steps of a part of themselves to `last`. In between what lobes see
 * is linear, over 2 l + 1.
 *   power  C_l, l = 0..last */
void ibl_bands_fill(const double *power, int last, int part,
                    ibl_lobe_bands *bands);

/* Chooses degrees in steps of a sixteenth, to where the lobes of a roughness
 * have nothing to see.
 *   power  C_l, l = 0..IBL_LOBE_DEGREE */
void ibl_bands_degrees(const double *power, double roughness,
                       ibl_lobe_bands *bands);

/* Fills the results for the directions and degrees of *bands; but for energy,
 * the lobes have the energy 1. n_dot_v and alpha in (0, 1]. */
void ibl_lobe_bands_make(const ibl_bands_rule *rule, double n_dot_v,
                         double alpha, ibl_lobe_bands *bands);

/* The same for the directions from `first` on, which were added since. */
void ibl_lobe_bands_toward(const ibl_bands_rule *rule, double n_dot_v,
                           int first, ibl_lobe_bands *bands);

#endif
