/* SPDX-License-Identifier: MIT */
/*
 * shown SCREEN.xwd X Y PICTURE.png: how many pixels of a screen (what Xvfb
 * keeps with -fbdir), from X, Y on, are not those of a picture.
 */
#include <png.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

/* Fields of the header that are looked at, as X11/XWDFile.h numbers them: all
 * of 4 bytes, the highest first. */
enum {
    HEADER_SIZE = 0,
    WIDTH = 4,
    HEIGHT = 5,
    BYTE_ORDER = 7,
    BITS = 11,
    ROW_BYTES = 12,
    COLOURS = 19,
    FIELDS = 25
};

static void fail(const char *name, const char *what)
{
    fprintf(stderr, "%s: %s\n", name, what);
    exit(2);
}

static uint32_t field(const unsigned char *xwd, int i)
{
    const unsigned char *b = xwd + 4 * i;
    return (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 |
           b[3];
}

static unsigned char *load(const char *path, size_t *size)
{
    enum {
        MOST = 64 << 20
    };
    FILE *f = fopen(path, "rb");
    unsigned char *bytes = malloc(MOST);

    if (!f || !bytes)
        fail(path, "cannot be opened");
    *size = fread(bytes, 1, MOST, f);
    fclose(f);
    return bytes;
}

/* Pixels of blue, green, red and one byte more, rows from the top. */
static const unsigned char *pixels_of(const char *path,
                                      const unsigned char *xwd, size_t size)
{
    if (size < 4 * FIELDS || field(xwd, BITS) != 32 || field(xwd, BYTE_ORDER))
        fail(path, "is no screen of 4 bytes a pixel, the lowest first");
    const size_t begin = field(xwd, HEADER_SIZE) + 12 * field(xwd, COLOURS);
    if (begin + (size_t)field(xwd, HEIGHT) * field(xwd, ROW_BYTES) > size)
        fail(path, "is cut short");
    return xwd + begin;
}

int main(int argc, char **argv)
{
    png_image image = {.version = PNG_IMAGE_VERSION};
    size_t size, other = 0;

    if (argc != 5)
        fail("shown", "SCREEN.xwd X Y PICTURE.png");
    const uint32_t left = (uint32_t)atoi(argv[2]);
    const uint32_t top = (uint32_t)atoi(argv[3]);
    if (!png_image_begin_read_from_file(&image, argv[4]))
        fail(argv[4], image.message);
    image.format = PNG_FORMAT_BGR;
    unsigned char *picture = malloc(PNG_IMAGE_SIZE(image));
    if (!picture || !png_image_finish_read(&image, NULL, picture, 0, NULL))
        fail(argv[4], image.message);
    unsigned char *xwd = load(argv[1], &size);
    const unsigned char *screen = pixels_of(argv[1], xwd, size);
    if (left + image.width > field(xwd, WIDTH) ||
        top + image.height > field(xwd, HEIGHT))
        fail(argv[4], "goes beyond the screen");
    for (uint32_t y = 0; y < image.height; y++)
        for (uint32_t x = 0; x < image.width; x++) {
            const unsigned char *p = picture + 3 * (y * image.width + x);
            const unsigned char *q =
                screen + (top + y) * field(xwd, ROW_BYTES) + 4 * (left + x);
            other += p[0] != q[0] || p[1] != q[1] || p[2] != q[2];
        }
    printf("%zu\n", other);
    free(picture);
    free(xwd);
    return 0;
}
