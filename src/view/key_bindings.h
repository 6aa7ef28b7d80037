/* SPDX-License-Identifier: MIT */
/* What keys and the panel change, in one table from which the lists are made.
 */
#ifndef VIEW_KEY_BINDINGS_H
#define VIEW_KEY_BINDINGS_H

#include <stddef.h>

#include "view/app.h"

/* A key is a printable character or, above Unicode, a code of GLFW. */
#define VIEW_KEY(code) (0x110000 + (code))
#define VIEW_KEY_BACK_TAB VIEW_KEY(0) /* with Shift */

/* How a control changes a setting. */
typedef enum view_change {
    VIEW_SWITCHES,   /* a bool */
    VIEW_CYCLES,     /* an enumeration, through `high` values */
    VIEW_COUNTS,     /* an int, by 1 */
    VIEW_ADDS,       /* a double, by `by` */
    VIEW_MULTIPLIES, /* a double, by the factor `by` */
    VIEW_SLIDES      /* a double, on the panel, in steps of `by` */
} view_change;

typedef struct view_control {
    const char *keys, *what; /* for lists; NULL: on the panel alone */
    int key;                 /* act(app, 1); -1: none, 0: the table's end */
    int back;                /* act(app, -1), 0: none */
    int last; /* key..last: set an int to the key's index; 0: none */
    void (*act)(view_app *app, int step); /* NULL: change: */
    view_change change;
    size_t offset; /* of the setting */
    double by;
    double low, high; /* limits of the setting */
    /* on the panel */
    unsigned modes; /* bits of view_mode: where it is shown */
    const char *label;
    const char *const *names; /* of values; NULL: numbers, or materials */
} view_control;

extern const view_control view_controls[];
void *view_control_field(const view_control *c, view_settings *s);

/* Runs the action of a key; unknown keys do nothing. */
void view_keys_press(view_app *app, int key);
/* The list that `?` shows: a line per key or pair of keys, with a tab before
 * the description. */
void view_keys_text(char *text, int size);
enum {
    VIEW_KEYS_BYTES = 4096 /* size for view_keys_text */
};

/* ---- arrows, mouse and wheel ------------------------------------------- */

/* A pixel of a picture, from its upper left. */
typedef struct view_place {
    int width, height; /* of the picture */
    double x, y;
} view_place;

/* Drags by pixels: turns the camera, by half a turn for the height of the
 * picture, or moves the map. */
void view_drag(view_settings *s, const baked_set *set, int width, int height,
               double dx, double dy);
/* Moves the camera nearer, or enlarges the map around a pixel, by a factor 1.1
 * per step. */
void view_approach(view_settings *s, const baked_set *set, view_place at,
                   double steps);
/* Moves a model by pixels, with what is in the middle of its distance. */
void view_pan(view_settings *s, int width, int height, double dx, double dy);
/* Turns the environment by degrees. */
void view_spin(view_settings *s, double degrees);
/* Moves the first light about the origin at its distance: around +Y and up, by
 * degrees. Makes one if there is none. */
void view_move_light(view_settings *s, double around, double up);

#endif
