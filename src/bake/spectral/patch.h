/* SPDX-License-Identifier: MIT */
/* A pixel of the map as a patch of the sphere, constant over it, seen through
 * a lobe. */
#ifndef IBL_BAKE_SPECTRAL_PATCH_H
#define IBL_BAKE_SPECTRAL_PATCH_H

#include "brdf/lobe.h"

/* theta from +Y and phi in the world's axes, in radians: x = sin(theta)
 * cos(phi), z = sin(theta) sin(phi). */
typedef struct ibl_patch {
    double theta[2];
    double phi, width; /* middle and width */
    float rgb[3];      /* radiance */
} ibl_patch;

/* In wider patches the horizon is too curved. */
static const double ibl_patch_widest = 0.4;

/* Unit vector to the middle. */
void ibl_patch_middle(const ibl_patch *patch, double d[3]);
/* Solid angle. */
double ibl_patch_angle(const ibl_patch *patch);
/* Radius of a cap around the middle that contains it, in radians. */
double ibl_patch_radius(const ibl_patch *patch);

/* The Gauss-Legendre rule on -1..1; masses sum to 2. */
enum {
    IBL_RULE_MOST = 66
};

typedef struct ibl_rule {
    int count; /* 0: not made */
    double node[IBL_RULE_MOST], mass[IBL_RULE_MOST];
} ibl_rule;

/* Makes a rule of 1..IBL_RULE_MOST nodes, unless it already has that many. */
void ibl_rule_make(int count, ibl_rule *rule);

/*
 * Number of nodes that keep the relative error of an integral over a length
 * `extent`, of a lobe whose nearest singularities are `reach` away.
 */
int ibl_rule_nodes(double extent, double reach, double error);

/* A point light: its direction, a unit vector in the world's axes, and its
 * radiance times solid angle. */
typedef struct ibl_patch_light {
    double direction[3];
    double rgb[3];
} ibl_patch_light;

/* The rules of the previous patch along theta and phi, for reuse. */
typedef struct ibl_patch_rules {
    ibl_rule down, across;
} ibl_patch_rules;

/* Writes points that together have the light of a patch; returns their number.
 * out NULL: only counts them. */
int ibl_patch_points(const ibl_patch *patch, double reach, double error,
                     ibl_patch_rules *rules, ibl_patch_light *out);

/* Integral over a patch of the lobe around d, above the horizon, as exact as
 * `rule`. */
double ibl_patch_lobe(const ibl_patch *patch, const ibl_lobe_shape *shape,
                      const ibl_rule *rule, const double d[3]);

#endif
