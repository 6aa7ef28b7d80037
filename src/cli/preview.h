/* SPDX-License-Identifier: MIT */
#ifndef CLI_PREVIEW_H
#define CLI_PREVIEW_H

#include "cli/bake_record.h"

/*
 * A contact sheet as a PNG file: the environment, each specular level, the
 * skybox and the irradiance as unfolded cubes (+Y on top, -X +Z +X -Z in the
 * middle row, -Y below), the LUT with N.V to the right and roughness upwards.
 * All radiance has the same exposure. *png is the caller's to free. False: no
 * memory.
 */
bool ibl_preview_png(const ibl_bake *b, void **png, size_t *size);

#endif
