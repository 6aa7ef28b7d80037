/* SPDX-License-Identifier: MIT */
/* Textures of a set as OpenGL has them. */
#ifndef VIEW_UPLOAD_H
#define VIEW_UPLOAD_H

#include "ibl/io.h"
#include "view/gl.h"

/* A texture of all levels, cubes with 6 faces, flat ones with 1, filtered
 * linearly, between levels too, and clamped to edges; bound to the active unit.
 * name is for messages. 0, with a message, if OpenGL has no room for it. */
GLuint view_upload(const ibl_texture *tex, const char *name);

/* The same of cubes, one or more, as a cube map array
 * (view_gl_has_cube_arrays). */
GLuint view_upload_cubes(const ibl_texture *tex, const char *name);

/* An RGBA32F texture of width x height that is read texel by texel. */
GLuint view_float_target(int width, int height);

#endif
