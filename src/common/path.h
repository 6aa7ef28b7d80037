/* SPDX-License-Identifier: MIT */
#ifndef COMMON_PATH_H
#define COMMON_PATH_H

#include <stdbool.h>

/* The part after the last slash. */
const char *ibl_path_name(const char *path);
/* Whether both exist and are the same file. */
bool ibl_path_same(const char *a, const char *b);
/* Whether files may be made in the directory of path; errno if not. */
bool ibl_path_is_open(const char *path);

/* Both are for free(); NULL: no memory. */

/* directory/name; directory is not empty and may end in a slash. */
char *ibl_path_join(const char *directory, const char *name);
/* name as it is seen from the directory that file is in. */
char *ibl_path_beside(const char *file, const char *name);

/* The image bridge beside the program, where a build leaves it, or in
 * ../lib/iblbake, where an installation has it; for free(). NULL: there is
 * none, take the one that the library was built with. */
char *ibl_bridge_beside(void);

#endif
