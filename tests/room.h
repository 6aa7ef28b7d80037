/* SPDX-License-Identifier: MIT */
/* What programs that draw the room share: its pictures, and what they show in
 * double. */
#ifndef TEST_ROOM_H
#define TEST_ROOM_H

#include "view/room.h"
#include "view/sphere_grid.h"

/* ---- in double ------------------------------------------------------------
 */

/* Looks from eye to a point; fov in degrees is vertical. */
view_camera room_camera(const double eye[3], const double at[3], double fov,
                        int width, int height);

/* What a ray meets, cast into the boxes and spheres that are drawn. */
typedef struct room_hit {
    int what; /* box; boxes + sphere; -1: the sky */
    double distance, point[3], normal[3];
    double f0[3], albedo[3], emission[3], roughness;
} room_hit;

/* direction: unit */
room_hit room_cast(const view_room_draw *draw, const double eye[3],
                   const double direction[3]);

/* The shares of a point: of locals, of the dynamic probe, of the environment;
 * without alpha as if it was 1. */
void room_weights(const view_room_draw *d, const double point[3],
                  const double *alpha, double *weights);

/* ---- maps -----------------------------------------------------------------
 */

/* One to be filled, of one level, bound to unit 0. */
GLuint room_texture(GLenum target);
/* A cube of one level, RGBA32F: a function of each texel's unit direction. */
typedef void room_texel(void *cookie, const double direction[3], float rgba[4]);
GLuint room_cube(int size, room_texel *texel, void *cookie);
/* Its faces, one after the other; from test_alloc. */
float *room_faces(int size, room_texel *texel, void *cookie);
/* The same everywhere. */
GLuint room_cube_of(float r, float g, float b, float a);

/* A level of cubes with faces of n x n texels: RGBA, from test_alloc. */
float *room_cubes_read(GLuint cubes, int count, int level, int n);
/* RG32F, the same everywhere. */
GLuint room_table_of(float r, float g);

/* ---- pictures -------------------------------------------------------------
 */

/* Kept for the running test. */
void room_image_make(view_image *image, int width, int height);
/* RGBA, rows from the top, from test_alloc. */
float *room_image_read(const view_image *image);

/* ---- --mode scene ---------------------------------------------------------
 */

/* What it shows in uniform light of the environment. */
typedef struct room_stage {
    view_scene *stage;
    view_settings s; /* the defaults, in that mode */
    view_room_environment environment;
    GLuint table;
    view_model *guest;
    view_image image;
} room_stage;

/* Opens a screen of that size, too, for the running test. */
void room_stage_begin(room_stage *on, int width, int height,
                      const float light[3], const float table[2]);
/* A picture as room_image_read has it; NULL after a failure. */
float *room_stage_draw(room_stage *on);

#endif
