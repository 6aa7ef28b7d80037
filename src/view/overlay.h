/* SPDX-License-Identifier: MIT */
/* Text on the picture: the list of keys, the texel under the cursor, the
 * progress of a bake, labels of a contact sheet. */
#ifndef VIEW_OVERLAY_H
#define VIEW_OVERLAY_H

#include "view/gl.h"

typedef struct view_overlay view_overlay;

view_overlay *view_overlay_create(void); /* NULL, with a message */
void view_overlay_free(view_overlay *o); /* NULL is fine */

/* Adds text (ASCII, lines by \n) with its upper left corner at x, y pixels, on
 * a dark plate. scale: 1 is 7 pixels a character's height or so. */
void view_overlay_text(view_overlay *o, double x, double y, double scale,
                       const char *text);
/* Size that text would have. */
void view_overlay_measure(const char *text, double scale, double *width,
                          double *height);
/* A bar of share 0..1. */
void view_overlay_bar(view_overlay *o, double x, double y, double width,
                      double height, double share);
/* Draws all that was added into the bound framebuffer, and forgets it. */
void view_overlay_draw(view_overlay *o, int width, int height);

#endif
