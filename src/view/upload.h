/* SPDX-License-Identifier: MIT */
/* Uploads textures to OpenGL. */
#ifndef VIEW_UPLOAD_H
#define VIEW_UPLOAD_H

#include "view/baked_set.h"
#include "view/gl.h"

/* Uploads all levels of a texture, filtered linearly, between levels too, and
 * clamped to edges; binds it to the active unit.
 *   tex    without blocks: see ibl_texture_unblock
 *   cubes  true: as a cube map array (view_gl_has_cube_arrays); false: as a
 *          cube map or, with one face, as a 2D texture or array
 *   name   for messages
 * Returns 0, with a message, if OpenGL has no room for it. */
GLuint view_upload(const ibl_texture *tex, bool cubes, const char *name);

/* Uploads the map of a set as an equirectangular picture of RGB floats, bound
 * to the active unit. 0: it is not at hand or too large. */
GLuint view_upload_map(const baked_set *set);

/* Makes a texture of 32-bit floats, GL_RGB or GL_RGBA, that is read texel by
 * texel, on the active unit. pixels NULL: without defined texels. */
GLuint view_float_image(GLenum format, int width, int height,
                        const float *pixels);

/* A picture of RGBA floats to draw into; zeroed: not made yet. */
typedef struct view_image {
    GLuint texture, framebuffer;
    int width, height;
} view_image;

/* Makes it, unless it has that size already. False, with a message. */
bool view_image_make(view_image *i, int width, int height);
void view_image_free(view_image *i); /* zeroes it, too */

/* The program of shaders/mean.frag. */
typedef struct view_mean {
    GLuint program;
    GLint part;
} view_mean;

bool view_mean_make(view_mean *m); /* false, with a message */
/* Blends a picture into the mean of several, which is made on first use. part:
 * its share, 1: it replaces them. Leaves the mean bound for drawing, blending
 * off. False, with a message. */
bool view_mean_add(const view_mean *m, const view_image *picture, float part,
                   view_image *mean);

#endif
