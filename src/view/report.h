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
/* Prints the error of the last draw of two sides: a line for each sphere or
 * material of the model that shows, and for all. */
void view_report_print(view_renderer *r, const view_settings *side,
                       const baked_set *set, const baked_set *other);

/* --stats: frames since the last line; all zero at the start. */
typedef struct view_stats {
    int frames;
    double sum, worst, gpu; /* milliseconds; gpu: by OpenGL's timer, summed */
    double begun;           /* ibl_now() before the first frame */
} view_stats;

void view_stats_add(view_stats *t, double ms, double gpu);
/* Prints a line of NAME=VALUE words, at last what draws, and begins anew. */
void view_stats_print(view_stats *t, const view_renderer *r,
                      const view_settings *s);

#endif
