/* SPDX-License-Identifier: MIT */
/* Baked files, of iblbake or of other programs, ready to be judged. */
#ifndef CLI_VERIFY_FILES_H
#define CLI_VERIFY_FILES_H

#include "cli/console.h"
#include "cli/judge_report.h"

enum {
    IBL_VERIFY_KINDS = IBL_OUTPUT_LUT + 1 /* outputs that can be judged */
};

/* Roughness of the levels as --roughness-map has it. */
typedef struct ibl_verify_map {
    int given; /* 0: what the files say, else linear */
    ibl_roughness_map map;
    int count; /* of list; 0: by map */
    double list[IBL_MAX_LEVELS];
} ibl_verify_map;

/* The command line of iblbake verify. */
typedef struct ibl_verify_opts {
    ibl_common common;
    const char *input;                   /* NULL: only a table */
    const char *directory;               /* NULL: only the files below */
    const char *name;                    /* of the files in directory */
    const char *files[IBL_VERIFY_KINDS]; /* NULL: look in directory */
    char face_names[IBL_FACES][16];
    ibl_verify_map roughness;
    int lobe;       /* 0: what the files say, else GGX; 1 + ibl_lobe */
    double yaw_deg; /* NAN: what the files say, else 0 */
    int axes[3];    /* +-1, 2, 3: our axis that the files' X, Y, Z are */
    int scale;      /* 0: E/pi, 1: E */
    int geometry;   /* 0: what the files say, else smith; 1 + ibl_geometry */
    ibl_judge_options judge;
    const char *json;    /* "-": standard output */
    const char *heatmap; /* NULL: none */
    double max_error;    /* NAN: none */
    char stem[256];      /* holds name when it comes from input */
} ibl_verify_opts;

typedef struct ibl_verify_files {
    char *path[IBL_VERIFY_KINDS]; /* or a pattern; NULL: none */
    int count;                    /* of levels, by kind */
    ibl_judge_level level[IBL_REPORT_ROWS];
    ibl_cube cube[IBL_REPORT_ROWS]; /* texels of each, faces as ours */
    ibl_lut lut;                    /* empty: none */
    ibl_pixel lut_pixel;
    ibl_geometry geometry;
    double yaw_deg;
} ibl_verify_files;

/* "0,0.25,1", each from 0 to 1. Returns how many, 0: it is no such list. */
int ibl_roughness_list(const char *text, double list[IBL_MAX_LEVELS]);

/* Finds and reads what opts names, with what it means. False after one
 * message; ibl_verify_files_free also then. */
bool ibl_verify_files_read(const ibl_verify_opts *opts, ibl_ctx *ctx,
                           ibl_console *console, ibl_verify_files *files);
void ibl_verify_files_free(ibl_verify_files *files);

/* Judges every level, and the table, by the report's options. judge has the
 * files' yaw; NULL if there is only a table. False: as ibl_report_add. */
bool ibl_verify_judge(const ibl_verify_files *files, ibl_ctx *ctx,
                      ibl_judge *judge, ibl_console *console,
                      ibl_report *report);

#endif
