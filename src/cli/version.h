/* SPDX-License-Identifier: MIT */
#ifndef CLI_VERSION_H
#define CLI_VERSION_H

#include <stdio.h>

/* --version: the program, what it was built with, what it runs on. */
void ibl_version_print(FILE *to);

#endif
