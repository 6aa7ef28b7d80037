/* SPDX-License-Identifier: MIT */
/* The probes of a draw for the room's shaders, and the masks of its tiles. */
#ifndef VIEW_ROOM_PROBES_H
#define VIEW_ROOM_PROBES_H

#include "view/room.h"

typedef struct view_room_probes view_room_probes;

/* Of the uniform block "Room", at its end: std140. */
typedef struct view_room_probe_block {
    int picture_size[4]; /* width, height; edge of tiles, 0: no masks; locals */
    unsigned masks[4];   /* all locals; those before the dynamic one */
    float local_lod[4];  /* scale, offset, last level, irradiance scale */
    float dynamic_lod[4]; /* the same; last is 1, or 0 if there is none */
} view_room_probe_block;

view_room_probes *view_room_probes_create(void); /* NULL, with a message */
void view_room_probes_free(view_room_probes *p); /* NULL is fine */

void view_room_probes_block(view_room_probe_block *b, const view_room_draw *d,
                            const GLint size[2]);
/* Binds what the shaders read, and makes masks if they are wanted. The blocks
 * have been uploaded; depth test and blending are off. */
void view_room_probes_use(view_room_probes *p, const view_room_draw *d,
                          const GLint viewport[4]);
/* As view_room_masks. */
GLuint view_room_probes_masks(const view_room_probes *p, int *columns,
                              int *rows);

#endif
