/* SPDX-License-Identifier: MIT */
#ifndef IBL_IO_NUMBER_H
#define IBL_IO_NUMBER_H

#include <stdbool.h>

/* Reads a decimal number after blanks and moves *t behind it; does not depend
 * on the locale. False: there is none. */
bool ibl_take_number(char **t, double *value);

#endif
