/* SPDX-License-Identifier: MIT */
/* What keys do, in one table that the lists of them are made of. */
#ifndef VIEW_KEY_BINDINGS_H
#define VIEW_KEY_BINDINGS_H

#include "view/app.h"

/* Does what a key is for; other keys do nothing. */
void view_keys_press(view_app *app, int key, bool shift);
/* The list that `?` shows, and --keys prints: a line for each key or pair of
 * keys, the keys in the first 16 columns. */
void view_keys_text(char *text, int size);
enum {
    VIEW_KEYS_BYTES = 4096 /* room for it */
};

#endif
