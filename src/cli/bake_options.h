/* SPDX-License-Identifier: MIT */
/* The bake's command line as one struct. */
#ifndef CLI_BAKE_OPTIONS_H
#define CLI_BAKE_OPTIONS_H

#include "cli/common_options.h"
#include "cli/judge.h"

typedef struct ibl_opts {
    ibl_common common;
    const char *input; /* "-": standard input; NULL: none (only the LUT) */
    const char *directory;
    const char *name;
    ibl_container format;
    ibl_pixel pixel; /* of the cubes */
    ibl_overflow overflow;
    unsigned only; /* bit n: ibl_output_kind n is wanted */
    ibl_bake_options bake;
    ibl_lut_options lut;
    const char *preview;
    const char *depfile;
    int sync;    /* to the disk before the bake ends */
    int timings; /* stage times in the sidecar */
    int verify;
    double max_error; /* of verify; NAN: none */
    ibl_judge_options judge;
    char stem[256]; /* holds name when it comes from input */
} ibl_opts;

/* The parts of ibl_bake_command that parse; strings point into argv or into
 * the settings. */
extern const ibl_section *const ibl_bake_sections[];
void ibl_bake_defaults(void *settings);
bool ibl_bake_take(void *settings, const char *word);
bool ibl_bake_validate(void *settings);

/* The options that affect only sampled levels, of those that are not as by
 * default: "--samples, --jitter"; "" for none. */
enum {
    IBL_SAMPLING_BYTES = 64
};
void ibl_sampling_given(const ibl_opts *o, char text[IBL_SAMPLING_BYTES]);

#endif
