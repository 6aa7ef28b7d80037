/* SPDX-License-Identifier: MIT */
#ifndef VIEW_PLATE_H
#define VIEW_PLATE_H

#include "view/app.h"

/* Puts on the overlay what the window has to say: list of keys, texel under
 * the cursor, progress of a bake, notice, scale of false colours. */
void view_plate_add(view_app *app, int width, int height);

#endif
