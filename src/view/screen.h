/* SPDX-License-Identifier: MIT */
/* Pictures in memory, without a display: OSMesa, by dlopen. */
#ifndef VIEW_SCREEN_H
#define VIEW_SCREEN_H

typedef struct view_screen view_screen;

/* Makes an OpenGL 3.3 core context current whose framebuffer 0 has that size,
 * and loads gl. libraries: file names of OSMesa, ended by NULL; NULL: the usual
 * ones. One at a time. NULL, with a message: no OSMesa (names the package), or
 * no OpenGL 3.3 core. */
view_screen *view_screen_memory(int width, int height,
                                const char *const *libraries);
void view_screen_close(view_screen *screen); /* NULL is fine */

#endif
