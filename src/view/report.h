/* SPDX-License-Identifier: MIT */
/* What the viewer prints about what it draws. */
#ifndef VIEW_REPORT_H
#define VIEW_REPORT_H

#include "view/probe_set.h"
#include "view/renderer.h"

/* Prints the error of the split sum of the last draw for each sphere, as they
 * stand on the screen. False: there is no reference. */
bool view_report_print(const view_renderer *r, const view_settings *s);
/* Prints the version and the renderer of OpenGL. */
void view_report_gl(void);
/* Prints what a set consists of. */
void view_report_set(const baked_set *set);

/* Prints how long the last capture of the scene took. */
void view_report_probe(const view_scene *stage, view_probe_filter filter);

/* The direction of the last draw's sun in the world, and its irradiance. */
void view_report_sun(const view_scene *stage);

/* Where baked probes are from, and how many. */
void view_report_probe_set(const view_probe_set *set);

/* ---- --stats ------------------------------------------------------------- */

/* A line of NAME=VALUE words for each update of the scene's probe, and in the
 * other modes for each second with frames in it. */

/* Frames since the last line. All zeros in the beginning. */
typedef struct view_stats {
    int frames;
    double sum, worst; /* milliseconds */
    double begun;      /* view_clock() before the first of them */
    int updates;       /* of the probe, that were told of */
} view_stats;

void view_stats_add(view_stats *t, double ms);

/* In a window, after each frame: prints a line if it is time for one. */
void view_stats_tell(view_stats *t, const view_renderer *r,
                     const view_settings *s);
/* After a picture or sheet: prints a line, and for the scene's probe another of
 * the same capture, filtered the other way. False, with a message. */
bool view_stats_end(view_stats *t, const view_renderer *r,
                    const view_settings *s);

#endif
