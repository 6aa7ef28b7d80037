/* SPDX-License-Identifier: MIT */
/* Inspection of maps: levels of a cube as cross, strip or equirectangular map,
 * and the table with lines of equal value. Finds the texel under the cursor;
 * shaders/layout.glsl draws with the same geometry, and tests compare both. */
#ifndef VIEW_INSPECT_H
#define VIEW_INSPECT_H

#include "view/baked_set.h"
#include "view/settings.h"

#define VIEW_HARMONICS_EDGE 32 /* texels that harmonics are shown by */
#define VIEW_FACE_SOURCE (-2)  /* of the environment itself */

/* The texel under the cursor. */
typedef struct view_texel {
    bool inside;         /* false: the other members are not set */
    int face, level;     /* face -1: the table; VIEW_FACE_SOURCE */
    int x, y;            /* texel */
    double direction[3]; /* cube: of the texel's centre in the environment's
                            frame; table: N.V, roughness, 0 */
    float value[3];      /* decoded */
} view_texel;

/* The texel at pixel x, y (from the upper left) of a picture of width x height:
 * of the map, or of the sky behind the spheres. */
view_texel view_inspect(const baked_set *set, const view_settings *s, int width,
                        int height, double x, double y);
/* Moves the map by pixels, or multiplies zoom around pixel x, y. At zoom 1 the
 * map just fits the window. pan is the point of the map in the middle of the
 * window, from the map's centre, in fractions of its size to the right and
 * down: -1/2..1/2. zoom is at least 1/4, and a texel covers at most a fourth of
 * the window. */
void view_inspect_drag(const baked_set *set, view_settings *s, int width,
                       int height, double dx, double dy);
void view_inspect_zoom(const baked_set *set, view_settings *s, int width,
                       int height, double x, double y, double factor);

extern const char *const view_face_names[IBL_FACES];
/* "level 2  +X (17, 40)  dir 0.98 0.12 -0.10  rgb 1.25 0.91 0.33" */
void view_texel_text(const view_texel *t, char *text, int size);

#endif
