/* SPDX-License-Identifier: MIT */
/*
 * iblbake: exact values to compare bakes with.
 *
 * The integrals of <ibl/ibl.h> over every pixel of the source at full
 * resolution, in double precision, for any direction and roughness: a
 * millisecond each for a map of 1024x512. Pixels are patches of constant
 * radiance. Shares no code with the bakes, not even for the cube's conventions,
 * lobes and solid angles. Conventions, status codes and thread rules are those
 * of <ibl/ibl.h>. No call reports progress.
 */
#ifndef IBL_REFERENCE_H
#define IBL_REFERENCE_H

#include <stddef.h>

#include "ibl.h"

#ifdef __cplusplus
extern "C" {
#endif
IBL_API_BEGIN

typedef struct ibl_reference ibl_reference;

/*
 * Prepares the integrals over env, turned by yaw_deg as in
 * ibl_cube_from_latlong; takes memory of about a third of env. Borrows ctx and
 * env, whose pixels must stay as they are, until ibl_reference_free.
 */
ibl_status ibl_reference_create(ibl_ctx *ctx, const ibl_image *env,
                                double yaw_deg, ibl_reference **out);
void ibl_reference_free(ibl_reference *ref); /* NULL is fine */
/* From now on integrals have relative errors of about 1e-4, at worst some 1e-3,
 * and take a third of the time: for many directions, whose errors cancel. */
void ibl_reference_coarsen(ibl_reference *ref);

/*
 * int L w dO / int w dO for `count` directions R (any length but 0), w being a
 * lobe's density times max(N.L, 0) with N = V = R, alpha = roughness^2, and
 * each pixel a patch of constant radiance: sum L_i W_i / sum W_i, W_i the
 * integral of w over pixel i. The relative error is about 1e-5, mostly less. A
 * roughness below 3e-4 gives the pixel that contains R; Charlie below alpha =
 * 1e-3 is as at 1e-3, and at 0 the pixel, too.
 *   dirs   3 * count doubles     rgb   3 * count doubles, written
 * IBL_ERR_ARGUMENT: roughness outside 0..1, a direction of length 0.
 */
ibl_status ibl_reference_lobe(const ibl_reference *ref, ibl_lobe lobe,
                              double roughness, const double *dirs,
                              size_t count, double *rgb);

/*
 * What a surface reflects to a viewer. With F0 its reflectance at normal
 * incidence, the integral of f(V, L) L N.L over the sphere is F0 * A + B; f is
 * the GGX microfacet BRDF with this geometry and Schlick's Fresnel term, single
 * scattering. The relative error is about 1e-4, up to 4e-3 if all light is
 * along the horizon.
 *   roughness  n values in 0..1
 *   normals    3 * count doubles of any length but 0
 *   views      as many, from the surface to the viewer, not below the surface
 *   out        IBL_REFERENCE_BRDF * n * count doubles, written: for each pair
 *              of normal and view each roughness, with R G B of A, A for a
 *              radiance of 1, and the same of B. For a radiance of 1, A and B
 *              are ibl_bake_lut's scale and bias.
 * A roughness below 3e-4 is a mirror: the pixel at the reflected direction.
 * IBL_ERR_ARGUMENT: a roughness, geometry, direction or view that is not so.
 * Sources: Walter et al. 2007; Heitz 2014; Karis 2013.
 */
#define IBL_REFERENCE_BRDF 8
ibl_status ibl_reference_brdf(const ibl_reference *ref, ibl_geometry geometry,
                              const double *roughness, int n,
                              const double *normals, const double *views,
                              size_t count, double *out);

/* int L max(N.L, 0) dO / pi, over the same patches: irradiance / pi. */
ibl_status ibl_reference_irradiance(const ibl_reference *ref,
                                    const double *dirs, size_t count,
                                    double *rgb);

/* A texel of a cube of `size`, or of a flat level with as much detail, whose
 * face is 0. */
typedef struct ibl_texel {
    int face, x, y;
} ibl_texel;

/*
 * Level 0: the mean of the source over a texel's solid angle. As in
 * ibl_cube_from_latlong, pixels are constant patches or, if they are larger
 * than the texels, are divided into the smaller patches of the interpolation.
 * Exact to about 1e-8, for any aspect.
 *   projection  of the texels
 *   base   edge of the level 0 that sets the interpolation, size to
 *          IBL_MAX_CUBE_SIZE: size, or more for the texels of one of its mips
 */
ibl_status ibl_reference_texels(const ibl_reference *ref,
                                ibl_projection projection, int base, int size,
                                const ibl_texel *texels, size_t count,
                                double *rgb);

/* ibl_bake_sh's coefficients, pixel by pixel. degree 0..64. */
ibl_status ibl_reference_sh(const ibl_reference *ref, int degree,
                            double *coeffs);

/* Mean radiance over the sphere, sum L dO / 4 pi. */
ibl_status ibl_reference_mean(const ibl_reference *ref, double rgb[3]);

/*
 * The split-sum integrals of ibl_bake_lut at one point, by adaptive quadrature
 * to an absolute error of 1e-9. n_dot_v and roughness in 0..1. Roughness 0
 * gives a mirror's values, 1 - Fc and Fc with Fc = (1 - n_dot_v)^5; n_dot_v 0
 * gives the limit, which for Schlick's geometry differs from the mirror's
 * values even if roughness goes to 0 after n_dot_v.
 */
ibl_status ibl_reference_lut(ibl_ctx *ctx, double n_dot_v, double roughness,
                             ibl_geometry geometry, double scale_bias[2]);

/*
 * The albedos E of sheen (ibl_bake_lut) at one point, with Ashikhmin's V and
 * with Charlie's, to a relative error of 1e-6. n_dot_v and roughness in (0, 1].
 */
ibl_status ibl_reference_sheen(ibl_ctx *ctx, double n_dot_v, double roughness,
                               double albedo[2]);

IBL_API_END
#ifdef __cplusplus
}
#endif

#endif
