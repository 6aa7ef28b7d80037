/* SPDX-License-Identifier: MIT */
/* The commands, and the options that they share. */
#ifndef CLI_OPTION_H
#define CLI_OPTION_H

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
    int isa; /* ibl_isa */
    int quiet;
    int verbose;
} ibl_common;

extern const ibl_section ibl_input_section;   /* read: of ibl_common */
extern const ibl_section ibl_running_section; /* the rest, --help, --version */

ibl_common ibl_common_default(void);
bool ibl_common_finish(const ibl_common *c);

/* Values of --rotate, into a double. */
#define IBL_ROTATE_ALLOWED                                                     \
    "-360 to 360, learnopengl, threejs (both 0) or cmgen (-90)"
bool ibl_rotate_parse(void *yaw_deg, const char *value);

#endif
