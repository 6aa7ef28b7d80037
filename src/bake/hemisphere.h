/* SPDX-License-Identifier: MIT */
#ifndef IBL_BAKE_HEMISPHERE_H
#define IBL_BAKE_HEMISPHERE_H

#include "ibl/ibl.h"

/*
 * ibl_bake_irradiance with opts->step > 0: the classic grid over the
 * hemisphere. opts has been checked; out is allocated, opts->size and one
 * level, and stays the caller's whatever happens.
 */
ibl_status ibl_irradiance_grid(ibl_ctx *ctx, const ibl_image *env,
                               const ibl_irradiance_options *opts,
                               ibl_cube *out);

#endif
