/* SPDX-License-Identifier: MIT */
/* What the two kinds of screen share; only the files screen*.c see it. */
#ifndef VIEW_SCREEN_KIND_H
#define VIEW_SCREEN_KIND_H

#include "view/screen.h"

/* The calls of screen.h. about is the text of OpenGL and kept here. */
typedef struct view_screen_kind {
    void (*close)(view_screen *screen);
    void (*size)(const view_screen *screen, int *width, int *height);
    double (*scale)(const view_screen *screen);
    void (*show)(view_screen *screen);
    bool (*poll)(view_screen *screen, double wait);
    void (*title)(view_screen *screen, const char *title);
} view_screen_kind;

/* The first member of each kind's own struct. */
struct view_screen {
    const view_screen_kind *kind;
    char about[256];
};

/* Writes about, of the context that is current. */
void view_screen_describe(view_screen *screen);

/* view_screen_memory with the names that the library is looked for by, ended
 * by NULL. */
view_screen *view_screen_memory_from(const char *const *libraries, int width,
                                     int height);

#endif
