/* SPDX-License-Identifier: MIT */
/* What the program shows, in a window or in pictures, and what keys and frames
 * do to it. */
#ifndef VIEW_APP_H
#define VIEW_APP_H

#include <limits.h>

#include "view/options.h"
#include "view/overlay.h"
#include "view/probe_set.h"
#include "view/renderer.h"
#include "view/report.h"

typedef struct view_app {
    ibl_ctx *ctx;
    const view_options *options;
    struct GLFWwindow *window;
    int width, height; /* of the framebuffer in pixels: more than asked for
                          where the display has a scale */
    double scale;      /* pixels of text for one of an ordinary display */
    view_renderer *renderer;
    view_overlay *overlay;
    view_probe_set *probes; /* of a file, or NULL */

    view_settings settings;
    view_settings drawn; /* those of the last frame that could be drawn */
    bool drew;           /* there was one */

    /* What is shown: one slot, while the other one is filled. */
    baked_set sets[2];
    baked_set *set;       /* NULL: nothing yet */
    view_request request; /* where it is from: */
    char path[PATH_MAX];

    /* A map that is being baked, to be shown after that. */
    view_baker *baker;
    char baking[PATH_MAX]; /* its path */
    char stage[64];
    double baked; /* share of the whole bake */

    double begun;    /* view_clock() when the scene's time began */
    double mouse[2]; /* pixels from the upper left; -1: not in the window */
    bool held[3];    /* buttons */
    double frame_ms;
    view_stats stats;
    char title[512];
    char notice[200]; /* on screen until a key or a click; "": none */
    bool redraw;      /* something changed since the last frame */
    bool quit;
} view_app;

/* ---- what is shown ------------------------------------------------------ */

/* Makes what draws, with the probes of the options, for the current context.
 * False after a message. */
bool view_app_make(view_app *app);
/* Opens a set, or begins to bake a map. False after a message; the picture
 * stays. */
bool view_app_open(view_app *app, const view_request *what);
/* Asks for the progress of the bake, and shows its result. False: the first
 * thing to show has failed. */
bool view_app_tend_bake(view_app *app);
/* Reads files anew that have changed. Those that cannot be read leave what is
 * shown. */
void view_app_tend_files(view_app *app);
/* Limits the settings to what the set has, and asks for a frame. */
void view_app_fit(view_app *app);
/* Ends the bake and frees what draws, while the context is current. */
void view_app_end(view_app *app);

/* Draws what is shown into framebuffer 0; spread: as settings have it. If that
 * fails, restores the settings of the last frame, draws that and gives a
 * notice. False, with a message, if that fails too. */
bool view_app_draw(view_app *app, bool spread);

/* ---- what keys do ------------------------------------------------------- */

/* Back to what the command line said. */
void view_app_reset(view_app *app);
/* Writes what is shown to the first iblview-NNN.png that is not there. */
void view_app_picture(view_app *app);
/* Says something on the screen until the next key or click. */
void view_app_notice(view_app *app, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
/* The same of a file that is not shown. */
void view_app_notice_path(view_app *app, const char *path);

/* ---- the window (window.c, window_text.c) --------------------------------
 */

/* Shows what the options say until the window is closed. False after a
 * message. */
bool view_window_run(ibl_ctx *ctx, const view_options *options);
/* Draws the window's text: keys, the texel under the cursor, progress of a
 * bake, notice, scale of false colours. */
void view_window_text(view_app *app);
/* Sets the title to what is shown and how. */
void view_app_title(view_app *app);

/* ---- pictures without a window (still.c) ---------------------------------
 */

/* Opens or bakes what the options name, and makes what they ask for: a picture,
 * captures, or a sheet with one choice along its rows and another along its
 * columns. False, with a message. */
bool view_still_run(ibl_ctx *ctx, const view_options *o);
/* Draws until the options' frames or samples are there. *ms: the time of the
 * last frame; those of all are added to stats. False, with a message. */
bool view_still_draw(view_renderer *r, const view_options *o,
                     const view_settings *s, double *ms, view_stats *stats);

#endif
