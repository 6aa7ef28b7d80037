/* SPDX-License-Identifier: MIT */
/* Which texels are judged, and for how many each of them stands. */
#ifndef CLI_JUDGE_PICKS_H
#define CLI_JUDGE_PICKS_H

#include <stdbool.h>
#include <stddef.h>

#include <ibl/ibl.h>
#include <ibl/reference.h>

enum {
    IBL_JUDGE_LIGHTS = 8,
    IBL_DARK_CELLS = 8 /* along a face's edge */
};

typedef struct ibl_judge_options {
    int texels; /* of each level, about; at least IBL_JUDGE_MIN_TEXELS */
    int all;    /* every texel instead */
    int seed;
    int grid; /* cells along a face's edge, at least; for pictures. 0: as
                 texels has it */
} ibl_judge_options;

typedef struct ibl_judged_texel {
    ibl_texel at;
    double weight; /* texels that it stands for */
    double error;  /* relative */
    double value;  /* R + G + B of the truth */
} ibl_judged_texel;

/* The level that texels are chosen of. */
typedef struct ibl_pick_scene {
    int size;
    int light_count; /* of lights, from the brightest */
    double lights[IBL_JUDGE_LIGHTS][3];
    /* Cells of IBL_DARK_CELLS squared on each face that are dark. */
    bool dark[IBL_FACES * IBL_DARK_CELLS * IBL_DARK_CELLS];
} ibl_pick_scene;

/* Chooses; *list, by face, row and column, is the caller's to free. error is
 * 0 in it. False: no memory. */
bool ibl_picks(const ibl_pick_scene *scene, const ibl_judge_options *opts,
               ibl_judged_texel **list, size_t *count);

/* Directions of the brightest pixels, each at least 10 degrees from the
 * brighter ones, of a map turned by yaw_deg. Returns their number, 1..most. */
int ibl_find_lights(const ibl_image *env, double yaw_deg, int most,
                    double dirs[][3]);

/* Numbers that depend on nothing but what is passed: 0 <= x < 1. */
double ibl_pick_random(int seed, unsigned long long stream,
                       unsigned long long index);

#endif
