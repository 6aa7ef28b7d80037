/* SPDX-License-Identifier: MIT */
/* What the files of view/scene_captures.h share. */
#ifndef VIEW_SCENE_PARTS_H
#define VIEW_SCENE_PARTS_H

#include "view/scene_captures.h"
#include "view/scene_locals.h"
#include "view/volumes.h"

enum {
    VIEW_SCENE_MIRROR = 0 /* sphere that the probe is in */
};

struct view_scene {
    view_room *room;
    view_volumes *volumes;     /* made when they are to be drawn */
    view_capture *capture;     /* in the mirror, of what moves too */
    view_scene_locals *locals; /* NULL: none */
    int local_count;
    int due;  /* of them, the last, which are still to be captured anew */
    int seen; /* the first, which have been captured ever */
    const view_probe_set *set; /* that was baked; then there are no locals */
    ibl_ctx *ctx;              /* made when the library is to filter */
    view_capture_options made; /* what capture was made by */
    bool limited;              /* and whether it was to see its box alone */
    view_room_draw draw;       /* of the frame that is being made */
    GLuint framebuffer, depth;
    int width, height; /* of depth */
    bool fresh;        /* a whole update was made, and nothing is another */
    bool sun, capture_shadows; /* of the settings that it was made by */
    bool still;                /* what is captured is without what moves */
    bool begun;                /* an update that is spread over frames */
    bool failed; /* the last one: there is none until something changes */
    double begun_at, shown_at;
    int updates;
    bool timed[VIEW_PROBE_FILTERS];
    double ms[VIEW_PROBE_FILTERS][3];     /* of the last update by each */
    ibl_probe wired[VIEW_MAX_LOCALS + 1]; /* whose volumes are drawn */
};

/* Frees them; the next draw makes others. */
void view_scene_drop_captures(view_scene *st);
/* Makes those that settings ask for, where there are others. False, with a
 * message. */
bool view_scene_make_captures(view_scene *st, const view_settings *s);

/* These capture from the position, in the light of st->draw, which has the
 * probes then: everything, local probes one by one where settings spread them;
 * or what is due of that, or of the mirror's. False, with a message. */
bool view_scene_capture_whole(view_scene *st, const view_settings *s,
                              const double position[3]);
bool view_scene_refresh(view_scene *st, const view_settings *s,
                        const double position[3]);

#endif
