/* SPDX-License-Identifier: MIT */
/* The paths of the outputs. */
#ifndef CLI_TARGETS_H
#define CLI_TARGETS_H

#include "cli/bake_record.h"

/* Sets the path of every file that is wanted. Refuses, with a message and
 * before the work, what could not be written after it, and outputs that would
 * replace the input or, by chance, those of another environment. The output
 * directory is there. */
ibl_status ibl_targets_plan(ibl_bake *b);

/* The rule "outputs: input" that make and ninja include, no prerequisite for
 * standard input. The text is the caller's to free; NULL: no memory. */
char *ibl_depfile_text(const ibl_bake *b);

#endif
