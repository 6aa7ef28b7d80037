/* SPDX-License-Identifier: MIT */
/* Layouts of environments: found by shape, turned into equirectangular maps. */
#ifndef IBL_IO_LAYOUT_H
#define IBL_IO_LAYOUT_H

#include "ibl/io.h"

/* The layout of an image with this shape as opts say; AUTO: none has it. Cube
 * is a texture's, whose faces are stored like a vertical strip. */
ibl_input_layout ibl_input_layout_of(const ibl_read_options *opts,
                                     long long width, long long height);

/* Makes the map of an image in another layout than equirectangular; its shape
 * is that layout's.
 *   name   of the file whose faces are checked; NULL: they are not
 *   order  as in ibl_read_options
 *   faces  NULL or empty: gets the faces, if the layout has any, as level 0
 *   map    empty, filled here */
ibl_status ibl_unwrap(ibl_ctx *ctx, const char *name, ibl_input_layout layout,
                      const unsigned char order[IBL_FACES],
                      const ibl_image *img, ibl_cube *faces, ibl_image *map);

/* Takes faces below one another, whose first and last texels lie on the edges,
 * to texels that are centres: bilinear. */
ibl_status ibl_faces_from_edges(ibl_ctx *ctx, ibl_image *strip);

/* Copies a face, whose rows are `row` floats apart, to where its code says. */
void ibl_face_put(const float *from, size_t row, int code, ibl_cube *cube);
/* Warns if the faces of a cube do not meet but would in another order. order:
 * the codes by which the file's faces came to their places */
ibl_status ibl_faces_check(ibl_ctx *ctx, const char *name, const ibl_cube *cube,
                           const unsigned char order[IBL_FACES]);

#endif
