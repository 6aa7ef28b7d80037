/* SPDX-License-Identifier: MIT */
#include "io/ultra_hdr.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/bridge.h"

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

/* Finds the nth segment APPn of a name before the picture; size 0: none. */
static segment find_segment(const unsigned char *jpeg, size_t size, int marker,
                            const char *name, int nth)
{
    const size_t length = strlen(name) + 1;

    for (size_t at = 2; at + 4 <= size && jpeg[at] == 0xff;) {
        const size_t bytes = (size_t)jpeg[at + 2] << 8 | jpeg[at + 3];
        const unsigned char *body = jpeg + at + 4;
        if (jpeg[at + 1] == 0xda || bytes < 2 || bytes > size - at - 2)
            break;
        if (jpeg[at + 1] == marker && bytes - 2 > length &&
            !memcmp(body, name, length) && !nth--)
            return (segment){body + length, bytes - 2 - length};
        at += 2 + bytes;
    }
    return (segment){0};
}

/* The first segment of XMP that has a word; size 0: none. */
static segment find_xmp(const unsigned char *jpeg, size_t size,
                        const char *word)
{
    const size_t length = strlen(word);

    for (int i = 0; i < 8; i++) {
        const segment s = find_segment(jpeg, size, 0xe1, xmp_name, i);
        /* its end is no 0, so that strstr cannot be used */
        for (size_t k = 0; k + length <= s.size; k++)
            if (!memcmp(s.bytes + k, word, length))
                return s;
    }
    return (segment){0};
}

/* Joins the parts of an ICC profile, each behind its number and their count.
 * The caller must free *icc; NULL: there is none. */
static ibl_status join_icc(const ibl_input *in, unsigned char **icc,
                           size_t *total)
{
    *icc = NULL;
    *total = 0;
    for (int pass = 0; pass < 2; pass++) {
        size_t done = 0;
        for (int i = 0; i < 255; i++) {
            const segment s =
                find_segment(in->bytes, in->size, 0xe2, icc_name, i);
            if (s.size < 2)
                break;
            if (pass)
                memcpy(*icc + done, s.bytes + 2, s.size - 2);
            done += s.size - 2;
        }
        *total = done;
        if (!done || pass)
            break;
        *icc = ibl_alloc_array(done, 1);
        if (!*icc)
            return ibl_no_memory(in->ctx, "an ICC profile");
    }
    return IBL_OK;
}

/* ---- the second picture ------------------------------------------------ */

typedef struct second {
    const unsigned char *bytes;
    size_t size;
    segment text; /* what says how much brighter; size 0: no gain map */
    bool iso;     /* by ISO 21496-1, not by Android's XMP */
} second;

static uint32_t get(const segment *s, size_t at, int count)
{
    const bool big = s->bytes[0] == 'M';
    uint32_t n = 0;

    for (int i = 0; i < count && at + (size_t)count <= s->size; i++)
        n = n << 8 | s->bytes[at + (size_t)(big ? i : count - 1 - i)];
    return n;
}

/* Finds the gain map among the pictures behind the first, by the entry of the
 * index that lists them. */
static ibl_status find_second(const ibl_input *in, second *found)
{
    const segment s = find_segment(in->bytes, in->size, 0xe2, mpf_name, 0);
    const size_t ifd = s.size >= 8 ? get(&s, 4, 4) : 0;
    const uint32_t entries = ifd ? get(&s, ifd, 2) : 0;
    size_t list = 0, count = 0;

    *found = (second){0};
    for (size_t i = 0; i < entries && ifd + 14 + 12 * i <= s.size; i++)
        if (get(&s, ifd + 2 + 12 * i, 2) == 0xb002) {
            count = get(&s, ifd + 6 + 12 * i, 4) / 16;
            list = get(&s, ifd + 10 + 12 * i, 4);
        }
    for (size_t i = 1; i < count && i < 16 && list + 16 * i + 12 <= s.size &&
                       !found->text.size;
         i++) {
        const size_t size = get(&s, list + 16 * i + 4, 4);
        const size_t at =
            (size_t)(s.bytes - in->bytes) + get(&s, list + 16 * i + 8, 4);
        if (at > in->size || size > in->size - at)
            return ibl_bad_file(in,
                                "Ultra HDR JPEG: its picture %zu lies behind "
                                "the end of the file: it is cut short",
                                i + 1);
        *found = (second){.bytes = in->bytes + at, .size = size};
        if (size <= 4 || memcmp(found->bytes, "\xff\xd8", 2) != 0)
            continue;
        found->text = find_segment(found->bytes, size, 0xe2, iso_name, 0);
        found->iso = found->text.size > 4;
        if (!found->iso)
            found->text = find_xmp(found->bytes, size, "hdrgm:GainMapMax");
    }
    return IBL_OK;
}

static ibl_status read_meaning(const ibl_input *in, const second *s,
                               ibl_gain_map *g)
{
    const char *why;

    if (s->iso) {
        why = ibl_gain_map_of_iso(s->text.bytes, s->text.size, g);
    } else {
        char *text = ibl_alloc_array(s->text.size + 1, 1);
        if (!text)
            return ibl_no_memory(in->ctx, "the text of a gain map");
        memcpy(text, s->text.bytes, s->text.size);
        text[s->text.size] = '\0';
        why = ibl_gain_map_of_xmp(text, g);
        ibl_free(text);
    }
    if (!why && !g->of_base_space &&
        find_segment(s->bytes, s->size, 0xe2, icc_name, 0).size)
        why = "it has a colour space of its own";
    return why ? ibl_unsupported(in,
                                 "Ultra HDR JPEG whose gain map cannot be "
                                 "used: %s",
                                 why)
               : IBL_OK;
}

/* ---- the picture -------------------------------------------------------- */

typedef struct brightening {
    const ibl_gain_map *meaning;
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
    const ibl_gain_map *m = b->meaning;
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
                           const ibl_gain_map *meaning, ibl_rows *rows)
{
    const ibl_read_options opts = {
        .part = -1, .any_aspect = 1, .transfer = IBL_TRANSFER_LINEAR};
    ibl_input part = ibl_input_of(in->ctx, in->name, s->bytes, s->size);
    ibl_rows *gain = NULL;

    ibl_status status = ibl_other_image_open(&part, &opts, &gain);
    if (status)
        return status;
    brightening b = {meaning, &gain->whole, &rows->whole};
    if ((double)gain->width * gain->height > 4.0 * rows->width * rows->height)
        status = ibl_bad_file(in,
                              "Ultra HDR JPEG: its gain map of %dx%d is "
                              "larger than its picture",
                              gain->width, gain->height);
    else
        status = ibl_run(in->ctx, NULL, (rows->height + ROWS - 1) / ROWS,
                         rows_job, &b);
    ibl_rows_close(gain);
    return status;
}

ibl_status ibl_jpeg_open(ibl_input *in, const ibl_read_options *opts,
                         ibl_rows **rows)
{
    ibl_read_options own = *opts;
    ibl_gain_map meaning;
    double primaries[8];
    unsigned char *icc;
    size_t size;
    second s = {0};
    ibl_status status = ibl_input_load(in);

    if (status)
        return status;
    if (!find_segment(in->bytes, in->size, 0xe2, iso_name, 0).size &&
        !find_xmp(in->bytes, in->size, "hdrgm:Version").size)
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
    if (!status)
        status = join_icc(in, &icc, &size);
    if (status)
        return status;
    const bool profile = icc != NULL;
    const bool known = profile && ibl_icc_primaries(icc, size, primaries);
    ibl_free(icc);
    if (profile && !known)
        return ibl_unsupported(
            in, "Ultra HDR JPEG with an ICC profile that is none of sRGB, "
                "Display P3 and Rec. 2020 with the curve of sRGB");
    own.transfer = IBL_TRANSFER_SRGB;
    status = ibl_other_image_open(in, &own, rows);
    if (!status)
        status = brighten(in, &s, &meaning, *rows);
    if (status) {
        ibl_rows_close(*rows);
        *rows = NULL;
        return status;
    }
    (*rows)->has_primaries = known;
    if (known)
        memcpy((*rows)->primaries, primaries, sizeof primaries);
    (*rows)->report.low_range = 0;
    snprintf((*rows)->report.format, sizeof(*rows)->report.format,
             "Ultra HDR JPEG, gain map of %s",
             s.iso ? "ISO 21496-1" : "Android");
    return IBL_OK;
}
