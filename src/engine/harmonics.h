/* SPDX-License-Identifier: MIT */
/*
 * Nine spherical harmonics as engines store them. sh has at least nine
 * coefficients of radiance, 3 doubles each, as ibl_bake_sh makes them: order
 * l (l + 1) + m, no Condon-Shortley phase.
 */
#ifndef ENGINE_HARMONICS_H
#define ENGINE_HARMONICS_H

#include <stddef.h>

enum {
    IBL_SH_NINE = 9 /* coefficients up to l = 2 */
};

typedef enum ibl_sh_format {
    IBL_SH_NONE,
    IBL_SH_CMGEN, /* lines of Filament's cmgen: shader form, with names */
    IBL_SH_THREE, /* a JSON array for LightProbe.sh.fromArray: radiance */
    IBL_SH_CESIUM /* a JSON array for Cartesian3.unpackArray: shader form */
} ibl_sh_format;

/* Indexed by ibl_sh_format, ended by NULL. */
extern const char *const ibl_sh_format_names[];

/* The shader form: E/pi is the sum of shader[i] times 1, y, z, x, xy, yz,
 * 3zz - 1, zx, xx - yy. Filament calls it pre-scaled. */
void ibl_sh_shader(const double *sh, double shader[IBL_SH_NINE][3]);

/*
 * Babylon's polynomial, in the order x y z xx yy zz yz zx xy. Its shader turns
 * it back into harmonics and takes the cosine's factors 1, 2/3, 1/4 off, so
 * they are in it twice: SphericalPolynomial.FromHarmonics multiplies by them
 * what has been convolved already.
 */
void ibl_sh_polynomial(const double *sh, double polynomial[IBL_SH_NINE][3]);

/* Coefficients of irradiance E of EXT_lights_image_based, in Babylon's basis,
 * which has the Condon-Shortley phase. */
void ibl_sh_gltf(const double *sh, double gltf[IBL_SH_NINE][3]);

/* The least E/pi of each channel that nine coefficients give, over 1,536
 * directions. */
void ibl_sh_least(const double *sh, double least[3]);
/* Multiplies the coefficients of each degree l by sinc(l / window)^4, as
 * Filament's cmgen does, and by 0 from l = window on. INFINITY: by 1. */
void ibl_sh_window(int degree, double window, double *sh);
/* The widest window with which no E/pi of nine coefficients is negative. */
double ibl_sh_widest_window(const double *sh);

/* The text of a format; of NONE the value of the key sh of Filament's KTX: nine
 * lines of three numbers. The caller must free it; NULL: no memory. */
char *ibl_sh_text(ibl_sh_format format, const double *sh);

#endif
