/* SPDX-License-Identifier: MIT */
/* Single scanlines: where they end, and their pixels. */
#include "io/rgbe.h"

#include <string.h>

#include "core/context.h"

enum {
    MIN_NEW = 8, /* widths that the new run lengths are used for */
    MAX_NEW = 32767
};

bool ibl_rgbe_is(const void *bytes, size_t size)
{
    return size >= 2 && !memcmp(bytes, "#?", 2);
}

/* ---- passing them --------------------------------------------------- */

/* 2, 2 and a length: no pixel that was normalised looks so. */
static bool marks_new(const unsigned char *p, int width)
{
    return width >= MIN_NEW && width <= MAX_NEW && p[0] == 2 && p[1] == 2 &&
           p[2] < 128;
}

static bool marks_repeat(const unsigned char *p)
{
    return p[0] == 1 && p[1] == 1 && p[2] == 1;
}

/* Passes four components of runs and literals. Written without a branch on
 * which of the two it is, which no predictor could guess. */
static ibl_rgbe_fault pass_new(ibl_rgbe_scan *s)
{
    const unsigned char *bytes = s->bytes;
    size_t at = s->at + 4;

    for (int c = 0; c < 4; c++) {
        int left = s->width;
        while (left > 0) {
            if (at >= s->size)
                return IBL_RGBE_CUT;
            const int code = bytes[at];
            const int is_run = code > 128;
            left -= code - (-is_run & 128);
            at += (size_t)(is_run ? 2 : code + 1);
            if (!code)
                return IBL_RGBE_ZERO_RUN;
        }
        s->value = -left;
        if (left < 0)
            return IBL_RGBE_OVERRUN;
    }
    if (at > s->size)
        return IBL_RGBE_CUT;
    s->at = at;
    return IBL_RGBE_WHOLE;
}

/* Passes pixels and repeats (1, 1, 1, n) of the pixel before; consecutive
 * ones are the bytes of one count, the lowest first. The first pixel of a
 * scanline has none before it and is one, whatever it looks like. */
static ibl_rgbe_fault pass_old(ibl_rgbe_scan *s)
{
    const unsigned char *bytes = s->bytes;
    size_t at = s->at + 4;
    int left = s->width - 1, shift = 0;

    while (left > 0) {
        if (s->size - at < 4)
            return IBL_RGBE_CUT;
        if (!marks_repeat(bytes + at)) {
            if (shift && !s->value)
                return IBL_RGBE_ZERO_RUN;
            shift = 0;
            left--;
        } else {
            /* a fourth byte is beyond every width unless it is 0 */
            const int n = bytes[at + 3];
            const int count = shift < 24 ? n << shift : (n > 0) << 24;
            s->is_old = true;
            s->value = shift ? s->value + count : count;
            left -= count;
            if (shift >= 24 && !count)
                return IBL_RGBE_ZERO_RUN;
            shift += 8;
        }
        at += 4;
    }
    s->value = -left;
    if (left < 0)
        return IBL_RGBE_OVERRUN;
    s->at = at;
    return IBL_RGBE_WHOLE;
}

ibl_rgbe_fault ibl_rgbe_pass(ibl_rgbe_scan *s)
{
    const unsigned char *p = s->bytes + s->at;
    s->is_new = s->is_old = false;
    if (s->size - s->at < 4)
        return IBL_RGBE_CUT;
    if (!marks_new(p, s->width))
        return pass_old(s);
    s->is_new = true;
    s->value = p[2] << 8 | p[3];
    return s->value == s->width ? pass_new(s) : IBL_RGBE_BAD_LENGTH;
}

/* Two bytes for each byte of a pixel: new run lengths that never run. The old
 * ones take no more than four for a pixel, and 12 for zeros before a fault. */
size_t ibl_rgbe_most_bytes(const ibl_rgbe_header *h)
{
    return 8 * (size_t)h->row_px + 64;
}

ibl_status ibl_rgbe_report(const ibl_input *in, ibl_rgbe_fault f, int row,
                           const ibl_rgbe_header *h, int value)
{
    switch (f) {
    case IBL_RGBE_ZERO_RUN:
        return ibl_refuse(
            in, IBL_ERR_FORMAT,
            "scanline %d of %d has a run of no pixels: the file is damaged",
            row + 1, h->rows);
    case IBL_RGBE_OVERRUN:
        return ibl_refuse(in, IBL_ERR_FORMAT,
                          "scanline %d of %d has a run that ends %d pixels "
                          "beyond its %d: the file is damaged",
                          row + 1, h->rows, value, h->row_px);
    case IBL_RGBE_BAD_LENGTH:
        return ibl_refuse(in, IBL_ERR_FORMAT,
                          "scanline %d of %d says it has %d pixels, not %d: "
                          "the file is damaged",
                          row + 1, h->rows, value, h->row_px);
    case IBL_RGBE_WHOLE:
    case IBL_RGBE_CUT:
        break;
    }
    return ibl_refuse(
        in, IBL_ERR_FORMAT,
        "the file ends in scanline %d of %d: it is cut short: copy it again",
        row + 1, h->rows);
}

/* ---- their pixels ------------------------------------------------------ */

static size_t plane_bytes(const ibl_rgbe_header *h)
{
    return ((size_t)h->row_px + IBL_RGBE_SLACK + 63) / 64 * 64;
}

size_t ibl_rgbe_scratch(const ibl_rgbe_header *h)
{
    return 4 * plane_bytes(h);
}

/* Planes from pixels that follow each other, with repeats unless flat. */
static void split(const unsigned char *src, bool flat, int count,
                  unsigned char *planes, size_t stride)
{
    int i = 0, shift = 0;
    for (; i < count; src += 4) {
        if (flat || !i || !marks_repeat(src)) {
            for (int c = 0; c < 4; c++)
                planes[c * stride + i] = src[c];
            i++;
            shift = 0;
            continue;
        }
        const int n = src[3] << shift;
        for (int c = 0; c < 4; c++)
            memset(planes + c * stride + i, planes[c * stride + i - 1],
                   (size_t)n);
        i += n;
        shift += 8;
    }
}

static void apply_matrix(const float m[9], int count, float *px)
{
    for (int i = 0; i < count; i++, px += 3) {
        const float x = px[0], y = px[1], z = px[2];
        for (int c = 0; c < 3; c++)
            px[c] = m[3 * c] * x + m[3 * c + 1] * y + m[3 * c + 2] * z;
    }
}

void ibl_rgbe_row(const ibl_rgbe_dsp *dsp, const ibl_rgbe_header *h,
                  const unsigned char *src, bool flat, bool has_slack,
                  unsigned char *scratch, float *dst)
{
    const size_t stride = plane_bytes(h);

    if (flat || !marks_new(src, h->row_px)) {
        split(src, flat, h->row_px, scratch, stride);
    } else {
        src += 4;
        for (int c = 0; c < 4; c++)
            src = (has_slack ? dsp->expand : ibl_rgbe_expand_c)(
                src, h->row_px, scratch + c * stride);
    }
    dsp->to_rgb(scratch, stride, h->row_px, h->scale, dst);
    if (h->xyz)
        apply_matrix(h->matrix, h->row_px, dst);
}
