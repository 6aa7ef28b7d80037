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

/* ---- the index of pictures -------------------------------------------- */

static uint32_t get(const segment *s, size_t at, int count)
{
    const bool big = s->bytes[0] == 'M';
    uint32_t n = 0;

    for (int i = 0; i < count; i++)
        n = n << 8 | s->bytes[at + (size_t)(big ? i : count - 1 - i)];
    return n;
}

/* Offset in the index of the list of pictures, and their number; 0: none. */
static size_t find_pictures(const segment *s, uint32_t *count)
{
    const size_t ifd = s->size >= 8 ? get(s, 4, 4) : 0;
    const uint32_t entries = ifd && ifd + 2 <= s->size ? get(s, ifd, 2) : 0;

    for (size_t i = 0; i < entries; i++) {
        const size_t at = ifd + 2 + 12 * i;
        if (at + 12 > s->size)
            break;
        if (get(s, at, 2) != 0xb002)
            continue;
        const size_t list = get(s, at + 8, 4), bytes = get(s, at + 4, 4);
        *count = (uint32_t)(bytes / 16);
        return list <= s->size && bytes <= s->size - list ? list : 0;
    }
    return 0;
}

/* What the second picture says of itself. */
typedef enum second_kind {
    NO_GAIN_MAP,
    ANDROID,
    ISO
} second_kind;

typedef struct second {
    const unsigned char *bytes;
    size_t size;
    second_kind kind;
    segment text;
} second;

static second_kind kind_of(second *s)
{
    s->text = find_segment(s->bytes, s->size, 0xe2, iso_name, 0);
    if (s->text.size > 4)
        return ISO;
    for (int i = 0; i < 8; i++) {
        s->text = find_segment(s->bytes, s->size, 0xe1, xmp_name, i);
        /* its end is no 0, so that strstr cannot be used */
        for (size_t k = 0; k + 17 <= s->text.size; k++)
            if (!memcmp(s->text.bytes + k, "hdrgm:GainMapMax", 16))
                return ANDROID;
    }
    return NO_GAIN_MAP;
}

/* Whether the first picture says that it has a gain map. */
static bool claims(const ibl_input *in)
{
    if (find_segment(in->bytes, in->size, 0xe2, iso_name, 0).size)
        return true;
    for (int i = 0; i < 8; i++) {
        const segment s = find_segment(in->bytes, in->size, 0xe1, xmp_name, i);
        for (size_t k = 0; k + 13 <= s.size; k++)
            if (!memcmp(s.bytes + k, "hdrgm:Version", 13))
                return true;
    }
    return false;
}

/* Finds the gain map among the pictures behind the first. */
static ibl_status find_second(const ibl_input *in, second *found)
{
    const segment s = find_segment(in->bytes, in->size, 0xe2, mpf_name, 0);
    uint32_t count = 0;
    const size_t list = find_pictures(&s, &count);

    *found = (second){0};
    for (uint32_t i = 1; list && i < count && i < 16; i++) {
        const size_t size = get(&s, list + 16 * i + 4, 4);
        const size_t at =
            (size_t)(s.bytes - in->bytes) + get(&s, list + 16 * i + 8, 4);
        if (at > in->size || size > in->size - at)
            return ibl_bad_file(in,
                                "Ultra HDR JPEG: its picture %u lies behind "
                                "the end of the file: it is cut short",
                                (unsigned)i + 1);
        *found = (second){.bytes = in->bytes + at, .size = size};
        found->kind =
            size > 4 && in->bytes[at] == 0xff && in->bytes[at + 1] == 0xd8
                ? kind_of(found)
                : NO_GAIN_MAP;
        if (found->kind)
            break;
    }
    if (!found->kind)
        ibl_warn(in->ctx,
                 "%s: says that it has a gain map, but none is in it: read as "
                 "a plain JPEG",
                 in->name);
    return IBL_OK;
}

/* ---- rows ------------------------------------------------------------- */

typedef struct hdr_rows {
    ibl_rows rows;
    ibl_rows *base;
    ibl_gain_map meaning;
    ibl_image gain; /* as in the file, 0..1 */
} hdr_rows;

typedef struct batch {
    hdr_rows *r;
    float *rgb;
    int first, count;
} batch;

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

static void brighten_row(const hdr_rows *r, int y, float *rgb)
{
    const ibl_gain_map *m = &r->meaning;

    for (int x = 0; x < r->rows.width; x++, rgb += 3) {
        double g[3];
        look_up(&r->gain, (x + 0.5) / r->rows.width, (y + 0.5) / r->rows.height,
                g);
        for (int c = 0; c < 3; c++) {
            const double share = pow(fmax(g[c], 0), 1 / m->gamma[c]);
            const double gain =
                exp2(m->min[c] + (m->max[c] - m->min[c]) * share);
            const double light = ((double)rgb[c] + m->base_offset[c]) * gain;
            rgb[c] = (float)fmax(light - m->offset[c], 0);
        }
    }
}

static void rows_job(void *arg, int job, int worker)
{
    const batch *b = arg;

    (void)worker;
    for (int y = job * ROWS; y < b->count && y < (job + 1) * ROWS; y++)
        brighten_row(b->r, b->first + y,
                     b->rgb + 3 * (size_t)b->r->rows.width * (size_t)y);
}

static ibl_status rows_read(ibl_rows *rows, int count, float *rgb,
                            uint32_t *most)
{
    hdr_rows *r = (hdr_rows *)rows;
    batch b = {r, rgb, rows->row, count};

    ibl_status status = ibl_rows_read(r->base, count, rgb, most);
    if (!status)
        status =
            ibl_run(rows->ctx, NULL, (count + ROWS - 1) / ROWS, rows_job, &b);
    return status ? status
                  : ibl_rows_look(rows->ctx, rgb, rows->width, count, most);
}

static void rows_close(ibl_rows *rows)
{
    hdr_rows *r = (hdr_rows *)rows;
    ibl_rows_close(r->base);
    ibl_image_free(&r->gain);
    ibl_free(r);
}

/* ---- opening ---------------------------------------------------------- */

static ibl_status open_jpeg(const ibl_input *in, const ibl_read_options *opts,
                            const char *kind, bool encoded, ibl_rows **rows)
{
    ibl_bridge_source source = {
        .in = in, .request = {.reader = "jpeg", .encoded = encoded}};

    snprintf(source.kind, sizeof source.kind, "%s", kind);
    return ibl_bridge_rows(&source, opts, rows);
}

static ibl_status read_gain(hdr_rows *r, const ibl_input *in, const second *s)
{
    const ibl_input part = ibl_input_of(in->ctx, in->name, s->bytes, s->size);
    const ibl_read_options opts = {.part = -1, .any_aspect = 1};
    ibl_rows *rows = NULL;
    uint32_t *most = NULL;

    ibl_status status =
        open_jpeg(&part, &opts, "JPEG of a gain map", true, &rows);
    if (!status && ((double)rows->width * rows->height >
                    4.0 * r->rows.width * r->rows.height))
        status = ibl_bad_file(in,
                              "Ultra HDR JPEG: its gain map of %dx%d is "
                              "larger than its picture",
                              rows->width, rows->height);
    if (!status) {
        rows->silent = true;
        most = ibl_alloc_array((size_t)rows->height, sizeof *most);
        status =
            most ? ibl_image_alloc(in->ctx, rows->width, rows->height, &r->gain)
                 : ibl_no_memory(in->ctx, "a gain map");
    }
    if (!status)
        status = ibl_rows_read(rows, rows->height, r->gain.data, most);
    ibl_free(most);
    ibl_rows_close(rows);
    return status;
}

static ibl_status read_meaning(const ibl_input *in, const second *s,
                               ibl_gain_map *g)
{
    const char *why;

    if (s->kind == ISO) {
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

static ibl_status read_profile(const ibl_input *in, ibl_rows *rows)
{
    unsigned char *icc;
    size_t size;
    ibl_status status = join_icc(in, &icc, &size);

    rows->has_primaries = icc && ibl_icc_primaries(icc, size, rows->primaries);
    if (icc && !rows->has_primaries)
        status = ibl_unsupported(
            in, "Ultra HDR JPEG with an ICC profile that is none of sRGB, "
                "Display P3 and Rec. 2020 with the curve of sRGB");
    ibl_free(icc);
    return status;
}

static ibl_status open_parts(hdr_rows *r, const ibl_input *in,
                             const ibl_read_options *opts, const second *s)
{
    ibl_status status = read_meaning(in, s, &r->meaning);
    if (!status)
        status = read_profile(in, &r->rows);
    if (!status)
        status = open_jpeg(in, opts, "Ultra HDR JPEG", false, &r->base);
    if (status)
        return status;
    r->base->silent = true;
    r->rows.width = r->base->width;
    r->rows.height = r->base->height;
    r->rows.orientation = r->base->orientation;
    r->rows.report.bridged = 1;
    snprintf(r->rows.report.format, sizeof r->rows.report.format,
             "Ultra HDR JPEG, gain map of %s",
             s->kind == ISO ? "ISO 21496-1" : "Android");
    return read_gain(r, in, s);
}

ibl_status ibl_ultra_hdr_open(const ibl_input *in, const ibl_read_options *opts,
                              ibl_rows **rows)
{
    second s;

    *rows = NULL;
    if (!claims(in))
        return IBL_OK;
    ibl_status status = find_second(in, &s);
    if (status || !s.kind)
        return status;
    hdr_rows *r = ibl_alloc_zeroed(1, sizeof *r);
    if (!r)
        return ibl_no_memory(in->ctx, "an Ultra HDR JPEG");
    r->rows =
        (ibl_rows){.ctx = in->ctx, .read = rows_read, .close = rows_close};
    status = open_parts(r, in, opts, &s);
    if (status)
        ibl_rows_close(&r->rows);
    else
        *rows = &r->rows;
    return status;
}
