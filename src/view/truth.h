/* SPDX-License-Identifier: MIT */
/* The integral that the split sum approximates: for each pixel the whole BRDF
 * (GGX with the geometry of the table, Schlick's Fresnel, and the diffuse part)
 * against the map, or level 0 where that is not at hand, by importance
 * sampling, accumulated over frames. N samples are the first N of one sequence,
 * however divided into frames. */
#ifndef VIEW_TRUTH_H
#define VIEW_TRUTH_H

#include <stdbool.h>

#include "view/baked_set.h"
#include "view/frame.h"
#include "view/gl.h"
#include "view/model.h"

#define VIEW_TRUTH_SAMPLES 4096 /* most samples of a pixel */

typedef struct view_truth {
    const char *environment; /* what it integrates, as "level 0" */
    view_image mean; /* of all samples, composed with the sky as the split sum
                        is */
    int samples;     /* of each pixel so far; 0: it begins anew */
    /* Of truth.c: */
    GLuint tokens, chance;   /* view_aim, as textures */
    const view_model *model; /* of the samples so far, or NULL */
    view_frame shown;        /* the same */
    int sampling[4];         /* of the frame */
    view_image pass, second; /* the last; the mean of every second pass */
    int seconds;             /* samples in that */
    bool even;               /* the last pass is one of these */
    int by_clock;            /* samples of the next frame */
} view_truth;

/* Makes the table of lights (view_aim) of a set, whose textures must be bound
 * when it draws. NULL, with a message. */
view_truth *view_truth_create(const baked_set *set);
void view_truth_free(view_truth *t); /* NULL is fine */
/*
 * Adds samples to the picture of what is seen; begins anew if frame differs in
 * more than its display, or the subject in size or model.
 *   frame      that of the pixels' centres; seen has that of a place in them,
 *              which may change
 *   samples    for each pixel; 0: as many as keep a frame quick, by the clock
 * Changes program, vertex array and framebuffer; blending is off, the viewport
 * is the picture's. False, with a message.
 */
bool view_truth_draw(view_truth *t, const view_frame *frame,
                     const view_subject *seen, int samples);
/* The mean of every second pass, M of all N samples. Of independent ones its
 * squared difference from the mean of all, times *factor = M / (N - M), is an
 * estimate of the variance of that. Sequences are more even: the noise is less.
 * 0: there was one pass. */
GLuint view_truth_second(const view_truth *t, double *factor);

/* ---- its table of lights ----------------------------------------------- */

/*
 * Samples of a rough lobe rarely hit a small sun, and then count too much. So
 * some directions are drawn from the map, and both kinds are combined by
 * multiple importance sampling (Veach and Guibas 1995). A direction is a random
 * place in a random cell, a pixel if they are few enough, by its light above
 * the mean (Karlik et al. 2019, "MIS Compensation").
 *
 * Chances are multiples of 1 / VIEW_AIM_TOKENS. A random token names a cell:
 * drawing is one lookup and the chance is exact. Neighbouring tokens belong to
 * neighbouring cells, so an even sequence of numbers gives even directions.
 */
#define VIEW_AIM_ROW 512 /* edge of the square texture of tokens */
#define VIEW_AIM_TOKENS (VIEW_AIM_ROW * VIEW_AIM_ROW)
#define VIEW_AIM_MOST 1024 /* most cells of a row or a column */

typedef struct view_aim {
    int width, height; /* 0: too little light is above the mean and there is no
                          table */
    float *chance;     /* of each cell, in rows as the map's pixels */
    float *tokens;     /* index of each token's cell */
} view_aim;

void view_aim_make(const ibl_image *map, view_aim *aim);
void view_aim_free(view_aim *aim); /* zeroed is fine */

/* ---- errors against it --------------------------------------------------- */

/* Sums over pixels and their R, G and B. */
typedef struct view_error {
    double difference2, truth2;
    double noise2; /* what the noise of a reference is expected to add to
                      difference2; 0: unknown */
    int pixels;
} view_error;

/* sqrt(sum |picture - truth|^2 / sum |truth|^2): -1 without pixels; 0 where
 * both are black, infinite where only truth is. */
double view_error_rmse(view_error e);
/* The part of it that is noise; 0: unknown. */
double view_error_noise(view_error e);

/*
 * Sums errors over what is shown. Only pixels count whose eight neighbours show
 * the same.
 *   shown     for each pixel 0..count-1, or -1
 *   pictures  linear RGB floats, width * height, rows from the top: picture and
 *             truth; the one of them that is a reference, and view_truth_second
 *             of it, NULL: none. noise2 is without its factor
 *   errors    count
 */
void view_errors(const int *shown, int count, int width, int height,
                 const float *const pictures[4], view_error *errors);

#endif
