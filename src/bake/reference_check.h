/* SPDX-License-Identifier: MIT */
#ifndef IBL_BAKE_REFERENCE_CHECK_H
#define IBL_BAKE_REFERENCE_CHECK_H

#include "ibl/reference.h"

/* IBL_ERR_ARGUMENT: there is no such geometry. */
ibl_status ibl_reference_check_geometry(ibl_ctx *ctx, ibl_geometry geometry);

#endif
