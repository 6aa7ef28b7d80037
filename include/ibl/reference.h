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
 * sum L_i w_i dO_i / sum w_i dO_i, w = D_ggx(N.H; roughness^2) max(N.L, 0),
 * N = V = R, for `count` unit directions R. Where the lobe is narrower than a
 * few pixels, pixels near its peak are divided further until dividing once
 * more changes nothing above 1e-6 of the result. Roughness 0 gives the pixel
 * that R is in.
 *   dirs   3 * count doubles     rgb   3 * count doubles, written
 * IBL_ERR_ARGUMENT: roughness outside 0..1.
 */
ibl_status ibl_reference_specular(const ibl_reference *ref, double roughness,
                                  const double *dirs, size_t count,
                                  double *rgb);

/* sum L_i max(N.L_i, 0) dO_i / sum max(N.L_i, 0) dO_i: irradiance / pi. */
ibl_status ibl_reference_irradiance(const ibl_reference *ref,
                                    const double *dirs, size_t count,
                                    double *rgb);

/* A texel of a cube of `size`. */
typedef struct ibl_texel {
    int face, x, y;
} ibl_texel;

/*
 * Level 0: the mean over a texel's solid angle of the source, as constant
 * patches where its pixels are no larger than the texels (width >= 4 size and
 * height >= 2 size), else interpolated bilinearly.
 */
ibl_status ibl_reference_texels(const ibl_reference *ref, int size,
                                const ibl_texel *texels, size_t count,
                                double *rgb);

/* ibl_bake_sh's coefficients, pixel by pixel. degree 0..64. */
ibl_status ibl_reference_sh(const ibl_reference *ref, int degree,
                            double *coeffs);

/* Mean radiance over the sphere, sum L dO / 4 pi. */
ibl_status ibl_reference_mean(const ibl_reference *ref, double rgb[3]);

/*
 * The split-sum integrals of ibl_bake_lut at one point, by adaptive
 * quadrature to an absolute error of 1e-9. n_dot_v and roughness in 0..1, the
 * limits at 0 included.
 */
ibl_status ibl_reference_lut(ibl_ctx *ctx, double n_dot_v, double roughness,
                             ibl_geometry geometry, double scale_bias[2]);

#ifdef __cplusplus
}
#endif

#endif
