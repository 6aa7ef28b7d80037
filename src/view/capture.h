/* SPDX-License-Identifier: MIT */
/*
 * Captures of the room as cubes, filtered to levels of roughness (ibl/ibl.h:
 * GGX with N = V = R) and irradiance, a face at a time. Levels of cubes of 64
 * texels differ from the library's by an nRMSE of 1.5 % in an evenly lit room,
 * up to 4 % with a light 50 times as bright, 11 % with a small one 1000 times
 * as bright (tests/check_view_capture.c).
 *
 * Alpha is the share of a texel that was drawn, 0..1. Filters treat it like the
 * colours, which are premultiplied by it.
 *
 * All calls turn depth test and blending off and leave no program in use. They
 * change the framebuffer, the viewport, the units VIEW_CAPTURE_UNIT and _MORE
 * and the vertex array.
 */
#ifndef VIEW_CAPTURE_H
#define VIEW_CAPTURE_H

#include <stdbool.h>

#include "ibl/ibl.h"
#include "view/room.h"
#include "view/settings.h"

/* Cube arrays, RGBA16F, filtered linearly. */
typedef struct view_cubes {
    GLuint specular;
    GLuint irradiance; /* E / pi */
} view_cubes;

#define VIEW_CAPTURE_IRRADIANCE 32 /* edge of irradiance */

/* Allocates count cubes with ibl_default_levels(size) levels, without defined
 * texels. False, and both are 0, if OpenGL has no memory. */
bool view_cubes_make(view_cubes *c, int size, int count);
void view_cubes_free(view_cubes *c); /* also zeroes them */

typedef struct view_capture view_capture;

/* What an update captures. Must be the same for all steps of an update. */
typedef struct view_capture_shot {
    view_room *room;
    /* Captured from draw.eye; ignores clip and paraboloid. */
    view_room_draw draw;
    double far;           /* far plane; the near plane is at 0.05 */
    const view_cubes *to; /* cubes of the capture's size */
    int layer;
    bool timed; /* waits for the end of each step */
} view_capture_shot;

typedef enum view_capture_state {
    VIEW_CAPTURE_FAILED,
    VIEW_CAPTURE_BEGUN,
    VIEW_CAPTURE_DONE
} view_capture_state;

/* Parts of an update that are timed. */
enum {
    VIEW_CAPTURE_DRAWING,
    VIEW_CAPTURE_LEVELS,
    VIEW_CAPTURE_DIFFUSE,
    VIEW_CAPTURE_PARTS
};

/* size: edge of a face, a power of two, 16..1024. Pictures of paraboloids have
 * twice the edge: a third more pixels than six faces. They pay off if the scene
 * is more expensive to draw. NULL, with a message. */
view_capture *view_capture_create(view_probe_capture kind, int size);
void view_capture_free(view_capture *c); /* NULL is fine */

/*
 * Does the next `steps` steps of an update, at most to its end. 0: drops an
 * update that was begun, and does a whole one. FAILED, with a message, if
 * OpenGL fails; the next call then begins a new update.
 *
 * The steps are: draw each of six faces or two sides; make the lookups; fill
 * each face of each level from 1 on; fill each face of the irradiance.
 */
view_capture_state
view_capture_update(view_capture *c, const view_capture_shot *shot, int steps);
/* Milliseconds of the last update, once it is DONE: drawing, levels,
 * irradiance. Without shot->timed, the time to issue the commands. */
const double *view_capture_times(const view_capture *c);

/* ---- samples (capture_samples.c) --------------------------------------- */

/* Number of levels of the lookups; the last has four texels along an edge. */
int view_capture_lookups(int size);
/* Variance along an axis of a lookup in a level from 1 on, in mean solid angles
 * of a texel: wide enough to hide that texel sizes vary 5-fold. */
#define VIEW_CAPTURE_BLUR (5.0 / 3)

/* Samples for each texel: of a level, and of irradiance, whose small cube must
 * be as accurate as a level. */
enum {
    VIEW_CAPTURE_SAMPLES = 64,
    VIEW_CAPTURE_MOST_SAMPLES = 128
};

/* Rows of VIEW_CAPTURE_MOST_SAMPLES: one for each level from 1 on, one for
 * irradiance. A sample: x, y of a direction about +Z, weight, level of the
 * lookup. The caller must free it. */
float *view_capture_samples(int size, int levels);

#endif
