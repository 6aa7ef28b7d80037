/* SPDX-License-Identifier: MIT */
/* What tests of shading share: sets made in memory, pictures of them, and the
 * split sum with its lookups written out in double. */
#ifndef SHADE_H
#define SHADE_H

#include "cli/lookup.h"
#include "view/baked_set.h"
#include "view/renderer.h"
#include "view/sphere_grid.h"

#include "maps.h"
#include "test.h"

/* A screen and a renderer, which it returns, for the running test. */
view_renderer *shade_begin(int width, int height);
ibl_ctx *shade_ctx(void);

/* A set with the maps that its textures were made of. Unless a test says
 * otherwise RGBA32F and RG32F, so that both are the same numbers. */
typedef struct shade_set {
    baked_set set;
    ibl_cube specular, irradiance;
    ibl_lut lut;
} shade_set;

enum {
    SHADE_TABLE = 128, /* edge of the tables that are made here */
    SHADE_SETS = 2
};
/* Those of a test, freed after it. */
extern shade_set shade_sets[SHADE_SETS];

void shade_constant(shade_set *s, const float rgb[3]);
/* Specular chain of size and levels (opts), irradiance, harmonics, table. */
void shade_bake(shade_set *s, const ibl_image *map,
                const ibl_specular_options *opts);
/* The same of a random map, 32 texels along an edge. */
void shade_kind(shade_set *s, ibl_roughness_map mapping, map_kind kind);
/* Textures anew, from maps that a test has changed. */
void shade_pack(shade_set *s, ibl_pixel cubes, ibl_pixel lut);

/* view_renderer_draw and _read: linear RGB, rows from the top, from test_alloc.
 * The last loads a set and draws all places of a pixel. Exit if they cannot. */
bool shade_frame(const view_settings side[2]);
float *shade_read(int side);
float *shade_draw(const baked_set *set, const view_settings *s);
/* A sphere of radius 1 around the origin, of glTF's default material, whose
 * height is scaled. */
view_model *shade_ball(double height);
/* Index in view_materials; exits if there is none of that name. */
int shade_material(const char *name);

/* What a pixel shows: a sphere, all nine of it and its neighbours, or the sky
 * (-1), or what both have a part in (-2). */
typedef struct shade_pixel {
    int sphere;
    double normal[3], view[3], n_v;
} shade_pixel;
/* For each pixel of the picture; from test_alloc. */
shade_pixel *shade_pixels(const view_settings *s);

/* Lookups; directions are of the environment's own frame. How a lobe is looked
 * up, as ibl_lobe of ibl/ibl.glsl, and what it sees. */
typedef struct shade_lobe {
    double bend, lod, diffuse, half_distance;
    int taps;
} shade_lobe;
void shade_see(const ibl_cube *specular, const shade_lobe *q, const double n[3],
               const double v[3], const double light[3], double seen[3]);
/* The level of a roughness. */
double shade_level(const baked_set *set, double roughness);
void shade_irradiance(const shade_set *s, view_diffuse by, const double n[3],
                      double rgb[3]);

/* The split sum's input light, and its result without point lights. */
typedef struct shade_light {
    double specular[3], irradiance[3]; /* E/pi */
    double table[2], n_v;
} shade_light;
void shade_look_up(const shade_set *s, const view_settings *settings,
                   const view_sphere *sphere, const shade_pixel *p,
                   shade_light *light);
void shade_split_sum(const view_settings *settings, const view_sphere *sphere,
                     const shade_light *light, double rgb[3]);

#endif
