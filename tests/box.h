/* SPDX-License-Identifier: MIT */
/*
 * A room with a block in it for tests of what is captured: walls of 8 x 8
 * squares in two shades of the wall's own colour, with a marker in the corner
 * of its smallest coordinates; and the same traced by rays, without OpenGL.
 */
#ifndef TEST_BOX_H
#define TEST_BOX_H

#include <stdbool.h>

#include "view/gl.h"

typedef struct box_scene {
    double panel; /* radiance of 2 x 2 squares of a wall; 0: none */
    bool open;    /* without a ceiling: nothing is drawn there */
    int calls;    /* of box_draw */
    GLuint program, array, buffer;
    int vertices;
    float *mesh, *moved; /* vertices in the world, in clip space; colours */
} box_scene;

/* OpenGL's part, after panel and open have been set. False, with a message. */
bool box_begin(box_scene *s);
void box_end(box_scene *s);
/* A view_capture_scene, the cookie a box_scene. */
void box_draw(void *cookie, const double clip[16], const double eye[3],
              int size, int side);
/* What a ray meets: RGB, alpha. */
void box_trace(const box_scene *s, const double eye[3], const double dir[3],
               double rgba[4]);

#endif
