/* SPDX-License-Identifier: MIT */
/* One bake of the program: what was requested, read, made and written, and
 * the parts of bake.c, which plan, describe and judge its files. */
#ifndef CLI_BAKE_RECORD_H
#define CLI_BAKE_RECORD_H

#include "cli/console.h"
#include "cli/judge_report.h"

/* The command line; strings point into argv, or name to stem. */
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

/* The options that affect only sampled levels, of those that are not as by
 * default: "--samples, --jitter"; "" for none. */
enum {
    IBL_SAMPLING_BYTES = 64
};
void ibl_sampling_given(const ibl_opts *o, char text[IBL_SAMPLING_BYTES]);

/* Bakes what the options say; the exit status. */
int ibl_bake_run(const void *settings);

/* "spectral", "sampled", or "mixed" where levels differ; "environment" where
 * all are that. */
const char *ibl_bake_specular_method(const ibl_bake *b);

/* Sets the key/values that a texture of the bake carries: see FILES in the
 * manual page. */
bool ibl_texture_metadata(const ibl_bake *b, ibl_output_kind kind,
                          ibl_texture *tex);

/* NAME.json: see FILES in the manual page. Says nothing of threads or times
 * unless --timings was given, so that equal bakes give equal bytes. The text
 * is the caller's to free; NULL: no memory. */
char *ibl_sidecar_text(const ibl_bake *b);

/*
 * A contact sheet as a PNG file: the environment, each specular level, the
 * skybox and the irradiance as unfolded cubes (+Y on top, -X +Z +X -Z in the
 * middle row, -Y below), the LUT with N.V to the right and roughness upwards.
 * All radiance has the same exposure. *png is the caller's to free. False: no
 * memory.
 */
bool ibl_preview_png(const ibl_bake *b, void **png, size_t *size);

/* Sets the path of every file that is wanted. Refuses, with a message and
 * before the work, what could not be written after it, and outputs that would
 * replace the input or, by chance, those of another environment. The output
 * directory is there. */
bool ibl_targets_plan(ibl_bake *b);

/* The rule "outputs: input" that make and ninja include, no prerequisite for
 * standard input. The text is the caller's to free; NULL: no memory. */
char *ibl_depfile_text(const ibl_bake *b);

/* --verify. Judges the file that a texture is written as and adds to the
 * report. */
bool ibl_bake_judge(ibl_bake *b, ibl_output_kind kind, const ibl_texture *tex);
/* Prints the report; fails, with a message, if it is above --max-error. */
bool ibl_bake_judged(const ibl_bake *b);

#endif
