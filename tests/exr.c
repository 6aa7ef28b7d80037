/* SPDX-License-Identifier: MIT */
#include "exr.h"

#include <fnmatch.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "io/rows.h"
#include "maps.h"

test_messages test_exr_kept;
ibl_ctx *test_exr_ctx;
ibl_image test_exr_img;
const char *const test_exr_compressions[8] = {"none", "rle",   "zips", "zip",
                                              "piz",  "pxr24", "b44",  "b44a"};
const char *const test_exr_types[3] = {"half", "float", "uint32"};

ibl_image test_exr_source(ibl_ctx *ctx, int width, int height)
{
    ibl_image img = map_constant(ctx, width, height, 0);
    test_random r = {(uint64_t)width * 1000 + (uint64_t)height};

    for (int i = 0; i < 3 * width * height; i++) {
        const double kind = test_random_unit(&r);
        const double u = test_random_unit(&r);
        img.data[i] = (float)(kind < 0.4    ? 0.25 * (i % 3) + 0.01 * i
                              : kind < 0.9  ? exp(u * 16 - 8)
                              : kind < 0.95 ? -u
                                            : u * 1e-6);
    }
    return img;
}

float test_exr_pattern(int x, int y, int channel)
{
    return (float)((x * 7 + y * 13 + x / 64 * y + channel * 11) % 1000) / 8;
}

/* A channel's samples of the rows from y on, rows of them. */
static void fill_samples(const test_exr_channel *c, int width, int y, int rows,
                         float *to)
{
    const int w = width / c->step, h = (rows + c->step - 1) / c->step;
    const size_t begin = (size_t)(y / c->step) * (size_t)w;
    for (int i = 0; i < w * h; i++)
        to[i] = c->data ? c->data[begin + (size_t)i]
                        : test_exr_pattern(i % w, y + i / w,
                                           (int)strcspn("RGB", c->name));
}

static bool write_chunk(exr_context_t f, exr_encode_pipeline_t *pipe, int y,
                        float *samples, int lines, int width, int height,
                        const test_exr_channel *channels)
{
    exr_chunk_info_t info;
    const int rows = y + lines < height ? lines : height - y;
    bool ok = !exr_write_scanline_chunk_info(f, 0, y, &info) &&
              !(y ? exr_encoding_update(f, 0, &info, pipe)
                  : exr_encoding_initialize(f, 0, &info, pipe));
    for (int i = 0; ok && i < pipe->channel_count; i++) {
        exr_coding_channel_info_t *c = &pipe->channels[i];
        float *from = samples + (size_t)i * (size_t)lines * (size_t)width;
        fill_samples(&channels[i], width, y, rows, from);
        c->user_data_type = EXR_PIXEL_FLOAT;
        c->user_bytes_per_element = 4;
        c->user_pixel_stride = 4;
        c->user_line_stride = 4 * width / channels[i].step;
        c->encode_from_ptr = (const uint8_t *)from;
    }
    if (ok && !y)
        ok = !exr_encoding_choose_default_routines(f, 0, pipe);
    return ok && !exr_encoding_run(f, 0, pipe);
}

bool test_exr_write(const char *path, int width, int height,
                    exr_compression_t compression,
                    const test_exr_channel *channels, int count,
                    const exr_attr_chromaticities_t *chroma, int envmap)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_context_t f;
    int part, lines = 1;

    if (exr_start_write(&f, path, EXR_WRITE_FILE_DIRECTLY, &init))
        return false;
    bool ok =
        !exr_add_part(f, "p", EXR_STORAGE_SCANLINE, &part) &&
        !exr_initialize_required_attr_simple(f, 0, width, height, compression);
    for (int i = 0; ok && i < count; i++)
        ok = !exr_add_channel(f, 0, channels[i].name, channels[i].type,
                              EXR_PERCEPTUALLY_LOGARITHMIC, channels[i].step,
                              channels[i].step);
    if (ok && chroma)
        ok = !exr_attr_set_chromaticities(f, 0, "chromaticities", chroma);
    if (ok && envmap >= 0)
        ok = !exr_attr_set_envmap(f, 0, "envmap", (exr_envmap_t)envmap);
    ok = ok && !exr_write_header(f) &&
         !exr_get_scanlines_per_chunk(f, 0, &lines);
    float *samples =
        malloc(sizeof *samples * (size_t)count * (size_t)lines * (size_t)width);
    for (int y = 0; ok && y < height; y += lines)
        ok = write_chunk(f, &pipe, y, samples, lines, width, height, channels);
    free(samples);
    exr_encoding_destroy(f, &pipe);
    return !exr_finish(&f) && ok;
}

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
    const ibl_status status =
        test_exr_decode_bytes(bytes, size, &opts, img, report);
    test_image(*img);
    return status;
}

bool test_exr_same(const ibl_image *a, const ibl_image *b)
{
    return a->width == b->width && a->height == b->height &&
           !memcmp(a->data, b->data,
                   3 * sizeof(float) * (size_t)a->width * (size_t)a->height);
}

void test_exr_begin(int threads, int width, int height)
{
    file_need_oiio();
    test_exr_ctx = file_ctx(threads, &test_exr_kept, file_bridge());
    test_exr_img = test_exr_source(test_exr_ctx, width, height);
    CHECK(file_save_pfm(file_path("s.pfm"), &test_exr_img));
}

void test_exr_refused(const char *name, const char *layer, int part,
                      ibl_status want, const char *words)
{
    ibl_image img;
    char glob[200];
    const ibl_status status = test_exr_decode(name, layer, part, &img, NULL);
    snprintf(glob, sizeof glob, "*%s*", words);
    CHECK_MSG(status == want && !fnmatch(glob, test_exr_kept.text[0], 0) &&
                  !img.data,
              "%s: %d %s", name, status, test_exr_kept.text[0]);
}
