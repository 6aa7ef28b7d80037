/* SPDX-License-Identifier: MIT */
/*
 * Measures the errors of baked maps against <ibl/reference.h>.
 *
 * A level of a cube is judged at chosen texels. The weight of a chosen texel is
 * the number of texels of its kind divided by the number chosen of this kind.
 * All statistics use the weights. So they estimate those of the whole level,
 * although hard texels are chosen more often. The first kind that fits counts:
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
 *   rounding  from encoding the reference in the pixel format, without the
 *             components of overflow
 *   overflow  from components whose reference is above the largest value of
 *             the pixel format, and from components brighter than the
 *             reference in or next to a texel that holds the largest value:
 *             light that was clipped or moved
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

/* A level to judge: a cube of faces of one size, or a flat one. */
typedef struct ibl_judge_level {
    ibl_output_kind
        content;      /* SKYBOX: means over texels; SPECULAR; IRRADIANCE */
    int number;       /* index in its chain */
    ibl_lobe lobe;    /* SPECULAR */
    double roughness; /* SPECULAR, 0..1; 0 is judged as SKYBOX */
    double scale;     /* of the reference: 1, or pi if irradiance is E */
    ibl_projection projection;
    int size;        /* texels along a face's edge; see ibl_projection */
    int base;        /* SKYBOX: size of level 0 of its chain */
    float *texels;   /* laid out as a level of ibl_cube */
    ibl_pixel pixel; /* format in the file; IBL_PIXEL_COUNT: none */
    double loss;     /* nRMSE of the whole level by the format, used for
                        pixels of blocks; NAN: not known */
    size_t mended;   /* not finite when read; counted in nonfinite */
} ibl_judge_level;

/* Distribution of the relative errors of some texels. */
typedef struct ibl_error_spread {
    size_t count;
    double median, p95, worst;
} ibl_error_spread;

/* Sorts texels by error; returns their weighted statistics. */
ibl_error_spread ibl_error_spread_of(ibl_judged_texel *texels, size_t count);

typedef struct ibl_verdict {
    ibl_judge_level level;  /* texels: NULL */
    ibl_error_spread error; /* of all judged texels */
    ibl_error_spread dark;  /* of the darkest tenth by weight, at least one
                               texel, including ties at its upper limit */
    double worst_dir[3];
    double nrmse, bias, rounding, overflow; /* as defined above */
    double rounding_share; /* (rounding / nrmse)^2, at most 1: the part of the
                              squared error caused by the pixel format. Of
                              blocks level.loss is the rounding; both are NAN if
                              it is not known */
    double overflow_share; /* the same for overflow */
    size_t nonfinite;      /* texels of the level with NaN or Inf */
    ibl_judged_texel *texels; /* error.count */
} ibl_verdict;

void ibl_verdict_free(ibl_verdict *v); /* NULL and zeroed are allowed */

/* An environment and the reference values computed so far. Judging another
 * level with the same content, roughness and size is cheap. */
typedef struct ibl_judge ibl_judge;

/* Borrows ctx and env until ibl_judge_free. yaw_deg is that of
 * ibl_cube_from_latlong. The functions return NULL or false if there is no
 * memory, or after a message through ctx. */
ibl_judge *ibl_judge_create(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                            const ibl_judge_options *opts);
void ibl_judge_free(ibl_judge *judge); /* NULL is allowed */

/* Judges a level; the caller must free *out. */
bool ibl_judge_cube_level(ibl_judge *judge, const ibl_judge_level *level,
                          ibl_verdict *out);

/* The change by encoding of n channels, at most 3, that a file holds multiplied
 * by scale. 0 for IBL_PIXEL_COUNT, and for blocks, whose texels are not
 * encoded each for itself. */
void ibl_judge_loss(ibl_pixel pixel, double scale, const double *values, int n,
                    double *loss);

/* Errors of a table against the integrals, over its channels: absolute, but
 * relative to integrals above 1. */
typedef struct ibl_lut_verdict {
    int size;
    size_t count;    /* texels judged: corners, edges, and cells of a grid */
    double max, rms; /* rms is weighted as above */
    double worst_n_dot_v, worst_roughness;
    double rounding; /* rms error caused by the pixel format */
    size_t nonfinite;
} ibl_lut_verdict;

/* pixel as in ibl_judge_level. */
bool ibl_judge_lut(ibl_ctx *ctx, const ibl_lut *lut, ibl_pixel pixel,
                   ibl_geometry geometry, const ibl_judge_options *opts,
                   ibl_lut_verdict *out);

/* An environment in memory, and judges of what was baked from it: the skybox
 * from all of it, the rest perhaps from what was left when lights had been
 * taken out. */
typedef struct ibl_judged_map {
    double yaw_deg;
    ibl_image env, rest; /* rest: empty if no lights are to be taken out */
    ibl_light lights[IBL_MAX_LIGHTS]; /* their directions are turned */
    int light_count;
    ibl_judge *by_env, *by_rest; /* by_rest: NULL with rest empty */
} ibl_judged_map;

/* Reads the environment; most is the number of lights to take out, 0 or less
 * for none. False: after a message through ctx. ibl_judged_map_free is needed
 * also then. */
bool ibl_judged_map_read(ibl_ctx *ctx, ibl_source *source, double yaw_deg,
                         int most, ibl_judged_map *map);
/* Bytes that it takes. */
size_t ibl_judged_map_bytes(const ibl_source *source, int most);
/* Makes the judges. False: no memory, or after a message through ctx. */
bool ibl_judged_map_prepare(ibl_ctx *ctx, const ibl_judge_options *opts,
                            ibl_judged_map *map);
void ibl_judged_map_free(ibl_judged_map *map); /* zeroed is allowed */

/* What the specular and irradiance cubes are made from. */
const ibl_image *ibl_judged_map_rest(const ibl_judged_map *map);
/* The judge of an output. */
ibl_judge *ibl_judged_map_judge(const ibl_judged_map *map,
                                ibl_output_kind kind);

#endif
