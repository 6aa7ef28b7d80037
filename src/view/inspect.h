/* SPDX-License-Identifier: MIT */
/* The maps themselves: levels of a cube as cross, strip or equirectangular map,
 * the table with lines of equal value. This names the texel under the cursor;
 * shaders/layout.glsl draws by the same geometry, and tests compare the two. */
#ifndef VIEW_INSPECT_H
#define VIEW_INSPECT_H

#include "view/baked_set.h"
#include "view/settings.h"

/* Something under the cursor. */
typedef struct view_texel {
    bool inside;         /* else nothing else holds */
    int face, level;     /* face -1: flat */
    int x, y;            /* texel */
    double direction[3]; /* of a cube's texel centre, in the environment's own
                            frame; of the table: N.V, roughness, 0 */
    float value[3];      /* as the file has it, decoded */
} view_texel;

/* Pixel x, y (from the upper left) of a picture of width x height, in the modes
 * that inspect and of the sky behind the spheres. */
view_texel view_inspect(const baked_set *set, const view_settings *s, int width,
                        int height, double x, double y);
/* A drag by pixels, and a wheel that multiplies zoom around pixel x, y. At zoom
 * 1 the map just fits the window. pan is the point of the map in the middle of
 * the window, in shares of its size to the right and down of its own middle:
 * -1/2..1/2. zoom stays between 1/4 and a texel of a fourth of the window. */
void view_inspect_drag(const baked_set *set, view_settings *s, int width,
                       int height, double dx, double dy);
void view_inspect_zoom(const baked_set *set, view_settings *s, int width,
                       int height, double x, double y, double factor);

/* "level 2  +X (17, 40)  dir 0.98 0.12 -0.10  rgb 1.25 0.91 0.33" */
void view_texel_text(const view_texel *t, char *text, int size);

#endif
