/* SPDX-License-Identifier: MIT */
#include "io/source.h"

#include <stdbool.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/alpha.h"
#include "io/bridge.h"
#include "io/container.h"
#include "io/exr.h"
#include "io/load.h"
#include "io/read.h"
#include "io/repair.h"
#include "io/rgbe.h"
#include "io/rows.h"
#include "io/sniff.h"

enum {
    SNIFF_BYTES = 64 /* that tell the kind of a file */
};

struct ibl_source {
    ibl_ctx *ctx;
    char *name;
    ibl_input in;
    ibl_rows *rows;
    ibl_mender mender;
    ibl_read_report report;
    int strict;
    bool straight;         /* colours are to be multiplied by alpha */
    ibl_alpha_count alpha; /* what it was like */
    int row;               /* the next */
    ibl_status status;     /* of a read that failed */
};

/* ---- opening -------------------------------------------------------- */

static uint64_t longest(const unsigned char *bytes, size_t size)
{
    const char *kind, *reader;
    if (ibl_rgbe_is(bytes, size))
        return ibl_rgbe_longest(bytes, size);
    ibl_sniff(bytes, size, &kind, &reader);
    return kind || ibl_exr_is(bytes, size) ? IBL_LONGEST : 0;
}

static ibl_status open_bridged(ibl_source *s, const ibl_read_options *opts)
{
    const ibl_status status = ibl_input_load(s->ctx, longest, &s->in);
    if (status)
        return status;
    ibl_bridge_source source = {
        .name = s->in.name, .bytes = s->in.bytes, .size = s->in.size};
    ibl_sniff(s->in.bytes, s->in.size, &source.kind, &source.reader);
    return ibl_bridge_rows(s->ctx, &source, opts, &s->rows);
}

static ibl_status open_any(ibl_source *s, const ibl_read_options *opts)
{
    unsigned char first[SNIFF_BYTES];
    size_t size;

    if (!ibl_input_read(&s->in, 0, sizeof first, first, &size))
        return ibl_fail(s->ctx, IBL_ERR_IO, "%s: cannot be read", s->in.name);
    if (ibl_exr_is(first, size))
        return ibl_exr_open(s->ctx, &s->in, opts, &s->rows);
    if (ibl_is_ktx2(first, size) || ibl_is_ktx(first, size))
        return ibl_fail(s->ctx, IBL_ERR_FORMAT,
                        "%s: is a texture, %s, where a map is wanted: give the "
                        "map that it was baked from",
                        s->in.name, ibl_is_ktx(first, size) ? "KTX" : "KTX2");
    if (opts->layer || opts->part > 0)
        return ibl_fail(s->ctx, IBL_ERR_FORMAT,
                        "%s: has no %s: only OpenEXR files do, so do not ask "
                        "for one",
                        s->in.name, opts->layer ? "layers" : "parts");
    if (ibl_rgbe_is(first, size))
        return ibl_rgbe_open(s->ctx, &s->in, opts, &s->rows);
    return open_bridged(s, opts);
}

/* A source without its input. Owns a copy of the name. */
static ibl_status make(ibl_ctx *ctx, const char *name,
                       const ibl_read_options *opts, ibl_source **out)
{
    const size_t bytes = strlen(name) + 1;
    ibl_source *s;

    if (opts->part < -1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "part %d: must be -1 or the number of a part, from 0",
                        opts->part);
    if (opts->alpha > IBL_ALPHA_STRAIGHT)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "alpha option %d: must be at most %d", (int)opts->alpha,
                        IBL_ALPHA_STRAIGHT);
    s = ibl_alloc_zeroed(1, sizeof *s);
    if (!s)
        return ibl_no_memory(ctx, "a source");
    s->ctx = ctx;
    s->in.fd = -1;
    s->strict = opts->strict;
    s->alpha = ibl_alpha_count_none();
    s->name = ibl_alloc_array(bytes, 1);
    if (!s->name) {
        ibl_source_close(s);
        return ibl_no_memory(ctx, "a source");
    }
    memcpy(s->name, name, bytes);
    *out = s;
    return IBL_OK;
}

static void fill_report(ibl_source *s)
{
    ibl_read_report *r = &s->report;

    *r = s->rows->report;
    r->nonfinite = s->mender.done.nonfinite;
    r->negative = s->mender.done.negative;
    r->peak = s->mender.done.peak;
    r->has_alpha = s->rows->alpha != NULL;
    r->alpha_least = s->row && r->has_alpha ? s->alpha.least : 1;
    r->alpha_most = s->row && r->has_alpha ? s->alpha.most : 1;
    r->alpha_nonfinite = s->alpha.nonfinite;
    r->alpha_beyond = s->alpha.beyond;
    r->alpha_hidden = s->alpha.hidden;
}

/* Opens the rows of s->in; frees s if that fails. */
static ibl_status start(ibl_source *s, const ibl_read_options *opts,
                        ibl_source **out)
{
    ibl_progress(s->ctx, "decode", 0);
    ibl_status status = open_any(s, opts);
    if (!status)
        status = ibl_mender_init(&s->mender, s->rows);
    if (status) {
        ibl_source_close(s);
        return status;
    }
    if (s->rows->whole.data)
        ibl_input_close(&s->in);
    s->straight = s->rows->straight || opts->alpha == IBL_ALPHA_STRAIGHT;
    fill_report(s);
    *out = s;
    return IBL_OK;
}

ibl_status ibl_source_over(ibl_ctx *ctx, const char *name, const void *bytes,
                           size_t size, const ibl_read_options *opts,
                           ibl_source **out)
{
    const ibl_read_options defaults = ibl_read_options_default();
    ibl_source *s;
    ibl_status status;

    *out = NULL;
    opts = opts ? opts : &defaults;
    if (!size)
        return ibl_fail(ctx, IBL_ERR_FORMAT, "%s: is empty", name);
    status = make(ctx, name, opts, &s);
    if (status)
        return status;
    s->in = ibl_input_of(s->name, bytes, size);
    return start(s, opts, out);
}

ibl_status ibl_source_open(ibl_ctx *ctx, const char *path,
                           const ibl_read_options *opts, ibl_source **out)
{
    const ibl_read_options defaults = ibl_read_options_default();
    ibl_source *s;
    ibl_status status;

    if (!ctx || !path || !out)
        return ibl_missing(ctx, "ibl_source_open: path or out");
    *out = NULL;
    opts = opts ? opts : &defaults;
    status = make(ctx, path, opts, &s);
    if (status)
        return status;
    status = ibl_input_open(ctx, s->name, longest, &s->in);
    if (status) {
        ibl_source_close(s);
        return status;
    }
    return start(s, opts, out);
}

void ibl_source_close(ibl_source *source)
{
    if (!source)
        return;
    ibl_mender_free(&source->mender);
    ibl_rows_close(source->rows);
    ibl_input_close(&source->in);
    ibl_free(source->name);
    ibl_free(source);
}

/* ---- reading -------------------------------------------------------- */

int ibl_source_width(const ibl_source *source)
{
    return source->rows->width;
}

int ibl_source_height(const ibl_source *source)
{
    return source->rows->height;
}

const float *ibl_source_alpha(const ibl_source *source)
{
    return source->rows->alpha;
}

const ibl_read_report *ibl_source_report(const ibl_source *source)
{
    return &source->report;
}

/* The same of alpha. */
static ibl_status tell_alpha(const ibl_source *s)
{
    const ibl_alpha_count *a = &s->alpha;

    if (s->strict && (a->nonfinite || a->beyond))
        return ibl_fail(s->ctx, IBL_ERR_FORMAT,
                        "%s: alpha is not finite in %zu pixels and not from 0 "
                        "to 1 in %zu, which strict reading refuses and any "
                        "other mends",
                        s->in.name, a->nonfinite, a->beyond);
    if (a->nonfinite)
        ibl_warn(s->ctx,
                 "%s: alpha of %zu pixels was not finite and became 0: they "
                 "count as not seen",
                 s->in.name, a->nonfinite);
    if (a->beyond)
        ibl_warn(s->ctx,
                 "%s: alpha of %zu pixels was not from 0 to 1 but from %.9g "
                 "to %.9g, and became 0 or 1",
                 s->in.name, a->beyond, (double)a->lowest, (double)a->highest);
    if (a->hidden)
        ibl_warn(s->ctx,
                 "%s: %zu pixels had a colour but alpha 0, and became black: "
                 "colours are taken as multiplied by alpha unless they are "
                 "said to be straight",
                 s->in.name, a->hidden);
    return IBL_OK;
}

/* Once all is there: says what had to be mended, or refuses it. */
static ibl_status tell_mended(const ibl_source *s)
{
    const ibl_repair *done = &s->mender.done;

    if (s->strict && (done->nonfinite || done->negative))
        return ibl_fail(s->ctx, IBL_ERR_FORMAT,
                        "%s: %zu pixels are not finite and %zu negative, "
                        "which strict reading refuses and any other mends",
                        s->in.name, done->nonfinite, done->negative);
    if (done->nonfinite)
        ibl_warn(s->ctx,
                 "%s: %zu pixels were not finite; each became its brightest "
                 "neighbour",
                 s->in.name, done->nonfinite);
    if (done->negative)
        ibl_warn(s->ctx, "%s: %zu pixels were negative and became 0",
                 s->in.name, done->negative);
    if (s->report.low_range)
        ibl_warn(s->ctx,
                 "%s: low dynamic range (integers, taken for sRGB): lamps and "
                 "the sun are clipped, so it cannot light well",
                 s->in.name);
    return tell_alpha(s);
}

/* Alpha of the next rows, whose colours are there. */
static void apply_alpha(ibl_source *s, int rows, float *rgb)
{
    const size_t width = (size_t)s->rows->width;

    if (s->rows->alpha)
        ibl_alpha_apply(s->rows->alpha + width * (size_t)s->row, rgb,
                        width * (size_t)rows, s->straight, &s->alpha);
}

ibl_status ibl_source_read(ibl_source *source, int rows, float *rgb)
{
    ibl_source *s = source;

    if (!s || !rgb)
        return ibl_missing(s ? s->ctx : NULL, "ibl_source_read: rgb");
    if (s->status)
        return s->status;
    const int left = s->rows->height - s->row;
    if (rows < 1 || rows > left)
        return ibl_fail(s->ctx, IBL_ERR_ARGUMENT,
                        "%d rows: must be 1 to the %d that are left", rows,
                        left);
    s->status = ibl_mender_read(&s->mender, rows, rgb);
    if (!s->status)
        apply_alpha(s, rows, rgb);
    s->row += rows;
    fill_report(s);
    if (!s->status && rows == left)
        s->status = tell_mended(s);
    if (!s->status && rows == left && s->rows->silent)
        ibl_progress(s->ctx, "decode", 1);
    return s->status;
}

ibl_status ibl_source_image(ibl_source *source, ibl_image *img)
{
    ibl_rows *rows = source->rows;
    ibl_status status = IBL_OK;

    *img = rows->whole;
    rows->whole = (ibl_image){0};
    if (!img->data)
        status = ibl_read_alloc(source->ctx, source->name, rows->width,
                                rows->height, img);
    if (!status)
        status = ibl_source_read(source, img->height, img->data);
    if (status)
        ibl_image_free(img);
    return status;
}
