/* SPDX-License-Identifier: MIT */
/* The key/values that a texture of the bake carries: see FILES in the manual
 * page. */
#ifndef CLI_KEYS_H
#define CLI_KEYS_H

#include "cli/bake.h"

ibl_status ibl_keys_set(const ibl_bake *b, ibl_output_kind kind,
                        ibl_texture *tex);

#endif
