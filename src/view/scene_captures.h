/* SPDX-License-Identifier: MIT */
/* Draws --mode scene: the room, a probe in its mirror that is captured again
 * while objects move, and local probes of the objects that stand still. */
#ifndef VIEW_SCENE_CAPTURES_H
#define VIEW_SCENE_CAPTURES_H

#include "ibl/probes.h"
#include "view/capture.h"
#include "view/gl.h"
#include "view/probe_set.h"
#include "view/room.h"
#include "view/sphere_grid.h"

typedef struct view_scene view_scene;

enum {
    VIEW_SCENE_MIRROR = 0 /* index of the sphere with the probe */
};

view_scene *view_scene_create(void);  /* NULL, with a message */
void view_scene_free(view_scene *st); /* NULL is fine */

/* Replaces local probes of the settings by baked ones; NULL: does not. probes
 * must stay valid until the next call. The next draw captures everything again;
 * call this also after a change of the environment. */
void view_scene_use(view_scene *st, const view_probe_set *probes);

/*
 * Draws into a framebuffer of width x height pixels by settings: camera, turn,
 * parallax, seconds and how the probe is refreshed. The first draw, and each
 * after a change of the light or of the capture, makes a whole capture with its
 * bounces. If settings spread local probes, each draw captures one of them, and
 * the last the mirror too; until then nothing moves in it. Later draws capture
 * when the interval is over, by settings.seconds, and objects have moved. If
 * that fails, with a message, the probe stays until the next change. Leaves the
 * framebuffer bound, other state as view_room_render. False, with a message.
 */
bool view_scene_draw(view_scene *st, const view_settings *s,
                     const view_room_environment *environment, GLuint table,
                     GLuint framebuffer, int width, int height);

/* Results of draws. */
typedef struct view_scene_state {
    view_room_draw draw;           /* the last draw, with its probes */
    int updates;                   /* number of updates of the mirror's probe */
    double shown;                  /* settings.seconds of that probe */
    double ms[VIEW_CAPTURE_PARTS]; /* of the last one */
} view_scene_state;

const view_scene_state *view_scene_state_of(const view_scene *st);

/* Default distance of the camera from the mirror, in units. */
extern const double view_scene_distance;
/* The camera orbits the mirror and stays in the room. */
view_camera view_scene_camera(const view_settings *s, int width, int height);

/* ---- local probes (scene_locals.c) ------------------------------------- */

/* Places 1..VIEW_MAX_LOCALS probes in a nearly square grid at eye level,
 * outside pillars and mirror. Influence: the cell, from below the floor to
 * above the ceiling; proxy: the walls. Influences of neighbours overlap by a
 * blend width and sum to at least 1. Sorted by ibl_probes_order; layers 0 to
 * count - 1. */
void view_scene_place(ibl_probe *probes, int count);

/* ---- volumes of probes ------------------------------------------------- */

/* Scene-linear, at an exposure of 0. */
extern const float view_volumes_influence[3], view_volumes_proxy[3];

/* Draws a volume into the bound framebuffer with the camera of the last
 * view_room_render. The depth buffer hides wires behind surfaces but not on
 * them, and does not change. ev: the exposure of the picture; wires look the
 * same at any. *program: 0 until the first draw, which makes it. Changes
 * program and vertex array; turns depth test and blending off. False, with a
 * message.
 */
bool view_volumes_render(GLuint *program, double ev, const ibl_volume *volume,
                         const float colour[3]);

#endif
