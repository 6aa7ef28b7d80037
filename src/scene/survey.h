/* SPDX-License-Identifier: MIT */
/* What the materials of scenes need of an environment. */
#ifndef SCENE_SURVEY_H
#define SCENE_SURVEY_H

#include "scene/scene.h"

enum {
    IBL_SURVEY_BINS = 65 /* bin i: roughness i / 64 */
};

/* What reflects with one roughness, each member a sum over the scene's area,
 * which is 1 in all. */
typedef struct ibl_survey_bin {
    double share;
    double power;   /* of the square of the reflectance along the normal, of
                       metals in 1, of others in .04 */
    double diffuse; /* of the luminance of the diffuse albedo */
} ibl_survey_bin;

/*
 * Shares of the area of triangles in the world, so that several scenes add up
 * by their areas. What alpha masks out does not count, what it blends counts in
 * part. Surfaces between metals and others (partly metallic ones, dielectrics
 * of more than F0 = .04) are divided between both.
 */
typedef struct ibl_scene_survey {
    double area; /* in the scenes' own units, squared; the next, to anisotropic,
                    are shares */
    ibl_survey_bin metal[IBL_SURVEY_BINS], dielectric[IBL_SURVEY_BINS];
    ibl_survey_bin clearcoat[IBL_SURVEY_BINS]; /* over the others, of F0 .04 */
    ibl_survey_bin sheen[IBL_SURVEY_BINS];     /* over the others */
    double unlit;                              /* share, in no bin */
    double transmission, anisotropic;
    int scenes, materials, triangles, images; /* numbers; materials and
                                                 triangles: those that are
                                                 drawn, images: those that were
                                                 looked at */
} ibl_scene_survey;

/* The sum of IBL_SURVEY_BINS shares. */
double ibl_survey_share(const ibl_survey_bin bins[]);

/*
 * Adds a scene, whose images that matter are decoded, and reduced: 2^16
 * places, evenly over the area, with the values of the textures there. The
 * same result for any number of threads.
 *   survey  zeroed before the first scene
 * Errors of ibl_scene_decode_all. IBL_ERR_FORMAT: the scene has no area.
 */
ibl_status ibl_scene_survey_add(ibl_ctx *ctx, ibl_scene *scene,
                                ibl_scene_survey *survey);

#endif
