/* SPDX-License-Identifier: MIT */
#ifndef VIEW_TITLE_H
#define VIEW_TITLE_H

#include "view/app.h"

/* What is shown and how, for the window's title. */
void view_title_text(const view_app *app, char *text, size_t size);

#endif
