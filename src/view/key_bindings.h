/* SPDX-License-Identifier: MIT */
/* What keys do, in one table that the lists of them are made of. */
#ifndef VIEW_KEY_BINDINGS_H
#define VIEW_KEY_BINDINGS_H

#include "view/app.h"

/* A key is a printable character or, beyond Unicode, one of GLFW's codes. */
#define VIEW_KEY(code) (0x110000 + (code))
#define VIEW_KEY_BACK_TAB VIEW_KEY(0) /* with Shift */

/* Does what a key is for; other keys do nothing. */
void view_keys_press(view_app *app, int key);
/* The list that `?` shows: a line for each key or pair of keys, a tab between
 * the keys and what they do. */
void view_keys_text(char *text, int size);
enum {
    VIEW_KEYS_BYTES = 4096 /* room for it */
};

#endif
