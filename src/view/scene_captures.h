/* SPDX-License-Identifier: MIT */
/* What --mode scene shows: the room with a probe in its mirror, captured again
 * while things move, and local probes of what stands still. */
#ifndef VIEW_SCENE_CAPTURES_H
#define VIEW_SCENE_CAPTURES_H

#include "view/capture.h"
#include "view/probe_set.h"
#include "view/sphere_grid.h"

typedef struct view_scene view_scene;

enum {
    VIEW_SCENE_MIRROR = 0 /* the sphere that the probe is in */
};

view_scene *view_scene_create(void);  /* NULL, with a message */
void view_scene_free(view_scene *st); /* NULL is fine */

/* Local probes in place of those that settings ask for; NULL: none. They stay
 * the caller's and must stay until the next call. The next draw captures anew,
 * as it must when another environment lights the room. */
void view_scene_use(view_scene *st, const view_probe_set *probes);

/*
 * Draws into a texture of width x height pixels by settings: camera, turn,
 * parallax, seconds and how the probe is refreshed.
 * The first draw, and each after a change of the light or of the capture, makes
 * a whole capture with its bounces. If settings spread local probes, each draw
 * captures one of them, the last the mirror's too, and nothing moves in it
 * until then. Later draws capture when the interval is over, by
 * settings.seconds, and something has moved. If that fails, with a message, the
 * probe stays until the next change. Leaves its framebuffer bound, and state as
 * view_room_render. False, with a message.
 */
bool view_scene_draw(view_scene *st, const view_settings *s,
                     const view_room_environment *environment, GLuint table,
                     GLuint picture, int width, int height);

/* What draws have left. */
typedef struct view_scene_state {
    view_room_draw draw; /* what the last one was drawn by, with its probes */
    int updates;         /* of the probe that were shown, so far */
    double shown;        /* settings.seconds when the probe's capture began */
    /* Milliseconds of the last update by each filter; false, and zeros: there
     * was none of this size and kind of capture. */
    bool timed[VIEW_PROBE_FILTERS];
    double ms[VIEW_PROBE_FILTERS][VIEW_CAPTURE_PARTS];
} view_scene_state;

const view_scene_state *view_scene_state_of(const view_scene *st);
/* Captures the last draw once more, only for the times of that filter. False,
 * with a message. */
bool view_scene_measure(view_scene *st, view_probe_filter filter);
/* What the library filters with, once it has been asked to; else NULL. */
ibl_ctx *view_scene_context(view_scene *st);

/* Writes the captures of local probes into a directory (probe_save.h). False,
 * with a message, also if there are none. */
bool view_scene_save(const view_scene *st, ibl_ctx *ctx, const char *dir);

/* Of the camera, where settings have none. */
extern const double view_scene_distance;
/* The camera goes about the mirror and stays in the room. */
view_camera view_scene_camera(const view_settings *s, int width, int height);

#endif
