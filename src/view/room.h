/* SPDX-License-Identifier: MIT */
/*
 * The scene of --mode scene: a room of 10 x 4 x 10 units, floor at y = 0, with
 * a glossy floor, four pillars, panels that emit light, windows to the
 * environment, and spheres, most of which move.
 *
 * Light comes through the windows and from the panels, as probes see it. Each
 * surface is shaded by the split sum with the given probes, mixed and looked up
 * as in ibl/probes.h; the second bounce comes with their next refresh. The
 * environment's sun is a light with shadows.
 */
#ifndef VIEW_ROOM_H
#define VIEW_ROOM_H

#include <stdbool.h>

#include "ibl/probes.h"
#include "view/gl.h"
#include "view/room_sun.h"

typedef struct view_room view_room;

/* Inside of the walls, for proxies; and how thick these are. */
extern const double view_room_centre[3], view_room_half[3], view_room_wall;

typedef struct view_room_material {
    float albedo[3]; /* diffuse; 0 of metals */
    float roughness;
    float f0[3];
    float emission[3]; /* radiance */
} view_room_material;

/* Solid, its sides along the axes. */
typedef struct view_room_box {
    double low[3], high[3];
    view_room_material material;
} view_room_box;

/* All that stands still but the sphere in the middle. */
int view_room_boxes(void);
const view_room_box *view_room_box_at(int i);

/* Sphere 0 is a mirror that stands still. 1 is a lamp, the others are rough;
 * these move. */
#define VIEW_ROOM_SPHERES 4
void view_room_sphere(int i, double seconds, double centre[3], double *radius);
bool view_room_sphere_moves(int i);
const view_room_material *view_room_sphere_material(int i);

/* Probes, each a layer of cube arrays: filtered linearly; alpha is how much has
 * been seen, and colour is multiplied by it. */
typedef struct view_probe_maps {
    int count; /* 0..IBL_MAX_TILE_PROBES */
    const ibl_probe
        *probe; /* in the order of ibl_probes_order, with their layers */
    bool holes; /* somewhere alpha is below 1: others have to fill in */
    GLuint specular, irradiance;
    bool filament; /* levels are linear in r (2 - r), not in roughness r */
    float lod_scale, lod_offset, last_level;
    float irradiance_scale; /* times the texel is E / pi */
} view_probe_maps;

/* What is seen through windows, and has the share that no probe takes. */
typedef struct view_room_environment {
    GLuint specular, irradiance, sky; /* sky: level 0 or the skybox */
    float lod[4];                     /* as view_frame.lod */
    float irradiance_scale;           /* as view_frame.diffuse[0] */
    double turn;                      /* degrees */
    view_room_sun sun; /* zeros: none. The maps have it too; it is taken off
                          where they are seen */
} view_room_environment;

typedef struct view_room_draw {
    double clip[16]; /* world to clip space, column-major, mirrored or not; of a
                        paraboloid for shaders/paraboloid.glsl */
    double eye[3];
    bool paraboloid;
    double seconds; /* where what moves is */
    bool moving;    /* draw what moves */
    bool shadows;   /* in the sun */
    /* Limited: what is outside of the box, and the sky, is 0 in RGBA, but hides
     * what is behind it. Else alpha is 1. Set it where clip ends before the
     * walls. */
    bool limited;
    double limit_centre[3], limit_half[3];
    /* Probes at a point count in the order of ibl_probes_order, of equals the
     * local ones first, as in ibl_probes_blend with alpha, without a limit of
     * number. */
    view_probe_maps locals;
    view_probe_maps dynamic; /* a probe that is captured anew, or none */
    bool untiled; /* each pixel goes through all locals: the same picture */
    view_room_environment environment;
    GLuint table; /* of the split sum */
    bool parallax;
    bool sharp; /* as if blend was 0: each point has all of its first probe */
} view_room_draw;

/* NULL, with a message: shaders have to have arrays of cubes. */
view_room *view_room_create(void);
void view_room_free(view_room *r); /* NULL is fine */

/* Draws scene-linear RGBA over the viewport of the bound framebuffer, which has
 * a depth buffer, and clears the depth. Makes shadows anew when sun, turn or
 * what moves has changed. Changes texture units below VIEW_ROOM_UNITS, uniform
 * buffers 0 to 2, program and vertex array; tests of depth and back faces are
 * off. */
void view_room_render(view_room *r, const view_room_draw *d);

/* Edge of a tile of the picture. Local probes of each are a texel of the unit
 * VIEW_ROOM_UNIT_MASKS: the masks of ibl_tiles_cull in words of 32 bits, lower
 * first. Paraboloids, which are no projection, have none. */
#define VIEW_ROOM_TILE 16

#endif
