/* SPDX-License-Identifier: MIT */
/* Text on the picture: the list of keys, the texel under the cursor, the
 * progress of a bake, labels of a contact sheet. */
#ifndef VIEW_OVERLAY_H
#define VIEW_OVERLAY_H

#include "view/gl.h"

typedef struct view_overlay view_overlay;

view_overlay *view_overlay_create(void); /* NULL, with a message */
void view_overlay_free(view_overlay *o); /* NULL is fine */

/* Between these two, calls below draw into the bound framebuffer, of width x
 * height pixels with sRGB-encoded values. Nothing else may draw there. The
 * second one leaves blending off, and the program and vertex array bound. */
void view_overlay_begin(view_overlay *o, int width, int height);
void view_overlay_end(view_overlay *o);

/* Text on a dark background whose upper left corner is at pixel x, y. Text
 * is ASCII, other bytes become ?; \n ends a line, \t goes to the next column of
 * 100 * scale pixels. A character is about 7 * scale pixels high. Letters
 * differ in width. Any length is taken; what is outside is not seen. */
void view_overlay_text(view_overlay *o, double x, double y, double scale,
                       const char *text);
/* Size in pixels that the plate of text would have; 0 and 0 if it is empty. */
void view_overlay_measure(const char *text, double scale, double *width,
                          double *height);
/* A bar of share 0..1. */
void view_overlay_bar(view_overlay *o, double x, double y, double width,
                      double height, double share);
/* The scale of false colours, darkest to the left, with the
 * stops below it: as high as two lines of text. */
void view_overlay_legend(view_overlay *o, double x, double y, double width,
                         double scale);

/* False colours: a spiral through the colour cube that rises evenly in
 * perceived brightness (Green 2011), over stops around middle grey, 0.18. Each
 * stop is a step, in which the colour goes half of the way to the next. Values
 * outside are striped black and blue, or white and red. */
#define VIEW_STOPS 8 /* on either side of middle grey */
/* The sRGB-encoded colour of -VIEW_STOPS .. VIEW_STOPS stops from middle grey,
 * for the legend. Same formula as shaders/tone.glsl. */
void view_false_colour(double stops, double srgb[3]);

#endif
