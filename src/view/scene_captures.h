/* SPDX-License-Identifier: MIT */
/* The room of room.h with a probe in its mirror, which is captured again while
 * things move, and local ones that see what stands still: what --mode scene
 * shows. */
#ifndef VIEW_SCENE_CAPTURES_H
#define VIEW_SCENE_CAPTURES_H

#include "view/capture.h"
#include "view/probe_set.h"
#include "view/room.h"
#include "view/sphere_grid.h"

typedef struct view_scene view_scene;

enum {
    VIEW_SCENE_MIRROR = 0 /* the sphere that the probe is in */
};

view_scene *view_scene_create(void);  /* NULL, with a message */
void view_scene_free(view_scene *st); /* NULL is fine */

/* Local probes from now on, in place of those that settings ask for; NULL:
 * none. They stay the caller's, and until others are given. */
void view_scene_use(view_scene *st, const view_probe_set *probes);

/* What lights the room is another: the next draw captures anew. */
void view_scene_restart(view_scene *st);
/* Frees the captures; the next draw makes others. */
void view_scene_drop_captures(view_scene *st);

/*
 * Draws into a texture of width x height pixels what settings say: camera,
 * turn, parallax, seconds and how the probe is refreshed. The first draw, and
 * each after a change of the light or of the capture, makes a whole capture
 * with its bounces (where settings spread local probes, one of them; each of
 * the next draws another one, and the last of them the mirror's again, which
 * sees nothing move until then); later ones capture when the interval is over
 * and something has moved, going by settings.seconds; if one of these fails,
 * with a message, the probe stays as it is until the next change. turn of the
 * environment is the settings'. Leaves a framebuffer of its own bound, and
 * state as view_room_render does. False, with a message.
 */
bool view_scene_draw(view_scene *st, const view_settings *s,
                     const view_room_environment *environment, GLuint table,
                     GLuint picture, int width, int height);

/* Updates of the probe that were shown, so far. */
int view_scene_updates(const view_scene *st);
/* Milliseconds of the last one that was filtered so: drawing, levels,
 * irradiance. False, and zeros, if there was none of this size and kind of
 * capture. */
bool view_scene_times(const view_scene *st, view_probe_filter filter,
                      double ms[3]);
/* Captures what the last draw was of once more, to be filtered so, for its
 * times alone. False, with a message. */
bool view_scene_measure(view_scene *st, view_probe_filter filter);
/* What the library filters with, once it has been asked to; else NULL. */
ibl_ctx *view_scene_context(view_scene *st);
/* The time that the probe shows: settings.seconds when its capture began. */
double view_scene_shown(const view_scene *st);

/* Writes what the local probes of the last draw have captured into a directory,
 * as probe_save.h says. False, with a message: there are none, too. */
bool view_scene_save(const view_scene *st, ibl_ctx *ctx, const char *dir);

/* What the last draw was drawn by, with its probes. */
const view_room_draw *view_scene_drawn(const view_scene *st);

/* Of the camera, where settings have none. */
extern const double view_scene_distance;
/* The camera goes about the mirror and stays in the room. */
view_camera view_scene_camera(const view_settings *s, int width, int height);

#endif
