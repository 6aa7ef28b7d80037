/* SPDX-License-Identifier: MIT */
#ifndef IBL_IMAGE_IMAGE_H
#define IBL_IMAGE_IMAGE_H

#include "ibl/ibl.h"

/* Whether there is a context and an image that a caller filled in, with data
 * and a size in range: IBL_ERR_ARGUMENT. */
ibl_status ibl_check_image(ibl_ctx *ctx, const ibl_image *img);

#endif
