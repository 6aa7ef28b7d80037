/* SPDX-License-Identifier: MIT */
/* What programs that draw the room share. */
#ifndef TEST_ROOM_H
#define TEST_ROOM_H

#include "view/room.h"
#include "view/sphere_grid.h"

/* A picture for the running test. */
void room_image_make(view_image *image, int width, int height);
/* RGBA, rows from the top, from test_alloc. */
float *room_image_read(const view_image *image);

/* Looks from eye to a point; fov in degrees is vertical. */
view_camera room_camera(const double eye[3], const double at[3], double fov,
                        int width, int height);
/* A draw by that camera with everything shown, without maps. */
view_room_draw room_draw_by(const view_camera *camera);

/* What a ray meets, cast in double into the boxes and spheres that are drawn.
 */
typedef struct room_hit {
    int what; /* box; boxes + sphere; -1: the sky */
    double distance, point[3], normal[3];
    double sky[3]; /* direction of the environment */
    const view_room_material *material;
} room_hit;

/* direction: unit */
room_hit room_cast(const view_room_draw *draw, const double eye[3],
                   const double direction[3]);

/* The top of the floor, of any of its tiles. */
bool room_is_floor(const room_hit *h);

/* A cube of one level, RGBA32F: a function of each texel's unit direction. */
typedef void room_texel(void *cookie, const double direction[3], float rgba[4]);
GLuint room_cube(int size, room_texel *texel, void *cookie);
/* The same everywhere. */
GLuint room_cube_of(float r, float g, float b, float a);
/* An array of count cubes of one texel a face, RGBA32F, each of one colour. */
GLuint room_cubes_of(int count, const float (*rgba)[4]);
GLuint room_layer_of(float r, float g, float b, float a); /* of one */
/* The same as room_cube, as the one layer of an array. */
GLuint room_layer(int size, room_texel *texel, void *cookie);
/* A table that is the same everywhere. */
GLuint room_table_of(float r, float g);

/* The room in light that is white everywhere, by the table of a surface that
 * loses nothing: each material has one colour. The sky says what direction it
 * is in. */
typedef struct lit_room {
    view_room *room;
    view_image image;
    GLuint white, black, sky, table;
    GLuint white_layer, black_layer;
} lit_room;

extern lit_room lit;

/* Opens a screen of that size, too, for the running test. */
void lit_begin(int width, int height);
view_room_draw lit_draw(const view_camera *camera);
/* As room_image_read has it. */
float *lit_render(const view_room_draw *draw);
/* Whether a pixel has the colour of what a ray meets. The sky is a filtered
 * texture, which is less exact. */
bool lit_has_colour(const float *pixel, const room_hit *hit, double tolerance);

/* Captures the lit room from eye into one cube, for the running test. */
typedef struct room_capture {
    view_capture *capture;
    view_cubes cubes;
    view_room_draw draw;
} room_capture;

room_capture *room_capture_begin(view_probe_capture kind, int size,
                                 const double eye[3]);
/* A whole update. */
void room_capture_update(room_capture *c);
/* The same of a sky alone. */
void room_capture_sky(room_capture *c, GLuint sky);
/* A level of cubes with faces of n x n texels: RGBA, from test_alloc. */
float *room_cubes_read(GLuint cubes, int count, int level, int n);
/* The only one of these, without alpha. */
void room_cube_read(GLuint cubes, const ibl_cube *cube);

/* What --mode scene shows, in uniform light of the environment. */
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
/* A picture as room_image_read has it; NULL after a failure. */
float *room_stage_draw(room_stage *on);

#endif
