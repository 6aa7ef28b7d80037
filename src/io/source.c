/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "ibl/io.h"

struct ibl_source {
    ibl_ctx *ctx;
    ibl_image img;
    ibl_read_report report;
    int row; /* the next */
};

ibl_status ibl_source_open(ibl_ctx *ctx, const char *path,
                           const ibl_read_options *opts, ibl_source **out)
{
    ibl_source *s = ibl_alloc_zeroed(1, sizeof *s);

    *out = NULL;
    if (!s)
        return ibl_no_memory(ctx, "a source");
    s->ctx = ctx;
    const ibl_status status =
        ibl_image_read(ctx, path, opts, &s->img, &s->report);
    if (status) {
        ibl_source_close(s);
        return status;
    }
    *out = s;
    return IBL_OK;
}

int ibl_source_width(const ibl_source *source)
{
    return source->img.width;
}

int ibl_source_height(const ibl_source *source)
{
    return source->img.height;
}

ibl_status ibl_source_read(ibl_source *source, int rows, float *rgb)
{
    const size_t floats = 3 * (size_t)source->img.width;
    if (rows < 1 || rows > source->img.height - source->row)
        return ibl_fail(source->ctx, IBL_ERR_ARGUMENT,
                        "%d rows: must be 1 to the %d that are left", rows,
                        source->img.height - source->row);
    memcpy(rgb, source->img.data + floats * (size_t)source->row,
           floats * (size_t)rows * sizeof *rgb);
    source->row += rows;
    return ibl_cancelled(source->ctx) ? IBL_ERR_CANCELLED : IBL_OK;
}

const ibl_read_report *ibl_source_report(const ibl_source *source)
{
    return &source->report;
}

void ibl_source_close(ibl_source *source)
{
    if (!source)
        return;
    ibl_image_free(&source->img);
    ibl_free(source);
}
