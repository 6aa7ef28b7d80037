/* SPDX-License-Identifier: MIT */
/* The passes over the whole framebuffer: the linear picture to what is shown
 * (shaders/display.frag), the maps to a linear picture
 * (shaders/inspect.frag). */
#ifndef VIEW_DISPLAY_H
#define VIEW_DISPLAY_H

#include "view/gl.h"

typedef struct view_display view_display;

view_display *view_display_create(void); /* NULL, with a message */
void view_display_free(view_display *d); /* NULL is fine */

/*
 * Both draw into the bound framebuffer and viewport, by the uniform block Frame
 * at binding 0. They change only program, vertex array and the named texture
 * units.
 *
 * Shows picture, and of truth what settings.compare asks for (else 0): RGBA32F
 * textures of the framebuffer's size. They stay bound to VIEW_UNIT_PICTURE and
 * VIEW_UNIT_TRUTH. Values are sRGB-encoded here. NaN is magenta (255, 0, 255)
 * and infinity cyan (0, 255, 255) in every mode.
 */
void view_display_draw(view_display *d, GLuint picture, GLuint truth);

/* Draws what settings.mode inspects as linear RGB, texels as they are, from the
 * maps at VIEW_UNIT_SPECULAR, VIEW_UNIT_IRRADIANCE and VIEW_UNIT_LUT. */
void view_display_inspect(view_display *d);

/* False colours: a spiral through the colour cube that rises evenly in
 * perceived brightness (Green 2011), over stops around middle grey, 0.18. Each
 * stop is a step, in which the colour goes half of the way to the next. Values
 * outside are striped black and blue, or white and red. */
#define VIEW_STOPS 8 /* on either side of middle grey */
/* The sRGB-encoded colour of -VIEW_STOPS .. VIEW_STOPS stops from middle grey,
 * for the legend. Same formula as shaders/tone.glsl. */
void view_false_colour(double stops, double srgb[3]);

#endif
