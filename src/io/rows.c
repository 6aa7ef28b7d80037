/* SPDX-License-Identifier: MIT */
#include "io/rows.h"

#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/half.h"
#include "io/layout.h"

ibl_status ibl_rows_read(ibl_rows *rows, int count, float *rgb)
{
    const ibl_status status = rows->read(rows, count, rgb);

    rows->row += status ? 0 : count;
    return status;
}

void ibl_rows_close(ibl_rows *rows)
{
    if (rows) {
        float *alpha = rows->alpha;
        rows->close(rows);
        ibl_free(alpha);
    }
}

ibl_status ibl_rows_alloc_alpha(ibl_rows *rows)
{
    rows->alpha = ibl_alloc_zeroed((size_t)rows->width * (size_t)rows->height,
                                   sizeof *rows->alpha);
    return rows->alpha ? IBL_OK : ibl_no_memory(rows->ctx, "alpha");
}

/* ---- sizes -------------------------------------------------------- */

ibl_status ibl_map_check_size(const ibl_input *in, const ibl_read_options *opts,
                              long long width, long long height)
{
    if (width < 1 || height < 1 || width > IBL_MAX_EDGE ||
        height > IBL_MAX_EDGE)
        return ibl_bad_file(in, "%lldx%lld pixels; each edge must be 1 to %d",
                            width, height, IBL_MAX_EDGE);
    /* Where sizes have 32 bits; what is beside the pixels takes less than they
     * do in floats of 4 channels. */
    if ((uint64_t)(width * height) > SIZE_MAX / 64)
        return ibl_reject(
            in, IBL_ERR_MEMORY,
            "%lldx%lld pixels are more than this build has memory "
            "for: scale it down",
            width, height);
    if (ibl_input_layout_of(opts, width, height) != IBL_INPUT_AUTO)
        return IBL_OK;
    if (opts->layout)
        return ibl_bad_file(in,
                            "%lldx%lld pixels: not the shape of the layout %s",
                            width, height, ibl_input_layout_name(opts->layout));
    if (width == height)
        return ibl_bad_file(in,
                            "%lldx%lld is square: say by the option "
                            "input-layout whether it is octahedral or equirect",
                            width, height);
    return ibl_bad_file(
        in,
        "%lldx%lld is not 2:1; an equirectangular map that high is %lldx%lld "
        "(the option any-aspect takes others)",
        width, height, 2 * height, height);
}

ibl_status ibl_map_alloc(const ibl_input *in, int width, int height,
                         ibl_image *img)
{
    const size_t pixels = (size_t)width * (size_t)height;
    const ibl_status fits = ibl_allow(in, 3 * sizeof(float) * pixels);

    if (fits)
        return fits;
    float *data = ibl_alloc_array(pixels, 3 * sizeof *data);
    if (!data)
        return ibl_reject(in, IBL_ERR_MEMORY,
                          "no memory for %dx%d pixels at once, %.1f GiB: scale "
                          "it down, or free some",
                          width, height, (double)pixels * 12 / (1 << 30));
    *img = (ibl_image){width, height, data};
    return IBL_OK;
}

/* ---- an image that is there ----------------------------------------- */

static ibl_status image_read(ibl_rows *rows, int count, float *rgb)
{
    const size_t floats = 3 * (size_t)rows->width;
    const float *src = rows->whole.data + floats * (size_t)rows->row;

    if (src != rgb)
        memcpy(rgb, src, floats * (size_t)count * sizeof *rgb);
    return IBL_OK;
}

static void image_close(ibl_rows *rows)
{
    ibl_image_free(&rows->whole);
    ibl_free(rows);
}

ibl_status ibl_rows_of_image(ibl_ctx *ctx, ibl_image *img, const ibl_rows *like,
                             ibl_rows **out)
{
    ibl_rows *r = *out = ibl_alloc_zeroed(1, sizeof *r);

    if (!r) {
        ibl_image_free(img);
        return ibl_no_memory(ctx, "an image");
    }
    *r = (ibl_rows){.ctx = ctx,
                    .width = img->width,
                    .height = img->height,
                    .read = image_read,
                    .close = image_close,
                    .whole = *img};
    if (like) {
        r->report = like->report;
        r->straight = like->straight;
    }
    *img = (ibl_image){0};
    return IBL_OK;
}

/* Where the pixel (x, y) of the upright image lies in width x height ones. */
static size_t lies_at(int orientation, int width, int height, int x, int y)
{
    const bool lies = orientation > 4;
    const int a = lies ? y : x, b = lies ? x : y;
    const bool right = orientation == 2 || orientation == 3 || orientation > 6;
    const bool low = orientation == 3 || orientation == 4 || orientation == 6 ||
                     orientation == 7;

    return (size_t)(low ? height - 1 - b : b) * (size_t)width +
           (size_t)(right ? width - 1 - a : a);
}

ibl_status ibl_rows_upright(const ibl_input *in, ibl_rows **rows)
{
    ibl_rows *r = *rows, *made = NULL;
    const int w = r->width, h = r->height, o = r->orientation;
    const int width = o > 4 ? h : w, height = o > 4 ? w : h;
    ibl_image from = r->whole, to = {0};
    ibl_status status = IBL_OK;

    if (!from.data)
        status = ibl_map_alloc(in, w, h, &from);
    if (!status)
        status = ibl_rows_read(r, h, from.data);
    if (!status)
        status = ibl_map_alloc(in, width, height, &to);
    if (!status)
        status = ibl_rows_of_image(in->ctx, &to, r, &made);
    if (!status && r->alpha)
        status = ibl_rows_alloc_alpha(made);
    for (size_t i = 0; i < (size_t)w * (size_t)h && !status; i++) {
        const size_t at = lies_at(o, w, h, (int)(i % (size_t)width),
                                  (int)(i / (size_t)width));
        memcpy(made->whole.data + 3 * i, from.data + 3 * at,
               3 * sizeof *from.data);
        if (r->alpha)
            made->alpha[i] = r->alpha[at];
    }
    if (from.data != r->whole.data)
        ibl_image_free(&from);
    if (made) {
        ibl_rows_close(r);
        *rows = made;
    }
    return status;
}

/* ---- pixels of a program --------------------------------------------- */

static float load(const ibl_pixels *from, const unsigned char *row, size_t i)
{
    uint16_t half;
    float f;

    if (!from->half) {
        memcpy(&f, row + i * sizeof f, sizeof f);
        return f;
    }
    memcpy(&half, row + i * sizeof half, sizeof half);
    return ibl_half_to_float(half);
}

ibl_status ibl_rows_of_pixels(const ibl_input *in, const ibl_pixels *from,
                              const ibl_read_options *opts, ibl_rows **out)
{
    const size_t channels = (size_t)from->channels;
    const ptrdiff_t usual = from->width * from->channels * (from->half ? 2 : 4);
    const unsigned char *row = from->data;
    ibl_image img = {0};

    ibl_status status = ibl_map_check_size(in, opts, from->width, from->height);
    if (!status)
        status = ibl_map_alloc(in, from->width, from->height, &img);
    if (!status)
        status = ibl_rows_of_image(in->ctx, &img, NULL, out);
    if (!status && opts->alpha && channels == 4)
        status = ibl_rows_alloc_alpha(*out);
    if (status)
        return status;
    ibl_rows *r = *out;
    snprintf(r->report.format, sizeof r->report.format, "pixels in memory, %s",
             from->half ? "halves" : "floats");
    for (size_t y = 0, at = 0; y < (size_t)from->height; y++) {
        for (size_t x = 0; x < (size_t)from->width; x++, at++) {
            for (size_t c = 0; c < 3; c++)
                r->whole.data[3 * at + c] = load(from, row, channels * x + c);
            if (r->alpha)
                r->alpha[at] = load(from, row, channels * x + 3);
        }
        row += from->row_bytes ? from->row_bytes : usual;
    }
    return IBL_OK;
}
