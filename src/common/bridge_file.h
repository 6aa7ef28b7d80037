/* SPDX-License-Identifier: MIT */
#ifndef COMMON_BRIDGE_FILE_H
#define COMMON_BRIDGE_FILE_H

/* The image bridge beside the program, where a build leaves it, or in
 * ../lib/iblbake, where an installation has it; the caller's
 * to free. NULL: there is none, take the one that the library was built
 * with. */
char *ibl_bridge_beside(void);

#endif
