/* SPDX-License-Identifier: MIT */
#include "engine/png.h"

#include <limits.h>
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include "json/text.h"

enum {
    HEADER_BYTES = 33,  /* signature and IHDR chunk */
    CHUNK_BYTES = 12,   /* of a chunk besides its data */
    MOST_PACKED = 1032, /* bytes that a byte of deflate can stand for */
    LEVEL = 5           /* of deflate: 6 takes twice the time for 5 % less */
};

bool ibl_blob_add(ibl_blob *blob, const void *bytes, size_t size)
{
    if (size > blob->room - blob->size) {
        const size_t room = 2 * blob->room + size;
        unsigned char *larger = realloc(blob->bytes, room);
        if (!larger)
            return false;
        blob->bytes = larger;
        blob->room = room;
    }
    if (size)
        memcpy(blob->bytes + blob->size, bytes, size);
    blob->size += size;
    return true;
}

void ibl_blob_free(ibl_blob *blob)
{
    free(blob->bytes);
    *blob = (ibl_blob){0};
}

static void stay_silent(png_structp png, const char *text)
{
    (void)png;
    (void)text;
}

static void leave(png_structp png, const char *text)
{
    (void)text;
    png_longjmp(png, 1);
}

/* ---- encoding --------------------------------------------------------- */

static void add(png_structp png, png_bytep bytes, size_t size)
{
    if (!ibl_blob_add(png_get_io_ptr(png), bytes, size))
        png_error(png, "no memory");
}

/* All rows have one filter: a choice for each saves nothing. */
static void write_image(png_structp png, png_infop info,
                        const unsigned char *pixels, int channels, int width,
                        int height, const ibl_texture *keys)
{
    png_set_compression_level(png, LEVEL);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_PAETH);
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, 8,
                 channels == 4 ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (channels == 3)
        png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    for (int i = 0; keys && i < keys->key_count; i++)
        png_set_text(png, info,
                     &(png_text){.compression = PNG_TEXT_COMPRESSION_NONE,
                                 .key = keys->keys[i].key,
                                 .text = keys->keys[i].value},
                     1);
    png_write_info(png, info);
    for (int y = 0; y < height; y++, pixels += channels * width)
        png_write_row(png, pixels);
    png_write_end(png, NULL);
}

bool ibl_png_encode(const unsigned char *pixels, int channels, int width,
                    int height, const ibl_texture *keys, ibl_blob *out)
{
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL,
                                              leave, stay_silent);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    volatile bool ok = false;

    *out = (ibl_blob){0};
    if (info && !setjmp(png_jmpbuf(png))) {
        png_set_write_fn(png, out, add, NULL);
        write_image(png, info, pixels, channels, width, height, keys);
        ok = true;
    }
    png_destroy_write_struct(&png, &info);
    if (!ok)
        ibl_blob_free(out);
    return ok;
}

/* ---- decoding --------------------------------------------------------- */

bool ibl_png_size(const unsigned char *bytes, size_t size, int *width,
                  int *height)
{
    if (size < HEADER_BYTES || png_sig_cmp(bytes, 0, 8) ||
        memcmp(bytes + 12, "IHDR", 4) != 0)
        return false;
    const size_t w = png_get_uint_32(bytes + 16);
    const size_t h = png_get_uint_32(bytes + 20);
    const size_t depth = bytes[24];
    const int type = bytes[25];
    const size_t channels = type & PNG_COLOR_MASK_PALETTE
                                ? 1
                                : (type & PNG_COLOR_MASK_COLOR ? 3 : 1) +
                                      (type & PNG_COLOR_MASK_ALPHA ? 1 : 0);
    if (w > IBL_MAX_EDGE || h > IBL_MAX_EDGE || !depth ||
        w * channels * depth / 8 * h / MOST_PACKED > size)
        return false;
    *width = (int)w;
    *height = (int)h;
    return true;
}

bool ibl_png_fits(const unsigned char *bytes, size_t size, int width,
                  int height)
{
    int w, h;

    return ibl_png_size(bytes, size, &w, &h) && w == width && h == height &&
           bytes[24] == 8 &&
           (bytes[25] == PNG_COLOR_TYPE_RGBA ||
            bytes[25] == PNG_COLOR_TYPE_RGB);
}

typedef struct encoded {
    const unsigned char *bytes;
    size_t left;
} encoded;

static void get(png_structp png, png_bytep bytes, size_t size)
{
    encoded *e = png_get_io_ptr(png);

    if (size > e->left)
        png_error(png, "cut short");
    memcpy(bytes, e->bytes, size);
    e->bytes += size;
    e->left -= size;
}

static void read_image(png_structp png, png_infop info, int width, int height,
                       unsigned char *rgba)
{
    const size_t row = 4 * (size_t)width;

    png_read_info(png, info);
    png_set_expand(png);
    png_set_scale_16(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 255, PNG_FILLER_AFTER);
    const int passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    if (png_get_rowbytes(png, info) != row ||
        png_get_image_height(png, info) != (png_uint_32)height)
        png_error(png, "another size");
    for (int pass = 0; pass < passes; pass++)
        for (int y = 0; y < height; y++)
            png_read_row(png, rgba + row * (size_t)y, NULL);
    png_read_end(png, NULL);
}

bool ibl_png_decode(const unsigned char *bytes, size_t size, int width,
                    int height, unsigned char *rgba)
{
    encoded e = {bytes, size};
    png_structp png =
        png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, leave, stay_silent);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    volatile bool ok = false;

    if (info && !setjmp(png_jmpbuf(png))) {
        png_set_read_fn(png, &e, get);
        /* Texts and profiles. To keep one, libpng would allocate as many bytes
         * as it claims to have. */
        png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, NULL, -1);
        read_image(png, info, width, height, rgba);
        ok = true;
    }
    png_destroy_read_struct(&png, &info, NULL);
    return ok;
}

/* A chunk is its data's size, a name, the data (key, NUL, value) and a sum. */
ibl_status ibl_png_keys(ibl_ctx *ctx, const unsigned char *bytes, size_t size,
                        ibl_texture *tex)
{
    ibl_status status = IBL_OK;

    for (size_t at = 8; !status && size - at >= CHUNK_BYTES;) {
        const size_t length = png_get_uint_32(bytes + at);
        const char *data = (const char *)bytes + at + 8;
        if (length > size - at - CHUNK_BYTES || length > INT_MAX ||
            !memcmp(data - 4, "IDAT", 4))
            break;
        at += CHUNK_BYTES + length;
        const size_t key = strnlen(data, length) + 1;
        if (memcmp(data - 4, "tEXt", 4) != 0 || key > length || key == 1)
            continue;
        char *value = ibl_format("%.*s", (int)(length - key), data + key);
        status =
            value ? ibl_texture_set(ctx, tex, data, value) : IBL_ERR_MEMORY;
        free(value);
    }
    return status;
}
