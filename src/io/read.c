/* SPDX-License-Identifier: MIT */
#include "io/read.h"

#include "core/alloc.h"
#include "core/context.h"
#include "io/source.h"

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
    const bool cross = 3 * width == 4 * height || 4 * width == 3 * height;
    if (width != 2 * height && !opts->any_aspect)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: %lldx%lld is not 2:1%s; an equirectangular map "
                        "that high is %lldx%lld (the option any-aspect takes "
                        "others)",
                        name, width, height,
                        cross ? " but the shape of an unfolded cube, which "
                                "sets of probes take as a cross"
                              : "",
                        2 * height, height);
    return IBL_OK;
}

ibl_status ibl_read_alloc(ibl_ctx *ctx, const char *name, int width, int height,
                          ibl_image *img)
{
    const size_t pixels = (size_t)width * (size_t)height;
    float *data = ibl_alloc_array(pixels, 3 * sizeof *data);

    if (!data)
        return ibl_fail(ctx, IBL_ERR_MEMORY,
                        "%s: no memory for %dx%d pixels at once, %.1f GiB: "
                        "scale it down, or free some",
                        name, width, height, (double)pixels * 12 / (1 << 30));
    *img = (ibl_image){width, height, data};
    return IBL_OK;
}

/* All of a source that was opened with status. */
static ibl_status read_all(ibl_status status, ibl_source *source,
                           ibl_image *img, ibl_read_report *report)
{
    ibl_image whole;
    if (status)
        return status;
    status = ibl_source_image(source, &whole);
    if (!status)
        *img = whole;
    if (report)
        *report = *ibl_source_report(source);
    ibl_source_close(source);
    return status;
}

ibl_status ibl_image_decode(ibl_ctx *ctx, const char *name, const void *bytes,
                            size_t size, const ibl_read_options *opts,
                            ibl_image *img, ibl_read_report *report)
{
    ibl_source *source;
    if (!ctx || !name || (!bytes && size) || !img)
        return ibl_missing(ctx, "ibl_image_decode: name, bytes or img");
    const ibl_status status =
        ibl_source_over(ctx, name, bytes, size, opts, &source);
    return read_all(status, source, img, report);
}

ibl_status ibl_image_read(ibl_ctx *ctx, const char *path,
                          const ibl_read_options *opts, ibl_image *img,
                          ibl_read_report *report)
{
    ibl_source *source;
    if (!ctx || !img)
        return ibl_missing(ctx, "ibl_image_read: img");
    const ibl_status status = ibl_source_open(ctx, path, opts, &source);
    return read_all(status, source, img, report);
}
