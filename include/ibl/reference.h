/* SPDX-License-Identifier: MIT */
/*
 * iblbake: the truth that bakes are judged by.
 *
 * The sums of <ibl/ibl.h> over every pixel of the source at full resolution,
 * in double precision with compensated summation, for any direction and any
 * roughness. Slow, and sharing no code with what it judges: not the cube
 * rule, not the lobe, not the solid angles. Conventions, status codes and
 * thread rules are those of <ibl/ibl.h>.
 */
#ifndef IBL_REFERENCE_H
#define IBL_REFERENCE_H

#include <stddef.h>

#include "ibl.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ibl_reference ibl_reference;

/*
 * Prepares the sums over env, turned by yaw_deg as in ibl_cube_from_latlong.
 * Borrows ctx and env until ibl_reference_free.
 */
ibl_status ibl_reference_create(ibl_ctx *ctx, const ibl_image *env,
                                double yaw_deg, ibl_reference **out);
void ibl_reference_free(ibl_reference *ref); /* NULL is fine */

/*
 * int L w dO / int w dO for `count` directions R (any length but 0), with
 * w = D_ggx(N.H; alpha) max(N.L, 0), N = V = R, alpha = roughness^2, and each
 * pixel a patch of constant radiance: sum L_i W_i / sum W_i, W_i the integral
 * of w over pixel i: near R and on its horizon along the patch's four edges
 * (Stokes), of a closed form, elsewhere by Gauss points, each within 1e-7 of
 * itself. Roughness 0 gives the pixel that R is in.
 *   dirs   3 * count doubles     rgb   3 * count doubles, written
 * IBL_ERR_ARGUMENT: roughness outside 0..1, a direction without one.
 * None of the calls of this header reports progress.
 */
ibl_status ibl_reference_specular(const ibl_reference *ref, double roughness,
                                  const double *dirs, size_t count,
                                  double *rgb);

/*
 * The same of any lobe of ibl_lobe; GGX is ibl_reference_specular. Roughness 0
 * gives the pixel that R is in for every lobe; Charlie below alpha = 1e-9 is
 * as there, a ring on the horizon.
 */
ibl_status ibl_reference_lobe(const ibl_reference *ref, ibl_lobe lobe,
                              double roughness, const double *dirs,
                              size_t count, double *rgb);

/* int L max(N.L, 0) dO / pi, over the same patches: irradiance / pi. */
ibl_status ibl_reference_irradiance(const ibl_reference *ref,
                                    const double *dirs, size_t count,
                                    double *rgb);

/* A texel of a cube of `size`. */
typedef struct ibl_texel {
    int face, x, y;
} ibl_texel;

/*
 * Level 0: the mean over a texel's solid angle of what ibl_cube_from_latlong
 * takes it from, the source's pixels as constant patches or, where they are
 * larger than the texels, the finer ones of its interpolation. Exact to about
 * 1e-9, for any aspect.
 *   base   edge of the level 0 whose interpolation it is: size, or more where
 *          the texels are those of a mip of it; size..IBL_MAX_CUBE_SIZE
 */
ibl_status ibl_reference_texels(const ibl_reference *ref, int base, int size,
                                const ibl_texel *texels, size_t count,
                                double *rgb);

/* ibl_bake_sh's coefficients, pixel by pixel. degree 0..64. */
ibl_status ibl_reference_sh(const ibl_reference *ref, int degree,
                            double *coeffs);

/* Mean radiance over the sphere, sum L dO / 4 pi. */
ibl_status ibl_reference_mean(const ibl_reference *ref, double rgb[3]);

/*
 * The split-sum integrals of ibl_bake_lut at one point, by adaptive
 * quadrature to an absolute error of 1e-9. n_dot_v and roughness in 0..1. At
 * roughness 0 a mirror's, 1 - Fc and Fc with Fc = (1 - n_dot_v)^5; at n_dot_v
 * 0 the limit, which for Schlick's geometry is not the mirror's even where
 * roughness falls to 0 after n_dot_v.
 */
ibl_status ibl_reference_lut(ibl_ctx *ctx, double n_dot_v, double roughness,
                             ibl_geometry geometry, double scale_bias[2]);

#ifdef __cplusplus
}
#endif

#endif
