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
#include <stdio.h>

#include "cli/common_options.h"
#include "cli/rendered.h"

typedef struct ibl_judge_options {
    int texels; /* about, of each level; 24 or more, default 128 */
    int all;    /* judge every texel instead */
    int seed;   /* default 1 */
    int grid;   /* 1: also a grid of texels, for ibl_heatmap_png */
} ibl_judge_options;

ibl_judge_options ibl_judge_options_default(void);

typedef struct ibl_judge_level {
    ibl_output_kind content; /* SKYBOX: means over texels; SPECULAR; IRRADIANCE.
                                In verdicts also LUT, and JSON for harmonics */
    int number;              /* index in its chain; of harmonics their degree */
    ibl_lobe lobe;           /* SPECULAR */
    double roughness;        /* SPECULAR, 0..1; 0 is judged as SKYBOX */
    double scale;            /* of the truth: 1, or pi if irradiance is E */
    ibl_cube texels; /* one level, in the world's axes; in verdicts only its
                        size */
    int base;        /* SKYBOX: size of level 0 of its chain */
    ibl_pixel pixel; /* format in the file; IBL_PIXEL_COUNT: none */
    double loss;     /* of a format of blocks, nRMSE of the whole level by it;
                        NAN: not known */
    size_t mended;   /* not finite when read; counted in nonfinite */
} ibl_judge_level;

/* A texel that was judged. */
typedef struct ibl_judged {
    double direction[3], error; /* relative */
} ibl_judged;

typedef struct ibl_verdict {
    ibl_judge_level level;
    size_t count; /* texels judged */
    ibl_measured measured;
    double worst, worst_at[3]; /* relative error, direction; of a table N.V and
                                  roughness */
    bool over;           /* light is above the largest value of the format */
    size_t nonfinite;    /* texels of the level with NaN or Inf */
    double coefficients; /* of harmonics: relative error of these, whereas
                            measured is irradiance, to all degrees */
    ibl_judged *texels;  /* of levels; else NULL */
    size_t texel_count;  /* count, and those of the grid */
} ibl_verdict;

/* An environment to judge by. */
typedef struct ibl_judge ibl_judge;

/* Borrows ctx and env until ibl_judge_free. yaw_deg is that of
 * ibl_cube_from_latlong. The functions return NULL or false if there is no
 * memory, or after a message through ctx. */
ibl_judge *ibl_judge_create(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                            const ibl_judge_options *opts);
void ibl_judge_free(ibl_judge *judge); /* NULL is allowed */

extern const char *const ibl_shader_names[];

/* A row of what is rendered. */
typedef struct ibl_drawn_row {
    double f0, roughness; /* roughness NAN: means over the roughnesses */
    ibl_measured measured;
} ibl_drawn_row;

enum {
    IBL_REPORT_ROWS = 2 * IBL_MAX_LEVELS + 3,
    IBL_DRAWN_ROWS = 18
};

/* Verdicts on a set; zeroed: none. */
typedef struct ibl_report {
    ibl_judge_options options;
    int count;
    ibl_verdict rows[IBL_REPORT_ROWS];
    ibl_shader shader;
    int directions;         /* 0: not rendered */
    int drawn_count, vague; /* vague: rows as of ibl_measured_is_vague */
    ibl_drawn_row drawn[IBL_DRAWN_ROWS]; /* of each F0, then its mean */
} ibl_report;

/* Judge a level; harmonics of radiance, as of ibl_bake_sh; a table, whose
 * errors are absolute, but relative to integrals above 1, and whose nRMSE is
 * their root mean square over the channels. They add the verdict. */
bool ibl_report_level(ibl_report *report, const ibl_judge *judge,
                      const ibl_judge_level *level);
bool ibl_report_sh(ibl_report *report, const ibl_judge *judge, int degree,
                   const double *sh);
bool ibl_report_lut(ibl_report *report, ibl_ctx *ctx, const ibl_lut *lut,
                    ibl_geometry geometry);
/* Measures what is rendered, with the parts if there is rest, by the usual grid
 * of materials, in place of what was. */
bool ibl_report_drawn(ibl_report *report, const ibl_truth *truth,
                      const ibl_drawn *set, const ibl_reference *rest);
void ibl_report_free(ibl_report *report);

/* Whether all values are finite, and every nRMSE, the table's largest error and
 * that of coefficients are at most max_error, and the mean nRMSE of every F0 as
 * rendered at most max_rendered (NAN: no limit). If not, writes the reason to
 * why, in one line. */
bool ibl_report_passes(const ibl_report *report, double max_error,
                       double max_rendered, char *why, size_t size);

void ibl_report_print(const ibl_report *report, FILE *to);
/* {"texels": .., "seed": .., "levels": [..], "harmonics": {..}, "lut": {..}, or
 * "rendered": {..}}; NULL: no memory. */
json_t *ibl_report_json(const ibl_report *report);

/*
 * Draws the errors as a PNG file: each judged level as an unfolded cube whose
 * cells have the largest relative error judged there, and the colour scale
 * below. The caller must free *png. False: no memory.
 */
bool ibl_heatmap_png(const ibl_report *report, void **png, size_t *size);

#endif
