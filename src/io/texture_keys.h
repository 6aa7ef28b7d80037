/* SPDX-License-Identifier: MIT */
/* Words for lobe tables, in keys and sidecars. */
#ifndef IBL_IO_TEXTURE_KEYS_H
#define IBL_IO_TEXTURE_KEYS_H

#include "ibl/io.h"

/* What layer i of a table is for; NULL after the last. f0 must be in range. */
const char *ibl_lobe_layer_name(ibl_f0 f0, int i);

#endif
