/* SPDX-License-Identifier: MIT */
#ifndef CLI_DISC_BRDF_H
#define CLI_DISC_BRDF_H

#include <ibl/ibl.h>

/*
 * The mean over a disc light of f(V, L) N.L, which times the light's irradiance
 * is what a surface reflects of it: f is the GGX microfacet BRDF with Schlick's
 * Fresnel term F0, single scattering.
 *   radius      of the disc, in radians: 0 to 0.1
 *   normal, view, light   unit vectors; the light's is that of its middle
 * The lobe's share within the disc has a closed form, if the disc is projected
 * to slopes linearly; F, geometry and N.L are those of one direction in it.
 * nRMSE over all directions for alpha 0.0025 to 1, N.V 0.05 to 0.95: at most
 * 0.3 % for a radius of 0.25 degrees, 0.5 % for 1, 6 % for 3.
 */
double ibl_disc_brdf(ibl_geometry geometry, double alpha, double f0,
                     double radius, const double normal[3],
                     const double view[3], const double light[3]);

#endif
