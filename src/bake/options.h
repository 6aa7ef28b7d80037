/* SPDX-License-Identifier: MIT */
/* Range checks of options, which fail with IBL_ERR_ARGUMENT and a message; the
 * mapping of roughness. */
#ifndef IBL_BAKE_OPTIONS_H
#define IBL_BAKE_OPTIONS_H

#include "ibl/ibl.h"

/* All options of a bake and env's size; of the yaws, only opts->yaw_deg. */
ibl_status ibl_check_bake(ibl_ctx *ctx, const ibl_environment *env,
                          const ibl_bake_options *opts);
/* Checks the mapping and the range of roughness. ctx NULL: no message. */
ibl_status ibl_check_roughness(ibl_ctx *ctx, const ibl_specular_options *opts);
/* Of the lookups of sampled levels. */
double ibl_lod_bias_of(const ibl_specular_options *opts);
#endif
