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

/* A cube of one level, RGBA32F: a function of each texel's unit direction. */
typedef void room_texel(void *cookie, const double direction[3], float rgba[4]);
GLuint room_cube(int size, room_texel *texel, void *cookie);
/* The same everywhere. */
GLuint room_cube_of(float r, float g, float b, float a);

/* A level of cubes with faces of n x n texels: RGBA, from test_alloc. */
float *room_cubes_read(GLuint cubes, int count, int level, int n);
/* The only one of these, without alpha. */
void room_cube_read(GLuint cubes, const ibl_cube *cube);

/* ---- the room in white light ----------------------------------------------
 */

/* By the table of a surface that loses nothing, each material has one colour,
 * times the light of the probes. The sky says what direction it is in. */
typedef struct lit_room {
    view_room *room;
    view_image image;
    view_room_draw draw; /* without probes, by a camera to set */
    GLuint black;        /* a cube */
    bool directions; /* colours of the one probe are those of the sky, else */
    float colour[IBL_MAX_PROBES + 1][4]; /* times alpha; the dynamic one's
                                            follows those of the locals */
} lit_room;

extern lit_room lit;

/* Opens a screen of that size, too, for the running test. */
void lit_begin(int width, int height);
/* Turns the environment by degrees. */
void lit_turn(double turn);
/* Lights the draw by count probes, of which the last may be the dynamic one;
 * they are kept until the next call. */
void lit_probes(const ibl_probe *probes, int count, bool dynamic);
/* A picture of lit.draw, RGBA, rows from the top, from test_alloc. */
float *lit_render(void);
/* Whether a pixel at (x, y), or of a captured face of that size, has the colour
 * of what is up to so many pixels around it. Between two things it may be a mix
 * of them. size 0: of the picture. */
bool lit_shows(const float *rgb, int size, int face, double x, double y,
               double around, double tolerance);

/* ---- captures -------------------------------------------------------------
 */

/* Captures the lit room from eye into one cube, for the running test. */
typedef struct room_capture {
    view_capture *capture;
    view_probe_maps cubes;
} room_capture;

room_capture *room_capture_begin(view_probe_capture kind, int size,
                                 const double eye[3]);
/* A whole update. */
void room_capture_update(room_capture *c);
/* The same of a sky alone. */
void room_capture_sky(room_capture *c, GLuint sky);

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
    bool anew; /* what the last draw was told */
} room_stage;

/* Opens a screen of that size, too, for the running test. */
void room_stage_begin(room_stage *on, int width, int height,
                      const float light[3], const float table[2]);
/* A picture as lit_render has it; NULL after a failure. */
float *room_stage_draw(room_stage *on);

#endif
