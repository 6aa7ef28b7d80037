/* SPDX-License-Identifier: MIT */
/* Shared by the three containers: shapes, texels in and out, KTX key/values.
 * Readers must not trust any value of the file, only in->size. */
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

/* The 32-bit word at an offset; the caller has checked the offset. */
uint32_t ibl_input_u32(const ibl_input *in, uint64_t at);
ibl_status ibl_input_short(const ibl_input *in, const char *what);

/* A texture's shape as KTX and KTX2 headers store it. 0 levels means 1, 0
 * layers means 1 and no array, 0 depth means not 3D. */
typedef struct ibl_extent {
    uint32_t width, height, depth, layers, faces, levels;
} ibl_extent;

ibl_extent ibl_extent_of(const ibl_texture *tex);

/* How a file stores texels, and where the next image is: a face of a level and
 * layer. */
typedef struct ibl_place {
    const ibl_layout *layout;
    uint64_t at;
    uint32_t row_align; /* rows begin at multiples of it, in bytes */
    bool bottom_up;     /* the first row in the file is the bottom row */
} ibl_place;

/* Checks a shape and gives it to tex, which gets no memory yet. */
ibl_status ibl_texture_shape(const ibl_input *in, const ibl_extent *shape,
                             const ibl_place *place, ibl_texture *tex);
/* Bytes in the file of an image, and of so many images with all levels. */
uint64_t ibl_place_bytes(const ibl_place *place, const ibl_texture *tex,
                         int level);
uint64_t ibl_place_all_bytes(const ibl_place *place, const ibl_texture *tex,
                             uint64_t images);
/* Refuses a file with fewer bytes than its texels take. */
ibl_status ibl_check_stored(const ibl_input *in, const ibl_place *place,
                            const ibl_texture *tex);
/* Refuses a level for which the file states another size. */
ibl_status ibl_check_level_bytes(const ibl_input *in, int level, uint64_t bytes,
                                 uint64_t must);
/* Allocates the texels of tex, whose shape is set, unless there is only the
 * head of the file: data is then NULL, and no level is read. */
ibl_status ibl_texture_alloc(const ibl_input *in, ibl_texture *tex);
/* The same for a texture that no file limits. */
ibl_status ibl_texture_room(ibl_ctx *ctx, ibl_texture *tex);
/* Copies an image, numbered by layer and face, into tex and moves place->at
 * behind it; adds alpha where needed. */
ibl_status ibl_place_read(const ibl_input *in, ibl_place *place,
                          ibl_texture *tex, int level, int image);
/* All images of a level, which follow one another. */
ibl_status ibl_place_read_level(const ibl_input *in, ibl_place *place,
                                ibl_texture *tex, int level);

/* Width and height of a level, in texels. */
size_t ibl_texture_width(const ibl_texture *tex, int level);
size_t ibl_texture_height(const ibl_texture *tex, int level);
/* Bytes of a level with all its layers and faces. */
size_t ibl_texture_level_bytes(const ibl_texture *tex, int level);

/* Checks a texture that a caller may have filled in: IBL_ERR_ARGUMENT. */
ibl_status ibl_texture_check(ibl_ctx *ctx, const ibl_texture *tex);

/* Reads the key/value pairs of KTX and KTX2. Skips values that are not text (no
 * UTF-8, or zeros inside). Drops KTXorientation: *bottom_up is true for `up`,
 * false for `down`; other values are refused. */
ibl_status ibl_keys_read(const ibl_input *in, uint64_t at, uint64_t size,
                         const char *down, const char *up, ibl_texture *tex,
                         bool *bottom_up);

/* Writes the pairs of tex to dst, with this KTXorientation and our KTXwriter.
 * Returns their bytes; writes nothing if dst is NULL. */
size_t ibl_keys_write(const ibl_texture *tex, const char *orientation,
                      unsigned char *dst);

/* The first bytes of each kind of file, without the terminating zero. */
#define IBL_KTX2_MAGIC "\xABKTX 20\xBB\r\n\x1A\n"
#define IBL_KTX_MAGIC "\xABKTX 11\xBB\r\n\x1A\n"
#define IBL_DDS_MAGIC "DDS "

/* The container of a file by its first bytes; IBL_CONTAINER_COUNT: unknown. */
ibl_container ibl_container_of(const unsigned char *bytes, size_t size);

/* ibl_texture_decode of an input in memory, or of the head of one. */
ibl_status ibl_texture_take(const ibl_input *in, ibl_texture *tex,
                            ibl_container *container);
/* tex must be empty. Free it with ibl_texture_free, after errors too. */
ibl_status ibl_ktx2_decode(const ibl_input *in, ibl_texture *tex);
ibl_status ibl_ktx_decode(const ibl_input *in, ibl_texture *tex);
ibl_status ibl_dds_decode(const ibl_input *in, ibl_texture *tex);
/* Copies a DDS file that the bridge is to read, with a header that OpenImageIO
 * understands: of four bytes per texel by masks, a cube's by the old flags.
 * dst: of size bytes. Returns the bytes written. */
size_t ibl_dds_picture(const unsigned char *bytes, size_t size,
                       unsigned char *dst);
/* Whether the first bytes of a DDS file name no DX10 header. */
bool ibl_dds_is_legacy(const unsigned char *bytes, size_t size);

/* A contiguous part of a file. */
typedef struct ibl_piece {
    const void *bytes;
    size_t size;
} ibl_piece;

enum {
    IBL_MAX_TEXTURE_LEVELS = 17
};

/* A file to write, piece after piece. The texels stay in the texture; head has
 * all other bytes. */
typedef struct ibl_pieces {
    unsigned char *head;   /* owned, like the next two, by ibl_pieces_free */
    unsigned char *packed; /* compressed levels, or NULL */
    ibl_piece *piece;
    size_t size; /* of all pieces, in bytes */
    int count, room;
} ibl_pieces;

/* Makes room for `room` pieces, and a zeroed head. False: no memory. */
bool ibl_pieces_alloc(ibl_pieces *file, size_t head_bytes, int room);
void ibl_pieces_free(ibl_pieces *file);
void ibl_pieces_add(ibl_pieces *file, const void *bytes, size_t size);

/* Makes the file of tex. Checks tex first: errors as ibl_texture_encode. file:
 * zeroed; the caller must free it, after errors too. */
ibl_status ibl_texture_pieces(ibl_ctx *ctx, const ibl_texture *tex,
                              ibl_container container, ibl_pieces *file);

/* The same for a valid tex. */
ibl_status ibl_ktx2_encode(ibl_ctx *ctx, const ibl_texture *tex,
                           ibl_pieces *file);
ibl_status ibl_ktx_encode(ibl_ctx *ctx, const ibl_texture *tex,
                          ibl_pieces *file);
ibl_status ibl_dds_encode(ibl_ctx *ctx, const ibl_texture *tex,
                          ibl_pieces *file);
ibl_status ibl_dds_legacy_encode(ibl_ctx *ctx, const ibl_texture *tex,
                                 ibl_pieces *file);

/* Decodes a level of a texture of 3 channels: its layers and faces one below
 * the other. */
ibl_status ibl_texels_decode(ibl_ctx *ctx, const ibl_texture *tex, int level,
                             float *rgb);

/* ---- levels as frames of Zstandard (RFC 8878): zstd_frames.c ----------- */

/*
 * Compresses each level to a frame that states its size, on the pool.
 *   tex     valid, zstd is 1..IBL_MAX_ZSTD
 *   packed  memory of all frames, which the caller frees, after errors too
 *   frames  one for each level
 */
ibl_status ibl_zstd_pack(ibl_ctx *ctx, const ibl_texture *tex,
                         unsigned char **packed,
                         ibl_piece frames[IBL_MAX_TEXTURE_LEVELS]);

/* Refuses `packed` bytes that cannot hold `bytes`. level: for messages. */
ibl_status ibl_zstd_check(const ibl_input *in, int level, uint64_t packed,
                          uint64_t bytes);

/* Decompresses frames at an offset, which are in the file, to `bytes` of new
 * memory, which the caller frees with ibl_free, after errors too. */
ibl_status ibl_zstd_unpack(const ibl_input *in, int level, uint64_t at,
                           uint64_t packed, uint64_t bytes,
                           unsigned char **unpacked);

#endif
