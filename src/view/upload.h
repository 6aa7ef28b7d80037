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

#endif
