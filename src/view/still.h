/* SPDX-License-Identifier: MIT */
/* Pictures, sheets and captures without a window. */
#ifndef VIEW_STILL_H
#define VIEW_STILL_H

#include "view/options.h"
#include "view/report.h"

/* Draws until the options' frames or samples are there. *ms: the time of the
 * last frame; those of all are added to stats. False, with a message. */
bool view_still_draw(view_renderer *r, const view_options *o,
                     const view_settings *s, double *ms, view_stats *stats);

/* Opens or bakes what the options name, and makes what they ask for: a picture,
 * or a sheet with one choice along its rows and another along its columns.
 * False, with a message. */
bool view_still_run(ibl_ctx *ctx, const view_options *o);

#endif
