/* SPDX-License-Identifier: MIT */
/* Chooses the texels to judge, and their weights. */
#ifndef CLI_JUDGE_PICKS_H
#define CLI_JUDGE_PICKS_H

#include <stdbool.h>
#include <stddef.h>

#include <ibl/ibl.h>
#include <ibl/reference.h>

enum {
    IBL_JUDGE_LIGHTS = 8,
    IBL_DARK_CELLS = 8 /* cells along a face's edge */
};

typedef struct ibl_judge_options {
    int texels; /* about, of each level; IBL_JUDGE_MIN_TEXELS or more */
    int all;    /* choose every texel instead */
    int seed;
    int grid; /* least cells along a face's edge, for heat maps, or 0 */
} ibl_judge_options;

typedef struct ibl_judged_texel {
    ibl_texel at;
    double weight; /* number of texels that it represents */
    double error;  /* relative error */
    double value;  /* R + G + B of the reference */
} ibl_judged_texel;

/* The level whose texels are chosen. */
typedef struct ibl_pick_scene {
    ibl_level_shape shape;
    int light_count; /* entries of lights, brightest first */
    double lights[IBL_JUDGE_LIGHTS][3];
    /* The dark cells; each image has IBL_DARK_CELLS x IBL_DARK_CELLS cells. */
    bool dark[IBL_FACES * IBL_DARK_CELLS * IBL_DARK_CELLS];
} ibl_pick_scene;

/* Chooses texels. *list is in order of face, row and column, with error 0; the
 * caller must free it. False: no memory. */
bool ibl_picks(const ibl_pick_scene *scene, const ibl_judge_options *opts,
               ibl_judged_texel **list, size_t *count);

/* Finds the directions of the brightest pixels in a map turned by yaw_deg, at
 * least 10 degrees apart, brightest first. Returns their number, 1..most. */
int ibl_find_lights(const ibl_image *env, double yaw_deg, int most,
                    double dirs[][3]);

#endif
