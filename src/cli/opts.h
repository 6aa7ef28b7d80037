/* SPDX-License-Identifier: MIT */
/* The bake's command line as one struct. */
#ifndef CLI_OPTS_H
#define CLI_OPTS_H

#include <stdbool.h>
#include <stddef.h>

#include <ibl/ibl.h>
#include <ibl/io.h>

#include "cli/judge.h"
#include "cli/option.h"

/* What a bake can leave, in the order in which it is made. Bit n of
 * ibl_opts.only is output n. */
typedef enum ibl_output_kind {
    IBL_OUTPUT_SKYBOX,
    IBL_OUTPUT_SPECULAR,
    IBL_OUTPUT_IRRADIANCE,
    IBL_OUTPUT_LUT,
    IBL_OUTPUT_JSON,
    IBL_OUTPUT_COUNT
} ibl_output_kind;

typedef struct ibl_opts {
    ibl_common common;
    const char *input; /* "-": standard input; NULL: none (LUT alone) */
    const char *directory;
    const char *name; /* NULL until ibl_opts_finish finds it */
    int format;       /* ibl_container */
    int pixel;        /* ibl_pixel of the cubes */
    int overflow;     /* ibl_overflow */
    unsigned only;    /* outputs that are wanted */
    int skybox;       /* edge; 0: none */
    ibl_specular_options specular;
    double roughness[2]; /* smallest and largest that is used */
    int method;          /* ibl_method */
    int lobe;            /* ibl_lobe */
    int mapping;         /* ibl_roughness_map */
    int pdf_mip;
    char sampling[64]; /* options that only sampled levels heed, as given */
    ibl_irradiance_options irradiance;
    ibl_lut_options lut;
    int geometry;  /* ibl_geometry */
    int sh_degree; /* of the sidecar's spherical harmonics */
    double yaw_deg;
    const char *preview;
    const char *depfile;
    int sync;    /* to the disk before the bake ends */
    int timings; /* stage times in the sidecar */
    int verify;
    double max_error; /* of verify; NAN: none */
    ibl_judge_options judge;
    char stem[256]; /* holds name when it comes from input */
} ibl_opts;

/* Whether the bake leaves an output. */
bool ibl_opts_wants(const ibl_opts *o, ibl_output_kind kind);
/* "skybox", "specular", "irradiance", "lut" or "json". */
const char *ibl_output_name(ibl_output_kind kind);

/* The pixel of the LUT: rg32f where the cubes are rgba32f, else rg16f. */
ibl_pixel ibl_opts_lut_pixel(const ibl_opts *o);

/* Options before any argument was seen. */
ibl_opts ibl_opts_default(void);
/* The take and the finish of ibl_bake_command; strings point into argv or
 * into the settings. */
bool ibl_opts_take(void *settings, const char *word);
bool ibl_opts_finish(void *settings);

/* An environment's name without directory and extension; "env" for standard
 * input or none. False, after a line on stderr, if it does not fit. */
bool ibl_stem(const char *input, char *stem, size_t size);

#endif
