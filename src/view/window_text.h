/* SPDX-License-Identifier: MIT */
#ifndef VIEW_WINDOW_TEXT_H
#define VIEW_WINDOW_TEXT_H

#include "view/app.h"

/* Draws the window's text: keys, the texel under the cursor, progress of a
 * bake, notice, scale of false colours. */
void view_window_text(view_app *app);

/* What is shown and how, for the window's title. */
void view_title_text(const view_app *app, char *text, size_t size);

#endif
