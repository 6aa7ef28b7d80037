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

/* The horizon has bends of its own in what is wider. */
static const double ibl_patch_widest = 0.4;

/* Unit vector to the middle. */
void ibl_patch_middle(const ibl_patch *patch, double d[3]);
/* Solid angle. */
double ibl_patch_angle(const ibl_patch *patch);
/* Radius of a cap around the middle that holds it, in radians. */
double ibl_patch_radius(const ibl_patch *patch);

/* The rule of Gauss and Legendre on -1..1; masses sum to 2. */
enum {
    IBL_RULE_MOST = 66
};

typedef struct ibl_rule {
    int count; /* 0: not made */
    double node[IBL_RULE_MOST], mass[IBL_RULE_MOST];
} ibl_rule;

/* 1..IBL_RULE_MOST nodes. A rule that has as many stays. */
void ibl_rule_make(int count, ibl_rule *rule);

/*
 * Nodes of a rule that leaves a relative error of the integral, over an
 * interval, of a lobe whose nearest singularities are that far off.
 */
int ibl_rule_nodes(double extent, double reach, double error);

/* A point light: its direction, a unit vector in the world's axes, and its
 * radiance times solid angle. */
typedef struct ibl_light {
    double direction[3];
    double rgb[3];
} ibl_light;

/* The rules along theta and phi of the patch before, to be used again. */
typedef struct ibl_patch_rules {
    ibl_rule down, across;
} ibl_patch_rules;

/* Points that stand for a patch, which has so much light. out NULL: only
 * counts them. */
int ibl_patch_points(const ibl_patch *patch, double reach, double error,
                     ibl_patch_rules *rules, ibl_light *out);

/* Integral of the lobe around d over a patch, as exact as `rule` is above the
 * horizon. */
double ibl_patch_lobe(const ibl_patch *patch, const ibl_lobe_shape *shape,
                      const ibl_rule *rule, const double d[3]);

#endif
