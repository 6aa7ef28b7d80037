/* SPDX-License-Identifier: MIT */
/* The room of room.h with a probe in its mirror, which is captured again while
 * things move, and local ones that see what stands still: what --mode scene
 * shows. */
#ifndef VIEW_STAGE_H
#define VIEW_STAGE_H

#include "view/capture.h"
#include "view/probe_set.h"
#include "view/room.h"
#include "view/scene.h"

typedef struct view_stage view_stage;

view_stage *view_stage_create(void);  /* NULL, with a message */
void view_stage_free(view_stage *st); /* NULL is fine */

/* Local probes from now on, in place of those that settings ask for; NULL:
 * none. They stay the caller's, and until others are given. */
void view_stage_use(view_stage *st, const view_probe_set *probes);

/* What lights the room is another: the next draw captures anew. */
void view_stage_restart(view_stage *st);

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
bool view_stage_draw(view_stage *st, const view_settings *s,
                     const view_room_environment *environment, GLuint table,
                     GLuint picture, int width, int height);

/* Updates of the probe that were shown, so far. */
int view_stage_updates(const view_stage *st);
/* Milliseconds of the last one that was filtered so: drawing, levels,
 * irradiance. False, and zeros, if there was none of this size and kind of
 * capture. */
bool view_stage_times(const view_stage *st, view_probe_filter filter,
                      double ms[3]);
/* Captures what the last draw was of once more, to be filtered so, for its
 * times alone. False, with a message. */
bool view_stage_measure(view_stage *st, view_probe_filter filter);
/* What the library filters with, once it has been asked to; else NULL. */
ibl_ctx *view_stage_context(view_stage *st);
/* The time that the probe shows: settings.seconds when its capture began. */
double view_stage_shown(const view_stage *st);

/* Writes what the local probes of the last draw have captured into a directory,
 * as probe_save.h says. False, with a message: there are none, too. */
bool view_stage_save(const view_stage *st, ibl_ctx *ctx, const char *dir);

/* What the last draw was drawn by, with its probes. */
const view_room_draw *view_stage_drawn(const view_stage *st);

/* Of the camera, where settings have none. */
extern const double view_stage_distance;
/* The camera goes about the mirror and stays in the room. */
view_camera view_stage_camera(const view_settings *s, int width, int height);

#endif
