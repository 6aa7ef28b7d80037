/* SPDX-License-Identifier: MIT */
/* What is drawn around and over a picture. */
#ifndef VIEW_LABELS_H
#define VIEW_LABELS_H

#include "view/app.h"

/* Draws labels beside what they label (what is shown, what
 * rows and columns are, which half is which and how they differ, the scales of
 * false colours and differences), the panel, and whatever is open. */
void view_labels_draw(view_app *app);

#endif
