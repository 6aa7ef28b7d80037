/* SPDX-License-Identifier: MIT */
#ifndef CLI_JUDGED_MAP_H
#define CLI_JUDGED_MAP_H

#include "cli/judge.h"

/* An environment in memory, and judges of what was baked from it: the skybox
 * from all of it, the rest perhaps from what was left when lights had been
 * taken out. */
typedef struct ibl_judged_map {
    double yaw_deg;
    ibl_image env, rest; /* rest: empty if no lights are to be taken out */
    ibl_light lights[IBL_MAX_LIGHTS]; /* their directions are turned */
    int light_count;
    ibl_judge *by_env, *by_rest; /* by_rest: NULL with rest empty */
} ibl_judged_map;

/* Reads the environment; most is the number of lights to take out, 0 for none.
 * False: after a message through ctx. ibl_judged_map_free is needed also
 * then. */
bool ibl_judged_map_read(ibl_ctx *ctx, const char *path,
                         const ibl_read_options *read, double yaw_deg, int most,
                         ibl_judged_map *map);
/* Makes the judges. False: no memory, or after a message through ctx. */
bool ibl_judged_map_prepare(ibl_ctx *ctx, const ibl_judge_options *opts,
                            ibl_judged_map *map);
void ibl_judged_map_free(ibl_judged_map *map); /* zeroed is allowed */

/* What the specular and irradiance cubes are made from. */
const ibl_image *ibl_judged_map_rest(const ibl_judged_map *map);
/* The judge of an output. */
ibl_judge *ibl_judged_map_judge(const ibl_judged_map *map,
                                ibl_output_kind kind);

#endif
