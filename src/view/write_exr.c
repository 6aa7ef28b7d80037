/* SPDX-License-Identifier: MIT */
#include "view/picture.h"

#include <OpenEXR/openexr.h>
#include <stdlib.h>
#include <string.h>

#include "view/message.h"

/* In the alphabetical order of files, which is not that of a pixel. */
static const char *const names[] = {"B", "G", "R"};

enum {
    CHANNELS = 3,
    PIXEL = CHANNELS * sizeof(float)
};

/* The file in zeroed memory of `room` bytes. */
typedef struct stream {
    unsigned char *bytes;
    size_t size, room;
} stream;

static int64_t write_fn(exr_const_context_t exr, void *user, const void *from,
                        uint64_t size, uint64_t offset,
                        exr_stream_error_func_ptr_t error)
{
    const size_t end = (size_t)(offset + size);
    stream *s = user;

    (void)exr;
    (void)error;
    if (end > s->room)
        return -1;
    memcpy(s->bytes + offset, from, (size_t)size);
    if (end > s->size)
        s->size = end;
    return (int64_t)size;
}

/* Without a handler OpenEXR prints errors, which are returned as well. */
static void ignore_error(exr_const_context_t exr, exr_result_t code,
                         const char *text)
{
    (void)exr;
    (void)code;
    (void)text;
}

/* Writes a block of lines with its own pipeline. */
static exr_result_t write_block(exr_context_t exr, const float *rgb, int width,
                                int y)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    exr_result_t rv = exr_write_scanline_chunk_info(exr, 0, y, &chunk);

    if (rv)
        return rv;
    rv = exr_encoding_initialize(exr, 0, &chunk, &pipe);
    if (rv)
        return rv;
    for (int i = 0; i < CHANNELS; i++) {
        exr_coding_channel_info_t *c = &pipe.channels[i];
        c->encode_from_ptr =
            (const uint8_t *)(rgb + (size_t)y * (size_t)width * CHANNELS +
                              CHANNELS - 1 - i);
        c->user_bytes_per_element = sizeof *rgb;
        c->user_data_type = EXR_PIXEL_FLOAT;
        c->user_pixel_stride = PIXEL;
        c->user_line_stride = PIXEL * width;
    }
    rv = exr_encoding_choose_default_routines(exr, 0, &pipe);
    if (!rv)
        rv = exr_encoding_run(exr, 0, &pipe);
    exr_encoding_destroy(exr, &pipe);
    return rv;
}

static exr_result_t write_picture(exr_context_t exr, const float *rgb,
                                  int width, int height)
{
    int part;
    int32_t lines = 0;
    exr_result_t rv = exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &part);

    if (!rv)
        rv = exr_initialize_required_attr_simple(exr, part, width, height,
                                                 EXR_COMPRESSION_ZIP);
    for (int i = 0; i < CHANNELS && !rv; i++)
        rv = exr_add_channel(exr, part, names[i], EXR_PIXEL_FLOAT,
                             EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    if (!rv)
        rv = exr_write_header(exr);
    if (!rv)
        rv = exr_get_scanlines_per_chunk(exr, part, &lines);
    for (int y = 0; y < height && !rv; y += lines)
        rv = write_block(exr, rgb, width, y);
    return rv;
}

bool view_exr_encode(const char *name, int width, int height, const float *rgb,
                     void **bytes, size_t *size)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t exr = NULL;
    /* Headers and the table of blocks take less; ZIP never enlarges a block. */
    stream s = {.room = 4096 + (size_t)height * (16 + (size_t)width * PIXEL)};

    *bytes = NULL;
    s.bytes = calloc(1, s.room);
    init.error_handler_fn = ignore_error;
    init.user_data = &s;
    init.write_fn = write_fn;
    exr_result_t rv =
        s.bytes ? exr_start_write(&exr, name, EXR_WRITE_FILE_DIRECTLY, &init)
                : EXR_ERR_OUT_OF_MEMORY;
    if (!rv)
        rv = write_picture(exr, rgb, width, height);
    /* Writes the table of blocks. */
    const exr_result_t end = exr_finish(&exr);
    if (!rv)
        rv = end;
    if (!rv) {
        *bytes = s.bytes;
        *size = s.size;
        return true;
    }
    free(s.bytes);
    return view_fail("%s: no EXR of %d x %d pixels is made of it: %s", name,
                     width, height, exr_get_default_error_message(rv));
}
