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

static void put_attribute(FILE *to, const char *name, const char *type,
                          size_t size)
{
    fprintf(to, "%s%c%s%c", name, 0, type, 0);
    put_u32(to, (uint32_t)size);
}

static void put_header(FILE *to, int width, int height, const char *channels)
{
    static const char *const boxes[] = {"dataWindow", "displayWindow"};

    put_u32(to, 20000630);
    put_u32(to, 2);
    put_attribute(to, "channels", "chlist", 18 * strlen(channels) + 1);
    for (const char *c = channels; *c; c++) {
        fprintf(to, "%c%c", *c, 0);
        put_u32(to, 2); /* floats */
        put_u32(to, 0);
        put_u32(to, 1);
        put_u32(to, 1);
    }
    fputc(0, to);
    put_attribute(to, "compression", "compression", 1);
    fputc(0, to);
    for (int i = 0; i < 2; i++) {
        put_attribute(to, boxes[i], "box2i", 16);
        put_u32(to, 0);
        put_u32(to, 0);
        put_u32(to, (uint32_t)width - 1);
        put_u32(to, (uint32_t)height - 1);
    }
    put_attribute(to, "lineOrder", "lineOrder", 1);
    fputc(0, to);
    put_attribute(to, "pixelAspectRatio", "float", 4);
    put_float(to, 1);
    put_attribute(to, "screenWindowCenter", "v2f", 8);
    put_u32(to, 0);
    put_u32(to, 0);
    put_attribute(to, "screenWindowWidth", "float", 4);
    put_float(to, 1);
    fputc(0, to);
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
