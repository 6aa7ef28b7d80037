/* SPDX-License-Identifier: MIT */
/* Images, from memory, then once more from a file or a pipe: both must give the
 * same. Or as each face of six. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/engine.h"
#include "fuzz.h"
#include "io/bridge.h"
#include "io/rows.h"

void fuzz_begin(void)
{
}

/* Decoders of other people's are left out: any file that the bridge reads is a
 * grey map, with a peak that no JPEG has (--wrap). */
ibl_status __wrap_ibl_bridge_rows(const ibl_input *in,
                                  const ibl_image_kind *kind,
                                  const ibl_read_options *opts,
                                  ibl_rows **rows);
ibl_status __wrap_ibl_bridge_rows(const ibl_input *in,
                                  const ibl_image_kind *kind,
                                  const ibl_read_options *opts, ibl_rows **rows)
{
    ibl_image img = {0};

    FUZZ_NEED(in->bytes && in->size && kind->reader);
    const int orientation = in->bytes[in->size - 1] % 16;
    const bool lies = orientation > 4 && orientation <= 8;
    ibl_status status =
        ibl_map_check_size(in, opts, lies ? 8 : 16, lies ? 16 : 8);
    if (!status)
        status = ibl_map_alloc(in, 16, 8, &img);
    if (status)
        return status;
    for (int i = 0; i < 3 * 16 * 8; i++)
        img.data[i] = (float)(in->bytes[(size_t)i % in->size]) /
                      (opts->transfer == IBL_TRANSFER_LINEAR ? 255 : 1);
    status = ibl_rows_of_image(in->ctx, &img, NULL, rows);
    if (!status)
        (*rows)->orientation = orientation;
    return status;
}

static ibl_read_options choose(fuzz_input *in)
{
    ibl_read_options opts = ibl_read_options_default();

    opts.alpha = (ibl_alpha)fuzz_choice(in, IBL_ALPHA_STRAIGHT + 1);
    opts.primaries = (ibl_primaries)fuzz_choice(in, IBL_PRIMARIES_REC2020 + 1);
    opts.layout = (ibl_input_layout)fuzz_choice(in, IBL_INPUT_OCTAHEDRAL + 1);
    const int bits = fuzz_choice(in, 128);
    opts.strict = bits & 1;
    opts.any_aspect = !(bits & 2);
    opts.hash = bits >> 2 & 1;
    opts.env = bits & 8 ? NULL : ibl_env_decode;
    opts.exposure = bits & 16 ? 3.5 : 0;
    opts.clamp = bits & 32 ? 2 : 0;
    if (bits & 64)
        ibl_face_order_parse("nz/90,pz,ny/m180,py/270,nx/m,px",
                             opts.face_order);
    return opts;
}

/* A pipe with the bytes, which are fewer than its room; -1 else. */
static int fill_pipe(const fuzz_input *in)
{
    int ends[2];

    if (!in->size || in->size > 60000 || pipe(ends))
        return -1;
    FUZZ_NEED(write(ends[1], in->bytes, in->size) == (ssize_t)in->size);
    close(ends[1]);
    return ends[0];
}

/* Reads a path some rows at a time. */
static ibl_status read_rows(const char *path, const ibl_read_options *opts,
                            int rows, ibl_image *img)
{
    ibl_source *source;
    ibl_status status = ibl_source_open(fuzz_ctx, path, opts, &source);

    if (status)
        return status;
    const int width = ibl_source_width(source),
              height = ibl_source_height(source);
    status = ibl_image_alloc(fuzz_ctx, width, height, img);
    for (int y = 0; y < height && !status; y += rows) {
        const int count = rows < height - y ? rows : height - y;
        status = ibl_source_read(source, count,
                                 img->data + 3 * (size_t)y * (size_t)width);
    }
    const float *alpha = status ? NULL : ibl_source_alpha(source);
    for (int i = 0; alpha && i < width * height; i++)
        FUZZ_NEED(alpha[i] >= 0 && alpha[i] <= 1);
    ibl_source_close(source);
    return status;
}

/* Files from 64 KiB on stay open; a shorter one can get zeros behind it, which
 * is another file. */
static ibl_status read_again(const fuzz_input *in, const ibl_read_options *opts,
                             bool by_pipe, int rows, ibl_image *img)
{
    const int fd = by_pipe ? fill_pipe(in) : -1;
    char path[64];

    if (fd < 0)
        return read_rows(fuzz_save("map", in->bytes, in->size), opts, rows,
                         img);
    snprintf(path, sizeof path, "/dev/fd/%d", fd);
    const ibl_status status = read_rows(path, opts, rows, img);
    close(fd);
    return status;
}

static void check_image(const ibl_image *img, const ibl_read_report *report)
{
    const size_t values = 3 * (size_t)img->width * (size_t)img->height;

    FUZZ_NEED(img->width >= 1 && img->width <= IBL_MAX_EDGE);
    FUZZ_NEED(img->height >= 1 && img->height <= IBL_MAX_EDGE);
    for (size_t i = 0; i < values; i++)
        FUZZ_NEED(img->data[i] >= 0 && isfinite(img->data[i]));
    FUZZ_NEED(memchr(report->format, 0, sizeof report->format));
}

static void compare(ibl_status a, const ibl_image *one, ibl_status b,
                    const ibl_image *two)
{
    FUZZ_NEED(a == b);
    if (a)
        return;
    FUZZ_NEED(one->width == two->width && one->height == two->height);
    FUZZ_NEED(!memcmp(one->data, two->data,
                      3 * sizeof *one->data * (size_t)one->width *
                          (size_t)one->height));
}

/* The file with zeros behind it, so that it is long enough to stay open. */
static fuzz_input lengthen(const fuzz_input *in)
{
    static unsigned char bytes[1 << 17];

    memset(bytes, 0, sizeof bytes);
    memcpy(bytes, in->bytes, in->size);
    return (fuzz_input){bytes, (1 << 16) + 1};
}

/* The file as each of six faces. */
static void read_faces(const fuzz_input *in, const ibl_read_options *opts)
{
    const char *path = fuzz_save("map", in->bytes, in->size);
    ibl_read_report report = {.format = ""};
    ibl_image img = {0};
    char list[IBL_FACES * 512];

    snprintf(list, sizeof list, "%s,%s,%s,%s,%s,%s", path, path, path, path,
             path, path);
    const ibl_status status =
        ibl_image_read(fuzz_ctx, list, opts, &img, &report);
    fuzz_said(status);
    if (!status)
        check_image(&img, &report);
    ibl_image_free(&img);
}

void fuzz_one(fuzz_input in)
{
    const ibl_read_options opts = choose(&in);
    const int way = fuzz_choice(&in, 8), step = fuzz_choice(&in, 256);
    ibl_read_report report = {.format = ""};
    ibl_image one = {0}, two = {0};

    if (way == 1) {
        read_faces(&in, &opts);
        return;
    }
    if (way >= 6 && in.size <= 1 << 16)
        in = lengthen(&in);
    const ibl_status first = ibl_image_decode(fuzz_ctx, "map", in.bytes,
                                              in.size, &opts, &one, &report);
    fuzz_said(first);
    if (!first)
        check_image(&one, &report);
    if (way >= 2) {
        fuzz_longest_read = way % 2 ? (size_t)step * 16 + 1 : 0;
        const ibl_status again =
            read_again(&in, &opts, way >= 4 && way < 6, step / 8 + 1, &two);
        fuzz_longest_read = 0;
        fuzz_said(again);
        compare(first, &one, again, &two);
    }
    ibl_image_free(&one);
    ibl_image_free(&two);
}
