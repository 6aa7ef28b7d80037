/* SPDX-License-Identifier: MIT */
/* The state of the window, and what both its keys and its frames do to it. */
#ifndef VIEW_APP_H
#define VIEW_APP_H

#include "view/options.h"
#include "view/overlay.h"
#include "view/probe_set.h"
#include "view/renderer.h"
#include "view/report.h"
#include "view/screen.h"

typedef struct view_app {
    ibl_ctx *ctx;
    const view_options *options;
    view_screen *screen;
    view_renderer *renderer;
    view_overlay *overlay;
    view_probe_set *probes; /* of a file, or NULL */

    view_settings settings;
    view_settings drawn; /* those of the last frame that could be drawn */
    bool drew;           /* there was one */

    /* What is shown: one slot, while the other one is filled. */
    baked_set sets[2];
    const baked_set *set; /* NULL: nothing yet */
    view_stamp stamp;     /* of its files */
    view_request request; /* where it is from; path is its own copy */
    char *path;           /* the same */

    /* A map that is being baked, to be shown after that. */
    view_baker *baker;
    char *baking; /* its path */
    char stage[64];
    double baked; /* share of the whole bake */

    double begun;    /* view_clock() when the scene's time began */
    double mouse[2]; /* pixels from the upper left */
    bool held[3];    /* buttons */
    double frame_ms;
    view_stats stats;
    char title[512];
    char notice[200]; /* on screen until a key or a click; "": none */
    bool redraw;      /* something changed since the last frame */
    bool quit;
} view_app;

/* Draws what is shown into framebuffer 0; spread: as settings have it. If that
 * fails, restores the settings of the last frame, draws that and gives a
 * notice. False, with a message, if that fails too. */
bool view_app_draw(view_app *app, bool spread, int width, int height);

/* ---- what keys do ------------------------------------------------------- */

/* Back to what the command line said. */
void view_app_reset(view_app *app);
/* Writes what is shown to the first iblview-NNN.png that is not there. */
void view_app_picture(view_app *app);
/* Says something on the screen until the next key or click. */
void view_app_notice(view_app *app, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));

#endif
