/* SPDX-License-Identifier: MIT */
/*
 * What a shader draws with baked light, against what the surface reflects.
 *
 * A truth is made once for a map: samples, each a normal and a view with a
 * material, its weight and its exact colour. It then measures any number of
 * sets in memory along the same samples.
 *
 * What is estimated is over normals that are uniform over the sphere, N.V with
 * the density 2 N.V (that of the pixels of a sphere) and any azimuth of the
 * view. A third of the samples are drawn so that reflections and N.V are even;
 * the others so that the half vector of the view and a light of the map lies
 * near the normal, at distances of every order, and more of them at grazing
 * angles. Weights undo that.
 */
#ifndef CLI_RENDERED_H
#define CLI_RENDERED_H

#include <ibl/reference.h>
#include <ibl/set.h>

#include "cli/figures.h"
#include "cli/lookup.h"

/* What a shader draws with, in the world's axes. Nothing in it is owned. */
typedef struct ibl_drawn {
    ibl_shader shader;   /* not AUTO */
    ibl_set_facts chain; /* levels of GGX, their roughness and lod; levels 0:
                            there are none, irradiance takes their place */
    ibl_cube specular;   /* these levels */
    ibl_cube irradiance; /* / pi, in level 0; data NULL: none */
    const double *sh;    /* in place of the cube, radiance as in ibl_bake_sh, to
                            sh_degree; NULL: none */
    int sh_degree;
    ibl_lut lut;             /* of IBL_LUT_SPLIT; data NULL: as exact */
    ibl_lobe_table lobes;    /* of IBL_SHADER_TABLE and on */
    const ibl_light *lights; /* that the bake took out of the map */
    int light_count;
} ibl_drawn;

/* Sets the levels. */
void ibl_drawn_chain(ibl_drawn *set, const ibl_cube *chain,
                     const ibl_specular_layout *layout);

#define IBL_MATERIAL_STEPS 64

/* The materials of what is drawn; [i]: those of roughness i / 64; [0]: of F0 =
 * 1, times the square of their tint, [1]: of F0 = .04. */
typedef struct ibl_materials {
    double weight[IBL_MATERIAL_STEPS + 1][2];  /* share of the surfaces in view,
                                                  0 or more; any sum above 0 */
    double diffuse[IBL_MATERIAL_STEPS + 1][2]; /* their mean diffuse albedo */
} ibl_materials;

enum {
    IBL_RENDERED_LIST = 32,  /* roughnesses, values of F0 */
    IBL_RENDERED_LEAST = 24, /* directions */
    IBL_RENDERED_DIRECTIONS = 512,
    IBL_RENDERED_MOST = 2048 /* if standard errors ask for more */
};

/* Of a grid there is a row of samples for each F0 and roughness, all along the
 * same directions. Of materials there is one row, whose samples have materials
 * drawn from the weights; they have diffuse light, too. */
typedef struct ibl_truth_options {
    int directions, seed;
    ibl_geometry geometry;
    const ibl_materials *materials; /* NULL: a grid of: */
    int roughness_count, f0_count;
    double roughness[IBL_RENDERED_LIST], f0[IBL_RENDERED_LIST];
} ibl_truth_options;

/* 512 directions, a grid of roughness .1 .2 .3 .4 .5 .7 .85 1, F0 1 and .04. */
ibl_truth_options ibl_truth_options_default(void);

typedef struct ibl_sample {
    double normal[3], view[3], mirror[3]; /* mirror: R */
    double n_dot_v, weight;
    double roughness, f0, albedo; /* albedo: of diffuse light */
    double table[2];              /* exact scale and bias of F0 */
    double truth[3];              /* T: reflected and diffuse */
} ibl_sample;

typedef struct ibl_truth {
    ibl_truth_options options; /* materials: NULL */
    int rows;                  /* by F0, then by roughness; 1 of materials */
    ibl_sample *sample;        /* [rows][directions] */
    double mean[3];            /* of the map */
} ibl_truth;

/* env is turned by yaw_deg as in a bake. out is zeroed or a truth, which it
 * replaces. False: after a message through ctx; ibl_truth_free is needed also
 * then. */
bool ibl_truth_make(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                    const ibl_truth_options *options, ibl_truth *out);
void ibl_truth_free(ibl_truth *t); /* zeroed is allowed */

/* Measures a set: rows of the truth, written. */
void ibl_measure(const ibl_truth *truth, const ibl_drawn *set,
                 ibl_measured *rows);

#endif
