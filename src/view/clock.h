/* SPDX-License-Identifier: MIT */
#ifndef VIEW_CLOCK_H
#define VIEW_CLOCK_H

/* Seconds since some time in the past. */
double view_clock(void);

#endif
