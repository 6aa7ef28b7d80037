/* SPDX-License-Identifier: MIT */
#include "io/ultra_hdr.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "io/colour_space.h"

/* The white of the profile connection space: D50. */
static const double d50[3] = {0.9642, 1, 0.8249};

typedef struct tag {
    const unsigned char *bytes;
    size_t size;
} tag;

static uint32_t word(const unsigned char *p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 |
           p[3];
}

static double fixed(const unsigned char *p)
{
    return (int32_t)word(p) / 65536.0;
}

/* A tag of at least 12 bytes; size 0: there is none. */
static tag find(const unsigned char *bytes, size_t size, const char *name)
{
    const uint32_t count = size >= 132 ? word(bytes + 128) : 0;

    for (uint32_t i = 0; i < count && 144 + 12 * (size_t)i <= size; i++) {
        const unsigned char *entry = bytes + 132 + 12 * (size_t)i;
        const size_t at = word(entry + 4), length = word(entry + 8);
        if (!memcmp(entry, name, 4) && at <= size && length <= size - at &&
            length >= 12)
            return (tag){bytes + at, length};
    }
    return (tag){0};
}

/* What a curve makes of one half; -1: no curve. sRGB makes 0.2140 of it. */
static double half_of(tag t)
{
    if (t.size >= 12 && !memcmp(t.bytes, "curv", 4)) {
        const uint32_t n = word(t.bytes + 8);
        if (n < 2 || n > 65536 || t.size - 12 < 2 * (size_t)n)
            return n == 1 && t.size >= 14
                       ? pow(0.5, (t.bytes[12] * 256 + t.bytes[13]) / 256.0)
                       : -1;
        const unsigned char *a = t.bytes + 12 + 2 * ((n - 1) / 2);
        const unsigned char *b = t.bytes + 12 + 2 * (n / 2);
        return (a[0] * 256 + a[1] + b[0] * 256 + b[1]) / (2 * 65535.0);
    }
    if (t.size >= 16 && !memcmp(t.bytes, "para", 4)) {
        const int type = t.bytes[8] * 256 + t.bytes[9];
        const double g = fixed(t.bytes + 12);
        if (type == 0)
            return pow(0.5, g);
        if (type >= 3 && t.size >= 32) /* above the linear part */
            return pow(fixed(t.bytes + 16) / 2 + fixed(t.bytes + 20), g);
    }
    return -1;
}

/* Whether the colorants are those of a space, adapted to D50. */
static bool has_colorants(const double xyz[9], const double xy[8])
{
    double from[8], m[9], near = 0;
    /* XYZ of D50 as a space of its own, whose primaries are its axes */
    const double sum = d50[0] + d50[1] + d50[2];
    const double axes[8] = {1, 0, 0, 1, 0, 0, d50[0] / sum, d50[1] / sum};

    memcpy(from, xy, sizeof from);
    if (!ibl_colour_matrix(from, axes, m, NULL))
        return false;
    for (int i = 0; i < 9; i++)
        near = fmax(near, fabs(m[i] * d50[i / 3] - xyz[i]));
    return near < 0.003;
}

bool ibl_icc_primaries(const unsigned char *bytes, size_t size, double xy[8])
{
    static const char *const colorants[] = {"rXYZ", "gXYZ", "bXYZ"};
    static const char *const curves[] = {"rTRC", "gTRC", "bTRC"};
    double xyz[9];

    for (int c = 0; c < 3; c++) {
        const tag t = find(bytes, size, colorants[c]);
        if (t.size < 20 ||
            !(fabs(half_of(find(bytes, size, curves[c])) - 0.2140) < 0.004))
            return false;
        for (int k = 0; k < 3; k++)
            xyz[3 * k + c] = fixed(t.bytes + 8 + 4 * k);
    }
    const double *const known[] = {ibl_primaries_xy(IBL_PRIMARIES_REC709),
                                   ibl_display_p3_xy(),
                                   ibl_primaries_xy(IBL_PRIMARIES_REC2020)};
    for (int i = 0; i < 3; i++)
        if (has_colorants(xyz, known[i])) {
            memcpy(xy, known[i], 8 * sizeof *xy);
            return true;
        }
    return false;
}
