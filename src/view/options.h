/* SPDX-License-Identifier: MIT */
/* The command line. */
#ifndef VIEW_OPTIONS_H
#define VIEW_OPTIONS_H

#include "view/controls.h"

/* Parses the words of the command line, ended by NULL; strings point into them.
 * False: the program must exit with *status, after --help or a message. */
bool view_options_parse(char **words, view_options *o, int *status);

/* False, with a message, if nothing is at PATH or an option does not fit it;
 * reads only the first bytes. */
bool view_options_may(const view_options *o);
/* False, with a message, if the options ask for what a set does not have. */
bool view_options_suit(const view_options *o, const baked_set *set);

#endif
