/* SPDX-License-Identifier: MIT */
#include "io/rgbe.h"

#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"

enum {
    MIN_NEW = 8, /* widths that the new run lengths are used for */
    MAX_NEW = 32767,
    JOB_PIXELS = 1 << 18, /* about a millisecond's work */
    JOB_COLUMNS = 8,      /* scanlines that are turned into columns at once */
    CHECK_ROWS = 256      /* scanlines between two looks at the cancel flag */
};

bool ibl_rgbe_is(const void *bytes, size_t size)
{
    return size >= 2 && !memcmp(bytes, "#?", 2);
}

/* ---- the index ------------------------------------------------------ */

struct scan {
    const unsigned char *bytes;
    size_t size, at;
    int width;
    bool is_new, is_old; /* the scanline that was passed last */
    int value;           /* of a fault */
};

typedef enum fault {
    NO_FAULT,
    CUT,       /* the file ends here */
    ZERO_RUN,  /* a run of no pixels */
    OVERRUN,   /* value pixels more than the scanline has */
    BAD_LENGTH /* a new scanline that says it has value pixels */
} fault;

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
static fault pass_new(struct scan *s)
{
    const unsigned char *bytes = s->bytes;
    size_t at = s->at + 4;

    for (int c = 0; c < 4; c++) {
        int left = s->width;
        while (left > 0) {
            if (at >= s->size)
                return CUT;
            const int code = bytes[at];
            const int is_run = code > 128;
            left -= code - (-is_run & 128);
            at += (size_t)(is_run ? 2 : code + 1);
            if (!code)
                return ZERO_RUN;
        }
        s->value = -left;
        if (left < 0)
            return OVERRUN;
    }
    if (at > s->size)
        return CUT;
    s->at = at;
    return NO_FAULT;
}

/* Passes pixels and repeats (1, 1, 1, n) of the pixel before; consecutive
 * ones are the bytes of one count, the lowest first. The first pixel of a
 * scanline has none before it and is one, whatever it looks like. */
static fault pass_old(struct scan *s)
{
    const unsigned char *bytes = s->bytes;
    size_t at = s->at + 4;
    int left = s->width - 1, shift = 0;

    while (left > 0) {
        if (s->size - at < 4)
            return CUT;
        if (!marks_repeat(bytes + at)) {
            if (shift && !s->value)
                return ZERO_RUN;
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
                return ZERO_RUN;
            shift += 8;
        }
        at += 4;
    }
    s->value = -left;
    if (left < 0)
        return OVERRUN;
    s->at = at;
    return NO_FAULT;
}

static fault pass_row(struct scan *s)
{
    const unsigned char *p = s->bytes + s->at;
    s->is_new = s->is_old = false;
    if (s->size - s->at < 4)
        return CUT;
    if (!marks_new(p, s->width))
        return pass_old(s);
    s->is_new = true;
    s->value = p[2] << 8 | p[3];
    return s->value == s->width ? pass_new(s) : BAD_LENGTH;
}

static ibl_status tell_fault(ibl_ctx *ctx, const char *name, fault f, int row,
                             const ibl_rgbe_header *h, int value)
{
    switch (f) {
    case ZERO_RUN:
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: scanline %d of %d has a run of no pixels: the "
                        "file is damaged",
                        name, row + 1, h->rows);
    case OVERRUN:
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: scanline %d of %d has a run that ends %d pixels "
                        "beyond its %d: the file is damaged",
                        name, row + 1, h->rows, value, h->row_px);
    case BAD_LENGTH:
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: scanline %d of %d says it has %d pixels, not %d: "
                        "the file is damaged",
                        name, row + 1, h->rows, value, h->row_px);
    case NO_FAULT:
    case CUT:
        break;
    }
    return ibl_fail(ctx, IBL_ERR_FORMAT,
                    "%s: the file ends in scanline %d of %d: it is cut short",
                    name, row + 1, h->rows);
}

static void index_flat(const ibl_rgbe_header *h, ibl_rgbe_index *index)
{
    index->flat = true;
    index->has_new = index->has_old = false;
    for (int i = 0; i <= h->rows; i++)
        index->row[i] = h->data + (size_t)i * 4 * (size_t)h->row_px;
}

ibl_status ibl_rgbe_scan(ibl_ctx *ctx, const char *name,
                         const unsigned char *bytes, size_t size,
                         const ibl_rgbe_header *h, ibl_rgbe_index *index)
{
    struct scan s = {
        .bytes = bytes, .size = size, .at = h->data, .width = h->row_px};
    const size_t pixels = (size_t)h->row_px * (size_t)h->rows;
    fault f = NO_FAULT;
    int row = 0;

    *index = (ibl_rgbe_index){0};
    if (size == h->data)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: the file ends after its header: it is cut short",
                        name);
    /* no scanline is shorter than a pixel */
    if ((size - h->data) / 4 < (size_t)h->rows)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: %zu bytes of pixels cannot hold %d scanlines: "
                        "the file is cut short",
                        name, size - h->data, h->rows);
    index->row = ibl_alloc_array((size_t)h->rows + 1, sizeof *index->row);
    if (!index->row)
        return ibl_no_memory(ctx, "an index of scanlines");

    for (; row < h->rows && !f; row++) {
        if (row % CHECK_ROWS == 0 && ibl_cancelled(ctx)) {
            ibl_rgbe_index_free(index);
            return IBL_ERR_CANCELLED;
        }
        index->row[row] = s.at;
        f = pass_row(&s);
        index->has_new |= s.is_new;
        index->has_old |= s.is_old;
    }
    index->row[h->rows] = s.at;
    /* Pixels that only look like codes: the size has the last word. */
    if ((f || s.at != size) && (size - h->data) / 4 == pixels &&
        (size - h->data) % 4 == 0) {
        index_flat(h, index);
        return IBL_OK;
    }
    if (f) {
        ibl_rgbe_index_free(index);
        return tell_fault(ctx, name, f, row - 1, h, s.value);
    }
    return IBL_OK;
}

void ibl_rgbe_index_free(ibl_rgbe_index *index)
{
    ibl_free(index->row);
    *index = (ibl_rgbe_index){0};
}

/* ---- scanlines ------------------------------------------------------ */

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

void ibl_rgbe_row(const ibl_rgbe_dsp *dsp, const unsigned char *bytes,
                  size_t size, const ibl_rgbe_header *h,
                  const ibl_rgbe_index *index, int row, unsigned char *scratch,
                  float *dst)
{
    const unsigned char *src = bytes + index->row[row];
    const size_t stride = plane_bytes(h);

    if (index->flat || !marks_new(src, h->row_px)) {
        split(src, index->flat, h->row_px, scratch, stride);
    } else {
        const bool has_slack = size - index->row[row + 1] >= IBL_RGBE_SLACK;
        src += 4;
        for (int c = 0; c < 4; c++)
            src = (has_slack ? dsp->expand : ibl_rgbe_expand_c)(
                src, h->row_px, scratch + c * stride);
    }
    dsp->to_rgb(scratch, stride, h->row_px, h->scale, dst);
    if (h->xyz)
        apply_matrix(h->matrix, h->row_px, dst);
}

/* ---- the picture ---------------------------------------------------- */

struct decode {
    const unsigned char *bytes;
    size_t size;
    ibl_rgbe_dsp dsp;
    ibl_rgbe_header h;
    ibl_rgbe_index index;
    unsigned char *scratch; /* one of scratch_bytes for each worker */
    size_t scratch_bytes;
    float *columns; /* JOB_COLUMNS scanlines for each worker, by_column only */
    int job_rows;
    float *pixels;
};

static void reverse(float *px, int count)
{
    for (float *a = px, *b = px + 3 * (count - 1); a < b; a += 3, b -= 3) {
        for (int c = 0; c < 3; c++) {
            const float t = a[c];
            a[c] = b[c];
            b[c] = t;
        }
    }
}

static void decode_rows(void *arg, int job, int worker)
{
    const struct decode *d = arg;
    const ibl_rgbe_header *h = &d->h;
    const int begin = job * d->job_rows;

    for (int i = begin; i < h->rows && i < begin + d->job_rows; i++) {
        const int y = h->reverse_rows ? h->rows - 1 - i : i;
        float *dst = d->pixels + (size_t)y * 3 * (size_t)h->width;
        ibl_rgbe_row(&d->dsp, d->bytes, d->size, h, &d->index, i,
                     d->scratch + (size_t)worker * d->scratch_bytes, dst);
        if (h->reverse_pixels)
            reverse(dst, h->width);
    }
}

/* Scanline i goes to column x_of(i), its pixel j to row y_of(j). */
static void decode_columns(void *arg, int job, int worker)
{
    const struct decode *d = arg;
    const ibl_rgbe_header *h = &d->h;
    const size_t line = 3 * (size_t)h->row_px;
    float *columns = d->columns + (size_t)worker * line * (size_t)d->job_rows;
    const int begin = job * d->job_rows;
    const int count =
        h->rows - begin < d->job_rows ? h->rows - begin : d->job_rows;

    for (int i = 0; i < count; i++)
        ibl_rgbe_row(&d->dsp, d->bytes, d->size, h, &d->index, begin + i,
                     d->scratch + (size_t)worker * d->scratch_bytes,
                     columns + i * line);
    for (int j = 0; j < h->row_px; j++) {
        const int y = h->reverse_pixels ? h->row_px - 1 - j : j;
        float *row = d->pixels + (size_t)y * 3 * (size_t)h->width;
        for (int i = 0; i < count; i++) {
            const int x = h->reverse_rows ? h->rows - 1 - begin - i : begin + i;
            memcpy(row + 3 * x, columns + i * line + 3 * j, 3 * sizeof *row);
        }
    }
}

static ibl_status decode_picture(ibl_ctx *ctx, struct decode *d)
{
    const ibl_rgbe_header *h = &d->h;
    const size_t threads = (size_t)ibl_ctx_threads(ctx);

    d->scratch_bytes = ibl_rgbe_scratch(h);
    d->scratch = ibl_alloc_array(threads, d->scratch_bytes);
    if (!d->scratch)
        return ibl_no_memory(ctx, "scanlines");
    d->job_rows = JOB_PIXELS / h->row_px + 1;
    if (h->by_column) {
        d->job_rows = h->rows < JOB_COLUMNS ? h->rows : JOB_COLUMNS;
        d->columns = ibl_alloc_array(threads * (size_t)d->job_rows,
                                     3 * sizeof(float) * (size_t)h->row_px);
        if (!d->columns)
            return ibl_no_memory(ctx, "scanlines");
    }
    return ibl_run(ctx, "decode", (h->rows + d->job_rows - 1) / d->job_rows,
                   h->by_column ? decode_columns : decode_rows, d);
}

ibl_status ibl_rgbe_decode(ibl_ctx *ctx, const char *name,
                           const unsigned char *bytes, size_t size,
                           ibl_image *img, char format[64])
{
    struct decode d = {.bytes = bytes, .size = size};
    ibl_status status = ibl_rgbe_parse(ctx, name, bytes, size, &d.h);

    *img = (ibl_image){0};
    if (!status)
        status = ibl_rgbe_scan(ctx, name, bytes, size, &d.h, &d.index);
    if (!status)
        status = ibl_image_alloc(ctx, d.h.width, d.h.height, img);
    if (status)
        goto done;
    ibl_rgbe_dsp_init(&d.dsp, ibl_ctx_isa(ctx));
    d.pixels = img->data;
    status = decode_picture(ctx, &d);
    if (status) {
        ibl_image_free(img);
        goto done;
    }
    snprintf(format, 64, "Radiance %s, %s", d.h.xyz ? "XYZE" : "RGBE",
             d.index.has_new   ? "run-length"
             : d.index.has_old ? "old run-length"
                               : "flat");
done:
    ibl_free(d.columns);
    ibl_free(d.scratch);
    ibl_rgbe_index_free(&d.index);
    return status;
}
