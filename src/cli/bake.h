/* SPDX-License-Identifier: MIT */
/* One bake of the program: what was asked for, read, made and written. */
#ifndef CLI_BAKE_H
#define CLI_BAKE_H

#include "cli/console.h"
#include "cli/judge_report.h"
#include "cli/opts.h"

/* An output file. path is set before anything is baked, the rest when the
 * file is made. */
typedef struct ibl_baked {
    char *path;        /* NULL: not wanted */
    size_t bytes;      /* of the file */
    ibl_texture shape; /* of the texture, without data and keys */
    size_t saturated;  /* values beyond what the pixel holds */
    ibl_overflow_level beyond[IBL_MAX_LEVELS]; /* of a cube */
} ibl_baked;

typedef struct ibl_bake {
    const ibl_opts *opts;
    ibl_console *console;
    ibl_ctx *ctx;
    ibl_outputs *outputs;
    int width, height;      /* of the environment */
    ibl_image env;          /* in memory if something looks at it again */
    ibl_read_report report; /* of reading it */
    ibl_bake_result made;   /* of it; empty where not wanted */
    ibl_lut lut;
    ibl_judge *judge;  /* with --verify, once a cube was judged */
    ibl_report judged; /* empty without --verify */
    ibl_baked files[IBL_OUTPUT_COUNT];
} ibl_bake;

/* Does what opts asks for; all of it is written, or nothing. Returns the exit
 * status: 0, or 1 after one line on stderr. */
int ibl_bake_run(const ibl_opts *opts);

/* Whether only a part of the range of roughness was asked for. */
bool ibl_bake_is_part(const ibl_bake *b);
/* Whether any level of the specular chain was sampled. */
bool ibl_bake_is_sampled(const ibl_bake *b);
/* "spectral", "sampled", or "mixed" where levels differ; "environment" where
 * all are that. */
const char *ibl_bake_specular_method(const ibl_bake *b);
/* "spectral" or "hemisphere grid"; "quadrature" or "hammersley". */
const char *ibl_bake_irradiance_method(const ibl_bake *b);
const char *ibl_bake_lut_method(const ibl_bake *b);

#endif
