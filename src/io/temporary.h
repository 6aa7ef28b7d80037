/* SPDX-License-Identifier: MIT */
/* Names of the temporaries of a set of outputs. */
#ifndef IBL_IO_TEMPORARY_H
#define IBL_IO_TEMPORARY_H

#include <stddef.h>

/* Writes ".NAME.iblbake-HOST-PID-SERIAL.tmp", for this process, which is at
 * most 64 bytes longer than name; of a long name only the first bytes. */
void ibl_temporary_name(char *to, size_t bytes, const char *name,
                        unsigned serial);

#endif
