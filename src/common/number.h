/* SPDX-License-Identifier: MIT */
#ifndef COMMON_NUMBER_H
#define COMMON_NUMBER_H

enum {
    IBL_NUMBER_BYTES = 32
};

/* The fewest digits that read back as the same double; with an exponent only
 * below 1e-5 and from 1e9 up. */
void ibl_number_text(double x, char text[IBL_NUMBER_BYTES]);

#endif
