/* SPDX-License-Identifier: MIT */
#ifndef COMMON_CLOCK_H
#define COMMON_CLOCK_H

/* Seconds of the monotonic clock. */
double ibl_now(void);

#endif
