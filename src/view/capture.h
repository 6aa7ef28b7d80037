/* SPDX-License-Identifier: MIT */
/*
 * Captures of the room as cubes, filtered to levels of roughness (ibl/ibl.h:
 * GGX with N = V = R) and irradiance: on the GPU, a face at a time, or by the
 * library. The GPU's levels of cubes of 64 texels and more differ from the
 * library's by an nRMSE of 0.2 % in an evenly lit room, of up to 1.5 % with a
 * light 50 times as bright, 2 % with 200 times and 2.2 % with 1000 times
 * (tests/check_view_capture.c).
 *
 * Alpha is how much of a texel has been seen: 0 where nothing was drawn. It is
 * filtered like the colours, which are premultiplied by it.
 *
 * All calls leave depth test and blending off and no program in use. The
 * framebuffer, the viewport, the units VIEW_CAPTURE_UNIT and _MORE and the
 * vertex array change.
 */
#ifndef VIEW_CAPTURE_H
#define VIEW_CAPTURE_H

#include <stdbool.h>
#include <stdint.h>

#include "ibl/ibl.h"
#include "view/room.h"
#include "view/settings.h"

/* Cube arrays, RGBA16F, filtered linearly. */
typedef struct view_cubes {
    GLuint specular;
    GLuint irradiance; /* E / pi */
} view_cubes;

#define VIEW_CAPTURE_IRRADIANCE 32 /* edge of those cubes */

/* ibl_default_levels(size) levels of count cubes each, undefined at first.
 * False, and both are 0, where OpenGL has no room for them. */
bool view_cubes_make(view_cubes *c, int size, int count);
void view_cubes_free(view_cubes *c); /* and zeroes them */
/* Face 0..5 of level 0 of a cube, 4 halves a pixel. False, with a message. */
bool view_cubes_read(const view_cubes *c, int size, int layer, int face,
                     uint16_t *rgba);

typedef struct view_capture view_capture;

/* What an update captures. It is the same for all steps of one. */
typedef struct view_capture_shot {
    view_room *room;
    /* From draw.eye; clip and paraboloid do not count. */
    view_room_draw draw;
    double far;           /* far plane; the near one is at 0.05 */
    const view_cubes *to; /* of the capture's size */
    int layer;
    ibl_ctx *cpu; /* not NULL: the library filters, in one step */
    bool timed;   /* wait for the end of each step */
} view_capture_shot;

typedef enum view_capture_state {
    VIEW_CAPTURE_FAILED,
    VIEW_CAPTURE_BEGUN,
    VIEW_CAPTURE_DONE
} view_capture_state;

/* The parts of an update whose times are kept. */
enum {
    VIEW_CAPTURE_DRAWING,
    VIEW_CAPTURE_LEVELS,
    VIEW_CAPTURE_DIFFUSE,
    VIEW_CAPTURE_PARTS
};

/* size: of faces, a power of two, 16..1024. Pictures of paraboloids have twice
 * the edge: a third more pixels than six faces. They pay where the scene costs
 * more. NULL, with a message. */
view_capture *view_capture_create(view_probe_capture kind, int size);
void view_capture_free(view_capture *c); /* NULL is fine */

/*
 * Does the next `steps` of an update, at most to its end; with 0 all of one,
 * and drops one that was begun. FAILED, with a message, if the library could
 * not filter: the next is a first step.
 *
 * Steps are: six faces or two sides drawn; the lookups; each face of each level
 * from 1 on; each face of the irradiance. With shot->cpu one step follows the
 * drawn ones.
 */
view_capture_state
view_capture_update(view_capture *c, const view_capture_shot *shot, int steps);
/* Milliseconds of the last whole update: drawing, levels, irradiance (0 if the
 * library made it with the levels). Without shot->timed, the time to ask for
 * them. */
const double *view_capture_times(const view_capture *c);

#endif
