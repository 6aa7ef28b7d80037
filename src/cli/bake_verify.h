/* SPDX-License-Identifier: MIT */
/* --verify: what a bake has written, against the exact sums. */
#ifndef CLI_BAKE_VERIFY_H
#define CLI_BAKE_VERIFY_H

#include "cli/bake_record.h"

/* Judges the file that a texture is written as and adds to the report. */
ibl_status ibl_bake_judge(ibl_bake *b, ibl_output_kind kind,
                          const ibl_texture *tex);

/* Prints the report; fails, with a message, if it is above --max-error. */
ibl_status ibl_bake_judged(const ibl_bake *b);

#endif
