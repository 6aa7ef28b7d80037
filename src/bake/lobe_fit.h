/* SPDX-License-Identifier: MIT */
/*
 * Fits what a shader looks up to the lobe of a view and roughness.
 *
 * A fetch at a lod between two levels blends their lobes K_a and K_b about a
 * direction d in the plane of N and V; irradiance adds the cosine lobe about N:
 *     S = (1 - w) ((1 - t) K_a(d) + t K_b(d)) + w cosine(N).
 * For a direction, the best t and w are a quadratic problem on two triangles.
 * So only the direction and the distance of taps, whose lobes are averaged, are
 * searched.
 */
#ifndef IBL_BAKE_LOBE_FIT_H
#define IBL_BAKE_LOBE_FIT_H

#include "bake/lobe_kernels.h"
#include "bake/true_lobe.h"

enum {
    IBL_LOBE_ANGLES = 25,  /* directions with products with the true lobe */
    IBL_LOBE_WINDOW = 4,   /* levels that come into question */
    IBL_LOBE_MOST_TAPS = 4 /* of a lookup */
};

/* lobe_tables.f16, which `make lobe-tables` writes: the tables of the default
 * chains of cubes of 64, 128 and so on, halves of the lower byte first. */
enum {
    IBL_LOBE_KNOWN = 5,
    IBL_LOBE_KNOWN_SIZE = 64,
    IBL_LOBE_KNOWN_BYTES = 2 * 4 * IBL_LOBE_LAYERS * 16 * 16
};

extern const unsigned char
    ibl_lobe_tables[IBL_LOBE_KNOWN * IBL_LOBE_KNOWN_BYTES];

/* Fits a table, also one that is known; options are checked. */
ibl_status ibl_lobe_table_fit(ibl_ctx *ctx, const ibl_lobe_table_options *o,
                              float *data);

/* The true lobe of a view and roughness in products with the levels'. */
typedef struct ibl_lobe_view {
    const ibl_lobe_kernels *kernels;
    double angle; /* between N and V, and so from N to R */
    double sine, cosine;
    double first, step; /* angles from N towards R, of the columns of h */
    int base, count;    /* window of levels: base..base + count - 1 */
    double h[2][IBL_LOBE_WINDOW][IBL_LOBE_ANGLES];
    double diffuse[2];
    double most_weight; /* of irradiance */
} ibl_lobe_view;

/* What a shader does. Directions are mix(R, N, bend), of taps in equal steps
 * from bend - half to bend + half: one may be beyond R or N. */
typedef struct ibl_lobe_lookup {
    double bend, half; /* both 0..1; half is 0 for one tap */
    double lod;
    double weight; /* of irradiance */
} ibl_lobe_lookup;

void ibl_lobe_view_make(const ibl_lobe_kernels *k,
                        const ibl_true_lobe_rule *rule, double n_dot_v,
                        double roughness, ibl_lobe_view *view);

/* The lookups of least cost with one tap and with IBL_LOBE_MOST_TAPS. */
void ibl_lobe_fit(const ibl_lobe_view *view, int which,
                  ibl_lobe_lookup best[2]);

#endif
