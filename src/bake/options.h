/* SPDX-License-Identifier: MIT */
/* Whether options are in range: IBL_ERR_ARGUMENT, in words, if not. */
#ifndef IBL_BAKE_OPTIONS_H
#define IBL_BAKE_OPTIONS_H

#include "ibl/ibl.h"

/* All of a bake; the size of env, and the yaw of opts alone, count. */
ibl_status ibl_check_bake(ibl_ctx *ctx, const ibl_environment *env,
                          const ibl_bake_options *opts);
/* The mapping and the range of roughness; without a context in silence. */
ibl_status ibl_check_roughness(ibl_ctx *ctx, const ibl_specular_options *opts);

#endif
