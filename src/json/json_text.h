/* SPDX-License-Identifier: MIT */
#ifndef IBL_JSON_JSON_TEXT_H
#define IBL_JSON_JSON_TEXT_H

#include <jansson.h>
#include <stdbool.h>

#include <ibl/ibl.h>
#include <ibl/io.h>

#include "json/json_load.h"

/* Whether bytes are UTF-8. */
bool ibl_json_is_text(const char *bytes);
/* A string from any bytes: if they are not UTF-8, all beyond ASCII become
 * U+FFFD. */
json_t *ibl_json_string(const char *bytes);

/* iblbake, its version and the revision of a program, NULL or "" if it has
 * none, as a file's generator. NULL: no memory. */
json_t *ibl_json_generator(ibl_isa isa, const char *revision);
/* Coefficients as [R, G, B], with cosine times ibl_sh_cosine(l), or NULL. */
json_t *ibl_json_harmonics(const double *sh, int degree, bool cosine);
/* {"texels": .., "moved": .., "lost": ..}; NULL: no memory. */
json_t *ibl_json_overflow(const ibl_overflow_level *level);

/* {"nrmse": .., "relative": ..}; NULL: no memory. */
json_t *ibl_json_pixel_error(const ibl_pixel_error *error);

/* Lights of a map: [{"direction", "radius_rad", "radius_deg", "irradiance",
 * "radiance"}, ..] */
json_t *ibl_lights_json(const ibl_light *lights, int count);

/*
 * A whole glTF 2.0 file of directional lights (KHR_lights_punctual), each of a
 * node that turns the light's -Z away from it. Color times intensity is the
 * irradiance. Scenes hold a node at least, so count is at least 1.
 */
json_t *ibl_lights_gltf(const ibl_light *lights, int count);

/* Rounds to four digits; results at chosen points are not more precise. */
double ibl_json_digits(double x);

/* A string in an object; "": there is none. */
static inline const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

#endif
