/* SPDX-License-Identifier: MIT */
/* Where pictures go: a window (GLFW) or memory (OSMesa, by dlopen). Either has
 * a current OpenGL 3.3 core context, with gl loaded, and framebuffer 0. One
 * screen at a time. */
#ifndef VIEW_SCREEN_H
#define VIEW_SCREEN_H

#include <stdbool.h>

typedef struct view_screen view_screen;

/* Events of a window, to members that are not NULL. Positions are in
 * framebuffer pixels from the upper left. */
typedef struct view_events {
    void *cookie;
    /* A printable character or, beyond 0x10FFFF, a view_key. */
    void (*key)(void *cookie, int key, bool shift);
    /* button -1: moved; 0, 1, 2: left, right, middle went down or up. Moved to
     * -1, -1: has left the window. */
    void (*mouse)(void *cookie, double x, double y, int button, bool down);
    void (*wheel)(void *cookie, double steps);
    void (*drop)(void *cookie, const char *path); /* of each dropped file */
    void (*refresh)(
        void *cookie); /* the size changed or the picture is lost: draw anew */
} view_events;

enum {
    VIEW_KEY_ESCAPE = 0x110000,
    VIEW_KEY_LEFT,
    VIEW_KEY_RIGHT,
    VIEW_KEY_UP,
    VIEW_KEY_DOWN,
    VIEW_KEY_PAGE_UP,
    VIEW_KEY_PAGE_DOWN,
    VIEW_KEY_HOME,
    VIEW_KEY_END,
    VIEW_KEY_TAB,
    VIEW_KEY_ENTER,
    VIEW_KEY_BACKSPACE
};

/* A picture in memory, without a display. NULL, with a message: no OSMesa
 * (names the package), or no OpenGL 3.3 core. */
view_screen *view_screen_memory(int width, int height);

/* A window of that size in screen coordinates. events must stay until it is
 * closed. NULL, with a message: no display, or no OpenGL 3.3 core. */
view_screen *view_screen_window(int width, int height, const char *title,
                                const view_events *events);
void view_screen_close(view_screen *screen); /* NULL is fine */

/* Present size of the framebuffer in pixels, 1 or more: larger than asked for
 * where the display has a scale. */
void view_screen_size(const view_screen *screen, int *width, int *height);
/* How many pixels text needs for one of an ordinary display, 1 or more. */
double view_screen_scale(const view_screen *screen);

/* Shows what was drawn (in memory: finishes it). */
void view_screen_show(view_screen *screen);
/* Delivers events; wait: returns after one, or after that many seconds.
 * 0: at once. False: the window is to be closed. In memory: true. */
bool view_screen_poll(view_screen *screen, double wait);
void view_screen_title(view_screen *screen, const char *title);
/* "OpenGL 4.5 (Core Profile) Mesa 22.3.6, llvmpipe ..." */
const char *view_screen_about(const view_screen *screen);

/* ---- for the files screen*.c ----------------------------------------------
 */

/* The calls above. NULL: nothing to do; the scale is 1, there are no events. */
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

/* view_screen_memory with the names of the library, ended by NULL. */
view_screen *view_screen_memory_from(const char *const *libraries, int width,
                                     int height);

#endif
