/* SPDX-License-Identifier: MIT */
/* Text output of the viewer. */
#ifndef VIEW_REPORT_H
#define VIEW_REPORT_H

#include "view/renderer.h"
#include "view/room.h"

/* Writes what a side shows that the other does not, as "reflection split". */
void view_report_side(const view_settings *side, int i, const baked_set *set,
                      const baked_set *other, char *text, size_t size);
/* Writes the error of the whole picture, as "RMSE 2.7 % (noise .9 %)"; "" if
 * nothing is compared. */
void view_report_sum(view_renderer *r, char *text, size_t size);
/* Prints the error of the last draw against what it was compared with, for each
 * sphere, arranged as on the screen, or for each material of the model.
 * names: of the sides. */
void view_report_print(view_renderer *r, const view_settings *s,
                       const char *const names[2]);
/* Prints the textures of a set. */
void view_report_set(const baked_set *set);

/* Prints the path and the number of baked probes. */
void view_report_probe_set(const view_probe_set *set, const char *path);

/* ---- --stats ------------------------------------------------------------- */

/* --stats prints a line of NAME=VALUE words for each update of the scene's
 * probe, and in other modes for each second with frames. */

/* Frames since the last line; all zero at the start. */
typedef struct view_stats {
    int frames;
    double sum, worst, gpu; /* milliseconds; gpu: by OpenGL's timer, summed */
    double begun;           /* ibl_now() before the first frame */
    int updates;            /* updates of the probe that were printed */
} view_stats;

void view_stats_add(view_stats *t, double ms, double gpu);

/* For a window, after each frame: prints a line if it is due. */
void view_stats_tell(view_stats *t, const view_renderer *r,
                     const view_settings *s);
/* For a picture or sheet: prints the line, in the scene of the last update of
 * its probe. */
void view_stats_end(view_stats *t, const view_renderer *r,
                    const view_settings *s);

#endif
