/* SPDX-License-Identifier: MIT */
#ifndef VIEW_REPORT_H
#define VIEW_REPORT_H

#include "view/probe_set.h"
#include "view/renderer.h"

/* Prints how far the split sum of the last draw is off the reference, a number
 * for each sphere as they stand on the screen. False: no reference is there. */
bool view_report_print(const view_renderer *r, const view_settings *s);
/* Prints what a set consists of. */
void view_report_set(const baked_set *set);

/* Prints how long the last capture of the scene took. */
void view_report_probe(const view_scene *stage, view_probe_filter filter);

/* Where the sun of the last draw of the scene is, in the world, and what it
 * gives a surface that faces it. */
void view_report_sun(const view_scene *stage);

/* Where baked probes are from, and how many. */
void view_report_probe_set(const view_probe_set *set);

#endif
