/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "float_exr.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static void put_u32(FILE *to, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        fputc((int)(value >> 8 * i & 255), to);
}

static void put_float(FILE *to, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_u32(to, bits);
}

/* Name, type and bytes of an attribute whose value needs no number. */
#define PLAIN(text) fwrite(text, 1, sizeof text - 1, to)

static void put_header(FILE *to, int width, int height, const char *channels)
{
    static const char boxes[2][20] = {"dataWindow", "displayWindow"};

    PLAIN("v/1\1\2\0\0\0channels\0chlist\0");
    put_u32(to, (uint32_t)(18 * strlen(channels) + 1));
    for (const char *c = channels; *c; c++) {
        fprintf(to, "%c%c", *c, 0);
        put_u32(to, 2); /* floats */
        put_u32(to, 0);
        put_u32(to, 1);
        put_u32(to, 1);
    }
    PLAIN("\0compression\0compression\0\1\0\0\0\0");
    for (int i = 0; i < 2; i++) {
        fprintf(to, "%s%cbox2i%c", boxes[i], 0, 0);
        put_u32(to, 16);
        put_u32(to, 0);
        put_u32(to, 0);
        put_u32(to, (uint32_t)width - 1);
        put_u32(to, (uint32_t)height - 1);
    }
    PLAIN("lineOrder\0lineOrder\0\1\0\0\0\0"
          "pixelAspectRatio\0float\0\4\0\0\0\0\0\x80\x3f"
          "screenWindowCenter\0v2f\0\10\0\0\0\0\0\0\0\0\0\0\0"
          "screenWindowWidth\0float\0\4\0\0\0\0\0\x80\x3f\0");
}

bool test_write_float_exr(FILE *to, int width, int height, const char *channels,
                          const float *samples)
{
    const size_t w = (size_t)width, h = (size_t)height;
    const size_t row = 4 * strlen(channels) * w;
    char *header = NULL;
    size_t header_size = 0;
    FILE *m = open_memstream(&header, &header_size);

    if (!m)
        return false;
    put_header(m, width, height, channels);
    fclose(m);
    fwrite(header, 1, header_size, to);
    free(header);
    for (size_t y = 0; y < h; y++) { /* where each chunk begins */
        put_u32(to, (uint32_t)(header_size + 8 * h + y * (row + 8)));
        put_u32(to, 0);
    }
    for (size_t y = 0; y < h; y++) {
        put_u32(to, (uint32_t)y);
        put_u32(to, (uint32_t)row);
        for (size_t c = 0; channels[c]; c++)
            for (size_t x = 0; x < w; x++)
                put_float(to, samples[(c * h + y) * w + x]);
    }
    return !ferror(to);
}
