/* SPDX-License-Identifier: MIT */
/* Shared by the three containers: shapes, texels in and out, KTX key/values. A
 * reader trusts only in->size. */
#ifndef IBL_IO_CONTAINER_H
#define IBL_IO_CONTAINER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/context.h"
#include "ibl/io.h"
#include "io/input.h"
#include "io/pixel_format.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "texels are encoded and stored in the machine's order, little endian"
#endif

enum {
    IBL_MAX_KEYS = 4096,
    IBL_MAX_KEY_BYTES = 255
};

/* The word at an offset that the caller has checked. */
uint32_t ibl_input_u32(const ibl_input *in, uint64_t at);
ibl_status ibl_input_short(const ibl_input *in, const char *what);

/* A texture's shape as KTX and KTX2 headers have it. 0 levels are 1, 0 layers
 * are 1 and no array, 0 depth is none. */
typedef struct ibl_shape {
    uint32_t width, height, depth, layers, faces, levels;
} ibl_shape;

ibl_shape ibl_shape_of(const ibl_texture *tex);

/* Where a level's face of a layer is in the file. */
typedef struct ibl_place {
    const ibl_layout *layout;
    uint64_t at;
    uint32_t row_align; /* rows begin at multiples of it */
    bool bottom_up;     /* the first row in the file is the lowest */
} ibl_place;

/* Allocates tex, without keys, after checking shape and that the file has
 * enough bytes for place's layout and alignment. */
ibl_status ibl_texture_begin(const ibl_input *in, const ibl_shape *shape,
                             const ibl_place *place, ibl_texture *tex);

/* Bytes of a level's face in the file. */
uint64_t ibl_place_bytes(const ibl_place *place, const ibl_texture *tex,
                         int level);
/* Copies one in, turning words round and widening where needed. */
ibl_status ibl_place_read(const ibl_input *in, const ibl_place *place,
                          ibl_texture *tex, int level, int layer, int face);
/* Reads a level, whose faces follow one another, and moves place->at behind
 * it. `images` faces must take the bytes that the file states. */
ibl_status ibl_place_read_level(const ibl_input *in, ibl_place *place,
                                ibl_texture *tex, int level, int images,
                                uint64_t bytes);

/* Edges of a level. */
size_t ibl_texture_width(const ibl_texture *tex, int level);
size_t ibl_texture_height(const ibl_texture *tex, int level);
/* Bytes of a level, all layers and faces. */
size_t ibl_texture_level_bytes(const ibl_texture *tex, int level);

/* Whether a texture that a caller may have filled in by hand is whole:
 * IBL_ERR_ARGUMENT. */
ibl_status ibl_texture_check(ibl_ctx *ctx, const ibl_texture *tex);

/* Reads key/value pairs of KTX and KTX2. Values that are not text (no UTF-8, or
 * zeros inside) are left out. KTXorientation is not kept: *bottom_up is true if
 * it is `up`, false if it is `down`; others are refused. */
ibl_status ibl_keys_read(const ibl_input *in, uint64_t at, uint64_t size,
                         const char *down, const char *up, ibl_texture *tex,
                         bool *bottom_up);

/* Writes the pairs of a file to dst, or nowhere if it is NULL: those of tex,
 * with KTXorientation and KTXwriter ours. Returns their bytes. */
size_t ibl_keys_write(const ibl_texture *tex, const char *orientation,
                      unsigned char *dst);

/* The first bytes of files, without the zero. */
#define IBL_KTX2_MAGIC "\xABKTX 20\xBB\r\n\x1A\n"
#define IBL_KTX_MAGIC "\xABKTX 11\xBB\r\n\x1A\n"
#define IBL_DDS_MAGIC "DDS "

/* The container of a file by its first bytes; IBL_CONTAINER_COUNT: none. */
ibl_container ibl_container_of(const unsigned char *bytes, size_t size);

/* tex is empty; free it with ibl_texture_free after an error. */
ibl_status ibl_ktx2_decode(ibl_input *in, ibl_texture *tex);
ibl_status ibl_ktx_decode(ibl_input *in, ibl_texture *tex);
ibl_status ibl_dds_decode(ibl_input *in, ibl_texture *tex);

/* A stretch of a file. */
typedef struct ibl_piece {
    const void *bytes;
    size_t size;
} ibl_piece;

enum {
    IBL_MAX_TEXTURE_LEVELS = 17
};

/* A file to write, piece after piece. Texels stay in the texture; the rest is
 * in head. */
typedef struct ibl_pieces {
    unsigned char *head; /* owned, as piece: ibl_pieces_free */
    ibl_piece *piece;
    size_t size; /* of all */
    int count, room;
} ibl_pieces;

/* Room for `room` pieces, and a zeroed head. False without memory. */
bool ibl_pieces_alloc(ibl_pieces *file, size_t head_bytes, int room);
void ibl_pieces_free(ibl_pieces *file);
void ibl_pieces_add(ibl_pieces *file, const void *bytes, size_t size);
/* A whole level. */
void ibl_pieces_add_level(ibl_pieces *file, const ibl_texture *tex, int level);

/* The file of tex, whatever the caller has filled in: errors as
 * ibl_texture_encode. file: zeroed; to be freed after errors too. */
ibl_status ibl_texture_pieces(ibl_ctx *ctx, const ibl_texture *tex,
                              ibl_container container, ibl_pieces *file);

/* The same, tex being valid. */
ibl_status ibl_ktx2_encode(ibl_ctx *ctx, const ibl_texture *tex,
                           ibl_pieces *file);
ibl_status ibl_ktx_encode(ibl_ctx *ctx, const ibl_texture *tex,
                          ibl_pieces *file);
ibl_status ibl_dds_encode(ibl_ctx *ctx, const ibl_texture *tex,
                          ibl_pieces *file);

#endif
