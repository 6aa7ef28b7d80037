/* SPDX-License-Identifier: MIT */
#include "engine/png.h"

#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

enum {
    HEADER_BYTES = 33, /* signature and IHDR chunk */
    CHUNK_BYTES = 12,  /* of a chunk besides its data */
    MOST_PACKED = 1032 /* bytes that a byte of deflate can stand for */
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
    memcpy(blob->bytes + blob->size, bytes, size);
    blob->size += size;
    return true;
}

void ibl_blob_free(ibl_blob *blob)
{
    free(blob->bytes);
    *blob = (ibl_blob){0};
}

/* ---- encoding --------------------------------------------------------- */

static void put(png_structp png, png_bytep bytes, size_t size)
{
    if (!ibl_blob_add(png_get_io_ptr(png), bytes, size))
        png_error(png, "no memory");
}

static void flush(png_structp png)
{
    (void)png;
}

static void stay_silent(png_structp png, const char *text)
{
    (void)png;
    (void)text;
}

static void put_keys(png_structp png, png_infop info, const ibl_texture *keys)
{
    for (int i = 0; keys && i < keys->key_count; i++) {
        png_text text = {.compression = PNG_TEXT_COMPRESSION_NONE,
                         .key = keys->keys[i].key,
                         .text = keys->keys[i].value};
        png_set_text(png, info, &text, 1);
    }
}

/* One filter, which is as good as a choice among all, and a low level: 6 takes
 * twice the time of 4 for 4 % less, 9 more than ten times for 7 %. */
static void put_image(png_structp png, png_infop info,
                      const unsigned char *rgba, int width, int height,
                      const ibl_texture *keys)
{
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, 8,
                 PNG_COLOR_TYPE_RGBA, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png, 4);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_PAETH);
    put_keys(png, info, keys);
    png_write_info(png, info);
    for (int y = 0; y < height; y++)
        png_write_row(png, rgba + 4 * (size_t)width * (size_t)y);
    png_write_end(png, NULL);
}

bool ibl_png_encode(const unsigned char *rgba, int width, int height,
                    const ibl_texture *keys, ibl_blob *out)
{
    png_structp png =
        png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, stay_silent);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    volatile bool ok = false;

    *out = (ibl_blob){0};
    if (info && !setjmp(png_jmpbuf(png))) {
        png_set_write_fn(png, out, put, flush);
        put_image(png, info, rgba, width, height, keys);
        ok = true;
    }
    png_destroy_write_struct(&png, &info);
    if (!ok)
        ibl_blob_free(out);
    return ok;
}

/* ---- decoding --------------------------------------------------------- */

static unsigned word(const unsigned char *p)
{
    return (unsigned)p[0] << 24 | (unsigned)p[1] << 16 | (unsigned)p[2] << 8 |
           p[3];
}

bool ibl_png_size(const unsigned char *bytes, size_t size, int *width,
                  int *height)
{
    if (size < HEADER_BYTES || png_sig_cmp(bytes, 0, 8) != 0 ||
        memcmp(bytes + 12, "IHDR", 4) != 0 || word(bytes + 16) > IBL_MAX_EDGE ||
        word(bytes + 20) > IBL_MAX_EDGE)
        return false;
    *width = (int)word(bytes + 16);
    *height = (int)word(bytes + 20);
    return true;
}

bool ibl_png_fits(const unsigned char *bytes, size_t size, int width,
                  int height)
{
    int w, h;

    if (!ibl_png_size(bytes, size, &w, &h) || w != width || h != height)
        return false;
    const int depth = bytes[24], type = bytes[25];
    const size_t channels = type == PNG_COLOR_TYPE_RGBA ? 4 : 3;
    return depth == 8 &&
           (type == PNG_COLOR_TYPE_RGBA || type == PNG_COLOR_TYPE_RGB) &&
           channels * (size_t)w * (size_t)h / MOST_PACKED <= size;
}

bool ibl_png_decode(const unsigned char *bytes, size_t size, int width,
                    int height, unsigned char *rgba)
{
    png_image image = {.version = PNG_IMAGE_VERSION};

    if (!png_image_begin_read_from_memory(&image, bytes, size))
        return false;
    image.format = PNG_FORMAT_RGBA;
    const bool ok = image.width == (png_uint_32)width &&
                    image.height == (png_uint_32)height &&
                    png_image_finish_read(&image, NULL, rgba, 0, NULL) &&
                    !(image.warning_or_error & PNG_IMAGE_ERROR);
    png_image_free(&image);
    return ok;
}

/* A chunk is its data's size, a name, the data (key, NUL, value) and a sum. */
ibl_status ibl_png_keys(ibl_ctx *ctx, const unsigned char *bytes, size_t size,
                        ibl_texture *tex)
{
    ibl_status status = IBL_OK;

    for (size_t at = 8; !status && size - at >= CHUNK_BYTES;) {
        const size_t length = word(bytes + at);
        const unsigned char *data = bytes + at + 8;
        if (length > size - at - CHUNK_BYTES || !memcmp(data - 4, "IDAT", 4))
            break;
        at += CHUNK_BYTES + length;
        const unsigned char *end = memchr(data, '\0', length);
        if (memcmp(data - 4, "tEXt", 4) != 0 || !end || end == data)
            continue;
        const size_t key = (size_t)(end - data) + 1;
        char *value = strndup((const char *)end + 1, length - key);
        status = value ? ibl_texture_set(ctx, tex, (const char *)data, value)
                       : IBL_ERR_MEMORY;
        free(value);
    }
    return status;
}
