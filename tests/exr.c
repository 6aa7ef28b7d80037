/* SPDX-License-Identifier: MIT */
#include "exr.h"

#include <math.h>
#include <string.h>

#include "files.h"
#include "maps.h"

test_messages test_exr_kept;
ibl_ctx *test_exr_ctx;
ibl_image test_exr_img;

ibl_status test_exr_decode_bytes(const void *bytes, size_t size,
                                 const ibl_read_options *opts, ibl_image *img,
                                 ibl_read_report *report)
{
    ibl_input in = ibl_input_of(test_exr_ctx, "f.exr", bytes, size);
    ibl_rows *rows = NULL;

    memset(&test_exr_kept, 0, sizeof test_exr_kept);
    ibl_status status = ibl_exr_open(&in, opts, &rows);
    *img = (ibl_image){0};
    if (!status)
        status = file_read_rows(rows, img);
    if (!status && report)
        *report = rows->report;
    ibl_rows_close(rows);
    test_image(*img);
    return status;
}

ibl_status test_exr_decode(const char *name, const char *layer, int part,
                           ibl_image *img, ibl_read_report *report)
{
    ibl_read_options opts = ibl_read_options_default();
    size_t size;
    unsigned char *bytes = file_load(file_path(name), &size);

    opts.any_aspect = 1;
    opts.layer = layer;
    opts.part = part;
    return test_exr_decode_bytes(bytes, size, &opts, img, report);
}

bool test_exr_same(const ibl_image *a, const ibl_image *b)
{
    return a->data && b->data && a->width == b->width &&
           a->height == b->height &&
           !memcmp(a->data, b->data, map_floats(a) * sizeof *a->data);
}

void test_exr_begin(int threads, int width, int height)
{
    test_random r = {(uint64_t)width * 1000 + (uint64_t)height};

    file_need_oiio();
    test_exr_ctx = file_ctx(threads, &test_exr_kept, file_bridge());
    test_exr_img = map_constant(test_exr_ctx, width, height, 0);
    for (int i = 0; i < 3 * width * height; i++) {
        const double kind = test_random_unit(&r);
        const double u = test_random_unit(&r);
        test_exr_img.data[i] = (float)(kind < 0.4    ? 0.25 * (i % 3) + 0.01 * i
                                       : kind < 0.9  ? exp(u * 16 - 8)
                                       : kind < 0.95 ? -u
                                                     : u * 1e-6);
    }
    CHECK(file_save_pfm(file_path("s.pfm"), &test_exr_img));
}
