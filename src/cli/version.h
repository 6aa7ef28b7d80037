/* SPDX-License-Identifier: MIT */
#ifndef CLI_VERSION_H
#define CLI_VERSION_H

#include <stdio.h>

/* --version: the program, what it was built with, what it runs on. */
void ibl_version_print(FILE *to);
/* "gcc 12.2.0" */
const char *ibl_version_compiler(void);
/* Of the source, as git describes it; "" if it did not. */
const char *ibl_version_revision(void);

#endif
