/* SPDX-License-Identifier: MIT */
#ifndef CLI_DEPFILE_H
#define CLI_DEPFILE_H

#include "cli/bake.h"

/* The rule "outputs: input" that make and ninja include, no prerequisite for
 * standard input. The text is the caller's to free; NULL: no memory. */
char *ibl_depfile_text(const ibl_bake *b);

#endif
