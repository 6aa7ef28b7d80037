/* SPDX-License-Identifier: MIT */
/* iblbake whose choice takes the samples of the seed in SEED. */
#include <stdlib.h>

#include "cli/rendered.h"

bool __real_ibl_truth_make(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                           const ibl_truth_options *options, ibl_truth *out);
bool __wrap_ibl_truth_make(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                           const ibl_truth_options *options, ibl_truth *out);

bool __wrap_ibl_truth_make(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                           const ibl_truth_options *options, ibl_truth *out)
{
    const char *seed = getenv("SEED");
    ibl_truth_options o = *options;

    o.seed = seed ? atoi(seed) : o.seed;
    return __real_ibl_truth_make(ctx, env, yaw_deg, &o, out);
}
