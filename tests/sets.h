/* SPDX-License-Identifier: MIT */
/* Sets that iblbake bakes for tests of the viewer. */
#ifndef TESTS_SETS_H
#define TESTS_SETS_H

#include <stdbool.h>

#include "view/baked_set.h"

/* A smooth sky, none of it zero, with a pixel of so much as the sun. */
ibl_image sets_map(ibl_ctx *ctx, int width, double sun);
/* A set of a white map, 3 levels of 16, freed after the test: set must last. */
void sets_white(baked_set *set);
/* Bakes a map in memory as view_set_bake does; opts NULL: defaults. */
bool sets_bake_image(ibl_ctx *ctx, const char *name, const ibl_image *map,
                     const ibl_specular_options *opts, baked_set *set);
/* A map of 64 pixels: its file, and as the library reads it. */
const char *sets_file(void);
ibl_image sets_read_map(ibl_ctx *ctx);

/* Runs the program on that file into a directory of that name. */
bool sets_bake(const char *directory, const char *options);
/* A set of the test's directory, which must open, until the running test has
 * ended. What was said of it: static storage, overwritten by the next. */
const char *sets_open(ibl_ctx *ctx, const char *name, baked_set *set);
/* Checks that texels and facts are the same. */
void sets_check_same(const baked_set *a, const baked_set *b, const char *what);

/* Checks that opening fails, with one line of the words and file, and notes. */
void sets_check_refused(ibl_ctx *ctx, const view_request *what,
                        const char *file, const char *words);
void sets_refused(ibl_ctx *ctx, const char *path, const char *words);

/* Line ends in text. */
int sets_lines(const char *text);

#endif
