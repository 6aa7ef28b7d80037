/* SPDX-License-Identifier: MIT */
/* Range checks of options, which fail with IBL_ERR_ARGUMENT and a message; the
 * mapping of roughness. */
#ifndef IBL_BAKE_OPTIONS_H
#define IBL_BAKE_OPTIONS_H

#include "ibl/ibl.h"

/* Options of a bake with every member that this library knows; bake.more is
 * `more`. */
typedef struct ibl_taken_options {
    ibl_bake_options bake;
    ibl_specular_options more[IBL_MAX_MORE_CHAINS];
} ibl_taken_options;

/* Those of a program; NULL: the defaults. Checks more_count. */
ibl_status ibl_bake_take_options(ibl_ctx *ctx, const ibl_bake_options *opts,
                                 ibl_taken_options *own);
/* All options of a bake and env's size; of the yaws, only opts->yaw_deg. */
ibl_status ibl_check_bake(ibl_ctx *ctx, const ibl_environment *env,
                          const ibl_bake_options *opts);
/* Checks the mapping and the range of roughness. ctx NULL: no message. */
ibl_status ibl_check_roughness(ibl_ctx *ctx, const ibl_specular_options *opts);
/* Of the lookups of a level with so many samples. */
double ibl_lod_bias_of(const ibl_specular_options *opts, int samples);
/* The chain, the size and the spectrum of a lobe table. */
ibl_status ibl_lobe_table_check(ibl_ctx *ctx, const ibl_lobe_table_options *o);
/* A program's options, NULL for the defaults, and that check. */
ibl_status ibl_lobe_table_take(ibl_ctx *ctx, const ibl_lobe_table_options *opts,
                               ibl_lobe_table_options *own);

#endif
