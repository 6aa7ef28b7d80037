/* SPDX-License-Identifier: MIT */
#include "io/ultra_hdr.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "io/colour_space.h"

/* The XYZ of red, green and blue, adapted to D50, as profiles have them. */
static const struct {
    ibl_primaries primaries;
    double xyz[9];
} spaces[] = {
    {IBL_PRIMARIES_REC709,
     {.4361, .2225, .0139, .3851, .7169, .0971, .1431, .0606, .7141}},
    {IBL_PRIMARIES_KEEP, /* Display P3 */
     {.5151, .2412, -.0011, .2920, .6922, .0419, .1572, .0666, .7841}},
    {IBL_PRIMARIES_REC2020,
     {.6735, .2790, -.0019, .1657, .6753, .0299, .1251, .0456, .7969}},
};

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

bool ibl_icc_primaries(const unsigned char *bytes, size_t size, double xy[8])
{
    static const char *const colorants[] = {"rXYZ", "gXYZ", "bXYZ"};
    static const char *const curves[] = {"rTRC", "gTRC", "bTRC"};
    bool same[3] = {true, true, true};

    for (int i = 0; i < 9; i++) {
        const tag t = find(bytes, size, colorants[i / 3]);
        const tag curve = find(bytes, size, curves[i / 3]);
        if (t.size < 20 || !(fabs(half_of(curve) - 0.2140) < 0.004))
            return false;
        const double value = fixed(t.bytes + 8 + 4 * (i % 3));
        for (int k = 0; k < 3; k++)
            same[k] &= fabs(value - spaces[k].xyz[i]) < 0.003;
    }
    for (int k = 0; k < 3; k++)
        if (same[k]) {
            memcpy(xy,
                   spaces[k].primaries ? ibl_primaries_xy(spaces[k].primaries)
                                       : ibl_display_p3_xy(),
                   8 * sizeof *xy);
            return true;
        }
    return false;
}
