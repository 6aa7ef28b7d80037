/* SPDX-License-Identifier: MIT */
/* The end of view_options_parse. */
#ifndef VIEW_OPTIONS_CHECK_H
#define VIEW_OPTIONS_CHECK_H

#include "view/options.h"

/* Once all options are known: fills in what was left open. False, with a
 * message, if they do not go together. */
bool view_options_finish(view_options *o);

#endif
