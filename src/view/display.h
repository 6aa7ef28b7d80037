/* SPDX-License-Identifier: MIT */
/*
 * The passes that fill the whole framebuffer from textures: the linear picture
 * to what is shown (shaders/display.frag) and the maps themselves to a linear
 * picture (shaders/inspect.frag).
 */
#ifndef VIEW_DISPLAY_H
#define VIEW_DISPLAY_H

#include "view/gl.h"

typedef struct view_display view_display;

view_display *view_display_create(void); /* NULL, with a message */
void view_display_free(view_display *d); /* NULL is fine */

/*
 * Both draw into the bound framebuffer, in the viewport that is set, by the
 * uniform block Frame that is bound to binding 0. They leave their program and
 * vertex array bound, and touch no other state but the texture units that
 * they name.
 *
 * Shows picture, and of truth what settings.compare asks for (0 where it asks
 * for nothing): RGBA32F textures of the framebuffer's size, taken texel by
 * pixel. They stay bound to VIEW_UNIT_PICTURE and VIEW_UNIT_TRUTH. Values are
 * sRGB-encoded here: the framebuffer must not do it again. NaN is shown as
 * magenta (255, 0, 255) and infinity as cyan (0, 255, 255), in whatever mode.
 */
void view_display_draw(view_display *d, GLuint picture, GLuint truth);

/* Draws what settings.mode inspects as linear RGB. The maps are bound to
 * VIEW_UNIT_SPECULAR, VIEW_UNIT_IRRADIANCE and VIEW_UNIT_LUT with whatever
 * filters; their texels are shown as they are. */
void view_display_inspect(view_display *d);

/*
 * False colours: a spiral through the colour cube that rises evenly in
 * perceived brightness (Green 2011), over stops around middle grey, 0.18. Each
 * stop is a step, within which colour goes half of the way to the next; below
 * and above are stripes, black and blue, white and red.
 */
#define VIEW_STOPS 8 /* on either side of middle grey */
/* The sRGB-encoded colour of so many stops from middle grey, -VIEW_STOPS ..
 * VIEW_STOPS: what a legend shows. Same formula as shaders/tone.glsl. */
void view_false_colour(double stops, double srgb[3]);

#endif
