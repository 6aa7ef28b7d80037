/* SPDX-License-Identifier: MIT */
/* Text on the picture: the list of keys, the texel under the cursor, the
 * progress of a bake, labels of a contact sheet. */
#ifndef VIEW_OVERLAY_H
#define VIEW_OVERLAY_H

#include "view/gl.h"

typedef struct view_overlay view_overlay;

view_overlay *view_overlay_create(void); /* NULL, with a message */
void view_overlay_free(view_overlay *o); /* NULL is fine */

/* Adds text (ASCII, other bytes are shown as ?; \n ends a line, \t goes to the
 * next of columns that are 60 * scale pixels wide) on a dark plate, whose upper
 * left corner is at x, y pixels. scale: 1 is 7 pixels a character's height or
 * so. Letters are of different widths. What is outside the framebuffer is not
 * seen; text of any length is taken. */
void view_overlay_text(view_overlay *o, double x, double y, double scale,
                       const char *text);
/* Size in pixels that the plate of text would have; 0 and 0 if it is empty. */
void view_overlay_measure(const char *text, double scale, double *width,
                          double *height);
/* A bar of share 0..1. */
void view_overlay_bar(view_overlay *o, double x, double y, double width,
                      double height, double share);
/* The scale of false colours (view/display.h), darkest to the left, with the
 * stops below: of the size of a plate of two lines, so wide. */
void view_overlay_legend(view_overlay *o, double x, double y, double width,
                         double scale);

/* Draws all that was added into the bound framebuffer, in the order in which
 * it was added, and forgets it. The framebuffer's values are sRGB-encoded.
 * Leaves blending off, its function source over, alpha kept, and its program
 * and vertex array bound. */
void view_overlay_draw(view_overlay *o, int width, int height);

#endif
