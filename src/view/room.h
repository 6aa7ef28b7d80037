/* SPDX-License-Identifier: MIT */
/*
 * The scene of --mode scene: a room of 10 x 4 x 10 units, floor at y = 0, with
 * a glossy floor, four pillars, a wall in a corner, panels that emit light,
 * windows to the environment, and spheres, most of which move.
 *
 * Probes capture the light of the windows and the panels. Each surface is
 * shaded by the split sum with the given probes, mixed and looked up as in
 * ibl/probes.h; the next refresh of the probes adds the next bounce. Lights
 * that were taken out of the environment have shadows.
 */
#ifndef VIEW_ROOM_H
#define VIEW_ROOM_H

#include <stdbool.h>

#include "ibl/io.h"
#include "ibl/probes.h"
#include "view/frame.h"
#include "view/gl.h"

typedef struct view_room view_room;

/* The inside of the walls, for proxies. */
extern const double view_room_centre[3], view_room_half[3];

typedef struct view_room_material {
    float albedo[3]; /* diffuse; metals: 0 */
    float roughness;
    float f0[3];
    float emission[3]; /* radiance */
} view_room_material;

/* Solid, axis-aligned. */
typedef struct view_room_box {
    double low[3], high[3];
    view_room_material material;
} view_room_box;

/* Everything that stands still, except the sphere in the middle. The first are
 * the tiles of the floor, which fill the box from the low corner of the first
 * to the high corner of the last. */
#define VIEW_ROOM_BOXES 49
#define VIEW_ROOM_TILES 25
const view_room_box *view_room_box_at(int i);
/* Whether a box stands in the room and hides what is behind it. */
bool view_room_box_hides(int i);

/* Sphere 0 is a mirror that stands still. 1 is a lamp, 2 and 3 are rough; these
 * move. */
#define VIEW_ROOM_SPHERES 4
void view_room_sphere(int i, double seconds, double centre[3], double *radius);
bool view_room_sphere_moves(int i);
const view_room_material *view_room_sphere_material(int i);

/* Probes, each a layer of cube arrays, filtered linearly. Alpha is the part
 * that was captured; colours are premultiplied by it. */
typedef struct view_probe_maps {
    int count;              /* 0..IBL_MAX_PROBES */
    const ibl_probe *probe; /* sorted by ibl_probes_order */
    bool holes; /* alpha is below 1 somewhere: other probes must fill in */
    GLuint specular, irradiance;
    bool filament; /* levels are linear in r (2 - r), not in roughness r */
    float lod_scale, lod_offset, last_level;
    float irradiance_scale; /* texel * scale = E / pi */
} view_probe_maps;

/* Seen through windows; gets the weight that the probes leave. */
typedef struct view_room_environment {
    GLuint specular, irradiance, sky; /* sky: level 0 or the skybox */
    view_frame
        frame;   /* what it says of the set and its lookup, with lights that
                    are no part of the maps; all but SPLIT_SUM by FIT */
    bool map;    /* VIEW_UNIT_OTHER has the map itself, for the sky */
    double turn; /* degrees */
} view_room_environment;

typedef struct view_room_draw {
    double clip[16]; /* world to clip space, column-major, mirrored or not; for
                        a paraboloid as in shaders/paraboloid.glsl */
    double eye[3];
    bool paraboloid;
    double seconds; /* time that places moving objects */
    bool moving;    /* draw moving objects */
    bool shadows;   /* of the lights */
    /* Blended at a point in the order of ibl_probes_order, local ones first
     * among equals, as by ibl_probes_blend with alpha but without a maximum
     * count. */
    view_probe_maps locals;
    view_probe_maps dynamic; /* a probe captured repeatedly, or none */
    bool untiled; /* each pixel tests all locals; the picture is the same */
    view_room_environment environment;
    GLuint table; /* split-sum table */
    bool parallax;
    /* A probe's influence is scaled by what of the way to its position is free
     * of walls and pillars. The dynamic probe, if it is in view, replaces what
     * hidden ones lose, and the others what then remains: the environment gets
     * no more by it. */
    bool walls;
    bool map;        /* the sky is the environment's map; not for captures */
    bool bare;       /* no sky: what it would cover is 0, alpha too */
    double widening; /* view_widening; 0 for captures */
    bool sharp;      /* as if blend was 0: the first probe gets all weight */
} view_room_draw;

/* NULL, with a message; needs cube map arrays. */
view_room *view_room_create(void);
void view_room_free(view_room *r); /* NULL is fine */

/* Draws scene-linear RGBA over the viewport of the bound framebuffer, which
 * must have a depth buffer, and clears the depth. Changes texture units below
 * VIEW_ROOM_UNITS, uniform buffers 0 and 1, program and vertex array; turns
 * depth test and face culling off. */
void view_room_render(view_room *r, const view_room_draw *d);

/* Edge of a tile of the picture, in pixels. Unit VIEW_ROOM_UNIT_MASKS has a
 * texel per tile and 64 local probes, their mask (ibl_tile_cull) in words of
 * 32 bits, lower first; the tiles of the next 64 are above. Paraboloids are no
 * projection and have no masks. */
#define VIEW_ROOM_TILE 16

#endif
