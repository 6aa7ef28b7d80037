/* SPDX-License-Identifier: MIT */
/* The actions of keys, in one table from which the lists are made. */
#ifndef VIEW_KEY_BINDINGS_H
#define VIEW_KEY_BINDINGS_H

#include "view/app.h"

/* A key is a printable character or, above Unicode, a code of GLFW. */
#define VIEW_KEY(code) (0x110000 + (code))
#define VIEW_KEY_BACK_TAB VIEW_KEY(0) /* with Shift */

/* Runs the action of a key; unknown keys do nothing. */
void view_keys_press(view_app *app, int key);
/* The list that `?` shows: a line per key or pair of keys, with a tab before
 * the description. */
void view_keys_text(char *text, int size);
enum {
    VIEW_KEYS_BYTES = 4096 /* size for view_keys_text */
};

#endif
