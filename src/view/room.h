/* SPDX-License-Identifier: MIT */
/*
 * The scene that probes are shown in: a room of 10 x 4 x 10 units about the
 * origin (floor at y = 0), with a glossy floor, four pillars, coloured panels
 * that emit light, windows to the environment, and spheres that move. All of it
 * is made here, of boxes and spheres; there are no files.
 *
 * It is lit by what comes through the windows and from the panels, as probes
 * see it: each surface is shaded by the split sum with the probes it is given,
 * mixed and looked up as ibl/probes.h says, so that probes of probes (the
 * second bounce) come with the next refresh.
 */
#ifndef VIEW_ROOM_H
#define VIEW_ROOM_H

#include <stdbool.h>

#include "view/gl.h"

typedef struct view_room view_room;

#define VIEW_ROOM_PROBES 4 /* that a draw can have */

/* A probe as it is drawn with: a prefiltered cube (RGBA16F or RGBA32F, alpha
 * what of it has been seen), its irradiance / pi as a cube, and where. */
typedef struct view_room_probe {
    GLuint specular, irradiance;
    float lod_scale, lod_offset, last_level; /* as view_frame.lod, linear */
    float position[3];
    float influence_centre[3], influence_half[3], blend;
    float proxy_centre[3], proxy_half[3]; /* boxes; half 0: no parallax */
} view_room_probe;

typedef struct view_room_draw {
    double clip[16]; /* world to clip space, column-major */
    double eye[3];
    double near;    /* what is nearer than that is not drawn */
    double seconds; /* where what moves is */
    bool shadows;   /* of the sun-like strongest panel */
    bool moving;    /* draw what moves */
    int hidden;     /* sphere that is left out, -1: none */
    int probe_count;
    view_room_probe probe[VIEW_ROOM_PROBES];
    GLuint environment; /* level 0 or the skybox: seen through windows */
    GLuint table;       /* of the split sum */
    double turn;        /* degrees, of the environment */
    bool parallax;
} view_room_draw;

view_room *view_room_create(void); /* NULL, with a message */
void view_room_free(view_room *r); /* NULL is fine */

/* Draws into the bound framebuffer, which has a depth buffer, as scene-linear
 * RGB; alpha 1. Its viewport is set. */
void view_room_render(view_room *r, const view_room_draw *d);

/* Spheres that move, and where one of them is at a time. */
int view_room_spheres(const view_room *r);
void view_room_sphere(const view_room *r, int i, double seconds,
                      double centre[3], double *radius);
/* Whether anything inside the box has moved between two times. */
bool view_room_moved(const view_room *r, double from, double to,
                     const double centre[3], const double half[3]);

#endif
