/* SPDX-License-Identifier: MIT */
#include "engine/png.h"

#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>
#if IBL_LIBDEFLATE
#include <libdeflate.h>
#endif

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

/* ---- encoding --------------------------------------------------------- */

enum {
    PAETH = 4,
    LEVEL = 3, /* of deflate: 9 takes ten times the time for 6 % less */
    MOST_KEY = 79
};

#if IBL_LIBDEFLATE

/* Returns the size; 0: no memory. */
static size_t pack(const unsigned char *bytes, size_t size, unsigned char *to,
                   size_t room)
{
    struct libdeflate_compressor *deflate = libdeflate_alloc_compressor(LEVEL);
    const size_t packed =
        deflate ? libdeflate_zlib_compress(deflate, bytes, size, to, room) : 0;

    libdeflate_free_compressor(deflate);
    return packed;
}

#else

static size_t pack(const unsigned char *bytes, size_t size, unsigned char *to,
                   size_t room)
{
    uLongf packed = room;

    return compress2(to, &packed, bytes, size, LEVEL) == Z_OK ? packed : 0;
}

#endif

static void put_word(unsigned char *to, size_t x)
{
    for (int i = 0; i < 4; i++)
        to[i] = (unsigned char)(x >> (24 - 8 * i));
}

/* Adds a chunk: the size of its data, a name, the data and their sum. */
static bool put_chunk(ibl_blob *out, const char *name, const void *data,
                      size_t size)
{
    unsigned char head[8], sum[4];

    put_word(head, size);
    memcpy(head + 4, name, 4);
    const uLong named = crc32(crc32(0, NULL, 0), head + 4, 4);
    put_word(sum, size ? crc32_z(named, data, size) : named);
    return ibl_blob_add(out, head, sizeof head) &&
           ibl_blob_add(out, data, size) && ibl_blob_add(out, sum, sizeof sum);
}

/* Where the row starts there is nothing on the left, and its filter is Up. */
static void filter(const unsigned char *row, const unsigned char *above,
                   size_t bytes, size_t texel, unsigned char *to)
{
    *to++ = PAETH;
    for (size_t i = 0; i < texel; i++)
        to[i] = (unsigned char)(row[i] - above[i]);
    for (size_t i = texel; i < bytes; i++) {
        const int a = row[i - texel], b = above[i], c = above[i - texel];
        const int from_a = abs(b - c), from_b = abs(a - c);
        const int from_c = abs(a + b - 2 * c);
        const int ab = from_a <= from_b ? a : b;
        const int least = from_a <= from_b ? from_a : from_b;
        to[i] = (unsigned char)(row[i] - (least <= from_c ? ab : c));
    }
}

/* All rows have one filter: a choice for each saves nothing. */
static bool put_image(const unsigned char *pixels, size_t width, size_t height,
                      size_t texel, ibl_blob *out)
{
    const size_t bytes = texel * width, line = bytes + 1, size = line * height;
    const size_t room = size + size / 1000 + 64; /* more than deflate adds */
    unsigned char *none = calloc(bytes, 1), *lines = malloc(size + room);
    bool ok = none && lines;

    for (size_t y = 0; y < height && ok; y++)
        filter(pixels + y * bytes, y ? pixels + (y - 1) * bytes : none, bytes,
               texel, lines + y * line);
    const size_t packed = ok ? pack(lines, size, lines + size, room) : 0;
    ok = packed && put_chunk(out, "IDAT", lines + size, packed);
    free(none);
    free(lines);
    return ok;
}

static bool put_keys(const ibl_texture *keys, ibl_blob *out)
{
    bool ok = true;

    for (int i = 0; keys && i < keys->key_count && ok; i++) {
        const char *key = keys->keys[i].key, *value = keys->keys[i].value;
        const size_t length = strlen(key) + 1, size = length + strlen(value);
        char *text = length <= MOST_KEY + 1 ? malloc(size + 1) : NULL;
        if (text) {
            memcpy(text, key, length);
            memcpy(text + length, value, size - length);
        }
        ok = text && put_chunk(out, "tEXt", text, size);
        free(text);
    }
    return ok;
}

static bool put_file(const unsigned char *pixels, int width, int height,
                     int texel, const ibl_texture *keys, ibl_blob *out)
{
    unsigned char header[13] = {0};

    put_word(header, (size_t)width);
    put_word(header + 4, (size_t)height);
    header[8] = 8;
    header[9] = texel == 4 ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB;
    *out = (ibl_blob){0};
    const bool ok =
        ibl_blob_add(out, "\x89PNG\r\n\x1a\n", 8) &&
        put_chunk(out, "IHDR", header, sizeof header) &&
        (texel == 4 || put_chunk(out, "sRGB", "", 1)) && put_keys(keys, out) &&
        put_image(pixels, (size_t)width, (size_t)height, (size_t)texel, out) &&
        put_chunk(out, "IEND", NULL, 0);
    if (!ok)
        ibl_blob_free(out);
    return ok;
}

bool ibl_png_encode(const unsigned char *rgba, int width, int height,
                    const ibl_texture *keys, ibl_blob *out)
{
    return put_file(rgba, width, height, 4, keys, out);
}

bool ibl_png_encode_rgb(const unsigned char *rgb, int width, int height,
                        void **png, size_t *size)
{
    ibl_blob out;
    const bool ok = put_file(rgb, width, height, 3, NULL, &out);

    *png = out.bytes;
    *size = out.size;
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
