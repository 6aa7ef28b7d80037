/* SPDX-License-Identifier: MIT */
/* The command line of iblbake verify, and its judging. */
#ifndef CLI_VERIFY_H
#define CLI_VERIFY_H

#include "cli/console.h"
#include "cli/judge.h"

typedef struct ibl_verify_opts {
    ibl_common common;
    const char *input;     /* the environment; NULL: judge only a table */
    const char *directory; /* NULL: use only files */
    const char *name;      /* base name of the files in directory */
    const char *probe;     /* for messages: of a set's probe, or NULL */
    int layer;             /* of arrays of cubes; -1: none */
    const char *files[IBL_CONTENTS]; /* NULL: search */
    unsigned leave;                  /* as in ibl_set_options */
    ibl_set_facts facts; /* of the options below, and roughness and axes */
    double yaw_deg;      /* NAN: what the files say; so */
    int lights;          /* -1, */
    int lobe, scale, table, geometry; /* 0; else 1 and their value */
    ibl_judge_options judge;
    int rendered; /* 1: judge what a shader draws, not texels */
    int directions;
    ibl_shader shader;
    double max_error, max_rendered_error; /* NAN: no limit */
    const char *json;                     /* "-": standard output */
    const char *heatmap;                  /* NULL: none */
    char stem[256]; /* buffer of name if it comes from input */
    ibl_given given;
} ibl_verify_opts;

/* Reads and judges; false after a message. report: zeroed. */
bool ibl_verify(const ibl_verify_opts *opts, ibl_ctx *ctx, ibl_console *console,
                ibl_report *report, json_t *about);

#endif
