/* SPDX-License-Identifier: MIT */
/* Volumes of probes in JSON: sets, grids and indices have them alike. */
#ifndef COMMON_JSON_VOLUME_H
#define COMMON_JSON_VOLUME_H

#include <ibl/probes.h>

#include "common/json_at.h"

/* Lengths and places are in any unit; up to this, volumes and their ratios are
 * well inside of a double. */
#define IBL_JSON_FARTHEST 1e12

/* Checks and takes {"box": {"centre", "half"}} or {"sphere": {"centre",
 * "radius"}}. False after ibl_json_wrong. */
bool ibl_json_volume(const ibl_json_at *at, ibl_volume *volume);

#endif
