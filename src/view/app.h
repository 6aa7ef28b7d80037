/* SPDX-License-Identifier: MIT */
/* State of the viewer, with a window or without, and what keys, the panel and
 * frames do to it. */
#ifndef VIEW_APP_H
#define VIEW_APP_H

#include <limits.h>

#include "view/controls.h"
#include "view/folder.h"
#include "view/renderer.h"
#include "view/room.h"

/* Frames since the last line of --stats; all zero at the start. */
typedef struct view_stats {
    int frames;
    double sum, worst, gpu; /* milliseconds; gpu: by OpenGL's timer, summed */
    double begun;           /* ibl_now() before the first frame */
} view_stats;

typedef struct view_app {
    ibl_ctx *ctx;
    const view_options *options;
    struct GLFWwindow *window;
    int width, height; /* of the framebuffer in pixels; above --size on a
                          display with a scale */
    double scale;      /* pixel scale of the display: 1 or more */
    view_renderer *renderer;
    view_probe_set *probes; /* from --probe-set, or NULL */
    view_model *model;      /* or NULL */

    view_settings side[2];  /* what is shown, and what it is compared with */
    int edited;             /* the one that keys and the panel change */
    view_settings drawn[2]; /* sides of the last frame that was drawn */

    /* The set that is shown is in one slot; the other takes the next. */
    baked_set sets[2];
    baked_set *set;       /* NULL: none is loaded yet */
    baked_set other;      /* of --against-set, or zeroed */
    view_request request; /* the source of set */
    char path[PATH_MAX];

    view_folder folder; /* of the list of files */

    /* A map that is being baked and will be shown. */
    view_baker *baker;
    char baking[PATH_MAX]; /* path of the map */
    double baked;          /* share of the bake that is done, 0..1 */

    double begun;    /* ibl_now() when the scene's time began */
    bool paused;     /* the scene's time stands still */
    double mouse[2]; /* pixels from the upper left; -1: not in the window */
    int held;        /* 1 + the button of a drag; 0: none */
    bool panel, help, files; /* what is open */
    bool labels;             /* are drawn */
    const char *caption;     /* of a sheet's picture, or NULL */
    char errors[80];         /* of what is compared */
    int judged;              /* samples of the reference that they are of */
    double frame_ms;
    view_stats stats;
    GLuint target;      /* framebuffer */
    char notice[400];   /* "": none */
    double notice_ends; /* ibl_now() when it goes */
    bool failed;        /* it says why something failed */
    bool redraw;        /* something changed since the last frame */
    bool wants_picture;
    bool quit;
} view_app;

/* ---- what is shown ------------------------------------------------------ */

/* Makes the renderer for the current context, and loads the model, the probe
 * set and the other set of the options. False after a message. */
bool view_app_make(view_app *app);
/* Opens a set, a model, a folder's list of files or, in the scene, a set of
 * probes, or begins to bake a map. False after a message, which is shown, too;
 * the picture is then unchanged. */
bool view_app_open(view_app *app, const view_request *what);
/* Shows the list of files beside what is shown. */
void view_app_list(view_app *app);
/* Opens an entry of that list, or its parent "..". */
void view_app_choose(view_app *app, const char *name);
/* Opens the next file of the same kind in its folder, or the one before. */
void view_app_step(view_app *app, int step);
/* Updates the progress of the bake, and shows its result; opens another layer
 * of an array. False: a bake failed and there is no earlier set to show. */
bool view_app_tend(view_app *app);
/* Limits the settings to what the set has, shares them between the sides, and
 * requests a frame. */
void view_app_fit(view_app *app);
/* view_control_why of the side that is edited. */
const char *view_app_why(const view_app *app, const view_control *c);
/* Stops the bake and frees all but the sets, while the context is current. */
void view_app_end(view_app *app);

#define VIEW_LINE 17 /* height of a line of labels, at scale 1 */

int view_app_panel_width(const view_app *app);
/* Where the picture is: beside labels and panel. */
view_area view_app_area(const view_app *app);
/* Size of a whole map there, as it is zoomed, in pixels. */
void view_app_map_size(const view_app *app, double size[2]);
/* Draws into app->target; spread: as in view_settings. If that fails, restores
 * the settings of the last frame, draws again and sets a notice. False, with a
 * message, if that fails too. */
bool view_app_draw(view_app *app, bool spread);
/* Sets the exposure so that the mean luminance of the picture is middle grey.
 */
bool view_app_expose(view_app *app);
/* Shows a text for some seconds. */
void view_app_notice(view_app *app, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
/* Shows the last message of view_fail. */
void view_app_notice_failure(view_app *app);

/* ---- around and over the picture (labels.c) ----------------------------- */

/* Draws labels beside what they label (what is shown, what
 * rows and columns are, which half is which and how they differ, the scales of
 * false colours and differences), the panel, and whatever is open. */
void view_labels_draw(view_app *app);
/* Prints the error of the last draw of two sides: a line for each sphere or
 * material of the model that shows, and for all. */
void view_labels_print(const view_app *app);
/* --stats: prints a line of NAME=VALUE words, at last what draws, and begins
 * anew. */
void view_stats_add(view_stats *t, double ms, double gpu);
void view_stats_print(view_stats *t, const view_renderer *r,
                      const view_settings *s);

/* ---- what keys and the mouse do (key_bindings.c) ------------------------ */

/* Does what a key does, and says what it changed; unknown keys do nothing. */
void view_keys_press(view_app *app, int key);
/* Drags the picture by pixels: turns the camera, by half a turn for the height
 * of the picture, or moves the map. */
void view_drag(view_app *app, double dx, double dy);
/* Moves the camera nearer, or enlarges the map around a pixel of the window, by
 * a factor 1.1 per step. */
void view_approach(view_app *app, double x, double y, double steps);
/* Moves a model by pixels, with what is in the middle of its distance. */
void view_pan(view_app *app, double dx, double dy);
/* Turns the environment by degrees. */
void view_spin(view_app *app, double degrees);

/* ---- runs --------------------------------------------------------------- */

/* Runs the window until it is closed. False after a message. */
bool view_window_run(ibl_ctx *ctx, const view_options *options);

/* ---- pictures in files (still.c) ---------------------------------------- */

/* Opens or bakes the set of the options and makes their outputs: a picture, a
 * contact sheet or a turntable. False, with a message. */
bool view_still_run(ibl_ctx *ctx, const view_options *o);
/* Bakes a map, or opens a set. False, with a message, and *set zeroed. */
bool view_still_load(ibl_ctx *ctx, const view_request *what, baked_set *set);
/* Writes what a window shows to the first iblview-NNN.png that does not exist,
 * and says so, or why not. */
void view_still_write(view_app *app);

#endif
