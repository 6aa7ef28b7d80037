/* SPDX-License-Identifier: MIT */
#ifndef FLOAT_EXR_H
#define FLOAT_EXR_H

#include <stdbool.h>
#include <stdio.h>

/* Writes OpenEXR as "OpenEXR File Layout" has it: uncompressed floats, a scan
 * line a chunk. channels: their names, a letter each, in the alphabet's order;
 * samples: width * height of each, one channel after the other. */
bool test_write_float_exr(FILE *to, int width, int height, const char *channels,
                          const float *samples);

#endif
