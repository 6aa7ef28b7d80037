/* SPDX-License-Identifier: MIT */
/* The probes of a draw for the room's shaders, and the masks of its tiles. */
#ifndef VIEW_ROOM_PROBES_H
#define VIEW_ROOM_PROBES_H

#include "view/room.h"

typedef struct view_room_probes {
    GLuint program;
    GLuint buffer, texels; /* what is packed, and the texture of it */
    GLuint none;           /* array of one black cube */
    GLuint masks, framebuffer;
    int columns, rows; /* of masks */
} view_room_probes;

/* Of the uniform block "Room", at its end: std140. */
typedef struct view_room_probe_block {
    int picture_size[4]; /* width, height; edge of tiles, 0: no masks; locals */
    unsigned masks[4];   /* all locals; those before the dynamic one */
    float local_lod[4], dynamic_lod[4]; /* as view_frame.lod */
    float scales[4]; /* irradiance of locals, of the dynamic one; 1 with it */
} view_room_probe_block;

/* Makes a zeroed one. False, with a message. */
bool view_room_probes_make(view_room_probes *p);
void view_room_probes_free(view_room_probes *p); /* zeroed is fine */

void view_room_probes_block(view_room_probe_block *b, const view_room_draw *d,
                            const GLint size[2]);
/* Binds what the shaders read, and makes masks if they are wanted: then the
 * framebuffer and the viewport are others. The blocks have been uploaded; depth
 * test, culling and blending are off. */
void view_room_probes_use(view_room_probes *p, const view_room_draw *d,
                          const GLint size[2]);

#endif
