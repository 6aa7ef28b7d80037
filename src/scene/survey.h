/* SPDX-License-Identifier: MIT */
/* What the materials of scenes need of an environment. */
#ifndef SCENE_SURVEY_H
#define SCENE_SURVEY_H

#include "scene/scene.h"

enum {
    IBL_SURVEY_BINS = 65 /* bin i: roughness i / 64 */
};

/* What reflects with one roughness. All members are sums: share <= 1, the
 * others are share times the mean of the luminance of a colour. */
typedef struct ibl_survey_bin {
    double share;   /* of the scene's area */
    double f0;      /* reflectance along the normal */
    double diffuse; /* diffuse albedo */
} ibl_survey_bin;

/*
 * Shares of the area of triangles in the world, so that several scenes add up
 * by their areas. What alpha masks out does not count, what it blends counts in
 * part. Partly metallic surfaces are divided between both kinds.
 */
typedef struct ibl_scene_survey {
    double area; /* in the scenes' own units */
    ibl_survey_bin metal[IBL_SURVEY_BINS], dielectric[IBL_SURVEY_BINS];
    ibl_survey_bin clearcoat[IBL_SURVEY_BINS]; /* over the others */
    ibl_survey_bin sheen[IBL_SURVEY_BINS];     /* f0: the sheen's colour */
    double unlit, transmission, anisotropic;   /* shares; unlit is in no bin */
    int scenes, materials, triangles, images;  /* counts; materials: those that
                                                  are drawn */
} ibl_scene_survey;

/*
 * Adds a scene, whose images that matter are decoded (and may stay reduced):
 * 2^18 places, evenly over the area, with the values of the textures there. The
 * same result for any number of threads.
 *   survey  zeroed before the first scene
 * Errors of ibl_scene_decode. IBL_ERR_FORMAT: the scene has no area.
 */
ibl_status ibl_scene_survey_add(ibl_ctx *ctx, ibl_scene *scene,
                                ibl_scene_survey *survey);

#endif
