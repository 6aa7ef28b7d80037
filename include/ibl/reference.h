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
 * sum L_i W_i / sum W_i for `count` directions R (any length but 0), with
 * w = D_ggx(N.H; alpha) max(N.L, 0), N = V = R, alpha = roughness^2.
 *
 * W_i is w at the pixel's centre times its solid angle dO_i where the lobe is
 * smooth over a pixel, and the integral of w over the pixel, a constant patch,
 * where it is not. With p the larger of pi / height and 2 pi / width, psi the
 * angle from R to the centre and t = sin^2(psi / 2) + alpha^2 cos^2(psi / 2),
 * w changes over a length of 2 sqrt(t): from 8 p up the centre counts, from
 * 4 p down the integral, in between a mix of both that is smooth in t, so the
 * result is continuous in R and in roughness. Where the mix begins centre and
 * patch differ by about 1 % of that pixel's weight. With alpha >= 4 p, a lobe
 * 10 pixels wide at half its height, no pixel is divided; so at roughness 1
 * this is ibl_reference_irradiance for maps of at least 26x13 pixels.
 * Roughness 0 gives the pixel that R is in.
 *
 * Patches are divided until dividing once more changes nothing above 1e-8 of
 * their weight; the result is within 1e-6, and where no pixel is divided
 * within 1e-13, of what is defined here.
 *   dirs   3 * count doubles     rgb   3 * count doubles, written
 * IBL_ERR_ARGUMENT: roughness outside 0..1, a direction without one.
 * None of the calls of this header reports progress.
 */
ibl_status ibl_reference_specular(const ibl_reference *ref, double roughness,
                                  const double *dirs, size_t count,
                                  double *rgb);

/*
 * The same of any lobe of ibl_lobe; GGX is ibl_reference_specular.
 *
 * Charlie and Phong change over a length that is nearly the same wherever they
 * are anything, so all pixels are alike: the centre counts from a width
 * alpha = p up for Charlie, 2 p for Phong, the integral from half of that down,
 * in between a mix of both that is smooth in alpha. Where the mix begins centre
 * and patch differ by about 1 % of a pixel's weight, or Charlie's also where
 * the horizon crosses it. Roughness 0 gives the pixel that R is in for every
 * lobe; Charlie below alpha = 1e-9 is as there, a ring on the horizon.
 */
ibl_status ibl_reference_lobe(const ibl_reference *ref, ibl_lobe lobe,
                              double roughness, const double *dirs,
                              size_t count, double *rgb);

/* sum L_i max(N.L_i, 0) dO_i / sum max(N.L_i, 0) dO_i: irradiance / pi; the
 * mean radiance where no pixel's centre is above the horizon, as in
 * ibl_bake_irradiance. */
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
