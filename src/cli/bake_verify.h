/* SPDX-License-Identifier: MIT */
/* --verify: what a bake has written, against the exact sums. */
#ifndef CLI_BAKE_VERIFY_H
#define CLI_BAKE_VERIFY_H

#include "cli/bake.h"

/* Judges a file of the bake by its bytes and adds to the report. */
ibl_status ibl_bake_judge(ibl_bake *b, ibl_output_kind kind, const void *bytes,
                          size_t size);

/* Prints the report; fails, with a message, if it is above --max-error. */
ibl_status ibl_bake_judged(const ibl_bake *b);

#endif
