/* SPDX-License-Identifier: MIT */
/*
 * Measures the errors of baked maps against <ibl/reference.h>.
 *
 * A level is judged at about as many texels as asked, half of them evenly over
 * the sphere, half near the light of the map, so that a sun is not left to
 * chance. Weights undo that: figures are those of all texels, with standard
 * errors. A level with few texels is judged at all of them. The choice depends
 * on the map, the level's size and the seed, never on what is judged.
 *
 * iblbake-verify(1) defines the figures. Texels that are not finite are counted
 * over the whole level and excluded from everything else.
 */
#ifndef CLI_JUDGE_H
#define CLI_JUDGE_H

#include <jansson.h>

#include "cli/common_options.h"
#include "cli/rendered.h"

typedef struct ibl_judge_options {
    int texels; /* about, of each level; 24 or more, default 128 */
    int all;    /* judge every texel instead */
    int seed;   /* default 1 */
} ibl_judge_options;

static inline ibl_judge_options ibl_judge_options_default(void)
{
    return (ibl_judge_options){.texels = 128, .seed = 1};
}

/* An environment to judge by. */
typedef struct ibl_judge ibl_judge;

/* Borrows env until ibl_judge_free. yaw_deg is that of ibl_cube_from_latlong.
 * The functions return NULL or false after a message through ctx. */
ibl_judge *ibl_judge_create(ibl_ctx *ctx, const ibl_image *env, double yaw_deg);
void ibl_judge_free(ibl_judge *judge); /* NULL is allowed */

/* A chain whose levels are judged. */
typedef struct ibl_judged {
    ibl_output_kind content; /* SKYBOX: means over texels; SPECULAR;
                                IRRADIANCE: / pi */
    ibl_cube chain;          /* in the world's axes */
    int levels;              /* that are judged */
    ibl_lobe lobe;           /* SPECULAR; so */
    const double *roughness; /* of each level; 0 is judged as SKYBOX */
} ibl_judged;

extern const char *const ibl_shader_names[];

/* Verdicts on a set. */
typedef struct ibl_report {
    ibl_judge_options options;
    /* {"seed": .., "levels": [..], "texels": .., "lut": {..}, "harmonics":
     * {..}, "rendered": {..}} as iblbake-verify(1) writes it; NULL: nothing was
     * judged. To be freed. */
    json_t *json;
} ibl_report;

/* Judge levels; harmonics of radiance, as of ibl_bake_sh, whose texels are
 * irradiance against that of all degrees; a table, whose errors are absolute,
 * but relative to integrals above 1, and whose nRMSE is their root mean square
 * over the channels. They add the verdicts. */
bool ibl_report_levels(ibl_report *report, const ibl_judge *judge,
                       const ibl_judged *judged);
bool ibl_report_sh(ibl_report *report, const ibl_judge *judge, int degree,
                   const double *sh);
bool ibl_report_lut(ibl_report *report, ibl_ctx *ctx, const ibl_lut *lut,
                    ibl_geometry geometry);
/* Measures what is rendered. */
void ibl_report_drawn(ibl_report *report, const ibl_truth *truth,
                      const ibl_drawn *set);

/* Whether all values are finite, and every nRMSE, the table's largest error and
 * that of coefficients are at most max_error, and the mean nRMSE of every F0 as
 * rendered at most max_rendered (NAN: no limit). If not, writes the reason to
 * why, in one line. */
bool ibl_report_passes(const ibl_report *report, double max_error,
                       double max_rendered, char *why, size_t size);

/* The verdicts as tables, to be freed. */
char *ibl_report_text(const ibl_report *report);

#endif
