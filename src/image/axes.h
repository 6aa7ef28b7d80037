/* SPDX-License-Identifier: MIT */
#ifndef IBL_IMAGE_AXES_H
#define IBL_IMAGE_AXES_H

#include "ibl/ibl.h"

/* Checks the range. Else IBL_ERR_ARGUMENT. */
ibl_status ibl_check_axes(ibl_ctx *ctx, ibl_axes axes);

#endif
