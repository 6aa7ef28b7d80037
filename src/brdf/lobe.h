/* SPDX-License-Identifier: MIT */
/*
 * The lobes of ibl_lobe, each once, as functions of
 *     q = sin^2(psi / 2),
 * psi the angle from R: near the peak of a narrow lobe the cosine has lost its
 * digits, q has not. With N = V = R the half vector is at psi / 2, so
 * N.H^2 = 1 - q, sin^2(theta_h) = q, N.L = 1 - 2 q; and dO = 4 pi dq.
 *
 * A lobe is K = scale D N.L with an integral of 1 over the sphere:
 *   GGX      D = D_ggx (brdf/ggx.h)
 *   Charlie  D = (2 q)^s, s = 1 / (2 alpha): sin(theta_h)^(1 / alpha), but for
 *            its constant (Estevez and Kulla 2017, "Production Friendly
 *            Microfacet Sheen BRDF")
 *   Phong    D = (1 - 2 q)^n, n = (1 / alpha^2 - 1) / 2
 *
 * In v = 2 q, dO = 2 pi dv over 0..1, the integrals are
 *   Charlie  2 pi int v^s (1 - v) dv = 2 pi / ((s + 1) (s + 2))
 *   Phong    2 pi int (1 - v)^(n + 1) dv = 2 pi / (n + 2)
 */
#ifndef IBL_BRDF_LOBE_H
#define IBL_BRDF_LOBE_H

#include <math.h>

#include "brdf/ggx.h"
#include "ibl/ibl.h"

typedef struct ibl_lobe_shape {
    ibl_lobe lobe;
    double alpha;
    double power; /* Charlie's s, Phong's n */
    double scale;
} ibl_lobe_shape;

/* alpha in (0, 1]; below 1e-75, where its square would underflow, as there. */
ibl_lobe_shape ibl_lobe_shape_of(ibl_lobe lobe, double alpha);

/* K, per steradian, 0 below the horizon. q in 0..1 and cosine = 1 - 2 q, each
 * with its own digits: those of q count at the peak of GGX and Phong, those of
 * the cosine on the horizon. */
static inline double ibl_lobe_value(const ibl_lobe_shape *s, double q,
                                    double cosine)
{
    double log_d = 0;
    if (!(cosine > 0))
        return 0;
    switch (s->lobe) {
    case IBL_LOBE_GGX:
        return s->scale * ibl_ggx_d_sincos(sqrt(q), sqrt(1 - q), s->alpha) *
               cosine;
    case IBL_LOBE_CHARLIE:
        log_d = s->power * (cosine < 0.5 ? log1p(-cosine) : log(2 * q));
        break;
    case IBL_LOBE_PHONG:
        log_d = s->power * (q < 0.25 ? log1p(-2 * q) : log(cosine));
        break;
    }
    return s->scale * exp(log_d) * cosine;
}

#endif
