/* SPDX-License-Identifier: MIT */
/*
 * Ultra HDR JPEG: a JPEG of what a plain screen shows, and a second one, the
 * gain map, that says how much brighter each pixel is. The second is found by
 * the index of the Multi-Picture Format (CIPA DC-007).
 */
#define _GNU_SOURCE /* memmem */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/bridge.h"
#include "io/colour_space.h"
#include "io/rows.h"

enum {
    ROWS = 8 /* in a job */
};

static const char xmp_name[] = "http://ns.adobe.com/xap/1.0/";
static const char iso_name[] = "urn:iso:std:iso:ts:21496:-1";
static const char icc_name[] = "ICC_PROFILE";
static const char mpf_name[] = "MPF";

/* ---- segments of a JPEG: ITU T.81, annex B ---------------------------- */

typedef struct segment {
    const unsigned char *bytes; /* behind its name */
    size_t size;
} segment;

/* An integer of some bytes at an offset; 0 beyond the end. */
static uint32_t number(const segment *s, size_t at, int count, bool little)
{
    uint32_t n = 0;

    for (int i = 0; i < count && at + (size_t)count <= s->size; i++)
        n = n << 8 | s->bytes[at + (size_t)(little ? count - 1 - i : i)];
    return n;
}

/* Finds the first segment APPn of a name before the picture that has a word;
 * size 0: none. */
static segment find_segment(const unsigned char *jpeg, size_t size, int marker,
                            const char *name, const char *word)
{
    const size_t length = strlen(name) + 1;

    for (size_t at = 2; at + 4 <= size && jpeg[at] == 0xff;) {
        const size_t bytes = (size_t)jpeg[at + 2] << 8 | jpeg[at + 3];
        const unsigned char *body = jpeg + at + 4;
        if (jpeg[at + 1] == 0xda || bytes < 2 || bytes > size - at - 2)
            break;
        if (jpeg[at + 1] == marker && bytes - 2 > length &&
            !memcmp(body, name, length) &&
            memmem(body + length, bytes - 2 - length, word, strlen(word)))
            return (segment){body + length, bytes - 2 - length};
        at += 2 + bytes;
    }
    return (segment){0};
}

/* ---- what a gain map means -------------------------------------------- */

/* The metadata of Android ("Ultra HDR Image Format v1.1", XMP properties
 * hdrgm:) and of ISO 21496-1 (binary). HDR = (SDR + base_offset) * 2^(min +
 * (max - min) g^(1 / gamma)) - offset, for a display that shows all of it; g is
 * 0..1. */
typedef struct gain_map {
    double min[3], max[3]; /* log2 of the gain */
    double gamma[3];
    double base_offset[3], offset[3];
    bool of_base_space; /* gains are of the base image's colour space */
} gain_map;

/* Formulas stay within floats, and no map is brighter than this times SDR. */
static const double most_log2 = 24;

/* The numbers of a property, 1 or 3: an attribute, or what is between the tags
 * of an element. False: it is something else; true also if it is not there. */
static bool take_property(char *xmp, const char *name, double value[3])
{
    char *t = strstr(xmp, name);
    int count = 0;

    if (!t)
        return true;
    t += strlen(name);
    t += strspn(t, " \t\r\n");
    if (*t == '=') {
        t += strspn(t, "=\"' \t\r\n");
        count = ibl_take_number(&t, value);
    }
    const char *end = *t == '>' ? strstr(t, name) : NULL;
    while (end && t < end && count < 3) {
        t += strspn(t, "> \t\r\n");
        if (*t == '<')
            t += strcspn(t, ">");
        else if (!ibl_take_number(&t, &value[count++]))
            return false;
    }
    if (count == 1)
        value[1] = value[2] = value[0];
    return count == 1 || count == 3;
}

static const char *take_xmp(char *xmp, gain_map *g)
{
    const struct {
        const char *name;
        double *value;
    } all[] = {{"hdrgm:GainMapMin", g->min},
               {"hdrgm:GainMapMax", g->max},
               {"hdrgm:Gamma", g->gamma},
               {"hdrgm:OffsetSDR", g->base_offset},
               {"hdrgm:OffsetHDR", g->offset}};
    const char *is_hdr = strstr(xmp, "hdrgm:BaseRenditionIsHDR");

    *g = (gain_map){.of_base_space = true};
    for (int c = 0; c < 3; c++) {
        g->gamma[c] = 1;
        g->base_offset[c] = g->offset[c] = 1 / 64.;
    }
    if (is_hdr &&
        !strncasecmp(is_hdr + 24 + strspn(is_hdr + 24, "=\"'> \t"), "true", 4))
        return "its base is the HDR picture";
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        if (!take_property(xmp, all[i].name, all[i].value))
            return "a property is no number";
    return NULL;
}

/* Flags of ISO 21496-1. */
enum {
    MULTICHANNEL = 128,
    BASE_SPACE = 64,
    BACKWARD = 4, /* as libultrahdr writes: the base is the HDR picture */
    ONE_DENOMINATOR = 8
};

/* Reads a fraction at *at, whose denominator follows it unless all have one. */
static double take_fraction(const segment *s, size_t *at, uint32_t denominator,
                            bool is_signed, bool *bad)
{
    const uint32_t n = number(s, *at, 4, false);
    const uint32_t d = denominator ? denominator : number(s, *at + 4, 4, false);

    *at += denominator ? 4 : 8;
    *bad |= !d || *at > s->size;
    return (is_signed ? (double)(int32_t)n : (double)n) / (d ? d : 1);
}

static const char *take_iso(const segment *s, gain_map *g)
{
    double *const all[] = {g->min, g->max, g->gamma, g->base_offset, g->offset};
    const int flags = (int)number(s, 4, 1, false);
    const int channels = flags & MULTICHANNEL ? 3 : 1;
    const bool one = flags & ONE_DENOMINATOR;
    const uint32_t d = one ? number(s, 5, 4, false) : 0;
    size_t at = one ? 9 : 5;
    bool bad = one && !d;

    if (number(s, 0, 2, false))
        return "its metadata is of a version that is not known";
    *g = (gain_map){.of_base_space = flags & BASE_SPACE};
    const double base = take_fraction(s, &at, d, false, &bad);
    const double alternate = take_fraction(s, &at, d, false, &bad);
    for (int i = 0; i < 15; i++) {
        const int c = i / 5, k = i % 5;
        all[k][c] =
            c < channels ? take_fraction(s, &at, d, k != 2, &bad) : all[k][0];
    }
    if (bad)
        return "its metadata is cut short or has a denominator of 0";
    if (flags & BACKWARD || base > alternate)
        return "its base is the HDR picture";
    return NULL;
}

/* ---- profiles ----------------------------------------------------------- */

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

/* A tag of at least 12 bytes; size 0: there is none. */
static segment find_tag(const segment *icc, const char *name)
{
    const uint32_t count = number(icc, 128, 4, false);

    for (size_t i = 0; i < count && 144 + 12 * i <= icc->size; i++) {
        const size_t at = number(icc, 136 + 12 * i, 4, false);
        const size_t length = number(icc, 140 + 12 * i, 4, false);
        if (!memcmp(icc->bytes + 132 + 12 * i, name, 4) && at <= icc->size &&
            length <= icc->size - at && length >= 12)
            return (segment){icc->bytes + at, length};
    }
    return (segment){0};
}

bool ibl_icc_primaries(const unsigned char *bytes, size_t size, double xy[8])
{
    static const char *const colorants[] = {"rXYZ", "gXYZ", "bXYZ"};
    const segment icc = {bytes, size};
    bool same[3] = {true, true, true};

    for (int i = 0; i < 9; i++) {
        const segment t = find_tag(&icc, colorants[i / 3]);
        const size_t at = (size_t)(8 + 4 * (i % 3));
        const double value = (int32_t)number(&t, at, 4, false) / 65536.0;
        for (int k = 0; k < 3; k++)
            same[k] &= fabs(value - spaces[k].xyz[i]) < 0.003;
    }
    for (int k = 0; k < 3; k++)
        if (same[k]) {
            memcpy(xy,
                   spaces[k].primaries ? ibl_primaries_xy(spaces[k].primaries)
                                       : ibl_khronos_xy(10),
                   8 * sizeof *xy);
            return true;
        }
    return false;
}

/* ---- the second picture ------------------------------------------------ */

typedef struct second {
    const unsigned char *bytes;
    size_t size;
    segment text; /* what says how much brighter; size 0: no gain map */
    bool iso;     /* by ISO 21496-1, not by Android's XMP */
} second;

/* Finds the gain map among the pictures behind the first, by the entry of the
 * index that lists them. */
static ibl_status find_second(const ibl_input *in, second *found)
{
    const segment s = find_segment(in->bytes, in->size, 0xe2, mpf_name, "");
    const bool little = s.size && *s.bytes == 'I';
    const size_t ifd = s.size >= 8 ? number(&s, 4, 4, little) : 0;
    const uint32_t entries = ifd ? number(&s, ifd, 2, little) : 0;
    size_t list = 0, count = 0;

    *found = (second){0};
    for (size_t i = 0; i < entries && ifd + 14 + 12 * i <= s.size; i++)
        if (number(&s, ifd + 2 + 12 * i, 2, little) == 0xb002) {
            count = number(&s, ifd + 6 + 12 * i, 4, little) / 16;
            list = number(&s, ifd + 10 + 12 * i, 4, little);
        }
    for (size_t i = 1; i < count && i < 16 && list + 16 * i + 12 <= s.size &&
                       !found->text.size;
         i++) {
        const size_t size = number(&s, list + 16 * i + 4, 4, little);
        const size_t at = (size_t)(s.bytes - in->bytes) +
                          number(&s, list + 16 * i + 8, 4, little);
        if (at > in->size || size > in->size - at)
            return ibl_bad_file(in,
                                "Ultra HDR JPEG: its picture %zu lies behind "
                                "the end of the file: it is cut short",
                                i + 1);
        *found = (second){.bytes = in->bytes + at, .size = size};
        if (size <= 4 || memcmp(found->bytes, "\xff\xd8", 2) != 0)
            continue;
        found->text = find_segment(found->bytes, size, 0xe2, iso_name, "");
        found->iso = found->text.size > 4;
        if (!found->iso)
            found->text = find_segment(found->bytes, size, 0xe1, xmp_name,
                                       "hdrgm:GainMapMax");
    }
    return IBL_OK;
}

static ibl_status read_meaning(const ibl_input *in, const second *s,
                               gain_map *g)
{
    char *text = ibl_alloc_zeroed(s->text.size + 1, 1);

    if (!text)
        return ibl_no_memory(in->ctx, "the text of a gain map");
    memcpy(text, s->text.bytes, s->text.size);
    const char *why = s->iso ? take_iso(&s->text, g) : take_xmp(text, g);
    ibl_free(text);
    for (int c = 0; c < 3 && !why; c++)
        if (!(fabs(g->min[c]) <= most_log2) ||
            !(fabs(g->max[c]) <= most_log2) || g->min[c] > g->max[c] ||
            !(g->gamma[c] > 0.001) || !(g->gamma[c] <= 1000) ||
            !(fabs(g->base_offset[c]) <= 1) || !(fabs(g->offset[c]) <= 1))
            why = "its gains, gamma or offsets are out of range";
    if (!why && !g->of_base_space &&
        find_segment(s->bytes, s->size, 0xe2, icc_name, "").size)
        why = "it has a colour space of its own";
    return why ? ibl_unsupported(in,
                                 "Ultra HDR JPEG whose gain map cannot be "
                                 "used: %s",
                                 why)
               : IBL_OK;
}

/* ---- the picture -------------------------------------------------------- */

typedef struct brightening {
    const gain_map *meaning;
    const ibl_image *gain; /* as in the file, 0..1 */
    const ibl_image *img;
} brightening;

/* The gain map at a place, by bilinear interpolation of what the file has;
 * columns wrap. */
static void look_up(const ibl_image *map, double x, double y, double g[3])
{
    const double u = x * map->width - 0.5, v = y * map->height - 0.5;
    const int x0 = (int)floor(u), y0 = (int)floor(v);
    const double fx = u - x0, fy = v - y0;
    const int columns[2] = {(x0 + map->width) % map->width,
                            (x0 + 1) % map->width};
    const int lines[2] = {y0 < 0 ? 0 : y0,
                          y0 + 1 < map->height ? y0 + 1 : map->height - 1};

    g[0] = g[1] = g[2] = 0;
    for (int i = 0; i < 4; i++) {
        const float *p =
            map->data + 3 * ((size_t)map->width * (size_t)lines[i / 2] +
                             (size_t)columns[i % 2]);
        const double weight = (i % 2 ? fx : 1 - fx) * (i / 2 ? fy : 1 - fy);
        for (int c = 0; c < 3; c++)
            g[c] += weight * (double)p[c];
    }
}

static void rows_job(void *arg, int job, int worker)
{
    const brightening *b = arg;
    const gain_map *m = b->meaning;
    const int width = b->img->width, height = b->img->height;

    (void)worker;
    for (int y = job * ROWS; y < height && y < (job + 1) * ROWS; y++) {
        float *rgb = b->img->data + 3 * (size_t)width * (size_t)y;
        for (int x = 0; x < width; x++, rgb += 3) {
            double g[3];
            look_up(b->gain, (x + 0.5) / width, (y + 0.5) / height, g);
            for (int c = 0; c < 3; c++) {
                const double share = pow(fmax(g[c], 0), 1 / m->gamma[c]);
                const double gain =
                    exp2(m->min[c] + (m->max[c] - m->min[c]) * share);
                const double light =
                    ((double)rgb[c] + m->base_offset[c]) * gain;
                rgb[c] = (float)fmax(light - m->offset[c], 0);
            }
        }
    }
}

/* Makes the picture of a plain screen, in rows, what a screen without limits
 * shows. */
static ibl_status brighten(const ibl_input *in, const second *s,
                           const gain_map *meaning, ibl_rows *rows)
{
    const ibl_read_options opts = {
        .part = -1, .any_aspect = 1, .transfer = IBL_TRANSFER_LINEAR};
    ibl_input part = ibl_input_of(in->ctx, in->name, s->bytes, s->size);
    ibl_rows *gain = NULL;

    ibl_status status = ibl_other_image_open(&part, &opts, &gain);
    if (!status &&
        (double)gain->width * gain->height > 4.0 * rows->width * rows->height)
        status = ibl_bad_file(in,
                              "Ultra HDR JPEG: its gain map of %dx%d is "
                              "larger than its picture",
                              gain->width, gain->height);
    if (!status) {
        brightening b = {meaning, &gain->whole, &rows->whole};
        status = ibl_run(in->ctx, NULL, (rows->height + ROWS - 1) / ROWS,
                         rows_job, &b);
    }
    ibl_rows_close(gain);
    return status;
}

ibl_status ibl_jpeg_open(ibl_input *in, const ibl_read_options *opts,
                         ibl_rows **rows)
{
    ibl_read_options own = *opts;
    gain_map meaning;
    double primaries[8];
    second s = {0};
    ibl_status status = ibl_input_load(in);

    if (status)
        return status;
    if (!find_segment(in->bytes, in->size, 0xe2, iso_name, "").size &&
        !find_segment(in->bytes, in->size, 0xe1, xmp_name, "hdrgm:Version")
             .size)
        return ibl_other_image_open(in, opts, rows);
    status = find_second(in, &s);
    if (!status && !s.text.size) {
        ibl_warn(in->ctx,
                 "%s: says that it has a gain map, but none is in it: read as "
                 "a plain JPEG",
                 in->name);
        return ibl_other_image_open(in, opts, rows);
    }
    if (!status)
        status = read_meaning(in, &s, &meaning);
    if (status)
        return status;
    /* a profile of such colours fits into one segment, behind its number */
    const segment icc = find_segment(in->bytes, in->size, 0xe2, icc_name, "");
    const bool known =
        icc.size > 2 &&
        ibl_icc_primaries(icc.bytes + 2, icc.size - 2, primaries);
    if (icc.size && !known)
        return ibl_unsupported(
            in, "Ultra HDR JPEG with an ICC profile that is none of sRGB, "
                "Display P3 and Rec. 2020");
    own.transfer = IBL_TRANSFER_SRGB;
    status = ibl_other_image_open(in, &own, rows);
    if (!status)
        status = brighten(in, &s, &meaning, *rows);
    if (status)
        return status;
    ibl_read_report *report = &(*rows)->report;
    report->has_primaries = known;
    if (known)
        memcpy(report->primaries, primaries, sizeof primaries);
    report->low_range = 0;
    snprintf(report->format, sizeof report->format,
             "Ultra HDR JPEG, gain map of %s",
             s.iso ? "ISO 21496-1" : "Android");
    return IBL_OK;
}
