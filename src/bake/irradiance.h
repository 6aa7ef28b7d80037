/* SPDX-License-Identifier: MIT */
#ifndef IBL_BAKE_IRRADIANCE_H
#define IBL_BAKE_IRRADIANCE_H

#include "ibl/ibl.h"

/* Whether the options are in range, in words if not. */
ibl_status ibl_irradiance_check(ibl_ctx *ctx,
                                const ibl_irradiance_options *opts);

#endif
