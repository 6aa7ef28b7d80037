/* SPDX-License-Identifier: MIT */
/* A sheet of pictures, in which one choice changes along the rows and another
 * along the columns. */
#ifndef VIEW_CONTACT_H
#define VIEW_CONTACT_H

#include "view/options.h"
#include "view/renderer.h"

/* Draws every picture of the sheet, labelled, and writes it. The set is
 * loaded, the screen has the size of one picture. False, with a message. */
bool view_contact_sheet(ibl_ctx *ctx, const view_options *o,
                        const baked_set *set, view_renderer *r);

#endif
