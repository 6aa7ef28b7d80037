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

/* libpng's simple interface marks 8-bit RGB as sRGB. */
bool ibl_png_encode_rgb(const unsigned char *rgb, int width, int height,
                        void **png, size_t *size)
{
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)width,
                       .height = (png_uint_32)height,
                       .format = PNG_FORMAT_RGB};
    png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(image);

    *png = malloc(bytes);
    if (!*png)
        return false;
    if (!png_image_write_to_memory(&image, *png, &bytes, 0, rgb, 0, NULL)) {
        free(*png);
        *png = NULL;
        return false;
    }
    *size = bytes;
    return true;
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

/* Bits of a pixel in the file. */
static size_t bits_of(const unsigned char *bytes)
{
    static const int channels[] = {[PNG_COLOR_TYPE_GRAY] = 1,
                                   [PNG_COLOR_TYPE_RGB] = 3,
                                   [PNG_COLOR_TYPE_PALETTE] = 1,
                                   [PNG_COLOR_TYPE_GRAY_ALPHA] = 2,
                                   [PNG_COLOR_TYPE_RGBA] = 4};
    const size_t type = bytes[25], types = sizeof channels / sizeof *channels;

    return type < types ? bytes[24] * (size_t)channels[type] : 0;
}

bool ibl_png_holds(const unsigned char *bytes, size_t size)
{
    int w, h;

    if (!ibl_png_size(bytes, size, &w, &h) || !bits_of(bytes))
        return false;
    return (size_t)w * bits_of(bytes) / 8 * (size_t)h / MOST_PACKED <= size;
}

bool ibl_png_fits(const unsigned char *bytes, size_t size, int width,
                  int height)
{
    int w, h;

    return ibl_png_size(bytes, size, &w, &h) && w == width && h == height &&
           bytes[24] == 8 &&
           (bytes[25] == PNG_COLOR_TYPE_RGBA ||
            bytes[25] == PNG_COLOR_TYPE_RGB) &&
           ibl_png_holds(bytes, size);
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

static void leave(png_structp png, const char *text)
{
    (void)text;
    png_longjmp(png, 1);
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
