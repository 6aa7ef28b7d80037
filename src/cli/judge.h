/* SPDX-License-Identifier: MIT */
/*
 * Measures the errors of baked maps against <ibl/reference.h>.
 *
 * A level of a cube is judged at chosen texels. Each stands for as many texels
 * as its kind has members per chosen one. All statistics are weighted by that
 * number, so that they estimate those of the whole level although hard texels
 * are chosen more often. The kinds; the first that fits counts:
 *   light   the 3x3 texels around each of the environment's brightest pixels
 *           (at least 10 degrees apart); all of them
 *   corner  the three texels at each of the cube's corners; all of them
 *   near    within 20 degrees of the brightest pixel
 *   edge    at the edge of a face
 *   dark    in the darkest tenth of the level
 *   rest    one for each cell of a grid over the faces
 * The choice depends on the environment, the size, the lobe, the roughness, the
 * count and the seed, never on the judged texels.
 *
 * iblbake-verify(1) defines nRMSE, the relative error, the bias and the darkest
 * tenth. Parts of nRMSE:
 *   rounding  that of the truth when it is encoded as the pixel format and
 *             decoded, without the components of overflow
 *   overflow  from components whose truth is above the largest value of the
 *             pixel format, and from components brighter than the truth in or
 *             next to a texel that holds the largest value: light that was
 *             clipped or moved
 * Texels that are not finite are counted over the whole level and excluded from
 * everything else.
 */
#ifndef CLI_JUDGE_H
#define CLI_JUDGE_H

#include "cli/common_options.h"
#include "cli/judge_picks.h"

enum {
    IBL_JUDGE_MIN_TEXELS = 24,
    IBL_JUDGE_TEXELS = 256 /* default */
};

ibl_judge_options ibl_judge_options_default(void);

/* A level to judge: a cube of faces of one size. */
typedef struct ibl_judge_level {
    ibl_output_kind
        content;      /* SKYBOX: means over texels; SPECULAR; IRRADIANCE */
    int number;       /* in its chain */
    ibl_lobe lobe;    /* SPECULAR */
    double roughness; /* SPECULAR, 0..1; 0 is judged as SKYBOX */
    double scale;     /* what the truth is multiplied by: 1; pi where an
                         irradiance map holds E */
    int size;         /* of the faces */
    int base;         /* SKYBOX: size, or that of the level 0 that this is
                         a mip of */
    float *texels;    /* 3 * 6 * size * size, as a level of ibl_cube */
    ibl_pixel pixel;  /* that they were decoded from; IBL_PIXEL_COUNT:
                         none, they are what they are */
    size_t mended;    /* texels that were not finite before a reader
                         mended them: counted as such */
} ibl_judge_level;

/* Relative errors of some texels. */
typedef struct ibl_error_spread {
    size_t count;
    double median, p95, worst;
} ibl_error_spread;

typedef struct ibl_verdict {
    ibl_judge_level level;  /* texels: NULL */
    ibl_error_spread error; /* of all texels that were judged */
    ibl_error_spread dark;  /* of the darkest tenth: at least one, and all that
                               are as dark as the brightest of them */
    double worst_dir[3];
    double nrmse, bias, rounding, overflow; /* as defined above */
    double rounding_share; /* (rounding / nrmse)^2, at most 1: the part of the
                              squared error that the pixel format explains */
    double overflow_share; /* as rounding_share */
    size_t nonfinite;      /* texels of the level with NaN or Inf */
    ibl_judged_texel *texels; /* error.count */
} ibl_verdict;

void ibl_verdict_free(ibl_verdict *v); /* NULL and zeroed are fine */

/* An environment with its truth at what was judged until now: levels of the
 * same content, roughness and size are judged again for little. */
typedef struct ibl_judge ibl_judge;

/* Borrows ctx and env until ibl_judge_free. yaw_deg as in
 * ibl_cube_from_latlong. These return NULL or false if there is no memory, or
 * after a message through ctx. */
ibl_judge *ibl_judge_create(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                            const ibl_judge_options *opts);
void ibl_judge_free(ibl_judge *judge); /* NULL is fine */

/* Judges a level; *out is the caller's to free. */
bool ibl_judge_cube_level(ibl_judge *judge, const ibl_judge_level *level,
                          ibl_verdict *out);

/* What encoding changes in n channels, at most 3, that a file holds multiplied
 * by scale; 0 for IBL_PIXEL_COUNT. */
void ibl_judge_loss(ibl_pixel pixel, double scale, const double *values, int n,
                    double *loss);

/* A split-sum table against the integrals, absolute errors over R and G. */
typedef struct ibl_lut_verdict {
    int size;
    size_t count;    /* texels judged: corners, edges, and cells of a grid */
    double max, rms; /* rms is weighted as above */
    double worst_n_dot_v, worst_roughness;
    double rounding; /* rms that the pixel format leaves */
    size_t nonfinite;
} ibl_lut_verdict;

/* pixel as in ibl_judge_level. */
bool ibl_judge_lut(ibl_ctx *ctx, const ibl_lut *lut, ibl_pixel pixel,
                   ibl_geometry geometry, const ibl_judge_options *opts,
                   ibl_lut_verdict *out);

#endif
