/* SPDX-License-Identifier: MIT */
/* Baked files, of iblbake or of other programs, ready to be judged. */
#ifndef CLI_VERIFY_FILES_H
#define CLI_VERIFY_FILES_H

#include "cli/judge_report.h"
#include "cli/verify.h"

/* A file, or what a pattern names. */
typedef struct ibl_verify_file {
    char *path;      /* NULL: none of that kind */
    ibl_pixel pixel; /* IBL_PIXEL_COUNT: none */
    int levels;
    ibl_cube level[IBL_MAX_LEVELS]; /* one each, faces as ours */
    size_t mended[IBL_MAX_LEVELS];  /* texels that were not finite */
    ibl_lobe lobe;                  /* of a specular chain */
    double roughness[IBL_MAX_LEVELS];
    double scale; /* of an irradiance map */
} ibl_verify_file;

typedef struct ibl_verify_files {
    ibl_verify_file cubes[IBL_VERIFY_LUT];
    char *lut_path;
    ibl_lut lut;
    ibl_pixel lut_pixel;
    ibl_geometry geometry;
    double yaw_deg;
} ibl_verify_files;

/* Finds and reads what opts names, with what it means. Fails with one
 * message; ibl_verify_files_free also then. */
ibl_status ibl_verify_files_read(const ibl_verify_opts *opts, ibl_ctx *ctx,
                                 ibl_console *console, ibl_verify_files *files);
void ibl_verify_files_free(ibl_verify_files *files);

/* Judges every cube of the files; judge has their yaw. */
ibl_status ibl_verify_judge(const ibl_verify_files *files, ibl_judge *judge,
                            ibl_console *console, ibl_report *report);

#endif
