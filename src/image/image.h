/* SPDX-License-Identifier: MIT */
#ifndef IBL_IMAGE_IMAGE_H
#define IBL_IMAGE_IMAGE_H

#include "ibl/ibl.h"

/* Checks that there is a context and a valid image, with data and a size in
 * range. Else IBL_ERR_ARGUMENT. */
ibl_status ibl_check_image(ibl_ctx *ctx, const ibl_image *img);

#endif
