/* SPDX-License-Identifier: MIT */
#include "exr.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "io/exr.h"
#include "kern/max_finite.h"

test_messages test_exr_kept;
const char *const test_exr_compressions[8] = {"none", "rle",   "zips", "zip",
                                              "piz",  "pxr24", "b44",  "b44a"};
const char *const test_exr_types[3] = {"half", "float", "uint32"};

static void fill(ibl_image *img, uint64_t seed)
{
    test_random r = {seed};
    for (int i = 0; i < 3 * img->width * img->height; i++) {
        const double kind = test_random_unit(&r);
        const double u = test_random_unit(&r);
        img->data[i] = (float)(kind < 0.4    ? 0.25 * (i % 3) + 0.01 * i
                               : kind < 0.9  ? exp(u * 16 - 8)
                               : kind < 0.95 ? -u
                                             : u * 1e-6);
    }
}

ibl_image test_exr_source(ibl_ctx *ctx, int width, int height)
{
    ibl_image img;
    if (ibl_image_alloc(ctx, width, height, &img))
        exit(1);
    fill(&img, (uint64_t)width * 1000 + (uint64_t)height);
    return img;
}

ibl_status test_exr_read_rows(ibl_rows *rows, ibl_image *img)
{
    static test_random r = {12};
    const size_t floats = 3 * (size_t)rows->width;
    uint32_t *most = malloc((size_t)rows->height * sizeof *most);
    ibl_status status =
        ibl_image_alloc(rows->ctx, rows->width, rows->height, img);
    const int longest = test_random_u64(&r) % 2 ? 3 : 80;
    while (!status && rows->row < rows->height) {
        const int left = rows->height - rows->row;
        const int some = 1 + (int)(test_random_u64(&r) % (uint64_t)longest);
        status = ibl_rows_read(rows, some < left ? some : left,
                               img->data + floats * (size_t)rows->row,
                               most + rows->row);
    }
    for (int y = 0; !status && y < rows->height; y++) {
        const uint32_t want =
            ibl_max_finite_c(img->data + floats * (size_t)y, floats);
        CHECK(want == most[y] ||
              (want >= IBL_INFINITE_BITS && most[y] >= IBL_INFINITE_BITS));
    }
    if (status)
        ibl_image_free(img);
    free(most);
    return status;
}

ibl_status test_exr_decode_bytes(ibl_ctx *ctx, const void *bytes, size_t size,
                                 const ibl_read_options *opts, ibl_image *img,
                                 ibl_read_report *report)
{
    ibl_input in = ibl_input_of(ctx, "f.exr", bytes, size);
    ibl_rows *rows;
    ibl_status status = ibl_exr_open(&in, opts, &rows);
    *img = (ibl_image){0};
    if (!status)
        status = test_exr_read_rows(rows, img);
    if (!status)
        *report = rows->report;
    ibl_rows_close(rows);
    return status;
}

ibl_status test_exr_decode(ibl_ctx *ctx, const char *path, const char *layer,
                           int part, ibl_image *img, ibl_read_report *report)
{
    ibl_read_options opts = ibl_read_options_default();
    size_t size;
    unsigned char *bytes = file_load(path, &size);
    opts.any_aspect = 1;
    opts.layer = layer;
    opts.part = part;
    *report = (ibl_read_report){.format = ""};
    memset(&test_exr_kept, 0, sizeof test_exr_kept);
    const ibl_status status =
        test_exr_decode_bytes(ctx, bytes, size, &opts, img, report);
    free(bytes);
    return status;
}

bool test_exr_same(const ibl_image *a, const ibl_image *b)
{
    return a->width == b->width && a->height == b->height &&
           !memcmp(a->data, b->data,
                   3 * sizeof(float) * (size_t)a->width * (size_t)a->height);
}

bool test_exr_ready(void)
{
    if (!file_bridge() || !file_have("oiiotool")) {
        test_skip("needs the image bridge and oiiotool");
        return false;
    }
    return true;
}
