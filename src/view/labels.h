/* SPDX-License-Identifier: MIT */
/* Labels of pictures: what is shown, what rows and columns are, which half is
 * which, and the scales of false colours and differences. */
#ifndef VIEW_LABELS_H
#define VIEW_LABELS_H

#include "view/overlay.h"
#include "view/renderer.h"

#define VIEW_LABEL_BYTES 400

/* Writes what the last draw shows, as "sky, gold, split". */
void view_labels_title(const view_settings *s, const view_renderer *r,
                       const baked_set *set, char text[VIEW_LABEL_BYTES]);
/* Draws the title and all other labels on the bound framebuffer, of width x
 * height pixels; nothing if the title has no room. */
void view_labels_draw(view_overlay *overlay, const view_settings *s,
                      const baked_set *set, int width, int height,
                      const char *title);

#endif
