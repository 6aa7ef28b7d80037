/* SPDX-License-Identifier: MIT */
/* The commands, and the options that they share. */
#ifndef CLI_COMMON_OPTIONS_H
#define CLI_COMMON_OPTIONS_H

#include <ibl/ibl.h>
#include <ibl/io.h>

#include "common/option.h"

extern const ibl_command ibl_bake_command;
extern const ibl_command ibl_verify_command;
extern const ibl_command ibl_bench_command;
extern const ibl_command ibl_probes_command;

/* The first member of every command's settings. */
typedef struct ibl_common {
    ibl_read_options read;
    int threads;
    ibl_isa isa;
    int quiet;
    int verbose;
} ibl_common;

extern const ibl_section ibl_input_section;   /* read: of ibl_common */
extern const ibl_section ibl_running_section; /* the rest, --help, --version */

ibl_common ibl_common_default(void);
bool ibl_common_validate(const ibl_common *c);

/* The outputs of a bake, in the order in which they are made. */
typedef enum ibl_output_kind {
    IBL_OUTPUT_SKYBOX,
    IBL_OUTPUT_SPECULAR,
    IBL_OUTPUT_IRRADIANCE,
    IBL_OUTPUT_LUT,
    IBL_OUTPUT_JSON,
    IBL_OUTPUT_COUNT
} ibl_output_kind;

/* "skybox", "specular", "irradiance", "lut" or "json". */
const char *ibl_output_name(ibl_output_kind kind);
/* The same as sidecars and keys have it: "brdf_lut" for "lut". */
const char *ibl_output_content(ibl_output_kind kind);

/* Of the table that goes with cubes: rg32f with rgba32f, else rg16f. */
ibl_pixel ibl_lut_pixel(ibl_pixel cubes);

/* Of a cube of that size, down to 1x1. */
int ibl_most_levels(int size);

/* An environment's name without directory and extension; "env" for standard
 * input or none. False, after a line on stderr, if it does not fit. */
bool ibl_stem(const char *input, char *stem, size_t size);

/* Values of --rotate, into a double. */
#define IBL_ROTATE_ALLOWED                                                     \
    "-360 to 360, learnopengl, threejs (both 0) or cmgen (-90)"
bool ibl_rotate_parse(void *yaw_deg, const char *value);

/* --version: the program, what it was built with, what it runs on. */
void ibl_version_print(FILE *to);
/* "gcc 12.2.0" */
const char *ibl_version_compiler(void);
/* Of the source, as git describes it; "" if it did not. */
const char *ibl_version_revision(void);

#endif
