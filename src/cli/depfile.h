/* SPDX-License-Identifier: MIT */
#ifndef CLI_DEPFILE_H
#define CLI_DEPFILE_H

#include "cli/bake.h"

enum {
    IBL_DEPFILE_WHY = 32
};

/* Whether make or ninja could not read the path in a depfile, and what it has
 * that they cannot. */
bool ibl_depfile_refuses(const char *path, char why[IBL_DEPFILE_WHY]);

/* The rule "outputs: input" that make and ninja include, no prerequisite for
 * standard input. The text is the caller's to free; NULL: no memory. */
char *ibl_depfile_text(const ibl_bake *b);

#endif
