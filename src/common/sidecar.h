/* SPDX-License-Identifier: MIT */
/* Reads NAME.json of a bake. */
#ifndef COMMON_SIDECAR_H
#define COMMON_SIDECAR_H

#include <ibl/io.h>

#include "json/json_load.h"

/* ibl_json_load of a sidecar; decodes its file names, to any bytes. Of
 * harmonics it has those up to degree 10, and one more. */
json_t *ibl_sidecar_load(const char *path, ibl_json_why *why);

/* The entry of the output whose member has that value; NULL: none. */
json_t *ibl_sidecar_output(const json_t *sidecar, const char *member,
                           const char *value);

/* Reads the lights that were taken out of the map, and returns their number;
 * -1: they are damaged. */
int ibl_sidecar_lights(const json_t *sidecar, ibl_light light[IBL_MAX_LIGHTS]);

/* What a sidecar says was done to the colours of its source. Leaves alone what
 * it does not say, or not in such words. */
void ibl_sidecar_colour(const json_t *sidecar, ibl_read_options *read);

#endif
