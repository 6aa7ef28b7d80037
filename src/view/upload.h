/* SPDX-License-Identifier: MIT */
/* Textures of a set as OpenGL has them. */
#ifndef VIEW_UPLOAD_H
#define VIEW_UPLOAD_H

#include "ibl/io.h"
#include "view/gl.h"

/*
 * A texture object with all levels, texel for texel as tex has them: cubes
 * with 6 faces, flat ones with 1. Filtered linearly, between levels too, and
 * clamped to edges. name stands in messages. 0, with a message, if OpenGL has
 * no room for it. Leaves it bound to the active unit.
 */
GLuint view_upload(const ibl_texture *tex, const char *name);

/* The same of an array of cubes, of one layer too, as a cube map array: needs
 * what view/gl.h says of these. */
GLuint view_upload_cubes(const ibl_texture *tex, const char *name);

/* An RGBA32F texture of width x height that is read texel by texel. */
GLuint view_float_target(int width, int height);

#endif
