/* SPDX-License-Identifier: MIT */
/* State of the viewer, with a window or without, and the actions of keys and
 * frames on it. */
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
    int width, height; /* of the framebuffer in pixels; above --size on a
                          display with a scale */
    double scale;      /* pixel scale of the display: 1 or more */
    view_renderer *renderer;
    view_overlay *overlay;
    view_probe_set *probes; /* from --probe-set, or NULL */
    view_model *model;      /* or NULL */
    char model_path[PATH_MAX];
    view_file_stamp model_seen;

    view_settings settings;
    view_settings drawn; /* of the last frame that was drawn */
    bool drew;           /* drawn holds the settings of a frame */

    /* The set that is shown is in one slot; the other takes the next. */
    baked_set sets[2];
    baked_set *set;       /* NULL: none is loaded yet */
    baked_set other;      /* of --against-set, or zeroed */
    view_request request; /* the source of set */
    char path[PATH_MAX];

    /* A map that is being baked and will be shown. */
    view_baker *baker;
    char baking[PATH_MAX]; /* path of the map */
    char stage[64];
    double baked; /* share of the bake that is done, 0..1 */

    double begun;    /* ibl_now() when the scene's time began */
    double mouse[2]; /* pixels from the upper left; -1: not in the window */
    bool held[3];    /* buttons */
    int mods;        /* keys that were down with the last button, GLFW's */
    int dragged;     /* 1 + row of the panel whose slider is held, or 0 */
    double frame_ms;
    view_stats stats;
    char title[512];
    char notice[200]; /* shown until a key or a click; "": none */
    bool redraw;      /* something changed since the last frame */
    bool quit;
} view_app;

/* ---- what is shown ------------------------------------------------------ */

/* Makes renderer and overlay for the current context, and loads the probe set
 * and the other set of the options. False after a message. */
bool view_app_make(view_app *app);
/* Opens a set, or begins to bake a map. False after a message; the picture is
 * then unchanged. */
bool view_app_open(view_app *app, const view_request *what);
/* Updates the progress of the bake, and shows its result. False: it failed and
 * there is no earlier set to show. */
bool view_app_tend_bake(view_app *app);
/* Reloads files that have changed. If one cannot be read, the picture stays. */
void view_app_tend_files(view_app *app);
/* Limits the settings to what the set has, and requests a frame. */
void view_app_fit(view_app *app);
/* Stops the bake and frees renderer, overlay, probes and the other set, while
 * the context is current. */
void view_app_end(view_app *app);

/* Draws into framebuffer 0; spread: as in view_settings. If that fails,
 * restores the settings of the last frame, draws again and sets a notice.
 * False, with a message, if that fails too. */
bool view_app_draw(view_app *app, bool spread);

/* ---- what keys do ------------------------------------------------------- */

/* Writes the picture to the first iblview-NNN.png that does not exist. */
void view_app_picture(view_app *app);
/* Shows a text until the next key or click. */
void view_app_notice(view_app *app, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
/* The end of a path, of that many bytes: it says more than the beginning. */
const char *view_path_end(const char *path, size_t most);
/* Shows that a file cannot be displayed. */
void view_app_notice_path(view_app *app, const char *path);

/* ---- the panel (panel.c) ------------------------------------------------ */

/* Draws the controls of the mode at the upper right, or a word that opens them
 * if they are hidden and the pointer is in that quarter. Between
 * view_overlay_begin and _end. */
void view_panel_draw(const view_app *app);
/* The share of the width, at the right, that the controls cover. */
double view_panel_share(const view_app *app);
/* Handles a press of the left button at the pointer, or with drag a motion
 * while it is held. False: no control is there. */
bool view_panel_point(view_app *app, bool drag);

/* ---- the window (window.c, panel.c) ------------------------------------ */

/* Runs the window until it is closed. False after a message. */
bool view_window_run(ibl_ctx *ctx, const view_options *options);
/* Draws the text of the window: keys, the texel under the cursor, progress of a
 * bake, notice, scale of false colours. */
void view_window_text(view_app *app);
/* Sets the title to the set and what was changed. */
void view_app_title(view_app *app);

/* ---- pictures without a window (still.c) ------------------------------- */

/* Opens or bakes the set of the options and makes their outputs: a picture,
 * captures, or a contact sheet. False, with a message. */
bool view_still_run(ibl_ctx *ctx, const view_options *o);
/* Draws the frames or samples that the options ask for. *ms: time of the last
 * frame; stats: adds the times of all. False, with a message. */
bool view_still_draw(view_renderer *r, const view_options *o,
                     const view_settings *s, double *ms, view_stats *stats);

#endif
