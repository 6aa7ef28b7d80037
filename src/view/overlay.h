/* SPDX-License-Identifier: MIT */
/* Text on the picture: list of keys, texel under the cursor, progress of a
 * bake, labels of a contact sheet. */
#ifndef VIEW_OVERLAY_H
#define VIEW_OVERLAY_H

#include "view/gl.h"

typedef struct view_overlay view_overlay;

view_overlay *view_overlay_create(void); /* NULL, with a message */
void view_overlay_free(view_overlay *o); /* NULL is fine */

/* The functions below draw between these two, into the bound framebuffer of
 * width x height pixels with sRGB-encoded values. Nothing else may draw there.
 * view_overlay_end leaves blending off, and program and vertex array bound. */
void view_overlay_begin(view_overlay *o, int width, int height);
void view_overlay_end(view_overlay *o);

/* Draws text on a dark background whose upper left corner is at pixel x, y.
 * Text is ASCII, other bytes become ?; \n ends a line, \t moves to the next
 * column of 100 * scale pixels. A character is about 7 * scale pixels high, its
 * width varies. Any length is allowed; text outside the picture is cut. */
void view_overlay_text(view_overlay *o, double x, double y, double scale,
                       const char *text);
enum {
    VIEW_TEXT_MARGIN = 4, /* around text, in pixels at scale 1 */
    VIEW_TEXT_LINE = 12,  /* between lines */
    VIEW_TEXT_TAB = 100   /* between columns */
};
/* Size in pixels of text with its background; 0 and 0 if it is empty. */
void view_overlay_measure(const char *text, double scale, double *width,
                          double *height);
/* A progress bar, filled by share 0..1. */
void view_overlay_bar(view_overlay *o, double x, double y, double width,
                      double height, double share);
/* Draws a scale with its values below it, two lines of text high: false
 * colours with their stops or, if most is above 0, greys from 0 to most. */
void view_overlay_legend(view_overlay *o, double x, double y, double width,
                         double scale, double most);

/* False colours: a spiral through the colour cube whose perceived brightness
 * rises evenly (Green 2011), over stops around middle grey, 0.18. Each stop is
 * a step, within which the colour changes half of the way to the next. Values
 * outside are striped black and blue, or white and red: shaders/tone.glsl. */
#define VIEW_STOPS 8 /* on either side of middle grey */

#endif
