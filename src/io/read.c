/* SPDX-License-Identifier: MIT */
#include "io/read.h"

#include <stdbool.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/bridge.h"
#include "io/exr.h"
#include "io/load.h"
#include "io/repair.h"
#include "io/rgbe.h"
#include "io/sniff.h"

ibl_read_options ibl_read_options_default(void)
{
    return (ibl_read_options){.part = -1};
}

ibl_status ibl_read_check_size(ibl_ctx *ctx, const char *name,
                               const ibl_read_options *opts, long long width,
                               long long height)
{
    if (width < 1 || height < 1 || width > IBL_MAX_EDGE ||
        height > IBL_MAX_EDGE)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: %lldx%lld pixels; each edge must be 1 to %d", name,
                        width, height, IBL_MAX_EDGE);
    if (width != 2 * height && !opts->any_aspect)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: %lldx%lld is not 2:1; an equirectangular map "
                        "that high is %lldx%lld (the option any-aspect takes "
                        "others)",
                        name, width, height, 2 * height, height);
    return IBL_OK;
}

static ibl_status decode_any(ibl_ctx *ctx, const char *name,
                             const unsigned char *bytes, size_t size,
                             const ibl_read_options *opts, ibl_image *img,
                             ibl_read_report *report)
{
    if (ibl_exr_is(bytes, size))
        return ibl_exr_decode(ctx, name, bytes, size, opts, img, report);
    if (opts->layer || opts->part > 0)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: has no %s: only OpenEXR files do, so do not ask "
                        "for one",
                        name, opts->layer ? "layers" : "parts");
    if (ibl_rgbe_is(bytes, size)) {
        ibl_status status =
            ibl_rgbe_decode(ctx, name, bytes, size, img, report->format);
        if (status)
            return status;
        status = ibl_read_check_size(ctx, name, opts, img->width, img->height);
        if (status)
            ibl_image_free(img);
        return status;
    }
    ibl_bridge_source source = {.name = name, .bytes = bytes, .size = size};
    ibl_sniff(bytes, size, &source.kind, &source.reader);
    return ibl_bridge_decode(ctx, &source, opts, img, report);
}

static ibl_status mend(ibl_ctx *ctx, const char *name,
                       const ibl_read_options *opts, ibl_image *img,
                       ibl_read_report *report)
{
    ibl_repair done;
    const ibl_status status = ibl_image_repair(ctx, img, &done);
    if (status)
        return status;
    report->nonfinite = done.nonfinite;
    report->negative = done.negative;
    report->peak = done.peak;
    if (!done.nonfinite && !done.negative)
        return IBL_OK;
    if (opts->strict)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: %zu pixels are not finite and %zu negative, "
                        "which strict reading refuses and any other mends",
                        name, done.nonfinite, done.negative);
    if (done.nonfinite)
        ibl_warn(ctx,
                 "%s: %zu pixels were not finite; each became its brightest "
                 "neighbour",
                 name, done.nonfinite);
    if (done.negative)
        ibl_warn(ctx, "%s: %zu pixels were negative and became 0", name,
                 done.negative);
    return IBL_OK;
}

/* Decodes and mends. owned, if not NULL, is freed between the two. */
static ibl_status read_bytes(ibl_ctx *ctx, const char *name,
                             const unsigned char *bytes, size_t size,
                             void *owned, const ibl_read_options *opts,
                             ibl_image *img, ibl_read_report *report)
{
    const ibl_read_options defaults = ibl_read_options_default();
    ibl_read_report scratch;
    ibl_image decoded = {0};
    ibl_status status;

    opts = opts ? opts : &defaults;
    report = report ? report : &scratch;
    *report = (ibl_read_report){.format = ""};
    if (opts->part < -1) {
        ibl_free(owned);
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "part %d: must be -1 or the number of a part, from 0",
                        opts->part);
    }
    ibl_progress(ctx, "decode", 0);
    status = decode_any(ctx, name, bytes, size, opts, &decoded, report);
    ibl_free(owned);
    if (!status)
        status = mend(ctx, name, opts, &decoded, report);
    if (status) {
        ibl_image_free(&decoded);
        return status;
    }
    if (report->low_range)
        ibl_warn(ctx,
                 "%s: low dynamic range (integers, taken for sRGB): lamps and "
                 "the sun are clipped, so it cannot light well",
                 name);
    ibl_progress(ctx, "decode", 1);
    *img = decoded;
    return IBL_OK;
}

ibl_status ibl_image_decode(ibl_ctx *ctx, const char *name, const void *bytes,
                            size_t size, const ibl_read_options *opts,
                            ibl_image *img, ibl_read_report *report)
{
    if (!size)
        return ibl_fail(ctx, IBL_ERR_FORMAT, "%s: is empty", name);
    return read_bytes(ctx, name, bytes, size, NULL, opts, img, report);
}

static bool is_known(const unsigned char *bytes, size_t size)
{
    const char *kind, *reader;
    ibl_sniff(bytes, size, &kind, &reader);
    return kind || ibl_exr_is(bytes, size) || ibl_rgbe_is(bytes, size);
}

ibl_status ibl_image_read(ibl_ctx *ctx, const char *path,
                          const ibl_read_options *opts, ibl_image *img,
                          ibl_read_report *report)
{
    unsigned char *bytes;
    size_t size;
    const ibl_status status = ibl_file_load(ctx, path, is_known, &bytes, &size);
    if (status)
        return status;
    return read_bytes(ctx, strcmp(path, "-") ? path : "standard input", bytes,
                      size, bytes, opts, img, report);
}
