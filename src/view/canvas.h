/* SPDX-License-Identifier: MIT */
/* A framebuffer with depth, for pictures of triangles. */
#ifndef VIEW_CANVAS_H
#define VIEW_CANVAS_H

#include "view/gl.h"

typedef struct view_canvas {
    GLuint framebuffer, depth;   /* on the picture itself */
    GLuint many, many_buffer[2]; /* several samples: colour and depth */
    int width, height, samples;  /* of the buffers */
} view_canvas;

/* Binds a framebuffer that draws into picture, a texture of width x height
 * pixels, directly or, if samples is above 1, through as many samples of each
 * pixel as OpenGL has, and sets the viewport. Allocates only if size or samples
 * change. False, with a message. */
bool view_canvas_begin(view_canvas *c, GLuint picture, int width, int height,
                       int samples);
/* Averages the samples into the picture; binds a framebuffer on it. */
void view_canvas_end(const view_canvas *c);
void view_canvas_free(view_canvas *c); /* zeroed is fine */

#endif
