/* SPDX-License-Identifier: MIT */
/* The paths of the outputs. Both calls return IBL_OK or say what is wrong. */
#ifndef CLI_TARGETS_H
#define CLI_TARGETS_H

#include "cli/bake.h"

/* Sets the path of every file that is wanted. */
ibl_status ibl_targets_name(ibl_bake *b);

/* Refuses before the work what could not be written after it, and outputs
 * that would replace the input or, by chance, those of another environment.
 * The output directory is there. */
ibl_status ibl_targets_check(const ibl_bake *b);

#endif
