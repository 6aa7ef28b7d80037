/* SPDX-License-Identifier: MIT */
/*
 * What a shader draws with baked files, against the light that the surface
 * reflects.
 *
 * Pairs of a normal and a view are drawn so that normals are uniform over the
 * sphere, N.V has the density 2 N.V (that of the pixels of a sphere) and the
 * view's azimuth is uniform; but half of the reflected directions are within 20
 * degrees of the environment's brightest pixel, a quarter of all within 7 and a
 * tenth within 2.5, and grazing views are as frequent as others. Weights undo
 * that.
 *
 * With S the shader's colour and T the truth, |.| over R, G and B,
 *     nRMSE = sqrt(sum w |S - T|^2 / sum w |T|^2).
 * From T to S, one exact thing after the other is replaced by that of the
 * shader. A part is the nRMSE of two neighbouring stages:
 *   0  T, the integral of the BRDF
 *   1  the exact lobes that the shader looks up, with the roughness and in the
 *      directions that it takes, and its share of exact irradiance; times
 *      F0 A + B by the exact table
 *   2  the same with the exact lobes of the levels' roughnesses, blended by the
 *      lod
 *   3  lookups in the files
 *   4  S: F0 A + B by the files' table
 */
#ifndef CLI_RENDERED_H
#define CLI_RENDERED_H

#include <jansson.h>
#include <stdio.h>

#include "cli/verify_files.h"

extern const char *const ibl_shader_names[];

typedef enum ibl_part {
    IBL_PART_VIEW,   /* stage 1 - stage 0 */
    IBL_PART_LEVELS, /* 2 - 1 */
    IBL_PART_TEXELS, /* 3 - 2 */
    IBL_PART_TABLE,  /* 4 - 3 */
    IBL_PARTS
} ibl_part;

/* "view", "levels", "texels", "table" */
extern const char *const ibl_part_names[];

/* 512 directions, roughness .1 .2 .3 .4 .5 .7 .85 1, F0 1 and .04. */
ibl_rendered_options ibl_rendered_options_default(void);

typedef struct ibl_rendered_row {
    double f0, roughness; /* roughness NAN: means over the roughnesses */
    double nrmse;
    double median, p95; /* of the relative error, ibl_relative_error */
    double ratio;       /* of the means of R + G + B over all pairs */
    double part[IBL_PARTS];
} ibl_rendered_row;

typedef struct ibl_rendered {
    ibl_rendered_options options; /* shader: not AUTO */
    /* For each F0 its roughnesses, then their mean. */
    int count;
    ibl_rendered_row rows[IBL_RENDERED_LIST * (IBL_RENDERED_LIST + 1)];
} ibl_rendered;

/* Judges the specular chain of files. Lights that were taken out of the map are
 * added in stages 1 to 4, by ibl_disc_brdf. False: no memory, or after a
 * message through ctx or console. */
bool ibl_rendered_judge(const ibl_verify_files *files, ibl_ctx *ctx,
                        const ibl_judged_map *map,
                        const ibl_rendered_options *options,
                        ibl_console *console, ibl_rendered *out);

/* The mean row of an F0, by its index. */
const ibl_rendered_row *ibl_rendered_mean(const ibl_rendered *rendered, int f0);

/* Whether the mean nRMSE of every F0 is at most `most` (NAN: no limit). If not,
 * writes the reason to why, in one line. */
bool ibl_rendered_passes(const ibl_rendered *rendered, double most, char *why,
                         size_t size);

void ibl_rendered_print(const ibl_rendered *rendered, FILE *to);
json_t *ibl_rendered_json(const ibl_rendered *rendered); /* NULL: no memory */

/*
 * Draws nRMSE and its parts over roughness as a PNG file, a panel for each F0.
 * The caller must free *png. False: no memory.
 */
bool ibl_rendered_png(const ibl_rendered *rendered, void **png, size_t *size);

#endif
