/* SPDX-License-Identifier: MIT */
/* Words of keys and sidecars. */
#ifndef IBL_IO_TEXTURE_KEYS_H
#define IBL_IO_TEXTURE_KEYS_H

#include "ibl/io.h"

/* The lod bias of levels for which none was given. */
#define IBL_LOD_BIAS_USUAL "log2(samples / 64) / 6, within 0 to 1"

/* What layer i of a table is for; NULL after the last. f0 must be in range. */
const char *ibl_lobe_layer_name(ibl_f0 f0, int i);

#endif
