/* SPDX-License-Identifier: MIT */
/*
 * What is expected of a distribution of materials: targets, and the lookups of
 * least error for them.
 *
 * A target is the lobe of a surface, of a roughness, a view and F0.
 */
#ifndef IBL_BAKE_EXPECTATION_H
#define IBL_BAKE_EXPECTATION_H

#include <stdbool.h>

#include "bake/lobe_kernels.h"
#include "bake/lookup_error.h"

enum {
    IBL_EXPECTED_VIEWS = 5,  /* Gauss-Legendre points of N.V */
    IBL_EXPECTED_NODES = 20, /* roughnesses, at most */
    IBL_EXPECTED_TARGETS = IBL_EXPECTED_NODES * IBL_EXPECTED_VIEWS * 2,
    IBL_EXPECTED_GRID = 128, /* roughnesses of ladders: i / 128 */
    IBL_EXPECTED_DEGREES = IBL_LOBE_DEGREE + 1,
    /* Directions of a view, after IBL_TO_R: for F0 = 1, and .04 */
    IBL_EXPECTED_BENT = 2
};

typedef struct ibl_expected_node {
    double roughness; /* below IBL_EXPECTED_LEAST: a mirror */
    double weight[2], diffuse[2];
} ibl_expected_node;

typedef struct ibl_expected_target {
    double seen[IBL_BANDS_MOST]; /* C_l of the lobe, in the direction
                                    IBL_EXPECTED_BENT */
    double lit[IBL_BANDS_MOST];  /* and of the cosine lobe */
    double weight;               /* of squares in units of its energy */
    double diffuse;              /* albedo, in units of its energy */
    double power;                /* |T|^2 without the mean */
    double both, even;           /* <cosine, cosine>, <cosine, T> */
} ibl_expected_target;

struct ibl_expectation {
    ibl_ctx *ctx;
    ibl_bands_rule rule;
    double at[IBL_EXPECTED_VIEWS], weight[IBL_EXPECTED_VIEWS];
    ibl_lobe_kernels kernels; /* of no chain: the spectrum and the cosine */
    const double *given;      /* C_l as given */
    int degree, most;         /* its last; the map's */
    double beyond;            /* power beyond `degree`, of that up to it */
    ibl_lut truth;
    int nodes;
    ibl_expected_node node[IBL_EXPECTED_NODES];
    ibl_lookup_view *view; /* IBL_EXPECTED_VIEWS of each node */
    ibl_expected_target target[IBL_EXPECTED_TARGETS];
    double total; /* of |T + a c|^2 */
    double (
        *lobe)[IBL_EXPECTED_DEGREES]; /* of ladders; NULL: none was fitted */
    bool has_lobe[IBL_EXPECTED_GRID + 1];
};

/* The best lookups of each target in a chain without its table. */
typedef struct ibl_best_lookups ibl_best_lookups;

/* *out is to be freed with ibl_free, also after an error. */
ibl_status ibl_best_lookups_of(const ibl_expectation *e,
                               const ibl_specular_layout *layout,
                               ibl_best_lookups **out);

/* That of a target: its lod, and the share of irradiance. */
void ibl_best_lookup(const ibl_best_lookups *s, int target, double *lod,
                     double *weight);

#endif
