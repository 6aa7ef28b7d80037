/* SPDX-License-Identifier: MIT */
/* What --stats prints: a line of NAME=VALUE words for each update of the
 * scene's probe, and in the other modes for each second with frames in it. */
#ifndef VIEW_STATS_H
#define VIEW_STATS_H

#include "view/renderer.h"

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
/* After all frames of a picture or sheet: prints one in any case, and for the
 * scene's probe another: of the same capture, filtered the other way. False,
 * with a message, if that cannot be. */
bool view_stats_end(view_stats *t, const view_renderer *r,
                    const view_settings *s);

#endif
