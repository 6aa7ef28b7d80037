/* SPDX-License-Identifier: MIT */
/* The room in light that is white everywhere, by the table of a surface that
 * loses nothing: each material has one colour. The sky says what direction it
 * is in. */
#ifndef LIT_ROOM_H
#define LIT_ROOM_H

#include "room.h"

typedef struct lit_room {
    view_room *room;
    room_target target;
    GLuint white, black, sky, table;
} lit_room;

extern lit_room lit;

/* Opens a screen of that size, too. False where the running test is skipped,
 * or has failed. */
bool lit_begin(int width, int height);
void lit_end(void);

view_room_draw lit_draw(const view_camera *camera);
/* RGBA, rows from the top; free() it. */
float *lit_render(const view_room_draw *draw);
/* Whether a pixel has the colour of what a ray meets. The sky is a filtered
 * texture, which is less exact. */
bool lit_has_colour(const float *pixel, const room_hit *hit, double tolerance);

#endif
