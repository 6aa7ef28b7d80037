/* SPDX-License-Identifier: MIT */
/* One bake of the program: what was requested, read, made and written, and
 * what textures and the sidecar say of it. */
#ifndef CLI_BAKE_RECORD_H
#define CLI_BAKE_RECORD_H

#include "cli/bake_options.h"
#include "cli/console.h"
#include "cli/judge_report.h"

/* An output file. path is set before anything is baked, the rest when the
 * file is made. */
typedef struct ibl_baked {
    char *path;        /* NULL: not wanted */
    size_t bytes;      /* of the file */
    ibl_texture shape; /* of the texture, without data and keys */
    ibl_overflow_report overflow;
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

/* Whether only a part of the range of roughness was requested. */
bool ibl_bake_is_part(const ibl_bake *b);
/* Whether any level of the specular chain was sampled. */
bool ibl_bake_is_sampled(const ibl_bake *b);
/* "spectral" or "sampled" of a level; "environment": it is that. */
const char *ibl_level_method(const ibl_specular_level *level);
/* The same of the whole chain; "mixed": both occur. */
const char *ibl_bake_specular_method(const ibl_bake *b);
/* "spectral" or "hemisphere grid"; "quadrature" or "hammersley". */
const char *ibl_bake_irradiance_method(const ibl_bake *b);
const char *ibl_bake_lut_method(const ibl_bake *b);

/* Sets the key/values that a texture of the bake carries: see FILES in the
 * manual page. */
ibl_status ibl_texture_metadata(const ibl_bake *b, ibl_output_kind kind,
                                ibl_texture *tex);

#endif
