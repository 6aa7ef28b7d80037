/* SPDX-License-Identifier: MIT */
/* Lights of a map as JSON. NULL: no memory. */
#ifndef CLI_LIGHTS_JSON_H
#define CLI_LIGHTS_JSON_H

#include <jansson.h>

#include <ibl/ibl.h>

/* [{"direction", "radius_rad", "radius_deg", "irradiance", "radiance"}, ..] */
json_t *ibl_lights_json(const ibl_light *lights, int count);

/*
 * A whole glTF 2.0 file of directional lights (KHR_lights_punctual), each of a
 * node that turns the light's -Z away from it. Color times intensity is the
 * irradiance. Scenes hold a node at least, so count is at least 1.
 */
json_t *ibl_lights_gltf(const ibl_light *lights, int count);

#endif
