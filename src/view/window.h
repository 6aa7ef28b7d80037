/* SPDX-License-Identifier: MIT */
/* The window: frames, and what keys, mouse, files and dropped maps do. */
#ifndef VIEW_WINDOW_H
#define VIEW_WINDOW_H

#include "view/options.h"

/* Shows what the options say until the window is closed. False after a
 * message. */
bool view_window_run(ibl_ctx *ctx, const view_options *options);

#endif
