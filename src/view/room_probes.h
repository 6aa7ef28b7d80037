/* SPDX-License-Identifier: MIT */
/* Probes of a draw for the room's shaders, and the masks of its tiles. */
#ifndef VIEW_ROOM_PROBES_H
#define VIEW_ROOM_PROBES_H

#include "view/room.h"

typedef struct view_room_probes {
    GLuint program;
    GLuint buffer, texels; /* packed probes, and their buffer texture */
    GLuint none;           /* array of one black cube */
    GLuint masks, framebuffer;
    int columns, rows; /* size of masks */
} view_room_probes;

/* The last members of the uniform block "Room", std140. */
typedef struct view_room_probe_block {
    int picture_size[4]; /* width, height, tile edge or 0: no masks, locals */
    int order[4];        /* locals before the dynamic one, rows of tiles */
    float local_lod[4], dynamic_lod[4]; /* as view_frame.lod */
    float scales[4]; /* irradiance: locals, dynamic one; then 1 with dynamic */
} view_room_probe_block;

/* *p must be zeroed. False, with a message. */
bool view_room_probes_make(view_room_probes *p);
void view_room_probes_free(view_room_probes *p); /* zeroed is fine */

void view_room_probes_block(view_room_probe_block *b, const view_room_draw *d,
                            const GLint size[2]);
/* Binds everything that the shaders read. Renders masks if the draw uses them,
 * which changes framebuffer and viewport. The blocks must be uploaded; depth
 * test, culling and blending must be off. */
void view_room_probes_use(view_room_probes *p, const view_room_draw *d,
                          const GLint size[2]);

#endif
