/* SPDX-License-Identifier: MIT */
#ifndef VIEW_BRIDGE_PATH_H
#define VIEW_BRIDGE_PATH_H

/* The image bridge of this build or installation, for ibl_ctx_options; free()
 * it. NULL: the one that was compiled in. */
char *view_bridge_path(void);

#endif
