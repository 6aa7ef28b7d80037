/* SPDX-License-Identifier: MIT */
#include "io/ultra_hdr.h"

#include <math.h>
#include <stdint.h>
#include <string.h>
#include <strings.h>

#include "io/input.h"

/* Formulas stay within floats, and no map is brighter than this times SDR. */
static const double most_log2 = 24;

static const char *check(const ibl_gain_map *g)
{
    for (int c = 0; c < 3; c++) {
        if (!(fabs(g->min[c]) <= most_log2) ||
            !(fabs(g->max[c]) <= most_log2) || g->min[c] > g->max[c])
            return "its gains are not a range";
        if (!(g->gamma[c] > 0.001) || !(g->gamma[c] <= 1000))
            return "its gamma is not above 0";
        if (!(fabs(g->base_offset[c]) <= 1) || !(fabs(g->offset[c]) <= 1))
            return "an offset is not from -1 to 1";
    }
    return NULL;
}

/* ---- XMP -------------------------------------------------------------- */

/* The numbers of a property, an attribute or what is between the tags of an
 * element: 1 or 3, and 0 if it is not there, -1 if it is something else. */
static int take_property(char *xmp, const char *name, double value[3])
{
    char *t = strstr(xmp, name);
    int count = 0;

    if (!t)
        return 0;
    t += strlen(name);
    t += strspn(t, " \t\r\n");
    if (*t == '=') {
        t += strspn(t, "=\"' \t\r\n");
        count = ibl_take_number(&t, value);
    } else if (*t == '>') {
        const char *end = strstr(t, name);
        while (end && t < end && count < 3) {
            t += strspn(t, "> \t\r\n");
            if (*t == '<')
                t += strcspn(t, ">");
            else if (!ibl_take_number(&t, &value[count++]))
                return -1;
        }
    }
    if (count == 1)
        value[1] = value[2] = value[0];
    return count == 1 || count == 3 ? count : -1;
}

const char *ibl_gain_map_of_xmp(char *xmp, ibl_gain_map *g)
{
    double unused[3];
    struct {
        const char *name;
        double *value;
        bool needed;
    } const all[] = {
        {"hdrgm:GainMapMin", g->min, false},
        {"hdrgm:GainMapMax", g->max, true},
        {"hdrgm:Gamma", g->gamma, false},
        {"hdrgm:OffsetSDR", g->base_offset, false},
        {"hdrgm:OffsetHDR", g->offset, false},
        {"hdrgm:HDRCapacityMax", unused, true},
    };
    const char *is_hdr = strstr(xmp, "hdrgm:BaseRenditionIsHDR");

    *g = (ibl_gain_map){.of_base_space = true};
    for (int c = 0; c < 3; c++) {
        g->gamma[c] = 1;
        g->base_offset[c] = g->offset[c] = 1 / 64.;
    }
    if (is_hdr &&
        !strncasecmp(is_hdr + 24 + strspn(is_hdr + 24, "=\"'> \t"), "true", 4))
        return "its base is the HDR picture";
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        const int count = take_property(xmp, all[i].name, all[i].value);
        if (count < 0 || (!count && all[i].needed))
            return "a property that is needed is missing or no number";
    }
    return check(g);
}

/* ---- ISO 21496-1 ------------------------------------------------------ */

enum {
    MULTICHANNEL = 128,
    BASE_SPACE = 64,
    BACKWARD = 4, /* as libultrahdr writes: the base is the HDR picture */
    ONE_DENOMINATOR = 8
};

typedef struct reader {
    const unsigned char *at, *end;
    uint32_t denominator; /* of all; 0: each has its own */
    bool bad;
} reader;

static uint32_t take_word(reader *r)
{
    if (r->end - r->at < 4) {
        r->bad = true;
        return 1;
    }
    r->at += 4;
    return (uint32_t)r->at[-4] << 24 | (uint32_t)r->at[-3] << 16 |
           (uint32_t)r->at[-2] << 8 | r->at[-1];
}

static double take_fraction(reader *r, bool is_signed)
{
    const uint32_t n = take_word(r);
    const uint32_t d = r->denominator ? r->denominator : take_word(r);

    r->bad |= !d;
    return (is_signed ? (double)(int32_t)n : (double)n) / (d ? d : 1);
}

const char *ibl_gain_map_of_iso(const unsigned char *bytes, size_t size,
                                ibl_gain_map *g)
{
    reader r = {bytes + 5, bytes + size, 0, false};

    *g = (ibl_gain_map){.of_base_space = true};
    if (size < 5)
        return "its metadata is cut short";
    if (bytes[0] || bytes[1])
        return "its metadata is of a version that is not known";
    const int flags = bytes[4], channels = flags & MULTICHANNEL ? 3 : 1;
    g->of_base_space = flags & BASE_SPACE;
    if (flags & ONE_DENOMINATOR) {
        r.denominator = take_word(&r);
        r.bad |= !r.denominator;
    }
    const double base = take_fraction(&r, false);
    const double alternate = take_fraction(&r, false);
    for (int c = 0; c < 3; c++) {
        const int from = c < channels ? c : 0;
        g->min[c] = c == from ? take_fraction(&r, true) : g->min[0];
        g->max[c] = c == from ? take_fraction(&r, true) : g->max[0];
        g->gamma[c] = c == from ? take_fraction(&r, false) : g->gamma[0];
        g->base_offset[c] =
            c == from ? take_fraction(&r, true) : g->base_offset[0];
        g->offset[c] = c == from ? take_fraction(&r, true) : g->offset[0];
    }
    if (r.bad)
        return "its metadata is cut short or has a denominator of 0";
    if (flags & BACKWARD || base > alternate)
        return "its base is the HDR picture";
    return check(g);
}
