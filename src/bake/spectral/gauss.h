/* SPDX-License-Identifier: MIT */
/* The Gauss-Legendre rule with four points on 0..1. */
#ifndef IBL_BAKE_SPECTRAL_GAUSS_H
#define IBL_BAKE_SPECTRAL_GAUSS_H

enum {
    IBL_GAUSS_POINTS = 4
};

static const double ibl_gauss_node[IBL_GAUSS_POINTS] = {
    0.069431844202973712, 0.33000947820757187, 0.66999052179242813,
    0.93056815579702629};
static const double ibl_gauss_mass[IBL_GAUSS_POINTS] = {
    0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
    0.17392742256872693};

#endif
