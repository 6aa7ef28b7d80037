/* SPDX-License-Identifier: MIT */
/* What a shader draws with a set of files, measured, as a table and as JSON. */
#ifndef CLI_RENDERED_REPORT_H
#define CLI_RENDERED_REPORT_H

#include <jansson.h>
#include <stdio.h>

#include "cli/rendered.h"
#include "cli/verify_files.h"

extern const char *const ibl_shader_names[];

typedef struct ibl_rendered_row {
    double f0, roughness; /* roughness NAN: means over the roughnesses */
    ibl_measured measured;
} ibl_rendered_row;

typedef struct ibl_rendered {
    ibl_truth_options options;
    ibl_shader shader; /* not AUTO */
    /* For each F0 its roughnesses, then their mean. */
    int count;
    ibl_rendered_row *rows;
} ibl_rendered;

/* Judges the specular chain of files. Lights that were taken out of the map are
 * drawn, too, by ibl_disc_brdf. False: no memory, or after a message through
 * ctx or console. ibl_rendered_free is needed also then. */
bool ibl_rendered_judge(const ibl_verify_files *files, ibl_ctx *ctx,
                        const ibl_judged_map *map,
                        const ibl_truth_options *options, ibl_shader shader,
                        ibl_console *console, ibl_rendered *out);
void ibl_rendered_free(ibl_rendered *rendered); /* zeroed is allowed */

/* Whether the mean nRMSE of every F0 is at most `most` (NAN: no limit). If not,
 * writes the reason to why, in one line. */
bool ibl_rendered_passes(const ibl_rendered *rendered, double most, char *why,
                         size_t size);

void ibl_rendered_print(const ibl_rendered *rendered, FILE *to);
json_t *ibl_rendered_json(const ibl_rendered *rendered); /* NULL: no memory */

#endif
