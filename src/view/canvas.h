/* SPDX-License-Identifier: MIT */
/* A framebuffer with depth, for pictures of triangles. */
#ifndef VIEW_CANVAS_H
#define VIEW_CANVAS_H

#include "view/gl.h"

typedef struct view_canvas {
    GLuint framebuffer[2]; /* of the buffers, of the picture */
    GLuint buffer[2];      /* colour and depth */
    int width, height, samples;
} view_canvas;

/* Binds a framebuffer for a picture, a texture of width x height pixels, with
 * that many samples of each pixel or as many as OpenGL has, and sets the
 * viewport. Allocates only if size or samples change. False, with a message. */
bool view_canvas_begin(view_canvas *c, GLuint picture, int width, int height,
                       int samples);
/* Writes the picture, the mean of the samples; binds a framebuffer on it. */
void view_canvas_end(const view_canvas *c);
void view_canvas_free(view_canvas *c); /* zeroed is fine */

#endif
